"""Spectra, what the eye makes of them, and cells of wavelengths."""

import numpy as np
import pytest

from radiosity.analytic import load_cases
from radiosity.light.bands import FEWEST, MOST
from radiosity.light.colour import XYZ_TO_RGB, delta_e_76, delta_e_2000, lab
from radiosity.light.palette import Cells, Nanometres
from radiosity.light.spectrum import (
    Spectrum,
    cells,
    colour_of,
    daylight,
    matching,
    means,
    nanometres,
    tristimulus,
    watts,
)
from radiosity.light.upsampling import primaries, white

CORNELL = {c["geometry"]["surface"]: c["geometry"] for c in load_cases("colour")
           if c["geometry"]["type"] == "cornell"}  # fmt: skip
WALLS = [Spectrum(np.array(g["nm"]), np.array(g["reflectance"])) for g in CORNELL.values()]
SAMPLE = Spectrum(np.array([400.0, 500.0, 600.0]), np.array([0.0, 1.0, 0.5]))


def smooth(middle, width=40.0):
    """Return the reflectance of a hump at a wavelength, (471,)."""
    return 0.1 + 0.8 * np.exp(-0.5 * ((nanometres() - middle) / width) ** 2)


def test_spectra_are_linear_between_and_end_as_light_or_go_on_as_shares():
    at = {nm: k for k, nm in enumerate(nanometres())}
    assert SAMPLE.light()[at[450.0]] == 0.5 and SAMPLE.light()[at[550.0]] == 0.75
    assert SAMPLE.light()[at[601.0]] == 0.0 and SAMPLE.share()[at[601.0]] == 0.5
    assert SAMPLE.light()[at[399.0]] == 0.0


def test_one_watt_at_555_nm_is_683_lumens_and_v_lambda_is_half_where_tables_say():
    y = dict(zip(nanometres(), matching()[:, 1], strict=True))
    assert y[555.0] == 1.0
    assert y[510.0] == 0.503 and y[610.0] == 0.503  # the table of V(lambda), CIE 015


def test_rgb_of_a_source_itself_is_its_own_and_of_grey_flat():
    source = daylight() * smooth(600)
    np.testing.assert_allclose(colour_of(np.full(471, 0.3), source), 0.3, rtol=1e-13)
    colours = colour_of(np.stack([smooth(450), smooth(650)]), np.ones(471))
    assert colours.shape == (2, 3) and colours[0, 2] > colours[0, 0]
    expected = XYZ_TO_RGB @ tristimulus(smooth(450)) / (XYZ_TO_RGB @ tristimulus(np.ones(471)))
    np.testing.assert_allclose(colours[0], expected, rtol=1e-13)


def test_a_source_without_blue_lends_its_luminance():
    lamp = (np.abs(nanometres() - 589) < 3) * 1.0
    share = smooth(589)
    found = colour_of(share, lamp)
    assert found[2] == pytest.approx(tristimulus(share * lamp)[1] / tristimulus(lamp)[1])


@pytest.mark.parametrize("count", [FEWEST, 16, MOST])
def test_cells_cover_everything_once_and_follow_each_other(count):
    bands = cells(count)
    assert bands.count == count and len(set(bands.names)) == count
    assert (np.diff(bands.wavelengths) > 0).all()
    np.testing.assert_allclose(means(np.full(471, 0.7), count), 0.7, rtol=1e-13)
    widths = watts(np.ones(471), count)
    assert widths.sum() == pytest.approx(471, rel=1e-13)
    np.testing.assert_allclose(bands.y @ widths, matching()[:, 1].sum(), rtol=1e-13)
    np.testing.assert_allclose(
        bands.rgb @ widths, XYZ_TO_RGB @ matching().sum(axis=0), rtol=1e-12
    )  # fmt: skip


def test_too_few_and_too_many_wavelengths_are_refused():
    for wrong in (FEWEST - 1, MOST + 1):
        with pytest.raises(ValueError, match=f"{wrong} wavelengths must lie between 8 and 128"):
            cells(wrong)


def errors(count, measure):
    """Return the differences of colours of walls in some lights, each seen after 1 to 4 bounces."""
    found = []
    lights = np.ones(471), daylight(), np.interp(nanometres(), [400, 500, 600, 700], [0, 8, 16, 18])
    shares = [w.share() for w in WALLS] + [smooth(480), smooth(620)]
    bands = cells(count)
    for light in lights:
        white_point = tristimulus(light)
        for share in shares:
            for bounces in (1, 2, 4):
                exact = tristimulus(light * share**bounces)
                seen = watts(light, count) * means(share, count) ** bounces
                xyz = np.linalg.solve(XYZ_TO_RGB, bands.to_rgb(seen))
                found.append(measure(*(lab(x, white_point) for x in (exact, xyz))))
    return np.array(found)


@pytest.mark.parametrize(("measure", "most"), [(delta_e_76, 0.7), (delta_e_2000, 0.3)])
def test_colours_converge_as_the_square_of_the_width_of_cells(measure, most):
    rms = {n: np.sqrt(np.mean(errors(n, measure) ** 2)) for n in (8, 16, 32, 64)}
    orders = [np.log2(rms[n] / rms[2 * n]) for n in (8, 16, 32)]
    assert min(orders) > 1.5 and max(orders) < 2.7  # 2: means over cells cut the first order off
    assert 0.8 * most < rms[16] < most  # measured .678 and .270: the constant, not only the order


def test_sixteen_cells_err_less_than_is_seen():
    assert errors(16, delta_e_2000).max() < 1.0


@pytest.mark.parametrize("count", [FEWEST, 11, 16, 32, MOST])
def test_primaries_are_shares_that_add_up_and_look_as_rgb_exactly(count):
    p, bands = primaries(count), cells(count)
    assert p.min() >= 0.0
    np.testing.assert_allclose(p.sum(axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(bands.to_rgb(white(count)), 1.0, rtol=1e-14)
    np.testing.assert_allclose(bands.rgb @ (p * white(count)[:, None]), np.eye(3), atol=1e-14)
    np.testing.assert_allclose(white(count), watts(daylight(), count), rtol=5e-3)  # rounded white


def test_primaries_are_smooth_and_converge():
    fine, coarse = primaries(128), primaries(32)
    middles = cells(32).wavelengths, cells(128).wavelengths
    there = np.stack([np.interp(middles[0], middles[1], x) for x in fine.T], axis=1)
    assert np.abs(coarse - there).max() < 0.05  # they turn within 60 nm, cells have 7 to 20
    assert np.abs(np.diff(fine, axis=0)).max() < 0.1


@pytest.mark.parametrize("palette", [Cells(8), Cells(16), Cells(61)])
def test_rgb_comes_back_under_daylight(palette):
    rgb, lamp = (0.2, 0.7, 0.05), (3.0, 1.0, 0.5)
    one = palette.light((1.0, 1.0, 1.0))
    np.testing.assert_allclose(palette.bands.to_rgb(palette.share(rgb) * one), rgb, rtol=1e-12)
    np.testing.assert_allclose(palette.bands.to_rgb(palette.light(lamp)), lamp, rtol=1e-12)
    assert np.ptp(palette.share((0.3,) * 3)) == 0.0
    assert palette.share((1.0, 1.0, 0.0)).max() <= 1.0
    assert palette.bands.luminance(one) == pytest.approx(1.0, rel=1e-13)


def test_all_nanometres_see_rgb_as_it_is_but_for_the_rounding_of_white():
    palette = Nanometres()
    for rgb in ((1.0, 0.0, 0.0), (0.2, 0.7, 0.3)):
        found = palette.bands.to_rgb(palette.light(rgb))
        np.testing.assert_allclose(found, rgb, atol=4e-4)  # D65 against (0.3127, 0.3290)
