"""Shininess from a texture: facets whose spread varies over a surface (Blinn 1977)."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.texture import Texture


@dataclass(frozen=True)
class Shininess:
    """A picture t of the spread of facets, c3 = c_min + (1 - c_min) t.

    Attributes
    ----------
    texture : Texture
        Of one band, in [0, 1]: 0 is shiny, 1 dull.
    minimum : float
        c_min in (0, 1].

    Examples
    --------
    >>> Shininess(Texture([[[0.0], [1.0]]]), 0.2).at([[0.25, 0.5], [0.5, 0.5]]).round(3).tolist()
    [0.2, 0.6]
    """

    texture: Texture
    minimum: float

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Return c3 (k,) at texture coordinates (k, 2)."""
        return spread(self.minimum, np.clip(self.texture.at(uv)[:, 0], 0.0, 1.0))

    @property
    def mean(self) -> float:
        """Return the mean of c3 over the picture."""
        return float(spread(self.minimum, self.texture.mean[0]))


def spread(minimum: float, texture) -> np.ndarray:
    """Return c3 = c_min + (1 - c_min) t(u, v): ``minimum`` where a texture t is 0, 1 where it is 1.

    c3 is the eccentricity of Trowbridge & Reitz's facets: near 0 the surface is shiny, at 1 dull.

    Raises
    ------
    ValueError
        c_min outside (0, 1] or a value t outside [0, 1].
    """
    t = np.asarray(texture, float)
    if not 0.0 < minimum <= 1.0:
        raise ValueError(
            f"minimum = {minimum} must lie above 0 and be at most 1: 0 is a mirror, which no "
            "distribution of facets describes"
        )
    if not np.all((t >= 0.0) & (t <= 1.0)):
        raise ValueError(f"texture values from {t.min()} to {t.max()} must lie in [0, 1]")
    return minimum + (1.0 - minimum) * t


def facets(cosine, minimum: float, texture) -> np.ndarray:
    """Return D3 = (c_min c3 / (cos^2(alpha) (c3^2 - 1) + 1))^2, broadcast.

    alpha is the angle between facet and surface, c3 that of `spread`. D3 is 1 at alpha = 0 where
    c3 = c_min, and (c_min/c3)^2 elsewhere: the integral of D3 cos(alpha) over the hemisphere is
    pi c_min^2 at every point, so that dull points send out no more light than shiny ones, and
    D3 / (pi c_min^2) is the normalised distribution (GGX with its own c3). The denominator is
    taken as sin^2 + c3^2 cos^2, which k1 = 1/(c3^2 - 1) of Blinn's short form is not at c3 = 1.
    """
    c, c3 = np.asarray(cosine, float), spread(minimum, texture)
    return (minimum * c3 / ((1.0 - c) * (1.0 + c) + (c3 * c) ** 2)) ** 2
