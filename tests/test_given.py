"""Meshes as users hold them: what each becomes, and what each mistake is told."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, faces_of

from radiosity.mesh.given import given_mesh

pyvista = pytest.importorskip("pyvista")
trimesh = pytest.importorskip("trimesh")

L = np.array([(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)], float)
PENTAGON = np.array([[np.cos(a), np.sin(a), 0] for a in 2 * np.pi * np.arange(5) / 5])
WITH_TIP = np.vstack([SQUARE, [[2.0, 0.5, 0.0]]])  # a triangle beside the square


def areas(given):
    """Of the user's faces."""
    return np.bincount(given.owner, given.faces.areas(), minlength=given.count)


def up(given):
    return given.faces.normals() == pytest.approx(np.tile([0, 0, 1.0], (len(given.faces), 1)))


# ---------------------------------------------------------------------- what is taken


def test_trimesh_faces_are_rows_in_order():
    mesh = trimesh.creation.box((1, 2, 3))
    given = given_mesh(mesh)
    assert given.count == len(mesh.faces) == len(given.faces) == 12
    assert given.owner.tolist() == list(range(12))
    assert np.array_equal(given.faces.vertices[:, :3], mesh.triangles)
    # 1e-15: trimesh's own rounding
    assert given.faces.normals() == pytest.approx(mesh.face_normals, abs=1e-15)
    assert given.faces.areas() == pytest.approx(mesh.area_faces, rel=1e-15)


@pytest.mark.parametrize("triangles", [False, True], ids=["quadrilaterals", "triangles"])
def test_polydata_of_equal_cells(triangles):
    mesh = pyvista.Box((0, 1, 0, 2, 0, 3))
    mesh = mesh.triangulate() if triangles else mesh
    given = given_mesh(mesh)
    assert given.count == len(given.faces) == mesh.n_cells == (12 if triangles else 6)
    assert np.all(given.faces.is_triangle == triangles)
    for k in range(mesh.n_cells):
        corners = mesh.points[mesh.get_cell(k).point_ids]
        assert np.array_equal(given.faces.vertices[k, : len(corners)], corners)
    assert areas(given).sum() == pytest.approx(22.0, rel=1e-15)


def test_polydata_of_mixed_cells():
    mesh = pyvista.PolyData(np.vstack([WITH_TIP, L + [5, 0, 0]]),
                            faces=[3, 1, 4, 2, 6, *range(5, 11), 4, 0, 1, 2, 3])  # fmt: skip
    given = given_mesh(mesh)
    assert given.count == 3 and set(given.owner) == {0, 1, 2}
    # 1e-6: pyvista may keep points in single precision
    assert areas(given) == pytest.approx([0.5, 3.0, 1.0], rel=1e-6)
    assert up(given)


ONE_SQUARE = [
    (SQUARE, np.array([[0, 1, 2, 3]])),
    [SQUARE, [[0, 1, 2, 3]]],
    (SQUARE.tolist(), [(0, 1, 2, 3)]),
    (SQUARE.astype(np.float32), np.array([[0, 1, 2, 3]], np.uint32)),
    (SQUARE.astype(int), np.array([[0, 1, 2, 3]], np.int16)),
    pyvista.PolyData(SQUARE, faces=[4, 0, 1, 2, 3]),
    faces_of(SQUARE[None]),
]


@pytest.mark.parametrize("mesh", ONE_SQUARE, ids=range(len(ONE_SQUARE)))
def test_one_square_in_many_guises(mesh):
    given = given_mesh(mesh)
    assert given.count == 1 and given.owner.tolist() == [0]
    assert np.array_equal(given.faces.vertices, SQUARE[None])
    assert given.faces.vertices.dtype == float


def test_faces_of_a_scene_stay_as_they_are():
    faces = faces_of(box((0, 0, 0), (1, 2, 3)))
    given = given_mesh(faces)
    assert given.faces is faces and given.owner.tolist() == list(range(6)) and given.count == 6


def test_lists_of_polygons_of_any_length():
    vertices = np.vstack([PENTAGON, L + [5, 0, 0], WITH_TIP - [5, 0, 0]])
    given = given_mesh((vertices, [[12, 15, 13], range(5), np.arange(5, 11), [11, 12, 13, 14]]))
    pentagon = 2.5 * np.sin(2 * np.pi / 5)
    assert areas(given) == pytest.approx([0.5, pentagon, 3.0, 1.0], rel=1e-14)
    assert np.all(np.diff(given.owner) >= 0)  # pieces of a face lie together, in order
    assert up(given)


def test_polygons_of_one_length_beyond_four():
    given = given_mesh((np.vstack([PENTAGON, PENTAGON + [5, 0, 0]]), np.arange(10).reshape(2, 5)))
    assert given.count == 2 and areas(given) == pytest.approx([2.5 * np.sin(2 * np.pi / 5)] * 2)


@pytest.mark.parametrize("repeated", [[0, 1, 2, 2], [0, 0, 1, 2], [0, 1, 1, 2], [0, 1, 2, 0]])
def test_a_quadrilateral_with_a_repeated_vertex_is_a_triangle(repeated):
    given = given_mesh((SQUARE, np.array([repeated, [0, 1, 2, 3]])))
    assert given.owner.tolist() == [0, 1] and given.faces.is_triangle.tolist() == [True, False]
    assert areas(given).tolist() == [0.5, 1.0] and up(given)


@pytest.mark.parametrize("first", range(4))
def test_a_concave_quadrilateral_becomes_two_pieces(first):
    dart = np.roll(np.array([(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)], float), first, axis=0)
    vertices = np.vstack([dart, SQUARE + [5, 0, 0]])
    given = given_mesh((vertices, np.array([[4, 5, 6, 7], [0, 1, 2, 3], [4, 5, 6, 7]])))
    assert given.owner.tolist() == [0, 1, 1, 2] and given.count == 3
    assert areas(given) == pytest.approx([1.0, 1.0, 1.0], rel=1e-15) and up(given)


def test_a_quadrilateral_that_is_not_planar_becomes_two_triangles():
    bent = SQUARE + [[0, 0, 0], [0, 0, 0], [0, 0, 0.25], [0, 0, 0]]
    given = given_mesh((bent, [[0, 1, 2, 3]]))
    assert given.owner.tolist() == [0, 0] and given.faces.is_triangle.all()
    halves = 0.5 * np.linalg.norm(np.cross(bent[2], bent[[1, 3]]), axis=1)
    assert given.faces.areas() == pytest.approx(halves, rel=1e-15)
    assert not np.allclose(*given.faces.normals())


@pytest.mark.parametrize("faces", [
    np.array([[0, 1, 1], [0, 1, 2], [1, 1, 1]]),
    [[0, 1, 1], [0, 1, 2], [0, 1, 0, 1]],
], ids=["triangles", "mixed"])  # fmt: skip
def test_faces_without_area_keep_their_number_and_have_no_piece(faces):
    given = given_mesh((SQUARE, faces))
    assert given.count == 3 and given.owner.tolist() == [1] and areas(given).tolist() == [0, 0.5, 0]


def test_the_mesh_stays_as_it_was():
    vertices, faces = SQUARE.copy(), np.array([[0, 1, 2, 3]])
    given_mesh((vertices, faces)).faces.vertices[:] = 7.0
    assert np.array_equal(vertices, SQUARE) and faces.tolist() == [[0, 1, 2, 3]]


# ---------------------------------------------------------------------- mistakes


def with_vertex(value):
    vertices = SQUARE.copy()
    vertices[2, 1] = value
    return vertices


MISTAKES = {
    "NaN": ((with_vertex(np.nan), [[0, 1, 2]]),
            r"mesh: vertex 2 = \[1.0, nan, 0.0\] must be finite .* repair the mesh"),
    "infinite": ((with_vertex(-np.inf), [[0, 1, 2]]), r"vertex 2 = \[1.0, -inf, 0.0\]"),
    "huge": ((with_vertex(2e15), [[0, 1, 2]]), r"at most 1e\+15: choose another unit of length"),
    "flat": ((SQUARE[:, :2], [[0, 1, 2]]), r"vertices have shape \(4, 2\) and must be \(n, 3\)"),
    "beyond": ((SQUARE, [[0, 1, 2], [1, 2, 4]]),
               r"face 1 = \[1, 2, 4\] names a vertex that does not exist: there are 4, counted"),
    "negative": ((SQUARE, [[0, 1, 2], [0, 2, -1]]), r"face 1 = \[0, 2, -1\] names a vertex"),
    "beyond, mixed": ((SQUARE, [[0, 1, 2], [0, 1, 2, 9]]), r"face 1 = \[0, 1, 2, 9\] names"),
    "no vertices": ((np.empty((0, 3)), [[0, 1, 2]]), r"face 0 = \[0, 1, 2\] .* there are 0"),
    "float": ((SQUARE, np.array([[0.0, 1.0, 2.0]])),
              r"face 0 holds float64 and must hold whole numbers"),
    "float, mixed": ((SQUARE, [[0, 1, 2, 3], [0, 1.5, 2]]), r"face 1 holds float64 and must"),
    "truth values": ((SQUARE, np.array([[True, False, True]])), "face 0 holds bool"),
    "no faces": ((SQUARE, []), "mesh has no faces: give at least one"),
    "no rows": ((SQUARE, np.empty((0, 3), int)), "mesh has no faces: give at least one"),
    "no cells": (pyvista.PolyData(), "mesh has no faces: give at least one"),
    "two corners": ((SQUARE, [[0, 1, 2], [0, 1]]),
                    "face 1 has 2 vertices, a polygon needs at least 3"),
    "bow tie": ((SQUARE, [[0, 1, 2, 3], [0, 2, 1, 3]]),
                r"face 1 crosses itself: edge 0 .* give the vertices in order"),
    "bent pentagon": ((PENTAGON + np.outer([0, 0, 0, 0, 0.3], [0, 0, 1]), [range(5)]),
                      "face 0 is not planar: vertex .* split it into triangles"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_told_where_and_why(mistake):
    mesh, message = MISTAKES[mistake]
    with pytest.raises(ValueError, match=message):
        given_mesh(mesh)


@pytest.mark.parametrize(
    "mesh, kind", [(3, "int"), (SQUARE, "ndarray"), ((SQUARE,), "tuple"), ({}, "dict")]
)
def test_what_is_no_mesh_is_named(mesh, kind):
    with pytest.raises(TypeError, match=f"mesh is a {kind} and must be a trimesh.Trimesh, a pyvis"):
        given_mesh(mesh)


def test_messages_call_the_mesh_by_its_name():
    with pytest.raises(ValueError, match="obstructions has no faces"):
        given_mesh((SQUARE, []), "obstructions")
    with pytest.raises(ValueError, match="obstructions: face 0 = "):
        given_mesh((SQUARE, [[0, 1, 9]]), "obstructions")
