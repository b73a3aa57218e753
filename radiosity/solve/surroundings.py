"""From a solved level to what rays that look around meet."""

import numpy as np

from radiosity.mesh.interpolation import find_neighbours, gradients
from radiosity.solve.level import Level
from radiosity.solve.system import area_lights, side_reflectance
from radiosity.transport.irradiance import Field, Surroundings
from radiosity.transport.shine import shine


def make_surroundings(level: Level, seed: int) -> Surroundings:
    """Return lights, lit patches and the outside as rays meet them.

    Light that comes straight from area lights changes fast at shadow edges, so it is computed
    anew on a finer grid; only what has been reflected more often is taken from the patches.
    """
    scene, reach, terms = level.scene, level.reach, level.terms
    patches = reach.patches
    lights = area_lights(scene)
    value, direct = level.coefficients, np.zeros((2, 0, terms.emission.shape[1]))
    if len(lights.polygons):
        value = value - level.emitted - level.reflected(level.emitted)
        arriving, face = shine(
            scene.faces, patches, reach.live, reach.visibility, reach.table, lights, seed
        )
        direct = side_reflectance(scene)[:, scene.faces.material[face]] * arriving
    row = np.full((patches.fronts, 2), -1)
    row[:, 0] = np.where(reach.live[: patches.fronts], np.arange(patches.fronts), -1)
    row[:, 1] = patches.back_of
    field = Field(
        row.ravel(), level.on_patches(value), _slopes(level, value), patches.centroid,
        np.pi * scene.ambient, direct,
    )  # fmt: skip
    return Surroundings(reach.visibility, reach.table, field, lights)


def _slopes(level, value):
    """Return (n, bands, 3) gradients: those of the elements, of constant ones from neighbours."""
    patches, live = level.reach.patches, level.reach.live
    if level.senders.elements.order == 0:
        around = find_neighbours(patches, live, level.scene.faces.material[patches.face])
        return gradients(patches, around, level.on_patches(value))
    slopes = np.zeros((len(patches), value.shape[1], 3))
    slopes[level.rows] = level.senders.elements.gradients(value)
    return slopes
