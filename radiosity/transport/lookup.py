"""From a point on a face back to the patch that holds it, compiled."""

from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.mesh.faces import Faces
from radiosity.mesh.patches import Patches

CUT = -2

Table = namedtuple(
    "Table",
    "origin along across skew face_normal shape first levels split begin whole start vertices "
    "normal face behind",
)
Table.__doc__ = """The arrays that `whole_side` and `cut_side` read.

A face's point x has the coordinates s', t' = (x - origin) . (along, across); on a quadrilateral
s + skew[0] s t = s' and t + skew[1] s t = t' give its bilinear s and t. ``whole`` is the front
that fills a cell, -1 where it is cut or another face lies on it. Of the k-th nested grids ``split``
begins at levels[k] and ``begin`` at levels[k] + k, see `Division`. The rest is as in `Patches`,
fronts only.
"""


def make_table(faces: Faces, patches: Patches) -> Table:
    """Return the table that finds the patches of these faces again."""
    v, n = faces.vertices, patches.fronts
    triangle = faces.is_triangle
    one, two = v[:, 1] - v[:, 0], np.where(triangle[:, None], v[:, 2], v[:, 3]) - v[:, 0]
    normal = faces.normals()
    det = np.einsum("fc,fc->f", np.cross(one, two), normal)[:, None]
    det[det == 0.0] = 1.0  # two corners of a quadrilateral in one place
    along, across = np.cross(two, normal) / det, np.cross(normal, one) / det
    twist = np.where(triangle[:, None], 0.0, v[:, 0] - v[:, 1] + v[:, 2] - v[:, 3])
    skew = np.stack([np.einsum("fc,fc->f", twist, d) for d in (along, across)], axis=1)
    skew[np.abs(skew) < 1e-12] = 0.0
    grid, division = patches.grid, patches.grid.division
    none, levels = np.empty(0, np.int64), np.cumsum([0, *map(len, division.splits)])[:-1]
    only = grid.start[:-1]
    bare = np.all(patches.behind < 0, axis=1)
    whole = np.where((np.diff(grid.start) == 1) & bare[only], only, -1)
    return Table(
        v[:, 0].copy(), along, across, skew, normal, division.shape, division.first, levels,
        np.concatenate([none, *division.splits]), np.concatenate([none, *division.begin]),
        whole, grid.start, patches.vertices[:n], patches.normal[:n], patches.face[:n],
        patches.behind,
    )  # fmt: skip


@njit(cache=True, nogil=True, inline="always")
def _coordinates(table, face, x):
    """Return the s and t of a point on a face, by Newton's method where the face is skew."""
    s1 = t1 = 0.0
    for c in range(3):
        r = x[c] - table.origin[face, c]
        s1 += r * table.along[face, c]
        t1 += r * table.across[face, c]
    g, h = table.skew[face, 0], table.skew[face, 1]
    s, t = s1, t1
    if g == 0.0 and h == 0.0:
        return s, t
    for _ in range(8):
        es, et = s + g * s * t - s1, t + h * s * t - t1
        a, b, c, d = 1.0 + g * t, g * s, h * t, 1.0 + h * s
        det = a * d - b * c
        s -= (d * es - b * et) / det
        t -= (a * et - c * es) / det
        if abs(es) + abs(et) < 1e-12:
            break
    return s, t


@njit(cache=True, nogil=True)
def coordinates_at(table, face, points):
    """Return the s and t (k, 2) of points (k, 3) on faces (k,)."""
    found = np.empty((len(face), 2))
    for k in range(len(face)):
        found[k] = _coordinates(table, face[k], points[k])
    return found


@njit(cache=True, nogil=True, inline="always")
def _in_square(s, t, columns, rows):
    """Return which cell of a square's grid holds (s, t), and its own s and t there."""
    s, t = s * columns, t * rows
    i = min(max(int(s), 0), columns - 1)
    j = min(max(int(t), 0), rows - 1)
    return j * columns + i, s - i, t - j


@njit(cache=True, nogil=True, inline="always")
def _in_triangle(s, t, n):
    """Return which cell of a triangle's n x n ones holds (s, t), and its own s and t there."""
    s, t = n * s, n * t
    row = min(max(int(t), 0), n - 1)
    column = min(max(int(s), 0), n - 1 - row)
    s, t = s - column, t - row
    cell = 2 * n * row - row * row + 2 * column
    if s + t > 1.0 and column < n - 1 - row:
        return cell + 1, s + t - 1.0, 1.0 - s
    return cell, s, t


@njit(cache=True, nogil=True, inline="always")
def _in_grid(s, t, columns, rows):
    """Do as `_in_square`, or, where there are no rows, as `_in_triangle`."""
    if rows > 0:
        return _in_square(s, t, columns, rows)
    return _in_triangle(s, t, columns)


@njit(cache=True, nogil=True, inline="always")
def cell_at(table, face, x, finer):
    """Return which cell of a face holds x, numbered as in `Division`.

    ``finer`` = m asks in a grid of m x m cells for each of the face's own.
    """
    s, t = _coordinates(table, face, x)
    columns, rows = table.shape[face, 0], table.shape[face, 1]
    square = min(rows, 1)
    cell, s, t = _in_grid(s, t, columns, rows)
    cell += table.first[face]
    for k in range(len(table.levels)):
        m = table.split[table.levels[k] + cell]
        part, s, t = _in_grid(s, t, m, m * square)
        cell = table.begin[table.levels[k] + k + cell] + part
    return cell * finer * finer + _in_grid(s, t, finer, finer * square)[0]


@njit(cache=True, nogil=True)
def margin_in(polygon, normal, x):
    """Return how far x lies inside a convex polygon's nearest edge (negative outside)."""
    lowest = 1e300
    for k in range(4):
        j = (k + 1) % 4
        ex = polygon[j, 0] - polygon[k, 0]
        ey = polygon[j, 1] - polygon[k, 1]
        ez = polygon[j, 2] - polygon[k, 2]
        length = np.sqrt(ex * ex + ey * ey + ez * ez)
        if length > 0.0:
            rx, ry, rz = x[0] - polygon[k, 0], x[1] - polygon[k, 1], x[2] - polygon[k, 2]
            d = (ey * rz - ez * ry) * normal[0] + (ez * rx - ex * rz) * normal[1]
            d += (ex * ry - ey * rx) * normal[2]
            lowest = min(lowest, d / length)
    return lowest


@njit(cache=True, nogil=True)
def _part_of(cell, x, start, vertices, normal):
    """Return the part of a cut cell that holds x."""
    best, margin = start[cell], -1e300
    for k in range(start[cell], start[cell + 1]):
        m = margin_in(vertices[k], normal[k], x)
        if m > margin:
            best, margin = k, m
    return best


@njit(cache=True, nogil=True, inline="always")
def whole_side(table, face, x, dx, dy, dz):
    """Return 2 * front for the front or 2 * front + 1 for the back that a ray meets.

    x is the point (3,) on ``face``, (dx, dy, dz) the ray's direction. `CUT` where the cell is not
    one patch: `cut_side` tells.
    """
    n = table.face_normal
    front = table.whole[cell_at(table, face, x, 1)]
    if front < 0:
        return CUT
    return 2 * front + int(dx * n[face, 0] + dy * n[face, 1] + dz * n[face, 2] > 0.0)


@njit(cache=True, nogil=True)
def cut_side(table, face, x, d):
    """Return what `whole_side` does, for cells that contacts have cut or covered."""
    n = table.face_normal[face]
    back = int(d[0] * n[0] + d[1] * n[1] + d[2] * n[2] > 0.0)
    front = _part_of(cell_at(table, face, x, 1), x, table.start, table.vertices, table.normal)
    other = table.behind[front, back]
    if other >= 0:
        m = table.face_normal[other]
        back = int(d[0] * m[0] + d[1] * m[1] + d[2] * m[2] > 0.0)
        front = _part_of(cell_at(table, other, x, 1), x, table.start, table.vertices, table.normal)
    return 2 * front + back


@njit(cache=True, nogil=True)
def fronts_at(table, face, points):
    """Return (k,) the fronts that hold points (k, 3) of faces (k,)."""
    found = np.empty(len(face), np.int64)
    for k in range(len(face)):
        cell = cell_at(table, face[k], points[k], 1)
        found[k] = _part_of(cell, points[k], table.start, table.vertices, table.normal)
    return found
