"""The trade of speed for accuracy, measured: time, memory and true error of many ways to solve."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from radiosity.scene.model import Scene
from radiosity.solve.adapt import refined_clusters
from radiosity.solve.estimate import evenly, yardstick
from radiosity.solve.level import solve_level
from radiosity.solve.methods import SOLVERS
from radiosity.solve.plan import plan_of_clusters
from radiosity.solve.solution import Solution
from radiosity.solve.solve import solve
from radiosity.transport.sampling import places

ASKED = (0.1, 0.05, 0.03, 0.02, 0.01, 0.005, 0.003, 0.002, 0.001)
FINER = 4.0  # how many times as accurate as the best answer the reference is asked to be
FINEST = 5e-4  # and the best that is asked of it
POINTS = 1000
COMPARED = 0.02  # accuracy at which solvers and options are compared, where it is asked for
LEAST_CONSTANT = 0.02  # accuracy beyond which constant elements take too long to wait for


@dataclass(frozen=True)
class Trial:
    """One way to solve a scene, and what came of it.

    Attributes
    ----------
    way : str
        Series that it belongs to: "linear", "constant", "clusters", or the option that is tried.
    accuracy : float
        Asked.
    patches : int
        Live ones, or clusters.
    seconds : float
        Warm, of solving and of what is said of the error.
    memory : int
        Bytes of the form factors.
    estimated, error : float
        95th percentile over the surfaces, as told by the program and against the reference.
    """

    way: str
    accuracy: float
    patches: int
    seconds: float
    memory: int
    estimated: float
    error: float


@dataclass(frozen=True)
class SolverTrial:
    """A solver on a given mesh: warm ``seconds``, and its error bound after each iteration."""

    solver: str
    seconds: float
    history: list[float]


@dataclass(frozen=True)
class Reference:
    """A far finer ``solution``: its irradiance (k, bands) at points of all surfaces, its error."""

    points: np.ndarray
    normals: np.ndarray
    irradiance: np.ndarray
    scale: float
    estimated: float
    solution: Solution

    def error_of(self, solution: Solution) -> float:
        """Return the 95th percentile of a solution's errors, in the norm of the accuracy."""
        luminance = solution.scene.bands.luminance
        y = luminance(self.irradiance)
        found = luminance(solution.irradiance(self.points, self.normals)[0])
        return float(np.percentile(np.abs(found - y) / yardstick(y, self.scale), 95))


def make_reference(scene: Scene, accuracy: float) -> Reference:
    """Return the reference for answers of an accuracy and worse, finer than what these reach."""
    best = min(accuracy, solve(scene, accuracy).estimate.reached)
    solution = solve(scene, max(best / FINER, FINEST))
    points, normals = _points_on(solution)
    irradiance, _ = solution.irradiance(points, normals)
    scale, reached = solution.estimate.scale, solution.estimate.reached
    return Reference(points, normals, irradiance, scale, reached, solution)


def _points_on(solution):
    """Return POINTS points evenly over the lit surfaces, and the normals there."""
    rows = evenly(solution.patches.area * solution.live, POINTS)
    points = places(solution.patches.vertices[rows], 2, np.zeros(POINTS, np.uint64))
    return points, solution.patches.normal[rows]


def trials(scene: Scene, finest: float, reference: Reference) -> Iterator[Trial]:
    """Yield the trials: accuracies down to ``finest`` of each kind of element, then options."""
    for way, accuracy, make in _ways(scene, finest):
        make()  # compiled code is loaded
        begun = time.perf_counter()
        solution = make()
        reached = solution.estimate.reached
        seconds = time.perf_counter() - begun
        factors = solution.level.factors
        matrix, _ = factors.rows()
        yield Trial(
            way, accuracy, len(factors.area), seconds, matrix.nbytes, reached,
            reference.error_of(solution),
        )  # fmt: skip


def solver_trials(solution: Solution) -> Iterator[SolverTrial]:
    """Yield all solvers on the mesh of a solution, to its tolerance, with its form factors.

    Those that do not serve the scene, or its elements, are left out.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1, order=0)
    >>> [trial.solver for trial in solver_trials(solution)]
    ['gauss-seidel', 'jacobi', 'southwell', 'gmres', 'cg', 'direct']
    """
    level = solution.level
    for name in SOLVERS:
        if name == "cg" and level.recipe.order == 1:
            continue
        recipe = replace(level.recipe, solver=name)
        found = solve_level(solution.scene, level.reach, recipe, like=level)  # loads what it needs
        if found.solver == name:
            begun = time.perf_counter()
            found = solve_level(solution.scene, level.reach, recipe, like=level)
            yield SolverTrial(name, time.perf_counter() - begun, found.history)


def _ways(scene, finest) -> Iterator[tuple[str, float, Callable[[], Solution]]]:
    """Yield a name, the accuracy asked and how to solve."""
    asked, at = [a for a in ASKED if a >= finest], max(COMPARED, finest)
    for a in asked:
        yield "linear", a, lambda a=a: solve(scene, a, order=1)
    for a in asked:
        if a >= LEAST_CONSTANT:
            yield "constant", a, lambda a=a: solve(scene, a, order=0)
    for a in asked:
        if a >= LEAST_CONSTANT:
            yield "clusters", a, lambda a=a: _by_clusters(scene, a)
    for name in SOLVERS:
        order = 0 if name == "cg" else 1
        way = f"{name}, order {order}"
        yield way, at, lambda n=name, o=order: solve(scene, at, solver=n, order=o)
    yield "everything forced", at, lambda: solve(scene, at, force=True)


def _by_clusters(scene, accuracy) -> Solution:
    """Return the solution by clusters, whether or not the scene has many faces."""
    plan = plan_of_clusters(scene, accuracy)
    level, check, estimate = refined_clusters(scene, plan, None)
    return Solution(scene, plan, level, lambda: (check, estimate))
