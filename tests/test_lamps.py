"""Light of abstract sources on points and patches: closed forms, order, shadows, invariance."""

import numpy as np
import pytest
from scenes_for_tests import block, box, faces_of, meshed

from radiosity.light.sources import Directional, Flood, Point, Spot
from radiosity.mesh.elements import make_elements
from radiosity.transport.lamps import lamp_irradiance, lamps_on

ROOM = box((0, 0, 0), (4, 4, 3))
DOWN = np.array([0.0, 0, -1])
ONE = np.ones(1)


def mesh(polygons, n):
    """Return patches and visibility of polygons divided n x n."""
    visibility, _, patches = meshed(faces_of(np.array(polygons)), n)
    return patches, visibility


def on_faces(polygons, lamp, n=1, order=1):
    """Return mesh, elements and coefficients of one lamp's light on faces of n x n cells."""
    patches, visibility = mesh(polygons, n)
    elements = make_elements(patches, np.arange(len(patches)), order)
    return patches, elements, lamps_on(visibility, (lamp,), elements, 1.0)


def fluxes(patches, found):
    return np.bincount(patches.face, found[: len(patches), 0] * patches.area)


def test_mean_over_a_patch_is_intensity_times_solid_angle_over_area():
    """A rectangle a x b seen from h over its middle: Omega = 4 asin(ab/sqrt((a2+4h2)(b2+4h2)))."""
    lamp = Point(np.array([2.0, 2, 1.5]), ONE)
    flux = fluxes(*on_faces(ROOM, lamp)[::2])
    a, b, h = 4.0, 4.0, 1.5
    floor = 4 * np.arcsin(a * b / np.sqrt((a * a + 4 * h * h) * (b * b + 4 * h * h)))
    wall = (4 * np.pi - 2 * floor) / 4
    np.testing.assert_allclose(flux, [floor, floor, *[wall] * 4], rtol=1e-5)  # Gauss's rule


@pytest.mark.parametrize("height", [1.0, 1e-3, 1e-9])
def test_flux_is_kept_however_near_a_surface_the_lamp_is(height):
    lamp = Point(np.array([2.1, 2.2, 3 - height]), ONE)
    patches, _, found = on_faces(ROOM, lamp, 2)
    assert np.all(np.isfinite(found))
    np.testing.assert_allclose(fluxes(patches, found).sum(), 4 * np.pi, rtol=1e-5)  # Gauss's rule
    if height < 0.1:
        np.testing.assert_allclose(fluxes(patches, found)[1], 2 * np.pi, rtol=1e-3)  # a half space


@pytest.mark.parametrize("exponent", [0.5, 1.0, 3.0, 1e4])
def test_flood_sends_out_two_pi_over_n_plus_one(exponent):
    lamp = Flood(np.array([2.0, 2, 2.5]), ONE, axis=np.array([0, 0.6, -0.8]), exponent=exponent)
    flux = fluxes(*on_faces(ROOM, lamp)[::2]).sum()
    np.testing.assert_allclose(flux, 2 * np.pi / (exponent + 1), rtol=1e-3)  # its edge at the lamp


@pytest.mark.parametrize(("beam", "cutoff"), [(25, 35), (30, 30), (1, 1), (0.01, 0.02)])
def test_spot_is_found_however_narrow(beam, cutoff):
    lamp = Spot(
        np.array([2.0, 2, 2.5]), ONE, axis=np.array([0, 0.6, -0.8]), beam=np.radians(beam),
        cutoff=np.radians(cutoff),
    )  # fmt: skip
    flux = fluxes(*on_faces(ROOM, lamp)[::2]).sum()
    np.testing.assert_allclose(flux, lamp.solid_angle, rtol=2e-3)  # edges followed to 1/16


def test_slopes_are_those_of_the_nearest_linear_field():
    """Against the least squares of E = I cos/d^2 on a fine grid of the floor."""
    lamp = Point(np.array([1.0, 2.5, 2.0]), ONE)
    _, elements, found = on_faces(ROOM, lamp)
    x, y = (a.ravel() for a in np.meshgrid(*[(np.arange(400) + 0.5) / 100] * 2))
    grid = np.stack([x, y, 0 * x], axis=1)
    apart = lamp.position - grid
    exact = apart[:, 2] / np.linalg.norm(apart, axis=1) ** 3
    basis = np.stack([0 * x + 1, x, y], axis=1)
    nearest = basis @ np.linalg.lstsq(basis, exact, rcond=None)[0]
    at = elements.at(grid, np.zeros(len(x), int), found)[:, 0]
    np.testing.assert_allclose(at, nearest, rtol=0, atol=1e-4 * nearest.max())  # the grid's width
    assert np.ptp(nearest) > 0.1 * nearest.max()  # or flat ones would do as well


def test_shadow_of_a_block_takes_its_share_of_the_floor():
    """A block of 1 x 1 and height 1 under a lamp at 2: its top casts 2 x 2 on the floor."""
    stood = block((1.5, 1.5, 0), (2.5, 2.5, 1), False)
    lamp = Point(np.array([2.0, 2, 2.0]), ONE)
    patches, _, found = on_faces(np.concatenate([ROOM, stood]), lamp)
    flux = fluxes(patches, found)

    def solid_angle(a, h):
        return 4 * np.arcsin(a * a / (a * a + 4 * h * h))

    exact = solid_angle(4, 2) - solid_angle(2, 2)
    np.testing.assert_allclose(flux[0], exact, rtol=5e-3)  # its edge followed to 1/16 of the floor
    np.testing.assert_allclose(flux.sum(), 4 * np.pi, rtol=2e-3)


def test_order_of_shadow_edges():
    """Means over n x n cells: the error of the sum falls with the cells at the edge."""
    stood = block((1.37, 1.61, 0), (2.41, 2.53, 1.1), False)
    lamp = Point(np.array([1.9, 2.3, 2.7]), ONE)

    def error(n):
        patches, _, found = on_faces(np.concatenate([ROOM, stood]), lamp, n)
        return abs(fluxes(patches, found).sum() / (4 * np.pi) - 1)

    assert error(8) < 3e-4 and error(2) < 3e-3


def test_points_in_the_shadow_get_nothing_and_others_the_formula():
    stood = block((1.5, 1.5, 0), (2.5, 2.5, 1), False)
    visibility = mesh(np.concatenate([ROOM, stood]), 1)[1]
    lamp = Point(np.array([2.0, 2, 2.0]), np.array([8.0, 4.0]))
    points = np.array([[2.0, 2.9, 0], [2, 3.1, 0], [2, 2, 1.0], [0, 2, 2.0]])
    normals = np.array([[0, 0, 1.0], [0, 0, 1], [0, 0, 1], [1, 0, 0]])
    found = lamp_irradiance(visibility, (lamp,), points, normals, 1.0)
    d = np.hypot(1.1, 2)
    np.testing.assert_allclose(found[:, 0], [0, 8 * 2 / d**3, 8, 2], rtol=1e-12)
    np.testing.assert_allclose(found[:, 1], found[:, 0] / 2)


def test_sun_through_a_roof_opening():
    """A patch of sun as large as the opening, moved by the way of the light; off it exactly 0."""
    roof = [[[a, 0, 3], [a, 4, 3], [b, 4, 3], [b, 0, 3]] for a, b in ((0, 1), (2, 4))]
    polygons = np.concatenate([ROOM[[0, 2, 3, 4, 5]], np.array(roof, float)])
    sun = Directional(np.array([0.6, 0, -0.8]), np.array([10.0]))
    patches, elements, found = on_faces(polygons, sun)
    flux = fluxes(patches, found)
    lit = 0.75 * 4  # it falls 2.25 aside: on 3.25 to 4.25 of the floor, of which 4 are there
    np.testing.assert_allclose(flux[0], lit * 8.0, rtol=1e-2)  # edge followed to 1/16 of the floor
    np.testing.assert_allclose(flux.sum(), 4.0 * 8.0, rtol=1e-2)
    visibility = mesh(polygons, 1)[1]
    points = np.array([[3.2, 1, 0], [3.3, 1, 0], [0.5, 1, 0]])
    at = lamp_irradiance(visibility, (sun,), points, np.tile([0.0, 0, 1], (3, 1)), 1.0)
    np.testing.assert_allclose(at[:, 0], [0, 8, 0], rtol=1e-12)


def test_lamp_outside_of_a_convex_room_is_shut_out():
    visibility = mesh(ROOM, 1)[1]
    assert not visibility.can_block
    up = np.array([[0.0, 0, 1]])
    for lamp in (Point(np.array([2.0, 2, 3.5]), ONE), Directional(DOWN, ONE)):
        assert lamp_irradiance(visibility, (lamp,), np.array([[2.0, 2, 0]]), up, 1.0) == 0
    under = Point(np.array([2.0, 2, -0.5]), ONE)
    below = lamp_irradiance(visibility, (under,), np.array([[2.0, 2, 0]]), -up, 1.0)
    np.testing.assert_allclose(below, 4.0)


def test_moving_and_scaling_all_changes_only_the_unit():
    lamp = Spot(
        np.array([1.0, 2, 2.5]), ONE, axis=np.array([0, 0.6, -0.8]), beam=0.3, cutoff=0.7
    )
    far, rows = np.array([100.0, -50, 7]), np.arange(6 * 9)
    moved = Spot(10 * lamp.position + far, ONE, axis=lamp.axis, beam=0.3, cutoff=0.7)
    there, visibility = mesh(10 * ROOM + far, 3)
    theirs = make_elements(there, rows, 1)
    here, ours, found = on_faces(ROOM, lamp, 3)
    one = ours.at(here.vertices[:, 0], rows, found)
    other = theirs.at(there.vertices[:, 0], rows, lamps_on(visibility, (moved,), theirs, 0.1))
    np.testing.assert_allclose(other, one, rtol=1e-6, atol=1e-9)  # coordinates of 100 are rounded


def test_order_0_is_the_mean_of_order_1():
    lamp = Point(np.array([1.0, 2, 2.9]), ONE)
    linear, constant = on_faces(ROOM, lamp, 2, 1)[2], on_faces(ROOM, lamp, 2, 0)[2]
    np.testing.assert_allclose(linear[: len(constant)], constant, rtol=1e-12)
