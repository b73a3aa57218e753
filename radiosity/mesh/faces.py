"""Faces: the planar triangles and convex quadrilaterals a scene is made of."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Faces:
    """Planar faces in scene units, counter-clockwise seen from the front.

    Attributes
    ----------
    vertices : (f, 4, 3) float64
        A triangle repeats its last vertex.
    material : (f,) int
        Index into ``Scene.materials``.
    group : (f,) int
        Index into ``Scene.groups`` (an OBJ group, or one per ``[[geometry]]`` block).
    """

    vertices: np.ndarray
    material: np.ndarray
    group: np.ndarray

    def __len__(self) -> int:
        """Return the number of faces."""
        return len(self.vertices)
