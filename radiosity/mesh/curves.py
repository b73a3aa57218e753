"""Faces that stand for a curved surface: normals at their corners, made or as files give them."""

from dataclasses import replace

import numpy as np

from radiosity.mesh.corners import unit
from radiosity.mesh.faces import Faces, ranges, welded
from radiosity.mesh.seams import find_seams
from radiosity.mesh.winding import find_shells, turned

FLAT = 1e-6  # of the length of normals, by which they may miss a flat face's own


def smooth_normals(faces: Faces, degrees: float) -> np.ndarray:
    """Return normals (f, 4, 3) at corners on the fronts, as means over the faces that meet there.

    Faces count whose normals differ by no more than ``degrees`` from the corner's own face's, with
    their angles at the corner as weights (Thuermer & Wuethrich 1998). Which way round the faces
    are wound does not matter: neighbours are taken as if they agreed.
    """
    odd = find_shells(faces, find_seams(faces)).odd
    if not odd.any():
        return _means(faces, degrees)
    even = turned(faces, odd)
    even = replace(even, corner_normals=_means(even, degrees))
    return turned(even, odd).corner_normals


def _means(faces, degrees):
    """Return what `smooth_normals` does, of faces that agree."""
    own, angle = faces.normals(), _angles(faces.vertices)
    corner = np.flatnonzero(angle.ravel() > 0.0)
    vertex = welded(faces.vertices.reshape(-1, 3))[corner]
    corner = corner[np.argsort(vertex, kind="stable")]
    _, first, count = np.unique(np.sort(vertex), return_index=True, return_counts=True)
    other, here = ranges(np.repeat(first, count), np.repeat(count, count))
    face, there = corner[here] // 4, corner[other] // 4
    near = np.einsum("kc,kc->k", own[face], own[there]) >= np.cos(np.radians(degrees)) - 1e-9
    total = np.zeros((4 * len(faces), 3))
    weight = angle.ravel()[corner[other[near]]]
    np.add.at(total, corner[here[near]], weight[:, None] * own[there[near]])
    total = total.reshape(-1, 4, 3)
    triangle = faces.is_triangle
    total[triangle, 3] = total[triangle, 2]
    return np.where((angle > 0)[..., None] | triangle[:, None, None], unit(total), own[:, None])


def _angles(v):
    """Return (f, 4) angles at the corners; 0 at the repeated one of a triangle."""
    ahead, behind = np.roll(v, -1, axis=1) - v, np.roll(v, 1, axis=1) - v
    triangle = np.all(v[:, 3] == v[:, 2], axis=1)
    ahead[triangle, 2] = v[triangle, 0] - v[triangle, 2]
    sine = np.linalg.norm(np.cross(ahead, behind), axis=2)
    angle = np.arctan2(sine, np.einsum("fvc,fvc->fv", ahead, behind))
    angle[triangle, 3] = 0.0
    return angle


def curved(faces: Faces) -> np.ndarray | None:
    """Return the corner normals (f, 4, 3) turned to the fronts; None where all faces are flat."""
    given, own = faces.corner_normals, faces.normals()[:, None]
    if given is None:
        return None
    length = np.linalg.norm(given, axis=2, keepdims=True)
    normals = np.where((length > 0).all(axis=1, keepdims=True), given, np.nan) / length
    behind = np.einsum("fvc,fvc->fv", normals, np.broadcast_to(own, normals.shape)).sum(axis=1) < 0
    normals = np.where(behind[:, None, None], -normals, normals)
    bent = np.abs(normals - own).max(axis=(1, 2), initial=0.0) > FLAT
    return np.where(bent[:, None, None], normals, np.nan) if bent.any() else None
