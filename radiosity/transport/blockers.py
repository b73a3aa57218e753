"""What can come between two polygons: convex blockers in a tree, and the tests that sort pairs.

A shaft is the convex hull of a pair of polygons. A blocker outside of it takes nothing away; one
that the whole shaft passes through hides the pair; the others are cut out exactly (`shadow`) or,
where they are many, left to rays.
"""

from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.mesh.faces import meeting_edges, welded
from radiosity.transport.polygon import heights
from radiosity.transport.shaft import beside, box_beside

LEAF = 4
MOST = 32  # blockers in one shaft that are cut out exactly
HIDDEN, TOO_MANY = -1, -2
NEXT, END, WAITING, NODES = 0, 1, 2, 3  # in a walk, see `next_blocker`
AWAY, BETWEEN, COVERS = 0, 1, 2
ACROSS, OUTSIDE, INSIDE = 0, 1, 2  # of an edge
DIRECTIONS, CHUNK = 64, 256

Blockers = namedtuple("Blockers", "corners count normal body beyond grain low high leaves")
Blockers.__doc__ = """Convex polygons in Morton order, and the boxes of a binary tree over them.

corners (k, 8, 3), count (k,), normal (k, 3), body (k,): which closed surface it belongs to, see
`Bodies`; beyond (k, 8): which one shares the edge that begins at each corner, -1 where none does,
wound the same way and turned the least; grain (k,): how far rounding may have moved a corner; low
and high (2 leaves, 3): node 1 is the root, the children of node m are 2 m and 2 m + 1, leaf l is
node leaves + l and holds the LEAF blockers from LEAF l on.
"""


def make_blockers(corners, count, normal, body, grain, hull: bool = False) -> Blockers:
    """Return the facets that can block.

    A facet that has all others on one side of its plane can not: no segment between two points of
    the scene crosses it.

    Parameters
    ----------
    corners : (m, 8, 3), count : (m,), normal : (m, 3)
        As in `Facets`, in local coordinates of about 1.
    body : (m,) int
    grain : float or (m,) float
        How far rounding may have moved their corners.
    hull : bool
        Keep those that cannot block too, for searches alone: ``beyond`` is -1.
    """
    grain = np.full(len(corners), grain, float)
    inside = np.arange(len(corners))
    if not hull:
        inside = np.flatnonzero(~on_the_hull(corners, normal, 8.0 * grain))
    order = inside[np.argsort(_morton(corners[inside].mean(axis=1)), kind="stable")]
    corners, count, normal, body = corners[order], count[order], normal[order], body[order]
    grain = grain[order]
    leaves = 1 << max(0, int(np.ceil(np.log2(max(1, -(-len(corners) // LEAF))))))
    low, high = np.full((2, 2 * leaves, 3), np.inf)
    high *= -1
    leaf = leaves + np.arange(len(corners)) // LEAF
    np.minimum.at(low, leaf, corners.min(axis=1))
    np.maximum.at(high, leaf, corners.max(axis=1))
    for m in range(leaves - 1, 0, -1):
        low[m] = np.minimum(low[2 * m], low[2 * m + 1])
        high[m] = np.maximum(high[2 * m], high[2 * m + 1])
    beyond = np.full(corners.shape[:2], -1) if hull else _beyond(corners, count, normal)
    return Blockers(
        np.ascontiguousarray(corners), count.astype(np.int64), np.ascontiguousarray(normal),
        body.astype(np.int64), beyond, grain, low, high, leaves,
    )  # fmt: skip


def _beyond(corners, count, normal) -> np.ndarray:
    """Return (k, 8) the polygon that shares each edge, see `Blockers`."""
    k, most = corners.shape[:2]
    real, start = np.arange(most) < count[:, None], np.zeros((k, most), int)
    start[real] = welded(corners[real])
    at = (np.arange(most) + 1) % count[:, None]
    end = np.take_along_axis(start, at, axis=1)
    real &= start != end
    one, two = meeting_edges(start.ravel(), end.ravel(), real.ravel()).T
    one, two = np.concatenate([one, two]), np.concatenate([two, one])
    alike = np.einsum("ec,ec->e", normal[one // most], normal[two // most])
    found, order = np.full(k * most, -1), np.argsort(alike, kind="stable")
    found[one[order]] = two[order] // most  # the last one stays
    return found.reshape(k, most)


def on_the_hull(corners: np.ndarray, normal: np.ndarray, slack: np.ndarray) -> np.ndarray:
    """Return (k,) bool: polygons whose plane has all corners on one side, within slack (k,).

    Those that the outermost corners in some directions lie on both sides of are spared the rest.
    """
    points = corners.reshape(-1, 3)
    ways = np.random.default_rng(0).normal(size=(DIRECTIONS, 3))
    outer = np.unique([np.argmax(points @ way) for way in ways]) if len(points) else []
    level = np.einsum("kc,kc->k", corners[:, 0], normal)
    left = np.arange(len(corners))
    for tried in (points[outer], points):
        one_side = np.zeros(len(left), bool)
        for a in range(0, len(left), CHUNK):
            part = left[a : a + CHUNK]
            h, s = normal[part] @ tried.T - level[part, None], slack[part]
            one_side[a : a + CHUNK] = (h.min(axis=1) >= -s) | (h.max(axis=1) <= s)
        left = left[one_side]
    found = np.zeros(len(corners), bool)
    found[left] = True
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
def passes(a, b, side, p, q, slack):
    """Return where all segments from p to q pass a line a-b: OUTSIDE, INSIDE or, both, ACROSS.

    ``side`` is -1 where p lies in front of the polygon whose edge from a to b it is, 1 behind it.

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
            return ACROSS
    return OUTSIDE if outside else INSIDE


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
        where = passes(corners[k], corners[(k + 1) % len(corners)], side, p, q, slack)
        if where == OUTSIDE:
            return AWAY
        covers = covers and where == INSIDE
    return COVERS if covers else BETWEEN


@njit(cache=True, nogil=True, error_model="numpy")
def next_blocker(blockers, planes, slack, walk):
    """Return the next blocker that no plane keeps out, -1 after the last.

    ``walk`` (64,) holds how far the tree was walked: the next of a leaf and its end, how many nodes
    wait, and these; WAITING = 0 of them before the first.
    """
    while True:
        while walk[NEXT] < walk[END]:
            b = walk[NEXT]
            walk[NEXT] += 1
            if not beside(blockers.corners[b, : blockers.count[b]], planes, slack):
                return b
        if walk[WAITING] == 0:
            return -1
        walk[WAITING] -= 1
        m = walk[NODES + walk[WAITING]]
        if box_beside(blockers.low[m], blockers.high[m], planes, slack):
            continue
        if m >= blockers.leaves:
            walk[NEXT] = (m - blockers.leaves) * LEAF
            walk[END] = min(walk[NEXT] + LEAF, len(blockers.count))
        else:
            top = NODES + walk[WAITING]
            walk[top], walk[top + 1] = 2 * m + 1, 2 * m
            walk[WAITING] += 2


@njit(cache=True, nogil=True, error_model="numpy")
def first_blocker(blockers, planes, slack, walk):
    """Return what `next_blocker` returns first."""
    walk[NEXT] = walk[END] = 0
    walk[WAITING], walk[NODES] = 1, 1
    return next_blocker(blockers, planes, slack, walk)


@njit(cache=True, nogil=True, error_model="numpy")
def find_blockers(blockers, free, p, box, planes, slack, beyond, walk, found):
    """Write the blockers between a polygon and all that a box holds into found.

    Parameters
    ----------
    free : (bodies + 1,) bool
        Bodies on whose free side the polygon lies: of these only what it sees the front of counts.
    p : (4, 3)
        Corners of the polygon.
    box : (m, 3)
        Corners of the box, or of another polygon.
    planes : (k, 4)
        Of the shaft between them, see `shaft_planes`.
    slack : float
        Distance that counts as touching.
    beyond : float
        How far behind a blocker the box must lie to be hidden: above 0 for a box about many
        polygons, one of which may lie on the blocker and be seen.
    walk : (64,) int64, found : (k,) int64, space; more than k are TOO_MANY

    Returns
    -------
    int
        How many, HIDDEN where one of them covers all, or TOO_MANY.
    """
    count, b = 0, first_blocker(blockers, planes, slack, walk)
    while b >= 0:
        corners, normal = blockers.corners[b, : blockers.count[b]], blockers.normal[b]
        own, where = max(slack, 4.0 * blockers.grain[b]), AWAY
        if not free[blockers.body[b]] or heights(p, corners[0], normal)[1] > own:
            where = between(corners, normal, p, box, own)
        if where == COVERS:
            low, high = heights(box, corners[0], normal)
            if max(low, -high) >= beyond:
                return HIDDEN
        if where != AWAY:
            if count == len(found):
                return TOO_MANY
            found[count] = b
            count += 1
        b = next_blocker(blockers, planes, slack, walk)
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def prepare_lines(blockers, candidates, p, slack, lines, sides):
    """Write the planes through corners of p and edges of the candidates, for `keep_between`.

    Parameters
    ----------
    lines : (MOST, 8, 4, 4)
        Gets (a, b, c, d) with a y0 + b y1 + c y2 + d positive inside, see `passes`.
    sides : (MOST,)
        Gets -1 where p lies in front of a candidate's plane, 1 behind it, 0 on both sides.
    """
    for m in range(len(candidates)):
        b = candidates[m]
        corners, count = blockers.corners[b], blockers.count[b]
        low, high = heights(p, corners[0], blockers.normal[b])
        own = max(slack, 4.0 * blockers.grain[b])
        sides[m] = -1.0 if low >= -own else 1.0 if high <= own else 0.0
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
        own = max(slack, 4.0 * blockers.grain[b])
        if (sides[m] < 0.0 and low >= -own) or (sides[m] > 0.0 and high <= own):
            continue
        covers = (sides[m] < 0.0 and high <= own) or (sides[m] > 0.0 and low >= -own)
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
                if high <= own:
                    away = True
                    break
                covers = covers and low >= -own
        if away:
            continue
        if covers:
            return HIDDEN
        found[kept] = b
        kept += 1
    return kept


@njit(cache=True, nogil=True, error_model="numpy")
def drop_beside(blockers, found, count, planes, slack):
    """Keep in found[:count] what no plane of a shaft keeps out; return how many."""
    kept = 0
    for k in range(count):
        if not beside(blockers.corners[found[k], : blockers.count[found[k]]], planes, slack):
            found[kept] = found[k]
            kept += 1
    return kept
