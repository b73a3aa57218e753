"""Refinement until the estimated error meets the accuracy, and the checks that estimate it."""

from dataclasses import replace

import numpy as np

from radiosity.mesh.elements import make_elements
from radiosity.mesh.interpolation import find_neighbours, gradients
from radiosity.mesh.patches import divisions
from radiosity.scene.model import Scene
from radiosity.solve.clustered import Clustered, coarser, solve_clusters
from radiosity.solve.estimate import HALVED, REFINED, Check, Estimate, compare
from radiosity.solve.level import Level, solve_level
from radiosity.solve.methods import Watch
from radiosity.solve.plan import MOST_CLUSTERS, MOST_LINEAR, Plan, count_cells, fits
from radiosity.solve.reach import find_reach
from radiosity.transport.arrival import make_senders
from radiosity.transport.threads import Progress, silent

ROUNDS = 6  # of refinement
AIM, FASTEST, SLOWEST = 0.8, 3.0, 1.15  # of the accuracy; factors that cells shrink by in a round


def refined(
    scene: Scene, plan: Plan, memory: float | None, watch: Watch | None = None,
    progress: Progress = silent,
) -> tuple[Level, Check, Estimate]:  # fmt: skip
    """Solve on finer and finer meshes until the estimate meets the plan's accuracy.

    Each round solves the mesh and one of cells twice as large, whose difference tells the error.
    Ends early where the next mesh would not fit into ``memory`` bytes: the estimate then says what
    was reached.
    """
    size = _cell_size(scene, plan.shape)
    for _ in range(ROUNDS):
        coarse = divisions(scene.faces, 2.0 * size, np.rint)
        level = solve_level(scene, 2 * coarse, plan.recipe, watch=watch, progress=progress)
        check = Check(solve_level(scene, coarse, plan.recipe), HALVED)
        estimate = compare(level, check)
        if estimate.reached <= plan.accuracy:
            break
        ratio = np.sqrt(estimate.reached / (AIM * plan.accuracy))
        size /= float(np.clip(ratio, SLOWEST, FASTEST))
        cells = count_cells(2 * divisions(scene.faces, 2.0 * size, np.rint))
        if cells > MOST_LINEAR or not fits(cells, 1, memory):
            break
    return level, check, estimate


def refined_clusters(
    scene: Scene, plan: Plan, memory: float | None, progress: Progress = silent
) -> tuple[Clustered, Check, Estimate]:
    """Solve with more and more clusters and rays until the estimate meets the plan's accuracy.

    Each round is compared with itself on a quarter as many clusters.
    """
    progress("mesh", 0, 1)
    reach = find_reach(scene, plan.shape, plan.recipe.seed)
    progress("mesh", 1, 1)
    clusters, recipe = plan.clusters, plan.recipe
    for _ in range(ROUNDS):
        level = solve_clusters(scene, reach, recipe, clusters, progress)
        check = Check(coarser(level, clusters // 4), HALVED)
        estimate = compare(level, check)
        clusters, recipe = 2 * clusters, replace(recipe, counted=4 * recipe.counted)
        if estimate.reached <= plan.accuracy or clusters > MOST_CLUSTERS:
            break
        if not fits(clusters, 0, memory):
            break
    return level, check, estimate


def _cell_size(scene, shape) -> float:
    """Return the size of cells of which there are as many as ``shape`` has."""
    return float(np.sqrt(scene.faces.areas().sum() / count_cells(shape)))


def check_of(level: Level, plan: Plan) -> Check:
    """Return what tells the error of a level on a mesh that was given.

    Linear elements: the same on cells twice as large where all faces divide so, else their own
    constant parts. Constant elements: linear ones on the same patches, or, where those are too
    many, slopes from neighbours.
    """
    shape = level.reach.patches.grid.shape
    if plan.recipe.order == 0:
        if len(level.rows) > MOST_LINEAR:
            return Check(smoothed(level), REFINED)
        linear = replace(plan.recipe, order=1, solver="gauss-seidel")
        return Check(solve_level(level.scene, shape, linear, reach=level.reach), REFINED)
    if np.all(shape % 2 == 0):
        return Check(solve_level(level.scene, shape // 2, plan.recipe), HALVED)
    flat = solve_level(level.scene, shape, plan.recipe, reach=level.reach, constant=True)
    return Check(flat, HALVED)


def smoothed(level: Level) -> Level:
    """Return a level of constant elements with slopes taken from neighbouring patches."""
    patches, live = level.reach.patches, level.reach.live
    around = find_neighbours(patches, live, level.scene.faces.material[patches.face])
    elements = make_elements(patches, level.rows, 1)
    slope = gradients(patches, around, level.on_patches(level.coefficients))[level.rows]
    axes = elements.axes / np.sum(elements.axes**2, axis=2, keepdims=True)
    slopes = np.einsum("nmc,nac->anm", slope, axes).reshape(-1, slope.shape[1])
    sight = level.senders.sight
    senders = make_senders(elements, sight.geometry, level.senders.visibility, sight.tolerance)
    both = np.concatenate([level.coefficients, slopes])
    return replace(level, senders=senders, coefficients=both)
