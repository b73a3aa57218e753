"""Reflection models at a point: how much of the light from one direction leaves in another.

A model is f, the radiance that leaves per irradiance that arrives, in 1/sr. Directions are unit
vectors that point away from the surface: ``to_light`` to the source, ``to_view`` to the eye.

Every lobe that a material holds (`phong.Phong`, `blinn.Blinn`, `torrance_sparrow.TorranceSparrow`)
is a frozen object that works in the surface's frame, z along the normal, on arrays of any leading
shape against which its exponent or roughness, if an array, broadcasts:

- ``value(to_light, to_view)``: f in 1/sr, (..., bands); 0 where either lies below the horizon
- ``albedo(cosine)``: share of the light from one direction that leaves in all, (..., bands)
- ``mean_albedo``: share of diffuse light that leaves, 2 int a(c) c dc, (bands,)
- ``sample(to_view, u)``: directions (..., 3) for squares u (..., 2) in [0, 1), some of them below
  the horizon, with ``density(to_view, directions)`` per steradian
- ``reciprocal``: whether f stays when light and view change places
- ``summary``: the model in words
"""

from dataclasses import dataclass, replace

import numpy as np


def lambert(reflectance):
    """Return the Lambertian model, the same in every direction, in 1/sr.

    f = rho / pi, since the hemisphere's integral of cos(theta) dw is pi (Lambert 1760).

    Parameters
    ----------
    reflectance : float or ndarray
        rho, dimensionless, of any shape.
    """
    return np.asarray(reflectance, dtype=np.float64) / np.pi


def diffuse_mean(albedo):
    """Return 2 int_0^1 a(c) c dc of a function of (32,) cosines along its last axis."""
    x, w = np.polynomial.legendre.leggauss(32)
    cosine = (x + 1) / 2
    return (albedo(cosine) * cosine) @ w


def shown(values) -> str:
    """Return a number, a colour or the range of an array in words."""
    values = np.atleast_1d(np.asarray(values, dtype=np.float64))
    if values.size > 4 and np.ptp(values) == 0.0:
        return f"{values[0]:.6g}"
    if values.size > 4:
        return f"from {values.min():.6g} to {values.max():.6g}"
    return " ".join(f"{v:.6g}" for v in values)


def checked_exponent(exponent) -> np.ndarray:
    """Return a lobe's exponent as an array; raises ValueError if it is negative or not finite."""
    n = np.asarray(exponent, dtype=np.float64)
    if not np.all((n >= 0) & np.isfinite(n)):
        raise ValueError(
            f"exponent = {exponent} must be finite and at least 0: a negative one would "
            "reflect without bound at right angles to the mirror direction"
        )
    return n


@dataclass(frozen=True)
class CosineLobe:
    """What lobes of a power of a cosine have in common; reciprocal.

    Attributes
    ----------
    reflectance : (bands,) float64
        rho, the albedo at normal incidence.
    exponent : float or ndarray
        n >= 0.
    """

    reflectance: np.ndarray
    exponent: float | np.ndarray
    reciprocal = True

    @property
    def summary(self) -> str:
        """The model in words."""
        name, rho = type(self).__name__, shown(self.reflectance)
        return f"{name}, reflectance {rho}, exponent {shown(self.exponent)}"

    def with_exponent(self, exponent) -> "CosineLobe":
        """Return the lobe with another exponent, or one for each point."""
        return replace(self, exponent=exponent)
