"""Grids of points that a lighting is judged by: how far apart, and what their values come to.

Spacing and margins are those of EN 12464-1, as lighting guides give them (Fagerhult, "Number of
calculation points"): cells of at most p = 0.2 5^(log10 d) metres, and no more than 10 m, where d is
the longer side of the area, or the shorter one where the longer is at least twice as long; points
in the cells' middles; a band of 0.5 m along the walls left out, in small rooms 15 % of the shorter
side.
"""

from dataclasses import dataclass

import numpy as np

from radiosity.scene.model import Scene

BAND, SHARE = 0.5, 0.15  # metres, and share of the shorter side, that margins come to at most
MOST = 10**6  # points of a grid


@dataclass(frozen=True)
class PointGrid:
    """Points that a plane or surface is judged by.

    Attributes
    ----------
    points, normals : (k, 3) float64
        Scene units, unit vectors.
    spacing : tuple of two floats
        Sides of a cell in scene units, of a surface's largest plane.
    margin : float
        Scene units.
    left_out : int
        Points of the grid that do not count.
    """

    points: np.ndarray
    normals: np.ndarray
    spacing: tuple[float, float]
    margin: float
    left_out: int


@dataclass(frozen=True)
class Evenness:
    """Illuminance over a grid in lx, with what 95 % of the errors stay below.

    ``u0`` = minimum/mean and ``ud`` = minimum/maximum are nan where all is dark. The error of the
    mean is the mean of the points' errors, as those may all have one sign.
    """

    mean: float
    minimum: float
    maximum: float
    u0: float
    ud: float
    mean_error: float
    minimum_error: float
    maximum_error: float
    u0_error: float
    ud_error: float


def evenness(lux: np.ndarray, error: np.ndarray, weight: np.ndarray | None = None) -> Evenness:
    """Return what illuminances (k,) and their errors (k,) in lx come to.

    Means are weighted where values stand for areas (k,) that differ.

    Examples
    --------
    >>> found = evenness(np.array([100.0, 300.0]), np.array([1.0, 3.0]))
    >>> found.mean, found.u0, round(found.u0_error, 3)
    (200.0, 0.5, 0.01)
    """
    least, most = int(np.argmin(lux)), int(np.argmax(lux))
    mean, off = (float(np.average(x, weights=weight)) for x in (lux, error))
    low, high = float(lux[least]), float(lux[most])
    off_low, off_high = float(error[least]), float(error[most])
    u0, u0_error = _ratio(low, mean, off_low, off)
    ud, ud_error = _ratio(low, high, off_low, off_high)
    return Evenness(mean, low, high, u0, ud, off, off_low, off_high, u0_error, ud_error)


def _ratio(low, high, off_low, off_high):
    """Return a ratio and by how much errors of both numbers can change it, to first order."""
    if high <= 0.0:
        return float("nan"), float("nan")
    return low / high, (off_low + low / high * off_high) / high


def standard_spacing(sides: np.ndarray) -> float:
    """Return p in metres of an area whose sides (2,) are in metres.

    Examples
    --------
    >>> [round(standard_spacing(np.array(s)), 2) for s in ([10.0, 8.0], [10.0, 5.0])]
    [1.0, 0.62]
    """
    short, long = np.sort(sides)
    d = short if long >= 2.0 * short else long
    return float(min(10.0, 0.2 * 5.0 ** np.log10(d)))


def cells(sides: np.ndarray, spacing: float | None, margin: float, scene: Scene) -> np.ndarray:
    """Return how many cells (2,) an area has within its margin; refuse what cannot be."""
    if not (0.0 <= margin < np.inf):
        raise ValueError(f"margin = {margin:g} must be at least 0 {scene.unit}")
    if spacing is not None and not (0.0 < spacing < np.inf):
        raise ValueError(f"spacing = {spacing:g} must be above 0 {scene.unit} and finite")
    inner = sides - 2.0 * margin
    if not np.all(inner > 0.0):
        raise ValueError(
            f"margin = {margin:g} must be less than half the shorter side of the area, "
            f"{sides.min():g} {scene.unit}"
        )
    if spacing is not None:
        count = np.ceil(inner / spacing * (1.0 - 1e-9))
    else:
        p = standard_spacing(inner * scene.unit_m) / scene.unit_m
        long = int(np.argmax(inner))
        d = 1 - long if inner[long] >= 2.0 * inner[1 - long] else long
        count = np.empty(2)
        count[d] = np.ceil(inner[d] / p * (1.0 - 1e-9))
        count[1 - d] = max(1.0, np.round(inner[1 - d] * count[d] / inner[d]))
    check_count(count.prod())
    return count.astype(int)


def check_count(count: float) -> None:
    """Raise ValueError where a grid would have too many points."""
    if count > MOST:
        raise ValueError(f"a grid of {count:.3g} points is above {MOST}: use a larger spacing")


def middles(sides: np.ndarray, shape: np.ndarray, margin: float) -> np.ndarray:
    """Return (k, 2) the middles of an area's cells, from its corner."""
    steps = [margin + (s - 2 * margin) * (np.arange(n) + 0.5) / n
             for s, n in zip(sides, shape, strict=True)]  # fmt: skip
    return np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2)
