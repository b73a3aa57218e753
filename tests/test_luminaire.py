"""Luminaires as light sources: interpolation, flux, orientation, mirrors, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from test_lamps import ROOM, fluxes, on_faces

from radiosity.light.luminaire import Distribution, Luminaire, frame_towards, of_values
from radiosity.light.sources import Point

ONE = np.ones(1)
DOWN = np.array([0.0, 0.0, -1.0])
RNG = np.random.default_rng(7)
PLANES, ANGLES = np.array([0.0, 50, 90, 200, 360]), np.array([0.0, 10, 35, 90, 180])
VALUES = RNG.uniform(0.1, 1.0, (5, 5))
VALUES[:, [0, -1]] = 0.7, 0.4  # one value each at the poles
VALUES[-1] = VALUES[0]
ODD = of_values(PLANES, ANGLES, VALUES)[0]


def made(distribution=ODD, frame=None, position=(0, 0, 0)):
    frame = frame_towards(DOWN) if frame is None else frame
    return Luminaire(np.array(position, float), ONE, frame=frame, distribution=distribution)


def directions(count, seed=1):
    x = np.random.default_rng(seed).normal(size=(count, 3))
    return x / np.linalg.norm(x, axis=1)[:, None]


def plain(planes, angles, values, direction):
    """Bilinear interpolation by loops, of a luminaire that hangs with C = 0 along x."""
    gamma = np.degrees(np.arccos(np.clip(-direction[2], -1, 1)))
    c = np.degrees(np.arctan2(direction[1], direction[0])) % 360.0
    if not angles[0] <= gamma <= angles[-1]:
        return 0.0
    for i in range(len(planes) - 1):
        for j in range(len(angles) - 1):
            if planes[i] <= c <= planes[i + 1] and angles[j] <= gamma <= angles[j + 1]:
                s = (c - planes[i]) / (planes[i + 1] - planes[i])
                t = (gamma - angles[j]) / (angles[j + 1] - angles[j])
                return (
                    (1 - s) * ((1 - t) * values[i, j] + t * values[i, j + 1])
                    + s * ((1 - t) * values[i + 1, j] + t * values[i + 1, j + 1])
                )  # fmt: skip
    raise AssertionError("no cell holds the direction")


def test_intensities_between_angles_are_those_of_the_plain_loop():
    ways = directions(300)
    expected = [plain(PLANES, ANGLES, VALUES / VALUES.max(), w) for w in ways]
    np.testing.assert_allclose(made().shape(ways), expected, rtol=1e-9)


def test_hanging_luminaires_have_the_nadir_below_and_c_counts_from_x_to_y():
    values = np.zeros((5, 3))
    values[0, 1] = values[4, 1] = 1.0  # C = 0 at the horizon
    values[1, 1] = 0.5  # C = 90
    values[:, 0] = 0.25
    lamp = made(of_values(np.arange(0, 361.0, 90), np.array([0.0, 90, 180]), values)[0])
    ways = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, -1], [-1, 0, 0], [0, -1, 0], [0, 0, 1]])
    np.testing.assert_allclose(lamp.shape(ways), [1, 0.5, 0.25, 0, 0, 0], atol=1e-12)


ISOTROPIC = lambda gamma: np.ones_like(gamma)  # noqa: E731
BATWING = lambda gamma: np.cos(gamma) * (0.3 + 2 * np.sin(gamma) ** 2)  # noqa: E731


@pytest.mark.parametrize(
    ("law", "last", "flux", "step", "error"),
    [
        (ISOTROPIC, 180, 4 * np.pi, 45.0, 1e-14),
        (ISOTROPIC, 90, 2 * np.pi, 45.0, 1e-14),
        (np.cos, 90, np.pi, 2.5, 2e-4),  # chords of a curve: step^2/12 of it is missing
        (np.cos, 90, np.pi, 0.25, 2e-6),
        (BATWING, 90, 2 * np.pi * (0.3 / 2 + 2 / 4), 0.5, 7e-5),
    ],
)
def test_flux_of_closed_forms(law, last, flux, step, error):
    """2 pi int I sin: of 1 it is 4 pi, of cos pi, of cos (a + b sin^2) 2 pi (a/2 + b/4)."""
    angles = np.arange(0, last + step / 2, step)
    values = np.maximum(law(np.radians(angles)), 0.0)
    shares, peak = of_values(np.array([0.0, 360]), angles, np.array([values] * 2))
    assert peak * shares.solid_angle == pytest.approx(flux, rel=error)


def test_solid_angle_is_the_integral_of_what_is_interpolated():
    """By Gauss's rule in every cell of both angles, which is exact to rounding there."""
    x, w = np.polynomial.legendre.leggauss(12)
    total = 0.0
    for a, b in zip(ODD.planes[:-1], ODD.planes[1:], strict=True):
        for c, d in zip(ODD.angles[:-1], ODD.angles[1:], strict=True):
            nodes = [(low + high) / 2 + (high - low) / 2 * x for low, high in ((a, b), (c, d))]
            azimuth, polar = np.meshgrid(*nodes)
            value = ODD(azimuth.ravel(), polar.ravel()).reshape(polar.shape) * np.sin(polar)
            total += (b - a) * (d - c) / 4 * (w @ value @ w)
    assert made().solid_angle == pytest.approx(total, rel=1e-13)


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_frames_are_right_handed_about_the_way_up(up):
    for axis in [*directions(20), *np.eye(3), *-np.eye(3)]:
        frame = frame_towards(axis, 0.3, up)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(np.cross(frame[0], frame[1]), -axis, atol=1e-12)
        np.testing.assert_allclose(frame[2], axis, atol=1e-15)
    where = np.eye(3)["xyz".index(up)]
    hanging = {"z": "xy", "y": "x-z", "x": "yz"}[up]
    c0, c90 = frame_towards(-where, 0.0, up)[:2]
    assert c0["xyz".index(hanging[0])] == 1.0
    assert c90["xyz".index(hanging[-1])] == (-1.0 if "-" in hanging else 1.0)


def test_a_tilt_turns_as_little_as_it_can():
    """Tilted towards y: C = 0, along x, stays; tilted towards x: C = 90 does."""
    tilted = frame_towards(np.array([0.0, 0.6, -0.8]))
    np.testing.assert_allclose(tilted[0], [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(tilted[1], [0, 0.8, 0.6], atol=1e-15)
    np.testing.assert_allclose(frame_towards(np.array([0.6, 0, -0.8]))[1], [0, 1, 0], atol=1e-15)
    for up, away in zip("xyz", np.eye(3), strict=True):
        near = frame_towards(1e-9 * np.ones(3) - away, 0.0, up)
        np.testing.assert_allclose(near, frame_towards(-away, 0.0, up), atol=1e-8)


def test_roll_adds_to_c():
    """What a luminaire rolled by 40 degrees sends to C = 75 is what it has at C = 35."""
    for axis in (DOWN, np.array([0.48, 0.6, -0.64])):
        still, rolled = (frame_towards(axis, np.radians(r)) for r in (0.0, 40.0))
        local = np.array([[np.cos(c) * 0.8, np.sin(c) * 0.8, 0.6] for c in np.radians([75.0, 35])])
        at_75, at_35 = local @ still
        assert made(frame=rolled).shape(at_75[None]) == pytest.approx(
            made(frame=still).shape(at_35[None]), rel=1e-12
        )
        assert made(frame=rolled).shape(at_35[None]) != pytest.approx(
            made(frame=still).shape(at_35[None]), rel=1e-3
        )


def test_turned_with_the_scene_and_mirrored_it_lights_the_same():
    x = 3 * directions(60, 2)
    lamp = made(frame=frame_towards(np.array([0.6, 0.0, -0.8]), 0.4), position=(0.1, 0.2, 0.3))
    for sign in (1.0, -1.0):
        turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        turn *= sign * np.linalg.det(turn)  # a rotation, and a reflection
        moved = lamp.moved(turn, np.array([1.0, -2, 0.5]))
        there = x @ turn.T + np.array([1.0, -2, 0.5])
        np.testing.assert_allclose(
            moved.reaching(there, 0.5)[2], lamp.reaching(x, 0.5)[2], rtol=1e-9
        )
        assert not moved.problems() and moved.solid_angle == lamp.solid_angle


def test_no_light_beyond_the_angles_that_were_measured():
    up = of_values(np.array([0.0, 360]), np.array([90.0, 180]), np.full((2, 2), 5.0))[0]
    assert made(up).shape(np.array([[0, 0, 1.0], [1, 0, 0], [0, 0.6, -0.8]])).tolist() == [1, 1, 0]


def beam(width):
    """Return a floodlight of a half width in degrees with 0.1 % of stray light all about."""
    angles = np.array([0.0, width, 1.3 * width, 180.0])
    return of_values(np.array([0.0, 360]), angles, np.array([[1, 1, 1e-3, 1e-3]] * 2))[0]


CUT = np.array([0.0, 60, 60.1, 180])
SHARP = of_values(np.array([0.0, 360]), CUT, np.array([[1.0, 1, 0.1, 0.1]] * 2))[0]


@pytest.mark.parametrize(
    ("distribution", "error"), [(SHARP, 1e-3), (ODD, 1e-4), (beam(5.0), 5e-4), (beam(0.5), 5e-4)]
)
def test_walls_of_a_closed_room_receive_all_flux(distribution, error):
    """Whatever the angles: kinks are integrated by cells, and a beam is found on one patch."""
    axis = np.array([2.3, 1.7, -1.0]) / np.linalg.norm([2.3, 1.7, -1.0])
    lamp = made(distribution, frame_towards(axis, 0.2), (2.0, 2.0, 2.5))
    patches, _, found = on_faces(ROOM, lamp)
    assert fluxes(patches, found).sum() == pytest.approx(lamp.solid_angle, rel=error)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"planes": np.radians([0.0, 50, 40, 200, 360])}, "C-planes that do not rise"),
        ({"planes": np.radians([0.0, 50, 90, 200, 300])}, "C-planes that do not rise"),
        ({"angles": np.radians([0.0, 10, 35, 90, 190])}, "gamma that do not rise"),
        ({"shares": np.ones((4, 5))}, "the shape (4, 5), not (5, 5)"),
        ({"shares": np.full((5, 5), np.nan)}, "do not lie in [0, 1]"),
        ({"shares": np.full((5, 5), 2.0)}, "do not lie in [0, 1]"),
        ({"angles": np.zeros(1)}, "less than two"),
    ],
)
def test_wrong_distributions_are_told(change, told):
    (found,) = made(Distribution(**{**vars_of(ODD), **change})).problems()
    assert told in found


def vars_of(distribution):
    return {key: getattr(distribution, key) for key in ("planes", "angles", "shares")}


def test_wrong_frames_and_places_are_told():
    assert not made().problems()
    assert "at right angles" in made(frame=2 * np.eye(3)).problems()[0]
    assert "not finite" in replace(made(), position=np.full(3, np.nan)).problems()[0]


def test_isotropic_distributions_shine_as_points_do():
    even = of_values(np.array([0.0, 360]), np.array([0.0, 180]), np.ones((2, 2)))[0]
    x = directions(20)
    one, other = made(even).reaching(x, 2.0), Point(np.zeros(3), ONE).reaching(x, 2.0)
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12)
