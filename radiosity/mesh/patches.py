"""Patches: the one-sided cells that carry radiosity, and the table that finds them again."""

from dataclasses import dataclass, replace

import numpy as np

from radiosity.mesh.contact import Contacts
from radiosity.mesh.cutting import cut_cells
from radiosity.mesh.division import Division
from radiosity.mesh.faces import Faces

NONE = -1


@dataclass(frozen=True)
class Grid:
    """Which cells the faces were divided into, and which patches lie in a cell.

    Attributes
    ----------
    division : Division
    start : (cells + 1,) int
        The patches of cell c are ``start[c]`` to ``start[c + 1] - 1`` (more than one where cut).
    """

    division: Division
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
    def front_of(self) -> np.ndarray:
        """Return (n,) the front of each patch: itself, or the one that it is the back of."""
        fronts = np.arange(len(self))
        behind = np.flatnonzero(self.back_of >= 0)
        fronts[self.back_of[behind]] = behind
        return fronts

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


def make_patches(faces: Faces, division: Division, contacts: Contacts) -> Patches:
    """Divide every face into cells and cut them along the contacts.

    Parameters
    ----------
    faces : Faces
    division : Division
    contacts : Contacts
        Where faces touch, cross or cover each other.
    """
    vertices, counts, behind = _cut(division.cells(faces), division.ends, contacts)
    start = np.concatenate([[0], np.cumsum(counts)])
    face = np.repeat(division.face, counts)
    cross = _vector_area(vertices)
    area = np.linalg.norm(cross, axis=1)
    normal = cross / np.maximum(area, 1e-300)[:, None]
    centroid = centroids(vertices)
    radius = np.linalg.norm(vertices - centroid[:, None], axis=2).max(axis=1)
    n = len(area)
    return Patches(
        vertices, normal, area, centroid, radius, face, np.ones(n, bool),
        np.full(n, NONE), behind, Grid(division, start),
    )  # fmt: skip


def _cut(cells, ends, contacts: Contacts):
    """Cut the cells of faces that have contacts; return patches, how many a cell, `behind`."""
    whole = np.ones(len(cells), int)
    if not contacts.faces:
        return cells, whole, np.full((len(cells), 2), NONE)
    pieces, behind = [], []
    for f in range(len(ends) - 1):
        here = cells[ends[f] : ends[f + 1]]
        contact = contacts.faces.get(f)
        if contact is None:
            pieces.append(here)
            behind.append(np.full((len(here), 2), NONE))
            continue
        parts, whole[ends[f] : ends[f + 1]] = cut_cells(here, contact.segments, contact.normal)
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
