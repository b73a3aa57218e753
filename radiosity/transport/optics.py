"""What surfaces do to light that comes from one direction: mirrors, clear interfaces and lobes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radiosity.light.coat import is_coat


@dataclass(frozen=True)
class Side:
    """One side of a surface, as single directions meet it; laws as in `radiosity.light`.

    Attributes
    ----------
    lobe, mirror, passage : object or None
        What lies on what: a lobe on a mirror, which with what passes lies on the base.
    """

    lobe: object | None = None
    mirror: object | None = None
    passage: object | None = None

    @property
    def index(self) -> np.ndarray | None:
        """Index of the far side over that of this one, None where light goes straight on."""
        return getattr(self.passage, "index", None)

    @property
    def is_clear(self) -> bool:
        """Whether it mirrors, or lets light through."""
        return self.mirror is not None or self.passage is not None

    def under_lobe(self, cosine: np.ndarray) -> np.ndarray:
        """Return the share (k, 1 or bands) that a lobe lets through to what it lies on."""
        if self.lobe is None or not is_coat(self.lobe):
            return np.ones((len(cosine), 1))
        return 1.0 - self.lobe.albedo(cosine)

    def sent_on(self, cosine: np.ndarray) -> np.ndarray:
        """Return the share (k, bands) of what arrives at an angle that is not left to the base."""
        below = [part.albedo(cosine) for part in (self.mirror, self.passage) if part is not None]
        found = self.under_lobe(cosine) * sum(below) if below else 0.0
        return found if self.lobe is None else found + self.lobe.albedo(cosine)


@dataclass(frozen=True)
class Optics:
    """All that is not diffuse about a scene's faces.

    Attributes
    ----------
    material : (f,) int
        Of each face.
    sides : tuple of (Side or None, Side or None)
        Front and back of each material, None where all is diffuse.
    absorption : (materials, bands) float64
        Of the medium behind each front, 1/scene unit.
    normal : (f, 3) float64
        Of the fronts.
    smooth : callable, optional
        ``smooth(face, points)`` returns unit normals (k, 3) of the fronts where they vary.
    """

    material: np.ndarray
    sides: tuple
    absorption: np.ndarray
    normal: np.ndarray
    smooth: Callable | None = None

    @property
    def bands(self) -> int:
        """How many numbers tell what a surface does."""
        return self.absorption.shape[1]

    @property
    def laws(self) -> np.ndarray:
        """Return (k, bands) numbers that tell bands apart that surfaces do not treat alike."""
        parts = [self.absorption]
        for side in (s for pair in self.sides for s in pair if s is not None):
            for law in (side.lobe, side.mirror, side.passage):
                for name in ("share", "reflectance", "index"):
                    value = getattr(law, name, None)
                    if value is not None:
                        value = np.atleast_2d(np.concatenate([np.real(value), np.imag(value)]))
                        parts.append(np.broadcast_to(value.reshape(2, -1), (2, self.bands)))
        return np.concatenate(parts)

    def different_bands(self) -> tuple[np.ndarray, np.ndarray]:
        """Return one band of each kind that surfaces treat alike, and the kind (bands,) of all."""
        _, first, which = np.unique(self.laws, axis=1, return_index=True, return_inverse=True)
        return first, which.ravel()

    def on(self, face: np.ndarray, back: np.ndarray) -> np.ndarray:
        """Return (k,) bool: which sides of faces send light on along single directions."""
        told = np.array([[s is not None for s in pair] for pair in self.sides], bool)
        return told[self.material[face], back]

    def wanted(self, lobes: bool = True) -> np.ndarray:
        """Return (f, 2) bool: whose fronts and backs send light on, by more than lobes if asked."""
        told = [[s is not None and (lobes or s.is_clear) for s in pair] for pair in self.sides]
        return np.array(told, bool)[self.material]

    def groups(self, face: np.ndarray, back: np.ndarray):
        """Yield each kind of side that is not all diffuse, its material, and which have it."""
        kind = 2 * self.material[face] + back
        for k in np.unique(kind):
            side = self.sides[k // 2][k % 2]
            if side is not None:
                yield side, k // 2, bool(k % 2), np.flatnonzero(kind == k)

    def facing(self, face: np.ndarray, back: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return unit normals (k, 3) of sides at points, scene units."""
        normal = self.normal[face] if self.smooth is None else self.smooth(face, points)
        return np.where(back[:, None], -normal, normal)
