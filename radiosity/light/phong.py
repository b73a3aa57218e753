"""Phong's lobe about the mirror direction, normalised so that it never returns too much."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.frames import frame, polar, to_scene
from radiosity.light.reflection import CosineLobe, checked_exponent, diffuse_mean

_Z = np.array([0.0, 0.0, 1.0])
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)
_LOBE_TAIL = 6.4  # cos^n z <= exp(-n z^2/2) is below 1.3e-9 beyond z = 6.4/sqrt(n)


def phong(reflectance, exponent, normal, to_light, to_view):
    """Return the energy-normalised Phong lobe, in 1/sr.

    f = rho (n + 2)/(2 pi) cos^n(alpha), alpha between the view and R = 2 (N.L) N - L, the mirror
    direction of the light; 0 where N.L <= 0, N.V <= 0 or cos(alpha) <= 0. Reciprocal, because
    R.V = 2 (N.L)(N.V) - L.V. Lafortune & Willems (1994), "Using the modified Phong reflectance
    model for physically based rendering"; Lewis (1994).

    Parameters
    ----------
    reflectance : float, (bands,) or (k, bands)
        rho, the directional albedo at normal incidence.
    exponent : float or (k,)
        n >= 0.
    normal, to_light, to_view : (k, 3) or (3,)
        Unit vectors.

    Returns
    -------
    (k, bands) float64
        One band where the reflectance is a number.
    """
    rho = np.atleast_1d(np.asarray(reflectance, dtype=np.float64))
    n = checked_exponent(exponent)
    light, view = _dot(normal, to_light), _dot(normal, to_view)
    cos_alpha = np.clip(2.0 * light * view - _dot(to_light, to_view), 0.0, 1.0)
    seen = (light > 0) & (view > 0) & (cos_alpha > 0)
    lobe = np.where(seen, (n + 2.0) / (2.0 * np.pi) * cos_alpha**n, 0.0)
    return lobe[..., None] * rho


def phong_albedo(exponent, cos_theta):
    """Return the directional albedo of the Phong lobe of reflectance 1, to 1e-8.

    a(theta) = (n + 2)/(2 pi) int cos^n(alpha) cos(theta_r) dw over the directions where both
    cosines are positive: 1 at normal incidence, falling towards grazing as the surface cuts the
    lobe off. About the mirror direction, rings up to alpha = pi/2 - theta are whole and give
    cos(theta) (1 - S), S = sin^(n+2)(theta). The cut rings, cos(alpha) = sin(theta) cos(z), give

    S (n + 2)/pi int_0^(pi/2) cos^n(z) sin(z) [cos(z) cos(theta) phi + sin(z)] dz,
    phi = pi/2 + atan2(cos(z) cos(theta), sin(z)) the half width of the arc above the surface.

    Derived here; agrees with Lewis (1994) at 0 degrees.

    Parameters
    ----------
    exponent : float or ndarray
        n >= 0; broadcasts against the cosine.
    cos_theta : float or ndarray
        Cosine of the angle of incidence, in [0, 1].
    """
    n, mu = checked_exponent(exponent), np.asarray(cos_theta, dtype=np.float64)
    if not np.all((mu >= 0) & (mu <= 1)):
        raise ValueError(f"cos_theta = {mu} must lie in [0, 1]: light arrives from the front")
    z, weight = _cut_ring_nodes(n)
    cos_z, sin_z, mu_z = np.cos(z), np.sin(z), mu[..., None]
    phi = np.pi / 2 + np.arctan2(cos_z * mu_z, sin_z)
    powers = cos_z ** n[..., None]
    cut = (weight * powers * sin_z * (cos_z * mu_z * phi + sin_z)).sum(axis=-1)
    inside = np.sqrt((1.0 - mu) * (1.0 + mu)) ** (n + 2.0)
    return mu * (1.0 - inside) + (n + 2.0) / np.pi * inside * cut


@dataclass(frozen=True)
class Phong(CosineLobe):
    """Energy-normalised Phong lobe, f = rho (n + 2)/(2 pi) cos^n(angle to mirror), see `phong`."""

    def value(self, to_light, to_view):
        """Return f (..., bands) in 1/sr."""
        return phong(self.reflectance, self.exponent, _Z, to_light, to_view)

    def shape(self, to_light, to_view):
        """Return cos^n(alpha) (..., 1), as the seeds write the lobe."""
        unit = phong(1.0, self.exponent, _Z, to_light, to_view)
        return unit * (2.0 * np.pi / (np.asarray(self.exponent) + 2.0))[..., None]

    def albedo(self, cosine):
        """Return the directional albedo (..., bands), see `phong_albedo`."""
        return phong_albedo(self.exponent, cosine)[..., None] * self.reflectance

    @property
    def mean_albedo(self):
        """Albedo under diffuse light, 2 int a(c) c dc."""
        mean = diffuse_mean(lambda c: phong_albedo(np.asarray(self.exponent)[..., None], c))
        return self.reflectance * mean[..., None]

    def sample(self, to_view, u):
        """Return directions with the density (n + 1)/(2 pi) cos^n about the mirror direction."""
        mirror = np.asarray(to_view) * [-1.0, -1.0, 1.0]
        cos_alpha = u[..., 0] ** (1.0 / (np.asarray(self.exponent) + 1.0))
        return to_scene(frame(mirror), polar(cos_alpha, 2.0 * np.pi * u[..., 1]))

    def density(self, to_view, directions):
        """Return the density (...) per steradian of `sample`."""
        n = np.asarray(self.exponent)
        cos_alpha = _dot(np.asarray(to_view) * [-1.0, -1.0, 1.0], directions)
        whole = np.where(cos_alpha > 0.0, np.clip(cos_alpha, 0.0, 1.0) ** n, 0.0)
        return (n + 1.0) / (2.0 * np.pi) * whole


def _cut_ring_nodes(n):
    """Return (..., 64) nodes z and weights for integrals of cos^n(z) times a smooth function.

    The range ends where the lobe has died away. z = end (1 - q^3) flattens the end point, where
    cos^n(z) has no derivative if n is below 1 (q from 0 to 1).
    """
    end = np.minimum(np.pi / 2, _LOBE_TAIL / np.sqrt(np.maximum(n, 1.0)))[..., None]
    q = 0.5 * (_NODES + 1.0)
    return end * (1.0 - q**3), 0.5 * _WEIGHTS * end * 3.0 * q**2


def _dot(a, b):
    return np.sum(np.asarray(a, dtype=np.float64) * np.asarray(b, dtype=np.float64), axis=-1)
