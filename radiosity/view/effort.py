"""Effort: how many passes a picture takes where its accuracy decides, and where it takes more.

First all pixels get passes until the error of what is not an edge meets the accuracy. Then rounds
of passes go to the pixels with the largest errors: edges of lamps and of surfaces, creases,
penumbras and highlights.
"""

import numpy as np
from scipy.ndimage import maximum_filter

from radiosity.view.film import Developed, Film
from radiosity.view.smoothing import MIXED

FEWEST, MOST = 8, 128  # passes over all pixels
ROUNDS = 5  # each doubles the passes of the pixels that it goes to
BUDGET = 0.5  # of the passes over all pixels: what a round may take
BEST = 0.9  # of the pixels within faces: those that passes over all have to serve
DARKEST = 0.1  # of the mean luminance: what is darker need not be known any better


def even_enough(film: Film, picture: Developed, accuracy: float) -> bool:
    """Return whether pixels within faces err by no more than the accuracy, rms, of their mean.

    But for the tenth that errs most, which rounds are better spent on than passes over all.
    """
    y = film.bands.luminance(picture.radiance)
    plain = _plain(picture) & (film.face != MIXED).reshape(y.shape)
    if not plain.any():
        return True
    squares = np.sort(picture.error[plain] ** 2)[: max(1, int(BEST * plain.sum()))]
    return bool(np.mean(squares) <= (accuracy * y[plain].mean()) ** 2)


def worth_more(
    film: Film, pixels: np.ndarray, picture: Developed, accuracy: float, most: int
) -> np.ndarray:  # fmt: skip
    """Return those of some pixels (k,) that have too large an error, or a neighbour that has.

    The standard error is to be at most the accuracy times max(Y, 0.1 Y_mean), as for irradiance on
    surfaces; Y is luminance, its mean over pixels without lamps. Neighbours count since a pixel
    whose few sight lines all missed what shows in a corner of it does not know its error, and
    since few samples that happen to agree would else be left as they are. Of more than ``most``
    pixels those with the largest errors, in that measure, are returned.
    """
    y = np.maximum(film.bands.luminance(picture.radiance), 0.0)
    plain = _plain(picture)
    mean = y[plain].mean() if plain.any() else 0.0
    allowed = np.maximum(accuracy * np.maximum(y, DARKEST * mean), np.finfo(float).tiny)
    excess = maximum_filter(picture.error / allowed, 3).ravel()[pixels]
    worst = np.argsort(-excess, kind="stable")[:most]
    return np.sort(pixels[worst[excess[worst] > 1.0]])


def _plain(picture):
    """Return (h, w) bool: pixels without lamps."""
    if picture.lamp is None:
        return np.ones(picture.radiance.shape[:2], bool)
    return picture.lamp[..., -1] == 0
