"""One point against a run of patches at once: heights, distances, factors and moments, vectorised.

As in `screen`, each coordinate has an array of its own, so that the compiler can use the
processor's vectors.
"""

import math

from numba import njit

from radiosity.transport.exchange import FIRST

RUN = 64  # consecutive patches that are looked at together
HEIGHT, LOW, HIGH, SQUARE = range(4)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _three(columns, first, stop):
    return columns[0, first:stop], columns[1, first:stop], columns[2, first:stop]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz"})
def look_along(columns, x, n, first, count, table):
    """Write what decides how a point sees ``count`` patches from ``first`` on.

    table (4, RUN) gets the height of the point over the planes of the patches, their lowest and
    highest corner over its horizon, and the squared distance of their centroids.
    """
    stop = first + count
    x0, x1, x2, n0, n1, n2 = x[0], x[1], x[2], n[0], n[1], n[2]
    height, low, high, square = table[0], table[1], table[2], table[3]
    c0, c1, c2 = _three(columns.centroid, first, stop)
    o0, o1, o2 = _three(columns.normal, first, stop)
    for k in range(count):
        d0, d1, d2 = x0 - c0[k], x1 - c1[k], x2 - c2[k]
        height[k] = d0 * o0[k] + d1 * o1[k] + d2 * o2[k]
        square[k] = d0 * d0 + d1 * d1 + d2 * d2
        low[k], high[k] = 1e300, -1e300
    for v in range(4):
        v0, v1, v2 = _three(columns.vertices[v], first, stop)
        for k in range(count):
            h = (v0[k] - x0) * n0 + (v1[k] - x1) * n1 + (v2[k] - x2) * n2
            low[k] = h if h < low[k] else low[k]
            high[k] = h if h > high[k] else high[k]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def rules(columns, axes, x, n, first, count, points, out):
    """Write the factors from a point to patches, and their moments, by Gauss rules over them.

    Parameters
    ----------
    axes : (2, 3, patches)
        Of the elements.
    out : (3, RUN)
        int K dA, int K u dA and int K v dA of each.
    """
    stop = first + count
    x0, x1, x2, n0, n1, n2 = x[0], x[1], x[2], n[0], n[1], n[2]
    c0, c1, c2 = _three(columns.centroid, first, stop)
    o0, o1, o2 = _three(columns.normal, first, stop)
    a0, a1, a2 = _three(axes[0], first, stop)
    b0, b1, b2 = _three(axes[1], first, stop)
    whole, one, two = out[0], out[1], out[2]
    for k in range(count):
        whole[k] = one[k] = two[k] = 0.0
    for m in range(FIRST[points], FIRST[points + 1]):
        p0, p1, p2 = _three(columns.points[m], first, stop)
        weight = columns.weights[m, first:stop]
        for k in range(count):
            d0, d1, d2 = p0[k] - x0, p1[k] - x1, p2[k] - x2
            r2 = d0 * d0 + d1 * d1 + d2 * d2
            here = d0 * n0 + d1 * n1 + d2 * n2
            there = d0 * o0[k] + d1 * o1[k] + d2 * o2[k]
            w = -weight[k] * here * there / (math.pi * r2 * r2)
            y0, y1, y2 = p0[k] - c0[k], p1[k] - c1[k], p2[k] - c2[k]
            whole[k] += w
            one[k] += w * (a0[k] * y0 + a1[k] * y1 + a2[k] * y2)
            two[k] += w * (b0[k] * y0 + b1[k] * y1 + b2[k] * y2)


@njit(cache=True, nogil=True, error_model="numpy")
def bound_runs(vertices, low, high):
    """Write the lowest and highest corners of each RUN of polygons into low and high (runs, 3)."""
    for r in range(len(low)):
        for c in range(3):
            some = vertices[r * RUN : (r + 1) * RUN, :, c]
            low[r, c], high[r, c] = some.min(), some.max()
