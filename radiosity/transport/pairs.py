"""Pairs of polygons a row at a time, compiled: hidden, exact, cut by few blockers, or for rays.

Each run of a row is screened at once; what no blocker can come between gets its product rules at
once too, the rest one by one.
"""

from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.transport.blockers import (
    HIDDEN,
    MOST,
    TOO_MANY,
    drop_beside,
    find_blockers,
    keep_between,
    prepare_lines,
)
from radiosity.transport.borrow import borrowed
from radiosity.transport.exchange import (
    CORNERS,
    FEWEST,
    GRAZING,
    exchange_area,
    grain_of,
    least_certain,
    least_height,
    load_fronts,
    make_room,
    points_needed,
)
from radiosity.transport.exchange import MOST as LARGEST
from radiosity.transport.near import FLAT, PARTLY, find_near, nearest
from radiosity.transport.partial import FAILED, partial_exchange
from radiosity.transport.screen import (
    HIGH_I,
    HIGH_J,
    LOW_I,
    LOW_J,
    RUN,
    SQUARE,
    products,
    screen,
)
from radiosity.transport.shadow import Shadows, make_shade
from radiosity.transport.shaft import front_planes, half_shaft_planes, outline_planes, shaft_planes
from radiosity.transport.visibility import LIFT

UNSEEN = -1
# Marks in the errors what is left to rays: RAYS, less the share that blockers hide which lie so
# flat on either end that rays start beyond them.
RAYS = -1.0
# More blockers in a shaft than this are left to rays where a share need be no better than this and
# no blocker comes so near to either end that a ray's origin would be lifted past it.
FEWER, COARSE, NEAR = 4, 7e-3, 4.0 * LIFT


Barriers = namedtuple("Barriers", "blockers free limit careful")
Barriers.__doc__ = """What can hide pairs.

free (n, bodies + 1) bool: see `Visibility.free_sides`; limit (n,): how many blockers are cut out
exactly where rays would do, FEWER or MOST; careful: see `Shadows`.
"""
Spaces = namedtuple("Spaces", "room shade walk run lines sides planes")
Spaces.__doc__ = "Space for one thread: see `make_room`, `make_shade`, `find_blockers`."


def make_spaces() -> Spaces:
    """Return space for one thread."""
    return Spaces(
        make_room(), make_shade(), np.empty(64, np.int64), np.empty(MOST, np.int64),
        np.empty((MOST, 8, 4, 4)), np.empty(MOST), np.empty((2 + 2 * CORNERS, 4)),
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def look_near(geometry, blockers):
    """Return (n,) how near blockers come to each polygon, so that rays could start beyond them."""
    geometry, blockers = borrowed((geometry, blockers))
    walk, planes = np.empty(64, np.int64), np.empty((6, 4))
    how = np.empty(len(geometry.area), np.int64)
    for i in range(len(how)):
        how[i] = nearest(blockers, geometry, i, NEAR, planes, walk)
    return how


@njit(cache=True, nogil=True, error_model="numpy")
def fill_rows(first, stop, live, geometry, columns, barriers, asked, spaces, unit, exchange, error):
    """Fill exchange[i, j] and error[i, j], in ``unit``, for first <= i < stop and j > i."""
    n = len(live)
    live, geometry, columns, barriers, spaces = borrowed(
        (live, geometry, columns, barriers, spaces)
    )
    table, product, box = np.empty((5, RUN)), np.zeros((LARGEST + 1, RUN)), np.empty((8, 3))
    needed, counts = np.empty(RUN, np.int64), np.zeros(RUN, np.int64)
    found = np.empty((RUN, MOST), np.int64)
    for i in range(first, stop):
        if not live[i]:
            continue
        for start in range(i + 1, n, RUN):
            count = min(RUN, n - start)
            screen(columns, geometry, i, start, count, table)
            if not _points_of_run(geometry, i, start, count, live, asked[0], table, needed):
                continue
            counts[:] = 0
            if len(barriers.blockers.count) > 0 and _block_run(
                geometry, i, start, count, barriers, asked, needed, counts, found, box, spaces
            ):
                continue
            for points in range(FEWEST, LARGEST + 1):
                low, high = reach_of(needed, count, points)
                if high > low:
                    out = product[points, low:high]
                    products(columns, geometry, i, start + low, high - low, points, out)
            for k in range(count):
                if needed[k] < 0:
                    continue
                j = start + k
                value = max(0.0, product[needed[k], k])
                least = least_certain(geometry, i, j, table[SQUARE, k])
                doubt = asked[0] * max(value, least)
                if needed[k] == 0:
                    value, doubt = exchange_area(geometry, i, j, asked[0], spaces.room)
                if counts[k] != 0 and value > 0.0:
                    value, doubt = _past_blockers(
                        geometry, i, j, value, doubt, barriers, found[k], counts[k], asked, spaces
                    )
                exchange[i, j], error[i, j] = unit * value, doubt if doubt < 0.0 else unit * doubt


@njit(cache=True, nogil=True, error_model="numpy")
def _points_of_run(geometry, i, start, count, live, tolerance, table, needed):
    """Write the points a direction that each pair's product rule needs; whether there is any pair.

    UNSEEN where a pair does not face each other, 0 where no vectorised rule will do.
    """
    ri, some = geometry.radius[i], False
    for k in range(count):
        j = start + k
        rj = geometry.radius[j]
        slack = least_height(geometry, i, j)
        needed[k] = UNSEEN
        if not live[j] or table[HIGH_I, k] <= slack or table[HIGH_J, k] <= slack:
            continue
        needed[k], some = 0, True
        if table[LOW_I, k] >= -slack and table[LOW_J, k] >= -slack:
            square = table[SQUARE, k]
            cosines = (table[LOW_I, k] + table[HIGH_I, k]) * (table[LOW_J, k] + table[HIGH_J, k])
            limit = 0.5 * tolerance * max(GRAZING, cosines / (4.0 * square))
            bent = geometry.bent[i] or geometry.bent[j]
            points = points_needed((square**0.5 - max(ri, rj)) / max(ri, rj), bent, limit)
            needed[k] = points if points <= LARGEST else 0
    return some


@njit(cache=True, nogil=True, error_model="numpy")
def reach_of(needed, count, points):
    """Return the range of a run that holds all pairs which need so many points."""
    low, high = count, 0
    for k in range(count):
        if needed[k] == points:
            low, high = min(low, k), k + 1
    return (low, high) if high > low else (0, 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _box_about(geometry, start, count, needed, box):
    """Write the corners of the box about the pairs' second polygons."""
    low, high = np.full(3, 1e300), np.full(3, -1e300)
    for k in range(count):
        if needed[k] != UNSEEN:
            for v in range(4):
                for c in range(3):
                    x = geometry.vertices[start + k, v, c]
                    low[c], high[c] = min(low[c], x), max(high[c], x)
    for c in range(3):
        for m in range(8):
            box[m, c] = high[c] if (m >> c) & 1 else low[c]


@njit(cache=True, nogil=True, error_model="numpy")
def _block_run(
    geometry, i, start, count, barriers, asked, needed, counts, found, box, spaces
):  # fmt: skip
    """Find the blockers of each pair of a run; whether all pairs are hidden.

    First those between polygon i and a box about all that face it, then those of each pair. Hidden
    pairs become UNSEEN.
    """
    _box_about(geometry, start, count, needed, box)
    blockers, free = barriers.blockers, barriers.free[i]
    p, planes, walk, run = geometry.vertices[i], spaces.planes, spaces.walk, spaces.run
    slack = 4.0 * geometry.grain[i]
    bounds = half_shaft_planes(geometry, i, box, slack, planes)
    some = find_blockers(blockers, free, p, box, planes[:bounds], slack, slack, walk, run)
    if some == HIDDEN:
        return True
    if some > 0:
        prepare_lines(blockers, run[:some], p, slack, spaces.lines, spaces.sides)
    for k in range(count):
        if needed[k] == UNSEEN or some == 0:
            continue
        j = start + k
        q, slack = geometry.vertices[j], 4.0 * grain_of(geometry, i, j)
        if some == TOO_MANY:
            bounds = shaft_planes(geometry, i, j, slack, planes)
            most = max(barriers.limit[i], barriers.limit[j]) if asked[1] >= COARSE else MOST
            counts[k] = find_blockers(
                blockers, free, p, q, planes[:bounds], slack, -slack, walk, found[k, :most]
            )
        else:
            counts[k] = keep_between(
                blockers, run[:some], spaces.lines, spaces.sides, geometry.centroid[j],
                geometry.normal[j], q, slack, found[k],
            )  # fmt: skip
            if counts[k] > 0:
                bounds = shaft_planes(geometry, i, j, slack, planes)
                counts[k] = drop_beside(blockers, found[k], counts[k], planes[:bounds], slack)
        if counts[k] == HIDDEN:
            needed[k] = UNSEEN
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _past_blockers(geometry, i, j, value, error, barriers, found, count, asked, spaces):
    """Return what blockers leave of an exchange, and its error; RAYS or below where rays must tell.

    ``found`` are those that no plane about the whole polygons keeps out. Where they are too many,
    those that lie flat on either end may still hide all.
    """
    near = max(barriers.limit[i], barriers.limit[j]) == MOST
    many = count == TOO_MANY
    if many and not near:
        return value, RAYS
    count_p, count_q, cut = load_fronts(geometry, i, j, spaces.room)
    if count_p == 0:
        return 0.0, 0.0
    blockers, grain = barriers.blockers, grain_of(geometry, i, j)
    slack, planes = 4.0 * grain, spaces.planes[:0]
    if many or cut:
        planes = _shaft_of_fronts(geometry, i, j, count_p, count_q, slack, spaces)
    if many:
        count = find_near(blockers, geometry, i, j, planes, slack, NEAR, PARTLY, spaces.walk, found)
    elif cut:
        count = drop_beside(blockers, found, count, planes, slack)
    if count == 0:
        return value, RAYS if many else error
    tolerance = max(asked[1], asked[2] * min(geometry.area[i], geometry.area[j]) / value)
    if tolerance >= COARSE and count > FEWER and not near:
        return value, RAYS
    seen, doubt = FAILED, 0.0
    if count > 0:
        shadows = _shadows_of(barriers, found[:count], grain, spaces)
        seen, doubt = partial_exchange(
            geometry, i, j, count_p, count_q, value, tolerance, shadows, spaces.room
        )
    if seen < 0.0 or (many and seen > 0.0):
        if len(planes) == 0:
            planes = _shaft_of_fronts(geometry, i, j, count_p, count_q, slack, spaces)
        flat = find_near(blockers, geometry, i, j, planes, slack, NEAR, FLAT, spaces.walk, found)
        hidden = 1.0 if seen < 0.0 else min(1.0, max(0.0, 1.0 - (seen - doubt) / value))
        return value, RAYS if flat == 0 else RAYS - hidden
    return seen, doubt + error if seen > 0.0 or doubt > 0.0 else 0.0  # hidden for certain


@njit(cache=True, nogil=True, error_model="numpy")
def _shaft_of_fronts(geometry, i, j, count_p, count_q, slack, spaces):
    """Return the planes about the parts of two polygons in front of each other, in the room."""
    p, q, planes = spaces.room.p[:count_p], spaces.room.q[:count_q], spaces.planes
    count = outline_planes(p, geometry.normal[i], q, geometry.normal[j], slack, planes)
    return planes[: front_planes(geometry, i, j, planes, count)]


@njit(cache=True, nogil=True, error_model="numpy")
def _shadows_of(barriers, active, grain, spaces):
    """Return the shadows of active blockers on a pair whose corners rounding moved by ``grain``."""
    blockers = barriers.blockers
    for k in range(len(active)):
        grain = max(grain, blockers.grain[active[k]])
    return Shadows(blockers, active, grain, spaces.shade, spaces.room.x, barriers.careful)
