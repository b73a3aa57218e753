"""The film: what the passes of the final gather add up to, and the picture developed from it."""

from dataclasses import dataclass

import numpy as np

from radiosity.view.shading import Shading
from radiosity.view.smoothing import MIXED, smoothed


@dataclass(frozen=True)
class Film:
    """Sums over the passes, a pixel each; the arrays are added to in place."""

    width: int
    height: int
    total: np.ndarray  # (pixels, bands) radiance
    indirect: np.ndarray  # (pixels, bands) irradiance that patches cause
    point: np.ndarray  # (pixels, 3)
    nearness: np.ndarray  # (pixels,)
    face: np.ndarray  # (pixels,) face and side all sight lines met, MIXED where several
    diffuse: np.ndarray | None = None  # (pixels, bands) reflectance, of scenes with textures

    @classmethod
    def blank(cls, width: int, height: int, bands: int, textured: bool = False) -> "Film":
        """Return a film that no light has met."""
        n = width * height
        light = [np.zeros((n, bands)) for _ in range(2)]
        diffuse = np.zeros((n, bands)) if textured else None
        face = np.full(n, MIXED)
        return cls(width, height, *light, np.zeros((n, 3)), np.zeros(n), face, diffuse)

    def add(self, pixels, index, plane, points, leaving, indirect, nearness) -> None:
        """Add what one pass found at some pixels."""
        self.total[pixels] += leaving
        self.indirect[pixels] += indirect
        self.point[pixels] += points
        self.nearness[pixels] += nearness
        same = plane if index == 0 else np.where(self.face[pixels] == plane, plane, MIXED)
        self.face[pixels] = same

    def developed(self, passes: int, shading: Shading) -> np.ndarray:
        """Return (h, w, bands) mean radiance with its indirect part smoothed."""
        shape = self.height, self.width
        noisy = self.indirect.reshape(*shape, -1) / passes
        face = self.face.reshape(shape)
        smooth = smoothed(
            noisy, self.point.reshape(*shape, 3) / passes,
            self.nearness.reshape(shape) / passes, face, shading.plane_axes,
        )  # fmt: skip
        diffuse = shading.plane_diffuse[face]
        if self.diffuse is not None:
            diffuse = self.diffuse.reshape(*shape, -1) / passes
        change = diffuse * (smooth - noisy) / np.pi
        change[face == MIXED] = 0.0
        return self.total.reshape(*shape, -1) / passes + change
