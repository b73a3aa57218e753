"""What a scene's mirrors, clear bodies and lobes carry between the elements of a mesh (E23)."""

from typing import TYPE_CHECKING

import numpy as np

from radiosity.mesh.elements import Elements, make_elements, make_nodes
from radiosity.scene.model import Scene
from radiosity.solve.optics import make_optics
from radiosity.solve.plan import Recipe
from radiosity.solve.reach import Reach
from radiosity.solve.system import lights_of
from radiosity.transport.aiming import make_targets
from radiosity.transport.arrival import Arrival
from radiosity.transport.caustics import FEWEST, MOST, find_caustics
from radiosity.transport.chains import Chains, cluster_chains, find_chains
from radiosity.transport.images import find_planes, make_images
from radiosity.transport.irradiance import Lights
from radiosity.transport.paths import Space
from radiosity.transport.threads import Progress, over_ranges
from radiosity.transport.tracer import Tracer
from radiosity.transport.visibility import LIFT

if TYPE_CHECKING:
    from radiosity.solve.clustered import Clustered
    from radiosity.solve.level import Level

AT_POINTS = 8  # rays from a point that is asked for, to those from a node
PARTS = 4  # that they are cast in, to tell their noise
MOST_TARGETS = 2000  # triangles that rays are aimed at, rather than all around
KEY = 1 << 45  # tells the patterns of points from those of nodes
RAYS = 64, 1 << 12  # from a cluster, the fewest and the most
LAMP_RAYS = 512  # from a lamp, to those from a node
RAYS_AT_ONCE = 1 << 15


def make_tracer(
    scene: Scene, reach: Reach, elements: Elements, emission: np.ndarray, tolerance: np.ndarray,
    recipe: Recipe, lights: Lights, exactly: bool = True,
) -> Tracer:  # fmt: skip
    """Return what follows light back to the elements of the live patches.

    ``emission`` (n, bands) is that of the elements, ``tolerance`` (n,) that of factors from points
    to them, see `make_senders`; ``exactly``: planar mirrors not by rays.
    """
    patches, rows = reach.patches, np.flatnonzero(reach.live)
    place = np.full(len(patches) + 1, -1)
    place[rows] = np.arange(len(rows))
    sides = np.stack([np.arange(patches.fronts), patches.back_of], axis=1)
    optics = make_optics(scene, reach.table)
    size = float(np.ptp(scene.faces.vertices, (0, 1)).max())
    planes = find_planes(scene.faces, patches, optics, size) if exactly else None
    space = Space(reach.visibility, reach.table, optics, planes)
    areas = np.zeros(len(scene.faces))
    emitted = emission if len(lights.polygons) else np.zeros_like(emission)
    face = patches.face[rows[emitted.any(axis=1)]]
    areas[face] = scene.faces.areas()[face]
    targets = make_targets(scene.faces, reach.visibility, optics.wanted())
    if len(targets.face) > MOST_TARGETS:
        targets = None
    images = ()
    if planes is not None:
        images = make_images(scene.faces, planes, elements, lights, tolerance)
    made = space, elements, place[sides.ravel()], lights, emitted, areas, recipe.seed
    return Tracer(*made, targets, images, _caustics(scene, space, recipe))


def tracer_of(level: "Level | Clustered") -> Tracer:
    """Return the tracer of a solved level, of its scene as it is now."""
    rows = np.flatnonzero(level.reach.live)
    made = level.scene, level.reach, make_elements(level.reach.patches, rows, level.recipe.order)
    emission, senders = level.terms.emission[rows], getattr(level, "senders", None)
    if senders is None:
        return make_tracer(*made, emission, np.zeros(0), level.recipe, level.lights, exactly=False)
    lights = lights_of(level.scene)
    return make_tracer(*made, emission, senders.sight.tolerance, level.recipe, lights)


def _caustics(scene, space, recipe):
    """Return the light of lamps by way of mirrors and clear bodies, None where there is none."""
    targets = make_targets(scene.faces, space.visibility, space.optics.wanted(lobes=False))
    if not scene.lights or not len(targets.face):
        return None
    area = float(scene.faces.areas().sum())
    rays = int(np.clip(LAMP_RAYS * recipe.chained, FEWEST, MOST))
    return find_caustics(space, targets, scene.lights, scene.unit_m, area, rays, recipe.seed)


def chains_of(
    tracer: Tracer, reach: Reach, recipe: Recipe, constant: bool, progress: Progress,
    known: Chains | None = None,
) -> Chains:
    """Return what arrives at the elements of the live patches by way of other surfaces.

    ``known`` are those of the same mesh under other light.
    """
    elements, rows = tracer.elements, np.flatnonzero(reach.live)
    linear = elements if elements.order == 1 else make_elements(reach.patches, rows, 1)
    found = find_chains(tracer, make_nodes(linear), recipe.chained, progress, known)
    return found.without_slopes(len(rows)) if constant else found


def cluster_chains_of(
    scene: Scene, reach: Reach, emission: np.ndarray, recipe: Recipe, labels: np.ndarray,
    lights: Lights, known: Chains | None = None,
) -> tuple[Tracer, Chains]:
    """Return what follows light back to live patches, and what comes so to their clusters."""
    rows = np.flatnonzero(reach.live)
    elements = make_elements(reach.patches, rows, 0)
    made = scene, reach, elements, emission, np.zeros(0), recipe, lights
    tracer = make_tracer(*made, exactly=False)
    rays = int(np.clip(recipe.counted // max(1, labels.max(initial=0) + 1), *RAYS))
    return tracer, cluster_chains(tracer, reach.patches, rows, labels, rays, known)


def arriving_by_chains(
    tracer: Tracer, coefficients: np.ndarray, ambient: np.ndarray, points: np.ndarray,
    normals: np.ndarray, rays: int,
) -> Arrival:  # fmt: skip
    """Return what arrives at points by way of other surfaces, (k, bands), and its standard error.

    Parameters
    ----------
    coefficients : (width n, bands) float64
        Of the radiosity of the elements.
    ambient : (bands,) float64
        Radiance of the outside.
    """
    k, bands = len(points), coefficients.shape[1]
    parts, exact, noise = np.zeros((PARTS, k, bands)), *np.zeros((2, k, bands))
    each, rest = rays // PARTS, tracer.beside_lights(coefficients)

    def work(a, b):
        exact[a:b] = tracer.lamplight(points[a:b], normals[a:b])
        if tracer.caustics is not None:
            more, noise[a:b] = tracer.caustics.at(points[a:b], normals[a:b])
            exact[a:b] += more
        for image in tracer.images:
            seen = image.weights(points[a:b], normals[a:b], a, LIFT, tracer.seed)
            exact[a:b] += image.share * (seen @ coefficients)
        keys = KEY + np.arange(a, b)
        for part in range(PARTS):
            some = range(part * each, (part + 1) * each)
            here = points[a:b], normals[a:b], keys, some
            parts[part, a:b] = _radiosity_seen(tracer, rest, ambient, *here)

    over_ranges(work, k, max(1, RAYS_AT_ONCE // each))
    error = parts.std(axis=0, ddof=1) / np.sqrt(PARTS)
    return Arrival(parts.mean(axis=0) + exact, np.hypot(error, noise), np.ones(k))


def _radiosity_seen(tracer, rest, ambient, points, normals, keys, samples):
    found = np.zeros((len(points), rest.shape[1]))
    for step in tracer.paths(points, normals, keys, samples):
        light = np.pi * tracer.straight(step)
        if step.bounce > 0:
            light += tracer.radiosity(step.ends, rest, ambient)
        np.add.at(found, step.owner, step.weight * light)
    return found
