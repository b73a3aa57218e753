"""Blinn's lobe about the halfway vector, (N.H)^n, normalised so that it never returns too much."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.frames import halfway
from radiosity.light.reflection import CosineLobe, checked_exponent, diffuse_mean
from radiosity.light.visible import mirrored_density, mirrored_view

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)
_DIES = 9.0  # cos^n(alpha) <= exp(-n alpha^2/2) is below 3e-18 beyond alpha = 9/sqrt(n)


@dataclass(frozen=True)
class Blinn(CosineLobe):
    """The lobe f = rho (N.H)^n/a_n, a_n = 8 pi (2^(-n/2) + n)/((n + 2)(n + 4)).

    a_n is the albedo of (N.H)^n at normal incidence, where it is largest, so the directional
    albedo is rho there and less elsewhere. *Blinn (1977)*; the usual (n + 8)/(8 pi) for 1/a_n is an
    approximation. Reciprocal.
    """

    def value(self, to_light, to_view):
        """Return f (..., bands) in 1/sr."""
        return self.shape(to_light, to_view) / _largest(self.exponent)[..., None] * self.reflectance

    def shape(self, to_light, to_view):
        """Return (N.H)^n (..., 1), as the seeds write the lobe."""
        half, _ = halfway(to_light, to_view)
        n = checked_exponent(self.exponent)
        lit = (np.asarray(to_light)[..., 2] > 0) & (np.asarray(to_view)[..., 2] > 0)
        return np.where(lit, np.clip(half[..., 2], 0.0, 1.0) ** n, 0.0)[..., None]

    def albedo(self, cosine):
        """Return the directional albedo (..., bands), see `blinn_albedo`."""
        n = self.exponent
        return (blinn_albedo(n, cosine) / _largest(n))[..., None] * self.reflectance

    @property
    def mean_albedo(self):
        """Albedo under diffuse light, 2 int a(c) c dc."""
        n = np.asarray(self.exponent)[..., None]
        mean = diffuse_mean(lambda c: blinn_albedo(n, c) / _largest(n))
        return mean[..., None] * self.reflectance

    def sample(self, to_view, u):
        """Return the view mirrored in facets of the density (n + 1)/(2 pi) cos^n that it sees."""
        cosine = (1.0 - u[..., 0]) ** (1.0 / (np.asarray(self.exponent) + 1.0))
        return mirrored_view(cosine, u[..., 1], to_view)

    def density(self, to_view, directions):
        """Return the density (...) per steradian of `sample`."""
        n = np.asarray(self.exponent)
        return mirrored_density(lambda c: (n + 1.0) / (2.0 * np.pi) * c**n, to_view, directions)


def blinn_albedo(exponent, cosine):
    """Return int (N.H)^n cos(theta_l) dw over the hemisphere, to 1e-9.

    With dw = 4 (V.H) dw_H and N.L = 2 (V.H)(N.H) - N.V the integral over the azimuth of H is
    elementary, as V.H = a + b cos(phi), a = N.V cos(alpha), b = sin(theta) sin(alpha), where
    N.L > 0: for |phi| < phi_0, cos(phi_0) = (N.V/(2 cos(alpha)) - a)/b. What is left is

    8 int cos^n sin(alpha) [2 cos(alpha) (a^2 p + 2 a b s + b^2 (p + s c)/2) - N.V (a p + b s)]
    d alpha, &nbsp; p = phi_0, s = sin(p), c = cos(p),

    with kinks at alpha = 45 degrees -+ theta/2. Derived here.

    Parameters
    ----------
    exponent : float or ndarray
        n >= 0.
    cosine : float or ndarray
        N.V in [0, 1]; broadcasts against the exponent.
    """
    n, view = np.broadcast_arrays(checked_exponent(exponent), np.asarray(cosine, float))
    end = np.minimum(np.pi / 2.0, _DIES / np.sqrt(np.maximum(n, 1e-3)))
    lean = np.arccos(np.clip(view, 0.0, 1.0)) / 2.0
    first, last = (np.minimum(np.pi / 4.0 + k * lean, end) for k in (-1, 1))
    whole = _between(np.zeros_like(first), first, n, view)
    return whole + _between(first, last, n, view)


def _between(low, high, n, view):
    """Return the integral over alpha from low to high, (...)."""
    turn = 0.5 * np.pi * (_NODES + 1.0)  # flattens both ends, where the integrand has a root
    alpha = low[..., None] + (high - low)[..., None] * 0.5 * (1.0 - np.cos(turn))
    weight = 0.25 * np.pi * np.sin(turn) * _WEIGHTS
    up, v = np.cos(alpha), view[..., None]
    a, b = v * up, np.sqrt((1.0 - v) * (1.0 + v)) * np.sin(alpha)
    c = np.clip((v / (2.0 * up) - a) / np.maximum(b, 1e-300), -1.0, 1.0)
    p, s = np.arccos(c), np.sqrt(1.0 - c**2)
    squares = a**2 * p + 2.0 * a * b * s + 0.5 * b**2 * (p + s * c)
    inner = 8.0 * up ** n[..., None] * np.sin(alpha) * (2.0 * up * squares - v * (a * p + b * s))
    return (inner * weight).sum(axis=-1) * (high - low)


def _largest(exponent):
    """Return the albedo of (N.H)^n at normal incidence."""
    n = np.asarray(exponent, dtype=np.float64)
    return 8.0 * np.pi * (2.0 ** (-n / 2.0) + n) / ((n + 2.0) * (n + 4.0))
