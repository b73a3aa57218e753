"""What mirrors, clear bodies and lobes do with the power that arrives at them, for the balance.

A patch sends on int a(theta) L cos(theta) dw of the light that arrives, a the share of each
direction; it absorbs what it neither scatters nor sends on. Light of lamps and of the outside may
leave the scene again without ever being scattered.
"""

import itertools
from dataclasses import dataclass, replace

import numpy as np

from radiosity.mesh.elements import make_elements, make_nodes
from radiosity.transport.aiming import make_targets
from radiosity.transport.caustics import FEWEST, rays_of
from radiosity.transport.hemisphere import meet, rays_from
from radiosity.transport.highlights import evenly_on
from radiosity.transport.irradiance import direct_irradiance
from radiosity.transport.paths import DEEP, OPEN, Bundle, first_rays, follow, squares
from radiosity.transport.tracer import Step

RAYS, IN_ALL = 256, 1 << 18  # from a node at most, and from all together about
AIMED = 16  # points on a light
GRAZING = 0.1  # cosine of the angle of light from what barely rises over a plane
KEY = 1 << 47
FARTHEST = 600.0  # of ways in a medium, in units of its absorption: e^600 is still a number


@dataclass(frozen=True)
class Onward:
    """Power in W a band (bands,) that came to patches ``rows`` which send light on.

    They ``absorbed`` some, some ``escaped`` without being scattered and media ``swallowed`` some.
    """

    rows: np.ndarray
    absorbed: np.ndarray
    escaped: np.ndarray
    swallowed: np.ndarray


def find_onward(level) -> Onward:
    """Return what becomes of the light at patches that send it on, of a mesh with a tracer.

    Added up by rays: a small difference of what arrives and what goes on would be lost in noise.
    """
    tracer, patches, rows = level.tracer, level.reach.patches, level.rows
    place = np.where(patches.front[rows], 2 * rows, 2 * patches.front_of[rows] + 1)
    mine = np.flatnonzero(tracer.space.sends_on(place))
    bands = level.scene.bands.count
    if not len(mine):
        return Onward(mine, *np.zeros((3, bands)))
    nodes = make_nodes(make_elements(patches, rows[mine], 1))
    side = place[mine][nodes.owner]
    normals = patches.normal[rows[mine]][nodes.owner]
    k = int(np.clip(IN_ALL // len(side), 16, RAYS))
    found = np.zeros((3, len(side), bands))
    kept = np.zeros((2 * patches.fronts, bands))
    kept[place] = level.terms.absorptance[rows]
    _of_rays(level, nodes.points, normals, side, kept, k, found)
    for light in range(len(tracer.lights.polygons)):
        taken, lost = _of_light(tracer, light, nodes.points, normals, side, kept)
        found[0] += taken
        found[2] += lost
    area = patches.area[rows[mine]] * level.scene.unit_m**2
    fit = nodes.fit[: len(mine)]
    by_lamps = _of_lamps(level, level.scene, kept)
    return Onward(mine, *(area @ (fit @ x) + y for x, y in zip(found, by_lamps, strict=True)))


def _of_rays(level, points, normals, side, kept, count, found):
    """Add what becomes of what arrives along rays from points on sides.

    But for what comes straight from lights that are looked for by themselves.
    """
    lights, seed = level.tracer.lights.without_lamps(), level.recipe.seed
    space = replace(level.tracer.space, planes=None)  # rays tell of planar mirrors, too
    tracer = replace(level.tracer, lights=lights, space=space)
    rest = tracer.beside_lights(level.coefficients)
    keys = KEY + np.arange(len(points))
    origins, directions = rays_from(space.visibility, points, normals, keys, range(count), seed)
    begin = origins.copy()
    sides, hits = meet(space.visibility, space.table, origins, directions)
    owner = np.repeat(np.arange(len(points)), count)
    start = first_rays(space, sides, hits, begin, directions, owner)
    cosine = np.clip(np.einsum("kc,kc->k", directions, normals[owner]), 0.0, 1.0)
    share = (kept[side[owner]] - _sent_on(space, side[owner], cosine)) / count
    keys, index = keys[owner], np.tile(np.arange(count), len(points))
    light = np.zeros((len(owner), space.optics.bands))
    steps = itertools.chain([start], follow(space, start, keys, index, seed, depth=DEEP))
    for bounce, ends in enumerate(steps):
        r = ends.ray
        step = Step(owner[r], ends, bounce, keys[r], index[r], np.ones(len(r)))
        here = tracer.radiosity(ends, rest, level.scene.ambient) + np.pi * tracer.straight(step)
        np.add.at(light, r, ends.weight * here)
    np.add.at(found[0], owner, share * light)
    if space.optics.absorption.any():
        lost = _swallowed_next(space, side[owner], points[owner], -directions, seed)
        np.add.at(found[2], owner, light * lost / count)
    out = np.flatnonzero(sides < 0)
    if level.scene.ambient.any() and len(out):
        light = np.pi * level.scene.ambient / count
        left = _left(space, side[owner[out]], points[owner[out]], -directions[out], seed)
        np.add.at(found[1], owner[out], light * left)


def _of_light(tracer, light, points, normals, side, kept):
    """Return what points on sides absorb of what a light sends, and what media swallow next.

    Means over points on the light, weighted by what they would send to a plane.
    """
    one, space, seed = tracer.lights.only(light), tracer.space, tracer.seed
    keys = KEY + np.arange(len(points))
    arriving = direct_irradiance(space.visibility, one, points, normals, keys, range(AIMED), seed)
    total, share, lost = np.zeros((3, len(points), space.optics.bands))
    for k in range(AIMED):
        u = squares(keys, np.full(len(points), k), 0, seed, 1)
        d = evenly_on(one.polygons[0], u) - points
        r2 = np.maximum(np.einsum("kc,kc->k", d, d), 1e-300)
        to_light = d / np.sqrt(r2)[:, None]
        cosine = np.clip(np.einsum("kc,kc->k", to_light, normals), 0.0, 1.0)
        weight = cosine * np.maximum(-(to_light @ one.normals[0]), 0.0) / r2
        total += weight[:, None]
        share += weight[:, None] * _sent_on(space, side, cosine)
        if space.optics.absorption.any():
            ways = (-to_light).astype(np.float32)
            lost += weight[:, None] * _swallowed_next(space, side, points, ways, seed)
    grazing = _sent_on(space, side, np.full(len(points), GRAZING))  # of what no point met
    whole = np.where(total > 0.0, total, 1.0)
    sent = np.where(total > 0.0, share / whole, grazing)
    return arriving * (kept[side] - sent), arriving * lost / whole


def _of_lamps(level, scene, kept):
    """Return what sides absorb of what lamps send, what escapes and what media swallow."""
    space, seed = level.tracer.space, level.recipe.seed
    targets = make_targets(scene.faces, space.visibility, space.optics.wanted())
    absorbed, escaped, swallowed = np.zeros((3, scene.bands.count))
    for number, lamp in enumerate(scene.lights):
        start, power = rays_of(space, targets, lamp, number, scene.unit_m, FEWEST, seed)
        keys, index = np.full(len(power), KEY), np.arange(len(power))
        rays = follow(space, start, keys, index, seed, depth=DEEP)
        for ends in itertools.chain([start], rays):
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
            absorbed += (light[k] * (kept[ends.sides[k]] - share)).sum(axis=0)
    return absorbed, escaped, swallowed


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
    for ends in follow(space, here, KEY + np.arange(k), np.zeros(k, int), seed, depth=DEEP):
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
