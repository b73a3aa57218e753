"""Exchange of a pair that sees each other in part: the exact visible factor, integrated adaptively.

The factor from a point to the visible part of the other polygon (`shadow`) is continuous with kinks
where shadow edges meet corners. Rules of the third degree over either polygon give two answers with
different errors; where they differ by too much one of the polygons is divided towards the kinks.
"""

import math

import numpy as np
from numba import njit

from radiosity.transport.exchange import sum_of_squares
from radiosity.transport.polygon import TINY, bilinear, point_factor
from radiosity.transport.shadow import visible_factor

MOST_CELLS = 1 << 13  # of one pair, after which its error is reported as it is
DEEPEST = 16
FAILED = -1.0
SHARE, SEEN, HIDDEN_PART = 0, 1, 2
ROUGH = 10.0
DOUBT = 2.0  # error of a mean over the difference of its rules: kinks fool both at once, if rarely
LEAK = 1e3  # a share of so many grains is what rounding leaves of a hidden polygon

_G, _C = 0.5 / math.sqrt(3.0), 0.48
_W = 1.0 / (48.0 * _C * _C)
# Two rules of degree 3 on the unit square, rows (s, t, weight): product Gauss, and one that looks
# almost into the corners, where shadows that only graze a polygon are seen first.
INNER = np.array([[0.5 - _G, 0.5 - _G, 0.25], [0.5 - _G, 0.5 + _G, 0.25],
                  [0.5 + _G, 0.5 - _G, 0.25], [0.5 + _G, 0.5 + _G, 0.25]])  # fmt: skip
OUTER = np.array([[0.5 - _C, 0.5 - _C, _W], [0.5 - _C, 0.5 + _C, _W], [0.5 + _C, 0.5 - _C, _W],
                  [0.5 + _C, 0.5 + _C, _W], [0.5, 0.5, 1.0 - 4.0 * _W]])  # fmt: skip
TILT = 0.6  # weight of the first in their mean, in which errors of the fourth degree cancel


@njit(cache=True, nogil=True, error_model="numpy")
def _cell(quad, box, rule, normal, target, shadows, out):
    """Write visible and unoccluded exchange of a part of a polygon into out (2,); False: failed.

    ``box`` (s0, s1, t0, t1) is the part's place on the unit square; ``shadows`` holds the blockers,
    those active, the grain, space, and a point.
    """
    blockers, active, grain, shade, x = shadows
    out[0] = out[1] = 0.0
    size = (box[1] - box[0]) * (box[3] - box[2])
    for k in range(len(rule)):
        s = box[0] + rule[k, 0] * (box[1] - box[0])
        t = box[2] + rule[k, 1] * (box[3] - box[2])
        weight = size * rule[k, 2] * bilinear(quad, s, t, x)
        seen, touched = visible_factor(x, normal, target, blockers, active, grain, shade)
        if seen < 0.0:
            return False
        whole = seen
        if touched:
            whole = point_factor(x[0], x[1], x[2], normal[0], normal[1], normal[2], target)
        out[0] += weight * seen
        out[1] += weight * whole
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _root(polygon, first, quad):
    """Write the quadrilateral of a convex polygon's fan that begins with corner ``first``."""
    quad[0], quad[1], quad[2] = polygon[0], polygon[first], polygon[first + 1]
    quad[3] = polygon[min(first + 2, len(polygon) - 1)]


@njit(cache=True, nogil=True, error_model="numpy")
def _nearer_to_first(geometry, i, j, blockers, active):
    """Whether the active blockers lie nearer to polygon i than to polygon j."""
    total = 0.0
    for m in range(len(active)):
        corners = blockers.corners[active[m], : blockers.count[active[m]]]
        one = two = 1e300
        for k in range(len(corners)):
            one = min(one, sum_of_squares(corners[k], geometry.centroid[i]))
            two = min(two, sum_of_squares(corners[k], geometry.centroid[j]))
        total += math.sqrt(one) - math.sqrt(two)
    return total < 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _divide(box, part):
    """Return a quarter of a box."""
    s, t = 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3])
    s0, s1 = (box[0], s) if part % 2 == 0 else (s, box[1])
    t0, t1 = (box[2], t) if part < 2 else (t, box[3])
    return s0, s1, t0, t1


@njit(cache=True, nogil=True, error_model="numpy")
def _difference(measure, one, of_one, two, of_two):
    """Return by how much two answers, seen ``of`` unoccluded exchange, differ."""
    if measure == SEEN:
        return abs(one - two)
    if measure == HIDDEN_PART:
        return abs((of_one - one) - (of_two - two))
    return abs(one * of_two - two * of_one) / max(of_one, TINY)


@njit(cache=True, nogil=True, error_model="numpy")
def _adaptive(polygon, normal, target, tolerance, measure, shadows, cells, quad, out):
    """Integrate over a polygon, dividing cells; write visible, unoccluded, error into out (3,).

    A cell is accepted where both rules agree within ``tolerance``, a share of the exchange, times
    the root of its share of the polygon: kinks lie along lines, so the cells that they cross add up
    to about the tolerance. ``measure`` names what must agree: the visible SHARE, what is SEEN or
    what is HIDDEN. Returns False where a shadow failed.
    """
    seen = whole = error = allowed = 0.0
    visited = 0
    for first in range(1, len(polygon) - 1, 2):
        _root(polygon, first, quad)
        cells[0, 0], cells[0, 1], cells[0, 2], cells[0, 3] = 0.0, 1.0, 0.0, 1.0
        left = 1
        while left > 0:
            left -= 1
            box = (cells[left, 0], cells[left, 1], cells[left, 2], cells[left, 3])
            if not _cell(quad, box, INNER, normal, target, shadows, out):
                return False
            inner, of_inner = out[0], out[1]
            if not _cell(quad, box, OUTER, normal, target, shadows, out):
                return False
            visited += 1
            side = box[1] - box[0]
            apart = _difference(measure, inner, of_inner, out[0], out[1])
            if side == 1.0:
                allowed = tolerance * of_inner
            done = apart <= allowed * side or side < 0.5**DEEPEST or visited > MOST_CELLS
            if done or left + 4 > len(cells):
                seen += TILT * inner + (1.0 - TILT) * out[0]
                whole += TILT * of_inner + (1.0 - TILT) * out[1]
                error += DOUBT * apart
                continue
            for part in range(4):
                row = cells[left + part]
                row[0], row[1], row[2], row[3] = _divide(box, part)
            left += 4
    out[0], out[1], out[2] = seen, whole, error
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def partial_exchange(geometry, i, j, count_p, count_q, whole, tolerance, shadows, room):
    """Return the exchange of a pair past blockers, and its estimated error; FAILED where too many.

    Parameters
    ----------
    count_p, count_q : int
        Corners of the parts in front of each other, in room.p and room.q.
    whole : float
        The pair's unoccluded exchange, which the visible share multiplies.
    tolerance : float
        Of the share.
    shadows : (blockers, active, grain, shade, x)
    """
    p, q = room.p[:count_p], room.q[:count_q]
    n, o = geometry.normal[i], geometry.normal[j]
    out, quad, cells = room.found, room.quad, room.cells
    turned = _nearer_to_first(geometry, i, j, shadows[0], shadows[1])
    one, normal, two = (q, o, p) if turned else (p, n, q)
    if not _adaptive(one, normal, two, tolerance, SHARE, shadows, cells, quad, out):
        return FAILED, 0.0
    if out[1] <= 0.0:
        return whole, whole
    share, doubt = out[0] / out[1], out[2] / out[1]
    if share <= LEAK * shadows[2]:
        return 0.0, 0.0
    if abs(out[1] - whole) <= ROUGH * tolerance * whole or not 0.0 < share < 1.0:
        return whole * share, whole * doubt
    # too near for the rules: the part that is smaller must be right by itself
    measure = SEEN if share < 0.5 else HIDDEN_PART
    if not _adaptive(one, normal, two, tolerance, measure, shadows, cells, quad, out):
        return FAILED, 0.0
    value = out[0] if share < 0.5 else whole - (out[1] - out[0])
    return min(whole, max(0.0, value)), out[2]
