"""Visibility: rays against the faces of the scene. The only module that knows embreex."""

from functools import cached_property

import numpy as np

from radiosity.mesh.bodies import find_bodies, free_of
from radiosity.mesh.contact import TOUCH
from radiosity.mesh.faces import Faces
from radiosity.mesh.facets import Facets, merge_facets
from radiosity.mesh.patches import Patches
from radiosity.transport.blockers import make_blockers, on_the_hull

LIFT = 1e-5  # ray origins and ends are lifted off their surface by this share of the half extent


class Visibility:
    """Occlusion and first hits among the faces, in single precision, centred and scaled.

    Rays live in coordinates (x - centre) * scale, in which the scene fits into [-1, 1].

    Parameters
    ----------
    faces : Faces
        Every triangle of every face blocks from both sides.
    facets : Facets, optional
        Those of the faces, where they are known.
    every : bool
        Take every face for one that can block, also those that nothing lies behind.

    Attributes
    ----------
    centre : (3,) float64
    scale : float
        A power of 2, so that scaling rounds nothing.
    grain : (f,) float64
        How far rounding, here or in the file, may have moved the vertices of a face, in ray
        coordinates; where a face is less even than most, how far they lie off its plane.
    touch : float
        Distance that counts as contact, in ray coordinates.
    face_normal : (f, 3) float32
    blockers : Blockers
        What can come between two points, as convex polygons in ray coordinates.
    facets : Blockers
        These and those that nothing lies behind.
    """

    def __init__(self, faces: Faces, facets: Facets | None = None, every: bool = False):
        v = faces.vertices
        low, high = v.reshape(-1, 3).min(axis=0), v.reshape(-1, 3).max(axis=0)
        self.centre = (low + high) / 2
        self.scale = 2.0 ** np.floor(1.0 - np.log2((high - low).max()))
        self.touch = TOUCH * np.linalg.norm(high - low) * self.scale
        self.face_normal = faces.normals().astype(np.float32)
        facets = merge_facets(faces) if facets is None else facets
        offset = np.abs([low, high]).max() * self.scale
        bent = facets.unevenness(faces) * self.scale
        rounding = max(4.0 * np.finfo(float).eps * (1.0 + offset), 4.0 * np.median(bent))
        grain = np.maximum(rounding, 2.0 * bent)
        self.grain = grain[facets.facet]
        self._corners = (facets.vertices - self.centre) * self.scale
        self._normal, bodies = facets.normal, find_bodies(faces)
        self._bodies, self._of_face = bodies.count, bodies.of_face
        self._of_facet = np.empty(len(facets.count), int)
        self._of_facet[facets.facet] = bodies.of_face
        made = self._corners, facets.count, facets.normal, self._of_facet, grain
        self.facets = make_blockers(*made, hull=True)
        self.blockers = self.facets if every else make_blockers(*made)
        triangles, self._face = _triangles(faces)
        self._triangles = ((triangles - self.centre) * self.scale).astype(np.float32)
        self._scene = _scene_of(self._triangles)

    @property
    def can_block(self) -> bool:
        """Whether any face can come between two points of the scene."""
        return len(self.blockers.count) > 0

    @cached_property
    def _shell(self):
        """Return the planes (h, 3), (h,) of the outermost facets; normals point to the scene."""
        f = self.facets
        outer = on_the_hull(f.corners, f.normal, 8.0 * f.grain)
        normal, corners = f.normal[outer], f.corners[outer]
        level = np.einsum("hc,hc->h", normal, corners[:, 0])
        every = f.corners.reshape(-1, 3)
        side = np.sign(normal @ every.sum(axis=0) - len(every) * level)
        return normal * side[:, None], level * side

    def outside(self, points: np.ndarray) -> np.ndarray:
        """Return (k,) bool: points, in ray coordinates, that outermost facets may hide others from.

        Those lie behind one of them, by more than they may be off a surface that they are meant to
        lie on.
        """
        normal, level = self._shell
        return np.any(points @ normal.T < level - LIFT, axis=1)

    def free_sides(self, patches: Patches) -> np.ndarray:
        """Return (n, bodies + 1) bool: on which bodies' free side a patch surely lies.

        The last column is False, for what belongs to no body.
        """
        points = (patches.vertices - self.centre) * self.scale
        free = np.zeros((len(patches), self._bodies + 1), bool)
        for b in range(self._bodies):
            corners, normal = self._corners[self._of_facet == b], self._normal[self._of_facet == b]
            slack = 4.0 * self.grain[self._of_face == b].max()
            free[:, b] = free_of(corners, corners[:, 0], normal, points, slack)
            own = self._of_face[patches.face] == b
            free[own, b] &= patches.front[own]
        return free

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
        return _first_hits(self._scene, self._face, origins, directions)

    def first_hits_of(self, wanted: np.ndarray):
        """Return what `first_hits` would be if there were only the ``wanted`` (f,) bool faces."""
        some = wanted[self._face]
        scene, face = _scene_of(self._triangles[some]), self._face[some]
        return lambda origins, directions: _first_hits(scene, face, origins, directions)


class Unobstructed(Visibility):
    """The same faces, met by rays, with nothing in the way of light: without shadows."""

    def __init__(self, visibility: Visibility):
        """Take over what is known of the faces."""
        self.__dict__.update(visibility.__dict__)

    def blocked(self, origins: np.ndarray, spans: np.ndarray) -> np.ndarray:
        """Return (k,) bool, all False; see `Visibility.blocked`."""
        _check(origins, spans)
        return np.zeros(len(origins), bool)


def _scene_of(triangles):
    """Return Embree's scene of triangles (t, 3, 3) float32."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scene = EmbreeScene(robust=True)
    index = np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    TriangleMesh(scene, triangles.reshape(-1, 3), index)
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32), query="OCCLUDED")
    return scene  # committed by its first ray


def _first_hits(scene, faces, origins, directions):
    _check(origins, directions)
    hit = scene.run(origins, directions, output=1)
    triangle = hit["primID"]
    return np.where(triangle >= 0, faces[triangle], -1).astype(np.int32), hit["tfar"]


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
