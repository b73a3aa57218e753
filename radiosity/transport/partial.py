"""Exchange of a pair that sees each other in part: the exact visible factor, integrated adaptively.

The factor from a point to the visible part of the other polygon (`shadow`) is continuous with kinks
where shadow edges meet corners. Rules of the third degree over either polygon give two answers with
different errors. The cell where they differ most is divided next, until the differences of all,
which have any sign, add up in quadrature to what was asked for.
"""

import math
from heapq import heappop, heappush

import numpy as np
from numba import njit

from radiosity.transport.blockers import AWAY, between
from radiosity.transport.cover import is_covered
from radiosity.transport.exchange import sum_of_squares
from radiosity.transport.polygon import TINY, area_of, bilinear, heights, point_factor
from radiosity.transport.shadow import hidden_share, kept_within, visible_factor
from radiosity.transport.shaft import beside, outline_planes

MOST_CELLS = 1 << 13  # of one pair, after which its error is reported as it is
FAILED = -1.0
SHARE, SEEN, HIDDEN_PART = 0, 1, 2
ROUGH = 0.1  # of the tolerance, what errors of the unoccluded exchange may add
CERTAIN = 3.0  # standard deviations
LEAK = 1e3  # a share of so many grains is what rounding leaves of a hidden polygon

_G, _C = 0.5 / math.sqrt(3.0), 0.48
_W = 1.0 / (48.0 * _C * _C)
# Two rules of degree 3 on the unit square, rows (s, t, weight): product Gauss, and one that looks
# almost into the corners, where shadows that only graze a polygon are seen first.
INNER = np.array([[0.5 - _G, 0.5 - _G, 0.25], [0.5 - _G, 0.5 + _G, 0.25],
                  [0.5 + _G, 0.5 - _G, 0.25], [0.5 + _G, 0.5 + _G, 0.25]])  # fmt: skip
OUTER = np.array([[0.5 - _C, 0.5 - _C, _W], [0.5 - _C, 0.5 + _C, _W], [0.5 + _C, 0.5 - _C, _W],
                  [0.5 + _C, 0.5 + _C, _W], [0.5, 0.5, 1.0 - 4.0 * _W]])  # fmt: skip
# A blocker of which no point sees more hidden may hide more between the points: where careful
# NOTICED, of the most that it may hide at all, otherwise MUCH, which is what rounding leaves. Where
# points see no more, a part of a polygon is looked at from the target too: where careful DIM.
NOTICED, MUCH, DIM = 0.1, 1e-12, 1e-2
BEND = 0.1  # of what middle and corners differ by, rules that agree by chance may still be wrong
GRAZE = 0.1  # of a cell in which a shadow could lie between the points of both rules
TILT = 0.6  # weight of the first in their mean, in which errors of the fourth degree cancel


@njit(cache=True, nogil=True, error_model="numpy")
def _cell(quad, box, rule, normal, target, shadows, out):
    """Write visible and unoccluded exchange of a part of a polygon into out (3,); False: failed.

    The third is how much of it the rule's last point sees differently from the others: with OUTER
    the middle from the corners. ``box`` (s0, s1, t0, t1) is the part's place on the unit square;
    ``shadows`` is a `Shadows`.
    """
    x = shadows.x
    out[0] = out[1] = before = of_before = 0.0
    size = (box[1] - box[0]) * (box[3] - box[2])
    for k in range(len(rule)):
        s = box[0] + rule[k, 0] * (box[1] - box[0])
        t = box[2] + rule[k, 1] * (box[3] - box[2])
        weight = size * rule[k, 2] * bilinear(quad, s, t, x)
        seen, touched = visible_factor(x, normal, target, shadows)
        if seen < 0.0:
            return False
        whole = seen
        if touched:
            whole = point_factor(x[0], x[1], x[2], normal[0], normal[1], normal[2], target)
        before, of_before = out[0], out[1]
        out[0] += weight * seen
        out[1] += weight * whole
    last, of_last = out[0] - before, out[1] - of_before
    out[2] = abs(last / max(of_last, TINY) - before / max(of_before, TINY)) * out[1]
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
def _difference(measure, one, of_one, two, of_two):
    """Return by how much two answers, seen ``of`` unoccluded exchange, differ."""
    if measure == SEEN:
        return abs(one - two)
    if measure == HIDDEN_PART:
        return abs((of_one - one) - (of_two - two))
    return abs(one * of_two - two * of_one) / max(of_one, TINY)


@njit(cache=True, nogil=True, error_model="numpy")
def _measured(polygon, part, normal, target, other, measure, shadows, quad, out):
    """Return a part of a polygon as it stands in the queue; ``side`` 0 where a shadow failed.

    ``part`` is (first, s, t, side): the fan's quadrilateral, its least coordinates and its side;
    ``other`` the normal of the target.
    """
    first, s, t, side = part
    _root(polygon, first, quad)
    box = (s, s + side, t, t + side)
    good = _cell(quad, box, INNER, normal, target, shadows, out)
    inner, of_inner = out[0], out[1]
    if not good or not _cell(quad, box, OUTER, normal, target, shadows, out):
        return 0.0, 0, 0.0, 0.0, 0.0, 0.0, 0.0
    apart = max(BEND * out[2], _difference(measure, inner, of_inner, out[0], out[1]))
    seen, whole = TILT * inner + (1.0 - TILT) * out[0], TILT * of_inner + (1.0 - TILT) * out[1]
    most = GRAZE * side * side * out[1]
    dim = DIM if shadows.careful else LEAK * shadows.grain
    dark = inner <= dim * of_inner and out[0] <= dim * out[1]
    if dark or apart < most:
        corners = np.empty((4, 3))
        _corners(quad, box, shadows.x, corners)
        if not dark:
            apart = max(
                apart, min(most, _overlooked(corners, normal, target, other, out[1], shadows))
            )
        elif not is_covered(corners, target, shadows.blockers, shadows.active, 4.0 * shadows.grain):
            back = _seen_back(corners, target, other, shadows, quad)
            if back < 0.0:
                return 0.0, 0, 0.0, 0.0, 0.0, 0.0, 0.0
            apart = max(apart, back - 2.0 * max(inner, out[0]), most if shadows.careful else 0.0)
    return -apart, first, s, t, side, seen, whole


@njit(cache=True, nogil=True, error_model="numpy")
def _corners(quad, box, x, corners):
    """Write the corners of a part of a quadrilateral; x is space for a point."""
    for k in range(4):
        s, t = box[1 if k in (1, 2) else 0], box[3 if k > 1 else 2]
        bilinear(quad, s, t, x)
        corners[k, 0], corners[k, 1], corners[k, 2] = x[0], x[1], x[2]


@njit(cache=True, nogil=True, error_model="numpy")
def _overlooked(corners, normal, target, other, whole, shadows):
    """Return the most that active blockers may take away of which no point saw much.

    That is of those that reach into the shaft of a part of a polygon and the target, and hide from
    no point more than MUCH or, where careful, NOTICED of the most that they may hide. ``whole`` is
    the unoccluded exchange.
    """
    blockers, active, slack = shadows.blockers, shadows.active, 4.0 * shadows.grain
    planes, total = np.empty((4 + len(target), 4)), 0.0
    bounds = planes[: outline_planes(corners, normal, target, other, slack, planes)]
    for m in range(len(active)):
        b = active[m]
        polygon = blockers.corners[b, : blockers.count[b]]
        if beside(polygon, bounds, slack):
            continue
        if between(polygon, blockers.normal[b], corners, target, slack) == AWAY:
            continue
        inside = kept_within(polygon, bounds, shadows.shade)
        most = _passage(inside, blockers.normal[b], corners, target)
        least = NOTICED * min(1.0, most / max(whole, TINY)) if shadows.careful else MUCH
        if not _hides_from_any(corners, target, polygon, blockers.normal[b], least, shadows):
            total += most
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _passage(polygon, normal, p, q):
    """Return about the most exchange between two polygons that can pass through a third."""
    if len(polygon) == 0:
        return 0.0
    return area_of(polygon) * min(_spread(polygon, normal, p), _spread(polygon, normal, q))


@njit(cache=True, nogil=True, error_model="numpy")
def _spread(polygon, normal, other):
    """Return about the most that a point of a polygon sees of another: cos area / (pi r^2)."""
    square = 0.0
    for c in range(3):
        low, high, other_low, other_high = 1e300, -1e300, 1e300, -1e300
        for k in range(len(polygon)):
            low, high = min(low, polygon[k, c]), max(high, polygon[k, c])
        for k in range(len(other)):
            other_low, other_high = min(other_low, other[k, c]), max(other_high, other[k, c])
        square += max(0.0, low - other_high, other_low - high) ** 2
    low, high = heights(other, polygon[0], normal)
    cosine = min(1.0, max(-low, high) / max(math.sqrt(square), TINY))
    return min(1.0, cosine * area_of(other) / max(math.pi * square, TINY))


@njit(cache=True, nogil=True, error_model="numpy")
def _hides_from_any(corners, target, polygon, normal, least, shadows):
    """Whether a blocker hides at least such a share from any point of both rules on a part."""
    x = shadows.x
    for rule in (OUTER, INNER):
        for k in range(len(rule)):
            bilinear(corners, rule[k, 0], rule[k, 1], x)
            if hidden_share(x, target, polygon, normal, shadows) > least:
                return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _seen_back(corners, target, other, shadows, quad):
    """Return the exchange that a few points of the target see of a part of a polygon.

    For a part of which no point sees much: a slit near to it, between its points, is open to all
    points of the target. Negative where a shadow failed.
    """
    total = 0.0
    for first in range(1, len(target) - 1, 2):
        _root(target, first, quad)
        for k in range(len(INNER)):
            weight = INNER[k, 2] * bilinear(quad, INNER[k, 0], INNER[k, 1], shadows.x)
            seen = visible_factor(shadows.x, other, corners, shadows)[0]
            if seen < 0.0:
                return seen
            total += weight * seen
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _adaptive(polygon, normal, target, other, tolerance, measure, shadows, quad, out):
    """Integrate over a polygon, dividing cells; write visible, unoccluded, error into out (3,).

    The cell with the largest error is divided next, until CERTAIN times the root of their squares
    and the largest once more are within ``tolerance``, a share of the exchange, or MOST_CELLS are
    reached. Once more, because kinks may fool the two rules at once, and where cells are few there
    is no other to make up for it. ``measure`` names what must agree: the visible SHARE, what is
    SEEN or what is HIDDEN. False where a shadow failed.
    """
    queue = [
        _measured(polygon, (1, 0.0, 0.0, 1.0), normal, target, other, measure, shadows, quad, out)
    ]
    for first in range(3, len(polygon) - 1, 2):
        part = (first, 0.0, 0.0, 1.0)
        heappush(
            queue, _measured(polygon, part, normal, target, other, measure, shadows, quad, out)
        )
    squares = whole = 0.0
    for cell in queue:
        squares, whole = squares + cell[0] ** 2, whole + cell[6]
        if cell[4] == 0.0:
            return False
    while _total(squares, queue) > tolerance * whole and len(queue) < MOST_CELLS:
        cell = heappop(queue)
        squares, whole = squares - cell[0] ** 2, whole - cell[6]
        side = 0.5 * cell[4]
        for k in range(4):
            part = (cell[1], cell[2] + (k % 2) * side, cell[3] + (k // 2) * side, side)
            quarter = _measured(polygon, part, normal, target, other, measure, shadows, quad, out)
            if quarter[4] == 0.0:
                return False
            heappush(queue, quarter)
            squares, whole = squares + quarter[0] ** 2, whole + quarter[6]
    out[0] = out[1] = squares = 0.0
    for cell in queue:
        out[0] += cell[5]
        out[1] += cell[6]
        squares += cell[0] ** 2
    out[2] = _total(squares, queue)
    return True


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _total(squares, queue):
    """Return the error of all cells, whose own are the first entries, negative."""
    return CERTAIN * math.sqrt(max(0.0, squares)) - queue[0][0]


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
    shadows : Shadows
    """
    p, q = room.p[:count_p], room.q[:count_q]
    n, o = geometry.normal[i], geometry.normal[j]
    out, quad = room.found, room.quad
    turned = _nearer_to_first(geometry, i, j, shadows.blockers, shadows.active)
    one, normal, two, other = (q, o, p, n) if turned else (p, n, q, o)
    if not _adaptive(one, normal, two, other, (1.0 - ROUGH) * tolerance, SHARE, shadows, quad, out):
        return FAILED, 0.0
    if out[1] <= 0.0:
        return whole, whole
    share, doubt = out[0] / out[1], out[2] / out[1]
    if share <= LEAK * shadows.grain:
        return 0.0, whole * (share + doubt)
    blur = abs(out[1] - whole) * min(share, 1.0 - share)
    if blur <= ROUGH * tolerance * whole or not 0.0 < share < 1.0:
        return whole * share, whole * doubt + max(0.0, blur)
    # too near for the rules: the part that is smaller must be right by itself
    measure = SEEN if share < 0.5 else HIDDEN_PART
    if not _adaptive(one, normal, two, other, tolerance, measure, shadows, quad, out):
        return FAILED, 0.0
    value = out[0] if share < 0.5 else whole - (out[1] - out[0])
    return min(whole, max(0.0, value)), out[2]
