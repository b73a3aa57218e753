"""Cells of the fine mesh: parts of patches, and the points where light is looked at for them.

A patch has coordinates (U, V) in whole numbers from 0 to SIDE, so that a point is the same for all
cells that share it. Each cell has its corners, the middles of its edges, and its centre.
"""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.corners import between, weights
from radiosity.mesh.patches import Patches

DEPTH = 5  # times that a patch is halved
SIDE = 3 * 2 ** (DEPTH + 1)  # a triangle's centre has thirds of its corners' coordinates
INWARD = 1e-3  # of the way to its centre, by which a point on the edge of a patch is moved in
ALL = np.arange(9)  # points of a cell: corner, middle, corner, middle, ..., centre
FEW = ALL[::2]  # without the middles of edges
SQUARE = SIDE * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
TRIANGLE = SIDE * np.array([[0, 0], [1, 0], [0, 1], [0, 1]])
_QUARTERS = [[0, 1, 8, 7], [1, 2, 3, 8], [8, 3, 4, 5], [7, 8, 5, 6]]
_THIRDS = [[0, 1, 7, 7], [1, 2, 3, 3], [7, 3, 4, 4], [1, 3, 7, 7]]


@dataclass(frozen=True)
class Cells:
    """Parts of patches; a triangle repeats its last corner.

    Attributes
    ----------
    patch : (n,) int
    corners : (n, 4, 2) int
        Coordinates (U, V), counter-clockwise as the patch is.
    """

    patch: np.ndarray
    corners: np.ndarray

    def __len__(self) -> int:
        """Return n."""
        return len(self.patch)

    def some(self, which: np.ndarray) -> "Cells":
        """Return those that a mask or indices choose."""
        return Cells(self.patch[which], self.corners[which])

    @property
    def is_triangle(self) -> np.ndarray:
        """Return (n,) bool."""
        return np.all(self.corners[:, 3] == self.corners[:, 2], axis=1)

    def samples(self) -> np.ndarray:
        """Return (n, 9, 2) the coordinates of each cell's points, as `ALL` numbers them.

        A triangle repeats some.
        """
        c, found = self.corners, np.empty((len(self), len(ALL), 2), int)
        found[:, 0:8:2] = c
        found[:, 1:8:2] = (c + np.roll(c, -1, axis=1)) // 2
        thirds = c[:, :3].sum(axis=1) // 3
        found[:, 8] = np.where(self.is_triangle[:, None], thirds, c.sum(axis=1) // 4)
        return found

    def quartered(self) -> "Cells":
        """Return four cells in the place of each."""
        at = np.where(self.is_triangle[:, None, None], _THIRDS, _QUARTERS)
        corners = self.samples()[np.arange(len(self))[:, None, None], at]
        return Cells(np.repeat(self.patch, 4), corners.reshape(-1, 4, 2))

    def areas(self, patches: Patches) -> np.ndarray:
        """Return (n,) in the square of the scene's unit."""
        corner = self.corners / SIDE
        one, two = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
        share = 0.5 * np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        whole = np.where(is_triangle(patches), 2.0, 1.0) * patches.area
        return share * whole[self.patch]  # of skew quadrilaterals about


def is_triangle(patches: Patches) -> np.ndarray:
    """Return (n,) bool: which patches repeat their last vertex."""
    return np.all(patches.vertices[:, 3] == patches.vertices[:, 2], axis=1)


def whole_patches(patches: Patches, which: np.ndarray) -> Cells:
    """Return some patches, each as one cell."""
    triangle = is_triangle(patches)[which]
    return Cells(which, np.where(triangle[:, None, None], TRIANGLE, SQUARE))


def numbered(patch: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return (...) one number for a point (..., 2) of a patch (...)."""
    return (patch * (SIDE + 1) + uv[..., 0]) * (SIDE + 1) + uv[..., 1]


def patch_of(numbers: np.ndarray) -> np.ndarray:
    """Return (k,) the patches of numbered points (k,)."""
    return numbers // (SIDE + 1) ** 2


def points_of(patches: Patches, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (k, 3) of numbered points (k,), and where light is looked at for them."""
    patch, (rest, v) = patch_of(numbers), np.divmod(numbers, SIDE + 1)
    u = rest % (SIDE + 1)
    triangle = is_triangle(patches)[patch]
    weight = weights(np.stack([u, v], axis=1) / SIDE, triangle)
    found = between(patches.vertices[patch], weight)
    far = np.where(triangle, u + v, np.maximum(u, v)) == SIDE
    edge = (np.minimum(u, v) == 0) | far
    return found, np.where(edge[:, None], moved_in(patches, patch, found), found)


def moved_in(patches: Patches, patch: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points (k, 3) on the edges of patches (k,), moved in a little.

    On an edge a wall that stands there would be seen from its own plane, and of two rooms that a
    wall parts both would be.
    """
    return points + INWARD * (patches.centroid[patch] - points)
