"""One polygon against a run of others at once: heights, distances and product rules, vectorised.

Most pairs of a mesh are far and unobstructed, and their exchange is a small product of Gauss rules.
Loops over consecutive polygons, each coordinate in an array of its own, let the compiler use the
processor's vectors: six times as many pairs a second as one by one.
"""

import math
from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.transport.exchange import FIRST, Geometry

RUN = 128
LOW_I, HIGH_I, LOW_J, HIGH_J, SQUARE = range(5)

Columns = namedtuple("Columns", "vertices normal centroid points weights")
Columns.__doc__ = """A `Geometry` with polygons in the last axis.

vertices (4, 3, n), normal and centroid (3, n), points (90, 3, n) and weights (90, n).
"""


def make_columns(geometry: Geometry) -> Columns:
    """Return the arrays of a geometry as `screen` and `products` read them."""
    return Columns(
        np.ascontiguousarray(geometry.vertices.transpose(1, 2, 0)),
        np.ascontiguousarray(geometry.normal.T),
        np.ascontiguousarray(geometry.centroid.T),
        np.ascontiguousarray(geometry.points.transpose(2, 1, 0)),
        np.ascontiguousarray(geometry.weights.T),
    )


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _three(columns, first, stop):
    """Return the three coordinates of a run of polygons."""
    return columns[0, first:stop], columns[1, first:stop], columns[2, first:stop]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz"})
def screen(columns, geometry, i, first, count, table):
    """Write heights and squared distances of polygon i and ``count`` others from ``first`` on.

    table (5, RUN) gets the lowest and highest corner of i over the planes of the others, of the
    others over the plane of i, and the squared distance of centroids.
    """
    c0, c1, c2 = geometry.centroid[i, 0], geometry.centroid[i, 1], geometry.centroid[i, 2]
    n0, n1, n2 = geometry.normal[i, 0], geometry.normal[i, 1], geometry.normal[i, 2]
    stop = first + count
    x, y, z = _three(columns.centroid, first, stop)
    o0, o1, o2 = _three(columns.normal, first, stop)
    low_i, high_i, low_j, high_j, square = table[0], table[1], table[2], table[3], table[4]
    for k in range(count):
        dx, dy, dz = x[k] - c0, y[k] - c1, z[k] - c2
        square[k] = dx * dx + dy * dy + dz * dz
        low_i[k] = low_j[k] = 1e300
        high_i[k] = high_j[k] = -1e300
    for v in range(4):
        corner = geometry.vertices[i, v]
        u0, u1, u2 = corner[0], corner[1], corner[2]
        v0, v1, v2 = _three(columns.vertices[v], first, stop)
        for k in range(count):
            h = (v0[k] - c0) * n0 + (v1[k] - c1) * n1 + (v2[k] - c2) * n2
            low_j[k] = h if h < low_j[k] else low_j[k]
            high_j[k] = h if h > high_j[k] else high_j[k]
            g = (u0 - x[k]) * o0[k] + (u1 - y[k]) * o1[k] + (u2 - z[k]) * o2[k]
            low_i[k] = g if g < low_i[k] else low_i[k]
            high_i[k] = g if g > high_i[k] else high_i[k]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def products(columns, geometry, i, first, count, points, out):
    """Write the product rules of polygon i and ``count`` others from ``first`` on into out (E1)."""
    stop = first + count
    n0, n1, n2 = geometry.normal[i, 0], geometry.normal[i, 1], geometry.normal[i, 2]
    o0, o1, o2 = _three(columns.normal, first, stop)
    for k in range(count):
        out[k] = 0.0
    for a in range(FIRST[points], FIRST[points + 1]):
        own = geometry.points[i]
        x, y, z = own[0, a], own[1, a], own[2, a]
        w = geometry.weights[i, a] / math.pi
        for b in range(FIRST[points], FIRST[points + 1]):
            p0, p1, p2 = _three(columns.points[b], first, stop)
            v = columns.weights[b, first:stop]
            for k in range(count):
                dx, dy, dz = p0[k] - x, p1[k] - y, p2[k] - z
                r2 = dx * dx + dy * dy + dz * dz
                one = dx * n0 + dy * n1 + dz * n2
                two = dx * o0[k] + dy * o1[k] + dz * o2[k]
                out[k] -= w * v[k] * one * two / (r2 * r2)
