"""What a scene requires to be modelled, what may be skipped and why, and what the answer will cost.

Nothing of the scene is solved to the accuracy asked; where linear elements will do, a coarse mesh
is tried, to see how hard the scene is and how fast the machine.
"""

import time
from dataclasses import dataclass

import numpy as np

from radiosity.scene.model import Scene
from radiosity.solve.adapt import AIM, ROUNDS, STEPS, first_mesh, refined
from radiosity.solve.level import STIFF, solve_level
from radiosity.solve.plan import BYTES, FACE, MOST_LINEAR, Plan, make_plan
from radiosity.solve.reach import find_reach
from radiosity.solve.system import area_lights

TRIED = 0.1  # accuracy of the try
# Measured: patches grow as the inverse of the error to the power GROWTH, the time of a mesh as they
# to the power PAIRS; a round of refinement, its check and what compares them, is WHOLE times that.
GROWTH, PAIRS, WHOLE = 0.68, 1.6, 1.7
HALVING = 2.0 ** (GROWTH * PAIRS)  # times as long for half the error
BASE = 1.9e8  # bytes of the program itself
# Seconds of scenes of many faces: for each face, each counted ray, each squared cluster.
A_FACE, A_RAY, A_PAIR = 8e-5, 2.5e-7, 4e-7


@dataclass(frozen=True)
class Requirement:
    """One decision: what is modelled (or "nothing"), and why."""

    name: str
    model: str
    reason: str


@dataclass(frozen=True)
class Forecast:
    """What a scene requires and what its answer will cost.

    Attributes
    ----------
    plan : Plan
    requirements : tuple of Requirement
    patches : int
        Expected, live ones.
    seconds : float
        Without start-up and compiling.
    memory : float
        Bytes at the peak, the program's own among them.
    """

    plan: Plan
    requirements: tuple[Requirement, ...]
    patches: int
    seconds: float
    memory: float


def foresee(scene: Scene, plan: Plan) -> Forecast:
    """Return what solving a scene by a plan will take."""
    if plan.clusters:
        return _of_clusters(scene, plan)
    if not plan.adapts:
        return _of_mesh(scene, plan)
    how = {"order": 1, "solver": plan.recipe.solver, "force": plan.recipe.force}
    tried = make_plan(scene, max(TRIED, plan.accuracy), **how)
    level, check, estimate = refined(scene, tried, None)
    first = 4 * first_mesh(scene, plan, None).count
    rounds = _rounds(level, estimate.reached, first, plan.accuracy)
    once, pair = _timed(level, check.level, tried.recipe)
    seconds = float(WHOLE * np.sum(once + pair * rounds**PAIRS))
    patches = int(rounds[-1])
    memory = BASE + BYTES[1] * patches**2
    found = _requirements(scene, plan, level.reach, bool(level.outside.any()))
    return Forecast(plan, found, patches, seconds, memory)


def _rounds(level, reached, first, accuracy) -> np.ndarray:
    """Return the live patches expected of each round of refinement.

    Of meshes of ``first`` cells at first, when a ``level`` has ``reached`` its error.
    """
    cells, many = level.reach.patches.grid.division.count, max(1, len(level.rows))
    found = [max(many, many * first / cells)]
    error = reached * (many / found[0]) ** (1.0 / GROWTH)
    while error > accuracy and found[-1] < MOST_LINEAR and len(found) < ROUNDS:
        share = np.clip(AIM * accuracy / error, *STEPS)
        error *= share
        found.append(min(MOST_LINEAR, found[-1] * share**-GROWTH))
    return np.array(found)


def _timed(level, check, recipe):
    """Return the seconds that any mesh takes, and those of a patch to the power PAIRS."""
    spent, size = [], []
    for one in (check, level):
        begun = time.perf_counter()
        solve_level(one.scene, one.reach.patches.grid.division, recipe)
        spent.append(time.perf_counter() - begun)
        size.append(len(one.rows) ** PAIRS)
    pair = max(0.0, spent[1] - spent[0]) / max(1.0, size[1] - size[0])
    return max(0.0, spent[0] - pair * size[0]), pair


def _of_mesh(scene, plan):
    reach = find_reach(scene, plan.division, plan.recipe.seed, plan.recipe.force)
    n = int(reach.live.sum())
    seconds = A_PAIR * n**2 * (4.0 if reach.visibility.can_block else 1.0)
    memory = BASE + BYTES[plan.recipe.order] * len(reach.live) ** 2
    return Forecast(plan, _requirements(scene, plan, reach, None), n, seconds, memory)


def _of_clusters(scene, plan):
    reach = find_reach(scene, plan.division, plan.recipe.seed)
    faces = len(scene.faces)
    seconds = A_FACE * faces + A_RAY * plan.recipe.counted + A_PAIR * plan.clusters**2
    memory = BASE + FACE * faces + BYTES[0] * plan.clusters**2
    found = _requirements(scene, plan, reach, None)
    return Forecast(plan, found, int(reach.live.sum()), seconds, memory)


def _requirements(scene, plan, reach, is_open) -> tuple[Requirement, ...]:
    """Return the decisions, in the order of the light's way."""
    light = _bands, _visibility, _backs, _environment, _highlights, _lights
    return tuple(make(scene, plan, reach, is_open) for make in (*light, _elements, _solver))


def _bands(scene, plan, reach, is_open):
    used = [scene.materials[k] for k in np.unique(scene.faces.material)]
    rho = np.array([m.diffuse for m in used])
    emitted = np.array([m.emission for m in used] + [scene.ambient])
    grey = np.all(rho == rho[:, :1]) and np.linalg.matrix_rank(emitted) <= 1
    if plan.recipe.force:
        return Requirement("bands", "3", "all are asked for (--force)")
    if grey:
        return Requirement("bands", "1", "all is grey, and all lights have one colour")
    return Requirement("bands", "3", "reflectances or lights differ in colour")


def _visibility(scene, plan, reach, is_open):
    count = len(reach.visibility.blockers.count)
    if plan.recipe.force:
        return Requirement("visibility", f"{count} facets", "all may block (--force)")
    if count == 0:
        return Requirement("visibility", "nothing", "no face can come between two others: no rays")
    if plan.clusters:
        return Requirement("visibility", "rays", f"{count} facets can block: too many to cut out")
    return Requirement("visibility", "exact shadows", f"{count} facets can block")


def _backs(scene, plan, reach, is_open):
    backs = len(reach.patches) - reach.patches.fronts
    if backs:
        return Requirement("backs", f"of {backs} patches", "light gets there")
    return Requirement("backs", "nothing", "no light gets to the back of any face")


def _environment(scene, plan, reach, is_open):
    if scene.ambient.any():
        return Requirement("environment", "emits", "ambient light enters from outside")
    if is_open is None:
        return Requirement("environment", "measured", "what leaves the scene is found on the way")
    if is_open:
        return Requirement("environment", "black", "the scene is open: light leaves it")
    return Requirement("environment", "nothing", "the scene is closed")


def _highlights(scene, plan, reach, is_open):
    used = {int(k) for k in scene.faces.material}
    glossy = [m.name for k, m in enumerate(scene.materials) if k in used and m.specular is not None]
    if glossy:
        return Requirement("highlights", "lobes", f"{', '.join(glossy)}: glossy, in pictures")
    return Requirement("highlights", "nothing", "no surface is glossy")


def _lights(scene, plan, reach, is_open):
    emits = np.array([m.emits for m in scene.materials])[scene.faces.material]
    if not emits.any():
        return Requirement("area lights", "nothing", "no face emits")
    one_by_one = len(area_lights(scene).polygons)
    how = "one by one" if one_by_one else "as patches: too many"
    return Requirement("area lights", f"{int(emits.sum())}", f"sampled {how} in pictures")


def _elements(scene, plan, reach, is_open):
    if plan.clusters:
        return Requirement(
            "elements", f"{plan.clusters} clusters", "too many faces for an exchange of each pair"
        )
    kind = "linear" if plan.recipe.order else "constant"
    why = "refined until the error is met" if plan.adapts else "on the mesh that was given"
    return Requirement("elements", kind, why)


def _solver(scene, plan, reach, is_open):
    left = min(float(m.absorptance.min()) for m in scene.materials)
    if left < STIFF and not is_open:
        return Requirement("solver", "direct", "reflectances near 1: bounces hardly fade")
    return Requirement("solver", plan.recipe.solver, "the matrix is dense")


