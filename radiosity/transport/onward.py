"""Light that looking around finds by way of mirrors, clear bodies and lobes (E24).

A ray that meets a surface which sends light on along single directions brings beside the light
that leaves it evenly what that sends on: it is followed (`follow`), and at its ends finds the
stored field, what lights emit and, by lobes, what abstract light sources send.
"""

import numpy as np

from radiosity.light.frames import frame, to_local
from radiosity.transport.irradiance import Surroundings, carried
from radiosity.transport.lamps import reaching
from radiosity.transport.paths import Bundle, first_rays, follow


def sent_on(
    around: Surroundings, origins, directions, sides, hits, keys, samples: range, seed: int
) -> np.ndarray:
    """Return (k, bands) exitance in W/m2 that rays bring beside what `carried` finds at `hits`.

    Parameters
    ----------
    origins, directions, hits : (k, 3) float32
        In ray coordinates.
    sides : (k,) int
        See `meet`.
    keys, samples : (p,) int, range
        As for `sent_along`: k = p len(samples).
    """
    count = len(samples)
    owner = np.repeat(np.arange(len(keys)), count)
    start = first_rays(around.space, sides, hits, origins, directions, owner)
    found = start.share * lamplight(around, start)
    dim = np.flatnonzero((start.share != 1.0).any(axis=1))
    found[dim] += (start.share[dim] - 1.0) * carried(around, sides[dim], hits[dim])
    index = np.tile(np.arange(samples.start, samples.stop), len(keys))
    for ends in follow(around.space, start, np.repeat(keys, count), index, seed):
        here = carried(around, ends.sides, ends.hits) + lamplight(around, ends)
        if len(around.lights.polygons):  # otherwise the field has what lights emit
            here += np.pi * _emitted(around.space, ends.sides)
        np.add.at(found, ends.ray, ends.weight * here)
    return found


def _emitted(space, sides):
    """Return (k, bands) radiance that sides emit, W/(m2 sr)."""
    found = np.zeros((len(sides), space.optics.bands))
    k = np.flatnonzero((sides >= 0) & (sides % 2 == 0))
    found[k] = space.optics.emission[space.optics.material[space.faces(sides[k])]]
    return found


def lamplight(around: Surroundings, ends: Bundle) -> np.ndarray:
    """Return (k, bands) pi times the radiance that lobes at the ends make of lamps' light, W/m2."""
    found, space, lamps = np.zeros_like(ends.share), around.space, around.lights.lamps
    k = np.flatnonzero(space.sends_on(ends.sides)) if lamps else np.zeros(0, int)
    if not len(k):
        return found
    face, back = space.faces(ends.sides[k]), ends.sides[k] % 2
    points = space.points(ends.hits[k].astype(np.float64))
    normals = space.optics.facing(face, back == 1, points)
    for side, _, _, mine in space.optics.groups(face, back):
        if side.lobe is None:
            continue
        frames = frame(normals[mine])
        view = to_local(frames, -ends.directions[k[mine]].astype(np.float64))
        for lamp in lamps:
            here = reaching(
                around.visibility, lamp, points[mine], normals[mine], around.lights.unit_m
            )
            value = side.lobe.value(to_local(frames, here.to_light), view)
            found[k[mine]] += np.pi * value * here.irradiance
    return found
