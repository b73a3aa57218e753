"""What light can reach, and where a scene is open: measured with rays before any factor."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from radiosity.mesh.patches import Patches
from radiosity.transport.hemisphere import MISS, look_out
from radiosity.transport.irradiance import AreaLights, direct_irradiance
from radiosity.transport.lookup import Table
from radiosity.transport.threads import over_ranges
from radiosity.transport.visibility import Visibility

FEWEST, MOST, IN_ALL = 32, 256, 1 << 22  # rays from a side, and about from all together
CHUNK = 256
AIMED = 8  # rays to each light


@dataclass(frozen=True)
class Survey:
    """Which sides of the patches light reaches, and what they see of the outside.

    Attributes
    ----------
    lit : (fronts, 2) bool
        Front and back: reached by light, directly or after reflections.
    open_share : (fronts, 2) float64
        Fraction of a lit side's hemisphere that leaves the scene (its factor to the
        environment, by 32 to 256 rays); NaN where not lit.
    """

    lit: np.ndarray
    open_share: np.ndarray

    @property
    def closed(self) -> bool:
        """Whether no lit side sees the outside."""
        return not np.any(self.open_share > 0)


def survey(
    visibility: Visibility,
    table: Table,
    patches: Patches,
    sources: np.ndarray,
    lights: AreaLights | None = None,
    seed: int = 0,
) -> Survey:
    """Follow light from the sides that send it out to every side it can reach.

    Parameters
    ----------
    patches : Patches
        Fronts only.
    sources : (fronts, 2) bool
        Sides that emit; where light enters from outside, every side that sees the outside.
    lights : AreaLights, optional
        Aimed at one by one, since they may be too small or too far for any ray to meet.
    """
    lit = sources.copy()
    lit[patches.behind >= 0] = False
    open_share = np.full(lit.shape, np.nan)
    views = partial(_look, visibility, table, patches, seed=seed)
    if lights is not None:
        lit |= _lit_directly(visibility, patches, lights, seed) & (patches.behind < 0)
    new = np.flatnonzero(lit)
    while len(new):
        _spread(views, new, lit.reshape(-1), open_share.reshape(-1))
        new = _small_ones(views, patches, lit)
    return Survey(lit, open_share)


def _spread(views, new, lit, open_share):
    """Follow light from new sides to all that it meets; mark them in ``lit`` (2 * fronts,)."""
    lit[new] = True
    while len(new):
        sides = views(new)
        open_share[new] = np.mean(sides == MISS, axis=1)
        met = np.unique(sides)
        met = met[met != MISS]
        new = met[~lit[met]]
        lit[new] = True


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


def _small_ones(views, patches, lit):
    """Return dark sides that see a lit one: too small for any ray to have met them."""
    dark = np.flatnonzero(~lit & (patches.behind < 0))
    sides = views(dark)
    return dark[np.any((sides != MISS) & lit.reshape(-1)[sides], axis=1)]


def sides_that_see_out(visibility, table, patches, seed: int = 0) -> np.ndarray:
    """Return (fronts, 2) bool: which sides see the outside of the scene."""
    every = np.arange(2 * patches.fronts)
    sides = _look(visibility, table, patches, every, seed)
    return np.any(sides == MISS, axis=1).reshape(-1, 2)


def _look(visibility, table, patches, which, seed=0):
    """Return (k, rays) sides met from the middles of the given sides.

    From every side 256, of scenes of many sides fewer.
    """
    front, back = which // 2, which % 2
    normals = patches.normal[front] * np.where(back, -1.0, 1.0)[:, None]
    rays = int(np.clip(IN_ALL // max(1, 2 * patches.fronts), FEWEST, MOST))
    found = np.empty((len(which), rays), np.int64)

    def work(a, b):
        points = patches.centroid[front[a:b]]
        found[a:b], _ = look_out(
            visibility, table, points, normals[a:b], which[a:b], range(rays), seed
        )

    over_ranges(work, len(which), CHUNK)
    return found
