"""What a scene requires to be modelled, what may be skipped and why, and what the answer will cost.

The first rounds of refinement are tried, to see how hard the scene is and how fast the machine;
what is left after them is expected from how such rounds go. Where light is exchanged between
clusters, the mesh is made and a small share of the rays is cast.
"""

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtr

from radiosity.scene.model import Scene
from radiosity.solve.adapt import AIM, MORE_RAYS, ROUNDS, STEPS, Rounds
from radiosity.solve.clustered import coarser, solve_clusters
from radiosity.solve.estimate import COARSER, Check, compare
from radiosity.solve.fading import STIFF, THROUGH
from radiosity.solve.level import solve_level
from radiosity.solve.plan import BYTES, FACE, MOST_CLUSTERS, MOST_LINEAR, Plan
from radiosity.solve.reach import find_reach
from radiosity.solve.refinement import WORTH
from radiosity.solve.system import lights_of, side_reflectance, translucent

if TYPE_CHECKING:
    from radiosity.solve.solution import Solution

TRIED = 0.1  # share of the work foreseen that rounds are tried for, at least one
# Measured: patches grow as the inverse of the error to the power GROWTH, the time of a mesh as they
# to the power PAIRS; a round of refinement, its check and what compares them, is WHOLE times that.
# Its error is MISSES times what it was meant to be, log-normal of the deviation SPREAD.
GROWTH, PAIRS, WHOLE = 0.8, 1.6, 1.7
MISSES, SPREAD, RARE = 0.9, 0.28, 0.01
HALVING = 2.0 ** (GROWTH * PAIRS)  # times as long for half the error
BASE = 1.95e8  # bytes of the program itself
TRIED_RAYS = 1 / 64, 1 / 16  # shares of the rays that count factors, of scenes of many faces
QUARTERED, QUIETER = 0.5, 0.4  # measured: errors between 4 times the clusters, by 4 times the rays
A_PAIR = 8e-7, 2.2e-6  # seconds of a pair of patches, on one mesh; of constant ones in shadows


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

    def __str__(self) -> str:
        """Return it as ``radiosity plan`` prints it."""
        from radiosity.solve.overview import forecast_text

        return forecast_text(self)

    def _repr_html_(self) -> str:
        """Return it as a notebook shows it."""
        from radiosity.solve.overview import forecast_html

        return forecast_html(self)


def foresee(scene: Scene, plan: Plan) -> Forecast:
    """Return what solving a scene by a plan will take."""
    if plan.clusters:
        return _of_clusters(scene, plan)
    if plan.recipe.order == 0 or not plan.adapts:
        return _of_mesh(scene, plan)
    rounds, patches, chance = _try(scene, plan)
    once, pair = _timed(rounds.level, rounds.check.level)
    seconds = float(WHOLE * np.sum(chance * (once + pair * patches**PAIRS)))
    last = chance - np.append(chance[1:], 0.0)  # chances that it is the last one
    memory = BASE + BYTES[1] * float(last @ patches**2)
    found = _requirements(scene, plan, rounds.level.reach, bool(rounds.level.outside.any()))
    lit = round(last @ patches) if len(rounds.level.rows) else 0
    return Forecast(plan, found, lit, seconds, memory)


def _try(scene, plan):
    """Try rounds; return the last, and patches and chances of all.

    Live patches of the rounds tried, then of those ahead, and how likely it is that each is needed.
    """
    rounds, tried, more = Rounds(scene, plan), [], True
    while more:
        cells = rounds.coarse.count
        more, ahead = rounds.advance(), np.zeros((2, 0))
        tried.append(max(1, len(rounds.level.rows)))
        if more:
            after = tried[-1] * rounds.coarse.count / cells
            ahead = _ahead(rounds.estimate.reached, after, plan.accuracy, rounds.left)
            more = np.sum(np.power(tried, PAIRS)) < TRIED * np.sum(ahead[1] * ahead[0] ** PAIRS)
    return rounds, np.append(tried, ahead[0]), np.append(np.ones(len(tried)), ahead[1])


def _ahead(reached, patches, accuracy, most) -> np.ndarray:
    """Return (2, k): patches and chances of the rounds after one that ``reached`` an error.

    The first of them has ``patches``; there are at most so many rounds.
    """
    found, chance, left = [], [], 1.0
    share = np.clip(AIM * accuracy / reached, *STEPS)
    while left > RARE and len(found) < most:
        found.append(patches)
        chance.append(left)
        if MOST_LINEAR < WORTH * patches:
            break
        reached *= MISSES * share
        left *= ndtr(np.log(reached / accuracy) / SPREAD)
        reached = max(reached, accuracy)  # where another one is needed
        share = np.clip(AIM * accuracy / reached, *STEPS)
        patches = min(MOST_LINEAR, share**-GROWTH * patches)
    return np.array([found, chance])


def _timed(level, check):
    """Return the seconds that any mesh takes, and those of a patch to the power PAIRS.

    Both are solved again: the first time compiled code may have been loaded on the way.
    """
    spent, size = [], []
    for one in (check, level):
        division, recipe = one.reach.patches.grid.division, one.recipe
        again, meshing = _clocked(find_reach, one.scene, division, recipe.seed, recipe.force)
        spent.append(meshing + _clocked(solve_level, one.scene, again, recipe)[1])
        size.append(len(one.rows) ** PAIRS)
    pair = max(0.0, spent[1] - spent[0]) / max(1.0, size[1] - size[0])
    return max(0.0, spent[0] - pair * size[0]), pair


def _of_mesh(scene, plan):
    reach = find_reach(scene, plan.division, plan.recipe.seed, plan.recipe.force)
    n = int(reach.live.sum())
    shadows = plan.recipe.order == 0 and reach.visibility.can_block
    seconds = A_PAIR[int(shadows)] * n**2
    memory = BASE + BYTES[plan.recipe.order] * len(reach.live) ** 2
    return Forecast(plan, _requirements(scene, plan, reach, None), n, seconds, memory)


def _of_clusters(scene, plan):
    """Try few rays, between few clusters, twice: what they take on top is for the rays."""
    reach, meshing = _clocked(find_reach, scene, plan.division, plan.recipe.seed, plan.recipe.force)
    spent, cast = [], []
    for few in TRIED_RAYS:
        recipe = replace(plan.recipe, counted=round(plan.recipe.counted * few))
        clusters = round(plan.clusters * np.sqrt(few))
        level, seconds = _clocked(solve_clusters, scene, reach, recipe, clusters)
        spent.append(seconds)
        cast.append(recipe.counted)
    check, halving = _clocked(coarser, level, clusters // 4)
    estimate, comparing = _clocked(compare, level, Check(check, COARSER))
    a_ray = max(0.0, spent[1] - spent[0]) / (cast[1] - cast[0])
    once = max(0.0, spent[0] - a_ray * cast[0])
    clusters, looks = _rounds_of_clusters(plan, estimate)
    seconds = meshing + np.sum(once + a_ray * plan.recipe.counted * clusters**2)
    seconds += np.sum(halving + comparing * looks)
    most = BYTES[0] * (plan.clusters * clusters[-1]) ** 2
    memory = BASE + FACE * len(scene.faces) + most
    found = _requirements(scene, plan, reach, None)
    return Forecast(plan, found, int(reach.live.sum()), float(seconds), float(memory))


def _rounds_of_clusters(plan, estimate) -> tuple[np.ndarray, np.ndarray]:
    """Return clusters of each solution and looks of each round, as multiples of the first's.

    ``estimate`` is of TRIED_RAYS, and so between a quarter as many clusters.
    """
    clusters, looks, mesh, kernel = [1.0], [1.0], QUARTERED * estimate.mesh, estimate.kernel
    while np.hypot(mesh, kernel) > plan.accuracy and len(looks) < ROUNDS:
        if kernel > mesh:
            looks, kernel = [*looks, MORE_RAYS * looks[-1]], QUIETER * kernel
        elif 2.0 * clusters[-1] * plan.clusters <= MOST_CLUSTERS:
            clusters, mesh = [*clusters, 2.0 * clusters[-1]], mesh / 2.0
            looks = [*looks, looks[-1]]
        else:
            break
    return np.array(clusters), np.array(looks)


def requirements_of(solution: "Solution") -> tuple[Requirement, ...]:
    """Return what was modelled of a solved scene, what was not, and why.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/furnace.toml"), 0.1)
    >>> [(r.model, r.reason) for r in requirements_of(solution) if r.name == "environment"]
    [('nothing', 'the scene is closed')]
    """
    is_open = not solution.closed
    return _requirements(solution.scene, solution.plan, solution.level.reach, is_open)


def _clocked(work, *what):
    """Return a result and the seconds that it took."""
    begun = time.perf_counter()
    found = work(*what)
    return found, time.perf_counter() - begun


def _requirements(scene, plan, reach, is_open) -> tuple[Requirement, ...]:
    """Return the decisions, in the order of the light's way."""
    light = (
        _bands, _visibility, _backs, _environment, _highlights, _mirrors, _passages, _lights,
        _lamps, _elements, _solver, _detail,
    )  # fmt: skip
    made = (make(scene, plan, reach, is_open) for make in light)
    return tuple(requirement for requirement in made if requirement is not None)


def _bands(scene, plan, reach, is_open):
    index = np.unique(scene.faces.material)
    used = [scene.materials[k] for k in index]
    rho = np.concatenate([side_reflectance(scene)[0], translucent(scene)])
    rho = rho[np.append(index, index + len(scene.materials))]
    lamps = [lamp.strength for lamp in scene.lights]
    emitted = np.array([m.emission for m in used] + [scene.ambient, *lamps])
    grey = np.all(rho == rho[:, :1]) and np.linalg.matrix_rank(emitted) <= 1
    grey = grey and all(m.texture is None or m.texture.grey for m in used)
    if grey and scene.sends_on:
        from radiosity.solve.optics import different_bands

        grey = different_bands(scene) == 1
    count, wavelengths = scene.bands.count, scene.bands.wavelengths is not None
    model = f"{count} wavelengths" if wavelengths else str(count)
    if plan.recipe.force:
        return Requirement("bands", model, "all are asked for (--force)")
    if grey and count > 1:
        return Requirement("bands", "1", "all is grey, and all lights have one colour")
    if count == 1:
        return Requirement("bands", model, "the luminance only is asked for (--bands grey)")
    if wavelengths:
        return Requirement("bands", model, _listed(scene.spectra) or "asked for (--bands)")
    if scene.spectra:
        return Requirement("bands", model, f"{_listed(scene.spectra)}, taken as RGB (--bands rgb)")
    return Requirement("bands", model, "reflectances or lights differ in colour")


def _listed(spectra) -> str:
    """Return which colours are spectra, the first of them by name; "" of none."""
    if not spectra:
        return ""
    more = f" and {len(spectra) - 2} more" if len(spectra) > 2 else ""
    return f"spectra are given: {', '.join(spectra[:2])}{more}"


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
    if not reach.live.any():
        return Requirement("environment", "nothing", "there is no light that could leave")
    if scene.ambient.any():
        return Requirement("environment", "emits", "ambient light enters from outside")
    if is_open is None:
        return Requirement("environment", "measured", "what leaves the scene is found on the way")
    if is_open:
        return Requirement("environment", "black", "the scene is open: light leaves it")
    return Requirement("environment", "nothing", "the scene is closed")


def _highlights(scene, plan, reach, is_open):
    glossy = having(scene, "specular")
    if glossy:
        why = f"{glossy}: in pictures, and between surfaces by rays"
        return Requirement("highlights", "lobes", why)
    return Requirement("highlights", "nothing", "no surface is glossy")


def _mirrors(scene, plan, reach, is_open):
    names = having(scene, "mirror")
    why = f"{names}: plain ones as windows to a mirrored scene, all others by rays"
    return Requirement("mirrors", "followed", why) if names else None


def _passages(scene, plan, reach, is_open):
    names = having(scene, "transmit")
    why = f"{names}: light goes straight on, or is refracted, along rays"
    return Requirement("transmission", "followed", why) if names else None


def having(scene: Scene, part: str) -> str:
    """Return the names of materials in use that have a lobe, a mirror or a transmission."""
    used = [scene.materials[k] for k in np.unique(scene.faces.material)]
    return ", ".join(m.name for m in used if getattr(m, part) is not None)


def _lights(scene, plan, reach, is_open):
    emits = np.array([m.emits for m in scene.materials])[scene.faces.material]
    if not emits.any():
        return Requirement("area lights", "nothing", "no face emits")
    one_by_one = len(lights_of(scene).polygons)
    how = "one by one" if one_by_one else "as patches: too many"
    return Requirement("area lights", f"{int(emits.sum())}", f"sampled {how} in pictures")


def _lamps(scene, plan, reach, is_open):
    if scene.lights:
        why = "exact at points, averaged over patches, with shadows"
        return Requirement("abstract lights", f"{len(scene.lights)}", why)
    return Requirement("abstract lights", "nothing", "there are none")


def _elements(scene, plan, reach, is_open):
    if plan.clusters:
        return Requirement(
            "elements", f"{plan.clusters} clusters", "too many faces for an exchange of each pair"
        )
    kind = "linear" if plan.recipe.order else "constant"
    why = "refined until the error is met" if plan.adapts else "on the mesh that was given"
    return Requirement("elements", kind, why)


def _solver(scene, plan, reach, is_open):
    left = min(float(m.least_absorptance.min()) for m in scene.materials)
    if left < STIFF and not is_open:
        return Requirement("solver", "direct", "reflectances near 1: bounces hardly fade")
    why = why_gmres(scene)
    if why and plan.recipe.solver not in THROUGH:
        return Requirement("solver", "gmres", why)
    return Requirement("solver", plan.recipe.solver, "the matrix is dense")


def why_gmres(scene: Scene) -> str:
    """Return why solvers that know the factors only do not serve a scene, "" where they do."""
    if scene.sends_on:
        return "mirrors, clear bodies or lobes send light on"
    through = translucent(scene)[scene.faces.material].any()
    return "light goes through translucent sheets" if through else ""


def _detail(scene, plan, reach, is_open):
    used = [scene.materials[k] for k in np.unique(scene.faces.material)]
    textured = [m.name for m in used if m.texture is not None]
    bumped = [m.name for m in used if m.bump is not None]
    rough = [m.name for m in used if m.shininess is not None]
    found = []
    if textured:
        found.append(f"textures of {', '.join(textured)}, on patches their means")
    if bumped:
        found.append(f"bumps of {', '.join(bumped)}")
    if rough:
        found.append(f"shininess of {', '.join(rough)}, elsewhere of mean roughness")
    if scene.faces.is_curved.any():
        found.append("faces that stand for a curved surface")
    if found:
        return Requirement("detail", "in pictures", "; ".join(found))
    return Requirement("detail", "nothing", "no texture, bumps or normals at corners")
