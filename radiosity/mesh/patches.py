"""Patches: the one-sided cells that carry radiosity, and the table that finds them again."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from radiosity.mesh.contact import Contacts
from radiosity.mesh.cutting import cut_cell
from radiosity.mesh.faces import Faces

NONE = -1


@dataclass(frozen=True)
class Grid:
    """Which cells a face was divided into, and which patches lie in a cell.

    Attributes
    ----------
    shape : (f, 2) int
        Cells along the two edges of a quadrilateral; (n, 0) is a triangle of n x n cells.
    first : (f,) int
        Index of a face's first cell.
    start : (cells + 1,) int
        The patches of cell c are ``start[c]`` to ``start[c + 1] - 1`` (more than one where cut).
    """

    shape: np.ndarray
    first: np.ndarray
    start: np.ndarray


@dataclass(frozen=True)
class Patches:
    """One-sided cells: the fronts of all faces, then the modelled backs.

    Attributes
    ----------
    vertices : (n, 4, 3) float64
        Scene units, counter-clockwise seen from the active side; a triangle repeats its last.
    normal : (n, 3) float64
        Unit vectors on the active side.
    area : (n,) float64
    centroid : (n, 3) float64
    radius : (n,) float64
        Of the circle about the centroid that holds the vertices.
    face : (n,) int
        Index into the scene's faces.
    front : (n,) bool
    back_of : (fronts,) int
        Index of the patch on the other side of a front, -1 where it is not modelled.
    behind : (fronts, 2) int
        The face that lies on a front or on its back and that a ray meets instead, -1 where none.
    grid : Grid
    """

    vertices: np.ndarray
    normal: np.ndarray
    area: np.ndarray
    centroid: np.ndarray
    radius: np.ndarray
    face: np.ndarray
    front: np.ndarray
    back_of: np.ndarray
    behind: np.ndarray
    grid: Grid

    def __len__(self) -> int:
        """Return the number of patches, both sides counted."""
        return len(self.area)

    @property
    def fronts(self) -> int:
        """Return how many patches are fronts; they come first."""
        return len(self.back_of)

    @property
    def covered(self) -> np.ndarray:
        """Return (fronts,) bool: fronts in contact, not part of the solution."""
        return self.behind[:, 0] >= 0

    def with_backs(self, wanted: np.ndarray) -> "Patches":
        """Return the fronts and, behind each front of the mask ``wanted``, its back."""
        k = np.flatnonzero(wanted)
        back_of = np.full(self.fronts, NONE)
        back_of[k] = self.fronts + np.arange(len(k))
        fronts = np.arange(self.fronts)
        both = np.concatenate([fronts, k])
        vertices = self.vertices[both]
        vertices[self.fronts :] = reversed_winding(vertices[self.fronts :])
        normal = self.normal[both]
        normal[self.fronts :] *= -1
        return replace(
            self,
            vertices=vertices,
            normal=normal,
            area=self.area[both],
            centroid=self.centroid[both],
            radius=self.radius[both],
            face=self.face[both],
            front=np.arange(len(both)) < self.fronts,
            back_of=back_of,
        )


def reversed_winding(vertices: np.ndarray) -> np.ndarray:
    """Return (n, 4, 3) polygons seen from behind; triangles keep their repeat at the end."""
    triangle = np.all(vertices[:, 3] == vertices[:, 2], axis=1)
    flipped = vertices[:, ::-1].copy()
    flipped[triangle] = vertices[triangle][:, [2, 1, 0, 0]]
    return flipped


def divisions(faces: Faces, size: float, rounding: Callable = np.ceil) -> np.ndarray:
    """Return (f, 2) how often each face is divided so that cells measure about ``size``.

    ``rounding`` makes whole numbers of the quotients.
    """
    v = faces.vertices
    edge = np.linalg.norm(np.roll(v, -1, axis=1) - v, axis=2)
    triangle = faces.is_triangle
    along = np.maximum(edge[:, [0, 1]], edge[:, [2, 3]])
    along[triangle, 0] = edge[triangle][:, [0, 1, 3]].max(axis=1)
    count = np.maximum(1, rounding(along / size - 1e-9)).astype(int)
    count[triangle, 1] = 0
    return count


def make_patches(faces: Faces, shape: np.ndarray, contacts: Contacts) -> Patches:
    """Divide every face into ``shape`` cells and cut them along the contacts.

    Parameters
    ----------
    faces : Faces
    shape : (f, 2) int
        As `divisions` returns it.
    contacts : Contacts
        Where faces touch, cross or cover each other.
    """
    cells, face, first = all_cells(faces, shape)
    vertices, counts, behind = _cut(cells, first, contacts)
    start = np.concatenate([[0], np.cumsum(counts)])
    face = np.repeat(face, counts)
    cross = _vector_area(vertices)
    area = np.linalg.norm(cross, axis=1)
    normal = cross / np.maximum(area, 1e-300)[:, None]
    centroid = centroids(vertices)
    radius = np.linalg.norm(vertices - centroid[:, None], axis=2).max(axis=1)
    n = len(area)
    return Patches(
        vertices, normal, area, centroid, radius, face, np.ones(n, bool),
        np.full(n, NONE), behind, Grid(shape, first, start),
    )  # fmt: skip


def all_cells(faces: Faces, shape: np.ndarray):
    """Return cell polygons (c, 4, 3), the face of each (c,) and each face's first cell (f,).

    Face by face; in a quadrilateral row by row from its first edge, in a triangle too.
    """
    triangle = shape[:, 1] == 0
    count = np.where(triangle, shape[:, 0] ** 2, shape[:, 0] * shape[:, 1])
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    cells = np.empty((count.sum(), 4, 3))
    for key in np.unique(shape, axis=0):
        same = np.flatnonzero(np.all(shape == key, axis=1))
        make = _triangle_cells if key[1] == 0 else _quad_cells
        block = make(faces.vertices[same], *key)
        cells[first[same][:, None] + np.arange(block.shape[1])] = block
    return cells, np.repeat(np.arange(len(count)), count), first


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


def _cut(cells, first, contacts: Contacts):
    """Cut the cells of faces that have contacts; return patches, how many a cell, `behind`."""
    whole = np.ones(len(cells), int)
    n_faces = len(first)
    if not contacts.faces:
        n = len(cells)
        return cells, whole, np.full((n, 2), NONE)
    pieces, behind = [], []
    ends = np.append(first[1:], len(cells))
    for f in range(n_faces):
        here = cells[first[f] : ends[f]]
        contact = contacts.faces.get(f)
        if contact is None:
            pieces.append(here)
            behind.append(np.full((len(here), 2), NONE))
            continue
        for k, cell in enumerate(here):
            parts = cut_cell(cell, contact.segments)
            whole[first[f] + k] = len(parts)
            pieces.append(parts)
            behind.append(contact.behind(centroids(parts)))
    return np.concatenate(pieces), whole, np.concatenate(behind)


def _vector_area(v: np.ndarray) -> np.ndarray:
    return 0.5 * np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1])


def centroids(v: np.ndarray) -> np.ndarray:
    """Return the centres of area of planar polygons (n, 4, 3)."""
    one = np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1)
    two = np.linalg.norm(np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 0]), axis=1)
    share = (one / np.maximum(one + two, 1e-300))[:, None]
    return (v[:, 0] + v[:, 2] + share * v[:, 1] + (1 - share) * v[:, 3]) / 3
