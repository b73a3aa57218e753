"""The seeds' raw lobes: unnormalised, for local shading alone, where their figures use them."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SeedForm:
    """A lobe as Blinn (1977) and Szirmay-Kalos (eq. 3.40) shade with it, f = k s/(N.L).

    s is cos^n(alpha), (N.H)^n or D F G/(N.V) with D of peak 1. Neither conserves energy nor is
    reciprocal: the light that is reflected does not fall with N.L, so f has no bound at grazing
    incidence, and no albedo.

    Attributes
    ----------
    model : Phong, Blinn or TorranceSparrow
        Whose ``shape`` is s and whose ``reflectance`` is k.
    """

    model: object
    reciprocal = False

    @property
    def summary(self) -> str:
        """The model in words."""
        return f"{self.model.summary}, the seed's raw form"

    def value(self, to_light, to_view):
        """Return f (..., bands) in 1/sr, 0 where light or view lies below the horizon."""
        light = np.asarray(to_light)[..., 2]
        shape = self.model.shape(to_light, to_view) / np.maximum(light, 1e-300)[..., None]
        return shape * self.model.reflectance
