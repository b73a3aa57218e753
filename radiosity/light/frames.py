"""Frames: directions seen from a surface, with z along its normal, and back."""

import numpy as np


def frame(normal) -> np.ndarray:
    """Return (..., 3, 3) right-handed frames whose third row is the unit normal (..., 3).

    Duff et al. (2017), "Building an orthonormal basis, revisited".
    """
    x, y, z = np.moveaxis(np.asarray(normal, dtype=np.float64), -1, 0)
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    one = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    two = np.stack([b, sign + y * y * a, -y], axis=-1)
    return np.stack([one, two, np.stack([x, y, z], axis=-1)], axis=-2)


def to_local(frames, directions) -> np.ndarray:
    """Return directions (..., 3) of the scene in the frames (..., 3, 3) of surfaces."""
    return np.einsum("...ij,...j->...i", frames, directions)


def to_scene(frames, directions) -> np.ndarray:
    """Return directions (..., 3) in the frames (..., 3, 3) of surfaces as those of the scene."""
    return np.einsum("...ij,...i->...j", frames, directions)


def polar(cosine, phi) -> np.ndarray:
    """Return unit vectors (..., 3) at an angle of given cosine to z and an azimuth phi."""
    cosine, phi = np.broadcast_arrays(np.asarray(cosine, float), np.asarray(phi, float))
    sine = np.sqrt(np.maximum((1.0 - cosine) * (1.0 + cosine), 0.0))
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)


def halfway(to_light, to_view):
    """Return the unit vector H = (L + V)/|L + V| and V.H; V and 0 where L = -V."""
    total = np.asarray(to_light, float) + to_view
    length = np.linalg.norm(total, axis=-1)
    opposite = length < 1e-12
    half = total / np.where(opposite, 1.0, length)[..., None]
    half = np.where(opposite[..., None], to_view, half)
    return half, np.where(opposite, 0.0, np.minimum(length / 2.0, 1.0))
