"""Colours of scene files in grey, in RGB and in wavelengths; spectra that are read and refused."""

import subprocess
import sys

import numpy as np
import pytest

import radiosity
from radiosity.light import photometry
from radiosity.light.bands import FEWEST, GREY, RGB, mixed
from radiosity.light.palette import CELLS, Cells, Grey, Rgb, kind_of, of_source, palette_of
from radiosity.light.spectrum import Spectrum, colour_of, daylight, nanometres, tristimulus
from radiosity.light.texture import Mixed, Texture
from radiosity.scene.checks import Number
from radiosity.scene.model import SceneError
from radiosity.scene.schema import REFLECTANCE
from radiosity.scene.spectra import MOST, read_spectrum

SHARE = REFLECTANCE.check
FLOOR = """
[[geometry]]
material = "floor"
polygons = [[[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]]
[[geometry]]
material = "lamp"
polygons = [[[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]]]
[cameras.c]
position = [1, 0.5, 5]
target = [1, 0.5, 0]
"""
RED = "nm,value\n400,0.1\n560,0.1\n620,0.8\n700,0.9\n"
WARM = "# a lamp\n400,0.2\n500,1.0  # a comment\n\n700,3.0\n"


@pytest.fixture
def room(tmp_path):
    """Return a function that loads a scene of some materials with spectra beside it."""
    (tmp_path / "red.csv").write_text(RED)
    (tmp_path / "warm.csv").write_text(WARM)
    (tmp_path / "flat.csv").write_text("300,0.4\n900,0.4\n")

    def made(floor, lamp, bands="auto", accuracy=0.02, more=""):
        text = f"{FLOOR}[materials.floor]\n{floor}\n[materials.lamp]\ndiffuse = 0\n{lamp}\n{more}"
        (tmp_path / "room.toml").write_text(text)
        return radiosity.load(tmp_path / "room.toml", bands=bands, accuracy=accuracy)

    return made


def spectrum(text):
    return read_spectrum(text, "x.csv", Number(0))


def test_auto_takes_what_the_colours_ask_for(room):
    plain = "diffuse = [0.6, 0.3, 0.1]", "emission = { radiance = [3, 2, 1] }"
    assert room(*plain).bands is RGB and room(*plain).spectra == ()
    mixed = room('diffuse = "red.csv"', plain[1])
    assert mixed.bands.count == 24 and mixed.spectra == ("red.csv",) and mixed.notes == ()
    assert room(*plain, bands="grey").bands is GREY
    assert room(*plain, bands="spectral").bands.count == 24
    assert room(*plain, bands=12).bands.count == room(*plain, bands="12").bands.count == 12
    assert room('diffuse = "red.csv"', plain[1], bands="rgb").bands is RGB
    unused = room(*plain, more='[materials.spare]\ndiffuse = "red.csv"\n')
    assert unused.bands is RGB  # no face has it


def test_the_accuracy_chooses_how_many_wavelengths():
    assert kind_of("auto", True, 0.02) == 24 and kind_of("spectral", False, 0.005) == 48
    assert kind_of("auto", True, 0.5) == FEWEST and kind_of("auto", True, 1e-4) == 128
    for wrong in ("color", "7", "129", "-9", "1e3", 0, 3.5, "٣٢"):
        with pytest.raises(
            ValueError, match="must be auto, grey, rgb, spectral or a number of wave"
        ):
            kind_of(wrong, True, 0.02)


def test_light_has_the_luminance_that_its_spectrum_has_in_every_palette(room):
    floor, lamp = 'diffuse = "red.csv"', 'emission = { radiance = "warm.csv" }'
    exact = photometry.EFFICACY * tristimulus(spectrum(WARM).light())[1]
    for bands, off in (("grey", 1e-12), ("rgb", 1e-4), ("16", 2e-3), ("128", 1e-4)):
        scene = room(floor, lamp, bands=bands)  # off: rounding of weights, width of cells
        found = photometry.photometric(scene.materials[1].emission, scene.bands)
        assert found == pytest.approx(exact, rel=off)


@pytest.mark.parametrize("bands", ["grey", "rgb", "16", "61"])
@pytest.mark.parametrize(
    ("key", "value"),
    [("luminance", 1000.0), ("luminous_flux", 1000 * np.pi), ("radiance", 1000 / 683)],
)
def test_photometric_light_is_white_of_that_luminance(room, bands, key, value):
    scene = room("diffuse = 0.5", f"emission = {{ {key} = {value} }}", bands=bands)
    emission = scene.materials[1].emission
    assert photometry.photometric(emission, scene.bands) == pytest.approx(1000.0, rel=1e-12)
    np.testing.assert_allclose(scene.bands.to_rgb(emission), 1000 / 683, rtol=1e-12)


@pytest.mark.parametrize("bands", ["grey", "rgb", "16"])
def test_quantities_of_a_spectrum_differ_as_they_should(room, bands):
    def emitted(key):
        lamp = f'emission = {{ {key} = "warm.csv" }}'
        return room("diffuse = 0.5", lamp, bands=bands).materials[1].emission

    np.testing.assert_allclose(emitted("exitance"), emitted("radiance") / np.pi, rtol=1e-13)
    np.testing.assert_allclose(emitted("radiant_flux"), emitted("exitance"), rtol=1e-13)  # of 1 m2


def test_a_reflectance_in_rgb_is_that_of_the_lamp_it_is_seen_in(room):
    scene = room('diffuse = "red.csv"', 'emission = { radiance = "warm.csv" }', bands="rgb")
    expected = colour_of(spectrum(RED).share(), spectrum(WARM).light())
    np.testing.assert_allclose(scene.materials[0].diffuse, np.clip(expected, 0, 1), rtol=1e-12)
    assert "red.csv, warm.csv: taken as they look in the scene's own light" in scene.notes[0]
    by_day = room('diffuse = "red.csv"', "emission = { radiance = 2 }", bands="rgb")
    expected = colour_of(spectrum(RED).share(), daylight())
    np.testing.assert_allclose(by_day.materials[0].diffuse, expected, rtol=1e-12)
    dark = room('diffuse = "red.csv"', "", bands="rgb")
    expected = colour_of(spectrum(RED).share(), np.ones(471))
    np.testing.assert_allclose(dark.materials[0].diffuse, expected, rtol=1e-12)


def test_several_lamps_count_with_their_power(room):
    more = '[[lights]]\ntype = "point"\nposition = [0, 0, 0.5]\n'
    lamp = 'emission = { radiant_flux = "warm.csv" }'
    scene = room('diffuse = "red.csv"', lamp, "rgb", more=more + 'radiant_flux = "red.csv"\n')
    source = spectrum(WARM).light() + spectrum(RED).light()
    expected = np.clip(colour_of(spectrum(RED).share(), source), 0, 1)
    np.testing.assert_allclose(scene.materials[0].diffuse, expected, rtol=1e-12)
    np.testing.assert_allclose(
        4 * np.pi * scene.lights[0].intensity,
        np.maximum(RGB.to_rgb(Rgb().light(spectrum(RED))), 0), rtol=1e-12,
    )  # fmt: skip


def test_grey_is_the_luminous_reflectance_in_the_light_there_is(room):
    scene = room('diffuse = "red.csv"', 'emission = { radiance = "warm.csv" }', bands="grey")
    lamp = spectrum(WARM).light()
    expected = tristimulus(spectrum(RED).share() * lamp)[1] / tristimulus(lamp)[1]
    np.testing.assert_allclose(scene.materials[0].diffuse, [expected], rtol=1e-12)
    scene = room("diffuse = [0.6, 0.3, 0.1]", "emission = { radiance = [3, 2, 1] }", bands="grey")
    rho, light = np.array([0.6, 0.3, 0.1]), np.array([3.0, 2.0, 1.0])
    expected = RGB.luminance(rho * light) / RGB.luminance(light)
    np.testing.assert_allclose(scene.materials[0].diffuse, [expected], rtol=1e-12)
    np.testing.assert_allclose(scene.materials[1].emission, [RGB.luminance(light)], rtol=1e-12)


def test_absorptance_and_gloss_may_be_spectra(room):
    gloss = 'specular = { model = "phong", reflectance = "red.csv", exponent = 9 }'
    one = room('absorptance = "red.csv"', "", bands=16).materials[0]
    np.testing.assert_allclose(one.absorptance, Cells(16).share(spectrum(RED)), rtol=1e-13)
    np.testing.assert_allclose(one.diffuse + one.absorptance, 1.0, rtol=1e-13)
    one = room(f"diffuse = 0.05\n{gloss}", "", bands=16).materials[0]
    np.testing.assert_allclose(one.specular.reflectance, Cells(16).share(spectrum(RED)), rtol=1e-13)
    said = r"diffuse \+ specular = 1\.\d+ at 0 degrees in band \d+\.?\dnm must be at most 1"
    with pytest.raises(SceneError, match=said):
        room(f'diffuse = "red.csv"\n{gloss}', "")


def test_small_absorptances_keep_their_digits():
    for palette in (Grey(np.array([3.0, 2.0, 1.0])), Cells(16), Rgb()):
        np.testing.assert_allclose(palette.share((1e-12,) * 3), 1e-12, rtol=1e-14)


def test_truths_in_rgb_are_left_out_elsewhere():
    assert radiosity.load("scenes/furnace.toml").truth is not None
    scene = radiosity.load("scenes/furnace.toml", bands="grey")
    assert scene.truth is None and "truth is left out" in scene.notes[-1]


def test_bare_geometry_may_be_computed_in_any_bands(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl m\nKd 0.6 0.3 0.1\nKe 1 1 1\n")
    (tmp_path / "a.obj").write_text(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl m\nf 1 2 3 4\n"
    )
    grey = radiosity.load(tmp_path / "a.obj", bands="grey").materials[0]
    np.testing.assert_allclose(grey.diffuse, RGB.luminance([0.6, 0.3, 0.1])[None], rtol=1e-12)
    many = radiosity.load(tmp_path / "a.obj", bands="20")
    lit = many.materials[0].diffuse * many.materials[0].emission
    np.testing.assert_allclose(many.bands.to_rgb(lit), [0.6, 0.3, 0.1], rtol=1e-12)


def test_a_palette_knows_the_light_of_its_bands():
    assert palette_of(RGB) == Rgb() and palette_of(Cells(9).bands) == Cells(9)
    assert palette_of(GREY).light((2.0, 2.0, 2.0)).tolist() == [pytest.approx(2.0)]
    assert of_source("rgb", np.zeros(471)).source.tolist() == [1.0] * 471


def test_a_file_may_have_a_head_comments_and_empty_lines():
    found = spectrum("\ufeff".strip("\ufeff") + "nm, reflectance\n# x\n\n380, 0.5 # y\n780,1e-1\n")
    assert found.nm.tolist() == [380.0, 780.0] and found.values.tolist() == [0.5, 0.1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("400,0.5\n500,1.2\n", "line 2: value = 1.2 must lie in [0, 1]: a surface cannot "
         "reflect more than it receives; divide percents by 100"),
        ("400,-0.5\n500,0.2\n", "line 1: value = -0.5 must lie in [0, 1]"),
        ("400,0.5\n400,0.2\n", "line 2: 400 nm must be greater than the 400 nm before: sort the"),
        ("nm,value\n400,0.5\n500\n", "line 3: '500' must be a wavelength in nm and a value"),
        ("400,0.5\n500,0.2,1\n", "line 2: '500,0.2,1' must be a wavelength in nm and a value"),
        ("400,0.5\nx,y\n", "line 2: 'x,y' must be a wavelength"),
        ("400,nan\n500,0.2\n", "line 1: value = nan must be a finite number"),
        ("-1,0.5\n500,0.2\n", "line 1: -1 nm must be greater than the 0 nm before"),
        ("inf,0.5\n", "line 1: inf nm must be"),
        ("0.4,0.5\n0.7,0.2\n", "runs from 0.4 to 0.7 nm, but must have a part in [360, 830]: is it "
         "in micrometres?"),
        ("400,0.5\n", "has 1 lines of values, at least 2 are needed"),
        ("", "has 0 lines of values"),
    ],
)  # fmt: skip
def test_what_is_no_spectrum_is_told_with_line_and_way_out(text, said):
    with pytest.raises(SceneError) as error:
        read_spectrum(text, "x.csv", SHARE)
    assert len(error.value.problems) == 1
    assert said in error.value.problems[0]


def test_of_many_wrong_lines_some_are_told():
    with pytest.raises(SceneError) as error:
        read_spectrum("".join(f"{k},2\n" for k in range(400, 450)), "x.csv", SHARE)
    assert len(error.value.problems) == MOST + 1
    assert error.value.problems[-1] == "and 40 more lines like these"


def test_problems_of_spectra_are_told_with_the_others_and_with_their_key(room, tmp_path):
    (tmp_path / "bad.csv").write_text("400,5\n500,0.1\n")
    with pytest.raises(SceneError) as error:
        room('diffuse = "bad.csv"\nshine = 1', 'emission = { exitance = "none.csv" }')
    told = "\n".join(error.value.problems)
    assert "materials.floor.shine is not a known key" in told
    assert 'materials.lamp.emission.exitance = "none.csv" does not exist' in told
    with pytest.raises(SceneError, match=r'materials.floor.diffuse = "bad.csv" line 1: value = 5'):
        room('diffuse = "bad.csv"', "")
    with pytest.raises(
        SceneError, match='must be a number or .r, g, b., or a spectrum, "NAME.csv"'
    ):
        room('diffuse = "red.txt"', "")


def test_spectra_are_read_from_the_scenes_folder_only(room, tmp_path):
    outside = tmp_path.parent / "outside.csv"
    outside.write_text(RED)
    for name in ("../outside.csv", str(outside)):
        with pytest.raises(SceneError, match="lies outside the scene's folder"):
            room(f'diffuse = "{name}"', "")
    (tmp_path / "odd.csv").write_bytes(b"400,0.5\n\xff\n")
    with pytest.raises(SceneError, match="line 2 is not UTF-8"):
        room('diffuse = "odd.csv"', "")


def test_nanometres_run_from_360_to_830():
    assert nanometres()[[0, -1]].tolist() == [360.0, 830.0] and len(nanometres()) == 471
    assert isinstance(spectrum(WARM), Spectrum)


def test_scenes_without_spectra_import_nothing_of_them():
    code = (
        "import sys, radiosity as r; s = r.solve(r.load('scenes/furnace.toml'), 0.1);"
        "s.irradiance([[1, 1, 0]], [[0, 0, 1]]); r.render(s, size=(4, 4), samples=8);"
        "print([m for m in sys.modules if m.endswith(('.spectrum', '.upsampling', '.spectra'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr


def test_mixed_textures_are_textures_of_mixed_texels():
    random = np.random.default_rng(0)
    picture = Texture(random.uniform(0, 1, (5, 7, 3)))
    shares = Cells(12).shares
    one, two = Mixed(picture, shares), Texture(mixed(picture.texels, shares))
    places = random.uniform(-1, 2, (40, 2))
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) @ random.normal(size=(2, 2))
    polygons = random.uniform(0, 1, (10, 1, 2)) + 0.3 * square
    single = dict(rtol=2e-6, atol=1e-7)  # texels are float32
    np.testing.assert_allclose(one.at(places), two.at(places), **single)
    np.testing.assert_allclose(one.mean_over(polygons), two.mean_over(polygons), rtol=1e-4)
    for what in ("mean", "lowest", "highest"):
        np.testing.assert_allclose(getattr(one, what), getattr(two, what), **single)
    assert one.bands == two.bands == 12 and not one.grey
    grey = Mixed(Texture(np.repeat(random.uniform(0, 1, (2, 2, 1)), 3, axis=2)), shares)
    assert grey.grey and np.ptp(grey.at(places), axis=1).max() == 0.0


def test_grey_bands_of_a_narrow_lamp_have_no_negative_shares(room, tmp_path):
    """Green of 520 nm lies outside of sRGB: its red is negative, and has no share in the grey."""
    (tmp_path / "narrow.csv").write_text("519,0\n520,1\n521,0\n")
    scene = room("diffuse = [1, 0, 0]", 'emission = { radiance = "narrow.csv" }', bands="grey")
    assert 0.0 <= scene.materials[0].diffuse[0] < 0.01


def test_saturated_textures_stay_within_bounds_in_wavelengths():
    """Primaries add up to 1 to rounding only."""
    yellow = Mixed(Texture(np.ones((2, 2, 3)) * [1, 1, 0]), Cells(24).shares)
    uv = np.random.default_rng(2).random((9, 2))
    for values in (yellow.mean, yellow.highest, yellow.lowest, yellow.at(uv)):
        assert values.min() >= 0.0 and values.max() <= 1.0
    assert mixed(np.array([1.0, 1.0, 0.0]), Cells(24).shares).max() > 1.0  # or it tests nothing


@pytest.mark.parametrize("accuracy", [0.0, -1.0, np.nan])
def test_an_impossible_accuracy_is_left_to_the_solve(accuracy):
    assert kind_of("spectral", True, accuracy) == CELLS
