"""The shaft of a pair, the convex hull of two polygons: planes about it, what lies beyond them."""

import math

from numba import njit

from radiosity.transport.polygon import heights


@njit(cache=True, nogil=True, error_model="numpy")
def shaft_planes(geometry, i, j, p, q, slack, planes):
    """Write the planes that bound the shaft of polygons i and j; return how many.

    Parameters
    ----------
    p, q : (m, 3)
        The polygons, or their parts in front of each other.
    planes : (2 + 2 m, 4)
        Gets (a, b, c, d): the shaft lies where a y0 + b y1 + c y2 <= d.
    """
    count = edge_planes(p, geometry.normal[i], q, slack, planes, 0)
    count = edge_planes(q, geometry.normal[j], p, slack, planes, count)
    return _front(geometry, j, planes, _front(geometry, i, planes, count))


@njit(cache=True, nogil=True, error_model="numpy")
def half_shaft_planes(geometry, i, q, slack, planes):
    """Write the planes that bound the shaft of polygon i and any convex body q; return how many."""
    count = edge_planes(geometry.vertices[i], geometry.normal[i], q, slack, planes, 0)
    return _front(geometry, i, planes, count)


@njit(cache=True, nogil=True, error_model="numpy")
def _front(geometry, i, planes, count):
    """Write the plane of polygon i after ``count`` others; return how many there are then."""
    normal, middle = geometry.normal[i], geometry.centroid[i]
    for c in range(3):
        planes[count, c] = -normal[c]
    planes[count, 3] = -(normal[0] * middle[0] + normal[1] * middle[1] + normal[2] * middle[2])
    return count + 1


@njit(cache=True, nogil=True, error_model="numpy")
def edge_planes(p, normal, q, slack, planes, count):
    """Write the planes through edges of p that just touch q after ``count`` others.

    ``p`` (m, 3) is a convex polygon, counter-clockwise about its normal, ``q`` any convex body.
    Returns how many there are then.
    """
    for e in range(len(p)):
        a, plane = p[e], planes[count, :3]
        if not _plane_about(a, p[(e + 1) % len(p)], normal, q, plane):
            continue
        if heights(p, a, plane)[1] > slack or heights(q, a, plane)[1] > slack:
            continue  # the direction of a short edge is rounding
        planes[count, 3] = plane[0] * a[0] + plane[1] * a[1] + plane[2] * a[2]
        count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _plane_about(a, b, n, q, plane):
    """Write the outward unit normal of the plane through the edge a-b that just touches q.

    False where there is none.
    """
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    mx, my, mz = y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]
    size = math.sqrt(mx * mx + my * my + mz * mz)
    if not size > 0.0:
        return False
    mx, my, mz = mx / size, my / size, mz / size
    out = up = 0.0  # of the corner seen furthest beyond the edge: of the largest angle
    for k in range(len(q)):
        x, y, z = q[k, 0] - a[0], q[k, 1] - a[1], q[k, 2] - a[2]
        side, height = mx * x + my * y + mz * z, max(0.0, n[0] * x + n[1] * y + n[2] * z)
        nowhere = out == 0.0 and up == 0.0
        flat = up == 0.0 and height == 0.0
        if nowhere or side * up > out * height or (flat and side > out):
            out, up = side, height
    slope = math.sqrt(out * out + up * up)
    if not slope > 0.0:
        return False
    plane[0] = (up * mx - out * n[0]) / slope
    plane[1] = (up * my - out * n[1]) / slope
    plane[2] = (up * mz - out * n[2]) / slope
    return True


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
