"""Refinement until the estimated error meets the accuracy, and the checks that estimate it."""

import time
from collections.abc import Callable
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
from radiosity.solve.level import Kept, Level, solve_level
from radiosity.solve.plan import (
    MOST_CLUSTERS,
    MOST_LINEAR,
    Plan,
    check_memory,
    fits,
    most_that_fit,
)
from radiosity.solve.reach import find_reach
from radiosity.solve.refinement import blame, graded, refine
from radiosity.transport.arrival import make_senders
from radiosity.transport.threads import Progress, silent

ROUNDS = 6  # of refinement
FEW = 150  # patches, of which linear elements are as coarse as constant ones: these are halved
AIM, STEPS, SLOWEST = 0.7, (0.25, 0.8), 1.15  # of the accuracy; of the error in a round; of a size
CUT = 1.3  # patches to cells: some are cut, some have backs that are lit
STEEP = 1.8  # power of the number of cells that the time of a round grows by
SURE, MORE_RAYS = 0.8, 4  # share of a time that is planned with; rays in a round to those before
MOST_CHAINED = 1 << 12  # rays from a node that are followed along chains
MOST_LOOKS = 1 << 16  # rays that look around from a point


def refined(
    scene: Scene, plan: Plan, memory: float | None, watch: Callable[[Level], None] | None = None,
    progress: Progress = silent, goal: Goal | None = None,
) -> tuple[Level, Check, Estimate]:  # fmt: skip
    """Solve on finer and finer meshes until the estimate meets the plan's accuracy.

    Of a ``goal`` only the errors at its points count. Ends early where the next mesh would not fit
    into ``memory`` bytes: the estimate then says what was reached.
    """
    rounds = Rounds(scene, plan, memory, watch, progress, goal)
    while rounds.advance():
        pass
    return rounds.level, rounds.check, rounds.estimate


class Rounds:
    """Rounds of refinement, one at a time.

    Each round solves a mesh and one of cells twice as large, whose difference tells the error and
    the cells that cause it: these are divided.

    Attributes
    ----------
    level, check, estimate : Level, Check, Estimate
        Of the last round.
    coarse : Division
        The mesh of large cells, of the next round where there is to be one.
    left : int
        Rounds that there may be still.
    """

    def __init__(
        self, scene: Scene, plan: Plan, memory: float | None = None,
        watch: Callable[[Level], None] | None = None, progress: Progress = silent,
        goal: Goal | None = None,
    ):  # fmt: skip
        """Choose the first mesh; see `refined`."""
        self.level = self.check = self.estimate = None
        self.coarse, self.left = first_mesh(scene, plan, memory), ROUNDS
        self._scene, self._plan, self._memory, self._goal = scene, plan, memory, goal
        self._recipe = plan.recipe
        self._watch, self._progress, self._clock = watch, progress, Clock(plan.seconds)
        self._most = min(MOST_LINEAR, most_that_fit(1, memory) / CUT) / 4
        like = None
        if goal is not None:
            self.coarse, like = graded(scene, self.coarse, plan.recipe, goal, self._most)
        self._reach = self._mesh(self.coarse.divided(2), like)

    def advance(self) -> bool:
        """Solve a round; return whether another one is needed and fits."""
        recipe, accuracy, memory = self._recipe, self._plan.accuracy, self._memory
        self.level = self.check = None  # their matrices go before the next ones come
        self.level = solve_level(
            self._scene, self._reach, recipe, watch=self._watch, memory=memory,
            progress=self._progress,
        )  # fmt: skip
        check = solve_level(self._scene, _like(self.level, self.coarse), recipe, memory=memory)
        self.check, self.left = Check(check, HALVED), self.left - 1
        self.estimate = compare(self.level, self.check, self._goal)
        shares = None
        if self._goal is not None:
            shares = blame(self.level, check, *self.estimate.judged)
            self.estimate = raised(self.estimate, self.check, shares)
        if self.estimate.reached <= accuracy or not self.left:
            return False
        if self._by_rays():
            return True
        if shares is None:
            shares = blame(self.level, check, *self.estimate.judged)
        room = min(self._most, self.coarse.count * self._clock.room() ** (1.0 / STEEP))
        wanted = float(np.clip(AIM * accuracy / self.estimate.reached, *STEPS))
        finer = refine(self.coarse, shares, wanted, room)
        if finer is None:
            return False
        self.coarse, self._reach = finer, self._mesh(finer.divided(2), self._reach)
        return fits(len(self._reach.patches), 1, memory)  # there may be more cuts and backs

    def _by_rays(self) -> bool:
        """Whether more rays along chains, rather than more patches, are what the error asks for."""
        estimate, recipe = self.estimate, self._recipe
        least = max(estimate.mesh, AIM * self._plan.accuracy)
        if not self._scene.sends_on or estimate.kernel <= least:
            return False
        if recipe.chained >= MOST_CHAINED or self._clock.room() < MORE_RAYS:
            return False
        self._recipe = replace(recipe, chained=MORE_RAYS * recipe.chained)
        return True

    def _mesh(self, division, like):
        recipe, progress = self._plan.recipe, self._progress
        return find_reach(self._scene, division, recipe.seed, recipe.force, like, progress)


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
    scene: Scene, plan: Plan, memory: float | None,
    watch: Callable[[Clustered], None] | None = None, progress: Progress = silent,
    goal: Goal | None = None,
) -> tuple[Clustered, Check, Estimate]:  # fmt: skip
    """Solve with more clusters, or gather with more rays, until the estimate meets the accuracy.

    Each round is compared with itself on a quarter as many clusters.
    """
    clusters, recipe, clock = plan.clusters, plan.recipe, Clock(plan.seconds)
    reach = find_reach(scene, plan.division, recipe.seed, recipe.force, progress=progress)
    level = solve_clusters(scene, reach, recipe, clusters, progress, watch)
    for left in range(ROUNDS - 1, -1, -1):
        check = Check(coarser(level, clusters // 4), COARSER)
        estimate = compare(level, check, goal)
        if estimate.reached <= plan.accuracy or not left or clock.room() < MORE_RAYS:
            break
        if estimate.kernel > estimate.mesh:
            recipe = replace(recipe, rays=MORE_RAYS * recipe.rays)
            if recipe.rays > MOST_LOOKS:
                break
            level = replace(level, recipe=recipe)
        else:
            clusters, recipe = 2 * clusters, replace(recipe, counted=MORE_RAYS * recipe.counted)
            if clusters > MOST_CLUSTERS or not fits(clusters, 0, memory):
                break
            level = solve_clusters(scene, reach, recipe, clusters, progress, watch)
    return level, check, estimate


def refined_constant(
    scene: Scene, plan: Plan, memory: float | None, watch: Callable[[Level], None] | None = None,
    progress: Progress = silent, goal: Goal | None = None,
) -> tuple[Level, Check, Estimate]:  # fmt: skip
    """Solve with constant elements on finer and finer meshes, everywhere alike; see `refined`."""
    recipe, division, reach = plan.recipe, plan.division, None
    area = scene.faces.areas().sum()
    for left in range(ROUNDS - 1, -1, -1):
        reach = find_reach(scene, division, recipe.seed, recipe.force, reach, progress)
        level = solve_level(scene, reach, recipe, watch=watch, memory=memory, progress=progress)
        check = check_of(level, plan, memory)
        estimate = compare(level, check, goal)
        if estimate.reached <= plan.accuracy or not left:
            break
        wanted = division.count * estimate.reached / (AIM * plan.accuracy)  # of order 2 in the size
        size = np.sqrt(area / wanted)
        size *= np.sqrt(divisions(scene.faces, size).count / wanted)  # triangles have more cells
        division = divisions(scene.faces, size)
        if not fits(CUT * division.count, 0, memory):
            break
    return level, check, estimate


def check_of(level: Level, plan: Plan, memory: float | None = None) -> Check:
    """Return what tells the error of a level on a mesh that was given.

    Linear elements: the same on cells twice as large where all faces divide so, else their own
    constant parts. Constant elements: linear ones on the same patches, on halved ones where they
    are few; where they are too many for ``memory``, slopes from neighbours.
    """
    scene, reach, few = level.scene, level.reach, len(level.rows) <= FEW
    grid = reach.patches.grid.division
    if plan.recipe.order == 0:
        most = min(MOST_LINEAR, most_that_fit(1, memory))
        if len(reach.live) * (4 if few else 1) > most:
            return Check(smoothed(level), REFINED)
        linear = replace(plan.recipe, order=1, solver="gauss-seidel")
        if few:
            reach = _like(level, grid.divided(2))
        return Check(solve_level(scene, reach, linear, memory=memory), REFINED)
    coarse = grid.halved()
    if coarse is not None:
        return Check(solve_level(scene, _like(level, coarse), plan.recipe, memory=memory), HALVED)
    return Check(solve_level(scene, reach, plan.recipe, constant=True, memory=memory), HALVED)


def _like(level, division):
    """Return a level's scene on another mesh."""
    recipe = level.recipe
    return find_reach(level.scene, division, recipe.seed, recipe.force, level.reach)


def smoothed(level: Level) -> Level:
    """Return a level of constant elements with slopes taken from neighbouring patches."""
    patches, live = level.reach.patches, level.reach.live
    around = find_neighbours(patches, live, level.scene.faces.material[patches.face])
    elements = make_elements(patches, level.rows, 1)
    slope = gradients(patches, around, level.on_patches(level.coefficients))[level.rows]
    slopes = elements.slopes(slope).reshape(-1, slope.shape[1])
    sight = level.senders.sight
    senders = make_senders(elements, sight.geometry, level.senders.visibility, sight.tolerance)
    both, kept = np.concatenate([level.coefficients, slopes]), Kept(level.straight, level.escaping)
    return replace(level, senders=senders, coefficients=both, kept=kept)
