"""Sampling directions by mirroring the view in facets that it sees, were they sides of grooves."""

import numpy as np

from radiosity.light.frames import halfway, polar

_FLIPS = 4096.0  # the lower digits of the second coordinate choose between a facet and its twin


def mirrored_view(cosine, u, to_view):
    """Return directions (..., 3) in which facets of given cos(alpha) mirror the view.

    A facet, or the other side of its groove, is taken in proportion to how much of each is seen,
    so that none is seen from behind. *Heitz & d'Eon (2014), "Importance sampling microfacet-based
    BSDFs using the distribution of visible normals"*, for V-cavities.

    Parameters
    ----------
    cosine, u : (...)
        N.H of the facet, and a number in [0, 1) that gives its azimuth.
    to_view : (..., 3)
    """
    half = polar(cosine, 2.0 * np.pi * u)
    twin = half * [-1.0, -1.0, 1.0]
    seen, other = (np.maximum(np.sum(h * to_view, axis=-1), 0.0) for h in (half, twin))
    flip = (u * _FLIPS) % 1.0 * (seen + other) >= seen
    half = np.where(flip[..., None], twin, half)
    across = np.where(flip, other, seen)
    return 2.0 * across[..., None] * half - to_view


def mirrored_density(chosen, to_view, directions):
    """Return the density (...) per steradian of `mirrored_view`.

    q(H)/4 min(1/((N.V)(N.H)), 2/(V.H)), with q the density of facets that ``chosen`` returns for
    their cosines.
    """
    half, across = halfway(directions, to_view)
    up, view = half[..., 2], np.maximum(np.asarray(to_view)[..., 2], 0.0)
    least = np.maximum(np.maximum(view * up, across / 2.0), 1e-300)
    density = chosen(np.clip(up, 0.0, 1.0)) / (4.0 * least)
    return np.where((up > 0.0) & (across > 0.0), density, 0.0)
