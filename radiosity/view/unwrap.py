"""Laying surfaces out flat: where each point lies on a square of texels, and the way back.

Texture coordinates (u, v) run from 0 to 1, right and down from the upper left corner as in glTF;
texel (i, j) of N x N, row and column, has its centre at ((j + 1/2)/N, (i + 1/2)/N).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from radiosity.mesh.faces import meeting_edges, welded
from radiosity.mesh.interpolation import SMOOTH
from radiosity.view.atlas import packed

LEAST, MOST = 16, 4096  # texels on a side
PADDING = 4  # texels between charts at least, two of them each one's own
REACH = 1.5  # texels beyond a chart's edge that still take its nearest point: bilinear looks at 1
INSET = 1e-4  # of a triangle: points on its very edge would lie on two faces
NONE = -1


def check_size(size: int) -> None:
    """Raise ValueError for a size that no lightmap is made of."""
    if not (isinstance(size, int | np.integer) and LEAST <= size <= MOST):
        raise ValueError(
            f"lightmap = {size} must be a whole number from {LEAST} to {MOST}: texels on a side"
        )


@dataclass(frozen=True)
class Layout:
    """Polygons laid out on N x N texels, in triangles.

    Attributes
    ----------
    size : int
        N.
    polygon : (t,) int
        Which of the polygons a triangle is a part of.
    corners : (t, 3, 3) float64
        In scene units, in the polygons' order.
    uv : (t, 3, 2) float64
    """

    size: int
    polygon: np.ndarray
    corners: np.ndarray
    uv: np.ndarray

    def texels(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the texels that have a place on a surface.

        Returns
        -------
        texel : (k,) int
            i N + j, rising.
        polygon : (k,) int
        points : (k, 3) float64
            On the polygon, scene units: the centre's, or the nearest one of a centre just outside.
        """
        n = self.size
        owner = np.full((n, n), NONE, np.int32)
        gap = np.full((n, n), np.inf, np.float32)
        weight = np.zeros((n, n, 2), np.float32)
        _rasterise(self.uv * n, REACH, owner, gap, weight)
        texel = np.flatnonzero(owner.ravel() >= 0)
        triangle, w = owner.ravel()[texel], weight.reshape(-1, 2)[texel].astype(float)
        w = np.column_stack([1.0 - w.sum(axis=1), w]) * (1.0 - INSET) + INSET / 3.0
        points = np.einsum("kv,kvc->kc", w, self.corners[triangle])
        return texel, self.polygon[triangle], points


def unwrap(polygons: np.ndarray, normals: np.ndarray, kind: np.ndarray, size: int) -> Layout:
    """Lay polygons out on size x size texels, all at about one scale.

    Neighbours of one ``kind`` whose normals agree within 30 degrees stay together where xatlas
    finds that they may; no other two share a chart, so that no texel lies across a crease.

    Parameters
    ----------
    polygons : (n, 4, 3) float64
        Planar and convex; a triangle repeats its last vertex.
    normals : (n, 3) float64
    kind : (n,) int
    size : int

    Raises
    ------
    ValueError
        So many charts do not fit on so few texels.
    """
    quad = np.flatnonzero(np.any(polygons[:, 3] != polygons[:, 2], axis=1))
    polygon = np.concatenate([np.arange(len(polygons)), quad])
    corners = np.concatenate([polygons[:, :3], polygons[quad][:, [0, 2, 3]]])
    surface = _surfaces(polygons, normals, kind)[polygon]
    order = np.argsort(surface, kind="stable")
    polygon, corners = polygon[order], corners[order]
    meshes = np.split(corners, np.flatnonzero(np.diff(surface[order])) + 1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # xatlas leaves out triangles of a tiny area, whatever the unit: make the usual one large.
    scale = 100.0 / np.sqrt(0.5 * np.median(np.linalg.norm(cross, axis=1)))
    uv = _packed([_mesh(m, scale) for m in meshes], size)
    return Layout(size, polygon, corners, uv)


def _mesh(corners, scale):
    """Return places (n, 3) float32 and triangles (t, 3) uint32 of corners (t, 3, 3)."""
    points = corners.reshape(-1, 3)
    _, first, index = np.unique(welded(points), return_index=True, return_inverse=True)
    places = (points[first] - points.mean(axis=0)) * scale
    return places.astype(np.float32), index.reshape(-1, 3).astype(np.uint32)


def _packed(meshes, size):
    """Return (t, 3, 2) texture coordinates: as large as fits into one square."""
    uv, charts = packed(meshes, size, PADDING)
    if uv is None:
        raise ValueError(
            f"lightmap = {size}: its {size} x {size} texels cannot hold the {charts} parts that "
            f"the surfaces come to, with {PADDING} texels between them: ask for more"
        )
    return uv


def _surfaces(polygons, normals, kind):
    """Return (n,) numbers that polygons of one smooth surface share.

    Each becomes a mesh of its own, as xatlas joins what touches within one.
    """
    point = welded(polygons.reshape(-1, 3))
    start, end = point, np.roll(point.reshape(-1, 4), -1, axis=1).ravel()
    one, two = meeting_edges(start, end, start != end).T // 4
    smooth = (kind[one] == kind[two]) & (one != two)
    smooth &= np.einsum("kc,kc->k", normals[one], normals[two]) > SMOOTH
    links = one[smooth], two[smooth]
    joined = coo_array((np.ones(smooth.sum()), links), shape=(len(polygons),) * 2)
    return connected_components(joined, directed=False)[1]


@njit(cache=True, nogil=True)
def _rasterise(uv, reach, owner, gap, weight):
    """Find for each texel the triangle that holds its centre, or the nearest within ``reach``."""
    n = len(owner)
    w = np.empty(3)
    for t in range(len(uv)):
        low_u = min(uv[t, 0, 0], uv[t, 1, 0], uv[t, 2, 0]) - reach
        high_u = max(uv[t, 0, 0], uv[t, 1, 0], uv[t, 2, 0]) + reach
        low_v = min(uv[t, 0, 1], uv[t, 1, 1], uv[t, 2, 1]) - reach
        high_v = max(uv[t, 0, 1], uv[t, 1, 1], uv[t, 2, 1]) + reach
        for i in range(max(0, int(np.floor(low_v))), min(n, int(np.ceil(high_v)) + 1)):
            for j in range(max(0, int(np.floor(low_u))), min(n, int(np.ceil(high_u)) + 1)):
                d = _nearest(uv[t], j + 0.5, i + 0.5, w)
                if d < gap[i, j] and d <= reach:
                    owner[i, j], gap[i, j] = t, d
                    weight[i, j, 0], weight[i, j, 1] = w[1], w[2]


@njit(cache=True, nogil=True)
def _nearest(corner, x, y, w):
    """Write the corners' weights at the point of a triangle nearest to (x, y); return how far."""
    ax, ay = corner[0, 0], corner[0, 1]
    bx, by, cx, cy = corner[1, 0] - ax, corner[1, 1] - ay, corner[2, 0] - ax, corner[2, 1] - ay
    det = bx * cy - by * cx
    if det != 0.0:
        w[1] = ((x - ax) * cy - (y - ay) * cx) / det
        w[2] = (bx * (y - ay) - by * (x - ax)) / det
        w[0] = 1.0 - w[1] - w[2]
        if w[0] >= 0.0 and w[1] >= 0.0 and w[2] >= 0.0:
            return 0.0
    best = np.inf
    for k in range(3):
        m = (k + 1) % 3
        px, py = corner[k, 0], corner[k, 1]
        ex, ey = corner[m, 0] - px, corner[m, 1] - py
        length = ex * ex + ey * ey
        t = 0.0
        if length > 0.0:
            t = min(1.0, max(0.0, ((x - px) * ex + (y - py) * ey) / length))
        d = np.hypot(x - px - t * ex, y - py - t * ey)
        if d < best:
            best = d
            w[:] = 0.0
            w[k], w[m] = 1.0 - t, t
    return best
