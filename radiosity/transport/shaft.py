"""The shaft of a pair, the convex hull of two polygons: planes about it, what lies beyond them."""

import math

import numpy as np
from numba import njit

from radiosity.transport.polygon import heights


@njit(cache=True, nogil=True, error_model="numpy")
def edge_normals(polygon, normal, slack, outward):
    """Write the unit normals of a convex polygon's edges, in its plane, into outward (m, 3).

    The corners run counter-clockwise about ``normal``. 0 where a plane about the edge could leave
    out another corner by more than ``slack``: rounding decides the direction of a short edge.
    """
    for e in range(len(polygon)):
        a, b = polygon[e], polygon[(e + 1) % len(polygon)]
        outward[e, 0], outward[e, 1], outward[e, 2] = _across(a, b, normal)
        for k in range(len(polygon)):
            out = up = 0.0
            for c in range(3):
                r = polygon[k, c] - a[c]
                out, up = out + outward[e, c] * r, up + normal[c] * r
            if max(0.0, out) + abs(up) > slack:
                outward[e, 0] = outward[e, 1] = outward[e, 2] = 0.0
                break


@njit(cache=True, nogil=True, error_model="numpy")
def all_edge_normals(vertices, normal, slack, outward):
    """Write the `edge_normals` of polygons (n, 4, 3) into outward (n, 4, 3)."""
    for i in range(len(vertices)):
        edge_normals(vertices[i], normal[i], slack[i], outward[i])


@njit(cache=True, nogil=True, error_model="numpy")
def _across(a, b, n):
    """Return the unit vector (b - a) x n, 0 where there is none."""
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    x, y, z = y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]
    size = math.sqrt(x * x + y * y + z * z)
    return (x / size, y / size, z / size) if size > 0.0 else (0.0, 0.0, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def shaft_planes(geometry, i, j, slack, planes):
    """Write the planes that bound the shaft of polygons i and j; return how many.

    Parameters
    ----------
    planes : (10, 4)
        Gets (a, b, c, d): the shaft lies where a y0 + b y1 + c y2 <= d.
    """
    p, q = geometry.vertices[i], geometry.vertices[j]
    count = _edge_planes(p, geometry.outward[i], geometry.normal[i], q, slack, planes, 0)
    count = _edge_planes(q, geometry.outward[j], geometry.normal[j], p, slack, planes, count)
    return front_planes(geometry, i, j, planes, count)


@njit(cache=True, nogil=True, error_model="numpy")
def half_shaft_planes(geometry, i, q, slack, planes):
    """Write the planes that bound the shaft of polygon i and any convex body q; return how many."""
    p = geometry.vertices[i]
    count = _edge_planes(p, geometry.outward[i], geometry.normal[i], q, slack, planes, 0)
    return _front_plane(geometry, i, planes, count)


@njit(cache=True, nogil=True, error_model="numpy")
def outline_planes(p, normal, q, other, slack, planes):
    """Write the planes through edges of any two polygons about their shaft; return how many.

    ``normal`` and ``other`` are theirs. Those of `shaft_planes` without the polygons' own.
    """
    outward = np.empty((max(len(p), len(q)), 3))
    edge_normals(p, normal, slack, outward)
    count = _edge_planes(p, outward, normal, q, slack, planes, 0)
    edge_normals(q, other, slack, outward)
    return _edge_planes(q, outward, other, p, slack, planes, count)


@njit(cache=True, nogil=True, error_model="numpy")
def front_planes(geometry, i, j, planes, count):
    """Write the planes of two polygons after ``count`` others; return how many there are then."""
    return _front_plane(geometry, j, planes, _front_plane(geometry, i, planes, count))


@njit(cache=True, nogil=True, error_model="numpy")
def _front_plane(geometry, i, planes, count):
    """Write the plane of polygon i after ``count`` others; return how many there are then."""
    normal, middle = geometry.normal[i], geometry.centroid[i]
    for c in range(3):
        planes[count, c] = -normal[c]
    planes[count, 3] = -(normal[0] * middle[0] + normal[1] * middle[1] + normal[2] * middle[2])
    return count + 1


@njit(cache=True, nogil=True, error_model="numpy")
def _edge_planes(p, outward, normal, q, slack, planes, count):
    """Write the planes through edges of p that just touch q after ``count`` others.

    ``outward`` is what `edge_normals` finds of p, ``q`` any convex body. Returns how many
    there are then.
    """
    for e in range(len(p)):
        if _plane_about(p[e], outward[e], normal, q, slack, planes[count]):
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _plane_about(a, m, n, q, slack, plane):
    """Write the plane through an edge that just touches q, its normal outward and of length 1.

    ``a`` is a corner of the edge, ``m`` its normal and ``n`` that of its polygon. False where there
    is none.
    """
    if m[0] == 0.0 and m[1] == 0.0 and m[2] == 0.0:
        return False
    out = up = low = 0.0  # of the corner seen furthest beyond the edge: of the largest angle
    for k in range(len(q)):
        x, y, z = q[k, 0] - a[0], q[k, 1] - a[1], q[k, 2] - a[2]
        side, height = m[0] * x + m[1] * y + m[2] * z, n[0] * x + n[1] * y + n[2] * z
        low, height = min(low, height), max(0.0, height)
        nowhere = out == 0.0 and up == 0.0
        flat = up == 0.0 and height == 0.0
        if nowhere or side * up > out * height or (flat and side > out):
            out, up = side, height
    slope = math.sqrt(out * out + up * up)
    if not slope > 0.0:
        return False
    plane[3] = 0.0
    for c in range(3):
        plane[c] = (up * m[c] - out * n[c]) / slope
        plane[3] += plane[c] * a[c]
    return low >= -slack or heights(q, a, plane)[1] <= slack


@njit(cache=True, nogil=True, error_model="numpy")
def box_beside(low, high, planes, slack):
    """Whether a box lies beyond one of a shaft's planes or just touches it."""
    for m in range(len(planes)):
        least = -planes[m, 3]
        for c in range(3):
            least += planes[m, c] * (low[c] if planes[m, c] > 0.0 else high[c])
        if least >= -slack:
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def beside(corners, planes, slack):
    """Whether a polygon lies beyond one of a shaft's planes or just touches it."""
    for m in range(len(planes)):
        least = 1e300
        for k in range(len(corners)):
            x, y, z = corners[k, 0], corners[k, 1], corners[k, 2]
            least = min(least, planes[m, 0] * x + planes[m, 1] * y + planes[m, 2] * z)
        if least - planes[m, 3] >= -slack:
            return True
    return False
