"""Spectra: quantities a nm of wavelength, what the eye makes of them, and cells to compute in.

A spectrum is integrated as the sum over whole nm from 360 to 830, linear between its own points
(CIE 15). Where light is computed, few cells of wavelengths take the place of these 471: they are
narrow where the eye sees much, and a spectrum counts in each with its mean as the eye weighs it.
"""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from radiosity.light.bands import FEWEST, MOST, Bands
from radiosity.light.colour import XYZ_TO_RGB


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Values at wavelengths, linear between them.

    Attributes
    ----------
    nm : (k,) float64
        Ascending.
    values : (k,) float64
        Of light in its unit a nm; of anything else as they are.
    name : str
    """

    nm: np.ndarray
    values: np.ndarray
    name: str = ""

    def light(self) -> np.ndarray:
        """Return (471,) values on whole nm, none outside of what is given."""
        return np.interp(nanometres(), self.nm, self.values, left=0.0, right=0.0)

    def share(self) -> np.ndarray:
        """Return (471,) values on whole nm, the first and the last going on outside (CIE 15)."""
        return np.interp(nanometres(), self.nm, self.values)


@cache
def _table() -> np.ndarray:
    """Return (471, 5): nm, the CIE 1931 functions for 2 degrees, and D65."""
    text = (files("radiosity.light") / "data" / "cie1931.csv").read_text(encoding="ascii")
    rows = [line for line in text.splitlines() if line[0].isdigit()]
    return np.array([line.split(",") for line in rows], float)


def nanometres() -> np.ndarray:
    """Return the wavelengths (471,) that spectra are summed over, 360 to 830 nm."""
    return _table()[:, 0]


def matching() -> np.ndarray:
    """Return (471, 3): the colour-matching functions of the CIE 1931 observer for 2 degrees."""
    return _table()[:, 1:4]


def daylight() -> np.ndarray:
    """Return (471,) W/nm of illuminant D65 whose luminance is 1, so that Y = sum S ybar = 1."""
    d65 = _table()[:, 4]
    return d65 / (d65 @ matching()[:, 1])


def tristimulus(values: np.ndarray) -> np.ndarray:
    """Return (..., 3) X, Y, Z of spectra (..., 471): sums over whole nm (E21).

    X = sum S(lambda) xbar(lambda) dlambda, and so on (Szirmay-Kalos, eq. 3.9), not normalised:
    683 lm/W times Y is the photometric quantity.
    """
    return np.asarray(values, float) @ matching()


def colour_of(share: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Return (..., 3) RGB of light that a reflectance leaves of a source, over that of the source.

    RGB(rho S)/RGB(S); where a source has no such component, the luminous reflectance takes its
    place. Both (..., 471). Values below 0 and above 1 occur: such colours lie outside of sRGB.
    """
    left, whole = tristimulus(share * source), tristimulus(source)
    rgb, white = left @ XYZ_TO_RGB.T, XYZ_TO_RGB @ whole
    seen = white > 1e-3 * white.max()
    grey = left[..., 1:2] / whole[1]
    return np.where(seen, rgb / np.where(seen, white, 1.0), grey)


@cache
def cells(count: int) -> Bands:
    """Return ``count`` cells of wavelengths that cover 360 to 830 nm as bands.

    Of equal sums of sqrt(w), w = xbar/X + ybar/Y + zbar/Z with X, Y, Z the sums of the functions:
    measured to err less than by equal widths, by w and by its cube root (docs/colour.md).

    Raises
    ------
    ValueError
        Fewer than FEWEST or more than MOST.
    """
    if not FEWEST <= count <= MOST:
        raise ValueError(f"{count} wavelengths must lie between {FEWEST} and {MOST}")
    xyz = _overlap(count) @ matching() / _widths(count)[:, None]
    middle = means(nanometres(), count)
    names = tuple(f"{nm:.4g}nm" for nm in middle)
    return Bands(names, XYZ_TO_RGB @ xyz.T, xyz[:, 1], middle)


def means(values: np.ndarray, count: int) -> np.ndarray:
    """Return (count,) the means of a spectrum (471,) in the `cells`, as the eye weighs it.

    A flat one has the same in all of them, to the last digit, so that it is solved once.
    """
    weight, least = _overlap(count) * _seen(), values.min()
    return least + weight @ (values - least) / weight.sum(axis=1)


def watts(values: np.ndarray, count: int) -> np.ndarray:
    """Return (count,) the power in the `cells` of light (471,): its `means` times their widths."""
    return means(values, count) * _widths(count)


def _seen() -> np.ndarray:
    """Return w (471,): how much each wavelength adds to what is seen, in all."""
    return (matching() / matching().sum(axis=0)).sum(axis=1)


@cache
def _overlap(count: int) -> np.ndarray:
    """Return (count, 471) the nm that each cell covers of each whole nm."""
    running = np.concatenate([[0.0], np.cumsum(np.sqrt(_seen()))])
    ends = nanometres()[0] - 0.5 + np.arange(len(running))
    edges = np.interp(np.linspace(0.0, running[-1], count + 1), running, ends)
    low, high = np.maximum(edges[:-1, None], ends[:-1]), np.minimum(edges[1:, None], ends[1:])
    return np.maximum(high - low, 0.0)


def _widths(count: int) -> np.ndarray:
    return _overlap(count).sum(axis=1)
