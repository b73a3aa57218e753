"""Facet distributions: how the tiny mirrors of a rough surface lean, and what they hide.

alpha is the angle between a facet's normal H and the surface's normal N. D has two forms: peak 1
(Blinn 1977) and normalised, such that the facets of a unit of surface cover it once when seen from
above, int D cos(alpha) dw = 1 over the hemisphere. Roughness may be an array that broadcasts
against the cosines.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import dawsn, erfc, wofz

LEAST_COSINE = 1e-100  # of facets that stand upright; none has a visible share
_DIES = 6.4  # exp(-6.4^2) = 1.6e-18 is lost in rounding
_TABLE = 512  # heights above the horizon; between them a cubic is right to 1e-9
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


@dataclass(frozen=True)
class TrowbridgeReitz:
    """Facets of an ellipsoid of revolution; Blinn's D3, known as GGX with alpha = c3.

    D3 = (c3^2/(cos^2(alpha)(c3^2 - 1) + 1))^2, whose normalised form is D3/(pi c3^2).
    *Trowbridge & Reitz (1975)*; Walter et al. (2007).

    Attributes
    ----------
    roughness : float or ndarray
        c3 in (0, 1]: 0 for a mirror, 1 for facets of all directions.
    """

    roughness: float | np.ndarray

    @classmethod
    def of_half_angle(cls, degrees):
        """Return the one that falls to 1/2 at beta: c3^2 = (cos^2 b - 1)/(cos^2 b - sqrt 2)."""
        sine2 = np.sin(_half_angle(degrees)) ** 2
        return cls(np.sqrt(sine2 / (np.sqrt(2.0) - 1.0 + sine2)))

    def relative(self, cosine):
        """Return D/D(0), Blinn's form of peak 1."""
        c, m2 = np.asarray(cosine, dtype=np.float64), np.square(self.roughness)
        return (m2 / ((1.0 - c) * (1.0 + c) + m2 * c**2)) ** 2

    def norm(self):
        """Return int D/D(0) cos(alpha) dw = pi c3^2."""
        return np.pi * np.square(self.roughness)

    def cosine_of(self, share):
        """Return the cos(alpha) below which a share of D cos(alpha) dw leans, for sampling."""
        u = np.asarray(share, dtype=np.float64)
        return np.sqrt((1.0 - u) / (1.0 - u + np.square(self.roughness) * u))

    def share_of(self, cosine):
        """Return the share that leans less, the inverse of `cosine_of`."""
        c = np.asarray(cosine, dtype=np.float64)
        sine2 = (1.0 - c) * (1.0 + c)
        return sine2 / (sine2 + np.square(self.roughness) * c**2)

    def chosen(self, cosine):
        """Return the density per steradian of facets chosen by `cosine_of`: D cos(alpha)."""
        return self.relative(cosine) * cosine / self.norm()

    def hidden(self, cosine):
        """Return the facets' backs seen from an angle theta per surface, (sqrt - cos)/2.

        sqrt(cos^2 + c3^2 sin^2)/2 - cos/2, Smith's cos(theta) Lambda (Heitz 2014).
        """
        c, m2 = np.asarray(cosine, dtype=np.float64), np.square(self.roughness)
        return 0.5 * (np.sqrt(c**2 + m2 * (1.0 - c) * (1.0 + c)) - c)


@dataclass(frozen=True)
class Beckmann:
    """Facets of a surface of Gaussian slopes, D = exp(-tan^2(alpha)/m^2)/(pi m^2 cos^4(alpha)).

    Beckmann & Spizzichino (1963); eq. 3.46 of Szirmay-Kalos with its 1/pi. Beyond m = 1/sqrt(2)
    the peak no longer lies at alpha = 0.

    Attributes
    ----------
    roughness : float or ndarray
        m, the root mean square slope; positive.
    """

    roughness: float | np.ndarray

    @classmethod
    def of_half_angle(cls, degrees):
        """Return the one that falls to 1/2 at beta: m^2 = t/(ln 2 + 2 ln(1 + t)), t = tan^2 b.

        Raises
        ------
        ValueError
            A half-angle above 46.07 degrees, where m would exceed 1/sqrt(2).
        """
        t = np.tan(_half_angle(degrees)) ** 2
        m2 = t / (np.log(2.0) + 2.0 * np.log1p(t))
        if np.any(m2 > 0.5):
            raise ValueError(
                f"half_angle = {degrees} degrees must be at most 46.07 for Beckmann facets: "
                "beyond, most do not lie flat and D rises before it falls; give their roughness"
            )
        return cls(np.sqrt(m2))

    def relative(self, cosine):
        """Return D/D(0) = exp(-tan^2(alpha)/m^2)/cos^4(alpha)."""
        c = np.maximum(cosine, LEAST_COSINE)
        return np.exp(-_tan2(c) / np.square(self.roughness) - 4.0 * np.log(c))

    def norm(self):
        """Return int D/D(0) cos(alpha) dw = pi m^2."""
        return np.pi * np.square(self.roughness)

    def cosine_of(self, share):
        """Return the cos(alpha) below which a share of D cos(alpha) dw leans, for sampling."""
        tan2 = -np.square(self.roughness) * np.log1p(-np.asarray(share, dtype=np.float64))
        return 1.0 / np.sqrt(1.0 + tan2)

    def share_of(self, cosine):
        """Return the share that leans less, the inverse of `cosine_of`."""
        return -np.expm1(-_tan2(np.maximum(cosine, LEAST_COSINE)) / np.square(self.roughness))

    def chosen(self, cosine):
        """Return the density per steradian of facets chosen by `cosine_of`: D cos(alpha)."""
        return self.relative(cosine) * cosine / self.norm()

    def hidden(self, cosine):
        """Return the facets' backs seen from an angle theta per surface, cos(theta) Lambda.

        m sin(theta) exp(-a^2)/(2 sqrt(pi)) - cos(theta) erfc(a)/2, a = 1/(m tan(theta)) (Smith
        1967; Heitz 2014).
        """
        c = np.asarray(cosine, dtype=np.float64)
        slope = self.roughness * np.sqrt((1.0 - c) * (1.0 + c))
        a = c / np.maximum(slope, 1e-200)
        decayed = np.exp(-(np.minimum(a, 30.0) ** 2))
        return 0.5 * (slope * decayed / np.sqrt(np.pi) - c * erfc(a))


@dataclass(frozen=True)
class Gaussian:
    """Facets whose angles are Gaussian; Blinn's D2 = exp(-(alpha/m)^2), c2 = 1/m (eq. 3.45).

    Torrance & Sparrow (1967).

    Attributes
    ----------
    roughness : float or ndarray
        m in radians; positive.
    """

    roughness: float | np.ndarray

    @classmethod
    def of_half_angle(cls, degrees):
        """Return the one that falls to 1/2 at beta: m = beta/sqrt(ln 2)."""
        return cls(_half_angle(degrees) / np.sqrt(np.log(2.0)))

    def relative(self, cosine):
        """Return D/D(0) = exp(-(alpha/m)^2)."""
        return np.exp(-((_angle(cosine) / self.roughness) ** 2))

    def norm(self):
        """Return int D/D(0) cos(alpha) dw.

        pi int_0^(pi/2) exp(-(a/m)^2) sin(2 a) da
        = pi m [F(m) + sqrt(pi)/2 exp(-q^2) Im w(m + i q)], q = pi/(2 m), F Dawson's and w
        Faddeeva's function. Derived here.
        """
        m = np.asarray(self.roughness, dtype=np.float64)
        q = np.pi / (2.0 * m)
        cut = np.exp(-(np.minimum(q, 30.0) ** 2)) * wofz(m + 1j * q).imag
        return np.pi * m * (dawsn(m) + 0.5 * np.sqrt(np.pi) * cut)

    def cosine_of(self, share):
        """Return cos(alpha) of the share of alpha exp(-(alpha/m)^2) d alpha that leans less.

        The distribution itself has no inverse; this one is nowhere much thinner.
        """
        m = self.roughness
        whole = -np.expm1(-((np.pi / (2.0 * m)) ** 2))
        alpha = m * np.sqrt(-np.log1p(-np.asarray(share, dtype=np.float64) * whole))
        return np.cos(np.minimum(alpha, np.pi / 2.0))

    def share_of(self, cosine):
        """Return the share that leans less, the inverse of `cosine_of`."""
        whole = -np.expm1(-((np.pi / (2.0 * self.roughness)) ** 2))
        return -np.expm1(-((_angle(cosine) / self.roughness) ** 2)) / whole

    def chosen(self, cosine):
        """Return the density per steradian of facets chosen by `cosine_of`.

        exp(-(alpha/m)^2) alpha/sin(alpha)/(pi m^2 (1 - exp(-(pi/(2 m))^2))).
        """
        m, alpha = self.roughness, _angle(cosine)
        whole = -np.expm1(-((np.pi / (2.0 * m)) ** 2))
        return self.relative(cosine) / np.sinc(alpha / np.pi) / (np.pi * np.square(m) * whole)

    def hidden(self, cosine):
        """Return the facets' backs seen from an angle theta per surface, cos(theta) Lambda."""
        return _backs(self, cosine, self.roughness, _DIES)


@dataclass(frozen=True)
class CosinePower:
    """Facets of Phong's lobe in the form of the halfway vector; Blinn's D1 = cos^c1(alpha).

    Attributes
    ----------
    exponent : float or ndarray
        c1, at least 0.
    """

    exponent: float | np.ndarray

    @classmethod
    def of_half_angle(cls, degrees):
        """Return the one that falls to 1/2 at beta: c1 = -ln 2/ln cos(beta)."""
        return cls(-np.log(2.0) / np.log(np.cos(_half_angle(degrees))))

    def relative(self, cosine):
        """Return D/D(0) = cos^c1(alpha)."""
        return np.asarray(cosine, dtype=np.float64) ** self.exponent

    def norm(self):
        """Return int D/D(0) cos(alpha) dw = 2 pi/(c1 + 2)."""
        return 2.0 * np.pi / (np.asarray(self.exponent) + 2.0)

    def cosine_of(self, share):
        """Return the cos(alpha) below which a share of D cos(alpha) dw leans, for sampling."""
        return (1.0 - np.asarray(share, dtype=np.float64)) ** (1.0 / (self.exponent + 2.0))

    def share_of(self, cosine):
        """Return the share that leans less, the inverse of `cosine_of`."""
        return 1.0 - np.asarray(cosine, dtype=np.float64) ** (self.exponent + 2.0)

    def chosen(self, cosine):
        """Return the density per steradian of facets chosen by `cosine_of`: D cos(alpha)."""
        return self.relative(cosine) * cosine / self.norm()

    def hidden(self, cosine):
        """Return the facets' backs seen from an angle theta per surface, cos(theta) Lambda."""
        return _backs(self, cosine, np.sqrt(2.0 / np.maximum(self.exponent, 1e-3)), _DIES)


DISTRIBUTIONS = {
    "gaussian": Gaussian,
    "beckmann": Beckmann,
    "trowbridge-reitz": TrowbridgeReitz,
}


def _backs(facets, cosine, lean, dies):
    """Return `_backs_at`, from a table where that is less work."""
    end = np.minimum(dies * np.asarray(lean), np.pi / 2.0)
    if np.ndim(end) or np.size(cosine) <= _TABLE:
        return _backs_at(facets, cosine, end)
    from scipy.interpolate import CubicSpline

    height = np.linspace(0.0, end, _TABLE)
    curve = CubicSpline(height, _backs_at(facets, np.sin(height), end))
    return np.maximum(curve(np.minimum(np.arcsin(np.clip(cosine, 0.0, 1.0)), end)), 0.0)


def _backs_at(facets, cosine, end):
    """Return int D max(0, -V.H) dw, the projected area of facets seen from behind (Heitz 2014).

    With H at alpha and an azimuth phi, V.H < 0 where |phi - pi| < phi_1, cos(phi_1) =
    cot(theta) cot(alpha), so 2 int D sin(alpha) [sin(theta) sin(alpha) sin(phi_1)
    - cos(theta) cos(alpha) phi_1] d alpha from pi/2 - theta on, until D dies at ``end``.
    """
    c, end = np.broadcast_arrays(np.clip(cosine, 0.0, 1.0), end)
    begin = np.minimum(np.pi / 2.0 - np.arccos(c), end)[..., None]
    turn = 0.5 * np.pi * (_NODES + 1.0)
    t = 0.5 * (1.0 - np.cos(turn))  # flattens the start, where the integrand is a 3/2 power
    weight = 0.25 * np.pi * np.sin(turn) * _WEIGHTS
    span = end[..., None] - begin
    alpha = begin + span * t
    upright, lying = c[..., None] * np.cos(alpha), np.sqrt(1.0 - c**2)[..., None] * np.sin(alpha)
    phi = np.arccos(np.clip(upright / np.maximum(lying, 1e-300), -1.0, 1.0))
    turned = _spread(facets)
    density = turned.relative(np.cos(alpha)) / turned.norm()
    seen = 2.0 * density * np.sin(alpha) * (lying * np.sin(phi) - upright * phi)
    return (seen * span * weight).sum(axis=-1)


def _spread(facets):
    """Return the distribution with one more axis, along which cosines are integrated over."""
    (value,) = vars(facets).values()
    return type(facets)(np.asarray(value, dtype=np.float64)[..., None])


def _half_angle(degrees):
    beta = np.asarray(degrees, dtype=np.float64)
    if not np.all((beta > 0) & (beta < 90)):
        raise ValueError(
            f"half_angle = {degrees} degrees must lie between 0 and 90, both excluded: there half "
            "as many facets lean as lie flat"
        )
    return np.radians(beta)


def _tan2(c):
    return (1.0 - c) * (1.0 + c) / c**2


def _angle(cosine):
    """Return alpha with the digits that its cosine has."""
    c = np.clip(cosine, -1.0, 1.0)
    return np.arctan2(np.sqrt((1.0 - c) * (1.0 + c)), c)
