"""Blockers so near to the front of a polygon that rays from it would start beyond them."""

import math

from numba import njit

from radiosity.transport.blockers import TOO_MANY, first_blocker, next_blocker
from radiosity.transport.polygon import heights

APART, PARTLY, FLAT = 0, 1, 2
# What lies flat on a polygon: least cosine to it, and in reaches the least height of the highest
# point over it (lower is contact or rounding), and the largest.
PARALLEL, FLUSH, SHALLOW = 0.9, 0.025, 25.0


@njit(cache=True, nogil=True, error_model="numpy")
def find_near(blockers, geometry, i, j, planes, slack, reach, least, walk, found):
    """Write the blockers in a shaft that are near to polygon i or j into found.

    ``least`` is PARTLY or FLAT, see `nearest`.

    Returns how many; more than found holds are TOO_MANY.
    """
    count, b = 0, first_blocker(blockers, planes, slack, walk)
    while b >= 0:
        one = _nearness(blockers, b, geometry, i, reach)
        if max(one, _nearness(blockers, b, geometry, j, reach)) >= least:
            if count == len(found):
                return TOO_MANY
            found[count] = b
            count += 1
        b = next_blocker(blockers, planes, slack, walk)
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _nearness(blockers, b, geometry, i, reach):
    """Return how near one blocker comes to the front of polygon i, see `nearest`."""
    corners, n, m = blockers.corners[b, : blockers.count[b]], geometry.normal[i], blockers.normal[b]
    low, high = heights(corners, geometry.centroid[i], n)
    if low > reach or high <= 0.0:
        return APART
    cosine, above = n[0] * m[0] + n[1] * m[1] + n[2] * m[2], 0.0
    if abs(cosine) <= PARALLEL:
        return PARTLY
    for c in range(3):
        above += m[c] * (corners[0, c] - geometry.centroid[i, c]) / cosine
    rise = geometry.radius[i] * math.sqrt(max(0.0, 1.0 - cosine * cosine)) / abs(cosine)
    low, high = max(low, above - rise), min(high, above + rise)  # over the polygon
    return FLAT if low <= reach and FLUSH * reach < high <= SHALLOW * reach else PARTLY


@njit(cache=True, nogil=True, error_model="numpy")
def nearest(blockers, geometry, i, reach, planes, walk):
    """Return how near blockers come to the front of polygon i, over the box about it.

    APART where none comes within ``reach`` of its plane, FLAT where one does of which so much lies
    so near that it matters, PARTLY otherwise. ``planes`` (6, 4) and ``walk`` (64,) are space.
    """
    for c in range(3):
        for side in range(2):
            plane, sign = planes[2 * c + side], 2.0 * side - 1.0
            plane[:] = 0.0
            plane[c] = sign
            plane[3] = sign * geometry.centroid[i, c] + geometry.radius[i] + reach
    how, b = APART, first_blocker(blockers, planes, 0.0, walk)
    while b >= 0 and how != FLAT:
        how = max(how, _nearness(blockers, b, geometry, i, reach))
        b = next_blocker(blockers, planes, 0.0, walk)
    return how
