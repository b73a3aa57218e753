"""What can come between two polygons: convex blockers in a tree, and the tests that sort pairs.

A shaft is the convex hull of a pair of polygons. A blocker outside of it takes nothing away; one
that the whole shaft passes through hides the pair; the others are cut out exactly (`shadow`) or,
where they are many, left to rays.
"""

import math
from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.transport.polygon import heights

LEAF = 2
MOST = 32  # blockers in one shaft that are cut out exactly
HIDDEN, TOO_MANY = -1, -2
AWAY, BETWEEN, COVERS = 0, 1, 2

Blockers = namedtuple("Blockers", "corners count normal body low high leaves")
Blockers.__doc__ = """Convex polygons in Morton order, and the boxes of a binary tree over them.

corners (k, 8, 3), count (k,), normal (k, 3), body (k,): which closed surface it belongs to, see
`Bodies`; low and high (2 leaves, 3): node 1 is the root, the
children of node m are 2 m and 2 m + 1, leaf l is node leaves + l and holds the LEAF blockers from
LEAF l on.
"""


def make_blockers(corners, count, normal, body, grain: float) -> Blockers:
    """Return the facets that can block.

    A facet that has all others on one side of its plane can not: no segment between two points of
    the scene crosses it.

    Parameters
    ----------
    corners : (m, 8, 3), count : (m,), normal : (m, 3)
        As in `Facets`, in local coordinates of about 1.
    body : (m,) int
    grain : float
        How far rounding may have moved a corner.
    """
    inside = np.flatnonzero(~_on_the_hull(corners, normal, 8.0 * grain))
    order = inside[np.argsort(_morton(corners[inside].mean(axis=1)), kind="stable")]
    corners, count, normal, body = corners[order], count[order], normal[order], body[order]
    leaves = 1 << max(0, int(np.ceil(np.log2(max(1, -(-len(corners) // LEAF))))))
    low, high = np.full((2, 2 * leaves, 3), np.inf)
    high *= -1
    leaf = leaves + np.arange(len(corners)) // LEAF
    np.minimum.at(low, leaf, corners.min(axis=1))
    np.maximum.at(high, leaf, corners.max(axis=1))
    for m in range(leaves - 1, 0, -1):
        low[m] = np.minimum(low[2 * m], low[2 * m + 1])
        high[m] = np.maximum(high[2 * m], high[2 * m + 1])
    return Blockers(
        np.ascontiguousarray(corners), count.astype(np.int64), np.ascontiguousarray(normal),
        body.astype(np.int64), low, high, leaves,
    )  # fmt: skip


def _on_the_hull(corners, normal, slack, chunk: int = 256) -> np.ndarray:
    """Return (k,) bool: polygons whose plane has all corners on one side, within slack."""
    points = np.unique(corners.reshape(-1, 3), axis=0)
    level = np.einsum("kc,kc->k", corners[:, 0], normal)
    found = np.zeros(len(corners), bool)
    for a in range(0, len(corners), chunk):
        h = normal[a : a + chunk] @ points.T - level[a : a + chunk, None]
        found[a : a + chunk] = (h.min(axis=1) >= -slack) | (h.max(axis=1) <= slack)
    return found


def _morton(points) -> np.ndarray:
    """Return (k,) codes that order points along a curve through nested octants."""
    if len(points) == 0:
        return np.zeros(0, np.int64)
    low, high = points.min(axis=0), points.max(axis=0)
    cell = ((points - low) / np.maximum(high - low, 1e-300) * 1023.0).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(10):
        for c in range(3):
            code |= ((cell[:, c] >> bit) & 1) << (3 * bit + c)
    return code


@njit(cache=True, nogil=True, error_model="numpy")
def _box_meets_shaft(low, high, normal, middle, around, other):
    """Whether a box reaches in front of a polygon and near to the segment from its middle to other.

    ``around`` is the radius of the larger end of the shaft.
    """
    front = 0.0
    for c in range(3):
        front += normal[c] * ((high[c] if normal[c] > 0.0 else low[c]) - middle[c])
    if not front > 0.0:
        return False
    enter, leave = 0.0, 1.0
    for c in range(3):
        a, b = low[c] - around - middle[c], high[c] + around - middle[c]
        d = other[c] - middle[c]
        if abs(d) < 1e-300:
            if a > 0.0 or b < 0.0:
                return False
            continue
        a, b = a / d, b / d
        enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return enter <= leave


@njit(cache=True, nogil=True, error_model="numpy")
def _passes(a, b, side, p, q, slack):
    """Where all segments from p to q pass a line a-b: 1 on its outer side, 2 inside, 0 on both.

    (a - x) x (b - x) . (y - x) is affine in x and in y, so the corners of both decide.
    """
    outside = inside = True
    for k in range(len(p)):
        ax, ay, az = a[0] - p[k, 0], a[1] - p[k, 1], a[2] - p[k, 2]
        bx, by, bz = b[0] - p[k, 0], b[1] - p[k, 1], b[2] - p[k, 2]
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        nx, ny, nz = side * nx, side * ny, side * nz
        level = nx * p[k, 0] + ny * p[k, 1] + nz * p[k, 2]
        for m in range(len(q)):
            w = nx * q[m, 0] + ny * q[m, 1] + nz * q[m, 2] - level
            outside = outside and w <= slack
            inside = inside and w >= -slack
        if not outside and not inside:
            return 0
    return 1 if outside else 2


@njit(cache=True, nogil=True, error_model="numpy")
def between(corners, normal, p, q, slack):
    """Sort one blocker: AWAY from the shaft of p and q, BETWEEN them, or it COVERS the shaft.

    Parameters
    ----------
    corners : (k, 3), normal : (3,)
        The blocker.
    p, q : (m, 3)
        Corners of two convex bodies.
    slack : float
        Distance that counts as touching.
    """
    low_p, high_p = heights(p, corners[0], normal)
    low_q, high_q = heights(q, corners[0], normal)
    if (low_p >= -slack and low_q >= -slack) or (high_p <= slack and high_q <= slack):
        return AWAY
    if not (low_p >= -slack or high_p <= slack):
        return BETWEEN
    side = -1.0 if low_p >= -slack else 1.0
    covers = high_q <= slack if side < 0.0 else low_q >= -slack
    for k in range(len(corners)):
        where = _passes(corners[k], corners[(k + 1) % len(corners)], side, p, q, slack)
        if where == 1:
            return AWAY
        covers = covers and where == 2
    return COVERS if covers else BETWEEN


@njit(cache=True, nogil=True, error_model="numpy")
def find_blockers(blockers, free, geometry, i, box, middle, reach, beyond, nodes, found):
    """Write the blockers between polygon i and all that a box holds into found.

    Parameters
    ----------
    free : (bodies + 1,) bool
        Bodies on whose free side polygon i lies: of these only what it sees the front of counts.
    box : (m, 3)
        Its corners, or a polygon's; ``middle`` (3,) and ``reach``: a sphere about what it holds.
    beyond : float
        How far behind a blocker the box must lie to be hidden: above 0 for a box about many
        polygons, one of which may lie on the blocker and be seen.
    nodes : (64,) int64, found : (k,) int64, space; more than k are TOO_MANY

    Returns
    -------
    int
        How many, HIDDEN where one of them covers all, or TOO_MANY.
    """
    count, left = 0, 1
    nodes[0] = 1
    p, normal, centre = geometry.vertices[i], geometry.normal[i], geometry.centroid[i]
    around, slack = max(geometry.radius[i], reach), 4.0 * geometry.grain
    while left > 0:
        left -= 1
        m = nodes[left]
        if not _box_meets_shaft(
            blockers.low[m], blockers.high[m], normal, centre, around, middle
        ):
            continue
        if m < blockers.leaves:
            nodes[left], nodes[left + 1] = 2 * m + 1, 2 * m
            left += 2
            continue
        first = (m - blockers.leaves) * LEAF
        for b in range(first, min(first + LEAF, len(blockers.count))):
            corners = blockers.corners[b, : blockers.count[b]]
            if heights(corners, centre, normal)[1] <= slack:
                continue
            if free[blockers.body[b]] and heights(p, corners[0], blockers.normal[b])[1] <= slack:
                continue
            where = between(corners, blockers.normal[b], p, box, slack)
            if where == COVERS:
                low, high = heights(box, corners[0], blockers.normal[b])
                if max(low, -high) >= beyond:
                    return HIDDEN
            if where != AWAY:
                if count == len(found):
                    return TOO_MANY
                found[count] = b
                count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def prepare_lines(blockers, candidates, p, slack, lines, sides):
    """Write the planes through corners of p and edges of the candidates, for `keep_between`.

    Parameters
    ----------
    lines : (MOST, 8, 4, 4)
        Gets (a, b, c, d) with a y0 + b y1 + c y2 + d positive inside, see `_passes`.
    sides : (MOST,)
        Gets -1 where p lies in front of a candidate's plane, 1 behind it, 0 on both sides.
    """
    for m in range(len(candidates)):
        b = candidates[m]
        corners, count = blockers.corners[b], blockers.count[b]
        low, high = heights(p, corners[0], blockers.normal[b])
        sides[m] = -1.0 if low >= -slack else 1.0 if high <= slack else 0.0
        for e in range(count):
            one, two = corners[e], corners[(e + 1) % count]
            for k in range(4):
                ax, ay, az = one[0] - p[k, 0], one[1] - p[k, 1], one[2] - p[k, 2]
                bx, by, bz = two[0] - p[k, 0], two[1] - p[k, 1], two[2] - p[k, 2]
                nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
                nx, ny, nz = sides[m] * nx, sides[m] * ny, sides[m] * nz
                line = lines[m, e, k]
                line[0], line[1], line[2] = nx, ny, nz
                line[3] = -(nx * p[k, 0] + ny * p[k, 1] + nz * p[k, 2])


@njit(cache=True, nogil=True, error_model="numpy")
def keep_between(blockers, candidates, lines, sides, centre, normal, q, slack, found):
    """Write those of the candidates that come between the prepared polygon and q into found.

    ``centre`` and ``normal`` are those of q. Returns how many, or HIDDEN where one covers all. The
    same as `between` for each, with what depends on the first polygon computed before.
    """
    kept = 0
    for m in range(len(candidates)):
        b = candidates[m]
        count = blockers.count[b]
        corners = blockers.corners[b, :count]
        if heights(corners, centre, normal)[1] <= slack:
            continue
        low, high = heights(q, corners[0], blockers.normal[b])
        if (sides[m] < 0.0 and low >= -slack) or (sides[m] > 0.0 and high <= slack):
            continue
        covers = (sides[m] < 0.0 and high <= slack) or (sides[m] > 0.0 and low >= -slack)
        away = False
        if sides[m] != 0.0:
            for e in range(count):
                low, high = 1e300, -1e300
                for v in range(4):
                    x, y, z = q[v, 0], q[v, 1], q[v, 2]
                    for k in range(4):
                        line = lines[m, e, k]
                        w = line[0] * x + line[1] * y + line[2] * z + line[3]
                        low, high = min(low, w), max(high, w)
                if high <= slack:
                    away = True
                    break
                covers = covers and low >= -slack
        if away:
            continue
        if covers:
            return HIDDEN
        found[kept] = b
        kept += 1
    return kept


@njit(cache=True, nogil=True, error_model="numpy")
def drop_beside(blockers, found, count, p, normal_p, q, normal_q, slack):
    """Keep in found[:count] what no side of the shaft of p and q keeps out; return how many.

    Parameters
    ----------
    p, q : (m, 3)
        Convex polygons in front of each other, counter-clockwise about their normals.
    """
    count = _drop_by_edges(blockers, found, count, p, normal_p, q, slack)
    return _drop_by_edges(blockers, found, count, q, normal_q, p, slack) if count > 0 else 0


@njit(cache=True, nogil=True, error_model="numpy")
def _drop_by_edges(blockers, found, count, p, n, q, slack):
    """Drop what lies beyond the planes through an edge of p that just touch q."""
    plane = np.empty(3)
    for e in range(len(p)):
        a = p[e]
        if not _plane_about(a, p[(e + 1) % len(p)], n, q, plane):
            continue
        if heights(p, a, plane)[1] > slack or heights(q, a, plane)[1] > slack:
            continue  # the direction of a short edge is rounding
        kept = 0
        for k in range(count):
            corners = blockers.corners[found[k], : blockers.count[found[k]]]
            if heights(corners, a, plane)[0] < -slack:
                found[kept] = found[k]
                kept += 1
        count = kept
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _plane_about(a, b, n, q, plane):
    """Write the outward unit normal of the plane through the edge a-b that just touches q.

    False where there is none.
    """
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    mx, my, mz = y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]
    size = math.sqrt(mx * mx + my * my + mz * mz)
    if not size > 0.0:
        return False
    mx, my, mz = mx / size, my / size, mz / size
    out = up = 0.0  # of the corner seen furthest beyond the edge
    for k in range(len(q)):
        x, y, z = q[k, 0] - a[0], q[k, 1] - a[1], q[k, 2] - a[2]
        side, height = mx * x + my * y + mz * z, max(0.0, n[0] * x + n[1] * y + n[2] * z)
        if k == 0 or side * up > out * height:
            out, up = side, height
    slope = math.sqrt(out * out + up * up)
    if not slope > 0.0:
        return False
    plane[0] = (up * mx - out * n[0]) / slope
    plane[1] = (up * my - out * n[1]) / slope
    plane[2] = (up * mz - out * n[2]) / slope
    return True
