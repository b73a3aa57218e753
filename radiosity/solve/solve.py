"""From a scene to its solution: mesh, survey, factors, system."""

import numpy as np

from radiosity.mesh.contact import find_contacts
from radiosity.mesh.interpolation import find_neighbours, gradients
from radiosity.mesh.patches import make_patches
from radiosity.scene.model import Scene, SceneError
from radiosity.solve.methods import SOLVERS, contraction
from radiosity.solve.plan import check_memory, make_plan
from radiosity.solve.solution import Balance, Solution
from radiosity.solve.system import area_lights, make_terms, side_reflectance
from radiosity.transport.factors import form_factors
from radiosity.transport.irradiance import Field, Surroundings
from radiosity.transport.lookup import make_table
from radiosity.transport.shine import shine
from radiosity.transport.survey import sides_that_see_out, survey
from radiosity.transport.threads import Progress, silent
from radiosity.transport.visibility import Visibility

STIFF = 0.999  # above this contraction an iteration would crawl: solve directly


def solve(
    scene: Scene,
    accuracy: float = 0.02,
    *,
    mesh: str = "auto",
    solver: str = "gauss-seidel",
    seed: int = 0,
    memory: float | None = None,
    progress: Progress = silent,
) -> Solution:
    """Solve B = M_e + rho F B for a scene (E7).

    Parameters
    ----------
    scene : Scene
    accuracy : float
        Asked relative error of the irradiance; chooses mesh, rays and tolerance.
    mesh : str
        ``auto``, ``input`` or N (cells along each edge of a face).
    solver : str
        ``gauss-seidel``, ``gmres`` or ``direct``.
    seed : int
        Of all sample patterns.
    memory : float, optional
        Bytes that may be used; half of what is free by default.
    progress : callable
        Called as ``progress(stage, done, total)``.

    Raises
    ------
    SceneError
        Nothing in a closed scene absorbs.
    Refused
        The matrix would not fit into ``memory``.
    NotConverged
    """
    if solver not in SOLVERS:
        raise ValueError(f"solver = {solver!r} must be one of {', '.join(SOLVERS)}")
    plan = make_plan(scene.faces, accuracy, mesh)
    check_memory(plan.cells, memory)
    emits = np.array([m.emits for m in scene.materials])[scene.faces.material]
    progress("mesh", 0, 1)
    cells = make_patches(scene.faces, plan.shape, find_contacts(scene.faces, emits))
    visibility = Visibility(scene.faces)
    table = make_table(scene.faces, cells)
    sources = np.zeros((cells.fronts, 2), bool)
    sources[:, 0] = emits[cells.face]
    if scene.ambient.any():
        sources |= sides_that_see_out(visibility, table, cells, seed)
    progress("mesh", 1, 1)
    reached = survey(visibility, table, cells, sources, seed)
    patches = cells.with_backs(reached.lit[:, 1])
    check_memory(len(patches), memory)
    live = np.concatenate([reached.lit[:, 0], np.ones(len(patches) - cells.fronts, bool)])
    fronts_open, backs_open = reached.open_share.T
    open_share = np.concatenate([fronts_open, backs_open[reached.lit[:, 1]]])
    open_share = np.where(live, open_share, 0.0)
    terms = make_terms(scene, patches, live)
    factors = form_factors(patches, visibility, live, plan.rays, seed, progress)
    arriving = np.pi * open_share[:, None] * scene.ambient
    solver = _suited(solver, factors, terms.reflectance, reached.closed, live)
    b, history = SOLVERS[solver](
        factors, terms.reflectance, terms.emission + terms.reflectance * arriving, plan.tolerance
    )
    irradiance = factors @ b + arriving
    return Solution(
        scene, patches, live, terms.reflectance, terms.emission, irradiance, b,
        _balance(scene, patches, terms, irradiance, b, open_share), history, solver, plan, seed,
        reached.closed, _surroundings(scene, patches, live, terms, factors, b, visibility, table, seed),
    )  # fmt: skip


def _suited(solver, factors, rho, closed, live):
    """Refuse a closed scene that nothing absorbs in; solve directly where bounces hardly fade."""
    if closed and live.any() and np.any(np.all(rho[live] >= 1.0, axis=0)):
        raise SceneError(
            "materials",
            ["every lit surface has reflectance 1 in a closed scene, so light never fades: "
             "let something absorb (diffuse below 1)"],
        )  # fmt: skip
    return "direct" if contraction(factors, rho) > STIFF else solver


def _balance(scene, patches, terms, irradiance, b, open_share) -> Balance:
    area = (patches.area * scene.unit_m**2)[:, None]
    entering = np.pi * open_share[:, None] * scene.ambient
    return Balance(
        emitted=(area * (terms.emission + entering)).sum(axis=0),
        absorbed=(area * (1 - terms.reflectance) * irradiance).sum(axis=0),
        escaped=(area * b * open_share[:, None]).sum(axis=0),
    )


def _surroundings(scene, patches, live, terms, factors, b, visibility, table, seed):
    """Return what rays that look around meet: lit patches, lights apart, the outside.

    Light that comes straight from the lights changes fast at shadow edges, so it is computed
    anew on a finer grid; only what has been reflected is taken from the patches.
    """
    lights = area_lights(scene)
    value, direct = b, np.zeros((2, 0, 3))
    if len(lights.polygons):
        value = b - terms.emission - terms.reflectance * (factors @ terms.emission)
        arriving, face = shine(scene.faces, patches, live, visibility, table, lights, seed)
        direct = side_reflectance(scene)[:, scene.faces.material[face]] * arriving
    around = find_neighbours(patches, live, scene.faces.material[patches.face])
    row = np.full((patches.fronts, 2), -1)
    row[:, 0] = np.where(live[: patches.fronts], np.arange(patches.fronts), -1)
    row[:, 1] = patches.back_of
    field = Field(
        row.ravel(), value, gradients(patches, around, value), patches.centroid,
        np.pi * scene.ambient, direct,
    )  # fmt: skip
    return Surroundings(visibility, table, field, lights)
