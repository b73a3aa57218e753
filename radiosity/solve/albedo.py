"""Albedo of a material under diffuse light: what it sends back, in all and evenly."""

import numpy as np

from radiosity.scene.model import Material


def reflectance_of(material: Material) -> np.ndarray:
    """Return the (bands,) share of diffuse light that a material sends back.

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


def spread_evenly(material: Material) -> np.ndarray:
    """Return the (bands,) reflectance of all that is spread evenly."""
    if material.mirror is None:
        return material.diffuse
    mirrored = material.mirror.mean_albedo
    left = 1.0 - mirrored if material.mirror in material.coats else 1.0
    return mirrored + material.diffuse * left
