"""Smoothing of gathered indirect light between pixels that look at the same face.

Indirect irradiance varies slowly on a face, over lengths in proportion to the distance of what
surrounds it (Ward, Rubinstein & Clear 1988). So the estimates of pixels within a share `REACH` of
that distance are fitted by a plane, whose value at the pixel has less noise and no first-order
bias.
Pixels whose sight lines met several faces are left as they are; direct light is never smoothed.
"""

import numpy as np
from numba import njit

from radiosity.transport.threads import over_ranges

REACH = 0.2  # of the harmonic mean distance to the surroundings
WINDOW = 8  # pixels to each side at most
MIXED = -1


def smoothed(irradiance, position, nearness, face, axes) -> np.ndarray:
    """Return irradiance (h, w, bands) with the noise between pixels of one face averaged out.

    Parameters
    ----------
    irradiance : (h, w, bands) float64
        Noisy, independent from pixel to pixel.
    position : (h, w, 3) float64
        Mean point that a pixel looks at, scene units.
    nearness : (h, w) float64
        Mean of 1/distance to the surroundings.
    face : (h, w) int
        Face and side, `MIXED` where a pixel is to be left alone.
    axes : (m, 2, 3) float64
        For each value of ``face`` two directions that span its plane.
    """
    out = irradiance.copy()
    args = irradiance, position, nearness, face, axes, out
    over_ranges(lambda a, b: _smooth_rows(a, b, *args), len(out), 8)
    return out


@njit(cache=True, nogil=True)
def _smooth_rows(first, stop, irradiance, position, nearness, face, axes, out):
    height, width, bands = irradiance.shape
    m, t = np.empty(6), np.empty((bands, 3))
    for i in range(first, stop):
        for j in range(width):
            f = face[i, j]
            if f < 0 or nearness[i, j] <= 0.0:
                continue
            reach2 = (REACH / nearness[i, j]) ** 2
            m[:] = 0.0
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
                        _add(m, t, (1.0 - far) ** 2, u, v, irradiance[y, x])
            _plane_value(m, t, out[i, j])


@njit(cache=True, nogil=True, inline="always")
def _add(m, t, w, u, v, value):
    """Add one sample to the moments of a weighted plane fit."""
    m[0] += w
    m[1] += w * u
    m[2] += w * v
    m[3] += w * u * u
    m[4] += w * u * v
    m[5] += w * v * v
    for b in range(len(value)):
        t[b, 0] += w * value[b]
        t[b, 1] += w * u * value[b]
        t[b, 2] += w * v * value[b]


@njit(cache=True, nogil=True, inline="always")
def _plane_value(m, t, value):
    """Write the fitted plane's value at the origin; the mean where samples lie on a line."""
    c0 = m[3] * m[5] - m[4] * m[4]
    c1 = m[4] * m[2] - m[1] * m[5]
    c2 = m[1] * m[4] - m[3] * m[2]
    det = m[0] * c0 + m[1] * c1 + m[2] * c2
    tilted = det > 1e-3 * m[0] * m[3] * m[5] and det > 0.0
    for b in range(len(value)):
        if tilted:
            value[b] = max(0.0, (c0 * t[b, 0] + c1 * t[b, 1] + c2 * t[b, 2]) / det)
        else:
            value[b] = t[b, 0] / m[0]
