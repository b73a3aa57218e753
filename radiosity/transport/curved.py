"""Normals between the corners of faces that stand for a curve."""

import numpy as np

from radiosity.mesh.corners import normal_between, weights
from radiosity.mesh.faces import Faces
from radiosity.transport.lookup import Table, coordinates_at


def smooth_normals(
    faces: Faces, table: Table, own: np.ndarray, face: np.ndarray, points: np.ndarray
) -> np.ndarray:
    """Return unit normals (k, 3) at points of faces (k,); ``own`` (k, 3) are the faces' own."""
    found = own.copy()
    k = np.flatnonzero(faces.is_curved[face])
    if len(k):
        st = coordinates_at(table, face[k], np.ascontiguousarray(points[k], dtype=np.float64))
        weight = weights(st, faces.is_triangle[face[k]])
        found[k] = normal_between(faces.corner_normals[face[k]], weight, own[k])
    return found
