"""From solved radiosities to what rays that look around meet."""

from typing import TYPE_CHECKING

import numpy as np

from radiosity.scene.model import Scene
from radiosity.solve.reach import Reach
from radiosity.solve.system import side_reflectance, textured_sides
from radiosity.transport.irradiance import FINER, Field, Lights, Surroundings
from radiosity.transport.shine import shine

if TYPE_CHECKING:
    from radiosity.transport.tracer import Tracer


def surroundings_of(
    scene: Scene, reach: Reach, lights: Lights, value: np.ndarray, slopes: np.ndarray,
    seed: int, finely: bool, tracer: "Tracer | None" = None,
) -> Surroundings:  # fmt: skip
    """Return lights, lit patches and the outside as rays meet them.

    Parameters
    ----------
    value, slopes : (n, bands), (n, bands, 3) float64
        What patches send out in W/m2 beside what the lights emit, and its gradients.
    finely : bool
        Light that comes straight from lights changes fast at shadow edges, so it is computed
        anew on a finer grid; ``value`` is what has been reflected more often.
    """
    patches = reach.patches
    direct = np.zeros((2, 0, value.shape[1]))
    if finely and lights:
        arriving, face = shine(
            scene.faces, patches, reach.live, reach.visibility, reach.table, lights, seed
        )
        direct = side_reflectance(scene)[:, scene.faces.material[face]]
        textured = textured_sides(scene)[:, scene.faces.material[face]]
        if textured.any():
            from radiosity.solve.texturing import textured_reflectance

            cells = patches.grid.division.divided(FINER).cells(scene.faces)
            for side, mine in zip(direct, textured, strict=True):
                side[mine] = textured_reflectance(scene, reach.table, face[mine], cells[mine])
        direct = direct * arriving
    row = np.full((patches.fronts, 2), -1)
    row[:, 0] = np.where(reach.live[: patches.fronts], np.arange(patches.fronts), -1)
    row[:, 1] = patches.back_of
    outside = np.pi * scene.ambient
    field = Field(row.ravel(), value, slopes, patches.centroid, outside, direct)
    made = reach.visibility, reach.table, field, lights
    known = tracer is not None and (tracer.images or tracer.caustics is not None)
    return Surroundings(*made, tracer and tracer.space, tracer if known else None)
