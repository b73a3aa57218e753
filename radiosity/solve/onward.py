"""What mirrors, clear bodies and lobes do with the power that arrives at them, for the balance.

A patch sends on int a(theta) L cos(theta) dw of the light that arrives, a the share of each
direction; it absorbs what it neither scatters nor sends on. Light of lamps and of the outside may
leave the scene again without ever being scattered.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from radiosity.mesh.elements import make_elements, make_nodes
from radiosity.transport.aiming import make_targets
from radiosity.transport.caustics import FEWEST, rays_of
from radiosity.transport.hemisphere import meet, rays_from
from radiosity.transport.paths import OPEN, Bundle, first_rays, follow

RAYS, IN_ALL = 256, 1 << 18  # from a node at most, and from all together about
KEY = 1 << 47
FARTHEST = 600.0  # of ways in a medium, in units of its absorption: e^600 is still a number


@dataclass(frozen=True)
class Onward:
    """Power in W a band (bands,) that patches sent on.

    ``escaped`` of it left the scene without being scattered, and media ``swallowed`` some.
    """

    sent: np.ndarray
    escaped: np.ndarray
    swallowed: np.ndarray


def find_onward(level) -> Onward:
    """Return what the patches of a solved mesh with a tracer send on."""
    tracer, patches, rows = level.tracer, level.reach.patches, level.rows
    place = np.where(patches.front[rows], 2 * rows, 2 * patches.front_of[rows] + 1)
    mine = np.flatnonzero(tracer.space.sends_on(place))
    bands = level.scene.bands.count
    if not len(mine):
        return Onward(*np.zeros((3, bands)))
    nodes = make_nodes(make_elements(patches, rows[mine], 1))
    side = place[mine][nodes.owner]
    normals = patches.normal[rows[mine]][nodes.owner]
    k = int(np.clip(IN_ALL // len(side), 16, RAYS))
    found = np.zeros((3, len(side), bands))
    _of_rays(level, nodes.points, normals, side, k, found)
    area = patches.area[rows[mine]] * level.scene.unit_m**2
    fit = nodes.fit[: len(mine)]
    by_lamps = _of_lamps(level, level.scene)
    return Onward(*(area @ (fit @ x) + y for x, y in zip(found, by_lamps, strict=True)))


def _of_rays(level, points, normals, side, count, found):
    """Add what arrives along rays from points on sides, times what these send on of it."""
    tracer, space, seed = level.tracer, level.tracer.space, level.recipe.seed
    keys = KEY + np.arange(len(points))
    origins, directions = rays_from(space.visibility, points, normals, keys, range(count), seed)
    begin = origins.copy()
    sides, hits = meet(space.visibility, space.table, origins, directions)
    owner = np.repeat(np.arange(len(points)), count)
    start = first_rays(space, sides, hits, begin, directions, owner)
    cosine = np.clip(np.einsum("kc,kc->k", directions, normals[owner]), 0.0, 1.0)
    share = _sent_on(space, side[owner], cosine) / count
    keys, index = keys[owner], np.tile(np.arange(count), len(points))
    light = start.weight * tracer.radiosity(start, level.coefficients, level.scene.ambient)
    for ends in follow(space, start, keys, index, seed):
        more = ends.weight * tracer.radiosity(ends, level.coefficients, level.scene.ambient)
        np.add.at(light, ends.ray, more)
    np.add.at(found[0], owner, share * light)
    if space.optics.absorption.any():
        lost = _swallowed_next(space, side[owner], points[owner], -directions, seed)
        np.add.at(found[2], owner, light * lost / count)
    out = np.flatnonzero(sides < 0)
    if level.scene.ambient.any() and len(out):
        light = np.pi * level.scene.ambient / count
        left = _left(space, side[owner[out]], points[owner[out]], -directions[out], seed)
        np.add.at(found[1], owner[out], light * left)


def _of_lamps(level, scene):
    """Return what lamps send to sides, times what these send on of it, bounce by bounce."""
    space, seed = level.tracer.space, level.recipe.seed
    targets = make_targets(scene.faces, space.visibility, space.optics.wanted())
    sent, escaped, swallowed = np.zeros((3, scene.bands.count))
    for number, lamp in enumerate(scene.lights):
        start, power = rays_of(space, targets, lamp, number, scene.unit_m, FEWEST, seed)
        keys, index = np.full(len(power), KEY), np.arange(len(power))
        for ends in itertools.chain([start], follow(space, start, keys, index, seed)):
            light = power[ends.ray] * ends.share
            escaped += light[ends.sides < 0].sum(axis=0)
            swallowed += (power[ends.ray] * _swallowed(space, ends)).sum(axis=0)
            k = np.flatnonzero(space.sends_on(ends.sides))
            face, back = space.faces(ends.sides[k]), ends.sides[k] % 2 == 1
            points = space.points(ends.hits[k].astype(np.float64))
            cosine = -np.einsum(
                "kc,kc->k", ends.directions[k], space.optics.facing(face, back, points)
            )
            share = _sent_on(space, ends.sides[k], np.clip(cosine, 0.0, 1.0))
            sent += (light[k] * share).sum(axis=0)
    return sent, escaped, swallowed


def _sent_on(space, side, cosine):
    """Return (k, bands) the share of light from some directions that sides send on."""
    found = np.zeros((len(side), space.optics.bands))
    for one, _, _, k in space.optics.groups(space.faces(side), side % 2):
        found[k] = one.sent_on(cosine[k])
    return found


def _left(space, side, points, directions, seed):
    """Return (k, bands) the share of light that travels to points on sides that leaves the scene.

    Without being scattered on the way.
    """
    k = len(side)
    found = np.zeros((k, space.optics.bands))
    here = _arriving(space, side, points, directions)
    for ends in follow(space, here, KEY + np.arange(k), np.zeros(k, int), seed):
        out = np.flatnonzero(ends.sides < 0)
        np.add.at(found, ends.ray[out], ends.share[out])
    return found


def _arriving(space, side, points, directions):
    """Return light that travels to points on sides as a bundle of rays that end there."""
    k = len(side)
    hits = ((points - space.visibility.centre) * space.visibility.scale).astype(np.float32)
    return Bundle(
        np.arange(k), side, hits, directions, np.ones((k, space.optics.bands)), np.ones(k),
        np.full(k, OPEN), np.zeros(k), np.full(k, np.inf), np.full(k, -1),
    )  # fmt: skip


def _swallowed_next(space, side, points, directions, seed):
    """Return (k, bands) the share of light that arrives at sides that is lost in media after."""
    k = len(side)
    found = np.zeros((k, space.optics.bands))
    here = _arriving(space, side, points, directions)
    for material in range(len(space.optics.sides)):  # a mirrored ray stays in its medium
        inside = (side % 2 == 1) & (space.optics.material[space.faces(side)] == material)
        here.medium[inside] = material
    for ends in follow(space, here, KEY + np.arange(k), np.zeros(k, int), seed, depth=1):
        np.add.at(found, ends.ray, _swallowed(space, ends))
    return found


def _swallowed(space, ends):
    """Return (k, bands) what media have taken off the shares of rays on their last way."""
    found = np.zeros_like(ends.share)
    k = np.flatnonzero((ends.medium != OPEN) & (ends.sides >= 0))
    rate = space.optics.absorption[ends.medium[k]] / space.visibility.scale
    found[k] = ends.share[k] * np.expm1(np.minimum(rate * ends.way[k, None], FARTHEST))
    return found
