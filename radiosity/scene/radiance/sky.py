"""Radiance's distant sources: suns as directional light, skies as ambient light."""

from dataclasses import dataclass, replace

import numpy as np

from radiosity.light.photometry import luminance

WIDE = 10.0  # degrees across, above which one direction is said to be a coarse approximation


@dataclass(frozen=True)
class Distant:
    """Light of some radiance (3,) from a cone about ``way`` that is ``angle`` degrees wide."""

    way: np.ndarray
    angle: float
    radiance: np.ndarray

    def turned(self, linear: np.ndarray) -> "Distant":
        """Return the source turned by a matrix (3, 3)."""
        way = linear @ self.way
        return replace(self, way=way / np.linalg.norm(way))


def lights_of(sources: list[Distant]) -> tuple[list[dict], list[str]]:
    """Return the tables ``[[lights]]`` of distant sources, and notes.

    A cone narrower than a half space becomes one direction, with the irradiance pi L sin^2(angle/2)
    of a plane that faces it. Of half spaces, sky and ground, the brightest becomes ambient light
    from everywhere.
    """
    shining = [s for s in sources if s.radiance.any()]
    cones = [s for s in shining if s.angle < 180.0]
    skies = [s for s in shining if s.angle >= 180.0]
    lights, notes = [], []
    for s in cones:
        irradiance = np.pi * np.sin(np.radians(s.angle / 2.0)) ** 2 * s.radiance
        lights.append({
            "type": "directional", "direction": (-s.way).tolist(), "irradiance": irradiance.tolist()
        })  # fmt: skip
    wide = sum(s.angle > WIDE for s in cones)
    if wide:
        notes.append(f"{wide} distant sources wider than {WIDE:g} degrees shine in one direction")
    if skies:
        sky = max(skies, key=lambda s: luminance(s.radiance))
        lights.append({"type": "ambient", "radiance": sky.radiance.tolist()})
        others = len(skies) - 1
        notes.append(
            "the sky is ambient light, the same from everywhere"
            + (f"; {others} darker half spaces are left out" if others else "")
        )
    return lights, notes
