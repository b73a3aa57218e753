"""The cameras' geometry: rays and projection as inverses, angles, extents, aspect, roll."""

import numpy as np
import pytest

from radiosity.scene.model import Camera
from radiosity.view.camera import basis, project, rays


def camera(**changes):
    values = {
        "name": "front",
        "position": np.array([0.0, 0.0, 0.0]),
        "target": np.array([0.0, 5.0, 0.0]),
        "up": np.array([0.0, 0.0, 1.0]),
        "fov": 40.0,
        "size": (60, 40),
    }
    return Camera(**{**values, **changes})


def elevation(**changes):
    return camera(**{"fov": None, "height": 2.0, **changes})


def looks(view, size, pixel_xy):
    """Return the directions alone, of a pinhole camera, which all begin where it stands."""
    origins, directions = rays(view, size, pixel_xy)
    assert np.all(origins == view.position)
    return directions


def angle(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def test_basis_is_right_handed_as_seen_by_the_eye():
    right, up, forward = basis(camera())
    assert right == pytest.approx([1, 0, 0]) and up == pytest.approx([0, 0, 1])
    assert forward == pytest.approx([0, 1, 0])


def test_basis_is_orthonormal_when_up_is_oblique_and_long():
    axes = np.array(basis(camera(target=[3.0, 1.0, -2.0], up=[10.0, 20.0, 70.0])))
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-15)
    assert np.cross(axes[0], axes[1]) == pytest.approx(-axes[2], abs=1e-15)


def test_the_centre_looks_forward():
    assert looks(camera(), (60, 40), [[30.0, 20.0]]) == pytest.approx(np.array([[0, 1, 0]]))


def test_x_goes_right_and_y_goes_down():
    right, down = looks(camera(), (60, 40), [[31.0, 20.0], [30.0, 21.0]])
    assert right[0] > 0 and right[2] == 0
    assert down[2] < 0 and down[0] == 0


@pytest.mark.parametrize("size", [(60, 40), (40, 40), (20, 400), (1920, 1080)])
@pytest.mark.parametrize("fov", [5.0, 40.0, 120.0])
def test_fov_is_vertical_whatever_the_size(size, fov):
    w, h = size
    view = camera(fov=fov)
    top, bottom, left, side = looks(view, size, [[w / 2, 0], [w / 2, h], [0, h / 2], [w, h / 2]])
    assert angle(top, bottom) == pytest.approx(fov, rel=1e-12)
    half_width = np.tan(np.radians(fov / 2)) * w / h  # square pixels
    assert angle(left, side) == pytest.approx(2 * np.degrees(np.arctan(half_width)), rel=1e-12)


def test_the_corner_lies_at_the_angle_of_its_plane_point():
    corner = looks(camera(), (60, 40), [[60.0, 0.0]])[0]
    t = np.tan(np.radians(20.0))
    assert corner / corner[1] == pytest.approx([1.5 * t, 1.0, t], rel=1e-14)
    assert np.linalg.norm(corner) == pytest.approx(1.0, rel=1e-15)


def test_roll_turns_the_picture():
    tilt = np.radians(30.0)
    rolled = camera(up=[np.sin(tilt), 0.0, np.cos(tilt)])  # head leans right: the world turns left
    xy, _ = project(rolled, (40, 40), [[0.0, 5.0, 1.0]])
    upright, _ = project(camera(), (40, 40), [[0.0, 5.0, 1.0]])
    radius = 20.0 - upright[0, 1]
    assert upright[0, 0] == pytest.approx(20.0)
    assert xy[0] == pytest.approx([20 - radius * np.sin(tilt), 20 - radius * np.cos(tilt)])


@pytest.mark.parametrize("extent", [{"fov": 75}, {"fov": None, "height": 12.5}])
def test_project_undoes_rays(extent):
    rng = np.random.default_rng(0)
    view = camera(
        position=rng.normal(size=3) * 100, target=rng.normal(size=3), up=rng.normal(size=3),
        **extent,
    )  # fmt: skip
    size = (321, 123)
    pixel = rng.uniform(-0.5, 1.5, (500, 2)) * size
    distance = rng.uniform(0.1, 1e4, 500)
    origin, direction = rays(view, size, pixel)
    xy, depth = project(view, size, origin + distance[:, None] * direction)
    # position ~ 100, distance 0.1: 1e-14 absolute on 0.1, times a focal length of about 100 pixels
    assert xy == pytest.approx(pixel, rel=0, abs=1e-9)
    assert depth == pytest.approx(distance * (direction @ basis(view)[2]), rel=1e-11)


@pytest.mark.parametrize("view", [camera(), elevation()])
def test_what_lies_behind_has_a_depth_but_no_pixel(view):
    xy, depth = project(view, (60, 40), [[0.0, -2.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    assert depth == pytest.approx([-2.0, 0.0, 2.0])
    assert np.isnan(xy[:2]).all() and xy[2] == pytest.approx([30.0, 20.0])


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"target": [0.0, 0.0, 0.0]}, r"cameras\.front\.target = \[0, 0, 0\] must differ"),
        ({"up": [0.0, 0.0, 0.0]}, r"cameras\.front\.up = \[0, 0, 0\] must have a length"),
        ({"up": [0.0, -3.0, 0.0]}, r"up = \[0, -3, 0\] must not point along the view"),
        ({"up": [1e-12, 1.0, 0.0]}, r"must not point along the view"),  # rounding, not a choice
        ({"fov": 180.0}, r"cameras\.front\.fov = 180\.0 must lie between 0 and 180"),
        ({"fov": 0.0}, r"fov = 0\.0 must lie between"),
        ({"fov": None, "height": 0.0}, r"cameras\.front\.height = 0\.0 must be positive"),
        ({"fov": None, "height": np.inf}, r"height = inf must be positive and finite"),
        ({"fov": None}, r"cameras\.front: fov = None, height = None: give fov for a pinhole"),
        ({"height": 2.0}, r"fov = 40\.0, height = 2\.0: give fov for a pinhole"),
    ],
)
def test_impossible_cameras_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        rays(camera(**changes), (60, 40), [[0.0, 0.0]])


@pytest.mark.parametrize("size", [(60, 40), (40, 40), (20, 400), (1920, 1080)])
def test_orthographic_sight_lines_are_parallel_and_cover_the_height(size):
    w, h = size
    view = elevation(target=[0.0, 9.0, 0.0])  # how far away the target is makes no difference
    corners = [[w / 2, 0], [w / 2, h], [0, h / 2], [w, h / 2], [w / 2, h / 2]]
    origins, directions = rays(view, size, corners)
    assert np.all(directions == [0.0, 1.0, 0.0])
    wide = 2.0 * w / h  # square pixels
    expected = [[0, 0, 1], [0, 0, -1], [-wide / 2, 0, 0], [wide / 2, 0, 0], [0, 0, 0]]
    assert origins == pytest.approx(np.array(expected), abs=1e-15)


def test_things_look_as_large_near_and_far_in_an_elevation():
    xy, depth = project(elevation(), (60, 40), [[0.5, 1.0, 0.5], [0.5, 1e3, 0.5]])
    assert xy == pytest.approx(np.array([[40.0, 10.0]] * 2))  # 40 pixels are 2 units
    assert depth == pytest.approx([1.0, 1e3])


def test_an_empty_picture_is_refused():
    with pytest.raises(ValueError, match="size = 60 x 0 must be at least 1 x 1"):
        rays(camera(), (60, 0), [[0.0, 0.0]])
