"""Winding: closed bodies whose faces do not all look out or all look in, and what turns them."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from radiosity.mesh.faces import Faces
from radiosity.mesh.seams import CLOSED, Seams


@dataclass(frozen=True)
class Shells:
    """The pieces of a mesh that hang together by edges.

    Attributes
    ----------
    of_face : (f,) int
        The piece of each face.
    closed : (s,) bool
        Without open or branched edges.
    orientable : (s,) bool
        Whether its faces can be turned so that neighbours agree.
    odd : (f,) bool
        Faces that lie the other way round than the larger part, by area, of their piece.
    share : (s,) float
        That larger part's share of the area; 1 where all agree.
    volume : (s,) float
        Enclosed, once odd faces are turned: above 0 where the fronts look out. 0 for open ones.
    """

    of_face: np.ndarray
    closed: np.ndarray
    orientable: np.ndarray
    odd: np.ndarray
    share: np.ndarray
    volume: np.ndarray

    def boxes(self, faces: Faces) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest and highest coordinates (s, 3) of the pieces."""
        order = np.argsort(self.of_face, kind="stable")
        first = np.searchsorted(self.of_face[order], np.arange(len(self.closed)))
        low, high = faces.vertices.min(axis=1)[order], faces.vertices.max(axis=1)[order]
        return np.minimum.reduceat(low, first), np.maximum.reduceat(high, first)


def find_shells(faces: Faces, seams: Seams) -> Shells:
    """Return the pieces of a mesh and which of their faces are wound against the others.

    Every face stands for two, as it is and turned round; of neighbours those that agree are
    joined. A piece is then two, one for each way round, or a single one if neither is consistent.
    """
    n, label = len(faces), seams.components()
    count = label.max(initial=-1) + 1
    pair, alike = seams.pairs()
    one, two = pair.T
    rows, columns = np.concatenate([one, one + n]), np.concatenate([two, two + n])
    columns = np.where(np.tile(alike, 2), (columns + n) % (2 * n), columns)
    graph = coo_array((np.ones(len(rows), bool), (rows, columns)), shape=(2 * n, 2 * n))
    side = connected_components(graph, directed=False)[1]
    orientable = np.ones(count, bool)
    orientable[label[side[:n] == side[n:]]] = False
    odd, share = _odd(faces.areas(), side[:n], side[n:], label, count)
    kinds = seams.kinds()[seams.edge]
    closed = np.ones(count, bool)
    closed[label[seams.face[kinds != CLOSED]]] = False
    volume = np.where(closed & orientable, _volumes(faces, label, odd, count), 0.0)
    return Shells(label, closed, orientable, odd, share, volume)


def _odd(area, side, other, label, count):
    """Return which faces are of the smaller way round in their piece, and the larger's share.

    Patches of a piece that only branched edges join are judged by themselves.
    """
    total = np.bincount(side, area, minlength=max(side.max(initial=-1), other.max(initial=-1)) + 1)
    mine, theirs = total[side], total[other]
    odd = (mine < theirs) | ((mine == theirs) & (side > other))
    wrong = np.bincount(label, np.where(odd, area, 0.0), minlength=count)
    return odd, 1.0 - wrong / np.maximum(np.bincount(label, area, minlength=count), 1e-300)


def _volumes(faces, label, odd, count):
    """Return (s,) the volumes under the faces, seen from a point of their piece, added up."""
    v = faces.vertices
    origin = np.zeros((count, 3))
    origin[label] = v[:, 0]  # near by, so that large coordinates do not cancel
    r = v - origin[label][:, None]
    fans = np.cross(r[:, 1], r[:, 2]) + np.cross(r[:, 2], r[:, 3])
    part = np.einsum("fc,fc->f", r[:, 0], fans) / 6.0
    return np.bincount(label, np.where(odd, -part, part), minlength=count)


def inside_out(faces: Faces, shells: Shells) -> np.ndarray:
    """Return (s,) bool: pieces that look inward, have nothing in them and are not all there is.

    A room has something in it, or is all there is; a lamp or a block turned inside out is neither.
    """
    found = shells.volume < 0
    if not found.any() or len(found) == 1:
        return np.zeros(len(found), bool)
    low, high = shells.boxes(faces)
    middle = (low + high) / 2.0
    for s in np.flatnonzero(found):
        inside = np.all((middle >= low[s]) & (middle <= high[s]), axis=1)
        smaller = np.any((low > low[s]) | (high < high[s]), axis=1)
        found[s] = not np.any(inside & smaller)
    return found


def turned(faces: Faces, which: np.ndarray) -> Faces:
    """Return the faces with those of ``which`` (f,) bool turned round; first corners stay."""
    found = faces.reversed(which)
    if found.corner_normals is None:
        return found
    normals = np.where(which[:, None, None], -found.corner_normals, found.corner_normals)
    return replace(found, corner_normals=normals)
