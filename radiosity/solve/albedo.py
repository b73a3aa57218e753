"""Albedo of a material under diffuse light: what it sends back evenly, and what along rays."""

import math

import numpy as np

from radiosity.scene.model import Material


def reflectance_of(material: Material) -> np.ndarray:
    """Return the (bands,) share of diffuse light that a material reflects evenly.

    rho, or rho (1 - a) under clear coats of the albedo a: what lobes and mirrors return and what
    goes through is followed by itself (`radiosity.transport.chains`).
    """
    return material.diffuse * let_in(material)


def let_in(material: Material) -> np.ndarray | float:
    """Return the (bands,) share of diffuse light that a material's coats let through."""
    return math.prod(1.0 - c.mean_albedo for c in material.coats)


def sent_on(material: Material) -> np.ndarray:
    """Return the (bands,) share of diffuse light that goes on along single directions."""
    lobe, below = material.specular, [material.mirror, material.transmit]
    found = np.zeros_like(material.diffuse)
    for part in below:
        if part is not None:
            found = found + part.mean_albedo
    if lobe is None:
        return found
    from radiosity.light.coat import is_coat, layered  # others need none of it

    return layered(found, lobe.mean_albedo, is_coat(lobe))
