"""Albedo of a material under diffuse light: what it sends back, in all and evenly."""

import numpy as np

from radiosity.scene.model import Material


def reflectance_of(material: Material) -> np.ndarray:
    """Return the (bands,) share of diffuse light that a material sends back.

    What lobes and mirrors return counts with their albedo a under diffuse light, spread evenly:
    rho + a, or a + rho (1 - a) of what lies under a clear coat. What goes through is lost.
    """
    return _with(spread_evenly(material), material.specular)


def spread_evenly(material: Material) -> np.ndarray:
    """Return the (bands,) reflectance of all that is spread evenly: the base under a mirror."""
    return _with(material.diffuse, material.mirror)


def let_in(material: Material) -> np.ndarray | float:
    """Return the (bands,) share of diffuse light that a material's coats let through."""
    return np.prod([1.0 - c.mean_albedo for c in material.coats], axis=0)


def _with(base, part):
    if part is None:
        return base
    from radiosity.light.coat import is_coat, layered  # others need none of it

    return layered(base, part.mean_albedo, is_coat(part))
