"""Fresnel: how much a smooth surface reflects and lets through, by angle, band and polarisation.

An index is relative: that of the far side divided by that of the side the light comes from, so
below 1 for light that leaves a medium. Metals have a complex one, nu + kappa j. Cosines are of the
angle of incidence; cosines and indices broadcast, so ``cosine[..., None]`` goes with an index a
band.
"""

import numpy as np


def polarised_reflectance(cosine, index):
    """Return the shares of light reflected, (R_s, R_p), perpendicular and parallel to the plane.

    With g = nu cos(theta_t) = sqrt(nu^2 - sin^2(theta)),
    R_s = |(c - g)/(c + g)|^2, R_p = |(nu^2 c - g)/(nu^2 c + g)|^2 (Born & Wolf, section 1.5.2; eqs.
    3.52 and 3.53 of Szirmay-Kalos with their labels exchanged). Beyond the critical angle both
    are 1.

    Parameters
    ----------
    cosine : float or ndarray
        c = cos(theta) in [0, 1].
    index : float, complex or ndarray
        Relative; broadcasts against the cosine.

    Raises
    ------
    ValueError
        A cosine outside [0, 1], or an index whose real part is not positive.
    """
    c, nu = _checked(cosine, index)
    g = _refracted_part(c, nu)
    r_s = _ratio(c - g, c + g)
    r_p = _ratio(nu**2 * c - g, nu**2 * c + g)
    return np.abs(r_s) ** 2, np.abs(r_p) ** 2


def reflectance(cosine, index):
    """Return the share of unpolarised light that is reflected, F = (R_s + R_p)/2.

    For real indices in the form of Cook & Torrance (1982) and Blinn (1977), without angles:
    F = 1/2 (g - c)^2/(g + c)^2 [1 + (c (g + c) - 1)^2/(c (g - c) + 1)^2], g^2 = nu^2 - 1 + c^2;
    1 where g^2 is not positive (total reflection). See `polarised_reflectance` for parameters.
    """
    c, nu = _checked(cosine, index)
    if np.iscomplexobj(nu):
        return sum(polarised_reflectance(c, nu)) / 2.0
    g2 = _square(c, nu)
    g = np.sqrt(np.maximum(g2, 0.0))
    first = _ratio(g - c, g + c)
    second = (c * (g + c) - 1.0) / (c * (g - c) + 1.0)
    return np.where((g2 > 0.0) | (nu == 1.0), 0.5 * first**2 * (1.0 + second**2), 1.0)


def transmittance(cosine, index):
    """Return the share of unpolarised light that passes into a clear medium, F_t = 1 - F_r.

    F_t = 2 c g [1/(c + g)^2 + nu^2/(nu^2 c + g)^2], which keeps its digits where little passes;
    0 in total reflection. See `polarised_reflectance` for parameters.

    Raises
    ------
    ValueError
        A complex index: what a metal does not reflect it absorbs.
    """
    c, nu = _checked(cosine, index)
    if np.iscomplexobj(nu):
        raise ValueError(f"index = {index} must be real: a metal absorbs what it does not reflect")
    g = np.sqrt(np.maximum(_square(c, nu), 0.0))
    product = 2.0 * c * g
    t_s = _ratio(product, (c + g) ** 2)
    t_p = _ratio(product * nu**2, (nu**2 * c + g) ** 2)
    return np.where(nu == 1.0, 1.0, t_s + t_p)


def normal_reflectance(index):
    """Return F_0 = |(1 - nu)/(1 + nu)|^2, the reflectance at normal incidence (eq. 3.55)."""
    return np.abs((1.0 - np.asarray(index)) / (1.0 + np.asarray(index))) ** 2


def index_of_reflectance(reflectance):
    """Return the real index that reflects F_0 at normal incidence.

    nu = (1 + sqrt(F_0))/(1 - sqrt(F_0)), eq. 3.56 of Szirmay-Kalos.

    Raises
    ------
    ValueError
        F_0 outside [0, 1): no finite index reflects everything.
    """
    f0 = np.asarray(reflectance, dtype=np.float64)
    if not np.all((f0 >= 0) & (f0 < 1)):
        raise ValueError(
            f"reflectance = {reflectance} at normal incidence must lie in [0, 1): no finite index "
            "reflects everything"
        )
    return (1.0 + np.sqrt(f0)) / (1.0 - np.sqrt(f0))


def mean_reflectance(index):
    """Return the reflectance under diffuse light, 2 int F(c) c dc, to 1e-6 relative; any shape."""
    x, w = np.polynomial.legendre.leggauss(64)
    c = (x + 1.0) / 2.0
    return (reflectance(c, np.asarray(index)[..., None]) * (w * c)).sum(axis=-1)


def _refracted_part(c, nu):
    """Return g = nu cos(theta_t); imaginary in total reflection."""
    g2 = _square(c, nu)
    return np.sqrt(g2) if np.iscomplexobj(g2) or np.all(g2 >= 0.0) else np.sqrt(g2 + 0j)


def _square(c, nu):
    """Return g^2, without cancellation where the index is near 1."""
    return (nu - 1.0) * (nu + 1.0) + c**2


def _ratio(a, b):
    """Return a/b, 0 where b is 0, as a then is: at grazing incidence on a medium like the other."""
    return a / np.where(b == 0, 1.0, b)


def _checked(cosine, index):
    c, nu = np.asarray(cosine, dtype=np.float64), np.asarray(index)
    if not np.all((c >= 0) & (c <= 1 + 1e-12)):
        raise ValueError(f"cosine = {cosine} must lie in [0, 1]: light arrives from the front")
    if not np.all((nu.real > 0) & np.isfinite(nu)):
        raise ValueError(f"index = {index} must be positive and finite: vacuum has 1, glass 1.5")
    return np.minimum(c, 1.0), nu if np.iscomplexobj(nu) else nu.astype(np.float64)
