"""Polygons seen from points: Lambert's exact sum, clipping, points inside; compiled.

A polygon is a (k, 3) array, a quadrilateral (4, 3) with a triangle repeating its last vertex;
vertices run counter-clockwise seen from the active side.
"""

import math

import numpy as np
from numba import njit

TINY = 1e-300
SECTOR_NODES, SECTOR_WEIGHTS = np.polynomial.legendre.leggauss(8)
PIECE, FARTHEST = 2.5, 40.0  # of u in `_sector`: per Gauss rule, and beyond which nothing is left


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _edge_term(ax, ay, az, bx, by, bz, nx, ny, nz):
    """Return angle(a, b) times the cosine between n and a x b."""
    cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    length = math.sqrt(cx * cx + cy * cy + cz * cz)
    if length < TINY:
        return 0.0
    angle = math.atan2(length, ax * bx + ay * by + az * bz)
    return angle * (cx * nx + cy * ny + cz * nz) / length


@njit(cache=True, nogil=True, error_model="numpy")
def point_factor(px, py, pz, nx, ny, nz, polygon):
    """Form factor from a surface element to a polygon seen from its front (E2).

    The polygon is clipped at the element's horizon as its edges stream by. Lambert (1760):
    F = 1/(2 pi) sum over edges of angle(r_k, r_k+1) n.(r_k x r_k+1)/|r_k x r_k+1|,
    with the sign turned so that a polygon facing the element counts positive.
    """
    total = 0.0
    crossed = False
    ox = oy = oz = ex = ey = ez = 0.0
    last = len(polygon) - 1
    ax, ay, az = polygon[last, 0] - px, polygon[last, 1] - py, polygon[last, 2] - pz
    ha = ax * nx + ay * ny + az * nz
    for k in range(len(polygon)):
        bx, by, bz = polygon[k, 0] - px, polygon[k, 1] - py, polygon[k, 2] - pz
        hb = bx * nx + by * ny + bz * nz
        if ha > 0.0 and hb > 0.0:
            total += _edge_term(ax, ay, az, bx, by, bz, nx, ny, nz)
        elif ha > 0.0 or hb > 0.0:
            crossed = True
            t = ha / (ha - hb)
            cx, cy, cz = ax + t * (bx - ax), ay + t * (by - ay), az + t * (bz - az)
            if ha > 0.0:
                total += _edge_term(ax, ay, az, cx, cy, cz, nx, ny, nz)
                ox, oy, oz = cx, cy, cz
            else:
                total += _edge_term(cx, cy, cz, bx, by, bz, nx, ny, nz)
                ex, ey, ez = cx, cy, cz
        ax, ay, az, ha = bx, by, bz, hb
    if crossed:
        total += _edge_term(ox, oy, oz, ex, ey, ez, nx, ny, nz)
    return max(0.0, -total / (2.0 * math.pi))


@njit(cache=True, nogil=True, error_model="numpy")
def add_moment(x, n, polygon, facing, moment):
    """Add the first moment of a polygon's kernel to moment (3,): int K (y - x - h m) dA (E12).

    K = cos cos'/(pi r^2) is the kernel of E2, m = -``facing`` points at the plane of the polygon,
    at the distance h. The moment lies in that plane. With w = y - x - h m, t = n - (n.m) m and
    grad(-1/(2 r^2)) = w/r^4 in the plane, Gauss' theorem leaves integrals over the edges, and one,
    int dA / r^2, that has no elementary form.

    Parameters
    ----------
    x, n : (3,)
        Point and unit normal.
    polygon : (k, 3)
        Convex, in front of the point and facing it; ``facing`` is its unit normal.
    """
    h = 0.0
    for c in range(3):
        h -= facing[c] * (polygon[0, c] - x[c])
    nm = -(n[0] * facing[0] + n[1] * facing[1] + n[2] * facing[2])
    t0, t1, t2 = n[0] + nm * facing[0], n[1] + nm * facing[1], n[2] + nm * facing[2]
    a0 = a1 = a2 = plain = 0.0
    for k in range(len(polygon)):
        p, q = polygon[k], polygon[k + 1 if k + 1 < len(polygon) else 0]
        e0, e1, e2 = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        length = math.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
        if length < TINY:
            continue
        e0, e1, e2 = e0 / length, e1 / length, e2 / length
        v0, v1 = e1 * facing[2] - e2 * facing[1], e2 * facing[0] - e0 * facing[2]
        v2 = e0 * facing[1] - e1 * facing[0]
        r0, r1, r2 = p[0] - x[0], p[1] - x[1], p[2] - x[2]
        off, begin = r0 * v0 + r1 * v1 + r2 * v2, r0 * e0 + r1 * e1 + r2 * e2
        end, square = begin + length, h * h + off * off
        far = math.sqrt(square)
        angle = math.atan2(far * length, square + begin * end) / far
        log = 0.5 * math.log((square + end * end) / (square + begin * begin))
        across, along = t0 * v0 + t1 * v1 + t2 * v2, t0 * e0 + t1 * e1 + t2 * e2
        w = -0.5 * ((nm * h + across * off) * angle + along * log)
        a0, a1, a2 = a0 + w * v0, a1 + w * v1, a2 + w * v2
        plain += _sector(off, begin, end, h)
    c = h / math.pi
    moment[0] += c * (a0 + 0.5 * t0 * plain)
    moment[1] += c * (a1 + 0.5 * t1 * plain)
    moment[2] += c * (a2 + 0.5 * t2 * plain)


@njit(cache=True, nogil=True, error_model="numpy")
def _sector(off, begin, end, h):
    """Return int dA/(h^2 + w^2) over the triangle of the origin and an edge ``off`` from it.

    That is 1/2 int ln(1 + (off cosh(u)/h)^2) / cosh(u) du between the edge's ends off sinh(u): free
    of singularities up to pi/2 off the real axis, however near or far the edge is.
    """
    size = abs(off)
    if size <= TINY + 1e-14 * h:
        return 0.0
    low, high = math.asinh(begin / size), math.asinh(end / size)
    low, high = max(low, -FARTHEST), min(high, FARTHEST)
    pieces = int(math.ceil((high - low) / PIECE))
    half, ratio, total = 0.5 * (high - low) / max(1, pieces), (off / h) ** 2, 0.0
    for m in range(pieces):
        for k in range(len(SECTOR_NODES)):
            wide = math.cosh(low + half * (2 * m + 1.0 + SECTOR_NODES[k]))
            total += SECTOR_WEIGHTS[k] * math.log1p(ratio * wide * wide) / wide
    return math.copysign(0.5 * half * total, off)


@njit(cache=True, nogil=True, error_model="numpy")
def heights(polygon, point, normal):
    """Return the lowest and highest signed distance of the vertices from a plane."""
    low, high = 1e300, -1e300
    for k in range(len(polygon)):
        h = 0.0
        for c in range(3):
            h += (polygon[k, c] - point[c]) * normal[c]
        low, high = min(low, h), max(high, h)
    return low, high


@njit(cache=True, nogil=True, error_model="numpy")
def area_of(polygon):
    """Return the area of a planar polygon."""
    nx = ny = nz = 0.0
    x, y, z = polygon[0, 0], polygon[0, 1], polygon[0, 2]
    for k in range(1, len(polygon) - 1):
        ax, ay, az = polygon[k, 0] - x, polygon[k, 1] - y, polygon[k, 2] - z
        bx, by, bz = polygon[k + 1, 0] - x, polygon[k + 1, 1] - y, polygon[k + 1, 2] - z
        nx, ny, nz = nx + ay * bz - az * by, ny + az * bx - ax * bz, nz + ax * by - ay * bx
    return 0.5 * math.sqrt(nx * nx + ny * ny + nz * nz)


@njit(cache=True, nogil=True, error_model="numpy")
def clip(polygon, point, normal, tolerance, out):
    """Write the part of a convex polygon in front of a plane into out; return its corner count.

    Corners within ``tolerance`` of the plane count as lying in it. ``out`` takes one corner more.
    """
    count = 0
    last = len(polygon) - 1
    ax, ay, az = polygon[last, 0], polygon[last, 1], polygon[last, 2]
    ha = (ax - point[0]) * normal[0] + (ay - point[1]) * normal[1] + (az - point[2]) * normal[2]
    for k in range(len(polygon)):
        bx, by, bz = polygon[k, 0], polygon[k, 1], polygon[k, 2]
        hb = (bx - point[0]) * normal[0] + (by - point[1]) * normal[1] + (bz - point[2]) * normal[2]
        if (ha > tolerance and hb < -tolerance) or (ha < -tolerance and hb > tolerance):
            t = ha / (ha - hb)
            out[count, 0], out[count, 1] = ax + t * (bx - ax), ay + t * (by - ay)
            out[count, 2] = az + t * (bz - az)
            count += 1
        if hb >= -tolerance:
            out[count, 0], out[count, 1], out[count, 2] = bx, by, bz
            count += 1
        ax, ay, az, ha = bx, by, bz, hb
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def first_half(polygon):
    """Return the share of a quadrilateral's area on its second vertex' side of the diagonal."""
    e, f, g = polygon[1] - polygon[0], polygon[2] - polygon[0], polygon[3] - polygon[0]
    one = two = 0.0
    for c in range(3):
        a, b = (c + 1) % 3, (c + 2) % 3
        one += (e[a] * f[b] - e[b] * f[a]) ** 2
        two += (f[a] * g[b] - f[b] * g[a]) ** 2
    one, two = math.sqrt(one), math.sqrt(two)
    return one / (one + two) if one > 0.0 else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def place_evenly(polygon, half, s, t, x):
    """Write into x the image of (s, t) under a map of the unit square that keeps shares of area.

    ``half`` is the polygon's `first_half`. Either half is a triangle (Turk 1990).
    """
    k = 1 if s < half else 2
    r = math.sqrt(s / half if k == 1 else (s - half) / (1.0 - half))
    for c in range(3):
        v = polygon[0, c]
        x[c] = v + r * ((1.0 - t) * (polygon[k, c] - v) + t * (polygon[k + 1, c] - v))


@njit(cache=True, nogil=True, error_model="numpy")
def bilinear(polygon, s, t, x):
    """Write the point at (s, t) into x and return the area stretch |x_s cross x_t| there."""
    w0, w1, w2, w3 = (1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t
    ax = ay = az = bx = by = bz = 0.0
    for c in range(3):
        v0, v1, v2, v3 = polygon[0, c], polygon[1, c], polygon[2, c], polygon[3, c]
        x[c] = w0 * v0 + w1 * v1 + w2 * v2 + w3 * v3
        ds = (1 - t) * (v1 - v0) + t * (v2 - v3)
        dt = (1 - s) * (v3 - v0) + s * (v2 - v1)
        if c == 0:
            ax, bx = ds, dt
        elif c == 1:
            ay, by = ds, dt
        else:
            az, bz = ds, dt
    cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return math.sqrt(cx * cx + cy * cy + cz * cz)
