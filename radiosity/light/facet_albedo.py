"""Albedo of facets: what they return of the light from one direction, integrated and tabulated."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from radiosity.light import fresnel
from radiosity.light.facets import LEAST_COSINE

COSINES = 160  # of a table
LEANS, TURNS = 36, 8  # quadrature nodes over each of three parts of alpha, five of the azimuth
LEAST = 1e-9  # cosine of the table's grazing end
ROUGHNESSES = np.geomspace(1e-4, 1.0, 41)  # of the tables between which others lie


def facet_albedo(facets, shadowing, index, cosine, leans=LEANS, turns=TURNS):
    """Return int f cos(theta_l) dw of Torrance-Sparrow facets, (k, bands).

    With dw = 4 (V.H) dw_H it is int D F(V.H) [G/((N.L)(N.V))] (N.L)(V.H) dw_H. Over cos(alpha) the
    rule follows D, cut where the first and the last N.L pass 0; over the azimuth it is cut where
    V.H makes N.L = 0 or N.L = N.V, or where a side of the groove begins to hide: between, the
    integrand is smooth.

    Parameters
    ----------
    facets : object
        With a scalar roughness.
    shadowing : callable
    index : (bands,) or None
        See `torrance_sparrow.TorranceSparrow`.
    cosine : (k,) float64
        N.V in (0, 1].
    """
    view = np.asarray(cosine, dtype=np.float64)[:, None, None]
    up, weight = _leans(facets, view, leans)
    a, b = view * up, np.sqrt((1.0 - view) * (1.0 + view)) * np.sqrt((1.0 - up) * (1.0 + up))
    phi, arc = _turns(a, b, _kinks(view, up), turns)
    across = np.clip(a + b * np.cos(phi), 0.0, 1.0)
    light = 2.0 * across * up - view
    lit = np.maximum(light, 0.0)
    hidden = shadowing(facets, lit, view, across, up)
    share = np.where(light > 0.0, hidden * lit * across, 0.0) * arc * weight / np.pi
    bands = [None] if index is None else np.asarray(index)[:, None]
    found = [np.einsum("kat,katb->k", share, mirrored_share(one, across)) for one in bands]
    return np.stack(found, axis=1)  # a band at a time: all of many wavelengths would take GB


def mirrored_share(index, cosine):
    """Return F (..., bands) of facets of an index; 1 (..., 1) where none is given."""
    if index is None:
        return np.ones((*np.shape(cosine), 1))
    return fresnel.reflectance(np.asarray(cosine)[..., None], np.asarray(index))


@lru_cache(maxsize=256)
def albedo_table(facets, shadowing: Callable, index: tuple | None) -> Callable:
    """Return a function of the cosine, of any shape (...), that gives the albedo (..., bands).

    Cubic and monotone between cosines (Fritsch & Carlson 1980) as close as the facets are flat
    near grazing: shadows there grow over angles as small as the facets lean.
    """
    from scipy.interpolate import PchipInterpolator

    slant = 0.3 * np.sqrt(1.0 / facets.cosine_of(0.5) ** 2 - 1.0)
    stretch = np.arcsinh(1.0 / slant)
    place = np.linspace(0.0, 1.0, COSINES)
    cosines = np.clip(np.sinh(place**2 * stretch) * slant, LEAST, 1.0)
    albedo = np.minimum(facet_albedo(facets, shadowing, index, cosines), 1.0)
    curve = PchipInterpolator(place, albedo, axis=0)
    return lambda cosine: curve(
        np.sqrt(np.clip(np.arcsinh(np.asarray(cosine) / slant) / stretch, 0.0, 1.0))
    )


def albedo_of_points(model, cosine):
    """Return the unscaled albedo (..., bands) where each point has a roughness of its own.

    Linear in the logarithm of the roughness between the tables of `ROUGHNESSES`.
    """
    roughness, cosine = np.broadcast_arrays(model.facets.roughness, np.asarray(cosine, float))
    place = np.interp(np.log(roughness), np.log(ROUGHNESSES), np.arange(len(ROUGHNESSES)))
    below = np.minimum(place.astype(int), len(ROUGHNESSES) - 2)
    used = np.unique([below, below + 1])
    kind = type(model.facets)
    tables = {
        k: albedo_table(kind(float(ROUGHNESSES[k])), model.shadowing, model.index_values)
        for k in used
    }
    albedo = np.empty((*cosine.shape, 1 if model.index is None else len(model.index)))
    for k in np.unique(below):
        mine = below == k
        low, high = (tables[j](cosine[mine]) for j in (k, k + 1))
        albedo[mine] = low + (place[mine] - k)[:, None] * (high - low)
    return albedo


def _leans(facets, view, count):
    """Return (k, 3 count, 1) cosines of alpha and weights for D cos(alpha) of the facets.

    N.L > 0 for every azimuth below alpha = 45 degrees - theta/2, for none above 45 + theta/2.
    """
    x, w = np.polynomial.legendre.leggauss(count)
    lean = np.arccos(view[:, 0]) / 2.0
    cuts = facets.share_of(np.cos(np.pi / 4.0 + lean * [-1.0, 1.0]))
    ends = np.concatenate([0.0 * lean, 1.0 - np.cbrt(1.0 - cuts), 1.0 + 0.0 * lean], axis=1)
    span = np.diff(ends, axis=1)[..., None]
    s = (ends[:, :-1, None] + span * (x + 1.0) / 2.0).reshape(len(view), -1)
    share = np.minimum(1.0 - (1.0 - s) ** 3, 1.0 - 2.0**-53)  # closer where facets lean most
    up = np.maximum(facets.cosine_of(share), LEAST_COSINE)
    density = facets.relative(up) / facets.norm() / np.maximum(facets.chosen(up), 1e-300)
    weight = density * 3.0 * (1.0 - s) ** 2 * (span * w / 2.0).reshape(s.shape)
    return up[..., None], weight[..., None]


def _kinks(view, up):
    """Return (k, alpha, 4) values of V.H where the integrand changes its formula."""
    both = 4.0 * up**2 - 1.0
    groove = np.where(both > 0.0, 2.0 * up * view / np.where(both > 0.0, both, 1.0), 2.0)
    found = np.concatenate([view / (2.0 * up), 2.0 * up * view, view / up, groove], axis=-1)
    return np.minimum(found, 2.0)


def _turns(a, b, kinks, count):
    """Return nodes and weights (k, alpha, 5 count) from 0 to pi, cut where a + b cos = kinks."""
    x, w = np.polynomial.legendre.leggauss(count)
    inner = np.arccos(np.clip((kinks - a) / np.maximum(b, 1e-150), -1.0, 1.0))
    ends = np.zeros((*inner.shape[:2], 6))
    ends[..., 1:5], ends[..., 5] = np.sort(inner, axis=-1), np.pi
    span = np.diff(ends, axis=-1)[..., None]
    phi = ends[..., :-1, None] + span * (x + 1.0) / 2.0
    arc = np.broadcast_to(span * w / 2.0, phi.shape)
    return phi.reshape(*inner.shape[:2], -1), arc.reshape(*inner.shape[:2], -1)
