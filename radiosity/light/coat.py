"""A diffuse base under what lies on it: how the light that the coat lets through comes back."""

import numpy as np


def coated_diffuse(base, into, out, mean):
    """Return the base's part f_d of a coated surface's reflection, in 1/sr.

    f_d = rho (1 - a(theta_i))(1 - a(theta_o))/(pi (1 - a_mean)): what the coat of albedo a does not
    return reaches the base, and the base's light leaves as the coat lets it out. Reciprocal; its
    albedo is rho (1 - a(theta_i)), so that with the coat no more than all returns for any rho up to
    1. *Kelemen & Szirmay-Kalos (2001)*, after Shirley et al. (1997).

    Parameters
    ----------
    base : float or ndarray
        rho of the base.
    into, out, mean : float or ndarray
        Albedo a of the coat at the angles of light and view, and under diffuse light.
    """
    through = (1.0 - np.asarray(into)) * (1.0 - np.asarray(out))
    room = 1.0 - np.asarray(mean)
    return np.where(room > 0.0, base * through / (np.pi * np.where(room > 0.0, room, 1.0)), 0.0)


def layered(base, upon, coupled: bool):
    """Return the share of light that leaves a base with something on it, by angle and band.

    a + rho (1 - a) where the base lies under a coat, rho + a where the two are added.

    Parameters
    ----------
    base : (..., bands) float64
        What the base sends on, rho, with the diffuse transmittance of a sheet added.
    upon : (..., bands) float64
        Albedo a of what lies on it.
    coupled : bool
    """
    return upon + (base * (1.0 - upon) if coupled else base)


def is_coat(part) -> bool:
    """Whether a lobe or a mirror lets light through to what lies below."""
    return bool(getattr(part, "dielectric", False))
