"""Encoding, gamut and colour differences."""

import numpy as np
import pytest

from radiosity.light.colour import (
    RGB_TO_XYZ,
    XYZ_TO_RGB,
    delta_e_76,
    delta_e_2000,
    encode,
    in_gamut,
    lab,
    outside,
)

# Sharma, Wu & Dalal (2005), of their test data those that tell the steps apart.
PAIRS = [
    ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
    ((50, -1.3802, -84.2814), (50, 0, -82.7485), 1.0),
    ((50, 2.5, 0), (50, 0, -2.5), 4.3065),
    ((50, 2.49, -0.001), (50, -2.49, 0.0009), 7.1792),
    ((50, 2.49, -0.001), (50, -2.49, 0.0011), 7.2195),
    ((50, 2.5, 0), (73, 25, -18), 27.1492),
    ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ((22.7233, 20.0904, -46.694), (23.0331, 14.973, -42.5619), 2.0373),
    ((2.0776, 0.0795, -1.135), (0.9033, -0.0636, -0.5514), 0.9082),
]
WHITE = np.array([0.95047, 1.0, 1.08883])


def test_white_is_the_sum_of_the_primaries_and_both_ways_are_inverse():
    white = RGB_TO_XYZ.sum(axis=1)
    np.testing.assert_allclose(white[:2] / white.sum(), [0.3127, 0.3290], rtol=1e-14)  # rounding
    assert white[1] == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(XYZ_TO_RGB @ RGB_TO_XYZ, np.eye(3), atol=1e-14)


def test_the_two_parts_of_the_curve_meet():
    below, above = encode([0.0031308, 0.0031309])
    assert below == 12.92 * 0.0031308
    assert 0 < above - below < 2e-6  # the step of the argument, 1e-7, by its slope, 12.7
    assert encode([-1.0, 2.0]).tolist() == [0.0, pytest.approx(1.0, abs=1e-15)]


def test_a_gamma_is_the_inverse_of_a_power():
    v = np.linspace(0, 1, 11)
    np.testing.assert_allclose(encode(v, 2.2) ** 2.2, v, atol=1e-15)
    np.testing.assert_array_equal(encode(v, 1.0), v)
    for wrong in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="must be positive and finite: screens have about 2.2"):
            encode(v, wrong)


def test_lab_of_white_of_grey_and_of_what_is_nearly_black():
    np.testing.assert_allclose(lab(WHITE, WHITE), [100.0, 0.0, 0.0], atol=1e-13)
    np.testing.assert_allclose(lab(0.125 * WHITE, WHITE), [42.0, 0.0, 0.0], atol=1e-13)  # 116/2-16
    assert lab(0.005 * WHITE, WHITE)[0] == pytest.approx(0.005 * (29 / 3) ** 3, rel=1e-13)
    edge = (6 / 29) ** 3  # where the line meets the root, both are 8
    np.testing.assert_allclose(lab(edge * WHITE * [[1 - 1e-9], [1 + 1e-9]], WHITE)[:, 0], 8.0)


def test_lab_of_the_primaries():
    """Red, green and blue of sRGB as tables give them, in its own white."""
    found = lab(RGB_TO_XYZ.T, RGB_TO_XYZ.sum(axis=1))
    tables = [[53.24, 80.09, 67.20], [87.73, -86.18, 83.18], [32.30, 79.19, -107.86]]
    np.testing.assert_allclose(found, tables, atol=0.02)  # tables round the matrix


@pytest.mark.parametrize(("one", "two", "expected"), PAIRS)
def test_ciede2000_of_its_authors_data(one, two, expected):
    assert round(float(delta_e_2000(one, two)), 4) == expected
    assert delta_e_2000(two, one) == pytest.approx(delta_e_2000(one, two), rel=1e-12)


def test_differences_are_about_equal_for_near_greys_and_0_for_the_same():
    one = np.random.default_rng(0).uniform([0, -60, -60], [100, 60, 60], (50, 3))
    assert not delta_e_2000(one, one).any() and not delta_e_76(one, one).any()
    assert delta_e_76([50, 3, 4], [50, 0, 0]) == 5.0
    assert delta_e_2000([50, 0, 0], [51, 0, 0]) == pytest.approx(1.0, rel=2e-3)  # S_L = 1 at L = 50


def test_gamut_mapping_keeps_luminance_and_what_is_inside():
    rgb = np.random.default_rng(1).uniform(-0.5, 1.0, (500, 3))
    found, y = in_gamut(rgb), rgb @ RGB_TO_XYZ[1]
    bad = outside(rgb)
    assert 100 < bad.sum() < 480
    np.testing.assert_array_equal(found[~bad], rgb[~bad])
    assert (found[bad] >= 0.0).all() and not outside(found).any()
    bright = bad & (y > 0)
    np.testing.assert_allclose(found[bright] @ RGB_TO_XYZ[1], y[bright], rtol=1e-12)  # rounding
    assert (found[bright].min(axis=1) < 1e-15).all()  # as vivid as can be
    ratio = (found - y[:, None])[bright] / (rgb - y[:, None])[bright]
    assert np.ptp(ratio, axis=1).max() < 1e-9  # the same direction from grey
    assert not found[bad & (y <= 0)].any()


def test_what_8_bits_cannot_tell_from_0_is_inside():
    assert not outside(np.array([-1e-4, 0.5, 0.5])) and outside(np.array([-2e-4, 0.5, 0.5]))
    rgb = np.ones((4, 3))
    assert in_gamut(rgb) is rgb
