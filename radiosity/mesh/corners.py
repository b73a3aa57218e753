"""Corners: texture coordinates and normals that faces have at their corners, and what lies between.

On a triangle values are linear (barycentric), on a quadrilateral bilinear in the same s and t that
its points are: x(s, t) = (1-s)(1-t) v0 + s(1-t) v1 + s t v2 + (1-s) t v3.
"""

import numpy as np

AGREE = 1e-5  # of the values' span: files give six digits
FRONT = 0.05  # least cosine between a shading normal and the face's own


def weights(st: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Return the corners' weights (k, 4) at places (s, t) (k, 2) of faces; triangle (k,) bool."""
    s, t = st.T
    linear = [1 - s - t, s, t, np.zeros(len(s))]
    bilinear = [(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t]
    return np.where(triangle[:, None], np.stack(linear, axis=1), np.stack(bilinear, axis=1))


def slopes(st: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Return the derivatives (k, 4, 2) of the corners' weights by s and t."""
    s, t = st.T
    one, none = np.ones(len(s)), np.zeros(len(s))
    linear = [[-one, -one], [one, none], [none, one], [none, none]]
    bilinear = [[t - 1, s - 1], [1 - t, -s], [t, s], [-t, 1 - s]]
    linear, bilinear = (np.moveaxis(np.array(w), -1, 0) for w in (linear, bilinear))
    return np.where(triangle[:, None, None], linear, bilinear)


def between(corners: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the values (k, c) that corners (k, 4, c) take where they have the weights (k, 4)."""
    return np.einsum("kv,kvc->kc", weight, corners)


def normal_between(normals: np.ndarray, weight: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Return the unit normals (k, 3) between those of corners (k, 4, 3).

    Phong (1975), "Illumination for computer generated pictures". ``own`` (k, 3) are the faces'
    normals, which hold where corners have none.
    """
    found = between(normals, weight)
    found = np.where(np.isfinite(found).all(axis=1)[:, None], found, own)
    return in_front(found, own)


def onto_curve(points, corners, normals, weight) -> np.ndarray:
    """Return points (k, 3) of faces, raised to the convex surface that the faces stand for.

    x + sum_i w_i max(0, n_i . (v_i - x)) n_i: to the tangent planes at the corners v_i, and less
    the farther a corner is. Where the surface is concave points stay. Hanika (2021), "Hacking the
    shadow terminator".

    Parameters
    ----------
    corners, normals : (k, 4, 3) float64
    weight : (k, 4) float64
        See `weights`.
    """
    below = np.einsum("kvc,kvc->kv", normals, corners - points[:, None])
    return points + np.einsum("kv,kvc->kc", weight * np.maximum(below, 0.0), normals)


def in_front(normals: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Return normals (k, 3) as unit vectors, bent until their cosine to ``own`` is FRONT at least.

    A surface cannot be seen, or lit, where its normal points into the face.
    """
    normals = unit(normals)
    cosine = np.einsum("kc,kc->k", normals, own)
    across = normals - cosine[:, None] * own
    bent = FRONT * own + np.sqrt(1.0 - FRONT**2) * unit(across)
    return np.where((cosine < FRONT)[:, None], bent, normals)


def joinable(joined, apart, one, two) -> np.ndarray:
    """Return (m,) bool: pairs of triangles whose corners mean the same joined as apart.

    Texture coordinates must be an affine function of the place, so that each point keeps its own;
    they and normals must agree along the shared edge. Between edges normals may differ a little:
    either way they pass without a step into what the neighbours have.

    Parameters
    ----------
    joined : (quads (m, 4, 3), uv (m, 4, 2) or None, normals (m, 4, 3) or None)
        Corners of the quadrilaterals.
    apart : (uv (t, 3, 2) or None, normals (t, 3, 3) or None)
        Corners of the triangles.
    one, two : (m,) int
        Their shared edges, 3 t + k, head to tail.
    """
    good = np.ones(len(one), bool)
    for values in apart:
        if values is not None:
            good &= _agree(values, one, two)
    quads, uv, _ = joined
    return good if uv is None else good & affine(quads, uv)


def _agree(values, one, two):
    """Return (m,) bool: whether both triangles have the same values along their shared edge."""
    here = np.stack([values[one // 3, one % 3], values[one // 3, (one % 3 + 1) % 3]], axis=1)
    there = np.stack([values[two // 3, (two % 3 + 1) % 3], values[two // 3, two % 3]], axis=1)
    both = np.concatenate([values[one // 3], values[two // 3]], axis=1)
    span = np.ptp(both, axis=1).max(axis=1)
    same = np.abs(here - there).max(axis=(1, 2)) <= AGREE * span
    return same | np.isnan(both).all(axis=(1, 2))


def affine(quads: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return (m,) bool: whether values (m, 4, c) are affine in the place, up to AGREE.

    Of planar quadrilaterals (m, 4, 3); false for triangles.
    """
    v = quads - quads[:, :1]
    normal = np.cross(v[:, 2], v[:, 3] - v[:, 1])
    whole, a, b = (
        np.einsum("mc,mc->m", np.cross(v[:, i], v[:, j]), normal)
        for i, j in ((1, 3), (2, 3), (1, 2))
    )
    whole[whole == 0.0] = np.nan  # v0, v1 and v3 in a line: not a quadrilateral to join
    a, b = a / whole, b / whole
    u = values - values[:, :1]
    miss = np.abs(u[:, 2] - a[:, None] * u[:, 1] - b[:, None] * u[:, 3]).max(axis=1)
    none = np.isnan(values).all(axis=(1, 2))
    return (miss <= AGREE * np.ptp(values, axis=1).max(axis=1)) | none


def unit(v: np.ndarray) -> np.ndarray:
    """Return vectors (..., 3) of length 1; 0 stays 0."""
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)
