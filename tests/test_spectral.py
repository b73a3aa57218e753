"""Scenes solved in wavelengths: metamers, products of spectra, energy, and what needs one band."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imageio.v3 import imread, imwrite

import radiosity
from radiosity.cli.session import Reading, load_scene
from radiosity.cli.solve import summary
from radiosity.light.bands import RGB
from radiosity.light.colour import XYZ_TO_RGB, delta_e_2000, encode, lab
from radiosity.light.palette import Cells
from radiosity.light.phong import Phong
from radiosity.light.photometry import photometric
from radiosity.light.spectrum import Spectrum, tristimulus
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Material, Scene
from radiosity.solve.methods import System, proportional_bands
from radiosity.solve.plan import make_plan
from radiosity.solve.requirements import foresee

SCENES = Path(__file__).resolve().parent.parent / "scenes"
SPECTRAL = SCENES / "cornell_box_spectral.toml"
LAMP = Spectrum(np.array([380.0, 500.0, 700.0]), np.array([0.2, 1.0, 3.0]))
PALETTE = Cells(24)
ROOM = """
[[geometry]]
material = "wall"
polygons = [
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]],
    [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], [[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]],
    [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]], [[0, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]],
]
"""


def court(floors, light):
    """Return a scene of floors beside each other that see a black lamp above them, and no other."""
    x = np.arange(len(floors))
    floor = np.array([[[k, 0, 0], [k + 1, 0, 0], [k + 1, 1, 0], [k, 1, 0]] for k in x], float)
    above = np.array([[[0, 0, 1], [0, 1, 1], [len(x), 1, 1], [len(x), 0, 1]]], float)
    dark = np.zeros(PALETTE.count)
    made = [Material(f"floor {k}", rho, 1 - rho, dark) for k, rho in enumerate(floors)]
    made.append(Material("lamp", dark, 1 - dark, light))
    index = np.arange(len(made))
    return Scene(
        "court", Faces(np.concatenate([floor, above]), index, index), tuple(made),
        tuple(m.name for m in made), bands=PALETTE.bands,
    )  # fmt: skip


def seen(scene, light):
    """Return CIELAB of what each floor of a court sends out, beside a white one."""
    solution = radiosity.solve(scene, mesh="1", order=0)
    floors = solution.patches.face[solution.patches.front] < len(scene.materials) - 1
    e, b = (x[: len(floors)][floors] for x in (solution.irradiance_on, solution.radiosity))
    xyz, white = (np.linalg.solve(XYZ_TO_RGB, PALETTE.bands.to_rgb(x).T).T for x in (b, e))
    return np.array([lab(one, w) for one, w in zip(xyz, white, strict=True)])


def metamers():
    """Return two reflectances of one colour in daylight: they differ by what daylight hides."""
    day = PALETTE.light((1.0, 1.0, 1.0))
    base = np.full(PALETTE.count, 0.4)
    hidden = np.linalg.svd(PALETTE.bands.rgb * day)[2][3:]
    wanted = np.sin(np.linspace(0, 3 * np.pi, PALETTE.count))
    change = hidden.T @ (hidden @ wanted)
    return base, base + 0.35 * change / np.abs(change).max()


def test_metamers_match_in_one_light_and_part_in_another():
    one, two = metamers()
    assert np.abs(one - two).max() > 0.3 and two.min() >= 0.0 and two.max() <= 1.0
    day, lamp = PALETTE.light((1.0, 1.0, 1.0)), PALETTE.light(LAMP)
    same, apart = (delta_e_2000(*seen(court([one, two], light), light)) for light in (day, lamp))
    assert same < 0.01 and apart > 3.0
    in_rgb = [PALETTE.bands.to_rgb(x * day) for x in (one, two)]
    np.testing.assert_allclose(*in_rgb, rtol=1e-12)  # RGB could not tell them apart in any light


def test_a_coloured_floor_in_coloured_light_has_the_product_of_their_spectra():
    wall = Spectrum(np.array([400.0, 550.0, 600.0, 700.0]), np.array([0.1, 0.1, 0.8, 0.9]))
    lamp = PALETTE.light(LAMP)
    scene = court([PALETTE.share(wall), np.full(PALETTE.count, 0.5)], lamp)
    solution = radiosity.solve(scene, mesh="1", order=0)
    floor, white = solution.radiosity[:2]
    np.testing.assert_allclose(floor, PALETTE.share(wall) * solution.irradiance_on[0], rtol=1e-13)
    np.testing.assert_allclose(white / white.sum(), lamp / lamp.sum(), rtol=1e-12)
    exact, source = tristimulus(wall.share() * LAMP.light()), tristimulus(LAMP.light())
    xyz = np.linalg.solve(XYZ_TO_RGB, PALETTE.bands.to_rgb(floor))
    unit = 2 * np.linalg.solve(XYZ_TO_RGB, PALETTE.bands.to_rgb(white))
    off = delta_e_2000(lab(xyz, unit), lab(exact, source))
    assert off < 0.3  # the cells' own error; the product of the RGB is off by more
    product = (XYZ_TO_RGB @ exact) / (XYZ_TO_RGB @ source)
    alone = XYZ_TO_RGB @ tristimulus(wall.share()) / (XYZ_TO_RGB @ tristimulus(np.ones(471)))
    assert np.abs(product - alone).max() > 0.05


@pytest.fixture
def write(tmp_path):
    def written(wall):
        (tmp_path / "flat.csv").write_text("380,0.4\n780,0.4\n")
        (tmp_path / "red.csv").write_text("400,0.1\n560,0.1\n620,0.8\n700,0.9\n")
        (tmp_path / "lamp.csv").write_text("380,0.2\n500,1\n700,3\n")
        path = tmp_path / "room.toml"
        path.write_text(f"{ROOM}[materials.wall]\n{wall}\n")
        return path

    return written


def test_a_furnace_of_spectra_is_its_closed_form_at_every_wavelength(write):
    path = write('diffuse = "red.csv"\nemission = { exitance = "lamp.csv" }')
    scene = radiosity.load(path)
    solution = radiosity.solve(scene, 0.1, mesh="2")
    rho = scene.materials[0].diffuse
    expected = PALETTE.light(LAMP) / (1.0 - rho)
    np.testing.assert_allclose(solution.radiosity, [expected] * 24, rtol=1e-6)  # the tolerance
    balance = solution.balance
    np.testing.assert_allclose(balance.absorbed, balance.emitted, rtol=1e-6)  # in each band
    assert not balance.escaped.any()


@pytest.mark.parametrize("diffuse", ["0.4", '"flat.csv"'])
def test_what_is_grey_is_the_same_in_one_band_in_three_and_in_wavelengths(write, diffuse):
    path = write(f"diffuse = {diffuse}\nemission = {{ radiance = 2 }}")
    found = {
        bands: radiosity.solve(radiosity.load(path, bands=bands), 0.1, mesh="2")
        for bands in ("grey", "rgb", "24")
    }
    for solution in found.values():
        assert len(solution.history) == len(found["rgb"].history)
        np.testing.assert_allclose(solution.illuminance, found["rgb"].illuminance, rtol=1e-12)
        rgb = solution.scene.bands.to_rgb(solution.radiosity)
        np.testing.assert_allclose(rgb, found["rgb"].radiosity, rtol=1e-12)


def test_flat_spectra_in_one_light_are_solved_once(write):
    scene = radiosity.load(write('diffuse = "flat.csv"\nemission = { radiance = "lamp.csv" }'))
    level = radiosity.solve(scene, 0.1, mesh="2").level
    terms = level.terms
    system = System(level.factors, terms.reflectance, terms.absorptance, terms.emission)
    assert len(set(proportional_bands(system)[1])) == 1
    made = foresee(scene, make_plan(scene, 0.1, "2")).requirements
    assert (made[0].name, made[0].model) == ("bands", "1")


def test_the_plan_says_which_bands_and_why():
    def said(path, bands):
        scene = radiosity.load(path, bands=bands)
        return foresee(scene, make_plan(scene, 0.1, "1")).requirements[0]

    auto = said(SPECTRAL, "auto")
    assert auto.model == "24 wavelengths"
    assert "spectra are given: cornell_spectra/white.csv" in auto.reason
    assert "and 2 more" in auto.reason
    assert said(SPECTRAL, "rgb").model == "3" and "taken as RGB" in said(SPECTRAL, "rgb").reason
    assert said(SPECTRAL, "grey").model == "1"
    plain = SCENES / "cornell_box.toml"
    assert said(plain, "16").model == "16 wavelengths" and "asked for" in said(plain, "16").reason
    assert said(plain, "auto").reason == "reflectances or lights differ in colour"


def test_rgb_scenes_look_alike_in_wavelengths():
    """Red walls lit by white walls: products of smooth spectra, not of three numbers."""
    three, many = (
        radiosity.solve(radiosity.load(SCENES / "cornell_box.toml", bands=b), mesh="2", order=1)
        for b in ("rgb", "24")
    )
    assert many.scene.bands.count == 24
    np.testing.assert_allclose(
        many.scene.bands.to_rgb(many.balance.emitted), three.balance.emitted, rtol=1e-12
    )  # fmt: skip
    ratio = many.illuminance[many.live] / three.illuminance[three.live]
    assert np.abs(ratio - 1).max() < 0.1  # the darkest places see walls of two colours only
    assert np.abs(ratio - 1).max() > 1e-3


def test_lumens_of_spectra_are_balanced_and_the_same_in_rgb():
    solutions = [
        radiosity.solve(radiosity.load(SPECTRAL, bands=b), mesh="2", order=1)
        for b in ("rgb", "auto")
    ]
    lumens = [photometric(s.balance.emitted, s.scene.bands) for s in solutions]
    assert lumens[0] == pytest.approx(lumens[1], rel=2e-3)  # the cells' error
    power = solutions[1].balance
    off = power.emitted - power.absorbed - power.escaped
    assert np.abs(off).max() < 1e-2 * power.emitted.max()
    rows = summary(solutions[1]).splitlines()
    assert rows[3].split() == ["power", "in", "lm", "luminous"]
    assert float(rows[4].split()[1]) == pytest.approx(lumens[1], rel=1e-5)
    red = solutions[0].illuminance.mean(), solutions[1].illuminance.mean()
    assert red[0] == pytest.approx(red[1], rel=0.01)


def test_pictures_of_spectra_keep_what_screens_cannot_show(tmp_path):
    solution = radiosity.solve(radiosity.load(SPECTRAL), 0.1)
    image = radiosity.render(solution, size=(48, 48), samples=16)
    assert image.pixels.min() < -2e-4 and 0 < image.outside < 0.2 * 48**2
    radiosity.write(image, tmp_path / "a.npy")
    assert np.load(tmp_path / "a.npy").min() == image.pixels.min()
    assert not radiosity.render(
        radiosity.solve(radiosity.load(SPECTRAL, bands="rgb"), 0.1), size=(24, 24), samples=8
    ).outside


def test_ambient_light_is_daylight(tmp_path):
    for bands in ("grey", "rgb", "20"):
        scene = load_scene(str(SCENES / "lroom.toml"), "auto", Reading(bands, 3.0), True)
        plain = radiosity.load(SCENES / "lroom.toml", bands=bands)
        entering = scene.ambient - plain.ambient
        np.testing.assert_allclose(scene.bands.to_rgb(entering), 3.0, rtol=1e-12)


def test_single_wavelengths_cannot_be_asked_for_by_accident():
    scene = replace(radiosity.load(SPECTRAL), bands=RGB)
    with pytest.raises(radiosity.SceneError, match=r"has the shape \(24,\), must have \(3,\)"):
        radiosity.solve(scene, mesh="1")


def run(*args, cwd=None):
    return subprocess.run(
        [sys.executable, "-m", "radiosity", *args], capture_output=True, text=True, cwd=cwd
    )


def test_every_verb_takes_bands(tmp_path):
    points = tmp_path / "p.csv"
    points.write_text("x,y,z,nx,ny,nz\n278,0,200,0,1,0\n")
    lux = {}
    for bands in ("rgb", "24", "grey"):
        done = run("probe", str(SPECTRAL), str(points), "--bands", bands, "--accuracy", "0.1")
        head, row = (line.split(",") for line in done.stdout.splitlines())
        found = dict(zip(head, map(float, row), strict=True))
        lux[bands] = found["illuminance"]
        rgb = [found[k] for k in ("E_r", "E_g", "E_b")]
        assert 683 * RGB.luminance(rgb) == pytest.approx(found["illuminance"], rel=1e-3)
    assert lux["24"] == pytest.approx(lux["rgb"], rel=0.02)
    assert lux["24"] == pytest.approx(lux["grey"], rel=0.05)
    info = run("info", str(SPECTRAL), "--bands", "12").stdout
    assert "colours in 12 wavelengths, of cornell_spectra/white.csv" in info
    assert "\nwhite" in info and " to 0.7" in info
    plan = run("plan", str(SPECTRAL), "--bands", "spectral", "--accuracy", "0.1").stdout
    assert "11 wavelengths" in plan  # 24 by the root of the accuracy
    solve = run("solve", str(SPECTRAL), "--mesh", "1", "-o", "a.csv", cwd=tmp_path)
    assert "power in lm" in solve.stdout
    assert (tmp_path / "a.csv").read_text().splitlines()[0].count("nm_W_m2") == 3 * 24
    view = run("view", str(SPECTRAL), "--screenshot", "v.png", "--size", "16x16", "--bands", "8",
               "--samples", "8", "--mesh", "1", cwd=tmp_path)  # fmt: skip
    assert view.returncode == 0 and (tmp_path / "v.png").exists()


def test_pictures_for_a_screen_of_a_power_and_what_is_told_of_colours(tmp_path):
    args = str(SPECTRAL), "--size", "24x24", "--samples", "8", "--mesh", "1"
    for name, more in (("s.png", ()), ("g.png", ("--gamma", "1")), ("a.npy", ())):
        done = run("render", *args, "-o", name, *more, cwd=tmp_path)
        assert "lie outside of sRGB: .exr and .npy keep them, .png greys them" in done.stderr
    curved, straight = (imread(tmp_path / n).astype(float) / 255 for n in ("s.png", "g.png"))
    np.testing.assert_allclose(encode(straight), curved, atol=0.03)  # 8 bits of the darkest
    refused = run("render", *args, "-o", "g.exr", "--gamma", "2")
    assert refused.returncode == 2 and "--gamma 2 is for .png" in refused.stderr


def test_wrong_bands_are_told_at_once():
    for verb in ("view", "solve", "plan", "tradeoff", "info"):
        done = run(verb, str(SPECTRAL), "--bands", "5")
        assert done.returncode == 2 and done.stdout == "" and "Traceback" not in done.stderr
        assert "must be auto, grey, rgb, spectral or a number of wavelengths from 8" in done.stderr


COURT = """
[[geometry]]
material = "floor"
polygons = [[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]]
uv = [[[0, 0], [1, 0], [1, 1], [0, 1]]]
[[geometry]]
material = "sheet"
polygons = [[[0, 0, 0.5], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0.5]]]
[[geometry]]
material = "lamp"
polygons = [[[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]]]
[cameras.c]
position = [0.5, 0.5, 0.4]
target = [0.5, 0.5, 0]
up = [0, 1, 0]
fov = 90
[materials.floor]
diffuse = { texture = "tiles.png", scale = 0.8 }
[materials.sheet]
diffuse = 0
translucent = [0.6, 0.3, 0.1]
[materials.lamp]
diffuse = 0
emission = { radiance = 2 }
"""


@pytest.mark.parametrize("bands", ["24", "grey"])
def test_textures_and_sheets_are_seen_in_daylight_as_in_rgb(tmp_path, bands):
    tiles = np.random.default_rng(0).integers(0, 256, (4, 4, 3)).astype(np.uint8)
    imwrite(tmp_path / "tiles.png", tiles)
    plain = COURT.replace("translucent = [0.6, 0.3, 0.1]", "translucent = 0.9")
    for text, exact in ((plain, True), (COURT, False)):
        (tmp_path / "court.toml").write_text(text)
        three, many = (
            radiosity.solve(radiosity.load(tmp_path / "court.toml", bands=b), mesh="4")
            for b in ("rgb", bands)
        )
        floor = three.patches.front & (three.scene.faces.material[three.patches.face] == 0)
        found, expected = (s.scene.bands.to_rgb(s.radiosity[floor]) for s in (many, three))
        pictures = [radiosity.render(s, size=(12, 12), samples=16).pixels for s in (many, three)]
        if bands == "grey":
            found, expected = (RGB.luminance(x) for x in (found, expected))
            off = 0.05 if exact else 0.2  # all of a texture counts in the light of the lamp
            assert found.mean() == pytest.approx(expected.mean(), rel=off)
        elif exact:  # seen once, in daylight: tiles do not see each other
            np.testing.assert_allclose(found, expected, rtol=1e-4)  # once more by the sheet
            np.testing.assert_allclose(*pictures, rtol=1e-3, atol=1e-4)
        else:  # tiles below a coloured sheet: products of spectra, in the mean not far from RGB's
            ratio = found.mean(axis=0) / expected.mean(axis=0)
            assert 1e-3 < np.abs(ratio - 1).max() < 0.15


def test_coloured_gloss_and_sheets_need_all_bands():
    square = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]])
    grey = Material("m", np.full(3, 0.2), np.full(3, 0.8), np.ones(3))
    colour = np.array([0.3, 0.2, 0.1])
    for material, model in (
        (grey, "1"), (replace(grey, specular=Phong(colour, 9.0)), "3"),
        (replace(grey, translucent=colour), "3"),
    ):  # fmt: skip
        scene = Scene("s", Faces.from_polygons(square, 0, 0), (material,), ("all",))
        assert foresee(scene, make_plan(scene, 0.1, "1")).requirements[0].model == model
