"""Sample points that are even, repeatable and the same for any number of threads.

Sobol points in four dimensions, shifted digit by digit with a hash of what is sampled
(Sobol 1967; direction numbers of Joe & Kuo 2008). What needs more dimensions takes further points
in an order of their own (Burley 2020, "Practical hash-based Owen scrambling").
"""

import math

import numpy as np
from numba import njit

from radiosity.transport.polygon import first_half, place_evenly

BITS = 32
UNIT = 1.0 / 4294967296.0


def _direction_numbers() -> np.ndarray:
    """Return (4, 32) direction numbers: van der Corput, then the polynomials of degree 1 to 3."""
    table = np.zeros((4, BITS), np.uint64)
    table[0] = [1 << (31 - k) for k in range(BITS)]
    for row, (degree, inner, start) in enumerate([(1, 0, [1]), (2, 1, [1, 3]), (3, 1, [1, 3, 1])]):
        m = list(start)
        for k in range(degree, BITS):
            value = m[k - degree] ^ (m[k - degree] << degree)
            for q in range(1, degree):
                if (inner >> (degree - 1 - q)) & 1:
                    value ^= m[k - q] << q
            m.append(value)
        table[row + 1] = [m[k] << (31 - k) for k in range(BITS)]
    return table


DIRECTIONS = _direction_numbers()


@njit(cache=True, nogil=True, error_model="numpy")
def hashed(a, b, c):
    """Mix three integers into 64 well-scrambled bits (splitmix64)."""
    x = np.uint64(a) * np.uint64(0x9E3779B97F4A7C15)
    x ^= np.uint64(b) + np.uint64(0xD1B54A32D192ED03) + (x << np.uint64(6))
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x ^= np.uint64(c) * np.uint64(0x94D049BB133111EB)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@njit(cache=True, nogil=True, error_model="numpy")
def sobol(index, dimension, shift):
    """Coordinate of one Sobol point in [0, 1), its digits shifted by 32 bits of ``shift``."""
    return shifted(_digits(index, dimension), shift)


@njit(cache=True, nogil=True, error_model="numpy")
def shuffled(index, key):
    """Return where a point comes in an order hashed from a key, below 2^32.

    Any 2^k points from a multiple of 2^k on are such points again, so still even (Laine & Karras
    2011, "Stratified sampling for stochastic transparency"; constants of Burley 2020). By its order
    a sequence is independent of others that count along with it.
    """
    x = _reversed(np.uint64(index)) + (np.uint64(key) & np.uint64(0xFFFFFFFF))
    for factor in (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6):
        x ^= x * np.uint64(factor)
        x &= np.uint64(0xFFFFFFFF)
    return np.int64(_reversed(x))


@njit(cache=True, nogil=True, error_model="numpy")
def _reversed(x):
    """Return 32 bits in reverse."""
    y = np.uint64(0)
    for _ in range(BITS):
        y = (y << np.uint64(1)) | (x & np.uint64(1))
        x >>= np.uint64(1)
    return y


@njit(cache=True, nogil=True, error_model="numpy")
def sobol_digits(first, count):
    """Return (count, 4) digits of the points from ``first`` on, for many to be `shifted`."""
    digits = np.empty((count, 4), np.uint64)
    for k in range(count):
        for d in range(4):
            digits[k, d] = _digits(first + k, d)
    return digits


@njit(cache=True, nogil=True, error_model="numpy")
def shifted(digits, shift):
    """Coordinate in [0, 1) of digits shifted by 32 bits of ``shift``."""
    return float(digits ^ (shift & np.uint64(0xFFFFFFFF))) * UNIT


@njit(cache=True, nogil=True, error_model="numpy")
def _digits(index, dimension):
    bits = np.uint64(0)
    k = 0
    while index:
        if index & 1:
            bits ^= DIRECTIONS[dimension, k]
        index >>= 1
        k += 1
    return bits


@njit(cache=True, nogil=True, error_model="numpy")
def places(polygons, dimension, shifts):
    """Return (m, 3) one point in each of polygons (m, 4, 3), evenly spread over all of them.

    By two coordinates, from ``dimension`` on, of the Sobol points, with shifts (m,) uint64.
    """
    points = np.empty((len(polygons), 3))
    for k in range(len(polygons)):
        s = sobol(k, dimension, shifts[k])
        t = sobol(k, dimension + 1, shifts[k] >> np.uint64(32))
        place_evenly(polygons[k], first_half(polygons[k]), s, t, points[k])
    return points


@njit(cache=True, nogil=True, error_model="numpy")
def cosine_direction(u, v, n, out):
    """Write a direction about the unit normal n with density cos(theta)/pi into out.

    Polar map of the unit square; frame of Duff et al. 2017.
    """
    r, phi = math.sqrt(u), 2.0 * math.pi * v
    x, y, z = r * math.cos(phi), r * math.sin(phi), math.sqrt(max(0.0, 1.0 - u))
    sign = math.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    out[0] = x * (1.0 + sign * n[0] * n[0] * a) + y * b + z * n[0]
    out[1] = x * sign * b + y * (sign + n[1] * n[1] * a) + z * n[1]
    out[2] = -x * sign * n[0] - y * n[1] + z * n[2]
