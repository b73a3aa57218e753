"""The form factors between a scene's patches: assembled, or reused where they fit."""

from dataclasses import dataclass

import numpy as np

from radiosity.scene.model import Scene
from radiosity.solve.plan import check_memory, make_plan
from radiosity.solve.reach import Reach, find_reach
from radiosity.transport.closure import BOUND, repaired
from radiosity.transport.factors import form_factors
from radiosity.transport.operator import FormFactors
from radiosity.transport.threads import Progress, silent

UNBALANCED = 0.5  # a defect that no accuracy leaves: the loosest is 0.5 of errors of any sign
FITS = 1e-9  # relative difference of areas that rounding in another order explains
SAME_PLACE = 1e-6  # of the scene's size, what centroids may differ by


@dataclass(frozen=True)
class SceneFactors:
    """What a scene's rows are, and the form factors between them.

    Attributes
    ----------
    factors : FormFactors
        The rows are ``reach.patches``: all fronts, then the backs that light reaches. Rows that
        light does not reach have area 0, so that factors with other lit sides do not fit.
    reach : Reach
    """

    factors: FormFactors
    reach: Reach


def scene_factors(
    scene: Scene,
    accuracy: float = 0.02,
    *,
    mesh: str = "auto",
    repair: bool = True,
    seed: int = 0,
    memory: float | None = None,
    progress: Progress = silent,
) -> SceneFactors:
    """Return the form factors that `radiosity.solve` computes for a scene.

    Parameters
    ----------
    scene, accuracy, mesh, seed, memory, progress
        As for `radiosity.solve.solve.solve`; only what decides which sides are lit matters of the
        scene's materials and lights.
    repair : bool
        Close the rows, as `solve` does.

    Raises
    ------
    ValueError
        Accuracy or mesh out of range.
    Refused
        The matrix would not fit into ``memory``.
    NotClosable
        The rows cannot be closed.

    Examples
    --------
    >>> import radiosity
    >>> scene = radiosity.load("scenes/box6.toml")
    >>> found = scene_factors(scene, 0.1, mesh="1")
    >>> found.factors.shape
    (6, 6)
    >>> solution = radiosity.solve(scene, 0.1, mesh="1", factors=found.factors)
    """
    plan = make_plan(scene, accuracy, mesh, order=0)
    check_memory(plan.division.count, memory)
    reach = find_reach(scene, plan.division, seed)
    check_memory(len(reach.patches), memory)
    raw = raw_factors(reach, plan.recipe.factors, seed, progress)
    f = repaired(raw) if repair else raw
    return SceneFactors(f.replaced(area=np.where(reach.live, f.area, 0.0)), reach)


def raw_factors(
    reach: Reach, accuracy: float, seed: int, progress: Progress, complete: bool = True
) -> FormFactors:
    """Return the factors between live patches and to what they see of the outside, not closed."""
    return form_factors(
        reach.patches, reach.visibility, reach.live, accuracy, seed, progress, complete=complete
    )


def fitted(factors: FormFactors, reach: Reach) -> FormFactors:
    """Return saved factors as those of a scene's patches; rows left open are closed.

    Raises
    ------
    ValueError
        Where the rows are not the scene's: names the first that differs, and the way out.
    NotClosable
        The rows cannot be closed.
    """
    wanted = np.where(reach.live, reach.patches.area, 0.0)
    problem = (
        _misfit(factors.area, wanted, reach) or _moved(factors, reach) or _unbalanced(factors)
    )
    if problem:
        raise ValueError(
            f"the form factors do not fit the scene: {problem}. Make them anew with the options "
            "of the solution: radiosity formfactors SCENE --mesh .. --accuracy .. -o F.npz (those "
            "of a bare mesh fit under --mesh input where light reaches the front of every face "
            "and no back)"
        )
    same = factors.replaced(area=np.where(reach.live, factors.area, reach.patches.area))
    return same if np.abs(same.closure).max(initial=0.0) <= BOUND else repaired(same)


def _unbalanced(factors) -> str | None:
    """Return which row sums to something far from 1, or None."""
    k = int(np.argmax(np.abs(factors.closure))) if len(factors.area) else 0
    if not len(factors.area) or abs(factors.closure[k]) <= UNBALANCED:
        return None
    return (
        f"row {k} and what leaves it sum to {1.0 + factors.closure[k]:.6g}, not to 1 within "
        f"{UNBALANCED:g}"
    )


def _moved(factors, reach) -> str | None:
    """Return which row lies elsewhere, or None; None too where the factors do not say."""
    if factors.centroid is None:
        return None
    here, v = reach.patches.centroid, reach.patches.vertices
    apart = np.linalg.norm(factors.centroid - here, axis=1)
    far = (apart > SAME_PLACE * np.ptp(v, axis=(0, 1)).max()) & (factors.area > 0)
    if not far.any():
        return None
    k = int(np.argmax(far))
    there, now = (", ".join(f"{x:.6g}" for x in c[k]) for c in (factors.centroid, here))
    return f"{_row(k, reach)}lies about ({there}) in them and about ({now}) in the scene"


def _row(k, reach) -> str:
    side = "front" if reach.patches.front[k] else "back"
    return f"row {k}, the {side} of a cell of face {reach.patches.face[k]}, "


def _misfit(area, wanted, reach) -> str | None:
    """Return which row differs first and how, or None."""
    n = min(len(area), len(wanted))
    other = np.flatnonzero(np.abs(area[:n] - wanted[:n]) > FITS * np.maximum(area[:n], wanted[:n]))
    counts = f"{len(area)} rows, the scene has {len(wanted)}"
    if len(other) == 0:
        return None if len(area) == len(wanted) else f"they have {counts}"
    k = int(other[0])
    where = _row(k, reach)
    counts = f" ({counts})" if len(area) != len(wanted) else ""
    if wanted[k] == 0:
        return f"{where}has area {area[k]:.12g} in them, but light does not reach it{counts}"
    if area[k] == 0:
        return f"{where}has no area in them, but light reaches it now{counts}"
    return f"{where}has area {area[k]:.12g} in them and {wanted[k]:.12g} in the scene{counts}"
