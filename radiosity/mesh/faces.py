"""Faces: the planar triangles and convex quadrilaterals a scene is made of."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from radiosity.mesh.duplicates import repeated

PLANAR = 1e-6  # deviation from a plane, as a share of a polygon's size, below which it is flat
WELD = 1e-7  # distance, as a share of the mesh's size, below which two vertices are one
SHARED = 8  # faces looked at round one edge; bounds the work where thousands share it
BLUNTEST = np.cos(np.radians(30))  # pairs with a corner below 30 or above 150 degrees stay apart


@dataclass(frozen=True)
class Faces:
    """Planar faces in scene units, counter-clockwise seen from the front.

    Attributes
    ----------
    vertices : (f, 4, 3) float64
        A triangle repeats its last vertex.
    material : (f,) int
        Index into ``Scene.materials``.
    group : (f,) int
        Index into ``Scene.groups`` (an OBJ group, or one per ``[[geometry]]`` block).
    degenerate : int
        How many faces without area were dropped on the way here.
    uv : (f, 4, 2) float64, optional
        Texture coordinates of the corners, nan on faces that have none.
    corner_normals : (f, 4, 3) float64, optional
        Unit normals of the curved surface that the faces stand for, on their front side, nan on
        faces that are meant to be flat.
    duplicates : int
        How many faces that were there before in all their corners were dropped on the way here.
    """

    vertices: np.ndarray
    material: np.ndarray
    group: np.ndarray
    degenerate: int = 0
    uv: np.ndarray | None = None
    corner_normals: np.ndarray | None = None
    duplicates: int = 0

    @classmethod
    def from_triangles(cls, triangles, material, group, merge: bool = True) -> "Faces":
        """Return the faces of triangles (t, 3, 3); see `from_polygons`."""
        triangles = np.asarray(triangles, float).reshape(-1, 3, 3)
        return cls.from_polygons(triangles[:, [0, 1, 2, 2]], material, group, merge)

    @classmethod
    def from_polygons(
        cls, vertices, material, group, merge: bool = True, uv=None, corner_normals=None
    ) -> "Faces":
        """Return the faces of planar convex polygons, without those that have no area.

        Parameters
        ----------
        vertices : (f, 4, 3) float
            A triangle repeats its last vertex. Equal vertices need not be shared.
        material, group : (f,) or scalar int
        merge : bool
            Join pairs of triangles of one plane, material, group and orientation that share an
            edge into convex quadrilaterals: the pair whose corners are nearest to 90 degrees
            first, then the one read first. A pair keeps the place and the first vertex of its
            first triangle. Pairs stay apart where `radiosity.mesh.corners.joinable` says so.
            Before, faces that repeat one of their material and group are dropped (`repeated`).
        uv, corner_normals : (f, 4, 2), (f, 4, 3) float, optional
        """
        v = np.asarray(vertices, float).reshape(-1, 4, 3)
        bad = np.flatnonzero(~np.isfinite(v).all(axis=(1, 2)))
        if len(bad):
            raise ValueError(f"face {bad[0]} has the vertices {v[bad[0]].tolist()}: they must be "
                             "finite")  # fmt: skip
        material, group = (np.broadcast_to(np.asarray(x, int), len(v)) for x in (material, group))
        keep = has_area(v)
        degenerate, duplicates = int(np.count_nonzero(~keep)), 0
        if merge:
            surface = material * (group.max(initial=0) + 1) + group
            keep[keep] = single = ~repeated(v[keep], surface[keep])
            duplicates = int(np.count_nonzero(~single))
        v, material, group = v[keep].copy(), material[keep].copy(), group[keep].copy()
        more = [None if x is None else np.asarray(x, float)[keep] for x in (uv, corner_normals)]
        if merge:
            first, second, joined = _merged(v, material, group, *more)
            made = []
            for corners, quads in zip((v, *more), joined, strict=True):
                if corners is not None:
                    corners[first] = quads
                    corners = np.delete(corners, second, axis=0)
                made.append(corners)
            v, *more = made
            material, group = (np.delete(x, second, axis=0) for x in (material, group))
        return cls(v, material, group, degenerate, *more, duplicates)

    @classmethod
    def concatenate(cls, parts: "list[Faces]") -> "Faces":
        """Return the faces of all parts, in order; their material and group indices as they are."""
        if not parts:
            return cls(np.empty((0, 4, 3)), np.empty(0, int), np.empty(0, int))
        return cls(
            np.concatenate([p.vertices for p in parts]),
            np.concatenate([p.material for p in parts]),
            np.concatenate([p.group for p in parts]),
            sum(p.degenerate for p in parts),
            _concatenated([p.uv for p in parts], parts),
            _concatenated([p.corner_normals for p in parts], parts),
            sum(p.duplicates for p in parts),
        )

    def without_duplicates(self) -> "Faces":
        """Return the faces without those that repeat one of their material, of any group."""
        keep = ~repeated(self.vertices, self.material)
        if keep.all():
            return self
        uv, normals = (None if x is None else x[keep] for x in (self.uv, self.corner_normals))
        left = self.vertices[keep], self.material[keep], self.group[keep]
        dropped = self.duplicates + int(np.count_nonzero(~keep))
        return Faces(*left, self.degenerate, uv, normals, dropped)

    def reversed(self, which: np.ndarray) -> "Faces":
        """Return the faces with those of ``which`` (f,) bool wound the other way round.

        First corners stay first; texture coordinates and normals stay at their corners, as they
        are.
        """
        order = np.where(which[:, None], turning(self.vertices), np.arange(4))[..., None]
        v, uv, normals = (
            None if x is None else np.take_along_axis(x, order, axis=1)
            for x in (self.vertices, self.uv, self.corner_normals)
        )
        return replace(self, vertices=v, uv=uv, corner_normals=normals)

    def __len__(self) -> int:
        """Return the number of faces."""
        return len(self.vertices)

    @property
    def is_triangle(self) -> np.ndarray:
        """Return (f,) bool: which faces repeat their last vertex."""
        return np.all(self.vertices[:, 3] == self.vertices[:, 2], axis=1)

    @cached_property
    def is_curved(self) -> np.ndarray:
        """Return (f,) bool: which faces stand for a curved surface, whose normals they have."""
        if self.corner_normals is None:
            return np.zeros(len(self), bool)
        return np.isfinite(self.corner_normals).all(axis=(1, 2))

    def normals(self) -> np.ndarray:
        """Return (f, 3) unit normals on the front side."""
        v = self.vertices
        cross = np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1])
        return cross / np.linalg.norm(cross, axis=1, keepdims=True)

    def areas(self) -> np.ndarray:
        """Return (f,) areas in squared scene units."""
        v = self.vertices
        return 0.5 * np.linalg.norm(np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1]), axis=1)


def turning(v: np.ndarray) -> np.ndarray:
    """Return (f, 4) the corners of polygons (f, 4, 3) the other way round, the first one first."""
    triangle = np.all(v[:, 3] == v[:, 2], axis=1)
    return np.where(triangle[:, None], [0, 2, 1, 1], [0, 3, 2, 1])


def has_area(v: np.ndarray) -> np.ndarray:
    """Return (f,) bool: which polygons (f, 4, 3) are no lines or points up to rounding."""
    edge = np.linalg.norm(np.roll(v, -1, axis=1) - v, axis=2).max(axis=1, initial=0)
    double = np.linalg.norm(np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1]), axis=1)
    rounding = 4 * np.finfo(float).eps * np.abs(v).max(axis=(1, 2), initial=0)
    return double > edge * (1e-12 * edge + rounding)


def _concatenated(corners, parts):
    """Return the corners' values of all parts, nan where a part has none; None if all have none."""
    some = [x for x in corners if x is not None]
    if not some:
        return None
    missing = np.full((4, some[0].shape[2]), np.nan)
    return np.concatenate([
        np.broadcast_to(missing, (len(p), *missing.shape)) if x is None else x
        for x, p in zip(corners, parts, strict=True)
    ])  # fmt: skip


def _merged(v, material, group, uv, normals):
    """Return first and second face of each pair to join, and what its corners become.

    That is quadrilaterals (m, 4, 3) and, where given, their texture coordinates and normals.
    """
    triangle = np.flatnonzero(np.all(v[:, 3] == v[:, 2], axis=1))
    corners = v[triangle][:, :3]
    surface = material[triangle] * (group.max(initial=0) + 1) + group[triangle]
    one, two = _neighbours(corners, surface)
    joined = [
        None if x is None else _joined(x[triangle][:, :3], one, two) for x in (v, uv, normals)
    ]
    worst = _worst_corner(joined[0])
    good = worst <= BLUNTEST
    if uv is not None or normals is not None:
        from radiosity.mesh.corners import joinable  # others need none of it

        details = [None if x is None else x[triangle][:, :3] for x in (uv, normals)]
        good &= joinable(joined, details, one, two)
    good = np.flatnonzero(good)
    one, two = one[good] // 3, two[good] // 3
    order = np.lexsort((two, one, np.round(worst[good], 6)))
    chosen = order[_greedy(one[order], two[order], len(triangle))]
    quads = [None if x is None else x[good[chosen]] for x in joined]
    return triangle[one[chosen]], triangle[two[chosen]], quads


def _neighbours(corners, surface):
    """Return the edges, numbered 3 t + k, of triangles of one surface that meet head to tail."""
    ids = welded(corners.reshape(-1, 3)).reshape(-1, 3)
    start, end = ids.ravel(), np.roll(ids, -1, axis=1).ravel()
    one, two = meeting_edges(start, end, start != end).T
    same = (surface[one // 3] == surface[two // 3]) & (one // 3 != two // 3)
    one, two = one[same], two[same]
    return np.minimum(one, two), np.maximum(one, two)


def ranges(low, count):
    """Return the numbers low[i] ... low[i] + count[i] - 1 of all i in a row, and their i."""
    owner = np.repeat(np.arange(len(low)), count)
    return low[owner] + np.arange(len(owner)) - (np.cumsum(count) - count)[owner], owner


def meeting_edges(start, end, real):
    """Return the pairs (t, 2) of half-edges that run between the same points head to tail.

    ``start`` and ``end`` number their points, ``real`` tells which of them count.
    """
    key = np.minimum(start, end) * (start.max(initial=0) + 1) + np.maximum(start, end)
    there, back = np.flatnonzero(real & (start < end)), np.flatnonzero(real & (start > end))
    back = back[np.argsort(key[back], kind="stable")]
    low = np.searchsorted(key[back], key[there], "left")
    count = np.searchsorted(key[back], key[there], "right") - low
    at, owner = ranges(low, np.minimum(count, SHARED))
    return np.stack([there[owner], back[at]], axis=1)


def welded(points):
    """Return (n,) numbers that are equal where points (n, 3) coincide.

    Each coordinate is split where sorted values leave a gap, so that no rounding boundary
    separates near neighbours.
    """
    if len(points) == 0:
        return np.empty(0, int)
    axes = np.ascontiguousarray(points.T)
    gap = WELD * np.linalg.norm([np.ptp(x) for x in axes])
    number = np.zeros(len(points), int)
    for x in axes:
        rank = _ranks(x, gap)
        number = _ranks(number * (rank.max() + 1) + rank, 0)
    return number


def _ranks(x, gap):
    """Return (n,) numbers that rise with x and are equal where no sorted values leave a gap."""
    order = np.argsort(x)
    rank = np.empty(len(x), int)
    rank[order] = np.concatenate([[0], np.cumsum(np.diff(x[order]) > gap)])
    return rank


def _joined(corners, one, two):
    """Return what the corners (t, 3, c) of pairs of triangles become, (m, 4, c).

    Quadrilaterals begin with the first vertex of triangle one // 3.
    """
    t, k = one // 3, one % 3
    a, b, c = (corners[t, (k + i) % 3] for i in range(3))
    d = corners[two // 3, (two % 3 + 2) % 3]
    quads = np.stack([a, d, b, c], axis=1)
    start = np.array([0, 3, 2])[k]
    return quads[np.arange(len(t))[:, None], (start[:, None] + np.arange(4)) % 4]


def _worst_corner(quads):
    """Return (m,) the largest |cos| of a corner; inf where not planar or not convex."""
    edge = np.roll(quads, -1, axis=1) - quads
    edge /= np.linalg.norm(edge, axis=2, keepdims=True)
    before = np.roll(edge, 1, axis=1)
    diagonals = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
    normal = np.cross(*diagonals)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    height = np.einsum("mkx,mx->mk", quads - quads[:, :1], normal)
    size = np.max([np.linalg.norm(x, axis=1) for x in diagonals], axis=0)
    flat = np.ptp(height, axis=1) <= PLANAR * size
    convex = np.einsum("mkx,mx->mk", np.cross(before, edge), normal).min(axis=1) > 0
    cosine = np.abs(np.einsum("mkx,mkx->mk", before, edge)).max(axis=1)
    return np.where(flat & convex, cosine, np.inf)


def _greedy(one, two, n):
    """Return which of the pairs, taken in order, meet two faces that are both still free."""
    free, chosen = [True] * n, []
    for k, (i, j) in enumerate(zip(one.tolist(), two.tolist(), strict=True)):
        if free[i] and free[j]:
            free[i] = free[j] = False
            chosen.append(k)
    return np.array(chosen, int)
