"""Where light is looked at: patches are divided until it lies on straight lines between points."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radiosity.mesh.patches import Patches
from radiosity.transport.threads import Progress
from radiosity.view.fine.cells import (
    ALL,
    DEPTH,
    FEW,
    Cells,
    numbered,
    patch_of,
    points_of,
    whole_patches,
)

TOLERANCE = 0.02  # by which light may miss a line between two points; a quarter of it is left
DIM = 0.1  # of the mean, what errors in the dark are relative to
EVENLY = 8  # of so many points one is for cells of about the same size, in which nothing can hide
SURE = 2.0  # standard errors that what is found must differ by to be real

POINTS_A_CELL = 4  # about, most of which it shares

Look = Callable[[np.ndarray, np.ndarray, Progress], "Light"]  # of patches (k,), points (k, 3)


@dataclass(frozen=True)
class Light:
    """What is seen at k points, of each of g light groups.

    Attributes
    ----------
    lux : (k, g) float64
        Illuminance.
    noise : (k,) float64
        Of all together, lx.
    reflected : (k, g, 3) float64
        Radiosity in W/m2 without emission, linear sRGB.
    error : (k,) float64
        Estimated, of the illuminance by all together, lx; infinite where it is not known.
    """

    lux: np.ndarray
    noise: np.ndarray
    reflected: np.ndarray
    error: np.ndarray

    def joined(self, other: "Light") -> "Light":
        """Return both, one after the other."""
        mine, more = vars(self).values(), vars(other).values()
        return Light(*(np.concatenate(both) for both in zip(mine, more, strict=True)))

    def some(self, which: np.ndarray) -> "Light":
        """Return that of some points."""
        return Light(*(values[which] for values in vars(self).values()))


class Seen:
    """The points that were looked at, by their numbers, and what was seen there."""

    def __init__(self, patches: Patches, look: Look, chosen: np.ndarray = ALL):
        self.patches, self.look, self.chosen = patches, look, chosen
        self.numbers, self.light = np.empty(0, np.int64), None

    def add(self, cells: Cells, progress: Progress) -> None:
        """Look at the points of cells that were not looked at before."""
        wanted = np.setdiff1d(self._numbers_of(cells), self.numbers)
        if not len(wanted):
            return
        found = self.look(patch_of(wanted), points_of(self.patches, wanted)[1], progress)
        numbers = np.concatenate([self.numbers, wanted])
        order = np.argsort(numbers)
        self.numbers = numbers[order]
        self.light = (found if self.light is None else self.light.joined(found)).some(order)

    def at(self, cells: Cells) -> np.ndarray:
        """Return (n, chosen) where among the numbers the points of cells are."""
        return np.searchsorted(self.numbers, self._numbers_of(cells))

    def _numbers_of(self, cells):
        return numbered(cells.patch[:, None], cells.samples()[:, self.chosen])


def refined(
    patches: Patches, which: np.ndarray, look: Look, progress: Progress, most: int
) -> tuple[Cells, Seen]:
    """Divide patches until light is straight, or DEPTH times, or to about ``most`` points.

    Parameters
    ----------
    which : (n,) int
        The patches; each has its corners, the middles of its edges and its centre in any case, but
        not the middles where they are too many for that.
    look : callable
        Returns the `Light` at points (k, 3) of patches (k,).

    Returns
    -------
    cells : Cells
        That cover the patches.
    seen : Seen
        Their points.
    """
    cells, done, many = whole_patches(patches, which), [], len(ALL) * len(which) > most
    seen = Seen(patches, look, FEW if many else ALL)
    seen.add(cells, progress)
    if many:
        return cells, seen
    means, area = _means(cells, seen), cells.areas(patches)
    large = 2.0 * EVENLY * POINTS_A_CELL * area.sum() / max(most, 1)
    for _ in range(DEPTH):
        area = cells.areas(patches)
        miss = np.where(area > large, np.inf, _misses(cells, seen, means))
        bent = np.flatnonzero(miss > TOLERANCE)
        worst = np.argsort(-(miss * area)[bent], kind="stable")
        room = max(0, most - len(seen.numbers)) // (3 * POINTS_A_CELL)  # four in the place of one
        bent = bent[worst[:room]]
        if not len(bent):
            break
        left = np.ones(len(cells), bool)
        left[bent] = False
        done.append(cells.some(left))
        cells = cells.some(np.sort(bent)).quartered()
        seen.add(cells, progress)
    done.append(cells)
    parts = zip(*((c.patch, c.corners) for c in done), strict=True)
    return Cells(*(np.concatenate(part) for part in parts)), seen


def _means(cells, seen):
    """Return (g + 1,) the mean illuminance of each light group and of all, lx."""
    area = cells.areas(seen.patches)
    lux = _with_all(seen.light.lux[seen.at(cells)[:, 8]])
    return np.average(lux, axis=0, weights=area)


def _with_all(lux):
    return np.concatenate([lux, lux.sum(axis=-1, keepdims=True)], axis=-1)


def _misses(cells, seen, means):
    """Return (n,) by how much light misses straight lines between the corners, relative."""
    at = seen.at(cells)
    lux, noise = _with_all(seen.light.lux[at]), seen.light.noise[at].max(axis=1)
    corner = lux[:, 0:8:2]
    middle = 0.5 * (corner + np.roll(corner, -1, axis=1))
    three = np.where(cells.is_triangle[:, None], corner[:, :3].mean(axis=1), corner.mean(axis=1))
    line = np.concatenate([middle, three[:, None]], axis=1)
    there = lux[:, [1, 3, 5, 7, 8]]
    off = np.maximum(np.abs(there - line) - SURE * noise[:, None, None], 0.0)
    unit = np.maximum(np.minimum(there, line), np.maximum(DIM * means, 1e-300))
    return (off / unit).max(axis=(1, 2))
