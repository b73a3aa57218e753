"""Luminaires: point-like sources whose intensity was measured over the angles C and gamma.

C-planes stand on the axis of a luminaire like pages of a book on its back: gamma runs in each of
them from 0 on the axis, nadir of a luminaire that hangs, to pi against it; C counts the planes
counter-clockwise as seen from behind, from above of one that hangs (type C of LM-63, CIE 121).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from radiosity.light.sources import TAIL, UNIT, WIDEST, Point

ROUNDING = 1e-9  # radians, by which a direction may miss the first or last angle
FLOOR = 0.05  # of the peak, that intensities have to change by to make an edge
HALF, DIM = 0.5, 0.02  # of the peak, above which directions belong to the lobe, or to its skirts
UPRIGHT = {  # where a luminaire that hangs has C = 0 and C = 90 degrees, by the scene's up
    "x": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "y": ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
    "z": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
}


@dataclass(frozen=True)
class Distribution:
    """Intensities over the angles C and gamma, as shares of the largest.

    Attributes
    ----------
    planes : (p,) float64
        C in radians, rising from 0 to 2 pi; the last plane is the first again.
    angles : (a,) float64
        gamma in radians, rising, in [0, pi]; no light leaves beyond the first and the last.
    shares : (p, a) float64
        I/I_max, between which both angles interpolate linearly.
    """

    planes: np.ndarray
    angles: np.ndarray
    shares: np.ndarray

    def __call__(self, azimuth: np.ndarray, polar: np.ndarray) -> np.ndarray:
        """Return I/I_max (k,) at C and gamma (k,) in radians, linear in both between values (E28).

        Examples
        --------
        >>> row, round_ = np.array([1.0, 0.5, 0.0]), np.array([0, 2 * np.pi])
        >>> cone = Distribution(round_, np.array([0, 1.0, 2.0]), np.array([row, row]))
        >>> cone(np.array([0.1, 3.0, 3.0]), np.array([0.0, 0.5, 2.5])).tolist()
        [1.0, 0.75, 0.0]
        """
        turned = np.mod(azimuth, 2.0 * np.pi)
        i, s = _place(self.planes, turned)
        j, t = _place(self.angles, polar)
        one, two = ((1 - t) * self.shares[k, j] + t * self.shares[k, j + 1] for k in (i, i + 1))
        lit = (polar >= self.angles[0] - ROUNDING) & (polar <= self.angles[-1] + ROUNDING)
        return np.where(lit, (1 - s) * one + s * two, 0.0)

    @cached_property
    def solid_angle(self) -> float:
        """Return the integral over all directions in sr: flux = I_max times it.

        int (1 - t) sin(gamma) and int t sin(gamma) between two angles, t linear from 0 to 1, are
        cos(a) - q and q - cos(b), q = (sin b - sin a)/(b - a); over C it is the trapezoid (E29).
        """
        return float(np.sum(self._weights * self.shares))

    @cached_property
    def lobe(self) -> float:
        """Return the half angle of the cone that fills as much as what is brighter than half."""
        bright = float(np.sum(self._weights * (self.shares >= HALF)))
        return float(np.arccos(np.clip(1.0 - bright / (2.0 * np.pi), -1.0, 1.0)))

    @cached_property
    def reach(self) -> tuple[float, float]:
        """Return between which gamma it is brighter than `DIM`, in any plane.

        What is dimmer holds no narrow lobe, but is stray light that changes slowly.
        """
        lit = np.flatnonzero((self.shares > DIM).any(axis=0))
        first, last = max(lit[0] - 1, 0), min(lit[-1] + 1, len(self.angles) - 1)
        return float(self.angles[first]), float(self.angles[last])

    @cached_property
    def _weights(self):
        """Return (p, a) sr: what each of the shares counts for in the integral."""
        a, b = self.angles[:-1], self.angles[1:]
        half = (b - a) / 2.0
        q = np.cos((a + b) / 2.0) * np.sin(half) / half
        over_angles = np.zeros(len(self.angles))
        over_angles[:-1] += np.cos(a) - q
        over_angles[1:] += q - np.cos(b)
        step = np.diff(self.planes) / 2.0
        over_planes = np.zeros(len(self.planes))
        over_planes[:-1] += step
        over_planes[1:] += step
        return np.outer(over_planes, over_angles)

    def problems(self) -> list[str]:
        """Return what is wrong with it, as ends of sentences."""
        p, a, whole = self.planes, self.angles, 2.0 * np.pi
        if np.ndim(p) != 1 or np.ndim(a) != 1 or min(len(p), len(a)) < 2:
            return ["has less than two planes or angles"]
        if np.shape(self.shares) != (len(p), len(a)):
            return [f"has shares of the shape {np.shape(self.shares)}, not ({len(p)}, {len(a)})"]
        found = []
        if not (np.all(np.diff(p) > 0.0) and p[0] == 0.0 and abs(p[-1] - whole) < ROUNDING):
            found.append("has C-planes that do not rise from 0 to 2 pi")
        if not (np.all(np.diff(a) > 0.0) and a[0] >= 0.0 and a[-1] <= np.pi + ROUNDING):
            found.append("has angles gamma that do not rise from 0 or more to at most pi")
        if not (np.all((self.shares >= 0.0) & (self.shares <= 1.0)) and np.any(self.shares > TAIL)):
            found.append("has shares of its peak that do not lie in [0, 1], or no light")
        return found


@dataclass(frozen=True)
class Luminaire(Point):
    """A point with a measured distribution; ``intensity`` is that of its peak.

    Attributes
    ----------
    frame : (3, 3) float64
        Unit vectors at right angles: C = 0, C = pi/2, and the axis, gamma = 0. Left-handed where
        C counts counter-clockwise as seen from behind; the other way round in mirrors.
    distribution : Distribution
    label : str
        What it was read from, for people.
    """

    frame: np.ndarray = None
    distribution: Distribution = None
    label: str = ""

    def shape(self, from_light: np.ndarray) -> np.ndarray:
        """Return I(w)/I, (k,), in directions (k, 3) of travel."""
        along, across, down = (from_light @ self.frame.T).T
        return self.distribution(np.arctan2(across, along), _polar(along, across, down))

    def edges(self, from_light: np.ndarray) -> np.ndarray:
        """Return the shape on a floor: it may be steep anywhere, and is an edge where it is."""
        return self.shape(from_light) + FLOOR

    def misses(self, from_light: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return (k,) bool, see `Source.misses`; as narrow as all lobes together."""
        first, last = self.distribution.reach
        polar = _polar(*(from_light @ self.frame.T).T)
        holds = (polar > first - radius) & (polar < last + radius)
        return holds & (radius > WIDEST * self.distribution.lobe)

    def moved(self, turn: np.ndarray, shift: np.ndarray) -> "Luminaire":
        """Return the same luminaire at turn @ position + shift, turned (3, 3) or mirrored."""
        return replace(self, position=turn @ self.position + shift, frame=self.frame @ turn.T)

    @property
    def solid_angle(self) -> float:
        """Return the integral of the shape in sr, see `Distribution.solid_angle`."""
        return self.distribution.solid_angle

    def problems(self) -> list[str]:
        """Return what is wrong with it beside its strength, as ends of sentences."""
        found = super().problems() + self.distribution.problems()
        if not np.allclose(self.frame @ self.frame.T, np.eye(3), rtol=0.0, atol=UNIT):
            found.append("has a frame whose vectors are not of length 1 and at right angles")
        return found


def frame_towards(axis: np.ndarray, roll: float = 0.0, up: str = "z") -> np.ndarray:
    """Return the frame (3, 3) of a luminaire turned from hanging to an axis by the shortest way.

    Parameters
    ----------
    axis : (3,) float64
        Unit vector of gamma = 0. Against ``up`` the luminaire hangs: C = 0 is x (y where x is up),
        C = 90 degrees y (-z where y is up, z where x is). Along ``up`` it was turned about C = 0.
    roll : float
        Radians by which it is then turned on its axis, the way that C counts.

    Examples
    --------
    >>> frame_towards(np.array([0.0, 0.0, -1.0])).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]
    """
    c0, c90 = np.array(UPRIGHT[up])
    down = -np.cross(c0, c90)
    way = np.cross(down, axis)
    cosine, sine = float(down @ axis), np.linalg.norm(way)
    way = c0 if sine == 0.0 else way / sine
    first, second = (_turned(v, way, cosine, sine) for v in (c0, c90))
    c, s = np.cos(roll), np.sin(roll)
    return np.stack([c * first + s * second, c * second - s * first, axis])


def of_values(
    planes: np.ndarray, angles: np.ndarray, values: np.ndarray
) -> tuple[Distribution, float]:
    """Return the distribution of values (p, a) at C and gamma in degrees, and the largest of them.

    Examples
    --------
    >>> lambert = np.cos(np.radians(np.arange(91.0)))
    >>> made, peak = of_values(np.array([0.0, 360]), np.arange(91.0), 200 * np.array([lambert] * 2))
    >>> peak, round(peak * made.solid_angle / np.pi, 1)
    (200.0, 200.0)
    """
    peak = float(values.max())
    return Distribution(np.radians(planes), np.radians(angles), values / peak), peak


def _turned(v, way, cosine, sine):
    """Return a vector turned about a unit vector (Rodrigues)."""
    return cosine * v + sine * np.cross(way, v) + (1.0 - cosine) * (way @ v) * way


def _polar(along, across, down):
    return np.arctan2(np.hypot(along, across), down)


def _place(knots, values):
    """Return the interval (k,) each value lies in, and how far along it, in [0, 1]."""
    i = np.clip(np.searchsorted(knots, values, "right") - 1, 0, len(knots) - 2)
    return i, np.clip((values - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0)
