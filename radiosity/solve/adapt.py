"""Refinement until the estimated error meets the accuracy, and the checks that estimate it."""

import time
from dataclasses import replace

import numpy as np

from radiosity.mesh.division import Division, divisions
from radiosity.mesh.elements import make_elements
from radiosity.mesh.interpolation import find_neighbours, gradients
from radiosity.scene.model import Scene
from radiosity.solve.clustered import Clustered, coarser, solve_clusters
from radiosity.solve.estimate import (
    COARSER,
    HALVED,
    REFINED,
    Check,
    Estimate,
    Goal,
    compare,
    raised,
)
from radiosity.solve.level import Level, solve_level
from radiosity.solve.methods import Watch
from radiosity.solve.plan import (
    MOST_CLUSTERS,
    MOST_LINEAR,
    Plan,
    Refused,
    check_memory,
    fits,
    most_that_fit,
)
from radiosity.solve.reach import find_reach
from radiosity.solve.refinement import blame, refine
from radiosity.transport.arrival import make_senders
from radiosity.transport.threads import Progress, silent

ROUNDS = 6  # of refinement
FEW = 150  # patches, of which linear elements are as coarse as constant ones: these are halved
AIM, STEPS, SLOWEST = 0.65, (0.2, 0.5), 1.15  # of the accuracy; of the error in a round; of a size
CUT = 1.3  # patches to cells: some are cut, some have backs that are lit
STEEP = 1.8  # power of the number of cells that the time of a round grows by
SURE, MORE_RAYS = 0.8, 4  # share of a time that is planned with; rays in a round to those before


def refined(
    scene: Scene, plan: Plan, memory: float | None, watch: Watch | None = None,
    progress: Progress = silent, goal: Goal | None = None,
) -> tuple[Level, Check, Estimate]:  # fmt: skip
    """Solve on finer and finer meshes until the estimate meets the plan's accuracy.

    Each round solves the mesh and one of cells twice as large, whose difference tells the error and
    the cells that cause it: these are divided. Of a ``goal`` only the errors at its points count.
    Ends early where the next mesh would not fit into ``memory`` bytes: the estimate then says what
    was reached.
    """
    coarse, clock = first_mesh(scene, plan, memory), Clock(plan.seconds)
    level, like, most = None, None, min(MOST_LINEAR, most_that_fit(1, memory) / CUT) / 4
    recipe = plan.recipe
    for left in reversed(range(ROUNDS)):
        try:
            level = solve_level(
                scene, coarse.divided(2), recipe, like=like, watch=watch, memory=memory,
                progress=progress,
            )  # fmt: skip
        except Refused:  # more cuts and backs than were expected
            if level is None:
                raise
            break
        like = level.reach
        check = Check(solve_level(scene, coarse, recipe, like=like, memory=memory), HALVED)
        estimate = compare(level, check, goal)
        if goal is None and (estimate.reached <= plan.accuracy or left == 0):
            break
        shares = blame(level, check.level, *estimate.judged)
        if goal is not None:
            estimate = raised(estimate, check, shares)
            if estimate.reached <= plan.accuracy:
                break
        room = min(most, coarse.count * clock.room() ** (1.0 / STEEP))
        wanted = np.clip(AIM * plan.accuracy / estimate.reached, *STEPS)
        coarse = refine(coarse, shares, float(wanted), room)
        if coarse is None:
            break
    return level, check, estimate


def first_mesh(scene: Scene, plan: Plan, memory: float | None) -> Division:
    """Return the first mesh, of cells twice as large as a plan's, or as large as need be to fit."""
    size = np.sqrt(scene.faces.areas().sum() / plan.division.count)
    while True:
        coarse = divisions(scene.faces, 2.0 * size, np.rint)
        if fits(CUT * 4 * coarse.count, 1, memory):
            return coarse
        if coarse.count <= len(scene.faces):
            check_memory(int(CUT * 4 * coarse.count) + 1, memory, 1)
        size *= SLOWEST


class Clock:
    """Tells whether another, longer round of refinement fits into the time that is left."""

    def __init__(self, seconds: float | None):
        """Start; ``seconds`` is all the time that there is, None for any."""
        self._seconds = seconds
        self._begun = self._before = time.perf_counter()

    def room(self) -> float:
        """Return how many times as long as the round that ends now the next one may take."""
        now = time.perf_counter()
        took, self._before = now - self._before, now
        if self._seconds is None:
            return np.inf
        return max(0.0, SURE * (self._seconds - (now - self._begun))) / took


def refined_clusters(
    scene: Scene, plan: Plan, memory: float | None, progress: Progress = silent,
    goal: Goal | None = None,
) -> tuple[Clustered, Check, Estimate]:  # fmt: skip
    """Solve with more and more clusters and rays until the estimate meets the plan's accuracy.

    Each round is compared with itself on a quarter as many clusters.
    """
    progress("mesh", 0, 1)
    reach = find_reach(scene, plan.division, plan.recipe.seed, plan.recipe.force)
    progress("mesh", 1, 1)
    clusters, recipe, clock = plan.clusters, plan.recipe, Clock(plan.seconds)
    for _ in range(ROUNDS):
        level = solve_clusters(scene, reach, recipe, clusters, progress)
        check = Check(coarser(level, clusters // 4), COARSER)
        estimate = compare(level, check, goal)
        clusters, recipe = 2 * clusters, replace(recipe, counted=MORE_RAYS * recipe.counted)
        if estimate.reached <= plan.accuracy or clusters > MOST_CLUSTERS:
            break
        if not fits(clusters, 0, memory) or clock.room() < MORE_RAYS:
            break
    return level, check, estimate


def check_of(level: Level, plan: Plan, memory: float | None = None) -> Check:
    """Return what tells the error of a level on a mesh that was given.

    Linear elements: the same on cells twice as large where all faces divide so, else their own
    constant parts. Constant elements: linear ones on the same patches, on halved ones where they
    are few; where they are too many for ``memory``, slopes from neighbours.
    """
    scene, grid, few = level.scene, level.reach.patches.grid.division, len(level.rows) <= FEW
    if plan.recipe.order == 0:
        most = min(MOST_LINEAR, most_that_fit(1, memory))
        if len(level.reach.live) * (4 if few else 1) > most:
            return Check(smoothed(level), REFINED)
        linear = replace(plan.recipe, order=1, solver="gauss-seidel")
        if few:
            finer = grid.divided(2)
            check = solve_level(scene, finer, linear, like=level.reach, memory=memory)
            return Check(check, REFINED)
        reach = level.reach
        return Check(solve_level(scene, grid, linear, reach=reach, memory=memory), REFINED)
    coarse = grid.halved()
    if coarse is not None:
        check = solve_level(scene, coarse, plan.recipe, like=level.reach, memory=memory)
        return Check(check, HALVED)
    flat = solve_level(scene, grid, plan.recipe, reach=level.reach, constant=True, memory=memory)
    return Check(flat, HALVED)


def smoothed(level: Level) -> Level:
    """Return a level of constant elements with slopes taken from neighbouring patches."""
    patches, live = level.reach.patches, level.reach.live
    around = find_neighbours(patches, live, level.scene.faces.material[patches.face])
    elements = make_elements(patches, level.rows, 1)
    slope = gradients(patches, around, level.on_patches(level.coefficients))[level.rows]
    slopes = elements.slopes(slope).reshape(-1, slope.shape[1])
    sight = level.senders.sight
    senders = make_senders(elements, sight.geometry, level.senders.visibility, sight.tolerance)
    both = np.concatenate([level.coefficients, slopes])
    return replace(level, senders=senders, coefficients=both)
