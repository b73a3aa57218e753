"""Bodies: closed, consistently wound surfaces among the faces, and what lies on their free side.

Whoever looks from the free side of a body, where its normals point, meets it from the front first;
faces that show him their backs are hidden by others and need not be looked at.
"""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.faces import Faces
from radiosity.mesh.seams import find_seams

LARGEST = 10**7  # coordinates times planes that are looked at for one body


@dataclass(frozen=True)
class Bodies:
    """Closed surfaces.

    Attributes
    ----------
    of_face : (f,) int
        Body of each face; ``count`` for faces of open or unevenly wound surfaces.
    count : int
    """

    of_face: np.ndarray
    count: int


def find_bodies(faces: Faces) -> Bodies:
    """Return the closed surfaces: every edge joins two faces that run along it in opposite ways."""
    seams = find_seams(faces)
    label = seams.components()
    broken = np.unique(label[seams.face[((seams.uses != 2) | (seams.turn != 0))[seams.edge]]])
    kept = np.setdiff1d(np.unique(label), broken)
    number = np.full(label.max(initial=-1) + 1, len(kept))
    number[kept] = np.arange(len(kept))
    return Bodies(number[label], len(kept))


def free_of(
    corners: np.ndarray, plane: np.ndarray, normal: np.ndarray, points: np.ndarray, slack: float
) -> np.ndarray:
    """Return (n,) bool: polygons that surely lie on the free side of one body.

    A convex body is judged by its planes; of another one that looks outward, what lies beside the
    box about it is free.

    Parameters
    ----------
    corners : (k, c, 3)
        Corners of the body's polygons; ``plane`` (k, 3) a point and ``normal`` (k, 3) of each.
    points : (n, 4, 3)
        Corners of the polygons in question.
    slack : float
        Distance that counts as touching.
    """
    free = np.zeros(len(points), bool)
    vertices = np.unique(corners.reshape(-1, 3), axis=0)
    if len(plane) * max(points.size, vertices.size) > LARGEST:
        return free
    level = np.einsum("kc,kc->k", plane, normal)
    own = vertices @ normal.T - level
    if own.max() <= slack or own.min() >= -slack:
        height = (points.reshape(-1, 3) @ normal.T - level).reshape(len(points), 4, len(plane))
        front = height.min(axis=1) >= -slack
        return front.any(axis=1) if own.max() <= slack else front.all(axis=1)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    beside = np.any((points.min(axis=1) >= high - slack) | (points.max(axis=1) <= low + slack), 1)
    return beside & (_volume(corners) > 0)


def _volume(corners) -> float:
    """Return the volume inside polygons (k, c, 3) that look outward; negative where inward."""
    middle = corners.mean(axis=(0, 1))
    r = corners - middle
    fans = np.cross(r[:, 1:-1], r[:, 2:]).sum(axis=1)
    return float(np.einsum("kc,kc->", r[:, 0], fans)) / 6.0
