"""Photometry: watts of bands, lumens, and the radiance that emits a given amount.

Watts of different bands are never summed: a total that is not weighted by the eye does not exist
here, see `radiosity.light.bands`.
"""

import numpy as np

from radiosity.light.bands import RGB, Bands

EFFICACY = 683.0  # lm/W at 540 THz, the SI definition of the candela


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


def illuminance(
    irradiance: np.ndarray, bands: Bands = RGB, efficacy: float = EFFICACY
) -> np.ndarray:
    """Return E_v = K Y(E) in lx for irradiance (..., n) in W/m2, K the efficacy in lm/W."""
    return efficacy * luminance(irradiance, bands)


def radiance_from_exitance(exitance: np.ndarray) -> np.ndarray:
    """Return L = M / pi, (3,) W/(m2 sr), of a Lambertian emitter of exitance M (W/m2).

    A single number stands for every band.
    """
    return _bands(exitance) / np.pi


def radiance_from_luminance(value: float, efficacy: float = EFFICACY) -> np.ndarray:
    """Return the neutral radiance L = L_v / K, (3,) W/(m2 sr), of luminance L_v (cd/m2)."""
    return _bands(value) / efficacy


def radiance_from_radiant_flux(flux: np.ndarray, area: float) -> np.ndarray:
    """Return L = Phi / (pi A), (3,) W/(m2 sr), of an emitter that sends out Phi watts a band.

    Parameters
    ----------
    flux : float or (3,) float
        W per band over all of the emitter's front; a single number stands for every band.
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


def radiance_from_luminous_flux(flux: float, area: float, efficacy: float = EFFICACY) -> np.ndarray:
    """Return the neutral radiance, (3,) W/(m2 sr), of an emitter that sends out ``flux`` lumens.

    Neutral white light of Phi_v lumens has Phi_v / K watts in every band, as the weights of
    `LUMINANCE` add up to 1; see `radiance_from_radiant_flux` for the area (m2).
    """
    return radiance_from_radiant_flux(_bands(flux) / efficacy, area)


def _bands(value) -> np.ndarray:
    return np.broadcast_to(np.asarray(value, float), (3,)).copy()
