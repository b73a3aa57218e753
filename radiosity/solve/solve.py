"""From a scene to its solution: the mesh that the accuracy asks for, solved, with its error."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radiosity.scene.model import Scene, check_scene
from radiosity.solve.adapt import check_of, refined, refined_clusters, refined_constant
from radiosity.solve.estimate import Goal, compare, unknown
from radiosity.solve.level import solve_level
from radiosity.solve.methods import Unbalanced
from radiosity.solve.plan import check_memory, left_beside, left_beside_chains, make_plan
from radiosity.solve.reach import find_reach
from radiosity.solve.solution import Solution, checked_points
from radiosity.transport.operator import FormFactors
from radiosity.transport.threads import Progress, silent

UNBALANCED = 0.1  # share of the emitted power that no mesh, however coarse, may lose or create


def solve(
    scene: Scene,
    accuracy: float = 0.02,
    *,
    mesh: str = "auto",
    order: int | None = None,
    solver: str = "gauss-seidel",
    seed: int = 0,
    force: bool = False,
    seconds: float | None = None,
    memory: float | None = None,
    progress: Progress = silent,
    factors: FormFactors | None = None,
    watch: Callable[[Solution], None] | None = None,
    goal: tuple[np.ndarray, np.ndarray] | None = None,
) -> Solution:
    """Solve B = M_e + rho F B for a scene (E7).

    Parameters
    ----------
    scene : Scene
    accuracy : float
        Asked relative error of the irradiance; chooses mesh, rays and tolerance.
    mesh : str
        ``auto``: refined until the estimated error meets the accuracy; ``input`` or N (cells along
        each edge of a face): as it is.
    order : int, optional
        Of the elements: 0 (constant) or 1 (linear). If not given, 1 where the mesh is ``auto`` and
        the scene has no more than a few thousand faces, else 0.
    solver : str
        ``gauss-seidel``, ``jacobi``, ``southwell``, ``gmres``, ``cg`` or ``direct``; where
        reflectances are near 1, ``direct`` takes their place.
    seed : int
        Of all sample patterns.
    force : bool
        Model everything, also what the scene does not require; see `radiosity.solve.requirements`.
    seconds : float, optional
        Take the best answer that can be had in so much time, whatever its accuracy; for the mesh
        ``auto``, without start-up and compiling.
    memory : float, optional
        Bytes that may be used; half of what is free by default.
    progress : callable
        Called as ``progress(stage, done, total)``.
    factors : FormFactors, optional
        Those between this scene's patches, as `radiosity.solve.assembly.scene_factors` makes and
        `radiosity.FormFactors.load` reads them; computed anew if not given. Order 0.
    watch : callable, optional
        Called with what is found so far, to be shown, whenever the solver has improved it; of
        ``southwell`` it has the ambient correction. Its errors are not known: infinite.
    goal : (points, normals), optional
        Refine for these points (k, 3) only, until 95 % of their errors meet the accuracy; of more
        than 500, some are judged.

    Raises
    ------
    ValueError
        An option out of range, or factors of other rows than this scene's patches.
    SceneError
        Nothing in a closed scene absorbs, or a scene made in code holds impossible numbers.
    Refused
        The matrix would not fit into ``memory``.
    NotConverged
    NotClosable
        The rows of the form factors cannot be closed.

    Examples
    --------
    >>> import radiosity
    >>> scene, early = radiosity.load("scenes/box6.toml"), []
    >>> solution = radiosity.solve(scene, 0.05, solver="southwell", watch=early.append)
    >>> bool(solution.estimate.reached <= 0.05)
    True
    >>> radiosity.render(early[0], size=(8, 6), samples=8).pixels.shape
    (6, 8, 3)
    """
    check_scene(scene)
    if factors is not None:
        if order == 1:
            raise ValueError("order = 1 has form factors of its own: leave out factors, or order")
        order = 0
    plan = make_plan(
        scene, accuracy, mesh, order=order, solver=solver, seed=seed, force=force, seconds=seconds
    )
    if factors is not None:
        plan = replace(plan, adapts=False)
    memory = left_beside(len(scene.faces), memory)
    if scene.sends_on:
        from radiosity.solve.optics import different_bands

        memory = left_beside_chains(different_bands(scene), memory, plan.recipe.order)
    check_memory(plan.clusters or plan.division.count, memory, plan.recipe.order)
    aim = None if goal is None else Goal.of(*checked_points(*goal), seed)
    seen = watch and (lambda level: watch(Solution(scene, plan, level, lambda: unknown(level))))
    if plan.adapts:
        of_patches = refined if plan.recipe.order else refined_constant
        until = refined_clusters if plan.clusters else of_patches
        found = until(scene, plan, memory, seen, progress, aim)
        return _judged(Solution(scene, plan, found[0], lambda: found[1:]))
    reach = find_reach(scene, plan.division, seed, force, progress=progress)
    level = solve_level(
        scene, reach, plan.recipe, factors=factors, watch=seen, progress=progress, memory=memory
    )

    def judge():
        check = check_of(level, plan, memory)
        return check, compare(level, check, aim)

    return _judged(Solution(scene, plan, level, judge))


def _judged(solution: Solution) -> Solution:
    """Return the solution; refuse one that makes or loses light."""
    history, accuracy = solution.history, solution.plan.accuracy
    defect = solution.balance.defect
    if not defect <= UNBALANCED or not (history[-1] <= accuracy or defect <= accuracy):
        order, caught = solution.plan.recipe.order, solution.scene.sends_on
        raise Unbalanced(defect, history, order, caught)
    return solution
