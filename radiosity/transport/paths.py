"""Light along single directions: rays followed through mirrors, clear bodies and lobes (E22).

Radiance L that arrives along a ray from a surface is what that leaves diffusely there, and what it
sends on: k_r L along the mirrored ray, k_t L (n_here/n_there)^2 along the refracted one (L/n^2 is
invariant), exp(-a d) L after a way d in a medium, and f cos/density of one ray chosen by a lobe.
Rays branch at every such surface, and end after so many of them (`DEPTH`, `DEEP`) or where a path
has become weaker than a least share.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from radiosity.light.frames import frame, to_local, to_scene
from radiosity.transport.hemisphere import meet
from radiosity.transport.lookup import Table
from radiosity.transport.optics import Optics, Side
from radiosity.transport.sampling import hashed, sobol
from radiosity.transport.visibility import LIFT, Visibility

if TYPE_CHECKING:
    from radiosity.transport.images import Planes

DEPTH, DEEP, LEAST = 24, 64, 1e-3  # bounces in pictures and between elements; share of a path
SALT = 1 << 44  # tells the patterns of lobes from others
OPEN = -1  # the medium of rays in none
UNIT = 2.0**-53
AROUND, GOLDEN = 256, np.pi * (3.0 - np.sqrt(5.0))  # rays to all sides, turned by this angle each


@dataclass(frozen=True)
class Bundle:
    """Rays where they end.

    Attributes
    ----------
    ray : (k,) int
        The first ray that each comes from.
    sides : (k,) int
        2 * front (+ 1 for its back) of the patch met, -1 for none.
    hits : (k, 3) float32
        Where, in ray coordinates.
    directions : (k, 3) float32
        Of travel, away from the eye.
    share : (k, bands) float64
        Of the radiance here, or of the light sent from here, that the first point gets.
    gain : (k,) float64
        By which radiance rises on the way to the first point, n_first^2/n_here^2.
    medium : (k,) int
        Material whose inside the ray ended in, `OPEN` for none.
    way : (k,) float64
        Length of its last part, in ray coordinates.
    density : (k,) float64
        Per steradian, by which a lobe chose its direction; infinite where there was no choice.
    state : (k,) int
        Which of the sequences of mirrors it has gone that are known exactly, from 1 on; 0 for no
        mirror yet, -1 for any other way.
    """

    ray: np.ndarray
    sides: np.ndarray
    hits: np.ndarray
    directions: np.ndarray
    share: np.ndarray
    gain: np.ndarray
    medium: np.ndarray
    way: np.ndarray
    density: np.ndarray
    state: np.ndarray

    def some(self, k: np.ndarray) -> "Bundle":
        """Return some of the rays."""
        return Bundle(*(getattr(self, name)[k] for name in self.__dataclass_fields__))

    @property
    def weight(self) -> np.ndarray:
        """Return (k, bands): how much of the radiance here arrives as radiance."""
        return self.share * self.gain[:, None]


@dataclass(frozen=True)
class Space:
    """What rays meet, and what that does to them."""

    visibility: Visibility
    table: Table
    optics: Optics
    planes: "Planes | None" = None

    def after(self, rays: Bundle) -> np.ndarray:
        """Return the state (k,) of rays after a mirror that they have met."""
        if self.planes is None:
            return np.full(len(rays.ray), -1)
        return self.planes.after(rays.state, self.faces(rays.sides), rays.sides % 2)

    def faces(self, sides: np.ndarray) -> np.ndarray:
        """Return (k,) the face of each side met."""
        return self.table.face[sides // 2]

    def points(self, hits: np.ndarray) -> np.ndarray:
        """Return points (k, 3) of ray coordinates in scene units."""
        return self.visibility.centre + hits / self.visibility.scale

    def sends_on(self, sides: np.ndarray) -> np.ndarray:
        """Return (k,) bool: which sides are not all diffuse; not where nothing is met."""
        found = np.zeros(len(sides), bool)
        k = np.flatnonzero(sides >= 0)
        found[k] = self.optics.on(self.faces(sides[k]), sides[k] % 2)
        return found


def first_rays(
    space: Space, sides: np.ndarray, hits: np.ndarray, origins: np.ndarray, directions: np.ndarray,
    groups: np.ndarray,
) -> Bundle:  # fmt: skip
    """Return rays that were traced once as a bundle; what they cross before that dims them.

    Parameters
    ----------
    sides, hits : (k,), (k, 3)
        See `meet`.
    origins, directions : (k, 3) float32
        Where they began, and unit vectors.
    groups : (k,) int
        Rays of one number begin in one place, and so in one medium.
    """
    medium = _media(space, sides, groups)
    return rays_within(space, sides, hits, origins, directions, medium)


def rays_within(
    space: Space, sides: np.ndarray, hits: np.ndarray, origins: np.ndarray, directions: np.ndarray,
    medium: np.ndarray,
) -> Bundle:  # fmt: skip
    """Return rays as `first_rays` does that begin in media (k,) which are known."""
    k = len(sides)
    way = np.linalg.norm(hits - origins, axis=1)
    made = Bundle(
        np.arange(k), sides, hits, directions, np.ones((k, space.optics.bands)), np.ones(k), medium,
        way, np.full(k, np.inf), np.zeros(k, int),
    )  # fmt: skip
    return _dimmed(space, made)


def medium_at(space: Space, point: np.ndarray) -> int:
    """Return the medium that a point (3,), scene units, lies in: `OPEN`, or a material's inside.

    It is told by the clear surfaces that rays to all sides meet first, most of them from inside.
    """
    if not _clear(space.optics).any():
        return OPEN
    k = np.arange(AROUND) + 0.5
    z, phi = 1.0 - 2.0 * k / AROUND, GOLDEN * k
    r = np.sqrt(1.0 - z * z)
    directions = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1).astype(np.float32)
    start = (point - space.visibility.centre) * space.visibility.scale
    origins = np.tile(start.astype(np.float32), (AROUND, 1))
    sides, _ = meet(space.visibility, space.table, origins, directions)
    sides = sides[sides >= 0]
    material = space.optics.material[space.faces(sides)]
    told = np.where(sides % 2 == 1, material, OPEN)[_clear(space.optics)[material]]
    found, votes = np.unique(told, return_counts=True)
    return int(found[np.argmax(votes)]) if len(found) else OPEN


def _clear(optics):
    """Return (materials,) bool: which bend light on its way into a body."""
    return np.array([any(s and s.index is not None for s in pair) for pair in optics.sides])


def _media(space, sides, groups):
    """Return (k,) the medium that rays begin in: what the clear surfaces tell that they meet."""
    optics = space.optics
    clear = _clear(optics)
    medium = np.full(len(sides), OPEN)
    if not clear.any():
        return medium
    met = np.flatnonzero(sides >= 0)
    material = optics.material[space.faces(sides[met])]
    told, inside = clear[material], sides[met] % 2 == 1
    votes = np.zeros(groups.max(initial=-1) + 1)  # of many rays one may slip through a crack
    np.add.at(votes, groups[met[told]], np.where(inside[told], 1, -1))
    within = told & inside & (votes[groups[met]] > 0)
    of_group = np.full(len(votes), OPEN)
    of_group[groups[met[within]]] = material[within]
    return of_group[groups]


def follow(
    space: Space, start: Bundle, keys: np.ndarray, index: np.ndarray, seed: int, *,
    lobes: bool = True, depth: int = DEPTH, least: float = LEAST,
) -> Iterator[Bundle]:  # fmt: skip
    """Yield where rays end that are sent on by what the rays of ``start`` met, bounce by bounce.

    Parameters
    ----------
    keys, index : (rays,) int
        Of the first rays: what patterns of lobes are hashed from, and which points of them to use.
    lobes : bool
        Follow one ray of every lobe; without, only mirrored and refracted ones.
    """
    rays = start
    for bounce in range(depth):
        rays = rays.some(np.flatnonzero(space.sends_on(rays.sides)))
        if not len(rays.ray):
            return
        sent = list(_sent_on(space, rays, keys, index, bounce, seed, lobes))
        if not sent:  # by lobes only, which are not followed
            return
        rays = _joined([_kept(bundle, origin, least) for bundle, origin in sent])
        if not len(rays.ray):
            return
        rays = _traced(space, rays)
        yield rays


def _traced(space, rays):
    """Return rays, which hold where they begin, where they end."""
    begin = rays.hits.copy()
    sides, hits = meet(space.visibility, space.table, rays.hits, rays.directions)
    return _dimmed(space, replace(
        rays, sides=sides, hits=hits, way=np.linalg.norm(hits - begin, axis=1)
    ))  # fmt: skip


def _dimmed(space, rays):
    """Return rays after the last part of their ways through media that absorb."""
    k = np.flatnonzero(rays.medium != OPEN)
    if not len(k):
        return rays
    rate = space.optics.absorption[rays.medium[k]] / space.visibility.scale
    depth = np.where(rays.sides[k] >= 0, rays.way[k], np.finfo(float).max)[:, None]
    share = rays.share.copy()
    with np.errstate(over="ignore"):  # of what never ends nothing is left
        share[k] *= np.exp(-rate * depth)
    return replace(rays, share=share)


def _kept(rays, origins, least):
    """Return the rays that carry enough, with where they begin in place of where they ended."""
    k = np.flatnonzero(rays.share.max(axis=1, initial=0.0) > least)
    return replace(rays.some(k), hits=origins[k].astype(np.float32))


def _joined(bundles):
    parts = [[getattr(b, name) for b in bundles] for name in Bundle.__dataclass_fields__]
    return Bundle(*map(np.concatenate, parts))


def _sent_on(space, rays, keys, index, bounce, seed, lobes):
    """Yield bundles of rays sent on and their origins (k, 3), in ray coordinates."""
    face, back = space.faces(rays.sides), rays.sides % 2
    points = space.points(rays.hits.astype(np.float64))
    normals = space.optics.facing(face, back == 1, points)
    flat = np.where(back[:, None] == 1, -1.0, 1.0) * space.optics.normal[face]
    for side, material, inside, k in space.optics.groups(face, back):
        mine, n = rays.some(k), _towards(normals[k], flat[k], rays.directions[k])
        cosine = np.clip(-np.einsum("kc,kc->k", mine.directions, n), 0.0, 1.0)
        above = mine.hits + LIFT * flat[k]
        if side.lobe is not None and lobes:
            u = squares(keys[mine.ray], index[mine.ray], bounce, seed)
            yield _from_lobe(side.lobe, mine, n, flat[k], u), above
        under = side.under_lobe(cosine)
        if side.mirror is not None:
            mirrored = _over(mine.directions + 2.0 * cosine[:, None] * n, flat[k])
            yield replace(
                mine, directions=mirrored, share=mine.share * under * side.mirror.albedo(cosine),
                density=np.full(len(k), np.inf), state=space.after(mine),
            ), above  # fmt: skip
        if side.passage is not None:
            below = replace(mine, hits=mine.hits - LIFT * flat[k])
            for passed in _passed(side, material, inside, below, n, cosine, under):
                yield passed, passed.hits  # not all pass


def _towards(normals, flat, directions):
    """Return the normals, or the faces' own where a ray meets one of those from below."""
    below = np.einsum("kc,kc->k", directions, normals) >= 0.0
    return np.where(below[:, None], flat, normals)


def _over(directions, flat):
    """Return directions (k, 3) float32, mirrored over the faces where they run below them."""
    under = np.minimum(np.einsum("kc,kc->k", directions, flat), 0.0)
    return (directions - 2.0 * under[:, None] * flat).astype(np.float32)


def _passed(side: Side, material, inside, rays, normals, cosine, under):
    """Yield the rays that go on beyond an interface, those of each index by themselves."""
    share = rays.share * under * side.passage.albedo(cosine)
    other = np.full(len(share), -1)
    rays = replace(rays, density=np.full(len(share), np.inf), state=other)
    if side.index is None:
        yield replace(rays, share=share)
        return
    medium = np.full(len(rays.ray), OPEN if inside else material)
    ratio = np.broadcast_to(side.index, share.shape[1:])
    for index in np.unique(ratio):
        bend = 1.0 / index
        rest = 1.0 - bend**2 * (1.0 - cosine**2)
        k = np.flatnonzero(rest > 0.0)
        along = bend * rays.directions[k] + (bend * cosine[k] - np.sqrt(rest[k]))[:, None] * (
            normals[k]
        )
        yield replace(
            rays.some(k), directions=along.astype(np.float32), share=share[k] * (ratio == index),
            gain=rays.gain[k] * bend**2, medium=medium[k],
        )  # fmt: skip


def _from_lobe(lobe, rays, normals, flat, u):
    """Return one ray each, chosen by a lobe: its share is f cos/density."""
    frames = frame(normals)
    view = to_local(frames, -rays.directions.astype(np.float64))
    light = lobe.sample(view, u)
    density, cosine = lobe.density(view, light), light[..., 2]
    directions = to_scene(frames, light)
    good = (cosine > 0.0) & (density > 0.0) & (np.einsum("kc,kc->k", directions, flat) > 0.0)
    weight = np.where(good, cosine / np.where(good, density, 1.0), 0.0)
    share = rays.share * lobe.value(light, view) * weight[:, None]
    return replace(
        rays, directions=directions.astype(np.float32), share=share, density=density,
        state=np.full(len(share), -1),
    )  # fmt: skip


def squares(keys, index, bounce, seed, salt=0):
    """Return points (k, 2) of the unit square; even at the first bounce, by chance at others.

    ``salt`` tells patterns apart of one bounce.
    """
    u = np.empty((len(keys), 2))
    _fill(np.ascontiguousarray(keys), np.ascontiguousarray(index), bounce, seed, salt, u)
    return u


@njit(cache=True, nogil=True)
def _fill(keys, index, bounce, seed, salt, u):
    for k in range(len(keys)):
        shift = hashed(keys[k], SALT + bounce + (salt << 8), seed)
        if bounce == 0:
            u[k, 0] = sobol(index[k], 2, shift)
            u[k, 1] = sobol(index[k], 3, shift >> np.uint64(32))
        else:
            u[k, 0] = (hashed(shift, index[k], 0) >> np.uint64(11)) * UNIT
            u[k, 1] = (hashed(shift, index[k], 1) >> np.uint64(11)) * UNIT


