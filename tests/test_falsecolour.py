"""False colours: read back off the scale that is in the picture, linear and logarithmic."""

import numpy as np
import pytest

from radiosity.light.colour import RGB_TO_XYZ, lab
from radiosity.view.falsecolour import STEPS, Scale, bar, false_colours, round_up
from radiosity.view.image import Image, write

LINEAR, LOGARITHMIC = Scale(400.0), Scale(1e4, decades=3.0)


def read_back(colours, scale):
    """Return the luminance (...) that colours (..., 3) stand for: the middle of the map's step."""
    steps = scale.luminance((np.arange(STEPS) + 0.5) / STEPS)
    table = {tuple(c): y for c, y in zip(scale.colours(steps).tolist(), steps, strict=True)}
    flat = [table[tuple(c)] for c in colours.reshape(-1, 3).tolist()]
    return np.reshape(flat, colours.shape[:-1])


def test_known_places():
    assert LINEAR.position([0.0, 100.0, 400.0, 800.0, -1.0]).tolist() == [0, 0.25, 1, 1, 0]
    found = LOGARITHMIC.position([10.0, 100.0, 1e3, 1e4, 1e6, 1.0, 0.0])
    assert found == pytest.approx([0, 1 / 3, 2 / 3, 1, 1, 0, 0], abs=1e-14)
    assert LOGARITHMIC.minimum == pytest.approx(10.0) and LINEAR.minimum == 0.0


@pytest.mark.parametrize("scale", [LINEAR, LOGARITHMIC])
def test_luminance_undoes_position(scale):
    y = np.random.default_rng(0).uniform(scale.minimum, scale.maximum, 100)
    assert scale.luminance(scale.position(y)) == pytest.approx(y, rel=1e-12)


def test_colours_read_back_to_the_luminance_within_a_step():
    pixels = np.random.default_rng(1).uniform(0, 0.5, (30, 40, 3))
    y = Image(pixels).luminance
    found = false_colours(y, LINEAR)[:30, :40]
    step = LINEAR.maximum / STEPS
    # half a step of the map; two of its 256 colours repeat their neighbours, hence one more
    assert np.abs(read_back(found, LINEAR) - y).max() <= 1.5 * step


def test_logarithmic_colours_read_back_within_a_step():
    y = 10.0 ** np.random.default_rng(2).uniform(1, 4, (30, 40))
    found = false_colours(y, LOGARITHMIC)[:30, :40]
    ratio = read_back(found, LOGARITHMIC) / y
    assert np.abs(np.log10(ratio)).max() <= 1.5 * LOGARITHMIC.decades / STEPS


def test_luminance_is_candela_and_never_negative():
    picture = Image(np.array([[[1.0, 1.0, 1.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.5]]]))
    assert picture.luminance == pytest.approx(np.array([[683.0, 683 * 0.7152, 0.0]]))


def test_what_lies_off_the_scale_has_the_colours_of_its_ends():
    low, high, dark, bright = LOGARITHMIC.colours([10.0, 1e4, 0.0, 1e9])
    assert dark.tolist() == low.tolist() and bright.tolist() == high.tolist()


def test_the_map_gets_evenly_lighter():
    shown = LINEAR.colours((np.arange(STEPS) + 0.5) / STEPS * LINEAR.maximum) / 255.0
    linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    lightness = lab(linear @ RGB_TO_XYZ.T, RGB_TO_XYZ.sum(axis=1))[:, 0]
    line = np.linspace(lightness[0], lightness[-1], STEPS)
    assert np.abs(lightness - line).max() < 3.0  # of 100; jet strays by more than 40
    assert lightness[0] < 20 and lightness[-1] > 88


@pytest.mark.parametrize("height", [64, 256, 700])
@pytest.mark.parametrize("scale", [LINEAR, LOGARITHMIC])
def test_the_bar_shows_the_colours_beside_their_numbers(scale, height):
    """The tick of a number stands, to the pixel, where the bar has that number's colour."""
    strip = bar(scale, height)
    line = max(11, height // 28)
    column = strip[:, line + line // 2].astype(int)
    coloured = np.flatnonzero(np.ptp(column, axis=1) > 30)  # below the unit's black letters
    top, bottom = coloured[0], coloured[-1] + 1
    found = read_back(strip[top:bottom, line + line // 2], scale)
    rows = np.arange(top, bottom) + 0.5
    expected = scale.luminance((bottom - rows) / (bottom - top))
    assert scale.position(found) == pytest.approx(scale.position(expected), abs=1.5 / STEPS)
    ticks = np.flatnonzero(strip[top - 1 :, 2 * line + line // 4].max(axis=1) < 200) + top - 1
    assert abs(ticks[0] - top) <= 1 and abs(ticks[-1] - bottom) <= 1


def test_ticks_are_round_and_hold_both_ends():
    assert LINEAR.ticks(5).tolist() == [0, 100, 200, 300, 400]
    assert Scale(730.0).ticks(4).tolist() == [0, 200, 400, 600, 730]
    expected = [10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000]
    assert LOGARITHMIC.ticks(3) == pytest.approx(expected)


def test_the_picture_stands_where_it_stood_and_low_ones_are_filled_with_white():
    y = np.full((20, 50), 300.0)
    whole = false_colours(y, LINEAR)
    assert whole.shape[0] > 20 and whole.shape[1] > 50
    assert np.all(whole[:20, :50] == LINEAR.colours(300.0)) and np.all(whole[20:, :50] == 255)


def test_what_lies_off_the_scale_is_told_beside_its_ends():
    plain, over = bar(LINEAR, 256), bar(LINEAR, 256, over=True)
    assert over.shape[1] >= plain.shape[1]
    width = plain.shape[1]
    differ = np.flatnonzero(np.any(plain != over[:, :width], axis=(1, 2)))
    assert len(differ) and differ.max() < 256 / 4, "only the number at the top is another"


def test_rounding_up():
    values = [1.0, 1.01, 730.0, 0.011, 9.99, 1e6, 1e-3]
    expected = [1.0, 1.2, 800.0, 0.012, 10.0, 1e6, 1e-3]
    assert [round_up(v) for v in values] == pytest.approx(expected, rel=1e-12)
    assert round_up(0.0) == 1.0


@pytest.mark.parametrize("maximum", [0.0, -1.0, np.inf, np.nan])
def test_impossible_scales_are_refused(maximum):
    with pytest.raises(ValueError, match=r"false colours up to .* must be positive and finite"):
        Scale(maximum)


def test_a_png_holds_them(tmp_path):
    import imageio.v3

    picture = Image(np.full((90, 40, 3), 0.25))
    write(picture, tmp_path / "a.png", scale=LINEAR)
    found = imageio.v3.imread(tmp_path / "a.png")
    assert np.array_equal(found, false_colours(picture.luminance, LINEAR))


@pytest.mark.parametrize(
    ("name", "gamma", "message"),
    [
        ("a.exr", None, r"false colours are for \.png: \.exr keeps linear radiance"),
        ("a.png", 2.2, "false colours are given as a screen shows them: leave out gamma"),
    ],
)
def test_false_colours_of_other_files_are_refused(tmp_path, name, gamma, message):
    with pytest.raises(ValueError, match=message):
        write(Image(np.ones((4, 4, 3))), tmp_path / name, gamma, LINEAR)
    assert not list(tmp_path.iterdir())
