"""What light can reach and what sees out, found before any factor: by rays where faces block."""

from functools import partial

import numpy as np
from numba import njit

from radiosity.mesh.elements import make_elements
from radiosity.mesh.patches import Patches, reversed_winding
from radiosity.transport.hemisphere import MISS, look_out
from radiosity.transport.irradiance import Lights, direct_irradiance
from radiosity.transport.lamps import lamps_on
from radiosity.transport.lookup import Table, margin_in
from radiosity.transport.polygon import heights, point_factor
from radiosity.transport.threads import over_ranges
from radiosity.transport.visibility import Visibility

FEWEST, MOST, IN_ALL = 32, 256, 1 << 22  # rays from a side, and about from all together
CHUNK = 256
AIMED = 8  # rays to each light
EDGE = 1e-5  # distance from the edges of a patch, in ray coordinates: nearer hits do not count
MOST_FREE = 10_000  # patches of which every pair is looked at where none can block
FLAT = 1e-13  # height over a plane, in ray coordinates, that is rounding
SEEN = 1e-9  # by which factors of a closed side may miss 1


def survey(
    visibility: Visibility,
    table: Table,
    patches: Patches,
    sources: np.ndarray,
    lights: Lights | None = None,
    seed: int = 0,
    through: np.ndarray | None = None,
) -> np.ndarray:
    """Return (fronts, 2) bool: sides that light reaches from ``sources``, after any reflections.

    Parameters
    ----------
    patches : Patches
        Fronts only.
    sources : (fronts, 2) bool
        Sides that emit; where light enters from outside, every side that sees the outside.
    lights : Lights, optional
        Aimed at one by one, since they may be too small or too far for any ray to meet.
    through : (fronts,) bool, optional
        Patches that light goes through.
    """
    lit = sources.copy()
    if lights is not None and lights.lamps:
        lit |= _lit_by_lamps(visibility, patches, lights)
    exposed = patches.behind < 0
    lit &= exposed
    through = np.zeros(patches.fronts, bool) if through is None else through & exposed.all(axis=1)
    lit |= lit[:, ::-1] & through[:, None]
    if not visibility.can_block and len(lit) <= MOST_FREE:
        _spread_freely(*_both_sides(visibility, patches), exposed, through, lit)
        return lit
    views = partial(_look, visibility, table, patches, seed=seed)
    inside = partial(_well_inside, visibility, patches)
    if lights is not None:
        lit |= _lit_directly(visibility, patches, lights.without_lamps(), seed) & exposed
    new = np.flatnonzero(lit)
    while len(new):
        _spread(views, inside, new, lit.reshape(-1), through)
        new = _small_ones(views, patches, lit)
    return lit


def _spread(views, inside, new, lit, through):
    """Follow light from new sides to all that it meets; mark them in ``lit`` (2 * fronts,)."""
    lit[new] = True
    while len(new):
        across = new[through[new // 2]] ^ 1
        new = np.append(new, across[~lit[across]])
        lit[across] = True
        sides, hits = views(new)
        dark = (sides != MISS) & ~lit[sides]
        met, places = sides[dark], hits[dark]
        new = np.unique(met[inside(met, places)])
        lit[new] = True


def _both_sides(visibility, patches):
    """Return fronts and backs, one after the other, (2, fronts, 4, 3), and their normals."""
    front = (patches.vertices[: patches.fronts] - visibility.centre) * visibility.scale
    normal = patches.normal[: patches.fronts]
    return np.stack([front, reversed_winding(front)]), np.stack([normal, -normal])


@njit(cache=True, nogil=True, error_model="numpy")
def _spread_freely(vertices, normals, exposed, through, lit):
    """Light all sides that face a lit one, where nothing can come between."""
    n = len(lit)
    waiting = [(i, s) for i in range(n) for s in range(2) if lit[i, s]]
    while len(waiting) > 0:
        i, s = waiting.pop()
        p, normal = vertices[s, i], normals[s, i]
        for j in range(n):
            for t in range(2):
                if lit[j, t] or not exposed[j, t]:
                    continue
                q = vertices[t, j]
                if heights(q, p[0], normal)[1] <= FLAT:
                    continue
                if heights(p, q[0], normals[t, j])[1] > FLAT:
                    lit[j, t] = True
                    waiting.append((j, t))
                    if through[j] and not lit[j, 1 - t]:
                        lit[j, 1 - t] = True
                        waiting.append((j, 1 - t))


@njit(cache=True, nogil=True, error_model="numpy")
def _see_out_freely(vertices, normals):
    """Return (n, 2): sides whose middles see less than all around them, nothing in between."""
    n, x = vertices.shape[1], np.empty(3)
    out = np.zeros((n, 2), np.bool_)
    for i in range(n):
        for c in range(3):
            x[c] = vertices[0, i, :, c].mean()
        for s in range(2):
            a, total = normals[s, i], 0.0
            for j in range(n):
                for t in range(2):
                    if heights(x.reshape(1, 3), vertices[t, j, 0], normals[t, j])[1] > FLAT:
                        total += point_factor(x[0], x[1], x[2], a[0], a[1], a[2], vertices[t, j])
            out[i, s] = total < 1.0 - SEEN
    return out


def _lit_directly(visibility, patches, lights, seed):
    """Return (fronts, 2) bool: sides whose middle sees some part of a light."""
    points, keys = patches.centroid, np.arange(patches.fronts)
    lit = np.zeros((patches.fronts, 2), bool)

    def work(a, b):
        for side, sign in enumerate((1, -1)):
            facing = sign * patches.normal[a:b]
            arriving = direct_irradiance(
                visibility, lights, points[a:b], facing, keys[a:b], range(AIMED), seed
            )
            lit[a:b, side] = np.any(arriving > 0, axis=1)

    over_ranges(work, patches.fronts, CHUNK)
    return lit


def _lit_by_lamps(visibility, patches, lights):
    """Return (fronts, 2) bool: sides that some light of an abstract source falls on."""
    both = patches.with_backs(np.ones(patches.fronts, bool))
    elements = make_elements(both, np.arange(len(both)), 0)
    arriving = lamps_on(visibility, lights.lamps, elements, lights.unit_m)
    return arriving.any(axis=1).reshape(2, -1).T


def _small_ones(views, patches, lit):
    """Return dark sides that see a lit one: too small for any ray to have met them."""
    dark = np.flatnonzero(~lit & (patches.behind < 0))
    sides, _ = views(dark)
    return dark[np.any((sides != MISS) & lit.reshape(-1)[sides], axis=1)]


def sides_that_see_out(visibility, table, patches, seed: int = 0) -> np.ndarray:
    """Return (fronts, 2) bool: which sides see the outside of the scene."""
    if not visibility.can_block and patches.fronts <= MOST_FREE:
        return _see_out_freely(*_both_sides(visibility, patches))
    every = np.arange(2 * patches.fronts)
    sides, _ = _look(visibility, table, patches, every, seed)
    return np.any(sides == MISS, axis=1).reshape(-1, 2)


def _look(visibility, table, patches, which, seed=0):
    """Return sides met from the middles of the given sides (k, rays), and where (k, rays, 3).

    From every side 256 rays, of scenes of many sides fewer.
    """
    front, back = which // 2, which % 2
    normals = patches.normal[front] * np.where(back, -1.0, 1.0)[:, None]
    rays = int(np.clip(IN_ALL // max(1, 2 * patches.fronts), FEWEST, MOST))
    found, places = np.empty((len(which), rays), np.int64), np.empty((len(which), rays, 3))

    def work(a, b):
        points = patches.centroid[front[a:b]]
        found[a:b], places[a:b] = look_out(
            visibility, table, points, normals[a:b], which[a:b], range(rays), seed
        )

    over_ranges(work, len(which), CHUNK)
    return found, places


def _well_inside(visibility, patches, sides, places):
    """Return (m,) bool: places (m, 3) in ray coordinates that lie off the edges of their patch.

    Of millions of rays that pass an edge, one may slip through it and meet what is sealed off.
    """
    x = visibility.centre + places / visibility.scale
    return _margins(patches.vertices, patches.normal, sides // 2, x) > EDGE / visibility.scale


@njit(cache=True, nogil=True)
def _margins(vertices, normals, patch, x):
    found = np.empty(len(patch))
    for k in range(len(patch)):
        found[k] = margin_in(vertices[patch[k]], normals[patch[k]], x[k])
    return found
