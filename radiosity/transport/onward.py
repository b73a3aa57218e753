"""Light that looking around finds by way of mirrors, clear bodies and lobes (E25).

A ray that meets a surface which sends light on along single directions brings beside the light
that leaves it evenly what that sends on: it is followed (`follow`), and at its ends finds the
stored field, what lights emit and, by lobes, what lights send that these look for.
"""

from dataclasses import replace

import numpy as np

from radiosity.transport.hemisphere import rays_from
from radiosity.transport.highlights import area_of_polygon, counted, in_lobes
from radiosity.transport.irradiance import Lights, Surroundings, carried
from radiosity.transport.paths import first_rays, follow


def irradiance_sent_on(
    around: Surroundings, points, normals, sides, hits, keys, samples: range, seed: int
) -> np.ndarray:  # fmt: skip
    """Return (p, bands) irradiance in W/m2 by what is sent on along the rays of `look_out`.

    Parameters
    ----------
    sides, hits : (p, n) int, (p, n, 3) float32
        What these met.
    """
    found = np.zeros((len(points), around.space.optics.bands))
    p = np.flatnonzero(_changed(around.space, sides.ravel()).reshape(sides.shape).any(axis=1))
    if len(p):
        here = points[p], normals[p], keys[p], samples, seed
        begin, directions = rays_from(around.visibility, *here)
        ends = sides[p].ravel(), hits[p].reshape(-1, 3)
        more = sent_on(around, begin, directions, *ends, keys[p], samples, seed, 0)
        found[p] = more.reshape(len(p), len(samples), -1).mean(axis=1)
    return found


def _changed(space, sides) -> np.ndarray:
    """Return (k,) bool: rays that may bring other light than what leaves their ends evenly."""
    if space.optics.absorption.any():
        return np.ones(len(sides), bool)
    return space.sends_on(sides)


def sent_on(
    around: Surroundings, origins, directions, sides, hits, keys, samples: range, seed: int,
    state: int = -1,
) -> np.ndarray:  # fmt: skip
    """Return (k, bands) exitance in W/m2 that rays bring beside what `carried` finds at ``hits``.

    Parameters
    ----------
    origins, directions, hits : (k, 3) float32
        In ray coordinates.
    sides : (k,) int
        See `meet`.
    keys, samples : (p,) int, range
        As for `radiosity.transport.irradiance.sent_along`: k = p len(samples).
    state : int
        0 where lights are not to be found in those planar mirrors whose light is known exactly.
    """
    space = around.space
    found = np.zeros((len(sides), space.optics.bands))
    k = np.flatnonzero(_changed(space, sides))
    if not len(k):
        return found
    owner = np.repeat(np.arange(len(keys)), len(samples))[k]
    index = np.tile(np.asarray(samples), len(keys))[k]
    start = first_rays(space, sides[k], hits[k], origins[k], directions[k], owner)
    start = replace(start, state=np.full(len(k), state))
    found[k] = _along(around, start, keys[owner], index, seed)
    return found


def _along(around, start, keys, index, seed):
    """Return what `sent_on` does, of rays where they end first."""
    space, lights, sides, hits = around.space, around.lights, start.sides, start.hits
    images = () if around.tracer is None else around.tracer.images
    found = np.pi * start.share * in_lobes(space, lights, start, keys, index, 0, seed, images)
    dim = np.flatnonzero((start.share != 1.0).any(axis=1))
    found[dim] += (start.share[dim] - 1.0) * carried(around, sides[dim], hits[dim])
    areas = _areas(lights, len(space.optics.material))
    for bounce, ends in enumerate(follow(space, start, keys, index, seed), 1):
        pattern = keys[ends.ray], index[ends.ray], bounce, seed
        straight = in_lobes(space, lights, ends, *pattern, images)
        share = counted(space, ends, areas) * (ends.state <= 0)  # others are known exactly
        straight += share[:, None] * _emitted(around, ends.sides)
        here = carried(around, ends.sides, ends.hits) + np.pi * straight
        np.add.at(found, ends.ray, ends.weight * here)
    return found


def _areas(lights: Lights, faces: int) -> np.ndarray:
    """Return (faces,) areas of the polygons that shine, 0 of other faces."""
    found = np.zeros(faces)
    if not len(lights.polygons):
        return found
    found[lights.face] = [area_of_polygon(q) for q in lights.polygons]
    return found


def _emitted(around, sides) -> np.ndarray:
    """Return (k, bands) radiance that lights emit from sides, W/(m2 sr)."""
    space, lights = around.space, around.lights
    number = np.full(len(space.optics.material), -1)
    number[np.asarray(lights.face, int)] = np.arange(len(lights.face))
    found = np.zeros((len(sides), space.optics.bands))
    k = np.flatnonzero((sides >= 0) & (sides % 2 == 0))
    light = number[space.faces(sides[k])]
    found[k[light >= 0]] = lights.exitance[light[light >= 0]] / np.pi
    return found
