"""From a scene's materials to the terms of the radiosity system, a patch and band each."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.patches import Patches
from radiosity.scene.model import Scene
from radiosity.solve.albedo import let_in, reflectance_of, sent_on
from radiosity.transport.irradiance import Lights
from radiosity.transport.lookup import make_table

MOST_LIGHTS = 32  # more emitting faces than this are not sampled one by one


@dataclass(frozen=True)
class Terms:
    """Per patch: reflectance, what is absorbed and emission M_e, (n, bands); dead ones are black.

    What goes on along single directions is among what is absorbed; ``sent_on`` (n, bands) is its
    share of diffuse light, None where there is none.
    ``transmittance`` (n, bands) goes through to the patch ``twin`` (n,) on the other side; both are
    None where nothing is translucent.
    """

    reflectance: np.ndarray
    absorptance: np.ndarray
    emission: np.ndarray
    transmittance: np.ndarray | None = None
    twin: np.ndarray | None = None
    sent_on: np.ndarray | None = None


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
    through, onwards = _through(scene, patches, live), None
    if scene.sends_on:
        onwards = np.array([sent_on(m) for m in scene.materials])[material]
        onwards[~live | ~(patches.front | _two_sided(scene)[material])] = 0.0
    if through is None:
        return Terms(rho, absorptance, emission, sent_on=onwards)
    return Terms(rho, absorptance - through[0], emission, *through, onwards)


def _through(scene, patches, live):
    """Return (n, bands) what goes through patches, and (n,) to which; None where nothing does."""
    tau = translucent(scene)
    if not tau[scene.faces.material].any():
        return None
    twin = np.append(patches.back_of, patches.front_of[patches.fronts :])
    passes = live & (twin >= 0) & live[twin]
    return np.where(passes[:, None], tau[scene.faces.material[patches.face]], 0.0), twin


def translucent(scene: Scene) -> np.ndarray:
    """Return (materials, bands): the share of diffuse light that comes out of the other side.

    Of a sheet under clear coats what they let in, tau (1 - a).
    """
    found = np.zeros((len(scene.materials), scene.bands.count))
    for k, m in enumerate(scene.materials):
        if m.translucent is not None:
            found[k] = m.translucent * let_in(m)
    return found


def textured_sides(scene: Scene) -> np.ndarray:
    """Return (2, materials) bool: whose fronts, and whose backs, reflect as a texture tells."""
    front = np.array([m.texture is not None for m in scene.materials], bool)
    return np.stack([front, front & _two_sided(scene)])


def _absorptance(scene: Scene) -> np.ndarray:
    """Return (materials, bands): 1 - reflectance, with the digits that a material gives it."""
    diffuse = np.array([m.diffuse for m in scene.materials]).reshape(-1, scene.bands.count)
    given = np.array([m.absorptance for m in scene.materials]).reshape(-1, scene.bands.count)
    lobes = side_reflectance(scene)[0] - diffuse
    return given - lobes


def side_reflectance(scene: Scene) -> np.ndarray:
    """Return (2, materials, bands): reflectance of the fronts and the backs of each material."""
    front = np.array([reflectance_of(m) for m in scene.materials]).reshape(-1, scene.bands.count)
    return np.stack([front, front * _two_sided(scene)[:, None]])


def _two_sided(scene):
    return np.array([m.two_sided for m in scene.materials], bool)


def goes_through(scene: Scene) -> np.ndarray:
    """Return (materials,) bool: through which some light gets to the other side."""
    clear = np.array([m.transmit is not None for m in scene.materials], bool)
    return clear | translucent(scene).any(axis=1)


def lights_of(scene: Scene, most: int = MOST_LIGHTS) -> Lights:
    """Return the lights to sample one by one, of the emitting faces none where above ``most``."""
    emits = np.array([m.emits for m in scene.materials])[scene.faces.material]
    which = np.flatnonzero(emits)
    if len(which) > most:
        which = which[:0]
    exitance = np.pi * np.array([m.emission for m in scene.materials])[scene.faces.material]
    return Lights(
        scene.faces.vertices[which], scene.faces.normals()[which], exitance[which], scene.lights,
        scene.unit_m, which,
    )  # fmt: skip
