"""How wrong a solution is: two levels of known orders, compared at points of all surfaces.

A level whose error falls by the factor g from the one to the other differs from it by g - 1 times
its own error. Halving the cells of linear elements makes g about 4 in the norm of the accuracy,
which edges and shadows decide; linear elements on the same cells are so much better than constant
ones that the difference is most of the error.
"""

from dataclasses import dataclass, replace

import numpy as np

from radiosity.light.bands import Bands
from radiosity.solve.level import Level
from radiosity.transport.arrival import Arrival
from radiosity.transport.sampling import hashed, places

# Of the difference: to halved cells, to linear elements, to a quarter of the clusters and half of
# the rays, whose noise is as large as that of the difference.
HALVED, REFINED, COARSER = 0.42, 1.3, 0.5
QUANTILE, DIM = 0.95, 0.1
SCATTER = 1.25  # of the rms difference, what bars have at least: two levels may agree by chance
LEAST, MOST, GOALS = 256, 2000, 500  # points at which levels are compared
PLACE = 1 << 42  # tells the pattern of these points from others


@dataclass(frozen=True)
class Check:
    """Another level that tells the error of a solution, and how much of the difference it is.

    Attributes
    ----------
    level : Level
    share : float
        Error of the solution as a share of its difference to ``level``.
    """

    level: Level
    share: float


@dataclass(frozen=True)
class Estimate:
    """Estimated errors of the irradiance that a level gathers.

    Attributes
    ----------
    reached : float
        95th percentile over the surfaces of the relative error, in the norm of the accuracy.
    scatter : float
        Relative error (norm of the accuracy) that every bar has at least.
    scale : float
        Mean irradiance in W/m2 (luminance-weighted); errors are relative to a tenth of it at least.
    mesh, kernel : float
        The part of it that the mesh, and the part that far factors and rays are estimated to cause.
    patches : (k,) int
        Live patches at points of which the levels were compared.
    found : (k, bands) float64
        Their error bars, W/m2.
    judged : tuple
        The points (m, 3), their normals, and what an error in W/m2 at each is worth (m,).
    bands : Bands
    """

    reached: float
    scatter: float
    scale: float
    mesh: float
    kernel: float
    patches: np.ndarray
    found: np.ndarray
    judged: tuple
    bands: Bands

    def on_patches(self, e: np.ndarray) -> np.ndarray:
        """Return (m, bands) error bars of irradiances e (m, bands) on the live patches.

        Those that were not compared get what the others have in 95 % of their area.
        """
        bars = (self.mesh + self.kernel) * _measure(e, self.scale, self.bands)
        bars[self.patches] = self.found
        return bars

    def bars(self, e: np.ndarray, difference: np.ndarray) -> np.ndarray:
        """Return (k, bands) error bars of irradiances e that differ so much from the check's."""
        return _bars(e, difference, self.scatter, self.scale, self.bands)


def _bars(e, difference, scatter, scale, bands):
    return np.abs(difference) + scatter * _measure(e, scale, bands)


def _measure(e, scale, bands):
    """Return (k, bands) what relative errors of irradiances e refer to."""
    y = np.maximum(bands.luminance(e), scale)
    return np.maximum(e, DIM * y[:, None])


@dataclass(frozen=True)
class Goal:
    """The points that an answer is asked for, (k, 3), and their unit normals; of many, some."""

    points: np.ndarray
    normals: np.ndarray

    @staticmethod
    def of(points: np.ndarray, normals: np.ndarray, seed: int) -> "Goal":
        """Return all of the points, or GOALS of them, chosen by chance."""
        if len(points) <= GOALS:
            return Goal(points, normals)
        some = np.random.default_rng(seed).choice(len(points), GOALS, replace=False)
        return Goal(points[some], normals[some])


def compare(level: Level, check: Check, goal: Goal | None = None) -> Estimate:
    """Return the estimated error of a level (E15), from points on its patches.

    Of a ``goal`` only the errors at its points count for what was reached.
    """
    patches, rows = level.reach.patches, level.rows
    chosen, area = _chosen(patches.area[rows])
    shifts = np.array([hashed(int(row), PLACE, 0) for row in rows[chosen]], np.uint64)
    points = places(patches.vertices[rows[chosen]], 0, shifts)
    normals, many = patches.normal[rows[chosen]], len(chosen)
    if goal is not None:
        points = np.concatenate([points, goal.points])
        normals = np.concatenate([normals, goal.normals])
    here, there = level.gathered(points, normals), check.level.gathered(points, normals)
    bands = level.scene.bands
    y = bands.luminance(here.total)
    scale = float(np.average(y[:many], weights=area)) if many else 0.0
    unit = yardstick(y, scale)
    error = check.share * (here.total - there.total)
    parts = [np.abs(bands.luminance(x)) / unit for x in (error, here.error)]
    relative = np.hypot(*parts)
    mesh, kernel, reached = (_quantile(x[:many], area) for x in (*parts, relative))
    rms = np.sqrt(np.sum(area * np.minimum(relative[:many], 1.0) ** 2) / max(area.sum(), 1e-300))
    scatter = SCATTER * min(float(rms), reached)
    bars = _bars(here.total, error, scatter, scale, bands) + noise_of(here, there, check.share)
    patch, which = np.unique(chosen, return_inverse=True)
    total = np.zeros((len(patch), bars.shape[1]))
    np.add.at(total, which, bars[:many] ** 2 / np.bincount(which)[which, None])
    count = slice(0, many)
    if goal is not None:
        count, area = slice(many, None), np.ones(len(goal.points))
        reached = _quantile(relative[count], area)
    judged = points[count], normals[count], np.sqrt(area / area.sum()) / unit[count]
    return Estimate(reached, scatter, scale, mesh, kernel, patch, np.sqrt(total), judged, bands)


def unknown(level: Level) -> tuple[Check, Estimate]:
    """Return the estimate of a level that is not solved yet: errors are infinite."""
    none, bands = np.zeros((0, 3)), level.scene.bands
    nowhere = none, none, np.zeros(0)
    return Check(level, 0.0), Estimate(
        np.inf, np.inf, 1.0, np.inf, 0.0, np.zeros(0, int), np.zeros((0, bands.count)), nowhere,
        bands,
    )  # fmt: skip


def yardstick(y: np.ndarray, scale: float) -> np.ndarray:
    """Return what errors of irradiances y (luminance-weighted) refer to: the norm of the accuracy.

    Each itself, or DIM of their mean ``scale``; infinity where all is dark.
    """
    return np.maximum(np.maximum(y, DIM * scale), 1e-300 if scale else np.inf)


def raised(estimate: Estimate, check: Check, shares: np.ndarray) -> Estimate:
    """Return an estimate, raised to what the cells' shares (cells,) of it are in quadrature.

    At the few points of a goal they may cancel: two levels agree by chance.
    """
    least = check.share * float(np.sqrt(np.sum(shares**2)))
    return replace(estimate, reached=max(estimate.reached, least))


def noise_of(here: Arrival, there: Arrival, share: float) -> np.ndarray:
    """Return two standard errors of what rays told of a solution, and of its check's ``share``."""
    return 2.0 * np.hypot(here.error, share * there.error)


def _chosen(area):
    """Return indices of patches, each once or more often, and the area that each stands for.

    All of them, LEAST in all at least, or, where they are many, MOST evenly over the area.
    """
    if len(area) <= MOST:
        times = -(-LEAST // max(1, len(area)))
        return np.tile(np.arange(len(area)), times), np.tile(area, times)
    found, times = np.unique(evenly(area, MOST), return_counts=True)
    return found, times.astype(float)


def evenly(area: np.ndarray, count: int) -> np.ndarray:
    """Return (count,) indices of areas, each as often as its share of the whole asks."""
    share = np.cumsum(area if area.any() else np.ones_like(area))
    share /= share[-1]
    return np.searchsorted(share, (np.arange(count) + 0.5) / count)


def _quantile(values, weight) -> float:
    """Return the value that QUANTILE of the weight lies below, 0 of none."""
    if len(values) == 0:
        return 0.0
    order = np.argsort(values)
    share = np.cumsum(weight[order]) / weight.sum()
    return float(values[order[np.searchsorted(share, QUANTILE)]])
