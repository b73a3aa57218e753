"""The exact part of a polygon that is seen from a point past convex blockers, compiled.

From a point x a blocker hides what lies beyond its plane and inside the cone of planes through x
and its edges. A polygon is cut along these planes; the parts that lie inside all of them are
dropped, and Lambert's sum (E2) over those left is the visible factor.
"""

from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.transport.blockers import MOST
from radiosity.transport.polygon import add_moment, area_of, point_factor

PARTS = 256  # of a polygon that wait to be cut
CORNERS = 24
PLANES = 9  # of a blocker: its own and one an edge
OVERFLOW = -1.0

Shade = namedtuple("Shade", "planes count parts corners next inner heights")
Shade.__doc__ = "Space for one thread: planes of blockers seen from a point, parts of a polygon."

Shadows = namedtuple("Shadows", "blockers active grain shade x careful")
Shadows.__doc__ = """What hides a pair of polygons, and space to cut it out.

active (m,) int64: of the blockers; grain: how far rounding may have moved a corner; x (3,): space
for a point; careful: whether to look harder for what lies between the points of a rule.
"""


def make_shade() -> Shade:
    """Return space for the shadows on one polygon at a time."""
    return Shade(
        np.empty((MOST, PLANES, 5)), np.empty(MOST, np.int64), np.empty((PARTS, CORNERS, 3)),
        np.empty(PARTS, np.int64), np.empty(PARTS, np.int64), np.empty((CORNERS, 3)),
        np.empty(CORNERS),
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _cone(x, corners, normal, grain, planes):
    """Write the planes that bound a blocker's shadow from x; return their count, 0 if seen edge-on.

    A plane is (a, b, c, d, slack): a point y is inside where a y0 + b y1 + c y2 + d > 0, and on the
    plane within the slack that rounding of the corners causes.
    """
    n0, n1, n2 = normal[0], normal[1], normal[2]
    level = n0 * corners[0, 0] + n1 * corners[0, 1] + n2 * corners[0, 2]
    height = n0 * x[0] + n1 * x[1] + n2 * x[2] - level
    if abs(height) <= 8.0 * grain:
        return 0
    side = -1.0 if height > 0.0 else 1.0
    planes[0, 0], planes[0, 1], planes[0, 2] = side * n0, side * n1, side * n2
    planes[0, 3], planes[0, 4] = -side * level, 8.0 * grain
    last = len(corners) - 1
    ax, ay, az = corners[last, 0] - x[0], corners[last, 1] - x[1], corners[last, 2] - x[2]
    for k in range(len(corners)):
        bx, by, bz = corners[k, 0] - x[0], corners[k, 1] - x[1], corners[k, 2] - x[2]
        px, py, pz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        px, py, pz = side * px, side * py, side * pz
        planes[k + 1, 0], planes[k + 1, 1], planes[k + 1, 2] = px, py, pz
        planes[k + 1, 3] = -(px * x[0] + py * x[1] + pz * x[2])
        reach = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
        planes[k + 1, 4] = 4.0 * grain * reach
        ax, ay, az = bx, by, bz
    return len(corners) + 1


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _misses(part, planes):
    """Whether a part of the polygon lies outside one of the planes."""
    for m in range(len(planes)):
        out = True
        for k in range(len(part)):
            w = planes[m, 0] * part[k, 0] + planes[m, 1] * part[k, 1] + planes[m, 2] * part[k, 2]
            if w + planes[m, 3] > planes[m, 4]:
                out = False
                break
        if out:
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _copy(x, k, out, m):
    out[m, 0], out[m, 1], out[m, 2] = x[k, 0], x[k, 1], x[k, 2]


@njit(cache=True, nogil=True, error_model="numpy")
def _split(part, count, plane, outer, inner, h):
    """Cut a part along a plane: keep the inside, write the rest to outer; return both counts."""
    any_in = any_out = False
    for k in range(count):
        h[k] = plane[0] * part[k, 0] + plane[1] * part[k, 1] + plane[2] * part[k, 2] + plane[3]
        any_in = any_in or h[k] > plane[4]
        any_out = any_out or h[k] < -plane[4]
    if not any_out:
        return count, 0
    if not any_in:
        for k in range(count):
            _copy(part, k, outer, k)
        return 0, count
    kept = cut = 0
    for k in range(count):
        m = k + 1 if k + 1 < count else 0
        if h[k] >= -plane[4]:
            _copy(part, k, inner, kept)
            kept += 1
        if h[k] <= plane[4]:
            _copy(part, k, outer, cut)
            cut += 1
        if (h[k] > plane[4] and h[m] < -plane[4]) or (h[k] < -plane[4] and h[m] > plane[4]):
            t = h[k] / (h[k] - h[m])
            for c in range(3):
                inner[kept, c] = part[k, c] + t * (part[m, c] - part[k, c])
            _copy(inner, kept, outer, cut)
            kept += 1
            cut += 1
    for k in range(kept):
        _copy(inner, k, part, k)
    return kept, cut


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _cut_out(shade, part, planes, after, waiting):
    """Take the shadow of one blocker out of a part; what is left waits for the blockers after it.

    Returns how many parts wait then, or OVERFLOW.
    """
    count = shade.corners[part]
    inside = shade.parts[part]
    for m in range(len(planes)):
        if waiting >= PARTS or count > CORNERS - 2:
            return OVERFLOW
        count, cut = _split(
            inside, count, planes[m], shade.parts[waiting], shade.inner, shade.heights
        )
        if cut > 2:
            shade.corners[waiting], shade.next[waiting] = cut, after
            waiting += 1
        if count < 3:
            break
    return waiting


@njit(cache=True, nogil=True, error_model="numpy")
def _kept(polygon, planes, shade):
    """Return the corners of a polygon's part inside planes (k, 5), see `_cone`; none if none is.

    A view of ``shade``, good until the next cut.
    """
    part, count = shade.parts[0], len(polygon)
    for k in range(count):
        _copy(polygon, k, part, k)
    for m in range(len(planes)):
        if count > CORNERS - 2:
            break
        count, _ = _split(part, count, planes[m], shade.parts[1], shade.inner, shade.heights)
        if count < 3:
            return part[:0]
    return part[:count]


@njit(cache=True, nogil=True, error_model="numpy")
def kept_within(polygon, planes, shade):
    """Return the corners of a polygon's part in a shaft, by its planes (k, 4); see `_kept`."""
    inward = np.zeros((len(planes), 5))
    inward[:, :3], inward[:, 3] = -planes[:, :3], planes[:, 3]
    return _kept(polygon, inward, shade)


@njit(cache=True, nogil=True, error_model="numpy")
def hidden_share(x, target, corners, normal, shadows):
    """Return the share of a polygon's area that a blocker hides from a point."""
    shade = shadows.shade
    planes = shade.planes[0, : _cone(x, corners, normal, shadows.grain, shade.planes[0])]
    if len(planes) == 0 or _misses(target, planes):
        return 0.0
    part = _kept(target, planes, shade)
    return area_of(part) / area_of(target) if len(part) > 0 else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def visible_factor(x, normal, target, shadows):
    """Factor from a surface element to the parts of a polygon that the active blockers leave.

    Parameters
    ----------
    x, normal : (3,)
    target : (k, 3)
        Convex, wholly in front of the element, facing it.
    shadows : Shadows

    Returns
    -------
    seen : float
        Exactly 0 where nothing is seen; OVERFLOW where too many parts arise.
    touched : bool
        Whether any blocker takes something away.
    """
    prepare_cones(x, shadows)
    return factor_past_cones(x, normal, target, normal, shadows, shadows.shade.heights[:0])


@njit(cache=True, nogil=True, error_model="numpy")
def prepare_cones(x, shadows):
    """Write the planes of all active blockers' shadows from x into ``shadows.shade``."""
    blockers, active, shade = shadows.blockers, shadows.active, shadows.shade
    for m in range(len(active)):
        b = active[m]
        corners = blockers.corners[b, : blockers.count[b]]
        shade.count[m] = _cone(x, corners, blockers.normal[b], shadows.grain, shade.planes[m])


@njit(cache=True, nogil=True, error_model="numpy")
def misses_all(target, planes, count):
    """Whether no prepared cone (m, PLANES, 5) takes anything away from a polygon.

    ``planes`` and ``count`` (m,) are what `prepare_cones` wrote.
    """
    for m in range(len(count)):
        if count[m] != 0 and not _misses(target, planes[m, : count[m]]):
            return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def factor_past_cones(x, normal, target, facing, shadows, moment):
    """Return what `visible_factor` does where the cones of x are prepared: once for many targets.

    The first moment of what is seen is added to ``moment``, see `add_moment`, unless that has
    length 0; ``facing`` is the target's unit normal.
    """
    active, shade = shadows.active, shadows.shade
    for k in range(len(target)):
        _copy(target, k, shade.parts[0], k)
    shade.corners[0], shade.next[0] = len(target), 0
    waiting, total, touched = 1, 0.0, False
    while waiting > 0:
        top = waiting - 1
        part = shade.parts[top, : shade.corners[top]]
        m = shade.next[top]
        while m < len(active) and (
            shade.count[m] == 0 or _misses(part, shade.planes[m, : shade.count[m]])
        ):
            m += 1
        if m == len(active):
            total += point_factor(x[0], x[1], x[2], normal[0], normal[1], normal[2], part)
            if len(moment) > 0:
                add_moment(x, normal, part, facing, moment)
            waiting -= 1
            continue
        touched = True
        # the part shrinks in place at `top`; what is cut off is put above it, then moved down
        left = _cut_out(shade, top, shade.planes[m, : shade.count[m]], m + 1, waiting)
        if left < 0:
            return OVERFLOW, True
        last = int(left) - 1
        if last > top:
            for k in range(shade.corners[last]):
                _copy(shade.parts[last], k, shade.parts[top], k)
            shade.corners[top], shade.next[top] = shade.corners[last], shade.next[last]
        waiting = max(last, top)
    return total, touched
