"""Scales of false colours that suit a solution, the same for all its views."""

import numpy as np

from radiosity.light.photometry import EFFICACY, illuminance, photometric
from radiosity.solve.estimate import yardstick
from radiosity.solve.solution import Solution
from radiosity.view.falsecolour import DECADES, Scale, round_up
from radiosity.view.shading import auto_exposure

MOST = 0.95  # share of the lit area that a linear scale of illuminance covers
LINES = 8  # isolux lines, about


def luminance_scale(solution: Solution, logarithmic: bool = False) -> Scale:
    """Return a scale in cd/m2: up to what the automatic exposure shows as white, or to all."""
    if not logarithmic:
        return Scale(round_up(EFFICACY / auto_exposure(solution)))
    most = photometric(solution.radiosity / np.pi, solution.scene.bands).max()
    return Scale(round_up(most), DECADES)


def illuminance_scale(solution: Solution, logarithmic: bool = False) -> Scale:
    """Return a scale in lx: linear up to what all but the brightest 5 % of the area has, or to all.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/cornell_box.toml"), 0.1)
    >>> scale = illuminance_scale(solution)
    >>> scale.unit, scale.maximum in round_numbers(scale)
    ('lx', True)
    """
    lux, area = solution.illuminance[solution.live], solution.patches.area[solution.live]
    return spread_scale(lux, area, logarithmic)


def spread_scale(lux: np.ndarray, area: np.ndarray, logarithmic: bool = False) -> Scale:
    """Return such a scale for illuminances (k,) in lx that parts of the area (k,) have."""
    if logarithmic or not len(lux):
        return Scale(round_up(lux.max(initial=0.0)), DECADES if logarithmic else 0.0, "lx")
    order = np.argsort(lux)
    share = np.cumsum(area[order]) / area.sum()
    return Scale(round_up(lux[order][np.searchsorted(share, MOST)]), 0.0, "lx")


def error_shares(solution: Solution) -> np.ndarray:
    """Return (n,) the estimated error of each patch's illuminance in %, as ``--accuracy`` has it.

    Relative to the illuminance, or to a tenth of its mean where it is less.
    """
    lux, live = solution.illuminance, solution.live
    mean = np.average(lux[live], weights=solution.patches.area[live]) if live.any() else 0.0
    return 100.0 * illuminance(solution.error, solution.scene.bands) / yardstick(lux, mean)


def error_scale(shares: np.ndarray, logarithmic: bool = False) -> Scale:
    """Return a scale in % for errors (k,), up to the largest."""
    known = shares[np.isfinite(shares)]
    return Scale(round_up(known.max(initial=0.0)), DECADES if logarithmic else 0.0, "%")


def round_numbers(scale: Scale) -> np.ndarray:
    """Return the round values on a scale where lines are drawn, ascending."""
    return scale.ticks(LINES)[1:]
