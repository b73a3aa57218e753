"""Seams: which edges of a mesh several faces share, and how they run along them."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from radiosity.mesh.faces import Faces, welded

OPEN, CLOSED, BRANCHED = 0, 1, 2  # an edge of one face, of two, of more that are no pairs


@dataclass(frozen=True)
class Seams:
    """The edges between welded corners.

    Attributes
    ----------
    corner : (f, 4) int
        Numbers that are equal where corners coincide.
    face, start, end, edge : (h,) int
        Of each side of a face: the face, the numbers of its two corners, the edge it runs along.
    uses, turn : (e,) int
        How many sides run along each edge, and those that run up less those that run down.
    """

    corner: np.ndarray
    face: np.ndarray
    start: np.ndarray
    end: np.ndarray
    edge: np.ndarray
    uses: np.ndarray
    turn: np.ndarray

    def components(self) -> np.ndarray:
        """Return (f,) numbers of the pieces that hang together by edges."""
        count, first = len(self.corner), np.zeros(len(self.uses), int)
        first[self.edge[::-1]] = self.face[::-1]
        joined = coo_array((np.ones(len(self.face)), (self.face, first[self.edge])), (count,) * 2)
        return connected_components(joined, directed=False)[1]

    def kinds(self) -> np.ndarray:
        """Return (e,) OPEN, CLOSED or BRANCHED; bodies that touch along an edge close it."""
        branched = (self.uses > 2) & (self.turn != 0)
        return np.where(branched, BRANCHED, np.where(self.uses == 1, OPEN, CLOSED))

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the faces (p, 2) that alone share an edge, and (p,) if they run along it alike."""
        two = np.flatnonzero(self.uses[self.edge] == 2)
        two = two[np.argsort(self.edge[two], kind="stable")].reshape(-1, 2)
        return self.face[two], self.turn[self.edge[two[:, 0]]] != 0


def find_seams(faces: Faces) -> Seams:
    """Return the edges of a mesh; corners that coincide are one, see `welded`."""
    corner = welded(faces.vertices.reshape(-1, 3)).reshape(-1, 4)
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    face = np.repeat(np.arange(len(faces)), 4)
    real = start != end
    start, end, face = start[real], end[real], face[real]
    size = corner.max(initial=0) + 1
    key = np.minimum(start, end) * size + np.maximum(start, end)
    which = np.unique(key, return_inverse=True)[1].ravel()
    uses = np.bincount(which)
    turn = np.bincount(which, weights=np.where(start < end, 1, -1)).astype(int)
    return Seams(corner, face, start, end, which, uses, turn)
