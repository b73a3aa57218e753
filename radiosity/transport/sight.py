"""Patches as points see them, compiled: exact visible factors and first moments, a point at a time.

Each run of patches is looked at at once: what no blocker hides and is far gets its Gauss rules at
once too, the rest exact sums over what the blockers leave.
"""

import math
from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.transport.blockers import HIDDEN, MOST, TOO_MANY, find_blockers
from radiosity.transport.borrow import borrowed
from radiosity.transport.exchange import CORNERS, FEWEST, points_needed
from radiosity.transport.exchange import MOST as LARGEST
from radiosity.transport.pairs import UNSEEN, reach_of
from radiosity.transport.polygon import add_moment, clip, heights, point_factor
from radiosity.transport.runs import HEIGHT, HIGH, LOW, RUN, SQUARE, look_along, rules
from radiosity.transport.shadow import (
    Shadows,
    factor_past_cones,
    make_shade,
    misses_all,
    prepare_cones,
)

HORIZON = 1e-14  # height over the horizon, in ray coordinates, below which nothing is seen
EXACT = 1e-12  # a tolerance below which no rule takes the place of an exact sum

Space = namedtuple(
    "Space", "shade walk found own planes box point x clipped moment result table product needed"
)
Space.__doc__ = "Space for one thread, see `make_shade`, `find_blockers`, `rules` and `_exactly`."

Sight = namedtuple("Sight", "geometry columns across boxes blockers free tolerance")
Sight.__doc__ = """Patches as points see them, in ray coordinates.

across (2, 3, n): the axes of their elements; boxes (2, runs, 3): lowest and highest corners of each
RUN of patches; free (bodies + 1,): see `find_blockers`; tolerance (n,): relative, of the factor to
a far patch.
"""


def make_space() -> Space:
    """Return space for one thread."""
    return Space(
        make_shade(), np.empty(64, np.int64), np.empty(MOST, np.int64), np.empty(MOST, np.int64),
        np.empty((7, 4)), np.empty((8, 3)), np.empty((1, 3)), np.empty(3), np.empty((CORNERS, 3)),
        np.empty(3), np.empty(3), np.empty((4, RUN)), np.empty((LARGEST + 1, 3, RUN)),
        np.empty(RUN, np.int64),
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def weigh(points, normals, lift, sight, space, weights, left):
    """Fill weights (k, width n) with exact factors and moments; mark in left what is for rays.

    Parameters
    ----------
    points, normals : (k, 3)
        Ray coordinates, unit vectors.
    lift : float
        By how much points look past blockers from over their place.
    left : (k, n) bool
        Where it is set, weights hold what arrives without blockers.
    """
    sight, space = borrowed((sight, space))
    points, normals, weights = borrowed((points, normals, weights))
    patches, x = len(sight.geometry.area), space.x
    table, product, needed = space.table, space.product, space.needed
    for p in range(len(points)):
        n = normals[p]
        for c in range(3):
            x[c], space.point[0, c] = points[p, c], points[p, c] + lift * n[c]
        for first in range(0, patches, RUN):
            count = min(RUN, patches - first)
            _corners(sight.boxes[0, first // RUN], sight.boxes[1, first // RUN], space.box)
            if heights(space.box, x, n)[1] <= HORIZON:
                continue
            look_along(sight.columns, x, n, first, count, table)
            if not _points_of_run(sight.geometry, first, count, sight.tolerance, table, needed):
                continue
            between = _between(n, first, sight, space)
            if between == HIDDEN:
                continue
            for m in range(FEWEST, LARGEST + 1):
                low, high = reach_of(needed, count, m)
                if high > low:
                    rules(sight.columns, sight.across, x, n, first + low, high - low, m,
                          product[m, :, low:high])  # fmt: skip
            _take(x, n, p, first, count, between, sight, space, weights, left)


@njit(cache=True, nogil=True, error_model="numpy")
def _points_of_run(geometry, first, count, tolerance, table, needed):
    """Write the points a direction that each patch's rule needs; whether any is seen at all.

    UNSEEN where patch and point do not face each other, 0 where the sum must be exact.
    """
    some = False
    for k in range(count):
        j = first + k
        needed[k] = UNSEEN
        if table[HEIGHT, k] <= _slack(geometry, j) or table[HIGH, k] <= HORIZON:
            continue
        needed[k], some = 0, True
        if table[LOW, k] >= -HORIZON and tolerance[j] > EXACT:
            far = math.sqrt(table[SQUARE, k]) / geometry.radius[j]
            needed[k] = points_needed(far, geometry.bent[j], tolerance[j])
    return some


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _slack(geometry, j):
    return 1e-12 * geometry.radius[j] + 4.0 * geometry.grain[j]


@njit(cache=True, nogil=True, error_model="numpy")
def _corners(low, high, box):
    for m in range(8):
        for c in range(3):
            box[m, c] = high[c] if (m >> c) & 1 else low[c]


@njit(cache=True, nogil=True, error_model="numpy")
def _hull_planes(x, normal, low, high, planes):
    """Write the planes of the box about a point and a box, and the point's horizon."""
    planes[:] = 0.0
    for c in range(3):
        planes[2 * c, c], planes[2 * c, 3] = 1.0, max(x[c], high[c])
        planes[2 * c + 1, c], planes[2 * c + 1, 3] = -1.0, -min(x[c], low[c])
        planes[6, c] = -normal[c]
    planes[6, 3] = -(normal[0] * x[0] + normal[1] * x[1] + normal[2] * x[2])


@njit(cache=True, nogil=True, error_model="numpy")
def _between(n, first, sight, space):
    """Find what comes between a point and a run of patches, and prepare its cones.

    Returns how many blockers do, HIDDEN or TOO_MANY, see `find_blockers`.
    """
    if len(sight.blockers.count) == 0:
        return 0
    low, high = sight.boxes[0, first // RUN], sight.boxes[1, first // RUN]
    slack = _slack(sight.geometry, first)
    _hull_planes(space.point[0], n, low, high, space.planes)
    count = find_blockers(
        sight.blockers, sight.free, space.point, space.box, space.planes, 0.0, slack,
        space.walk, space.found,
    )  # fmt: skip
    if count > 0:
        prepare_cones(space.point[0], _shadows(sight.blockers, space.found[:count], slack, space))
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _shadows(blockers, active, slack, space):
    grain = slack
    for k in range(len(active)):
        grain = max(grain, blockers.grain[active[k]])
    return Shadows(blockers, active, grain, space.shade, space.point[0], False)


@njit(cache=True, nogil=True, error_model="numpy")
def _take(x, n, p, first, count, between, sight, space, weights, left):
    """Write the weights of a run's patches: what rules found where nothing hides, exact sums else.

    ``between`` is what `_between` found.
    """
    geometry, patches, wide = sight.geometry, len(sight.geometry.area), weights.shape[1]
    planes, cones = space.shade.planes[: max(0, between)], space.shade.count[: max(0, between)]
    for k in range(count):
        m, j = space.needed[k], first + k
        if m == UNSEEN:
            continue
        if m > 0 and between >= 0 and misses_all(geometry.vertices[j], planes, cones):
            for a in range(0, wide, patches):
                weights[p, a + j] = space.product[m, a // patches, k]
            continue
        if not _exactly(x, n, j, space.table[HEIGHT, k], between, sight, space):
            left[p, j] = True
        for a in range(0, wide, patches):
            weights[p, a + j] = space.result[a // patches]


@njit(cache=True, nogil=True, error_model="numpy")
def _exactly(x, n, j, height, between, sight, space):
    """Write factor and moments of patch j into space.result; False where rays must tell."""
    geometry, moment, result = sight.geometry, space.moment, space.result
    moment[:], result[:] = 0.0, 0.0
    facing, slack, clipped = geometry.normal[j], _slack(geometry, j), space.clipped
    corners = clip(geometry.vertices[j], x, n, HORIZON, clipped)
    polygon, factor, active = clipped[:corners], -1.0, space.found[: max(0, between)]
    if corners < 3:
        return True
    if between == TOO_MANY:
        between = _alone(n, polygon, slack, sight, space)
        if between == HIDDEN:
            return True
        active = space.own[: max(0, between)]
    if between > 0:
        shadows = _shadows(sight.blockers, active, slack, space)
        factor, _ = factor_past_cones(x, n, polygon, facing, shadows, moment)
    exact = between == 0 or factor >= 0.0
    if factor < 0.0:
        moment[:] = 0.0
        factor = point_factor(x[0], x[1], x[2], n[0], n[1], n[2], polygon)
        add_moment(x, n, polygon, facing, moment)
    result[0] = factor
    for a in range(2):
        for c in range(3):
            foot = x[c] - height * facing[c] - geometry.centroid[j, c]
            result[a + 1] += sight.across[a, c, j] * (moment[c] + factor * foot)
    return exact


@njit(cache=True, nogil=True, error_model="numpy")
def _alone(n, polygon, slack, sight, space):
    """Do as `_between` for one patch of a run that has too many blockers."""
    low, high = space.box[0], space.box[7]
    for c in range(3):
        low[c], high[c] = polygon[:, c].min(), polygon[:, c].max()
    _hull_planes(space.point[0], n, low, high, space.planes)
    count = find_blockers(
        sight.blockers, sight.free, space.point, polygon, space.planes, 0.0, -slack,
        space.walk, space.own,
    )  # fmt: skip
    if count > 0:
        prepare_cones(space.point[0], _shadows(sight.blockers, space.own[:count], slack, space))
    return count
