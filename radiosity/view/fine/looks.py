"""What surfaces do to light, as the fine mesh shows them: matte, whatever they are."""

from dataclasses import dataclass, replace

import numpy as np

from radiosity.scene.model import Material, Scene
from radiosity.solve.albedo import sent_on
from radiosity.solve.system import side_reflectance, translucent

CLEAREST = 0.25  # of a surface that lets all light through, what is left to be seen


@dataclass(frozen=True)
class Looks:
    """What each material does to light in its place.

    Attributes
    ----------
    reflects : (2, materials, bands) float64
        Of fronts and backs: evenly, with what lobes and mirrors return as if that were even too.
    passes : (materials, bands) float64
        Evenly, to the other side.
    opacity : (materials,) float64
        1 but for what clear materials let through along single directions.
    """

    reflects: np.ndarray
    passes: np.ndarray
    opacity: np.ndarray


def looks_of(scene: Scene) -> Looks:
    """Return what the materials of a scene look like."""
    returned = [sent_on(replace(m, transmit=None)) for m in scene.materials]
    sides = side_reflectance(scene)
    both = np.array([[True, m.two_sided] for m in scene.materials]).T
    sides = sides + both[..., None] * np.reshape(returned, sides[0].shape)
    clear = [_clear(m) for m in scene.materials]
    opacity = np.maximum(1.0 - np.array(clear), CLEAREST)
    return Looks(np.minimum(sides, 1.0), translucent(scene), opacity)


def _clear(material: Material) -> float:
    """Return the share of diffuse light that goes through along single directions."""
    passage = material.transmit
    return 0.0 if passage is None else float(np.mean(passage.mean_albedo))
