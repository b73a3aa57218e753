"""Bands: the parts that light is divided into, each computed by itself, and what the eye makes.

A colour is one number a band: three in linear sRGB (BT.709), one where all is grey, or the watts
in each of some cells of wavelengths. Watts of different bands are never summed: what a quantity
looks like is `Bands.luminance` and `Bands.to_rgb`, both weighted by the eye.
"""

from dataclasses import dataclass

import numpy as np

LUMINANCE = (0.2126, 0.7152, 0.0722)  # share of a band in the luminance, IEC 61966-2-1
FEWEST, MOST = 8, 128  # wavelengths: with fewer, red, green and blue have no spectra in [0, 1]


@dataclass(frozen=True, eq=False)
class Bands:
    """What the numbers of a colour stand for.

    Attributes
    ----------
    names : (n,) tuple of str
    rgb : (3, n) float64
        Linear sRGB of a unit of each band; single wavelengths lie outside its gamut, so negative
        values occur.
    y : (n,) float64
        Luminance of a unit of each band: E_v = K y . E, K = 683 lm/W.
    wavelengths : (n,) float64 or None
        The middles of cells of wavelengths, nm.
    """

    names: tuple[str, ...]
    rgb: np.ndarray
    y: np.ndarray
    wavelengths: np.ndarray | None = None

    @property
    def count(self) -> int:
        """Return n."""
        return len(self.names)

    def luminance(self, values: np.ndarray) -> np.ndarray:
        """Return Y = y . values, (...), of values (..., n), in their unit."""
        return np.asarray(values, float) @ self.y

    def to_rgb(self, values: np.ndarray) -> np.ndarray:
        """Return (..., 3) linear sRGB of values (..., n), in their unit; negative out of gamut."""
        return values if self is RGB else np.asarray(values, float) @ self.rgb.T


RGB = Bands(("r", "g", "b"), np.eye(3), np.array(LUMINANCE))
GREY = Bands(("grey",), np.ones((3, 1)), np.ones(1))


def mixed(rgb: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return (..., n) what shares (n, 3), which add up to 1, mix of RGB (..., 3).

    Where the three are equal, all are, to the last digit.
    """
    rgb = np.asarray(rgb, float)
    flat = rgb.min(axis=-1, keepdims=True)
    return flat + (rgb - flat) @ shares.T
