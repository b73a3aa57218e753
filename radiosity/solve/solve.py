"""From a scene to its solution: mesh, survey, factors, system."""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from radiosity.scene.model import Scene, SceneError
from radiosity.solve.assembly import fitted, raw_factors
from radiosity.solve.methods import SOLVERS, NotConverged, contraction
from radiosity.solve.plan import check_memory, make_plan
from radiosity.solve.reach import find_reach
from radiosity.solve.solution import Balance, Solution
from radiosity.solve.surroundings import make_surroundings
from radiosity.solve.system import make_terms
from radiosity.transport.closure import repaired
from radiosity.transport.operator import FormFactors
from radiosity.transport.threads import Progress, silent

STIFF = 0.98  # above this contraction an iteration would crawl: solve directly


def solve(
    scene: Scene,
    accuracy: float = 0.02,
    *,
    mesh: str = "auto",
    solver: str = "gauss-seidel",
    seed: int = 0,
    memory: float | None = None,
    progress: Progress = silent,
    factors: FormFactors | None = None,
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
    factors : FormFactors, optional
        Those between this scene's patches, as `radiosity.solve.assembly.scene_factors` makes and
        `radiosity.transport.store.load_factors` reads them; computed anew if not given.

    Raises
    ------
    ValueError
        An option out of range, or factors of other rows than this scene's patches.
    SceneError
        Nothing in a closed scene absorbs.
    Refused
        The matrix would not fit into ``memory``.
    NotConverged
    NotClosable
        The rows of the form factors cannot be closed.
    """
    if solver not in SOLVERS:
        raise ValueError(f"solver = {solver!r} must be one of {', '.join(SOLVERS)}")
    plan = make_plan(scene.faces, accuracy, mesh)
    check_memory(plan.cells, memory)
    progress("mesh", 0, 1)
    reach = find_reach(scene, plan.shape, seed)
    progress("mesh", 1, 1)
    patches, live = reach.patches, reach.live
    check_memory(len(patches), memory)
    terms = make_terms(scene, patches, live)
    if factors is None:
        factors = repaired(raw_factors(reach, plan.factors, seed, progress))
    else:
        factors = fitted(factors, reach)
    solver = _suited(solver, factors, terms.reflectance, reach)
    entering = np.pi * factors.environment[:, None] * scene.ambient
    b, history = SOLVERS[solver](
        factors, terms.reflectance, terms.emission + terms.reflectance * entering, plan.tolerance
    )
    irradiance = factors @ b + entering
    balance = _balance(scene, reach.patches, factors, terms, irradiance, b)
    if not history[-1] <= accuracy and not balance.defect <= accuracy:
        raise NotConverged(f"{solver}, on form factors that create light,", history, accuracy)
    return Solution(
        scene, patches, live, terms.reflectance, terms.emission, irradiance, b,
        balance, history, solver, plan, seed,
        factors.is_closed, make_surroundings(scene, reach, terms, factors, b, seed),
    )  # fmt: skip


def _suited(solver, factors, rho, reach):
    """Refuse rooms that nothing absorbs in; solve directly where bounces hardly fade."""
    if np.any(rho >= 1.0) and np.any(_never_fades(factors, rho, reach.live)):
        raise SceneError(
            "materials",
            ["every lit surface has reflectance 1 in a closed scene, or in a closed part of it, "
             "so light never fades: let something absorb (diffuse below 1)"],
        )  # fmt: skip
    return "direct" if contraction(factors, rho) > STIFF else solver


def _never_fades(factors, rho, live) -> np.ndarray:
    """Return (parts, bands) bool: closed parts of the scene where nothing lit absorbs."""
    parts, part = connected_components(csr_matrix(factors.exchange > 0), directed=False)
    fades = np.zeros((parts, rho.shape[1]), bool)
    np.logical_or.at(fades, part, ((rho < 1.0) | (factors.environment > 0)[:, None]))
    lit = np.zeros(parts, bool)
    lit[part[live]] = True
    return lit[:, None] & ~fades


def _balance(scene, patches, factors, terms, irradiance, b) -> Balance:
    area = (patches.area * scene.unit_m**2)[:, None]
    open_share = factors.environment[:, None]
    return Balance(
        emitted=(area * (terms.emission + np.pi * open_share * scene.ambient)).sum(axis=0),
        absorbed=(area * (1 - terms.reflectance) * irradiance).sum(axis=0),
        escaped=(area * b * open_share).sum(axis=0),
    )
