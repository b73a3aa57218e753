"""Unoccluded exchange between planar convex polygons to a relative tolerance, compiled (E1).

Far pairs: a product of Gauss rules over both. Nearer ones: a Gauss rule over one of the exact
factor to the other. Near, touching and almost parallel ones: the contour integral. Slivers, where
the contour integral cancels: a graded rule over the smaller one of the exact factor. Each comes
with an estimate of its error.
"""

import math
from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.transport.contour import EPS, contour_exchange
from radiosity.transport.polygon import bilinear, clip, heights, point_factor
from radiosity.transport.rules import GRADED, NODES, ORDERS, WEIGHTS, gauss_index
from radiosity.transport.shaft import all_edge_normals

FEWEST, MOST = 2, 6  # Gauss points along each direction that are kept for every polygon
FIRST = np.array([0, 0, 0, 4, 13, 29, 54, 90])  # those of m points a direction begin at FIRST[m]
CORNERS = 12
CLOSE = 1.5  # distance from an outline, in radii, below which the contour integral is better
FINEST = 1e-15
GRAIN = 1e-15  # of coordinates about 1 that were not rounded before
ROUNDING = 0.1 * EPS  # of the exact factor from a point: its edge terms cancel
FEWEST_INDEX, LAST_INDEX = 1, 7
CONSTANT = 2.0
GRAZING = 0.01  # least product of cosines that relative errors refer to

Geometry = namedtuple(
    "Geometry", "vertices normal centroid radius area bent outward points weights grain"
)
Geometry.__doc__ = """Polygons as the kernels read them, in lengths of about 1.

vertices (n, 4, 3), normal and centroid (n, 3), radius and area (n,); bent (n,): no parallelogram;
outward (n, 4, 3): see `edge_normals`; points (n, 3, 90) and weights (n, 90), area included, of the
Gauss rules with 2 to 6 points a direction; grain (n,): how far rounding may have moved their
vertices.
"""

Room = namedtuple("Room", "p q scratch found x quad")
Room.__doc__ = "Space for one thread: clipped polygons, cuts, results, a point, a part."


def make_room() -> Room:
    """Return space for the computation of one pair at a time."""
    corners = np.empty((2, CORNERS, 3))
    found, x, quad = np.empty(3), np.empty(3), np.empty((4, 3))
    return Room(corners[0], corners[1], np.empty((4, 64)), found, x, quad)


def make_geometry(vertices, normal, centroid, area, grain=GRAIN) -> Geometry:
    """Return the arrays of polygons in local coordinates.

    Parameters
    ----------
    vertices : (n, 4, 3) float64
        Centred and scaled so that they lie within about [-1, 1].
    normal, centroid : (n, 3) float64
    area : (n,) float64
    grain : float or (n,) float
        How far rounding may have moved a vertex.
    """
    radius = np.linalg.norm(vertices - centroid[:, None], axis=2).max(axis=1, initial=0.0)
    n = len(vertices)
    points, weights = np.empty((n, 3, FIRST[-1])), np.empty((n, FIRST[-1]))
    _gauss_points(vertices, points, weights)
    outward, grain = np.empty((n, 4, 3)), np.full(n, grain, float)
    all_edge_normals(vertices, normal, 4.0 * grain, outward)
    skew = np.abs(vertices[:, 0] - vertices[:, 1] + vertices[:, 2] - vertices[:, 3]).max(axis=1)
    bent = skew > 1e-3 * radius
    return Geometry(vertices, normal, centroid, radius, area, bent, outward, points, weights, grain)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def grain_of(geometry, i, j):
    """Return how far rounding may have moved a vertex of either polygon."""
    return max(geometry.grain[i], geometry.grain[j])


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def least_height(geometry, i, j):
    """Return the height over a plane below which either polygon does not see the other."""
    reach = geometry.radius[i] + geometry.radius[j]
    return 1e-12 * reach + 4.0 * grain_of(geometry, i, j)


@njit(cache=True, nogil=True, error_model="numpy")
def _gauss_points(vertices, points, weights):
    x = np.empty(3)
    for i in range(len(vertices)):
        for m in range(FEWEST, MOST + 1):
            nodes, along = NODES[m - 1], WEIGHTS[m - 1]
            for a in range(m):
                for b in range(m):
                    k = FIRST[m] + a * m + b
                    stretch = bilinear(vertices[i], nodes[a], nodes[b], x)
                    weights[i, k] = stretch * along[a] * along[b]
                    points[i, 0, k], points[i, 1, k], points[i, 2, k] = x[0], x[1], x[2]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"})
def _product_rule(geometry, i, j, mi, mj):
    """E1 by mi x mi times mj x mj Gauss points."""
    n, o = geometry.normal[i], geometry.normal[j]
    p, q = geometry.points[i], geometry.points[j]
    wp, wq = geometry.weights[i], geometry.weights[j]
    n0, n1, n2, o0, o1, o2 = n[0], n[1], n[2], o[0], o[1], o[2]
    total = 0.0
    for a in range(FIRST[mi], FIRST[mi + 1]):
        x, y, z = p[0, a], p[1, a], p[2, a]
        inner = 0.0
        for b in range(FIRST[mj], FIRST[mj + 1]):
            dx, dy, dz = q[0, b] - x, q[1, b] - y, q[2, b] - z
            r2 = dx * dx + dy * dy + dz * dz
            one = dx * n0 + dy * n1 + dz * n2
            two = dx * o0 + dy * o1 + dz * o2
            inner -= wq[b] * one * two / (r2 * r2)
        total += wp[a] * inner
    return total / math.pi


@njit(cache=True, nogil=True, error_model="numpy")
def points_needed(far, bent, limit):
    """Return how many Gauss points a direction the kernel needs from ``far`` radii away; 0: many.

    Its error, as a share of A A'/(pi r^2), falls like (far + sqrt(far^2 - 1))^(-2 m), by one power
    less where the map from the unit square is not affine; the factor before it was found on random
    pairs of triangles and quadrilaterals.
    """
    if far <= 1.3:
        return 0
    rho = far + math.sqrt(far * far - 1.0)
    step = 1.0 / (rho * rho)
    error = (CONSTANT * rho if bent else CONSTANT) * step ** (FEWEST - 1)
    for m in range(FEWEST, MOST + 1):
        error *= step
        if error <= limit:
            return m
    return 0


@njit(cache=True, nogil=True, error_model="numpy")
def _edge_distance(point, polygon, count):
    """Return the distance of a point from the outline of a polygon."""
    least = 1e300
    for k in range(count):
        a, b = polygon[k], polygon[(k + 1) % count]
        dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        rx, ry, rz = point[0] - a[0], point[1] - a[1], point[2] - a[2]
        length2 = dx * dx + dy * dy + dz * dz
        t = 0.0
        if length2 > 0.0:
            t = min(1.0, max(0.0, (rx * dx + ry * dy + rz * dz) / length2))
        rx, ry, rz = rx - t * dx, ry - t * dy, rz - t * dz
        least = min(least, rx * rx + ry * ry + rz * rz)
    return math.sqrt(least)


@njit(cache=True, nogil=True, error_model="numpy")
def _point_rule(polygon, count, normal, target, nodes, weights, m, x):
    """Return a product rule over a convex polygon of the exact factor to another (E2)."""
    total = 0.0
    quad = np.empty((4, 3))
    for first in range(1, count - 1, 2):
        quad[0], quad[1], quad[2] = polygon[0], polygon[first], polygon[first + 1]
        quad[3] = polygon[min(first + 2, count - 1)]
        for a in range(m):
            for b in range(m):
                stretch = bilinear(quad, nodes[a], nodes[b], x)
                f = point_factor(x[0], x[1], x[2], normal[0], normal[1], normal[2], target)
                total += weights[a] * weights[b] * stretch * f
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _middle(polygon, count, out):
    """Write the mean corner; return the largest distance of a corner from it."""
    for c in range(3):
        out[c] = 0.0
        for k in range(count):
            out[c] += polygon[k, c] / count
    far = 0.0
    for k in range(count):
        far = max(far, sum_of_squares(polygon[k], out))
    return math.sqrt(far)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def sum_of_squares(a, b):
    """Return the squared distance of two points."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@njit(cache=True, nogil=True, error_model="numpy")
def _point_rules(polygon, count, normal, area, target, rho, tolerance, x):
    """Raise the order of `_point_rule` until its error is small; (value, error), -1 if it is not.

    Two orders differ by the error of the lower one, which the higher one makes rho^(-2) smaller
    with each point.
    """
    rounding = ROUNDING * area
    index = max(FEWEST_INDEX, gauss_index(rho, tolerance) - 1)
    before = _point_rule(
        polygon, count, normal, target, NODES[index], WEIGHTS[index], ORDERS[index], x
    )
    while index < LAST_INDEX:
        index += 1
        value = _point_rule(
            polygon, count, normal, target, NODES[index], WEIGHTS[index], ORDERS[index], x
        )
        gain = rho ** (-2.0 * (ORDERS[index] - ORDERS[index - 1]))
        error = 10.0 * abs(value - before) * max(gain, 1e-3)
        if error <= tolerance * value:  # two orders may agree by chance: never claim all of it
            return value, max(error, 0.05 * tolerance * value) + rounding
        before = value
    return before, -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _near(geometry, i, j, count_p, count_q, tolerance, room):
    """Exchange of the polygons in room.p and room.q, each in front of the other; (value, error)."""
    p, q, x = room.p[:count_p], room.q[:count_q], room.x
    reach_p = _middle(p, count_p, x)
    far_p = _edge_distance(x, q, count_q) / reach_p
    reach_q = _middle(q, count_q, x)
    far_q = _edge_distance(x, p, count_p) / reach_q
    far = max(far_p, far_q)
    if far > CLOSE:
        rho = far + math.sqrt(far * far - 1.0)
        if far_p >= far_q:
            value, error = _point_rules(
                p, count_p, geometry.normal[i], geometry.area[i], q, rho, tolerance, x
            )
        else:
            value, error = _point_rules(
                q, count_q, geometry.normal[j], geometry.area[j], p, rho, tolerance, x
            )
        if error >= 0.0:
            return value, error
    value, error = _contour(count_p, count_q, reach_p + reach_q, tolerance, room)
    if error > tolerance * value:
        other, least = _graded(geometry, i, j, count_p, count_q, room)
        if least < error:
            return other, least
    return value, error


@njit(cache=True, nogil=True, error_model="numpy")
def _contour(count_p, count_q, size, tolerance, room):
    """Exchange by the contour integral over the polygons in room; (value, error)."""
    p, q, found = room.p, room.q, room.found
    _scaled(p, count_p, 1.0 / size)
    _scaled(q, count_q, 1.0 / size)
    finer = 0.01 * tolerance
    for _ in range(3):
        contour_exchange(p, count_p, q, count_q, finer, room.scratch, found)
        quadrature = finer * found[1] / EPS
        if quadrature <= 0.5 * tolerance * found[0] or finer <= FINEST:
            break
        finer = max(FINEST, 0.2 * finer * tolerance * found[0] / quadrature)
    value, error = found[0], found[1] + min(quadrature, 0.5 * tolerance * found[0])
    _scaled(p, count_p, size)
    _scaled(q, count_q, size)
    return value * size * size, error * size * size


@njit(cache=True, nogil=True, error_model="numpy")
def _scaled(polygon, count, factor):
    for k in range(count):
        for c in range(3):
            polygon[k, c] *= factor


@njit(cache=True, nogil=True, error_model="numpy")
def _graded(geometry, i, j, count_p, count_q, room):
    """Exchange by a rule graded to all sides of the smaller polygon; (value, error)."""
    p, q, x = room.p[:count_p], room.q[:count_q], room.x
    fine, coarse = GRADED[2], GRADED[1]
    if geometry.area[i] <= geometry.area[j]:
        n = geometry.normal[i]
        value = _point_rule(p, count_p, n, q, fine[0], fine[1], len(fine[0]), x)
        other = _point_rule(p, count_p, n, q, coarse[0], coarse[1], len(coarse[0]), x)
    else:
        n = geometry.normal[j]
        value = _point_rule(q, count_q, n, p, fine[0], fine[1], len(fine[0]), x)
        other = _point_rule(q, count_q, n, p, coarse[0], coarse[1], len(coarse[0]), x)
    smaller = min(geometry.area[i], geometry.area[j])
    return value, 0.1 * abs(value - other) + ROUNDING * smaller


@njit(cache=True, nogil=True, error_model="numpy")
def load_fronts(geometry, i, j, room):
    """Write the parts of polygons i and j in front of each other into room.

    Returns their corners, both 0 where neither sees the other's front, and whether either was cut.
    """
    p, q = geometry.vertices[i], geometry.vertices[j]
    tolerance = least_height(geometry, i, j)
    low_q, high_q = heights(q, geometry.centroid[i], geometry.normal[i])
    low_p, high_p = heights(p, geometry.centroid[j], geometry.normal[j])
    if high_q <= tolerance or high_p <= tolerance:
        return 0, 0, False
    count_p = clip(p, geometry.centroid[j], geometry.normal[j], tolerance, room.p)
    count_q = clip(q, geometry.centroid[i], geometry.normal[i], tolerance, room.q)
    count_p, count_q = _distinct(room.p, count_p), _distinct(room.q, count_q)
    if count_p < 3 or count_q < 3:
        return 0, 0, False
    return count_p, count_q, min(low_p, low_q) < -tolerance


@njit(cache=True, nogil=True, error_model="numpy")
def _distinct(polygon, count):
    """Drop corners that repeat the one before; return how many are left."""
    kept = 0
    for k in range(count):
        before = kept - 1 if kept > 0 else count - 1
        if sum_of_squares(polygon[k], polygon[before]) > 0.0:
            polygon[kept, 0], polygon[kept, 1] = polygon[k, 0], polygon[k, 1]
            polygon[kept, 2] = polygon[k, 2]
            kept += 1
    return kept


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def least_certain(geometry, i, j, square):
    """Return the exchange below which the tolerance of a product rule is no longer relative."""
    return GRAZING * geometry.area[i] * geometry.area[j] / (math.pi * square)


@njit(cache=True, nogil=True, error_model="numpy")
def exchange_area(geometry, i, j, tolerance, room):
    """Return A_i F_ij without obstacles and its estimated error (E1).

    0 where neither sees the other's front. ``tolerance`` is relative.
    """
    ci, cj = geometry.centroid[i], geometry.centroid[j]
    ri, rj = geometry.radius[i], geometry.radius[j]
    slack = least_height(geometry, i, j)
    low_j, high_j = heights(geometry.vertices[j], ci, geometry.normal[i])
    low_i, high_i = heights(geometry.vertices[i], cj, geometry.normal[j])
    if high_j <= slack or high_i <= slack:
        return 0.0, 0.0
    if low_i >= -slack and low_j >= -slack:
        square = sum_of_squares(ci, cj)
        distance = math.sqrt(square)
        cosines = (low_i + high_i) * (low_j + high_j) / (4.0 * square)
        limit = 0.5 * tolerance * max(GRAZING, cosines)
        mi = points_needed((distance - rj) / ri, geometry.bent[i], limit)
        mj = points_needed((distance - ri) / rj, geometry.bent[j], limit)
        if mi > 0 and mj > 0 and mi * mj <= 16:
            value = max(0.0, _product_rule(geometry, i, j, mi, mj))
            return value, tolerance * max(value, least_certain(geometry, i, j, square))
    count_p, count_q, _ = load_fronts(geometry, i, j, room)
    if count_p == 0:
        return 0.0, 0.0
    return _near(geometry, i, j, count_p, count_q, tolerance, room)
