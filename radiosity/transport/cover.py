"""Whether a surface of several blockers hides one polygon from another, proven by its edges.

What a segment between the two meets changes only where the segment, moved, crosses an edge. A
blocker whose plane lies between the two is left over an edge that it shares with another such
blocker, wound the same way, only to enter that one. So if the blockers that can be reached like
that from one that some segment meets have no other edges in reach, all segments meet one of them.
"""

import numpy as np
from numba import njit

from radiosity.transport.blockers import INSIDE, MOST, OUTSIDE, passes
from radiosity.transport.polygon import heights

ASTRIDE, IN_FRONT, BEHIND = 0, -1, 1  # of a blocker's plane


@njit(cache=True, nogil=True, error_model="numpy")
def is_covered(p, q, blockers, active, slack):
    """Whether a surface that active blockers are part of hides all of q from all of p.

    Parameters
    ----------
    p, q : (m, 3)
        Corners of two convex bodies.
    blockers : Blockers
    active : (k,) int64
        Those that may be met first.
    slack : float
        Distance that counts as touching.
    """
    one, two = np.empty((1, 3)), np.empty((1, 3))
    _inside(p, 0.31, one[0])
    _inside(q, 0.43, two[0])
    reached, where = np.empty(MOST, np.int64), np.empty(blockers.corners.shape[1], np.int64)
    for m in range(len(active)):
        side = _side(blockers, active[m], p, q, slack)
        if side == ASTRIDE or not _cross(blockers, active[m], side, one, two, slack, where):
            continue
        reached[0] = active[m]
        if np.all(where[: blockers.count[active[m]]] == INSIDE) and _closes(
            blockers, side, p, q, slack, reached, where
        ):
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _inside(corners, skew, x):
    """Write a point between corners into x, off the middle, where edges of blockers often meet."""
    total = 1.0
    x[:] = corners[0]
    for k in range(1, len(corners)):
        weight = skew * k * k + 1.0
        total += weight
        for c in range(3):
            x[c] += weight / total * (corners[k, c] - x[c])


@njit(cache=True, nogil=True, error_model="numpy")
def _side(blockers, b, p, q, slack):
    """Return on which side of a blocker p lies, q on the other; ASTRIDE where neither is so."""
    corner, normal = blockers.corners[b, 0], blockers.normal[b]
    low_p, high_p = heights(p, corner, normal)
    low_q, high_q = heights(q, corner, normal)
    if low_p >= -slack and high_q <= slack:
        return IN_FRONT
    return BEHIND if high_p <= slack and low_q >= -slack else ASTRIDE


@njit(cache=True, nogil=True, error_model="numpy")
def _cross(blockers, b, side, p, q, slack, where):
    """Write how the segments pass the edges of a blocker; False where all miss it."""
    corners, count = blockers.corners[b], blockers.count[b]
    for e in range(count):
        where[e] = passes(corners[e], corners[(e + 1) % count], float(side), p, q, slack)
        if where[e] == OUTSIDE:
            return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _closes(blockers, side, p, q, slack, reached, where):
    """Whether all edges in reach from the blocker reached[0] lead to others between p and q."""
    count = 1
    k = 0
    while k < count:
        b = reached[k]
        k += 1
        if _side(blockers, b, p, q, slack) != side:
            return False
        if not _cross(blockers, b, side, p, q, slack, where):
            continue
        for e in range(blockers.count[b]):
            if where[e] == INSIDE:
                continue
            other = blockers.beyond[b, e]
            if np.any(reached[:count] == other):
                continue
            if other < 0 or count == len(reached):
                return False
            reached[count] = other
            count += 1
    return True
