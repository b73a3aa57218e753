"""Rays aimed at some triangles from points: directions spread evenly over the angles they fill.

A triangle of the solid angle O gets O/(sum of all) of the rays, each of which counts for
cos(theta)/pi times that sum (`aimed_rays`). Evenly over a spherical triangle: Arvo (1995),
"Stratified sampling of spherical triangles"; over the plane one where it fills next to nothing, in
which that would cancel.
"""

import math
from collections import namedtuple

import numpy as np
from numba import njit

from radiosity.mesh.faces import Faces
from radiosity.transport.borrow import borrowed
from radiosity.transport.sampling import hashed, sobol
from radiosity.transport.visibility import LIFT, Visibility

SMALL = 1e-3  # solid angle, sr, below which a triangle is taken for a plane one
SALT = 1 << 46
GRAZING = 1e-6  # height over a triangle, in ray coordinates, from which it is seen at all

Targets = namedtuple("Targets", "corners normal face sides")
Targets.__doc__ = """Triangles that rays are aimed at, in ray coordinates.

corners (t, 3, 3), normal (t, 3), face (t,); sides (t, 2) bool: whether front and back are wanted.
"""


def make_targets(faces: Faces, visibility: Visibility, wanted: np.ndarray) -> Targets:
    """Return the triangles of faces whose fronts or backs are ``wanted`` (f, 2) bool."""
    k = np.flatnonzero(wanted.any(axis=1))
    v = (faces.vertices[k] - visibility.centre) * visibility.scale
    quad = np.flatnonzero(~faces.is_triangle[k])
    corners = np.concatenate([v[:, :3], v[quad][:, [0, 2, 3]]])
    face = np.concatenate([k, k[quad]])
    return Targets(corners, faces.normals()[face], face, wanted[face])


def aimed_rays(
    visibility: Visibility, targets: Targets, points: np.ndarray, normals: np.ndarray,
    keys: np.ndarray, samples: range, seed: int,
):  # fmt: skip
    """Return rays from points to targets.

    Parameters
    ----------
    points, normals, keys, samples, seed
        As for `radiosity.transport.hemisphere.look_out`; of a normal 0 there is no horizon.

    Returns
    -------
    origins, directions : (k len(samples), 3) float32
        In ray coordinates.
    face : (k len(samples),) int
        That each is aimed at, -1 where there is none.
    factor : (k len(samples),) float64
        What a ray counts for that meets it, in the mean over all from its point: the solid angle
        times cos(theta)/pi, 0 below the horizon; times 1/pi where there is none.
    """
    count = len(samples)
    rays = len(points) * count
    origins, directions = np.empty((rays, 3), np.float32), np.zeros((rays, 3), np.float32)
    face, factor = np.full(rays, -1), np.zeros(rays)
    x = (points - visibility.centre) * visibility.scale
    running = np.empty(len(targets.face))
    _aim(
        x, normals, keys, samples.start, count, seed, LIFT, targets, running, origins, directions,
        face, factor,
    )  # fmt: skip
    return origins, directions, face, factor


@njit(cache=True, nogil=True, error_model="numpy")
def _aim(
    points, normals, keys, first, count, seed, lift, targets, running, origins, directions, face,
    factor,
):  # fmt: skip
    points, normals, targets = borrowed((points, normals, targets))
    a, b, c, d, x = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for p in range(len(points)):
        n, total = normals[p], 0.0
        free = _dot(n, n) == 0.0
        for i in range(3):
            x[i] = points[p, i] + lift * n[i]
        for t in range(len(running)):
            total += _angle(x, n, free, targets, t, a, b, c)
            running[t] = total
        shift = hashed(keys[p], SALT, seed)
        for k in range(count):
            r = p * count + k
            origins[r, 0], origins[r, 1], origins[r, 2] = x[0], x[1], x[2]
            directions[r, 0] = 1.0
            if total <= 0.0:
                continue
            left = sobol(first + k, 0, shift) * total
            t = min(np.searchsorted(running, left, "right"), len(running) - 1)
            angle = running[t] - (running[t - 1] if t > 0 else 0.0)
            u = min((left - running[t] + angle) / angle, 1.0 - 1e-12)
            v = sobol(first + k, 1, shift >> np.uint64(32))
            _to_corners(x, targets.corners[t], a, b, c)
            weight = total
            if angle < SMALL:
                _plane(x, targets, t, u, v, d)
                weight *= _stretch(x, targets, t, d) / angle
            else:
                _spherical(a, b, c, u, v, angle, d)
            cosine = 1.0 if free else d[0] * n[0] + d[1] * n[1] + d[2] * n[2]
            directions[r, 0], directions[r, 1], directions[r, 2] = d[0], d[1], d[2]
            face[r] = targets.face[t]
            factor[r] = max(0.0, cosine) * weight / math.pi


@njit(cache=True, nogil=True, error_model="numpy")
def _to_corners(x, corners, a, b, c):
    """Write the unit vectors to a triangle's corners."""
    for out, k in ((a, 0), (b, 1), (c, 2)):
        length = 0.0
        for i in range(3):
            out[i] = corners[k, i] - x[i]
            length += out[i] * out[i]
        length = math.sqrt(max(length, 1e-300))
        for i in range(3):
            out[i] /= length


@njit(cache=True, nogil=True, error_model="numpy")
def _angle(x, n, free, targets, t, a, b, c):
    """Return the solid angle of a triangle from a point, 0 where a side not wanted is seen.

    tan(O/2) = |a . b x c|/(1 + a.b + b.c + c.a); van Oosterom & Strackee (1983).
    """
    height, above = 0.0, free
    for i in range(3):
        height += (x[i] - targets.corners[t, 0, i]) * targets.normal[t, i]
    back = 0 if height > 0.0 else 1
    if abs(height) < GRAZING or not targets.sides[t, back]:
        return 0.0
    for k in range(3):
        over = 0.0
        for i in range(3):
            over += (targets.corners[t, k, i] - x[i]) * n[i]
        above = above or over > 0.0
    if not above:
        return 0.0
    _to_corners(x, targets.corners[t], a, b, c)
    volume = abs(_dot_cross(a, b, c))
    return 2.0 * math.atan2(volume, 1.0 + _dot(a, b) + _dot(b, c) + _dot(c, a))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _dot_cross(a, b, c):
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _spherical(a, b, c, u, v, angle, d):
    """Write a direction spread evenly over a spherical triangle."""
    cosine = _dihedral(a, b, c)
    sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    part = u * angle - math.acos(cosine)
    s, t = math.sin(part), math.cos(part)
    p, q = t - cosine, s + sine * _dot(a, b)
    low = (q * s + p * t) * sine
    along = 1.0 if low == 0.0 else ((q * t - p * s) * cosine - q) / low
    along = min(1.0, max(-1.0, along))
    across = math.sqrt(1.0 - along * along)
    r0, r1, r2 = _right(c, a)
    e0, e1, e2 = along * a[0] + across * r0, along * a[1] + across * r1, along * a[2] + across * r2
    z = 1.0 - v * (1.0 - (e0 * b[0] + e1 * b[1] + e2 * b[2]))
    rest = math.sqrt(max(0.0, 1.0 - z * z))
    d[0], d[1], d[2] = e0, e1, e2
    r0, r1, r2 = _right(d, b)
    d[0], d[1], d[2] = z * b[0] + rest * r0, z * b[1] + rest * r1, z * b[2] + rest * r2


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _right(c, a):
    """Return the unit part of c at right angles to a."""
    k = _dot(c, a)
    x, y, z = c[0] - k * a[0], c[1] - k * a[1], c[2] - k * a[2]
    length = math.sqrt(max(x * x + y * y + z * z, 1e-300))
    return x / length, y / length, z / length


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _dihedral(a, b, c):
    """Return the cosine of the angle at a of a spherical triangle."""
    p0, p1, p2 = _right(b, a)
    q0, q1, q2 = _right(c, a)
    return min(1.0, max(-1.0, p0 * q0 + p1 * q1 + p2 * q2))


@njit(cache=True, nogil=True, error_model="numpy")
def _plane(x, targets, t, u, v, d):
    """Write the way to a point spread evenly over a plane triangle."""
    root = math.sqrt(u)
    for i in range(3):
        p, q = targets.corners[t, 1, i], targets.corners[t, 2, i]
        first = targets.corners[t, 0, i]
        d[i] = first + root * ((p - first) * (1.0 - v) + (q - first) * v) - x[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _stretch(x, targets, t, d):
    """Return cos A/r^2 of a point of a triangle, and make the way to it a unit vector."""
    r2 = max(_dot(d, d), 1e-300)
    length = math.sqrt(r2)
    cosine = abs(_dot(d, targets.normal[t])) / length
    e, f = np.empty(3), np.empty(3)
    for i in range(3):
        d[i] /= length
        e[i] = targets.corners[t, 1, i] - targets.corners[t, 0, i]
        f[i] = targets.corners[t, 2, i] - targets.corners[t, 0, i]
    area = 0.5 * abs(_dot_cross(targets.normal[t], e, f))
    return cosine * area / r2
