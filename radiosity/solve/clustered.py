"""One mesh of many small patches, solved: light between clusters, their details from the lights.

Light that comes straight from its sources is computed on every patch. What has been reflected
varies slowly, so it is exchanged between clusters of patches, whose factors rays count, and sent
down to their patches: F = Push L Pull, with L between clusters, Pull the mean over a cluster and
Push the same irradiance for all of its patches.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from radiosity.mesh.clusters import make_clusters
from radiosity.mesh.elements import make_elements
from radiosity.scene.model import Scene
from radiosity.solve.equations import System, sheets_of
from radiosity.solve.fading import suited
from radiosity.solve.level import Kept, from_outside
from radiosity.solve.methods import solve_bands
from radiosity.solve.plan import Recipe
from radiosity.solve.reach import Reach
from radiosity.solve.surroundings import surroundings_of
from radiosity.solve.system import Terms, lights_of, make_terms, side_reflectance, translucent
from radiosity.transport.arrival import Arrival
from radiosity.transport.closure import repaired
from radiosity.transport.counting import count_rays, counted_factors
from radiosity.transport.irradiance import (
    Lights,
    Surroundings,
    direct_irradiance,
    indirect_irradiance,
)
from radiosity.transport.lamps import lamps_on
from radiosity.transport.operator import FormFactors
from radiosity.transport.threads import Progress, over_ranges, silent

if TYPE_CHECKING:
    from radiosity.transport.chains import Chains
    from radiosity.transport.tracer import Tracer

LIGHT_RAYS = 16  # to each face that emits from the middle of a patch
MOST_LIGHTS = 512  # found by chance, more faces that emit than these would be noise
CHUNK = 4096
RAYS = 64, 1 << 16  # from a cluster, the fewest and the most
POINTS_AT_ONCE = 65536
GATHER = 3.0  # standard errors of half the difference of two halves of the rays


@dataclass(frozen=True)
class Clustered:
    """A solved mesh of clusters, with what `Level` has.

    Attributes
    ----------
    labels : (m,) int
        Cluster of each live patch.
    factors : FormFactors
        Between clusters.
    straight : (m, bands) float64
        Irradiance on each live patch that comes straight from faces that emit, W/m2.
    lamplight : (m, bands) float64
        The same of abstract light sources.
    coefficients, arriving : (m, bands) float64
        Radiosity and irradiance of the live patches, W/m2.
    outside : (m,) float64
        Factors of the live patches' clusters to the outside.
    half : FormFactors, optional
        Between clusters, not closed, by half of the rays.
    chains, tracer : Chains, Tracer, optional
        What comes to clusters by way of mirrors, clear bodies and lobes.
    kept : Kept, optional
        In place of what labels, factors and ``chains`` tell of the answer, which are None then.
    """

    scene: Scene
    reach: Reach
    terms: Terms
    recipe: Recipe
    labels: np.ndarray | None
    factors: FormFactors | None
    lights: Lights
    straight: np.ndarray
    lamplight: np.ndarray
    coefficients: np.ndarray
    arriving: np.ndarray
    outside: np.ndarray
    history: list
    solver: str
    half: FormFactors | None = None
    chains: "Chains | None" = None
    tracer: "Tracer | None" = None
    kept: Kept | None = None

    @property
    def rows(self) -> np.ndarray:
        """Return (m,) the live patches."""
        return np.flatnonzero(self.reach.live)

    def on_patches(self, values: np.ndarray) -> np.ndarray:
        """Return (n, bands) values of all patches, 0 where dark."""
        full = np.zeros((len(self.reach.live), values.shape[1]))
        full[self.rows] = values
        return full

    @property
    def entering(self) -> np.ndarray:
        """Return (m, bands): the irradiance of the live patches that no patch sends, W/m2."""
        return from_outside(self.scene, self.outside) + self.lamplight

    @property
    def escaping(self) -> np.ndarray:
        """Return (m, bands): the radiosity of each live patch that leaves the scene, W/m2."""
        if self.kept is not None:
            return self.kept.escaping
        gone = self.outside[:, None]
        if self.chains is not None:
            gone = gone + self.chains.escaping[self.labels]
        return self.coefficients * gone

    @cached_property
    def surroundings(self) -> Surroundings:
        """Return what rays that look around meet; lights are left to be sampled by themselves."""
        value = self.coefficients
        if len(self.lights.polygons):
            value = value - self.terms.emission[self.rows]
        flat = np.zeros((len(self.reach.patches), value.shape[1], 3))
        return surroundings_of(
            self.scene, self.reach, self.lights, self.on_patches(value), flat, self.recipe.seed,
            False, self.tracer,
        )  # fmt: skip

    def gathered(
        self, points: np.ndarray, normals: np.ndarray, progress: Progress = silent
    ) -> Arrival:
        """Return the irradiance (k, bands) in W/m2 at points, by rays, and its standard error."""
        around, seed = self.surroundings, self.recipe.seed
        half, k = self.recipe.rays // 2, len(points)
        total, error = np.empty((2, k, self.coefficients.shape[1]))

        def work(a, b):
            keys = np.arange(a, b)
            here = points[a:b], normals[a:b], keys
            one, two = (
                indirect_irradiance(around, *here, some, seed)[0]
                + direct_irradiance(
                    around.visibility, self.lights, *here, range(some.start // 4, some.stop // 4),
                    seed,
                )
                for some in (range(half), range(half, 2 * half))
            )  # fmt: skip
            total[a:b], error[a:b] = (one + two) / 2.0, GATHER / 2.0 * np.abs(one - two) / 2.0
            if around.tracer is not None and around.tracer.caustics is not None:
                more, noise = around.tracer.caustics.at(points[a:b], normals[a:b])
                total[a:b] += more
                error[a:b] = np.hypot(error[a:b], noise)

        over_ranges(work, k, max(1, POINTS_AT_ONCE // (2 * half)), "irradiance", progress)
        return Arrival(total, error, np.ones(k))


def solve_clusters(
    scene: Scene, reach: Reach, recipe: Recipe, clusters: int, progress: Progress = silent,
    watch: Callable[[Clustered], None] | None = None,
) -> Clustered:  # fmt: skip
    """Solve a mesh of many patches by so many clusters; see `solve_level` for what it raises."""
    patches, rows = reach.patches, np.flatnonzero(reach.live)
    labels = make_clusters(patches, rows, _kinds(scene, patches, rows), clusters)
    n = labels.max(initial=-1) + 1
    half = int(np.clip(recipe.counted // max(1, n), *RAYS)) // 2
    area = np.bincount(labels, patches.area[rows], n)
    one, two = (
        count_rays(patches, rows, labels, reach.visibility, reach.table, some, recipe.seed,
                   progress)
        for some in (range(half), range(half, 2 * half))
    )  # fmt: skip
    factors = repaired(counted_factors(one + two, area, 2 * half))
    made = _lit(scene, reach, recipe, labels, factors, None, progress, watch)
    return replace(made, half=counted_factors(one, area, half))


def under_other_light(level: Clustered, scene: Scene, progress: Progress = silent) -> Clustered:
    """Return the same clusters, solved for a scene of the same surfaces under other light."""
    made = level.reach, level.recipe, level.labels, level.factors, level.chains
    return replace(_lit(scene, *made, progress, None), half=level.half)


def _lit(scene, reach, recipe, labels, factors, known, progress, watch) -> Clustered:
    """Solve a scene by the factors of its clusters; see `find_chains` for what is ``known``."""
    rows = np.flatnonzero(reach.live)
    terms, lights = make_terms(scene, reach.patches, reach.live), lights_of(scene, MOST_LIGHTS)
    straight = _straight(reach, rows, lights.without_lamps(), recipe.seed, progress)
    lamplight = _lamplight(reach, rows, lights)
    tracer, chains = _chains(scene, reach, terms.emission[rows], recipe, labels, lights, known)
    made = solved(
        scene, reach, recipe, terms, lights, labels, factors, straight, lamplight, chains, watch
    )
    return replace(made, tracer=tracer)


def coarser(level: Clustered, clusters: int) -> Clustered:
    """Return the same with fewer clusters and half of the rays that counted their factors."""
    patches, rows = level.reach.patches, level.rows
    labels = make_clusters(patches, rows, _kinds(level.scene, patches, rows), clusters)
    n = level.labels.max(initial=-1) + 1
    above = np.zeros(n, int)  # a cluster goes where its first patch goes
    above[level.labels[::-1]] = labels[::-1]
    above = np.unique(above, return_inverse=True)[1]
    return grouped(level, above, repaired(level.half.grouped(above)))


def grouped(level: Clustered, above: np.ndarray, factors: FormFactors) -> Clustered:
    """Return the same with its clusters in groups ``above`` (clusters,) of these factors."""
    parts, chains = (level.scene, level.reach, level.recipe, level.terms, level.lights), None
    if level.chains is not None:
        area = np.bincount(level.labels, level.reach.patches.area[level.rows], len(above))
        chains = level.chains.grouped(above, area)
    made = solved(*parts, above[level.labels], factors, level.straight, level.lamplight, chains)
    return replace(made, tracer=level.tracer)


def _chains(scene, reach, emission, recipe, labels, lights, known):
    """Return what follows light along single directions, and what it found; None where none is."""
    if not scene.sends_on:
        return None, None
    from radiosity.solve.chains import cluster_chains_of  # others need none of it

    return cluster_chains_of(scene, reach, emission, recipe, labels, lights, known)


def _kinds(scene, patches, rows):
    """Return (m,) int: what patches reflect and let through, of textures the means over all."""
    rho, tau = side_reflectance(scene), translucent(scene)
    laws = np.concatenate([rho, np.broadcast_to(tau, rho.shape)], axis=2)
    kind = np.unique(laws.reshape(-1, laws.shape[2]), axis=0, return_inverse=True)[1]
    side, material = np.where(patches.front[rows], 0, 1), scene.faces.material[patches.face[rows]]
    return kind.reshape(2, -1)[side, material]


def _straight(reach, rows, lights, seed, progress):
    """Return (m, bands): what comes straight from polygons that emit in the middles of patches."""
    patches, found = reach.patches, np.zeros((len(rows), lights.exitance.shape[1]))

    def work(a, b):
        r = rows[a:b]
        found[a:b] = direct_irradiance(
            reach.visibility, lights, patches.centroid[r], patches.normal[r], r, range(LIGHT_RAYS),
            seed,
        )  # fmt: skip

    if lights:
        over_ranges(work, len(rows), CHUNK, "direct light", progress)
    return found


def _lamplight(reach, rows, lights):
    """Return (m, bands): the mean over each patch of what abstract sources send."""
    if not lights.lamps:
        return np.zeros((len(rows), lights.exitance.shape[1]))
    elements = make_elements(reach.patches, rows, 0)
    return lamps_on(reach.visibility, lights.lamps, elements, lights.unit_m)


def _scaled(straight, area, stays):
    """Return straight light (m, bands), scaled so that its power is what ``stays`` (bands,)."""
    arrived = np.sum(area[:, None] * straight, axis=0)
    known = (arrived > 0) & (stays > 0)
    return straight * np.divide(stays, arrived, out=np.ones_like(arrived), where=known)


def solved(
    scene, reach, recipe, terms, lights, labels, factors, straight, lamplight, chains=None,
    watch=None,
) -> Clustered:
    """Solve the system of clusters and send its light down to the patches.

    What is reflected of the light that comes straight from faces is scaled to the power that leaves
    them and stays, so that none is lost or made, in all, however often it is reflected.
    """
    patches, rows = reach.patches, np.flatnonzero(reach.live)
    area, n = patches.area[rows], labels.max(initial=-1) + 1
    rho, emission = terms.reflectance[rows], terms.emission[rows]
    own = 0.0 if len(lights.polygons) else emission
    outside = factors.environment[labels]
    entering = from_outside(scene, outside) + lamplight
    if chains is not None:
        entering = entering + chains.entering(scene.ambient)[labels]

    def pulled(x):
        return np.stack([np.bincount(labels, area * x[:, b], n) for b in range(x.shape[1])], axis=1)

    def mean(x):
        return pulled(x) / np.bincount(labels, area, n)[:, None]

    kept = _scaled(straight, area, (1.0 - factors.loss) @ pulled(emission - own))
    sheets = None
    if terms.transmittance is not None:
        sheets = sheets_of(terms, make_elements(patches, rows, 0), rows)

    def scattered(e):
        return rho * e if sheets is None else rho * e + sheets.passed(e)

    source = mean(own + scattered(kept + entering))
    through = sheets and sheets.grouped(labels, area, n)
    system = System(factors, mean(rho), mean(terms.absorptance[rows]), source, through, chains)
    onwards = None if terms.sent_on is None else mean(terms.sent_on[rows])
    solver = suited(recipe.solver, system, np.ones(n, bool), onwards)

    def level(b, history):
        e = straight + entering + system.arriving(b)[labels]
        return Clustered(
            scene, reach, terms, recipe, labels, factors, lights, straight, lamplight,
            emission + scattered(e), e, outside, history, solver, chains=chains,
        )  # fmt: skip

    seen = None if watch is None else lambda b: watch(level(b, []))
    return level(*solve_bands(solver, system, recipe.tolerance, recipe.force, seen))
