"""Patches: areas, normals, centroids, grids, backs, divisions."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, faces_of, halves, l_room, meshed, tetrahedron

from radiosity.mesh.division import divisions
from radiosity.mesh.patches import reversed_winding

SKEW = np.array([[0, 0, 0], [3, 0, 0], [2, 1, 0], [0.5, 1.5, 0]], float)


def made(polygons, n):
    faces = faces_of(polygons)
    return faces, meshed(faces, n)[2]


@pytest.mark.parametrize("n", [1, 2, 7])
@pytest.mark.parametrize(
    "polygons", [box((0, 0, 0), (4, 3, 2)), tetrahedron(), l_room(), SKEW[None]]
)
def test_patches_add_up_to_their_faces(polygons, n):
    faces, patches = made(polygons, n)
    areas = np.bincount(patches.face, patches.area)
    assert areas == pytest.approx(faces.areas(), rel=1e-12)  # rounding
    moment = np.stack([np.bincount(patches.face, patches.area * x) for x in patches.centroid.T], 1)
    _, whole = made(polygons, 1)
    assert moment == pytest.approx(areas[:, None] * whole.centroid, abs=1e-11)  # rounding
    assert patches.normal == pytest.approx(faces.normals()[patches.face], abs=1e-12)


def test_numbers_of_cells():
    _, quads = made(box((0, 0, 0), (1, 1, 1)), 5)
    _, triangles = made(tetrahedron(), 5)
    assert len(quads) == 6 * 25 and len(triangles) == 4 * 25


def test_quadrilaterals_stay_quadrilaterals_and_triangles_triangles():
    _, quads = made(np.concatenate([box((0, 0, 0), (1, 1, 1)), SKEW[None] - 5]), 4)
    assert not np.any(np.all(quads.vertices[:, 2] == quads.vertices[:, 3], axis=1))
    _, triangles = made(tetrahedron(), 4)
    assert np.all(triangles.vertices[:, 2] == triangles.vertices[:, 3])


def test_radius_holds_the_vertices():
    _, patches = made(np.concatenate([SKEW[None], tetrahedron()]), 3)
    away = np.linalg.norm(patches.vertices - patches.centroid[:, None], axis=2)
    assert away.max(axis=1) == pytest.approx(patches.radius, rel=1e-14)


def test_parts_of_cut_cells_keep_area_and_look():
    polygons = np.concatenate([box((0, 0, 0), (1, 1, 1)), block((0.31, 0.2, 0), (0.7, 0.63, 0.5))])
    faces, patches = made(polygons, 3)
    areas = np.bincount(patches.face, patches.area)
    assert areas == pytest.approx(faces.areas(), rel=1e-12)  # rounding
    assert patches.normal == pytest.approx(faces.normals()[patches.face], abs=1e-9)
    assert patches.grid.start[-1] == len(patches) and len(patches.grid.start) == 12 * 9 + 1
    counts = np.diff(patches.grid.start)
    assert counts.min() == 1 and counts.max() > 1


def test_backs_lie_behind_their_fronts():
    _, patches = made(np.concatenate([SKEW[None], tetrahedron()]), 2)
    wanted = np.arange(len(patches)) % 3 == 1
    both = patches.with_backs(wanted)
    n = patches.fronts
    assert len(both) == n + wanted.sum() and both.fronts == n
    back = both.back_of[wanted]
    assert np.array_equal(back, np.arange(n, len(both))) and np.all(both.back_of[~wanted] == -1)
    assert np.array_equal(both.normal[back], -patches.normal[wanted])
    assert np.array_equal(both.area[back], patches.area[wanted])
    assert np.array_equal(both.face[back], patches.face[wanted])
    assert both.front[:n].all() and not both.front[n:].any()
    v = both.vertices
    cross = np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1])
    assert cross == pytest.approx(2 * both.area[:, None] * both.normal, abs=1e-12)
    assert len(patches) == n and patches.front.all()  # the original is what it was


def test_reversed_winding_twice_is_the_same_polygon():
    polygons = np.stack([SQUARE, SQUARE[[0, 1, 2, 2]]])
    flipped = reversed_winding(polygons)
    assert np.array_equal(flipped[1, 2], flipped[1, 3])
    area = np.cross(flipped[:, 2] - flipped[:, 0], flipped[:, 3] - flipped[:, 1])[:, 2]
    assert np.array_equal(area, [-2, -1])
    assert np.array_equal(reversed_winding(flipped), polygons)


def test_divisions_make_cells_of_about_the_size():
    faces = faces_of(np.stack([SQUARE * [3, 1, 1], SQUARE[[0, 1, 2, 2]], SQUARE * 1e-3]))
    assert divisions(faces, 0.5).shape.tolist() == [[6, 2], [2, 0], [1, 1]]
    assert divisions(faces, 0.3).shape.tolist() == [[10, 4], [3, 0], [1, 1]]
    assert divisions(faces, 1e9).shape.tolist() == [[1, 1], [1, 0], [1, 1]]


def test_a_room_of_triangles_is_divided_about_as_one_of_squares():
    triangles = faces_of(halves(box((0, 0, 0), (1, 1, 1))))
    for size in (0.5, 0.2, 0.05):
        wanted = 6.0 / size**2
        assert wanted <= divisions(triangles, size, np.rint).count <= 2.0 * wanted


def test_divisions_do_not_depend_on_the_unit():
    faces, small = faces_of(l_room()), faces_of(l_room() * 1e-9)
    assert np.array_equal(divisions(faces, 0.1).shape, divisions(small, 0.1e-9).shape)
