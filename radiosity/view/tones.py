"""Tones: radiance as a window shows it, in its own colours or in false ones."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from radiosity.light.colour import in_gamut
from radiosity.light.photometry import photometric
from radiosity.view.image import Image, tone_map

if TYPE_CHECKING:
    from radiosity.view.falsecolour import Scale


@dataclass(frozen=True)
class Tones:
    """The display value of a unit of radiance, or a ``scale`` of luminance where there is one.

    Raises
    ------
    ValueError
        An exposure that is not positive and finite.
    """

    exposure: float
    scale: "Scale | None" = None

    def __post_init__(self):
        if not 0.0 < self.exposure < np.inf:
            raise ValueError(f"exposure = {self.exposure} must be positive and finite")

    def shown(self, rgb: np.ndarray) -> np.ndarray:
        """Return (..., 3) uint8 sRGB of linear radiance (..., 3) in W/(m2 sr)."""
        if self.scale is not None:
            return self.scale.colours(photometric(rgb))
        return tone_map(in_gamut(np.asarray(rgb, np.float64) * self.exposure), 1.0)

    def picture(self, image: Image) -> np.ndarray:
        """Return (h, w, 3) uint8 of a gathered picture, as its file would show it."""
        if self.scale is not None:
            return self.scale.colours(image.luminance)
        return replace(image, exposure=self.exposure).shown()
