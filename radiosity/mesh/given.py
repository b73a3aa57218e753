"""Meshes as users hold them: arrays or objects with vertices and faces, as convex pieces."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.faces import Faces, has_area
from radiosity.mesh.triangulate import NoArea, convex_quads, triangulate

LARGEST = 1e15  # a coordinate whose fourth power is still far from overflow


@dataclass(frozen=True)
class Given:
    """The planar convex pieces of a mesh and the face that each is a part of.

    Attributes
    ----------
    faces : Faces
    owner : (f,) int
        Index of the user's face; faces without area have no piece.
    count : int
        How many faces the user has.
    """

    faces: Faces
    owner: np.ndarray
    count: int

    @property
    def size(self) -> int:
        """Return how many faces or pieces there are, whichever are more."""
        return max(self.count, len(self.faces))


def given_mesh(mesh, name: str = "mesh") -> Given:
    """Return the pieces of a mesh object or of arrays.

    Parameters
    ----------
    mesh : trimesh.Trimesh, pyvista.PolyData, (vertices, faces), Faces or Given
        vertices (v, 3) and faces (f, k) of indices from 0, or a list of polygons of any length,
        counter-clockwise seen from the active side; quadrilaterals may end in a repeated vertex.

    Raises
    ------
    TypeError
        Something else.
    ValueError
        Says which vertex or face is wrong, its value, the bound and the way out.
    """
    if isinstance(mesh, Given):
        return mesh
    if isinstance(mesh, Faces):
        return Given(mesh, np.arange(len(mesh)), len(mesh))
    vertices, polygons = _arrays(mesh, name)
    vertices = np.asarray(vertices, float)
    _check_vertices(vertices, name)
    if len(polygons) == 0:
        raise ValueError(f"{name} has no faces: give at least one")
    shape = getattr(polygons, "shape", ())
    if len(shape) == 2 and shape[1] in (3, 4):
        return _of_equal_length(vertices, np.asarray(polygons), name)
    return _of_any_length(vertices, polygons, name)


def _arrays(mesh, name):
    """Return vertices and faces by the attributes that trimesh and pyvista give them."""
    if hasattr(mesh, "points") and hasattr(mesh, "faces"):
        return mesh.points, _unpacked(np.asarray(mesh.faces))
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return mesh.vertices, mesh.faces
    if isinstance(mesh, tuple | list) and len(mesh) == 2:
        vertices, faces = mesh
        if not all(hasattr(f, "__len__") for f in faces):
            raise ValueError(
                f"{name}: faces must be an array (n, 3) or (n, 4) or a list of lists of vertices, "
                f"not {len(faces)} numbers"
            )
        regular = isinstance(faces, np.ndarray) or len({len(f) for f in faces}) == 1
        return vertices, np.asarray(faces) if regular else faces
    raise TypeError(
        f"{name} is a {type(mesh).__name__} and must be a trimesh.Trimesh, a pyvista.PolyData, "
        "(vertices, faces) or the path of a mesh file"
    )


def _unpacked(packed):
    """Return the polygons of VTK's list: count, indices, count, indices, ..."""
    if len(packed) and packed[0] > 0 and len(packed) % (packed[0] + 1) == 0:
        table = packed.reshape(-1, packed[0] + 1)
        if np.all(table[:, 0] == packed[0]):
            return table[:, 1:]
    polygons, k = [], 0
    while k < len(packed):
        polygons.append(packed[k + 1 : k + 1 + packed[k]])
        k += packed[k] + 1
    return polygons


def _check_vertices(vertices, name):
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError(f"{name}: vertices have shape {vertices.shape} and must be (n, 3)")
    bad = np.flatnonzero(~(np.abs(vertices) <= LARGEST).all(axis=1))
    if len(bad):
        raise ValueError(
            f"{name}: vertex {bad[0]} = {vertices[bad[0]].tolist()} must be finite and at most "
            f"{LARGEST:g}: choose another unit of length, or repair the mesh"
        )


def _check_indices(index, face, count, name):
    if index.dtype.kind not in "iu":
        raise ValueError(f"{name}: face {face} holds {index.dtype} and must hold whole numbers")
    if index.size and (index.min() < 0 or index.max() >= count):
        raise ValueError(
            f"{name}: face {face} = {index.tolist()} names a vertex that does not exist: there are "
            f"{count}, counted from 0"
        )


def _of_equal_length(vertices, index, name):
    """Return the pieces of triangles or quadrilaterals, most of them as they are."""
    wrong = np.flatnonzero(((index < 0) | (index >= len(vertices))).any(axis=1))
    face = int(wrong[0]) if len(wrong) else 0
    _check_indices(index[face], face, len(vertices), name)
    quads = vertices[index[:, [0, 1, 2, 2]] if index.shape[1] == 3 else index]
    triangle = np.all(quads[:, 3] == quads[:, 2], axis=1)
    good = triangle | convex_quads(quads)
    pieces, owner = [quads[good]], [np.flatnonzero(good)]
    for f in np.flatnonzero(~good):
        parts = _pieces(quads[f], f, name)
        pieces.append(parts)
        owner.append(np.full(len(parts), f))
    return _without_empty(np.concatenate(pieces), np.concatenate(owner), len(index))


def _of_any_length(vertices, polygons, name):
    pieces, owner = [np.empty((0, 4, 3))], [np.empty(0, int)]
    for f, polygon in enumerate(polygons):
        index = np.asarray(polygon)
        _check_indices(index, f, len(vertices), name)
        parts = _pieces(vertices[index], f, name)
        pieces.append(parts)
        owner.append(np.full(len(parts), f))
    return _without_empty(np.concatenate(pieces), np.concatenate(owner), len(polygons))


def _pieces(polygon, face, name):
    try:
        return triangulate(polygon)
    except NoArea:
        return np.empty((0, 4, 3))
    except ValueError as error:
        raise ValueError(f"{name}: face {face} {error}") from None


def _without_empty(pieces, owner, count):
    """Drop pieces without area; put those of one face next to each other."""
    order = np.argsort(owner, kind="stable")
    pieces, owner = pieces[order], owner[order]
    faces = Faces.from_polygons(pieces, 0, 0, merge=False)
    return Given(faces, owner[has_area(pieces)], count)
