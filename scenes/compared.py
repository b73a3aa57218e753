"""Path-traced references of the scenes here, and their blocks, which the scripts compare with.

A path tracer leaves noise, so means over blocks are compared, and only of blocks in which no pixel
shows an edge or a lamp.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from radiosity.light.photometry import luminance

HERE = Path(__file__).resolve().parent
SIDE = 8  # pixels of a reference to a block


@dataclass(frozen=True)
class Reference:
    """A path-traced picture (Mitsuba 3).

    Attributes
    ----------
    pixels : (h, h, 3) float64
        Radiance in W/(m2 sr).
    noise : (h, h, 3) float64
        Its standard error.
    inside : (b, b) bool
        Blocks of `SIDE` pixels that show neither an edge nor a lamp.
    """

    pixels: np.ndarray
    noise: np.ndarray
    inside: np.ndarray


def reference(name: str) -> Reference:
    """Return the reference of a scene."""
    data = np.load(HERE / f"{name}_reference" / "image.npz", allow_pickle=False)
    lamp = np.flatnonzero(data["object_names"] == "light")
    plain = data["interior"] & ~np.isin(data["object_id"], lamp)
    count = len(plain) // SIDE
    inside = blocks(plain[..., None].astype(float), count)[..., 0] > 1.0 - 1e-9
    return Reference(data["image"].astype(float), data["se"].astype(float), inside)


def blocks(pixels: np.ndarray, count: int) -> np.ndarray:
    """Return the means (count, count, n) over blocks of a square picture (h, h, n)."""
    side = len(pixels) // count
    return pixels.astype(float).reshape(count, side, count, side, -1).mean(axis=(1, 3))


def deviation(pixels: np.ndarray, truth: Reference) -> tuple[np.ndarray, float]:
    """Return how a picture's luminance deviates from a reference's, of blocks.

    Returns
    -------
    deviation : (b, b) float64
        Relative to the reference's mean, NaN where blocks are not compared.
    rms : float
        Its root mean square, the reference's own variance subtracted.
    """
    count = len(truth.inside)
    y = luminance(blocks(truth.pixels, count))
    found = luminance(blocks(pixels, count)) - y
    mean = y[truth.inside].mean()
    variance = blocks(luminance(truth.noise)[..., None] ** 2, count)[..., 0] / SIDE**2
    square = (found**2 - variance)[truth.inside].mean()
    return np.where(truth.inside, found / mean, np.nan), np.sqrt(max(square, 0.0)) / mean
