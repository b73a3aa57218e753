"""Sampling directions by mirroring the view in facets that it sees."""

import numpy as np

from radiosity.light.frames import halfway, polar

# Periods of the second coordinate that choose between a facet and its twin; no whole number of them
# fits between points of a regular pattern, so that these do not all choose alike.
_FLIPS = 1063.553


def mirrored_view(cosine, u, to_view):
    """Return directions (..., 3) in which facets of given cos(alpha) mirror the view, as grooves.

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


def ellipsoid_view(roughness, u, to_view):
    """Return directions (..., 3) in which facets of Trowbridge & Reitz mirror the view.

    They are chosen as Smith's shadowing lets them be seen: stretched to half a sphere, they
    project along the view to half a disk and half an ellipse. *Heitz (2018), "Sampling the GGX
    distribution of visible normals"*.

    Parameters
    ----------
    roughness : float or (...)
    u : (..., 2)
    to_view : (..., 3)
    """
    m = np.asarray(roughness, dtype=np.float64)[..., None]
    stretch = np.concatenate([m, m, np.ones_like(m)], axis=-1)
    v = stretch * to_view
    v = v / np.linalg.norm(v, axis=-1, keepdims=True)
    across = np.stack([-v[..., 1], v[..., 0], np.zeros_like(v[..., 0])], axis=-1)
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.where(length > 0, across / np.where(length > 0, length, 1.0), [1.0, 0.0, 0.0])
    radius, phi = np.sqrt(u[..., :1]), 2.0 * np.pi * u[..., 1:]
    x, share = radius * np.cos(phi), (1.0 + v[..., 2:]) / 2.0
    y = (1.0 - share) * np.sqrt(1.0 - x**2) + share * radius * np.sin(phi)
    z = np.sqrt(np.maximum(0.0, 1.0 - x**2 - y**2))
    half = (x * across + y * np.cross(v, across) + z * v) * stretch
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    return 2.0 * np.sum(half * to_view, axis=-1, keepdims=True) * half - to_view
