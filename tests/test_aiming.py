"""Rays aimed at triangles: exact factors, even patterns, sides and horizons."""

import numpy as np
import pytest

from radiosity.mesh.faces import Faces
from radiosity.transport.aiming import aimed_rays, make_targets
from radiosity.transport.polygon import point_factor
from radiosity.transport.visibility import Visibility

SQUARE = np.array([[[0.2, 0.1, 1], [1.2, 0.2, 1], [1.3, 1.2, 1], [0.2, 1.1, 1]]])
FLOOR = np.array([[[-2.0, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]])


def aimed(points, normals, samples, size=1.0, front=False, back=True):
    faces = Faces.from_polygons(np.concatenate([SQUARE * [size, size, 1.0], FLOOR]), 0, 0)
    visibility = Visibility(faces)
    wanted = np.array([[front, back], [False, False]])
    targets = make_targets(faces, visibility, wanted)
    points, normals = np.atleast_2d(points), np.atleast_2d(normals)
    keys = np.arange(len(points))
    return visibility, aimed_rays(visibility, targets, points, normals, keys, range(samples), 0)


@pytest.mark.parametrize("size", [1.0, 1e-2])  # above and below what is taken for a plane triangle
@pytest.mark.parametrize(
    ("point", "normal"),
    [((0.0, 0, 0), (0.0, 0, 1)), ((1.0, 0, 0.3), (0, 0.8, 0.6)), ((-1.0, 2, 0), (0.6, 0, 0.8)),
     ((0.01, 0.005, 0.9), (0, 0.3, 0.954))],
)  # fmt: skip
def test_factors_add_up_to_the_exact_one(size, point, normal):
    _, (_, _, face, factor) = aimed(np.array(point), np.array(normal), 4096, size)
    seen = SQUARE[0, ::-1] * [size, size, 1.0]  # from below
    assert factor.mean() == pytest.approx(point_factor(*point, *normal, seen), rel=1e-3)
    assert np.all(face == 0)


def test_the_error_falls_faster_than_that_of_random_rays():
    point, normal = np.array([0.9, 0.4, 0.8]), np.array([0.6, 0, 0.8])
    exact = point_factor(*point, *normal, SQUARE[0, ::-1])
    off = []
    for samples in (64, 4096):
        keys = [aimed(point + 1e-9 * k, normal, samples)[1][3].mean() - exact for k in range(8)]
        off.append(np.sqrt(np.mean(np.square(keys))))
    assert off[1] < off[0] / 64 ** (2 / 3)


def test_rays_meet_what_they_are_aimed_at():
    visibility, (origins, directions, face, factor) = aimed([0.3, 0.2, 0], [0, 0, 1.0], 512)
    met, _ = visibility.first_hits(origins, directions)
    assert np.all(met == 0) and np.all(face == 0) and np.all(factor > 0)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(1.0, abs=1e-6)


def test_sides_that_are_not_wanted_and_what_lies_below_the_horizon_get_no_ray():
    _, (_, _, face, factor) = aimed([0.3, 0.2, 0], [0, 0, 1.0], 16, front=True, back=False)
    assert np.all(face == -1) and np.all(factor == 0)
    _, (_, _, face, factor) = aimed([0.3, 0.2, 0], [0, 0, -1.0], 16)
    assert np.all(factor == 0)


def test_without_a_normal_factors_are_solid_angles():
    point = np.array([0.7, 0.6, 0.2])
    _, (_, directions, _, factor) = aimed(point, np.zeros(3), 1024)
    corners = SQUARE[0] - point
    a, b, c, d = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    angle = 0.0
    for p, q, r in ((a, b, c), (a, c, d)):
        volume = abs(p @ np.cross(q, r))
        angle += 2 * np.arctan2(volume, 1 + p @ q + q @ r + r @ p)
    assert factor * np.pi == pytest.approx(angle, rel=1e-9)
    # even over the sphere: as many to either side of the plane that halves the square
    assert directions[:, 2].min() > 0
