"""Smooth fields over patches: linear fields exactly, nothing across creases and colours."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, faces_of, meshed, rotation, tetrahedron, uv_sphere

from radiosity.mesh.interpolation import corner_matrix, corner_values, find_neighbours, gradients

TRAPEZOID = np.array([[0, 0, 0], [3, 0, 0], [2, 1, 0], [0.5, 1, 0]], float)
SLOPES = np.array([[1.0, -2.0, 0.5], [0.0, 0.0, 0.0], [-0.3, 0.7, 3.0]])  # (bands, 3)


def linear(points):
    return 50.0 + points @ SLOPES.T


def smoothed(patches, kind, values, live=None):
    live = np.ones(len(patches), bool) if live is None else live
    around = find_neighbours(patches, live, kind)
    slope = gradients(patches, around, values)
    return around, slope, corner_values(patches, around, values, slope)


def in_plane(patches):
    """(n, bands, 3): the slopes of `linear` within the plane of each patch."""
    n = patches.normal
    return SLOPES[None] - np.einsum("bc,nc->nb", SLOPES, n)[:, :, None] * n[:, None]


@pytest.mark.parametrize(
    "polygon", [SQUARE, SQUARE * [4, 1, 1], TRAPEZOID, SQUARE[[0, 1, 2, 2]]],
    ids=["square", "long", "trapezoid", "triangle"],
)  # fmt: skip
@pytest.mark.parametrize("n", [3, 6])
def test_linear_fields_are_exact_also_at_borders(polygon, n):
    turn = rotation(np.random.default_rng(0))
    _, _, patches = meshed(faces_of((polygon @ turn.T + 2)[None]), n)
    values = linear(patches.centroid)
    around, slope, corners = smoothed(patches, np.zeros(len(patches), int), values)
    told = np.bincount(around.corner // 4, minlength=len(patches)) > 4
    # 1e-9: least squares of exact data, in cells down to 1/24 wide
    assert slope[told] == pytest.approx(in_plane(patches)[told], abs=1e-9)
    assert told.all()
    assert corners == pytest.approx(linear(patches.vertices), abs=1e-9)


def test_neighbours_across_faces_of_one_plane_count():
    """Two squares side by side, of one material, carry one smooth field."""
    _, _, patches = meshed(faces_of(np.stack([SQUARE, SQUARE + [1, 0, 0]])), 2)
    values = linear(patches.centroid)
    around, slope, corners = smoothed(patches, np.zeros(len(patches), int), values)
    own = around.corner // 4
    assert np.any(patches.face[own] != patches.face[around.patch])
    assert slope == pytest.approx(in_plane(patches), abs=1e-10)
    assert corners == pytest.approx(linear(patches.vertices), abs=1e-10)


def test_nothing_is_smoothed_across_materials():
    _, _, patches = meshed(faces_of(np.stack([SQUARE, SQUARE + [1, 0, 0]])), 3)
    values = np.where(patches.face == 0, 1.0, 9.0)[:, None]
    around, slope, corners = smoothed(patches, patches.face, values)
    assert np.array_equal(patches.face[around.corner // 4], patches.face[around.patch])
    assert np.all(slope == 0) and np.array_equal(corners, np.repeat(values[:, None], 4, 1))


@pytest.mark.parametrize("polygons", [box((0, 0, 0), (1, 2, 3)), tetrahedron()])
def test_nothing_is_smoothed_across_creases(polygons):
    _, _, patches = meshed(faces_of(polygons), 3)
    values = patches.face[:, None] + 1.0
    around, slope, corners = smoothed(patches, np.zeros(len(patches), int), values)
    assert np.array_equal(patches.face[around.corner // 4], patches.face[around.patch])
    assert slope == pytest.approx(0, abs=1e-12)
    assert corners == pytest.approx(np.repeat(values[:, None], 4, 1), rel=1e-13)


def test_dead_patches_and_other_sides_stay_apart():
    _, _, patches = meshed(faces_of(SQUARE[None]), 4)
    both = patches.with_backs(np.ones(len(patches), bool))
    live = np.arange(len(both)) % 5 != 0
    around = find_neighbours(both, live, np.zeros(len(both), int))
    own = around.corner // 4
    assert live[own].all() and live[around.patch].all()
    assert np.array_equal(both.front[own], both.front[around.patch])


def test_a_curved_surface_is_smooth():
    _, _, patches = meshed(faces_of(uv_sphere(12)), 1)
    around = find_neighbours(patches, np.ones(len(patches), bool), np.zeros(len(patches), int))
    assert np.mean(np.bincount(around.corner, minlength=4 * len(patches))) > 3.5


@pytest.mark.parametrize("polygons", [box((0, 0, 0), (1, 2, 3)), uv_sphere(8), SQUARE[None]])
@pytest.mark.parametrize("n", [1, 3])
def test_a_constant_field_stays_constant(polygons, n):
    _, _, patches = meshed(faces_of(polygons), n)
    values = np.full((len(patches), 2), 3.7)
    _, slope, corners = smoothed(patches, np.zeros(len(patches), int), values)
    assert np.all(slope == 0)
    assert corners == pytest.approx(np.full(corners.shape, 3.7), rel=1e-14)


def test_gradients_turn_and_scale_with_the_mesh():
    rng = np.random.default_rng(1)
    _, _, patches = meshed(faces_of(SQUARE[None]), 5)
    values = rng.random((25, 2))
    _, slope, _ = smoothed(patches, np.zeros(25, int), values)
    for size in (1e-6, 1e6):
        turn = rotation(rng)
        _, _, moved = meshed(faces_of(size * (SQUARE @ turn.T + 1)[None]), 5)
        _, found, _ = smoothed(moved, np.zeros(25, int), values)
        assert size * found == pytest.approx(slope @ turn.T, abs=1e-9)


def test_smooth_fields_converge_with_second_order():
    """Corner values of sin(2 x) cos(3 y): the error falls as h^2."""
    errors = []
    for n in (8, 16, 32):
        _, _, patches = meshed(faces_of(SQUARE[None]), n)
        field = lambda p: 2 + np.sin(2 * p[..., :1]) * np.cos(3 * p[..., 1:2])  # noqa: E731
        _, _, corners = smoothed(patches, np.zeros(n * n, int), field(patches.centroid))
        errors.append(np.sqrt(np.mean((corners - field(patches.vertices)) ** 2)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 2e-3
    assert orders == pytest.approx(2, abs=0.25)


def test_corner_values_are_never_negative():
    _, _, patches = meshed(faces_of(SQUARE[None]), 4)
    values = np.maximum(0, patches.centroid[:, :1] - 0.5)
    _, _, corners = smoothed(patches, np.zeros(16, int), values)
    assert corners.min() >= 0


def test_one_patch_alone_keeps_its_value():
    _, _, patches = meshed(faces_of(SQUARE[None]), 1)
    _, slope, corners = smoothed(patches, np.zeros(1, int), np.array([[2.0, 5.0]]))
    assert np.all(slope == 0) and np.array_equal(corners, [[[2.0, 5.0]] * 4])


def test_the_matrix_makes_the_values_at_corners():
    faces = faces_of(np.stack([TRAPEZOID, TRAPEZOID + [4, 0, 1], SQUARE[[0, 1, 2, 2]] - 3]))
    _, _, patches = meshed(faces, 4)
    values = np.random.default_rng(3).uniform(20, 30, (len(patches), 2))
    live = np.arange(len(patches)) % 7 > 0
    around, _, corners = smoothed(patches, np.zeros(len(patches), int), values, live)
    found = corner_matrix(patches, around) @ values
    assert found == pytest.approx(corners.reshape(-1, 2), rel=1e-12)
    assert np.ptp(found) > 5.0
