"""Shininess from a texture: facets whose spread varies over a surface (Blinn 1977)."""

import numpy as np


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
