"""Photometry: watts of bands, lumens, and the radiance that emits a given amount.

Watts of different bands are never summed: a total that is not weighted by the eye does not exist
here, see `radiosity.light.bands`.
"""

import numpy as np

from radiosity.light.bands import RGB, Bands

EFFICACY = 683.0  # lm/W at 540 THz, the SI definition of the candela
WHITE = np.ones(3)  # of three bands, neutral light whose luminance is 1


def luminance(values: np.ndarray, bands: Bands = RGB) -> np.ndarray:
    """Return the luminance-weighted sum of bands; of RGB Y = 0.2126 R + 0.7152 G + 0.0722 B.

    Parameters
    ----------
    values : (..., n) float
        Any radiometric quantity per band.

    Returns
    -------
    (...) float64
        In the unit of ``values``; times `EFFICACY` it is the photometric quantity.
    """
    return bands.luminance(values)


def photometric(values: np.ndarray, bands: Bands = RGB, efficacy: float = EFFICACY) -> np.ndarray:
    """Return K Y: lm of W, lx of W/m2, cd of W/sr, cd/m2 of W/(m2 sr), K the efficacy in lm/W."""
    return efficacy * luminance(values, bands)


def illuminance(
    irradiance: np.ndarray, bands: Bands = RGB, efficacy: float = EFFICACY
) -> np.ndarray:
    """Return E_v = K Y(E) in lx for irradiance (..., n) in W/m2, K the efficacy in lm/W."""
    return photometric(irradiance, bands, efficacy)


def radiance_from_exitance(exitance: np.ndarray) -> np.ndarray:
    """Return L = M / pi, (n,) W/(m2 sr), of a Lambertian emitter of exitance M (W/m2).

    A single number stands for each of three bands.
    """
    return _bands(exitance) / np.pi


def radiance_from_luminance(
    value: float, white: np.ndarray = WHITE, efficacy: float = EFFICACY
) -> np.ndarray:
    """Return the neutral radiance L = L_v / K, (n,) W/(m2 sr), of luminance L_v (cd/m2).

    ``white`` (n,) is what bands hold of neutral light whose luminance-weighted sum is 1.
    """
    return value * white / efficacy


def radiance_from_radiant_flux(flux: np.ndarray, area: float) -> np.ndarray:
    """Return L = Phi / (pi A), (n,) W/(m2 sr), of an emitter that sends out Phi watts a band.

    Parameters
    ----------
    flux : float or (n,) float
        W per band over all of the emitter's front; a single number stands for each of three bands.
    area : float
        Area A of all faces that share the flux, m2.

    Raises
    ------
    ValueError
        If the area is not positive and finite.
    """
    if not (0 < area < np.inf):
        raise ValueError(f"area = {area} m2 must be positive: no face is there to emit the flux")
    return radiance_from_exitance(_bands(flux) / area)


def radiance_from_luminous_flux(
    flux: float, area: float, white: np.ndarray = WHITE, efficacy: float = EFFICACY
) -> np.ndarray:
    """Return the neutral radiance, (n,) W/(m2 sr), of an emitter that sends out ``flux`` lumens.

    Neutral light of Phi_v lumens has Phi_v / K watts of ``white`` (n,); in three bands that is as
    much in each, as their weights add up to 1. See `radiance_from_radiant_flux` for the area (m2).
    """
    return radiance_from_radiant_flux(flux * white / efficacy, area)


def _bands(value) -> np.ndarray:
    value = np.asarray(value, float)
    return value.copy() if value.ndim else np.full(RGB.count, value)
