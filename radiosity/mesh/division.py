"""Division of faces into cells: a grid on every face, and finer grids in some of its cells."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from radiosity.mesh.faces import Faces

# Cells along the side of a triangle, to those of a square as large. Measured on five rooms of
# triangles at five accuracies: 1 takes as long, and some errors are over twice what is estimated;
# 1.4 takes 1.3 times as long. Beyond the longest edge SLENDER, in sides of a square as large, cells
# are as large as those of a triangle that has it: in a corridor of triangles 2.2 takes twice as
# long, and with no bound constant elements miss 10 % by a factor of 2.7.
TRIANGLE, SLENDER = 1.2, 3.0


@dataclass(frozen=True)
class Division:
    """How faces are divided into cells: grids, and in some cells finer grids, and so on.

    Cells are numbered face by face, in a quadrilateral row by row from its first edge, in a
    triangle too; then those of each cell's own grid likewise.

    Attributes
    ----------
    shape : (f, 2) int
        Cells along the two edges of a quadrilateral; (n, 0) is a triangle of n x n cells.
    splits : tuple of (cells,) int
        Into m x m cells each cell of the grids is divided, each cell of these, and so on.
    """

    shape: np.ndarray
    splits: tuple[np.ndarray, ...] = ()

    @cached_property
    def first(self) -> np.ndarray:
        """Return (f + 1,) the first cell of each face's grid, and the end of the last."""
        n, m = self.shape.T
        return _ends(np.where(m == 0, n * n, n * m))

    @cached_property
    def begin(self) -> tuple[np.ndarray, ...]:
        """Return for each of ``splits`` (cells + 1,): the first part of a cell, the last's end."""
        return tuple(_ends(split**2) for split in self.splits)

    @property
    def count(self) -> int:
        """Return how many cells there are."""
        return int((self.begin or (self.first,))[-1][-1])

    @cached_property
    def ends(self) -> np.ndarray:
        """Return (f + 1,) the first cell of each face, and the end of the last."""
        ends = self.first
        for begin in self.begin:
            ends = begin[ends]
        return ends

    @cached_property
    def face(self) -> np.ndarray:
        """Return (cells,) the face of each cell."""
        return np.repeat(np.arange(len(self.shape)), np.diff(self.ends))

    def divided(self, split: np.ndarray | int) -> "Division":
        """Return the division in which each cell, or all, became split x split (cells,)."""
        return Division(self.shape, (*self.splits, np.broadcast_to(split, self.count).copy()))

    def halved(self) -> "Division | None":
        """Return the grids of cells twice as large, None where there are none."""
        if self.splits or np.any(self.shape % 2):
            return None
        return Division(self.shape // 2)

    def cells(self, faces: Faces) -> np.ndarray:
        """Return the polygons (cells, 4, 3) of these faces' cells; triangles repeat the last."""
        cells = _divided(faces.vertices, self.shape, self.first)
        triangle = np.repeat(self.shape[:, 1] == 0, np.diff(self.first))
        for split, begin in zip(self.splits, self.begin, strict=True):
            cells = _divided(cells, np.where(triangle, [split, 0 * split], split).T, begin)
            triangle = np.repeat(triangle, split**2)
        return cells


def divisions(faces: Faces, size: float, rounding: Callable = np.ceil) -> Division:
    """Return the division of each face into cells that measure about ``size``.

    Those of triangles are as large as squares that serve linear elements as well. ``rounding``
    makes whole numbers of the quotients.
    """
    v = faces.vertices
    edge = np.linalg.norm(np.roll(v, -1, axis=1) - v, axis=2)
    triangle = faces.is_triangle
    along = np.maximum(edge[:, [0, 1]], edge[:, [2, 3]])
    side = np.maximum(np.sqrt(faces.areas()), edge.max(axis=1) / SLENDER)
    along[triangle, 0] = TRIANGLE * side[triangle]
    count = np.maximum(1, rounding(along / size - 1e-9)).astype(int)
    count[triangle, 1] = 0
    return Division(count)


def _ends(counts):
    return np.concatenate([[0], np.cumsum(counts)])


def _divided(polygons, shape, first):
    """Return all cells (c, 4, 3) of the grids of polygons (f, 4, 3), which begin at ``first``."""
    if np.all(shape[:, 0] == 1) and np.all(shape[:, 1] <= 1):
        return polygons
    cells = np.empty((first[-1], 4, 3))
    for key in np.unique(shape, axis=0):
        same = np.flatnonzero(np.all(shape == key, axis=1))
        make = _triangle_cells if key[1] == 0 else _quad_cells
        block = make(polygons[same], *key)
        cells[first[same][:, None] + np.arange(block.shape[1])] = block
    return cells


def _quad_cells(v: np.ndarray, columns: int, rows: int) -> np.ndarray:
    """Return (k, rows * columns, 4, 3) bilinear cells of quadrilaterals (k, 4, 3)."""
    s = np.linspace(0, 1, columns + 1)[None, :, None]
    t = np.linspace(0, 1, rows + 1)[:, None, None]
    w = [(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t]
    p = sum(wk[None] * v[:, k, None, None] for k, wk in enumerate(w))
    quads = np.stack([p[:, :-1, :-1], p[:, :-1, 1:], p[:, 1:, 1:], p[:, 1:, :-1]], axis=3)
    return quads.reshape(len(v), rows * columns, 4, 3)


def _triangle_cells(v: np.ndarray, n: int, _: int) -> np.ndarray:
    """Return (k, n * n, 4, 3): row r from the first edge holds 2 (n - r) - 1 cells."""
    origin, e1, e2 = v[:, 0], v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    corners = []
    for r in range(n):
        for c in range(n - r):
            corners.append([(c, r), (c + 1, r), (c, r + 1)])
            if c < n - r - 1:
                corners.append([(c + 1, r), (c + 1, r + 1), (c, r + 1)])
    st = np.array(corners, float)[:, [0, 1, 2, 2]] / n
    return (
        origin[:, None, None]
        + st[None, :, :, 0, None] * e1[:, None, None]
        + st[None, :, :, 1, None] * e2[:, None, None]
    )
