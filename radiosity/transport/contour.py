"""The double contour integral of near and touching polygons, compiled (E3, E4).

A_p F_pq = 1/(2 pi) oint oint ln r dx . dx' with the integral along an edge of q in closed form. The
one along an edge of p is a Gauss rule wherever the integrand is smooth; towards points where it is
not the edge is bisected, and where edges touch a graded rule takes the last piece.
"""

import math

from numba import njit

from radiosity.transport.polygon import TINY
from radiosity.transport.rules import GRADED, NODES, ORDERS, WEIGHTS, gauss_index

EPS = 2.3e-16
DEPTH = 64
ON = 1e-14  # a share of a length below which two points are one
GRADE, SPLIT = -1, -2


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _log_integral(rx, ry, rz, ex, ey, ez, length):
    """Integral of ln |r - s e| for s from 0 to length along the unit direction e (E4)."""
    p = rx * ex + ry * ey + rz * ez
    hx, hy, hz = ry * ez - rz * ey, rz * ex - rx * ez, rx * ey - ry * ex
    h2 = hx * hx + hy * hy + hz * hz
    rest = length - p
    far2, near2 = rest * rest + h2, p * p + h2
    h = math.sqrt(h2)
    total = -length + h * math.atan2(h * length, h2 - p * rest)
    if far2 > TINY:
        total += 0.5 * rest * math.log(far2)
    if near2 > TINY:
        total += 0.5 * p * math.log(near2)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _ellipse(t, h, start, stop):
    """Sum of half axes of the ellipse about start..stop through the complex point t + i h."""
    a = max(1.0, (math.hypot(t - start, h) + math.hypot(t - stop, h)) / (stop - start))
    return a + math.sqrt(a * a - 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _singular_points(rx, ry, rz, dx, dy, dz, ex, ey, ez, le, cosine, where, off):
    """Write foot and distance of the three points near which an inner integral is least smooth.

    The ends of the inner edge, and where the two lines come nearest if the foot lies on the edge.
    r is the start of the inner edge seen from the start of the outer one. Return their count.
    """
    for k in range(2):
        x, y, z = rx + k * le * ex, ry + k * le * ey, rz + k * le * ez
        t = x * dx + y * dy + z * dz
        where[k] = t
        off[k] = math.sqrt(max(0.0, (x - t * dx) ** 2 + (y - t * dy) ** 2 + (z - t * dz) ** 2))
    sine2 = 1.0 - cosine * cosine
    if sine2 < 1e-8:
        return 2
    rd, re = rx * dx + ry * dy + rz * dz, rx * ex + ry * ey + rz * ez
    t, s = (rd - cosine * re) / sine2, (cosine * rd - re) / sine2
    if s < -1e-6 * le or s > (1.0 + 1e-6) * le:
        return 2
    x, y, z = rx + s * ex - t * dx, ry + s * ey - t * dy, rz + s * ez - t * dz
    where[2], off[2] = t, math.sqrt((x * x + y * y + z * z) / sine2)
    return 3


@njit(cache=True, nogil=True, error_model="numpy")
def _fitting_rule(start, stop, where, off, count, tolerance, at):
    """Return the rule for a piece of an edge: an order's index, GRADE, or SPLIT with at[0] where.

    A Gauss rule where no singular point is near; the graded one where those that are near lie on
    the ends of the piece.
    """
    span = stop - start
    rho, near = 1e300, 1e300
    at[0] = 0.5 * (start + stop)
    for k in range(count):
        e = _ellipse(where[k], off[k], start, stop)
        ends = min(abs(where[k] - start), abs(where[k] - stop))
        if not (ends <= ON * span and off[k] <= ON * span):
            near = min(near, e)
            if e < 1.2 and start + 0.01 * span < where[k] < stop - 0.01 * span:
                at[0] = where[k]
        rho = min(rho, e)
    index = gauss_index(rho, tolerance)
    if index >= 0:
        return index
    return GRADE if near > 4.0 else SPLIT


@njit(cache=True, nogil=True, error_model="numpy")
def _edge_pair(p0, p1, q0, q1, tolerance, grade, scratch, found):
    """Add the integral of ln r dx . dx' over two edges, and its magnitude, to found (2,)."""
    dx, dy, dz = p1[0] - p0[0], p1[1] - p0[1], p1[2] - p0[2]
    ex, ey, ez = q1[0] - q0[0], q1[1] - q0[1], q1[2] - q0[2]
    la = math.sqrt(dx * dx + dy * dy + dz * dz)
    le = math.sqrt(ex * ex + ey * ey + ez * ez)
    if la < TINY or le < TINY:
        return
    dx, dy, dz, ex, ey, ez = dx / la, dy / la, dz / la, ex / le, ey / le, ez / le
    cosine = dx * ex + dy * ey + dz * ez
    if abs(cosine) < 1e-15:
        return
    rx, ry, rz = q0[0] - p0[0], q0[1] - p0[1], q0[2] - p0[2]
    where, off, at, stack = scratch[0], scratch[1], scratch[2], scratch[3]
    count = _singular_points(rx, ry, rz, dx, dy, dz, ex, ey, ez, le, cosine, where, off)
    total = size = start = 0.0
    stack[0], left = la, 1
    while left > 0:
        stop = stack[left - 1]
        rule = _fitting_rule(start, stop, where, off, count, tolerance, at)
        if rule == SPLIT and left < DEPTH and at[0] - start > ON * la:
            stack[left] = at[0]
            left += 1
            continue
        nodes, weights = grade
        m = len(nodes)
        if rule >= 0:
            nodes, weights, m = NODES[rule], WEIGHTS[rule], ORDERS[rule]
        for k in range(m):
            t = start + nodes[k] * (stop - start)
            value = _log_integral(t * dx - rx, t * dy - ry, t * dz - rz, ex, ey, ez, le)
            total += weights[k] * (stop - start) * value
            size += weights[k] * (stop - start) * abs(value)
        start = stop
        left -= 1
    found[0] += cosine * total
    found[1] += abs(cosine) * size


@njit(cache=True, nogil=True, error_model="numpy")
def contour_exchange(p, np_, q, nq, tolerance, scratch, found):
    """Write A_p F_pq and its rounding error into found (2,); lengths of about 1.

    Parameters
    ----------
    p, q : (k, 3) polygons of np_ and nq corners, each wholly in front of the other
    tolerance : relative error aimed at
    scratch : (4, 64)
    """
    found[0] = found[1] = 0.0
    grade = GRADED[0] if tolerance >= 1e-7 else GRADED[1] if tolerance >= 1e-10 else GRADED[2]
    for i in range(np_):
        for j in range(nq):
            _edge_pair(
                p[i], p[(i + 1) % np_], q[j], q[(j + 1) % nq], tolerance, grade, scratch, found
            )
    found[0] = max(0.0, found[0] / (2.0 * math.pi))
    found[1] *= EPS / (2.0 * math.pi)
