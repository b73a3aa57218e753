"""Abstract light sources: what they send to a point, with no shape of their own.

A source has a radiant intensity I(w) in W/sr, and at the distance d causes the irradiance I/d^2 on
a plane that faces it, or, with the falloff 1/(a d^m + b) of a shading model, I/(a d^m + b). A
directional source is infinitely far: its irradiance is the same everywhere. Positions are in scene
units, distances in metres where light is computed.
"""

from dataclasses import dataclass, replace

import numpy as np

TAIL = 1e-6  # of a lobe's peak, below which nothing is looked for
UNIT = 1e-6  # by which vectors may miss the length 1
WIDEST = 0.5  # of a lobe's half angle, of a cone that middles tell enough of


@dataclass(frozen=True)
class Falloff:
    """1/(a d^m + b) of the distance d in metres; a = 1, b = 0, m = 2 is the law of nature."""

    a: float = 1.0
    b: float = 0.0
    m: float = 2.0

    def __call__(self, distance: np.ndarray) -> np.ndarray:
        """Return the share (k,) in 1/m2 of distances (k,) in m; 0 at the distance 0.

        Where it would be no number of double precision it is the largest one.
        """
        with np.errstate(divide="ignore", over="ignore"):
            share = 1.0 / (self.a * distance**self.m + self.b)
        return np.where(distance > 0.0, np.minimum(share, np.finfo(float).max), 0.0)


class Source:
    """A source that shines alike in all directions in which it shines."""

    def edges(self, from_light: np.ndarray) -> np.ndarray:
        """Return (k,) values that change fast where the shape has an edge, and only there."""
        return np.ones(len(from_light))

    def misses(self, from_light: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return (k,) bool: cones about directions whose middles tell nothing of the light in them.

        Those that may hold all of a lobe narrower than they are; ``radius`` (k,) in radians.
        """
        return np.zeros(len(from_light), bool)


@dataclass(frozen=True)
class Point(Source):
    """A point that shines alike in all directions.

    Attributes
    ----------
    position : (3,) float64
        Scene units.
    intensity : (bands,) float64
        I in W/sr.
    falloff : Falloff
    group : str
        Lights of one group are dimmed together.
    """

    position: np.ndarray
    intensity: np.ndarray
    falloff: Falloff = Falloff()
    group: str = ""

    @property
    def strength(self) -> np.ndarray:
        """Return (bands,) the intensity in W/sr."""
        return self.intensity

    def shape(self, from_light: np.ndarray) -> np.ndarray:
        """Return I(w) / I, (k,), in directions (k, 3) of travel."""
        return np.ones(len(from_light))

    def problems(self) -> list[str]:
        """Return what is wrong with it beside its strength, as ends of sentences."""
        found = [] if np.isfinite(self.position).all() else ["has a position that is not finite"]
        if not (self.falloff.a > 0.0 or self.falloff.b > 0.0):
            found.append("has a falloff without a and b: 1/(a d^m + b) has no value")
        axis = getattr(self, "axis", None)
        if axis is not None and abs(np.linalg.norm(axis) - 1.0) > UNIT:
            found.append(f"has an axis of length {np.linalg.norm(axis):g}, must be 1")
        return found

    def of_intensity(self, intensity: np.ndarray) -> "Point":
        """Return the same source with another intensity (bands,)."""
        return replace(self, intensity=intensity)

    def of_strength(self, strength: np.ndarray) -> "Point":
        """Return the same source of another strength (bands,), its intensity."""
        return self.of_intensity(strength)

    def moved(self, turn: np.ndarray, shift: np.ndarray) -> "Point":
        """Return the same source at turn @ position + shift, turned (3, 3) or mirrored."""
        axis = getattr(self, "axis", None)
        more = {} if axis is None else {"axis": turn @ axis}
        return replace(self, position=turn @ self.position + shift, **more)

    @property
    def solid_angle(self) -> float:
        """Return the integral of the shape over all directions in sr: flux = I times it."""
        return 4.0 * np.pi

    def reaching(self, points: np.ndarray, unit_m: float):
        """Return what reaches points (k, 3), nothing being in the way.

        Returns
        -------
        to_light : (k, 3) float64
            Unit vectors; 0 at the source itself.
        distance : (k,) float64
            Scene units.
        irradiance : (k, bands) float64
            On a plane that faces the source, W/m2.
        """
        apart = self.position - points
        distance = np.linalg.norm(apart, axis=1)
        to_light = apart / np.where(distance > 0.0, distance, 1.0)[:, None]
        strength = self.shape(-to_light) * self.falloff(distance * unit_m)
        return to_light, distance, strength[:, None] * self.intensity


@dataclass(frozen=True)
class Spot(Point):
    """A point that shines in a cone about an axis.

    Its intensity is full up to the angle ``beam`` from the axis and falls linearly in the angle to
    0 at ``cutoff``, both in radians.
    """

    axis: np.ndarray = None
    beam: float = 0.0
    cutoff: float = np.pi

    def shape(self, from_light: np.ndarray) -> np.ndarray:
        """Return 1 inside the beam, (cutoff - angle) / (cutoff - beam) between, 0 beyond."""
        angle = _angle(from_light, self.axis)
        ramp = self.cutoff - self.beam
        if ramp == 0.0:
            return (angle <= self.beam).astype(float)
        return np.clip((self.cutoff - angle) / ramp, 0.0, 1.0)

    def edges(self, from_light: np.ndarray) -> np.ndarray:
        """Return the shape: its ramp may be steep."""
        return self.shape(from_light)

    def misses(self, from_light: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return (k,) bool, see `Source.misses`."""
        return _hold(from_light, self.axis, radius, self.cutoff, self.cutoff)

    @property
    def solid_angle(self) -> float:
        """Return 2 pi (1 - (sin c - sin b)/(c - b)), c and b the cutoff and the beam.

        With m and h their half sum and half difference (sin c - sin b)/(c - b) = cos(m) sin(h)/h,
        of which 1 is taken off without cancelling.
        """
        m, h = (self.cutoff + self.beam) / 2.0, (self.cutoff - self.beam) / 2.0
        narrow = h * h / 6.0 if h < 1e-3 else 1.0 - np.sin(h) / h
        return float(2.0 * np.pi * (2.0 * np.sin(m / 2.0) ** 2 + np.cos(m) * narrow))


@dataclass(frozen=True)
class Flood(Point):
    """A point whose intensity is I cos^n of the angle to its axis, 0 behind; n = 1 is Lambert's."""

    axis: np.ndarray = None
    exponent: float = 1.0

    def shape(self, from_light: np.ndarray) -> np.ndarray:
        """Return cos^n of the angle to the axis."""
        cosine = from_light @ self.axis
        return np.where(cosine > 0.0, np.clip(cosine, 0.0, 1.0) ** self.exponent, 0.0)

    def edges(self, from_light: np.ndarray) -> np.ndarray:
        """Return (k,) 1 in front and 0 behind."""
        return (from_light @ self.axis > 0.0).astype(float)

    def misses(self, from_light: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return (k,) bool, see `Source.misses`."""
        half, end = (np.arccos(least ** (1.0 / max(self.exponent, 1e-6))) for least in (0.5, TAIL))
        return _hold(from_light, self.axis, radius, half, end)

    @property
    def solid_angle(self) -> float:
        """Return 2 pi/(n + 1)."""
        return 2.0 * np.pi / (self.exponent + 1.0)


@dataclass(frozen=True)
class Directional(Source):
    """Parallel light, of the sun.

    Attributes
    ----------
    direction : (3,) float64
        Unit vector of travel.
    irradiance : (bands,) float64
        On a plane at right angles to it, W/m2.
    group : str
        Lights of one group are dimmed together.
    """

    direction: np.ndarray
    irradiance: np.ndarray
    group: str = ""

    @property
    def strength(self) -> np.ndarray:
        """Return (bands,) the irradiance in W/m2."""
        return self.irradiance

    def of_strength(self, strength: np.ndarray) -> "Directional":
        """Return the same light of another strength (bands,), its irradiance."""
        return replace(self, irradiance=strength)

    def problems(self) -> list[str]:
        """Return what is wrong with it beside its strength, as ends of sentences."""
        length = np.linalg.norm(self.direction)
        return [] if abs(length - 1.0) <= UNIT else [f"has a direction of length {length:g}, not 1"]

    def moved(self, turn: np.ndarray, shift: np.ndarray) -> "Directional":
        """Return the same light turned (3, 3) or mirrored."""
        return replace(self, direction=turn @ self.direction)

    def reaching(self, points: np.ndarray, unit_m: float):
        """Return what reaches points (k, 3), see `Point.reaching`; from an infinite distance."""
        k = len(points)
        to_light = np.tile(-self.direction, (k, 1))
        return to_light, np.full(k, np.inf), np.tile(self.irradiance, (k, 1))


Light = Point | Directional


def _angle(directions, axis):
    """Return the angles (k,) between unit vectors, exact for small ones too."""
    across = np.linalg.norm(np.cross(directions, axis), axis=1)
    return np.arctan2(across, directions @ axis)


def _hold(directions, axis, radius, half, end):
    """Whether cones wider than a lobe's half angle may hold some of it, up to its end."""
    return (radius > WIDEST * half) & (_angle(directions, axis) < end + radius)
