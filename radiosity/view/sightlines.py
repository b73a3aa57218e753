"""Sight lines: which patches they meet, and what is told of what they show."""

from dataclasses import dataclass

import numpy as np

from radiosity.solve.solution import Solution
from radiosity.transport.hemisphere import MISS, meet
from radiosity.transport.visibility import LIFT

LAYERS = 16  # dark backs that a sight line from outside passes through


@dataclass(frozen=True)
class Seen:
    """What sight lines show, and by what their indirect light is smoothed between pixels.

    Attributes
    ----------
    leaving : (k, bands) float64
        Radiance, W/(m2 sr).
    indirect : (k, bands) float64
        The part of the irradiance there in W/m2 that does not come straight from lights.
    nearness : (k,) float64
        Mean of 1/distance to the surroundings there.
    diffuse : (k, bands) float64
        What of ``indirect`` is in ``leaving``, times pi.
    plane : (k,) int
        See `Shading`.
    points : (k, 3) float64
        Where, in scene units.
    """

    leaving: np.ndarray
    indirect: np.ndarray
    nearness: np.ndarray
    diffuse: np.ndarray
    plane: np.ndarray
    points: np.ndarray


def first_rows(solution: Solution, origins: np.ndarray, directions: np.ndarray):
    """Follow sight lines to the first patch, from outside of the scene through dark backs.

    A room shows its inside to who looks at it from without; from within, what no light reaches is
    black.

    Returns
    -------
    rows : (k,) int
        Patch, -1 where the sight line leaves the scene, -2 where it ends in the dark.
    points : (k, 3) float64
        Where, in scene units.
    """
    around = solution.surroundings
    centre, scale = around.visibility.centre, around.visibility.scale
    start = ((origins - centre) * scale).astype(np.float32)
    ahead = directions.astype(np.float32)
    rows = np.full(len(start), MISS)
    active = np.arange(len(start))
    for _ in range(LAYERS):
        sides, ends = meet(around.visibility, around.table, start[active], ahead[active])
        start[active] = ends
        back = (sides >= 0) & (sides % 2 == 1)
        row = rows_of(solution, sides)
        rows[active] = row
        active = active[back & (row < 0)]
        within = ~around.visibility.outside((origins[active] - centre) * scale)
        rows[active[within]] = -2
        active = active[~within]
        if not len(active):
            break
        start[active] += 2 * LIFT * ahead[active]
    return rows, centre + start / scale


def rows_of(solution: Solution, sides: np.ndarray) -> np.ndarray:
    """Return (k,) the patch of each side, see `first_rows`; -1 for backs that are not modelled."""
    row = np.where(sides >= 0, solution.surroundings.field.row[sides], MISS)
    dark = (sides >= 0) & (sides % 2 == 0) & (row < 0)
    row[dark] = _dusk(solution, sides[dark] // 2)
    return row


def _dusk(solution, fronts):
    """Return -2 for dark fronts, but themselves where they stand for a curve, which may be lit."""
    curved = solution.scene.faces.is_curved[solution.patches.face[fronts]]
    return np.where(curved, fronts, -2)
