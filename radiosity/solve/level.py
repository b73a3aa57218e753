"""One mesh, solved: its elements, factors and radiosities, and irradiance from them anywhere."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from radiosity.mesh.elements import make_elements
from radiosity.mesh.interpolation import find_neighbours, gradients
from radiosity.scene.model import Scene
from radiosity.solve.assembly import fitted, raw_factors
from radiosity.solve.equations import Sheets, System, sheets_of
from radiosity.solve.fading import suited
from radiosity.solve.methods import solve_bands
from radiosity.solve.plan import Recipe, check_memory
from radiosity.solve.reach import Reach
from radiosity.solve.surroundings import surroundings_of
from radiosity.solve.system import Terms, lights_of, make_terms
from radiosity.transport.arrival import Arrival, Senders, arriving, make_senders
from radiosity.transport.closure import repaired
from radiosity.transport.factors import patch_geometry
from radiosity.transport.irradiance import Surroundings
from radiosity.transport.lamps import lamp_irradiance, lamps_on
from radiosity.transport.linear import LinearFactors, linear_factors
from radiosity.transport.operator import FormFactors
from radiosity.transport.threads import Progress, silent

if TYPE_CHECKING:
    from radiosity.transport.chains import Chains
    from radiosity.transport.tracer import Tracer


@dataclass(frozen=True)
class Kept:
    """What factors told of a solved mesh, in their place where they are gone.

    Attributes
    ----------
    straight : (width m, bands) float64
        Coefficients of the irradiance that comes straight from faces that emit, W/m2.
    escaping : (m, bands) float64
        Radiosity of each live patch that leaves the scene, W/m2.
    """

    straight: np.ndarray
    escaping: np.ndarray


@dataclass(frozen=True)
class Level:
    """A solved mesh.

    Attributes
    ----------
    scene : Scene
    reach : Reach
    terms : Terms
    recipe : Recipe
    senders : Senders
        The elements of the live patches.
    factors : FormFactors, LinearFactors or None
        Between all patches, or between the elements of the live ones; None of what a file held.
    coefficients, arriving : (width m, bands) float64
        Of radiosity and irradiance on the m live patches, W/m2.
    outside : (width m,) float64
        Coefficients of the factor to the outside.
    lamplight : (width m, bands) float64
        Coefficients of the irradiance that abstract light sources cause, W/m2.
    sheets : Sheets or None
        What goes through translucent ones.
    history : list of float
        The solver's error bound after each iteration.
    solver : str
        The one that was used.
    chains, tracer : Chains, Tracer or None
        What comes by way of mirrors, clear bodies and lobes.
    constant : bool
        Whether slopes of linear elements were left out.
    kept : Kept or None
        In place of what ``factors`` and ``chains`` tell of the answer.
    """

    scene: Scene
    reach: Reach
    terms: Terms
    recipe: Recipe
    senders: Senders
    factors: FormFactors | LinearFactors | None
    coefficients: np.ndarray
    arriving: np.ndarray
    outside: np.ndarray
    lamplight: np.ndarray
    sheets: Sheets | None
    history: list
    solver: str
    chains: "Chains | None" = None
    tracer: "Tracer | None" = None
    constant: bool = False
    kept: Kept | None = None

    @property
    def rows(self) -> np.ndarray:
        """Return (m,) the live patches."""
        return np.flatnonzero(self.reach.live)

    def on_patches(self, coefficients: np.ndarray) -> np.ndarray:
        """Return (n, bands) patch means of a field of coefficients, 0 where dark."""
        full = np.zeros((len(self.reach.live), coefficients.shape[1]))
        full[self.rows] = coefficients[: len(self.senders.elements)]
        return full

    @property
    def emitted(self) -> np.ndarray:
        """Return the coefficients (width m, bands) of the emission."""
        emission = np.zeros_like(self.coefficients)
        emission[: len(self.rows)] = self.terms.emission[self.rows]
        return emission

    @property
    def entering(self) -> np.ndarray:
        """Return the coefficients (width m, bands) of irradiance that no patch sends, at first."""
        return from_outside(self.scene, self.outside) + self.lamplight

    def arrived(self, coefficients: np.ndarray) -> np.ndarray:
        """Return the coefficients of the irradiance that radiosities of the live patches cause."""
        straight = self._straight(coefficients)
        return straight if self.chains is None else straight + self.chains.arriving(coefficients)

    @property
    def straight(self) -> np.ndarray:
        """Return the coefficients (width m, bands) of what comes straight from faces that emit."""
        return self._straight(self.emitted) if self.kept is None else self.kept.straight

    def _straight(self, coefficients):
        if self.senders.elements.order == 1:
            return self.factors @ coefficients
        return (self.factors @ self.on_patches(coefficients))[self.rows]

    def scattered(self, e: np.ndarray) -> np.ndarray:
        """Return the coefficients of what irradiances make patches send, once."""
        sent = self._reflectance * e
        return sent if self.sheets is None else sent + self.sheets.passed(e)

    @property
    def _reflectance(self):
        return np.tile(self.terms.reflectance[self.rows], (self.senders.elements.width, 1))

    @cached_property
    def surroundings(self) -> Surroundings:
        """Return what rays that look around meet."""
        lights = lights_of(self.scene)
        value = self.coefficients - self._reflectance * self.lamplight
        if len(lights.polygons):
            value = value - self.emitted - self._reflectance * self.straight
        return surroundings_of(
            self.scene, self.reach, lights, self.on_patches(value), self._slopes(value),
            self.recipe.seed, True, self.tracer,
        )  # fmt: skip

    def _slopes(self, value):
        """Return (n, bands, 3) gradients: of the elements, of constant ones from neighbours."""
        patches, live = self.reach.patches, self.reach.live
        if self.senders.elements.order == 0:
            around = find_neighbours(patches, live, self.scene.faces.material[patches.face])
            return gradients(patches, around, self.on_patches(value))
        slopes = np.zeros((len(patches), value.shape[1], 3))
        slopes[self.rows] = self.senders.elements.gradients(value)
        return slopes

    @property
    def escaping(self) -> np.ndarray:
        """Return (m, bands): the radiosity of each live patch that leaves the scene, W/m2."""
        if self.kept is not None:
            return self.kept.escaping
        if self.senders.elements.order == 1:
            m = len(self.rows)
            gone = self.factors.escaping(self.senders.elements, self.coefficients)
            if self.chains is not None:
                gone = gone + self.coefficients[:m] * self.chains.escaping[:m]
            return gone
        gone = self.outside[:, None]
        if self.chains is not None:
            gone = gone + self.chains.escaping
        return self.coefficients * gone

    def gathered(
        self, points: np.ndarray, normals: np.ndarray, progress: Progress = silent
    ) -> Arrival:
        """Return the irradiance (k, bands) in W/m2 at points of unit normals, and its error."""
        found = arriving(
            self.senders, self.coefficients, points, normals, seed=self.recipe.seed,
            progress=progress,
        )  # fmt: skip
        if self.scene.lights:
            found.total[:] += lamp_irradiance(
                self.reach.visibility, self.scene.lights, points, normals, self.scene.unit_m
            )
        if self.scene.ambient.any():
            share, error = self._sky_at(points, normals)
            found.total[:] += np.pi * share[:, None] * self.scene.ambient
            found.error[:] += np.pi * error * self.scene.ambient
        return found if self.tracer is None else self._with_chains(found, points, normals)

    def _with_chains(self, found, points, normals):
        from radiosity.solve.chains import AT_POINTS, arriving_by_chains

        more = arriving_by_chains(
            self.tracer, self.coefficients, self.scene.ambient, points, normals,
            AT_POINTS * self.recipe.chained,
        )  # fmt: skip
        error = np.hypot(found.error, more.error)
        return Arrival(found.total + more.total, error, found.seen)

    def _sky_at(self, points, normals):
        """Return (k,) the factors from points to the outside, and (k, 1) their errors."""
        sides, seed = self._all_sides, self.recipe.seed
        found = arriving(sides, np.ones((len(sides.elements), 1)), points, normals, seed=seed)
        share = 1.0 - found.seen
        return np.where(share > sides.blur, share, 0.0), found.error

    @cached_property
    def _all_sides(self) -> Senders:
        """Both sides of all faces, lit or not: all that hides the outside."""
        patches, visibility = self.reach.patches, self.reach.visibility
        both = patches.with_backs(np.ones(patches.fronts, bool))
        rows = np.flatnonzero(np.concatenate([patches.behind[:, 0], patches.behind[:, 1]]) < 0)
        elements = make_elements(both, rows, 0)
        geometry = patch_geometry(both, visibility, rows)
        rule = self.senders.sight.tolerance.max(initial=0.0)
        return make_senders(elements, geometry, visibility, rule)


def solve_level(
    scene: Scene, reach: Reach, recipe: Recipe, *, factors: FormFactors | None = None,
    constant: bool = False, watch: Callable[[Level], None] | None = None,
    memory: float | None = None, progress: Progress = silent, like: Level | None = None,
) -> Level:  # fmt: skip
    """Solve a meshed scene.

    Parameters
    ----------
    factors : FormFactors, optional
        For order 0, those of the same patches, made before.
    constant : bool
        Leave the slopes of linear elements out: constant ones, by collocation.
    watch : callable, optional
        Called with a level at every iterate, of ``southwell`` with its ambient correction.
    memory : float, optional
        Bytes that may be used; half of what is free by default.
    like : Level, optional
        The same mesh under other light, solved: its factors are taken, and nothing is measured.

    Raises
    ------
    SceneError
        Nothing in a closed part of the scene absorbs.
    ValueError
        ``factors`` of other patches.
    Refused
        The matrix would not fit into ``memory``.
    NotConverged, NotClosable
    """
    patches, rows = reach.patches, np.flatnonzero(reach.live)
    terms = make_terms(scene, patches, reach.live)
    if like is None:
        check_memory(len(patches), memory, recipe.order)
        senders = senders_of(reach, recipe, recipe.order, terms)
        factors = _factors(reach, recipe, senders, factors, constant, progress)
    else:
        senders, factors, constant = like.senders, like.factors, like.constant
    elements, own = senders.elements, rows if recipe.order == 1 else np.arange(len(patches))
    outside = factors.outside if recipe.order == 1 else factors.environment
    lamplight = _lamplight(scene, reach, elements, len(own), constant)
    entering = from_outside(scene, outside) + lamplight
    sheets = None if terms.transmittance is None else sheets_of(terms, elements, rows)
    emission = terms.emission[rows]
    known = None if like is None else like.chains
    tracer, chains = _chains(scene, reach, senders, emission, recipe, constant, progress, known)
    more = [x if x is None or recipe.order == 1 else x.spread(rows, len(own))
            for x in (sheets, chains)]  # fmt: skip
    if chains is not None:
        entering = entering + more[1].entering(scene.ambient)
    system = _system(terms, factors, entering, own, elements.width, *more)
    solver = suited(recipe.solver, system, reach.live[own], _of(terms.sent_on, own))

    def level(b, history):
        parts = b, system.arriving(b) + entering, outside, lamplight
        parts = parts if recipe.order == 1 else (x[rows] for x in parts)
        made = scene, reach, terms, recipe, senders, factors, *parts, sheets, history, solver
        return Level(*made, chains, tracer, constant)

    seen = None if watch is None else lambda b: watch(level(b.copy(), []))
    return level(*solve_bands(solver, system, recipe.tolerance, recipe.force, seen))


def senders_of(reach: Reach, recipe: Recipe, order: int, terms: Terms) -> Senders:
    """Return the elements of the live patches as seen from points; those that emit exactly."""
    rows = np.flatnonzero(reach.live)
    rule = np.where(terms.emission[rows].any(axis=1), 0.0, recipe.rule)
    geometry = patch_geometry(reach.patches, reach.visibility, rows)
    elements = make_elements(reach.patches, rows, order)
    return make_senders(elements, geometry, reach.visibility, rule)


def _factors(reach, recipe, senders, factors, constant, progress):
    """Return the factors of elements, of order 0 those that are given, if they fit."""
    if recipe.order == 1:
        area = reach.patches.area[reach.live]
        found = linear_factors(senders, area, recipe.seed, progress)
        return found.without_slopes() if constant else found
    if factors is not None:
        return fitted(factors, reach)
    return repaired(raw_factors(reach, recipe.factors, recipe.seed, progress, not recipe.force))


def from_outside(scene: Scene, outside: np.ndarray) -> np.ndarray:
    """Return the irradiance (m, bands) of ambient light, by factors (m,) to the outside."""
    return np.pi * outside[:, None] * scene.ambient


def _lamplight(scene, reach, elements, own, constant):
    """Return the coefficients (width own, bands) of lamps' light on the live patches, or on all."""
    found = np.zeros((elements.width * own, scene.bands.count))
    if scene.lights:
        live = lamps_on(reach.visibility, scene.lights, elements, scene.unit_m)
        found[slice(None) if elements.order == 1 else reach.live] = live
        if constant:
            found[own:] = 0.0
    return found


def _chains(scene, reach, senders, emission, recipe, constant, progress, known):
    """Return what follows light along single directions, and what it found; None where none is."""
    if not scene.sends_on:
        return None, None
    from radiosity.solve.chains import chains_of, make_tracer  # others need none of it

    tracer = make_tracer(
        scene, reach, senders.elements, emission, senders.sight.tolerance, recipe, lights_of(scene)
    )
    return tracer, chains_of(tracer, reach, recipe, constant, progress, known)


def _of(values, own):
    return None if values is None else values[own]


def _system(terms, factors, entering, own, width, sheets, chains) -> System:
    """Return the equations of the coefficients of patches ``own``."""
    rho = np.tile(terms.reflectance[own], (width, 1))
    source = rho * entering
    if sheets is not None:
        source += sheets.passed(entering)
    source[: len(own)] += terms.emission[own]
    absorptance = np.tile(terms.absorptance[own], (width, 1))
    return System(factors, rho, absorptance, source, sheets, chains)
