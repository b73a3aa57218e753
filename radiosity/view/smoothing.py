"""Smoothing of indirect light between pixels that look at one face.

Indirect irradiance changes slowly over a face, the slower the farther its surroundings are (Ward,
Rubinstein & Clear 1988), so noise may be averaged over a fifth of their harmonic mean distance. A
plane fitted by weighted least squares leaves slopes as they are, and tells how far pixels scatter
about it.
"""

import numpy as np
from numba import njit

from radiosity.transport.threads import over_ranges

REACH = 0.2  # of the harmonic mean distance to the surroundings
WINDOW = 8  # pixels to each side at most
MIXED = -1
FREE = 2.0  # degrees of freedom that the scatter between passes counts for


def smoothed(irradiance, luminance, spread, count, position, nearness, face, axes):
    """Return irradiance with the noise between pixels of one face averaged out, and its error.

    Parameters
    ----------
    irradiance : (h, w, bands) float64
        Noisy means of passes, independent from pixel to pixel.
    luminance : (h, w) float64
        Of it, or the band or sum of bands whose error is asked for.
    spread : (h, w) float64
        Variance of one pass's luminance.
    count : (h, w) int
        Passes.
    position : (h, w, 3) float64
        Mean point that a pixel looks at, scene units.
    nearness : (h, w) float64
        Mean of 1/distance to the surroundings.
    face : (h, w) int
        Face and side, `MIXED` where a pixel is to be left alone.
    axes : (m, 2, 3) float64
        For each value of ``face`` two directions that span its plane.

    Returns
    -------
    smooth : (h, w, bands) float64
    error : (h, w) float64
        Standard error of its luminance, from how far the pixels scatter about the fit and, with
        the weight of two of them, their passes about their means; 0 where left alone.
    """
    out, error = irradiance.copy(), np.zeros(irradiance.shape[:2])
    args = irradiance, luminance, spread, count, position, nearness, face, axes, out, error
    over_ranges(lambda a, b: _smooth_rows(a, b, *args), len(out), 8)
    return out, error


@njit(cache=True, nogil=True)
def _smooth_rows(
    first, stop, irradiance, luminance, spread, count, position, nearness, face, axes, out, error
):
    height, width, bands = irradiance.shape
    m, q, s, t = np.empty(6), np.empty(6), np.empty(6), np.empty((bands, 3))
    for i in range(first, stop):
        for j in range(width):
            f = face[i, j]
            if f < 0 or nearness[i, j] <= 0.0:
                continue
            reach2 = (REACH / nearness[i, j]) ** 2
            m[:] = 0.0
            q[:] = 0.0
            s[:] = 0.0
            t[:] = 0.0
            for y in range(max(0, i - WINDOW), min(height, i + WINDOW + 1)):
                for x in range(max(0, j - WINDOW), min(width, j + WINDOW + 1)):
                    if face[y, x] != f:
                        continue
                    u = v = 0.0
                    for c in range(3):
                        d = position[y, x, c] - position[i, j, c]
                        u += d * axes[f, 0, c]
                        v += d * axes[f, 1, c]
                    far = (u * u + v * v) / reach2
                    if far < 1.0:
                        k = (1.0 - far) ** 2
                        _add_place(m, k * count[y, x], u, v)
                        _add_place(q, k * k * count[y, x], u, v)
                        _add_value(t, k * count[y, x], u, v, irradiance[y, x])
                        above = luminance[y, x] - luminance[i, j]
                        _add_scatter(s, k, k * count[y, x], u, v, above, spread[y, x])
            error[i, j] = _plane_value(m, q, s, t, out[i, j])


@njit(cache=True, nogil=True, inline="always")
def _add_place(m, w, u, v):
    """Add a place to the moments sum w (1, u, v, u^2, u v, v^2)."""
    m[0] += w
    m[1] += w * u
    m[2] += w * v
    m[3] += w * u * u
    m[4] += w * u * v
    m[5] += w * v * v


@njit(cache=True, nogil=True, inline="always")
def _add_value(t, w, u, v, value):
    for b in range(len(value)):
        t[b, 0] += w * value[b]
        t[b, 1] += w * u * value[b]
        t[b, 2] += w * v * value[b]


@njit(cache=True, nogil=True, inline="always")
def _add_scatter(s, k, w, u, v, y, spread):
    s[0] += w * y
    s[1] += w * u * y
    s[2] += w * v * y
    s[3] += w * y * y
    s[4] += k
    s[5] += k * spread


@njit(cache=True, nogil=True, inline="always")
def _plane_value(m, q, s, t, value):
    """Write the fitted plane's value at the origin, or the mean where samples lie on a line.

    Returns its standard error. With weights w = k n of pixels that scatter by sigma^2/n about the
    plane, the inverse P of m and the moments q of k^2 n: the value varies by sigma^2 (P q P)_00 and
    the residuals sum to sigma^2 (sum k - tr P q).
    """
    p00 = m[3] * m[5] - m[4] * m[4]
    p01 = m[4] * m[2] - m[1] * m[5]
    p02 = m[1] * m[4] - m[3] * m[2]
    det = m[0] * p00 + m[1] * p01 + m[2] * p02
    p11 = p12 = p22 = 0.0
    if det > 1e-3 * m[0] * m[3] * m[5] and det > 0.0:
        p11 = (m[0] * m[5] - m[2] * m[2]) / det
        p12 = (m[1] * m[2] - m[0] * m[4]) / det
        p22 = (m[0] * m[3] - m[1] * m[1]) / det
        p00, p01, p02 = p00 / det, p01 / det, p02 / det
    else:
        p00, p01, p02 = 1.0 / m[0], 0.0, 0.0
    for b in range(len(value)):
        value[b] = max(0.0, p00 * t[b, 0] + p01 * t[b, 1] + p02 * t[b, 2])
    cross = p01 * q[1] + p02 * q[2] + p12 * q[4]
    free = s[4] - (p00 * q[0] + p11 * q[3] + p22 * q[5] + 2.0 * cross)
    cross = p01 * s[0] * s[1] + p02 * s[0] * s[2] + p12 * s[1] * s[2]
    left = s[3] - (p00 * s[0] ** 2 + p11 * s[1] ** 2 + p22 * s[2] ** 2 + 2.0 * cross)
    variance = (max(0.0, left) + FREE * s[5] / s[4]) / (max(0.0, free) + FREE)
    cross = p00 * p01 * q[1] + p00 * p02 * q[2] + p01 * p02 * q[4]
    share = p00 * p00 * q[0] + p01 * p01 * q[3] + p02 * p02 * q[5] + 2.0 * cross
    return np.sqrt(max(0.0, variance * share))
