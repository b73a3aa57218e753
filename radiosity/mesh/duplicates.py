"""Duplicates: faces that are in a mesh twice, corner by corner, told apart from a sheet's sides."""

import numpy as np

FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
SPREAD, SHIFT = np.uint64(0xBF58476D1CE4E5B9), np.uint64(29)


def repeated(v: np.ndarray, surface: np.ndarray) -> np.ndarray:
    """Return (f,) bool: faces that another one before them equals, wound the same way.

    Both sides of a sheet are wound in opposite ways and stay two faces.

    Parameters
    ----------
    v : (f, 4, 3) float64
        Corners; a triangle repeats its last one. Where a face begins does not matter.
    surface : (f,) int
        A number, of the material say, that must be equal too.
    """
    if not len(v):
        return np.zeros(0, bool)
    first = _first_corner(v)
    turned = np.take_along_axis(v, first[:, :, None], axis=1) + 0.0  # so that -0 is 0
    key = np.zeros(len(v), np.uint64)
    for k in range(4):
        key = _mixed(key + _hash(turned[:, k]))
    key = _mixed(key + surface.astype(np.uint64))
    _, place, same = np.unique(key, return_index=True, return_inverse=True)
    before = place[same.ravel()]
    equal = np.all(turned == turned[before], axis=(1, 2)) & (surface == surface[before])
    return equal & (before < np.arange(len(v)))


def _first_corner(v):
    """Return (f, 4) the corners in their order from the one of the least hash."""
    value = np.stack([_hash(v[:, k] + 0.0) for k in range(4)], axis=1)
    triangle = np.all(v[:, 3] == v[:, 2], axis=1)
    sides = np.where(triangle, 3, 4)[:, None]
    order = value.argmin(axis=1)[:, None] + np.arange(4)
    order = np.where(triangle[:, None], np.minimum(np.arange(4), 2) + order[:, :1], order)
    return order % sides


def _hash(points):
    """Return (n,) numbers that equal points (n, 3) have in common."""
    bits = np.ascontiguousarray(points).view(np.uint64)
    return _mixed(sum(_mixed(bits[:, k] * FACTORS[k]) * FACTORS[k - 1] for k in range(3)))


def _mixed(x):
    x = (x ^ (x >> SHIFT)) * SPREAD
    return x ^ (x >> SHIFT)
