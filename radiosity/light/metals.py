"""Metals: complex indices of refraction, nu + kappa j, by wavelength and for the bands of sRGB."""

import json
from functools import cache
from importlib import resources

import numpy as np


def metal_index(name, wavelengths) -> np.ndarray:
    """Return a metal's complex index at wavelengths in nm, linear between measured values.

    Measured by Rakic (1995; aluminium) and Johnson & Christy (1972, 1974; the others), as given by
    the refractiveindex.info database of M. N. Polyanskiy (public domain, CC0).

    Parameters
    ----------
    name : str
        One of `metal_names`.
    wavelengths : float or ndarray
        From 380 to 780 nm, of any shape, which the result has too.

    Raises
    ------
    ValueError
        An unknown metal, or a wavelength outside the table.
    """
    table, nm = _metal(name), np.asarray(wavelengths, dtype=np.float64)
    known = _data()["wavelengths"]
    if not np.all((nm >= known[0]) & (nm <= known[-1])):
        raise ValueError(
            f"wavelengths = {wavelengths} must lie between {known[0]} and {known[-1]} nm, "
            f"where the index of {name} is tabulated"
        )
    return np.interp(nm, known, table["n"]) + 1j * np.interp(nm, known, table["k"])


def metal_bands(name) -> np.ndarray:
    """Return (3,) effective complex indices of a metal for the bands of linear sRGB.

    Each band's index is the one whose Fresnel reflectance is nearest, in the mean square over
    angles from 0 to 85 degrees, to sum_w F(wavelength w), w the share of a wavelength in the band
    under light of equal energy (CIE 1931 observer and the sRGB matrix; `band_weights`). A sum
    outside the values that F takes over the visible wavelengths, as for the red of gold, whose
    colour lies outside sRGB, is moved to the nearest of them: nothing reflects more than arrives.
    """
    table = _metal(name)
    return np.array(table["rgb_n"]) + 1j * np.array(table["rgb_k"])


def band_weights() -> tuple[np.ndarray, np.ndarray]:
    """Return wavelengths (w,) in nm and the weights (3, w) that make them bands; rows sum to 1."""
    data = _data()
    weights = np.array([data["weights"][band] for band in "rgb"])
    return np.array(data["wavelengths"], dtype=np.float64), weights


def metal_range() -> tuple[float, float]:
    """Return the shortest and the longest wavelength in nm at which indices are known."""
    known = _data()["wavelengths"]
    return known[0], known[-1]


def metal_names() -> tuple[str, ...]:
    """Return the names of the metals whose indices are known."""
    return tuple(_data()["metals"])


def _metal(name):
    metals = _data()["metals"]
    if name not in metals:
        raise ValueError(f"metal = {name!r} must be one of {', '.join(metals)}")
    return metals[name]


@cache
def _data():
    file = resources.files("radiosity") / "light" / "data" / "metals.json"
    return json.loads(file.read_text(encoding="utf-8"))
