"""What faces have at their corners: between them, joined, moved, and normals made of faces'."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, TRIANGLE, faces_of, halves, rotation, uv_sphere

from radiosity.mesh.corners import (
    FRONT,
    between,
    in_front,
    normal_between,
    onto_curve,
    slopes,
    weights,
)
from radiosity.mesh.curves import smooth_normals
from radiosity.mesh.faces import Faces
from radiosity.scene.geometry import Geometry

CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
UV = np.array([[[0.2, 0.1], [0.9, 0.3], [1.4, 2.0], [-0.5, 1.0]]])


def geometry(faces):
    return Geometry(faces, ("m",), ("g",))


def test_corners_have_their_own_values():
    for triangle in (False, True):
        at = CORNERS[[0, 1, 3]] if triangle else CORNERS
        found = between(np.repeat(UV, len(at), axis=0), weights(at, np.full(len(at), triangle)))
        np.testing.assert_array_equal(found, UV[0, : len(at)])


@pytest.mark.parametrize("triangle", [False, True])
def test_weights_add_up_to_one_and_follow_their_slopes(triangle):
    st, step = np.random.default_rng(0).uniform(0.1, 0.4, (20, 2)), 1e-6
    kind = np.full(20, triangle)
    np.testing.assert_allclose(weights(st, kind).sum(axis=1), 1, rtol=1e-15)
    for axis in (0, 1):
        d = step * np.eye(2)[axis]
        rise = (weights(st + d, kind) - weights(st - d, kind)) / (2 * step)
        np.testing.assert_allclose(slopes(st, kind)[..., axis], rise, atol=1e-9)  # rounding / step


def test_between_corners_a_triangle_is_linear_and_a_quadrilateral_bilinear():
    st = np.random.default_rng(1).uniform(0, 0.5, (50, 2))
    s, t = st[:, :1], st[:, 1:]
    a, b, c, d = UV[0]
    values = np.repeat(UV, 50, axis=0)
    linear = between(values, weights(st, np.ones(50, bool)))
    np.testing.assert_allclose(linear, a + s * (b - a) + t * (c - a), atol=1e-14)
    bilinear = between(values, weights(st, np.zeros(50, bool)))
    np.testing.assert_allclose(bilinear, a + s * (b - a) + t * (d - a) + s * t * (a - b + c - d))


def test_normals_between_are_unit_vectors_of_the_mean():
    own = np.array([[0.0, 0, 1]])
    corner = np.array([[[0.6, 0, 0.8], [0, 0, 1], [0, 0, 1], [0, 0, 1]]])
    middle = normal_between(corner, np.full((1, 4), 0.25), own)
    expected = np.array([0.15, 0, 0.95]) / np.hypot(0.15, 0.95)
    np.testing.assert_allclose(middle, [expected], rtol=1e-14)
    np.testing.assert_array_equal(normal_between(corner * np.nan, np.full((1, 4), 0.25), own), own)


def test_normals_that_point_into_the_face_are_bent_to_its_front():
    own = np.repeat([[0.0, 0, 1]], 3, axis=0)
    found = in_front(np.array([[1.0, 0, 1], [1, 0, -1], [0, 0, -1]]), own)
    np.testing.assert_allclose(np.linalg.norm(found[:2], axis=1), 1, rtol=1e-14)
    np.testing.assert_allclose(found[:2, 2], [np.sqrt(0.5), FRONT])
    assert found[1, 0] > 0 and found[2, 2] > 0


def test_points_are_raised_to_convex_surfaces_only():
    """On a unit sphere, at the middle x of an edge: x (1 + (1 - c)/2), c its ends' cosine."""
    one, two = np.array([0.0, 0, 1]), np.array([0.6, 0, 0.8])
    corners = np.array([[one, two, [0, 0.6, 0.8], [0, 0.6, 0.8]]])
    weight = np.array([[0.5, 0.5, 0, 0]])
    middle = (one + two)[None] / 2
    found = onto_curve(middle, corners, corners, weight)
    np.testing.assert_allclose(found, middle * (1 + 0.1), rtol=1e-14)
    assert np.linalg.norm(found) == pytest.approx(1, abs=0.05)  # as far out as it was inside
    np.testing.assert_array_equal(onto_curve(middle, corners, -corners, weight), middle)


def normals_of(sphere):
    return Faces(sphere, *np.zeros((2, len(sphere)), int), corner_normals=-sphere)


def test_a_moved_sphere_has_the_normals_of_an_ellipsoid():
    """x = M y with |y| = 1 has the normal M^-T y, also where M mirrors."""
    rng = np.random.default_rng(2)
    for sign in (1, -1):
        matrix = np.eye(4)
        matrix[:3, :3] = rotation(rng) @ np.diag([1, 2, sign * 0.5]) @ rotation(rng)
        matrix[:3, 3] = [3, 4, 5]
        moved = geometry(normals_of(uv_sphere(4))).placed(matrix).faces
        inverse = np.linalg.inv(matrix[:3, :3])
        on_sphere = (moved.vertices - matrix[:3, 3]) @ inverse.T
        expected = -on_sphere @ inverse
        expected /= np.linalg.norm(expected, axis=2, keepdims=True)
        np.testing.assert_allclose(moved.corner_normals, expected, atol=1e-12)
        cosine = np.einsum("fvc,fc->fv", moved.corner_normals, moved.normals())
        assert cosine.min() > 0  # still on the fronts


def test_texture_coordinates_stay_with_their_corners_when_mirrored():
    quads = np.array([SQUARE, TRIANGLE])
    uv = np.array([SQUARE, TRIANGLE])[..., :2] * 2
    faces = Faces.from_polygons(quads, 0, 0, uv=uv)
    moved = geometry(faces).placed(np.diag([-3.0, 1, 1, 1])).faces
    assert (moved.normals()[:, 2] == 1).all()
    np.testing.assert_allclose(moved.uv, moved.vertices[..., :2] * [-2 / 3, 2])


def test_parts_with_and_without_details_are_put_together():
    plain = faces_of([SQUARE + 5])
    rich = Faces.from_polygons([SQUARE], 0, 0, uv=[CORNERS], corner_normals=[SQUARE + [0, 0, 1]])
    both = Faces.concatenate([plain, rich])
    assert np.isnan(both.uv[0]).all() and np.isnan(both.corner_normals[0]).all()
    np.testing.assert_array_equal(both.uv[1], CORNERS)
    assert Faces.concatenate([plain, plain]).uv is None
    some = Faces.from_polygons([SQUARE, 0 * SQUARE, SQUARE + 1], 0, 0, uv=[CORNERS, UV[0], UV[0]])
    np.testing.assert_array_equal(some.uv, [CORNERS, UV[0]])  # the one without area is gone


def test_halves_are_joined_where_coordinates_are_affine_on_skew_faces_too():
    skew = np.array([[0, 0, 0], [3, 0.2, 0], [2.5, 1, 0], [0.2, 1.5, 0]])
    for quad in (SQUARE, skew):
        two = halves(quad[None])
        affine = two[..., :2] @ np.array([[0.3, 1.0], [-2.0, 0.1]]) + 7
        joined = Faces.from_polygons(two, 0, 0, uv=affine)
        assert len(joined) == 1
        np.testing.assert_allclose(joined.uv[0], quad[:, :2] @ [[0.3, 1.0], [-2.0, 0.1]] + 7)
        affine[1, 2:, 0] += 0.01
        assert len(Faces.from_polygons(two, 0, 0, uv=affine)) == 2


def test_smooth_normals_of_a_cube_are_its_diagonals_or_its_faces():
    from scenes_for_tests import block

    cube = faces_of(block((0, 0, 0), (2, 2, 2)))
    np.testing.assert_allclose(smooth_normals(cube, 100), (cube.vertices - 1) / np.sqrt(3))
    flat = smooth_normals(cube, 80)
    np.testing.assert_allclose(flat, np.repeat(cube.normals()[:, None], 4, axis=1), atol=1e-15)


def test_smooth_normals_do_not_depend_on_how_faces_are_cut():
    """Angles are the weights: a square corner cut into two triangles counts as one."""
    from scenes_for_tests import block

    cube = faces_of(halves(block((0, 0, 0), (2, 2, 2))))
    found = smooth_normals(cube, 100)
    np.testing.assert_allclose(found, (cube.vertices - 1) / np.sqrt(3), atol=1e-12)


def test_smooth_normals_of_a_sphere_converge_to_its_own():
    errors = []
    for n in (16, 32, 64):
        faces = faces_of(uv_sphere(n))
        errors.append(np.abs(smooth_normals(faces, 60) + faces.vertices).max())
    assert errors[-1] < 5e-3
    assert (np.log2(errors[:-1]) - np.log2(errors[1:]) > 1.9).all()  # order 2 in the faces' size
