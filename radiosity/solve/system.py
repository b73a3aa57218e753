"""From a scene's materials to the terms of the radiosity system, a patch and band each."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.reflection import phong_albedo
from radiosity.mesh.patches import Patches
from radiosity.scene.model import Material, Scene
from radiosity.transport.irradiance import AreaLights
from radiosity.transport.lookup import make_table

MOST_LIGHTS = 32  # more emitting faces than this are not sampled one by one


@dataclass(frozen=True)
class Terms:
    """Per patch: reflectance rho, 1 - rho and emission M_e, (n, 3); dead patches are black."""

    reflectance: np.ndarray
    absorptance: np.ndarray
    emission: np.ndarray


def reflectance_of(material: Material) -> np.ndarray:
    """Return the (3,) share of diffuse light that a material sends back.

    A specular lobe counts with its albedo under diffuse light, spread evenly.
    """
    rho = material.diffuse
    if material.specular is not None:
        lobe = material.specular
        rho = rho + lobe.reflectance * _mean_albedo(lobe.exponent)
    return rho


def _mean_albedo(exponent: float) -> float:
    """Return the albedo of a unit Phong lobe under diffuse light, 2 int a(c) c dc."""
    x, w = np.polynomial.legendre.leggauss(32)
    cosine = (x + 1) / 2
    return float(w @ (phong_albedo(exponent, cosine) * cosine))


def make_terms(scene: Scene, patches: Patches, live: np.ndarray) -> Terms:
    """Return reflectance and emission of every patch; backs reflect only where two-sided."""
    material = scene.faces.material[patches.face]
    side = np.where(patches.front, 0, 1)
    rho = side_reflectance(scene)[side, material]
    absorptance = np.where(rho > 0.0, _absorptance(scene)[material], 1.0)
    textured = textured_sides(scene)[side, material]
    if textured.any():
        from radiosity.solve.texturing import textured_reflectance

        table, where = make_table(scene.faces, patches), patches.face[textured]
        rho[textured] = textured_reflectance(scene, table, where, patches.vertices[textured])
        absorptance[textured] = 1.0 - rho[textured]
    emission = np.pi * np.array([m.emission for m in scene.materials])[material]
    rho[~live], absorptance[~live] = 0.0, 1.0
    emission[~live | ~patches.front] = 0.0
    return Terms(rho, absorptance, emission)


def textured_sides(scene: Scene) -> np.ndarray:
    """Return (2, materials) bool: whose fronts, and whose backs, reflect as a texture tells."""
    front = np.array([m.texture is not None for m in scene.materials], bool)
    return np.stack([front, front & np.array([m.two_sided for m in scene.materials], bool)])


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
