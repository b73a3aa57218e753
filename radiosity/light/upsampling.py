"""From red, green and blue to spectra: smooth ones that look as the numbers do in daylight.

RGB reflectances are mixed of three spectra between 0 and 1 that add up to 1, so that mixtures of
what is in [0, 1] are too and grey stays flat; RGB light is that mixture of daylight, D65. Seen in
daylight, each of the three has exactly the colour of its primary (Mallett & Yuksel 2019, "Spectral
primary decomposition for rendering with sRGB reflectance"). They are the smoothest such spectra,
found anew for the cells that are computed in, so that they are exact there.
"""

from functools import cache

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import nnls

from radiosity.light.spectrum import cells, daylight, watts

FIRM = 1e5  # weight of what must hold against what is to be smooth, until it is made exact


@cache
def white(count: int) -> np.ndarray:
    """Return (count,) watts a cell of daylight whose RGB is exactly (1, 1, 1).

    The white of sRGB is that of D65, rounded; cells err by more: the least change makes up for
    both.
    """
    rgb, found = cells(count).rgb, watts(daylight(), count)
    change = np.linalg.lstsq(rgb * found, 1.0 - rgb @ found, rcond=None)[0]
    return found * (1.0 + change)


@cache
def primaries(count: int) -> np.ndarray:
    """Return (count, 3): the reflectances of red, green and blue in each cell.

    Of all b >= 0 with sum over colours 1 in each cell and RGB(b_k white) = e_k, those of the
    least sum over k of (difference of neighbours)^2 / (distance of neighbours).
    """
    bands = cells(count)
    steps = np.diff(np.eye(count), axis=0) / np.sqrt(np.diff(bands.wavelengths))[:, None]
    smooth = block_diag(steps, steps, steps)
    colours = block_diag(*[bands.rgb * white(count)] * 3)
    exact = np.vstack([colours, np.tile(np.eye(count), 3)])
    wanted = np.concatenate([np.eye(3).ravel(), np.ones(count)])
    scale = np.linalg.norm(smooth)
    rows = np.vstack([smooth / scale, FIRM * exact])
    found, _ = nnls(rows, np.concatenate([np.zeros(len(smooth)), FIRM * wanted]))
    used = found > 0.0
    found[used] = _constrained(smooth[:, used], exact[:, used], wanted)
    return np.maximum(found, 0.0).reshape(3, count).T


def _constrained(smooth, exact, wanted):
    """Return the x of least |smooth x| for which exact x = wanted."""
    n, m = smooth.shape[1], len(wanted)
    matrix = np.block([[smooth.T @ smooth, exact.T], [exact, np.zeros((m, m))]])
    right = np.concatenate([np.zeros(n), wanted])
    return np.linalg.lstsq(matrix, right, rcond=None)[0][:n]
