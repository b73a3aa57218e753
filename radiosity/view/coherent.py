"""Coherent light in pictures: what mirrors show and what is seen through clear bodies (E26).

L = L_own + k_r L_r + k_t (n_here/n_there)^2 L_t: from where a sight line ends it goes on along the
mirrored and the refracted direction, again and again, and at each end the light that leaves there
is gathered as if the end were seen by itself.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radiosity.light.coherent import Straight
from radiosity.scene.model import Scene
from radiosity.solve.optics import make_optics
from radiosity.solve.reach import Reach
from radiosity.transport.optics import Side
from radiosity.transport.paths import (
    DEPTH,
    Bundle,
    Space,
    first_rays,
    follow,
    medium_at,
    rays_within,
)
from radiosity.view.shading import Shading
from radiosity.view.sightlines import Seen, rows_of

KEY = 1 << 46  # tells the patterns of what is seen in mirrors from those of pixels


def with_coherent(
    view, shading: Shading, origin: np.ndarray, rows: np.ndarray, points: np.ndarray,
    directions: np.ndarray, keys: np.ndarray, index: int, own: Callable, depth: int = DEPTH,
) -> Seen:  # fmt: skip
    """Return what sight lines show with all that mirrors and clear bodies add to it.

    Parameters
    ----------
    view : Solution or Stage
    origin : (3,) or (k, 3) float64
        Where they begin, scene units.
    rows, points : (k,) int, (k, 3) float64
        The patches that they meet, and where.
    directions : (k, 3) float64
        In which they go.
    keys, index : (k,) int, int
        What patterns are hashed from, and the number of the pass.
    own : callable
        ``own(rows, points, to_view, keys, index)`` returns what leaves points of patches by itself
        as `Seen`.
    depth : int
        How many surfaces a line is followed over.
    """
    space = _as_seen(view.space, shading)
    start = _start(view, space, origin, rows, points, directions)
    seen = _through(own(rows, points, -directions, keys, index), start.share)
    best = seen.diffuse.max(axis=1)
    for bounce, ends in enumerate(
        follow(space, start, keys, np.full(len(rows), index), view.seed, lobes=False, depth=depth)
    ):
        _add_ends(view, shading, ends, keys + KEY * (bounce + 1), index, own, seen, best)
    return seen


def _as_seen(space: Space, shading: Shading) -> Space:
    """Return what rays meet with the normals of pictures, bumps among them."""
    if shading.detail is None:
        return space

    def normals(face, points):
        return shading.detail.normals(face, points, np.ones(len(face)))

    return replace(space, optics=replace(space.optics, smooth=normals))


def _start(view, space, origin, rows, points, directions) -> Bundle:
    """Return the sight lines where they end, in the medium that the camera is in."""
    patches, visibility = view.patches, space.visibility
    sides = np.where(patches.front[rows], 2 * rows, 2 * patches.front_of[rows] + 1)
    origins = np.broadcast_to(origin, points.shape)
    hits, begin = (
        ((x - visibility.centre) * visibility.scale).astype(np.float32) for x in (points, origins)
    )
    ways = directions.astype(np.float32)
    if np.ndim(origin) == 2 and np.any(origin != origin[0]):  # each line begins by itself
        return first_rays(space, sides, hits, begin, ways, np.arange(len(rows)))
    medium = np.full(len(rows), medium_at(space, origins[0]))
    return rays_within(space, sides, hits, begin, ways, medium)


def _add_ends(view, shading, ends, keys, index, own, seen, best):
    """Add what is seen at the ends of lines that were sent on; keep what is seen best."""
    rows, weight = rows_of(view, ends.sides), ends.weight
    gone = np.flatnonzero(ends.sides < 0)
    outside = view.surroundings.field.outside / np.pi
    np.add.at(seen.leaving, ends.ray[gone], weight[gone] * outside)
    k = np.flatnonzero(rows >= 0)
    k = k[_shows(shading, rows[k])]
    if not len(k):
        return
    ray, points = ends.ray[k], view.space.points(ends.hits[k].astype(np.float64))
    there = own(rows[k], points, -ends.directions[k].astype(np.float64), keys[ray], index)
    there = _through(there, weight[k])
    np.add.at(seen.leaving, ray, there.leaving)
    _keep_the_brightest(seen, there, ray, best)


def _through(seen, weight) -> Seen:
    """Return what arrives of what is seen with a weight (k, bands)."""
    return replace(seen, leaving=weight * seen.leaving, diffuse=weight * seen.diffuse)


def _keep_the_brightest(seen, there, ray, best):
    """Let what is seen most of at one of several ends of a line be what is smoothed of it."""
    bright = there.diffuse.max(axis=1)
    order = np.argsort(bright, kind="stable")
    better = order[bright[order] > best[ray[order]]]  # of one line the brightest comes last
    for name in ("indirect", "nearness", "diffuse", "plane", "points"):
        getattr(seen, name)[ray[better]] = getattr(there, name)[better]
    best[ray[better]] = bright[better]


def _shows(shading, rows):
    """Return (k,) bool: which patches show anything by themselves."""
    parts = [shading.emission, shading.diffuse] + [x for x in [shading.through] if x is not None]
    return np.any([x[rows].any(axis=1) for x in parts], axis=0) | (shading.lobe[rows] >= 0)


def space_of(scene: Scene, reach: Reach, straight: bool) -> Space:
    """Return what sight lines are followed through in a scene that was not solved.

    ``straight``: no mirrors, and through clear bodies as if their index were 1.
    """
    optics = make_optics(scene, reach.table)
    if straight:
        optics = replace(optics, sides=tuple(map(_straight, optics.sides)))
    return Space(reach.visibility, reach.table, optics)


def _straight(pair) -> tuple[Side | None, Side | None]:
    """Return front and back of a material as light goes straight through it."""
    front, back = pair
    if front is None or front.passage is None:
        return None, None
    side = Side(front.lobe, None, Straight(front.passage))
    return side, None if back is None else side
