"""From a solved system to what rays that look around meet."""

import numpy as np

from radiosity.mesh.interpolation import find_neighbours, gradients
from radiosity.scene.model import Scene
from radiosity.solve.reach import Reach
from radiosity.solve.system import Terms, area_lights, side_reflectance
from radiosity.transport.irradiance import Field, Surroundings
from radiosity.transport.operator import FormFactors
from radiosity.transport.shine import shine


def make_surroundings(
    scene: Scene, reach: Reach, terms: Terms, factors: FormFactors, b: np.ndarray, seed: int
) -> Surroundings:
    """Return lights, lit patches and the outside as rays meet them.

    Light that comes straight from area lights changes fast at shadow edges, so it is computed
    anew on a finer grid; only what has been reflected more often is taken from the patches.
    """
    patches = reach.patches
    lights = area_lights(scene)
    value, direct = b, np.zeros((2, 0, b.shape[1]))
    if len(lights.polygons):
        value = b - terms.emission - terms.reflectance * (factors @ terms.emission)
        arriving, face = shine(
            scene.faces, patches, reach.live, reach.visibility, reach.table, lights, seed
        )
        direct = side_reflectance(scene)[:, scene.faces.material[face]] * arriving
    around = find_neighbours(patches, reach.live, scene.faces.material[patches.face])
    row = np.full((patches.fronts, 2), -1)
    row[:, 0] = np.where(reach.live[: patches.fronts], np.arange(patches.fronts), -1)
    row[:, 1] = patches.back_of
    field = Field(
        row.ravel(), value, gradients(patches, around, value), patches.centroid,
        np.pi * scene.ambient, direct,
    )  # fmt: skip
    return Surroundings(reach.visibility, reach.table, field, lights)
