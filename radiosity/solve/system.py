"""From a scene's materials to the terms of the radiosity system, a patch and band each."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.patches import Patches
from radiosity.scene.model import Material, Scene
from radiosity.transport.irradiance import AreaLights

MOST_LIGHTS = 32  # more emitting faces than this are not sampled one by one


@dataclass(frozen=True)
class Terms:
    """Per patch: reflectance rho, 1 - rho and emission M_e, (n, 3); dead patches are black."""

    reflectance: np.ndarray
    absorptance: np.ndarray
    emission: np.ndarray


def reflectance_of(material: Material) -> np.ndarray:
    """Return the (3,) share of diffuse light that a material sends back.

    What lobes and mirrors return counts with their albedo a under diffuse light, spread evenly:
    rho + a, or a + rho (1 - a) of a base under a clear coat. What goes through is lost.
    """
    rho = material.diffuse
    for part in (material.specular, material.mirror):
        if part is not None and part not in material.coats:
            rho = rho + part.mean_albedo
    if material.coats:
        upon = sum(coat.mean_albedo for coat in material.coats)
        rho = upon + rho * (1.0 - upon)
    return rho


def make_terms(scene: Scene, patches: Patches, live: np.ndarray) -> Terms:
    """Return reflectance and emission of every patch; backs reflect only where two-sided."""
    material = scene.faces.material[patches.face]
    side = np.where(patches.front, 0, 1)
    rho = side_reflectance(scene)[side, material]
    absorptance = np.where(rho > 0.0, _absorptance(scene)[material], 1.0)
    emission = np.pi * np.array([m.emission for m in scene.materials])[material]
    rho[~live], absorptance[~live] = 0.0, 1.0
    emission[~live | ~patches.front] = 0.0
    return Terms(rho, absorptance, emission)


def _absorptance(scene: Scene) -> np.ndarray:
    """Return (materials, 3): 1 - reflectance, with the digits that a material gives it."""
    diffuse = np.array([m.diffuse for m in scene.materials]).reshape(-1, 3)
    given = np.array([m.absorptance for m in scene.materials]).reshape(-1, 3)
    lobes = side_reflectance(scene)[0] - diffuse
    return given - lobes


def side_reflectance(scene: Scene) -> np.ndarray:
    """Return (2, materials, 3): reflectance of the fronts and the backs of each material."""
    front = np.array([reflectance_of(m) for m in scene.materials]).reshape(-1, 3)
    two_sided = np.array([m.two_sided for m in scene.materials])
    return np.stack([front, front * two_sided[:, None]])


def area_lights(scene: Scene, most: int = MOST_LIGHTS) -> AreaLights:
    """Return the emitting faces to sample one by one: all of them, or none where above ``most``."""
    emits = np.array([m.emits for m in scene.materials])[scene.faces.material]
    which = np.flatnonzero(emits)
    if len(which) > most:
        which = which[:0]
    exitance = np.pi * np.array([m.emission for m in scene.materials])[scene.faces.material]
    return AreaLights(scene.faces.vertices[which], scene.faces.normals()[which], exitance[which])
