"""Visibility: rays against the faces of the scene. The only module that knows embreex."""

import numpy as np

from radiosity.mesh.faces import Faces

LIFT = 1e-5  # ray origins and ends are lifted off their surface by this share of the half extent


class Visibility:
    """Occlusion and first hits among the faces, in single precision, centred and scaled.

    Rays live in coordinates (x - centre) * scale, in which the scene fits into [-1, 1].

    Parameters
    ----------
    faces : Faces
        Every triangle of every face blocks from both sides.

    Attributes
    ----------
    centre : (3,) float64
    scale : float
    convex : bool
        The faces look into one convex enclosure, so nothing can come between two of their fronts.
    """

    def __init__(self, faces: Faces):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        v = faces.vertices
        low, high = v.reshape(-1, 3).min(axis=0), v.reshape(-1, 3).max(axis=0)
        self.centre = (low + high) / 2
        self.scale = 2.0 / (high - low).max()
        self.convex = _is_convex(faces)
        triangles, self._face = _triangles(faces)
        local = ((triangles - self.centre) * self.scale).astype(np.float32)
        self._scene = EmbreeScene(robust=True)
        index = np.arange(3 * len(local), dtype=np.int32).reshape(-1, 3)
        TriangleMesh(self._scene, local.reshape(-1, 3), index)
        self.blocked(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # commits

    def blocked(self, origins: np.ndarray, spans: np.ndarray) -> np.ndarray:
        """Return (k,) bool: whether anything lies between an origin and origin + span.

        Parameters
        ----------
        origins, spans : (k, 3) float32
            In ray coordinates.
        """
        _check(origins, spans)
        limit = np.ones(len(origins), np.float32)
        return self._scene.run(origins, spans, dists=limit, query="OCCLUDED") == 0

    def first_hits(self, origins: np.ndarray, directions: np.ndarray):
        """Return the face that each ray meets first (k,), -1 where none, and the distance (k,)."""
        _check(origins, directions)
        hit = self._scene.run(origins, directions, output=1)
        triangle = hit["primID"]
        return np.where(triangle >= 0, self._face[triangle], -1).astype(np.int32), hit["tfar"]


def _check(origins, spans):
    if origins.dtype != np.float32 or spans.dtype != np.float32 or origins.shape != spans.shape:
        raise ValueError(
            f"rays must be float32 arrays of one shape (k, 3), not {origins.dtype} "
            f"{origins.shape} and {spans.dtype} {spans.shape}"
        )


def _triangles(faces: Faces):
    """Return (t, 3, 3) triangles and the face of each: one a triangle, two a quadrilateral."""
    v = faces.vertices
    quad = np.flatnonzero(~faces.is_triangle)
    triangles = np.concatenate([v[:, :3], v[quad][:, [0, 2, 3]]])
    return triangles, np.concatenate([np.arange(len(v)), quad])


def _is_convex(faces: Faces) -> bool:
    """Whether every vertex lies in front of every face, to rounding."""
    points = np.unique(faces.vertices.reshape(-1, 3), axis=0)
    middle = points.mean(axis=0)
    points -= middle
    tolerance = 1e-9 * np.abs(points).max()
    normals = faces.normals()
    level = np.einsum("fc,fc->f", faces.vertices[:, 0] - middle, normals) - tolerance
    for start in range(0, len(faces), 256):
        block = slice(start, start + 256)
        if np.any(points @ normals[block].T < level[block]):
            return False
    return True
