"""Crossing: faces that cut through each other, each on both sides of the other one."""

import numpy as np

from radiosity.mesh.boxes import near_boxes
from radiosity.mesh.contact import TOUCH
from radiosity.mesh.faces import Faces


def crossing_faces(faces: Faces) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs (p, 2) of faces that cut through each other, and a point of each (p, 3).

    Two convex polygons do where both have corners on either side of the other's plane, and the
    pieces of the line between the planes that they cover overlap (T. Moeller, A fast
    triangle-triangle intersection test, 1997). Faces that only touch do not.
    """
    v, normals = faces.vertices, faces.normals()
    touch = TOUCH * np.linalg.norm(np.ptp(v, axis=(0, 1))) if len(v) else 0.0
    pairs, points = [np.empty((0, 2), int)], [np.empty((0, 3))]
    for f, g in near_boxes(v.min(axis=1), v.max(axis=1), 0.0):
        f, g = f[f < g], g[f < g]
        for one, two in ((0, 1), (1, 0)):  # who lies on one side is done with
            pair = np.stack([f, g])
            height = _heights(v[pair[one]], v[pair[two], 0], normals[pair[two]])
            keep = (height.min(axis=1) < -touch) & (height.max(axis=1) > touch)
            f, g = f[keep], g[keep]
        along = np.cross(normals[f], normals[g])
        length = np.linalg.norm(along, axis=1)
        f, g, along = f[length > 1e-9], g[length > 1e-9], along[length > 1e-9]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        origin = v[f, 0]
        low, high, _ = _span(v[f] - origin[:, None], v[g, 0] - origin, normals[g], along)
        other, upto, place = _span(v[g] - origin[:, None], np.zeros_like(origin), normals[f], along)
        start, end = np.maximum(low, other), np.minimum(high, upto)
        cut = end - start > touch
        pairs.append(np.stack([f, g], axis=1)[cut])
        shift = (start + end) / 2 - np.einsum("pc,pc->p", place, along)
        points.append((origin + place + shift[:, None] * along)[cut])
    pairs, points = np.concatenate(pairs), np.concatenate(points)
    order = np.lexsort(pairs.T[::-1])
    return pairs[order], points[order]


def _heights(v, origin, normal):
    return np.einsum("pkc,pc->pk", v - origin[:, None], normal)


def _span(v, origin, normal, along):
    """Return from where to where polygons (p, 4, 3) meet planes, along a line, and a point there.

    They cross the planes, so two of their sides do.
    """
    height = _heights(v, origin, normal)
    after = np.roll(height, -1, axis=1)
    across = (height > 0) != (after > 0)
    share = np.divide(height, height - after, out=np.zeros_like(height), where=across)
    point = v + share[..., None] * (np.roll(v, -1, axis=1) - v)
    place = np.einsum("pkc,pc->pk", point, along)
    low = np.where(across, place, np.inf).min(axis=1)
    high = np.where(across, place, -np.inf).max(axis=1)
    first = np.take_along_axis(point, across.argmax(axis=1)[:, None, None], axis=1)[:, 0]
    return low, high, first
