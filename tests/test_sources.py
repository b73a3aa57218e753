"""Abstract light sources: shapes, flux, falloff, and what they never return."""

import numpy as np
import pytest

from radiosity.light.sources import Directional, Falloff, Flood, Point, Spot

AXIS = np.array([0.6, 0.0, -0.8])
ONE = np.ones(1)
LAMPS = {
    "point": Point(np.zeros(3), ONE),
    "spot": Spot(np.zeros(3), ONE, axis=AXIS, beam=np.radians(25), cutoff=np.radians(35)),
    "hard spot": Spot(np.zeros(3), ONE, axis=AXIS, beam=0.4, cutoff=0.4),
    "wide spot": Spot(np.zeros(3), ONE, axis=AXIS, beam=0.0, cutoff=np.pi),
    "half space": Flood(np.zeros(3), ONE, axis=AXIS, exponent=0.0),
    "lambert": Flood(np.zeros(3), ONE, axis=AXIS, exponent=1.0),
    "flood": Flood(np.zeros(3), ONE, axis=AXIS, exponent=37.5),
}


def ring(angle, axis=AXIS):
    """Return directions (k, 3) at angles (k,) to an axis."""
    across = np.cross(axis, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    return np.cos(angle)[:, None] * axis + np.sin(angle)[:, None] * across


@pytest.mark.parametrize("lamp", LAMPS.values(), ids=LAMPS)
def test_solid_angle_is_the_integral_of_the_shape(lamp):
    """2 pi int shape sin, between its kinks by Gauss's rule; of floods 2 pi/(n + 1)."""
    kinks = [0.0, np.pi / 2, np.pi, getattr(lamp, "beam", 0.0), getattr(lamp, "cutoff", 0.0)]
    kinks = np.unique(kinks)
    x, w = np.polynomial.legendre.leggauss(200)
    total = 0.0
    for a, b in zip(kinks[:-1], kinks[1:], strict=True):
        angle = (a + b) / 2 + (b - a) / 2 * x
        total += np.pi * (b - a) * np.sum(w * np.sin(angle) * lamp.shape(ring(angle)))
    np.testing.assert_allclose(lamp.solid_angle, total, rtol=1e-9)  # n = 37.5 is no polynomial
    if isinstance(lamp, Flood):
        assert lamp.solid_angle == 2 * np.pi / (lamp.exponent + 1)


def test_spot_is_full_in_the_beam_and_falls_linearly_in_the_angle():
    angle = np.radians([0, 20, 24.999, 27.5, 30, 34.9, 35.1, 90, 180])
    found = LAMPS["spot"].shape(ring(angle))
    np.testing.assert_allclose(found, [1, 1, 1, 0.75, 0.5, 0.01, 0, 0, 0], atol=1e-12)
    assert LAMPS["hard spot"].shape(ring(np.array([0.399, 0.401]))).tolist() == [1, 0]


def test_irradiance_falls_off_with_the_square_of_metres():
    lamp = Point(np.array([0.0, 0, 300]), np.array([9.0, 18.0]))
    to_light, distance, irradiance = lamp.reaching(np.zeros((1, 3)), 0.01)
    assert to_light.tolist() == [[0, 0, 1]] and distance.tolist() == [300]
    np.testing.assert_allclose(irradiance, [[1.0, 2.0]], rtol=1e-15)


def test_falloff_of_the_shading_model():
    lamp = Point(np.array([0.0, 0, 2]), ONE, Falloff(0.5, 1.0, 3.0))
    np.testing.assert_allclose(lamp.reaching(np.zeros((1, 3)), 1.0)[2], 1 / (0.5 * 8 + 1))


@pytest.mark.parametrize("distance", [0.0, 5e-324, 1e-200, 1e-9, 1e150])
def test_no_distance_gives_an_infinity(distance):
    with np.errstate(all="raise", under="ignore"):
        found = Point(np.array([0, 0, distance]), ONE).reaching(np.zeros((1, 3)), 1.0)
    assert all(np.all(np.isfinite(x)) for x in found)
    if distance == 1e-9:
        np.testing.assert_allclose(found[2], 1e18)


def test_directional_is_the_same_everywhere():
    sun = Directional(np.array([0.0, 0.6, -0.8]), np.array([1.0, 2, 3]))
    to_light, distance, irradiance = sun.reaching(np.array([[0, 0, 0], [9.0, 1e6, 2]]), 1.0)
    assert np.all(to_light == [0, -0.6, 0.8]) and np.all(irradiance == [1, 2, 3])
    assert np.all(np.isinf(distance))


def test_turning_lamp_and_point_together_changes_nothing():
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    x = np.random.default_rng(4).normal(size=(50, 3))
    for lamp in (LAMPS["spot"], LAMPS["flood"]):
        turned = type(lamp)(**{**vars(lamp), "axis": turn @ lamp.axis})
        np.testing.assert_allclose(
            turned.reaching(x @ turn.T, 1.0)[2], lamp.reaching(x, 1.0)[2], rtol=1e-9, atol=1e-12
        )


@pytest.mark.parametrize("cutoff", [1e-8, 1e-4, 0.1])
def test_narrow_spots_keep_the_digits_of_their_solid_angle(cutoff):
    """Of a beam of 0 it is pi c^2/3 (1 - c^2/20 ..), which 1 - sin(c)/c has no digits for."""
    narrow = Spot(np.zeros(3), ONE, axis=AXIS, beam=0.0, cutoff=cutoff)
    exact = np.pi * cutoff**2 / 3 * (1 - cutoff**2 / 20 + cutoff**4 / 840)
    np.testing.assert_allclose(narrow.solid_angle, exact, rtol=1e-8)  # the next term


@pytest.mark.parametrize("name", ["spot", "hard spot", "flood"])
def test_wide_cones_that_may_hold_the_lobe_are_told(name):
    lamp = LAMPS[name]
    towards = ring(np.radians([0.0, 80.0, 179.0]))
    assert lamp.misses(towards, np.full(3, 1.2)).tolist() == [True, True, False]
    assert not lamp.misses(towards, np.full(3, 0.01)).any()
