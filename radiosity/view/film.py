"""The film: what the passes of the final gather add up to, and the picture developed from it."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.bands import Bands
from radiosity.light.reflection import lambert
from radiosity.view.shading import Shading
from radiosity.view.smoothing import MIXED, smoothed

# Standard errors of n passes are those of independent ones times n to this power: their points
# fill a pixel, a light and a lobe more evenly. Measured from 8 to 128 passes, see
# benchmarks/gather.md.
EVENLY = -0.12


@dataclass(frozen=True)
class Developed:
    """A picture in the scene's bands.

    Attributes
    ----------
    radiance : (h, w, bands) float64
        W/(m2 sr).
    error : (h, w) float64 or None
        Standard error of its luminance, None where there was one pass only.
    lamp : (h, w, bands + 1) float64 or None
        What lamps that are seen add to the radiance, and the share of the pixel that they fill.
    """

    radiance: np.ndarray
    error: np.ndarray | None
    lamp: np.ndarray | None


@dataclass(frozen=True)
class Film:
    """Sums over the passes, a pixel each; the arrays are added to in place."""

    width: int
    height: int
    bands: Bands
    count: np.ndarray  # (pixels,) passes
    total: np.ndarray  # (pixels, bands) radiance
    indirect: np.ndarray  # (pixels, bands) irradiance that patches cause
    point: np.ndarray  # (pixels, 3)
    nearness: np.ndarray  # (pixels,)
    face: np.ndarray  # (pixels,) face and side all sight lines met, MIXED where several
    moments: np.ndarray  # (pixels, 4) of luminances: L^2, D, D^2, I^2; D = L less diffuse I/pi
    lamp: np.ndarray | None = None  # (pixels, bands + 1) of lamps seen: radiance, and how many
    diffuse: np.ndarray | None = None  # (pixels, bands) reflectance, where it varies in a plane

    @classmethod
    def blank(
        cls, width: int, height: int, bands: Bands, *, lamps: bool = False, varied: bool = False
    ) -> "Film":
        """Return a film that no light has met."""
        n, b = width * height, bands.count
        columns = b, b, 3, 4, b + 1 if lamps else 0, b if varied else 0
        total, indirect, point, moments, lamp, diffuse = (np.zeros((n, c)) for c in columns)
        return cls(
            width, height, bands, np.zeros(n, np.int64), total, indirect, point, np.zeros(n),
            np.full(n, MIXED), moments, lamp if lamps else None, diffuse if varied else None,
        )  # fmt: skip

    def add(self, pixels, plane, points, leaving, indirect, nearness, diffuse) -> None:
        """Add what one pass found at some pixels."""
        first = self.count[pixels] == 0
        same = first | (self.face[pixels] == plane)
        self.face[pixels] = np.where(same, plane, MIXED)
        self.count[pixels] += 1
        self.total[pixels] += leaving
        self.indirect[pixels] += indirect
        self.point[pixels] += points
        self.nearness[pixels] += nearness
        y, smooth = self.bands.luminance(leaving), self.bands.luminance(indirect)
        rest = y - self.bands.luminance(lambert(diffuse) * indirect)
        self.moments[pixels] += np.stack([y * y, rest, rest * rest, smooth * smooth], axis=1)
        if self.diffuse is not None:
            self.diffuse[pixels] += diffuse

    def add_lamps(self, pixels, emission) -> None:
        """Add lamps that pixels see: radiance (k, bands)."""
        self.lamp[pixels, :-1] += emission
        self.lamp[pixels, -1] += 1.0

    def developed(self, shading: Shading) -> Developed:
        """Return the mean radiance with its indirect part smoothed, and its standard error."""
        h, w, n = self.height, self.width, self.count[:, None]
        noisy, face = self.indirect / n, self.face.reshape(h, w)
        once, spread = self._scatter()
        smooth, doubt = smoothed(
            noisy.reshape(h, w, -1), self.bands.luminance(noisy).reshape(h, w),
            spread[2].reshape(h, w), self.count.reshape(h, w), (self.point / n).reshape(h, w, 3),
            (self.nearness / self.count).reshape(h, w), face, shading.plane_axes,
        )  # fmt: skip
        diffuse = shading.plane_diffuse[self.face] if self.diffuse is None else self.diffuse / n
        change = lambert(diffuse) * (smooth.reshape(noisy.shape) - noisy)
        change[self.face == MIXED] = 0.0
        radiance = (self.total / n + change).reshape(h, w, -1)
        error = None
        if not once:
            share = self.bands.luminance(lambert(diffuse)).reshape(h, w)
            apart = np.where(self.face == MIXED, spread[0], spread[1]) / self.count
            gain = self.count.astype(float) ** (2 * EVENLY)
            error = np.sqrt((gain * apart).reshape(h, w) + (share * doubt) ** 2)
        lamp = None if self.lamp is None else (self.lamp / n).reshape(h, w, -1)
        return Developed(radiance, error, lamp)

    def _scatter(self):
        """Return whether one pass is all, and variances (3, pixels) of a pass: of L, D and I."""
        n, m = self.count, self.moments
        y, smooth = self.bands.luminance(self.total), self.bands.luminance(self.indirect)
        squares = np.stack([m[:, 0] - y * y / n, m[:, 2] - m[:, 1] ** 2 / n,
                            m[:, 3] - smooth * smooth / n])  # fmt: skip
        return bool(np.any(n < 2)), np.maximum(squares, 0.0) / np.maximum(n - 1, 1)
