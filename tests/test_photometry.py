import numpy as np
import pytest

from radiosity.light import photometry as ph


def test_luminance_weights_the_bands_and_adds_up_to_one():
    np.testing.assert_array_equal(ph.luminance(np.eye(3)), [0.2126, 0.7152, 0.0722])
    assert ph.luminance([1, 1, 1]) == pytest.approx(1, abs=1e-15)  # rounding of three decimals
    assert ph.luminance(np.ones((4, 5, 3))).shape == (4, 5)


def test_illuminance_of_white_and_of_green():
    assert ph.illuminance([1, 1, 1]) == pytest.approx(683, rel=1e-15)
    assert ph.illuminance([0, 2, 0]) == pytest.approx(2 * 0.7152 * 683, rel=1e-15)
    assert ph.illuminance([1, 1, 1], efficacy=179) == pytest.approx(179, rel=1e-15)


def test_exitance_is_pi_times_radiance():
    np.testing.assert_allclose(ph.radiance_from_exitance([np.pi, 0, 1]), [1, 0, 1 / np.pi])
    np.testing.assert_allclose(ph.radiance_from_exitance(np.pi), [1, 1, 1])


def test_luminance_comes_back_through_the_weights():
    radiance = ph.radiance_from_luminance(1000.0)
    assert ph.EFFICACY * ph.luminance(radiance) == pytest.approx(1000)
    assert np.ptp(radiance) == 0


def test_radiant_flux_is_the_integral_of_the_exitance():
    radiance = ph.radiance_from_radiant_flux([60, 0, 6], 2.0)
    np.testing.assert_allclose(np.pi * radiance * 2.0, [60, 0, 6])
    np.testing.assert_allclose(ph.radiance_from_radiant_flux(6, 2.0), [3 / np.pi] * 3)


def test_luminous_flux_is_the_lumens_that_leave():
    radiance = ph.radiance_from_luminous_flux(800, 0.25)
    assert ph.illuminance(np.pi * radiance) * 0.25 == pytest.approx(800)


@pytest.mark.parametrize("area", [0.0, -1.0, np.inf, np.nan])
def test_flux_needs_an_area(area):
    with pytest.raises(ValueError, match=r"area = .* m2 must be positive"):
        ph.radiance_from_radiant_flux(1.0, area)
