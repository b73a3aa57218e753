"""Refraction: where light goes at an interface, what its radiance becomes there, clear panes.

``bend`` is eta_here/eta_there: the index of the side a direction lies on divided by that of the
other side, below 1 from air into glass.
"""

import numpy as np

from radiosity.light.fresnel import polarised_reflectance, reflectance


def mirrored(direction, normal):
    """Return the mirror direction b = 2 (n.d) n - d; both point away from the surface (..., 3)."""
    d, n = np.asarray(direction, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    return 2.0 * np.sum(n * d, axis=-1, keepdims=True) * n - d


def refracted(direction, normal, bend):
    """Return the direction in which a ray goes on beyond an interface, unit vectors (..., 3).

    t = (bend c - sqrt(1 - bend^2 (1 - c^2))) n - bend d, c = n.d, which is Snell's law
    sin(theta_t) = bend sin(theta) with the directions in one plane. Works both ways: light that
    comes from d goes to t, and an eye at d sees what comes from t.

    Parameters
    ----------
    direction : (..., 3)
        Unit vector d, away from the surface, on the side of the normal.
    normal : (..., 3)
    bend : float or (...)
        eta of this side / eta of the far side.

    Returns
    -------
    (..., 3) float64
        Away from the surface on the far side; NaN where the light is totally reflected.
    """
    d, n = np.asarray(direction, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    bend = np.asarray(bend, dtype=np.float64)[..., None]
    c = np.sum(n * d, axis=-1, keepdims=True)
    inside = 1.0 - bend**2 * (1.0 - c) * (1.0 + c)
    cos_t = np.where(inside >= 0.0, np.sqrt(np.maximum(inside, 0.0)), np.nan)
    return (bend * c - cos_t) * n - bend * d


def radiance_across(radiance, transmittance, bend):
    """Return the radiance beyond an interface, L_t = F_t L/bend^2, in the unit of ``radiance``.

    L/n^2 is invariant but for what is reflected: Snell's law makes n^2 cos(theta) dw the same on
    both sides, so the power F_t L cos(theta) dw dA goes on in the cone n^2 times as narrow.
    Nicodemus (1963), "Radiance".
    """
    return np.asarray(transmittance) * np.asarray(radiance) / np.asarray(bend) ** 2


def pane_transmittance(cosine, index):
    """Return what a clear pane lets through with all reflections between its faces.

    T = mean over s and p of (1 - R)/(1 + R): the sum of (1 - R)^2 R^(2 k), without interference
    (the pane is thicker than the light is coherent) or absorption. Stokes (1862).

    Parameters
    ----------
    cosine, index : float or ndarray
        As for `fresnel.polarised_reflectance`.
    """
    return sum((1.0 - r) / (1.0 + r) for r in polarised_reflectance(cosine, index)) / 2.0


def single_pass_transmittance(cosine, index):
    """Return what crosses two faces of a pane without any reflection between them, (1 - F)^2."""
    return (1.0 - reflectance(cosine, index)) ** 2


def fitted_pane_transmittance(cosine, coefficients):
    """Return the transmittance of measured glass, sum_k t_k cos^k(theta), kept within [0, 1].

    Mitalas & Arseneault (1972); their fit falls below 0 at grazing incidence.

    Parameters
    ----------
    cosine : float or ndarray
    coefficients : (k,)
        t_0, t_1, ...
    """
    fitted = np.polynomial.polynomial.polyval(np.asarray(cosine, float), coefficients)
    return np.clip(fitted, 0.0, 1.0)
