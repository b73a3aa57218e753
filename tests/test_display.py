"""What is shown how: exposure and false colours as typed, orthographic and all cameras."""

import subprocess
import sys
from dataclasses import replace

import imageio.v3
import numpy as np
import pytest
import typer

import radiosity
from radiosity.cli.display import Exposure, FalseColours, exposure, false_colours
from radiosity.cli.render import _check_names
from radiosity.view.falsecolour import Scale, bar, round_up
from radiosity.view.image import tone_map
from radiosity.view.shading import auto_exposure

PLATES = """
name = "plates"
[[geometry]]                       # a floor, and a plate 1 over it
material = "floor"
polygons = [[[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]]]
[[geometry]]
material = "plate"
polygons = [[[1, 1, 1], [3, 1, 1], [3, 2, 1], [1, 2, 1]]]
[materials.floor]
diffuse = 0
emission = { luminance = 100 }
[materials.plate]
diffuse = 0
emission = { luminance = 250 }
[cameras.plan]
position = [2, 2, 50]
target = [2, 2, 0]
up = [0, 1, 0]
projection = "orthographic"
height = 8
size = [80, 80]
[cameras."eye level"]
position = [2, -6, 3]
target = [2, 2, 0]
size = [24, 16]
"""


def run(*words, cwd):
    return subprocess.run(
        [sys.executable, "-m", "radiosity", *map(str, words)],
        capture_output=True, text=True, timeout=300, cwd=cwd,
    )  # fmt: skip


@pytest.fixture
def plates(tmp_path):
    (tmp_path / "plates.toml").write_text(PLATES)
    return tmp_path


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    path = tmp_path_factory.mktemp("plates") / "plates.toml"
    path.write_text(PLATES)
    return radiosity.solve(radiosity.load(path), 0.2)


def luminances(solution, camera):
    return radiosity.render(solution, camera, samples=8).luminance


def test_a_plan_shows_true_lengths_at_any_height(solved):
    """10 pixels a unit: the floor fills 40 x 40 of them, the plate 20 x 10, not larger for being
    nearer; a pixel's radiance is the emitter's, from wherever one looks."""
    y = luminances(solved, "plan")
    expected = np.zeros((80, 80))
    expected[20:60, 20:60] = 100.0
    expected[40:50, 30:50] = 250.0
    assert y == pytest.approx(expected, rel=1e-6)
    far = replace(solved.scene.cameras["plan"], position=np.array([2.0, 2.0, 5.0]))
    assert luminances(solved, far) == pytest.approx(expected, rel=1e-6)


def test_what_is_behind_an_orthographic_camera_is_not_seen(solved):
    between = replace(solved.scene.cameras["plan"], position=np.array([2.0, 2.0, 0.5]))
    y = luminances(solved, between)
    assert y.max() == pytest.approx(100.0, rel=1e-6), "the plate is above the camera"


def test_all_cameras_are_rendered_of_one_solution_with_one_exposure(plates, solved):
    done = run("render", "plates.toml", "-o", "out.png", "--all", "--samples", "8",
               "--accuracy", "0.2", cwd=plates)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in plates.glob("*.png")) == ["out-eye level.png", "out-plan.png"]
    assert done.stderr.count("solved") == 1
    e = auto_exposure(solved)
    told = [line for line in done.stderr.splitlines() if line.startswith("wrote")]
    assert told == [f"wrote out-{n}.png, exposure {e:.4g}" for n in ("plan", "eye level")]
    for name in ("plan", "eye level"):
        alone = radiosity.render(solved, name, samples=8)
        assert np.array_equal(imageio.v3.imread(plates / f"out-{name}.png"), alone.shown())


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["-o", "a.png", "--all", "--camera", "plan"], "--camera plan and --all exclude each"),
        (["-o", "a.exr", "--exposure", "2"], "--exposure is for .png: .exr keeps linear radiance"),
        (["-o", "a.exr", "--false-colour", "log"], "false colours are for .png"),
        (["-o", "a.png", "--false-colour", "9", "--exposure", "2"], "--exposure does not change"),
        (["-o", "a.png", "--false-color", "9", "--gamma", "2"], "leave out gamma"),
        (["-o", "a.png", "--exposure", "bright"], "'bright' must be auto, auto+1 or auto-1"),
        (["-o", "a.png", "--false-colour", "0"], "'0' must be auto, log, or the luminance"),
    ],
)
def test_what_cannot_be_is_refused_in_one_message(plates, words, told):
    done = run("render", "plates.toml", *words, cwd=plates)
    assert done.returncode == 2 and "Traceback" not in done.stderr
    assert told in " ".join(done.stderr.split())
    assert [p.name for p in plates.iterdir()] == ["plates.toml"]


@pytest.mark.parametrize("name", ["a/b", "..\\b", "a:b", "new\nline", "what?", "", "  "])
def test_names_that_no_file_can_have_are_refused(name):
    with pytest.raises(ValueError, match="--all: the camera's name .* which file names cannot"):
        _check_names(["front", name])


def test_names_of_one_file_are_refused():
    _check_names(["front", "back", "..", "Straße 7"])
    with pytest.raises(ValueError, match="the cameras 'front' and 'Front' differ in case only"):
        _check_names(["front", "Front"])


def test_a_name_with_a_slash_is_refused_before_anything_is_solved(plates):
    (plates / "plates.toml").write_text(PLATES.replace("eye level", "../eye"))
    done = run("render", "plates.toml", "-o", "a.png", "--all", cwd=plates)
    assert done.returncode == 2 and "'../eye' holds '/'" in done.stderr
    assert "solved" not in done.stderr and [p.name for p in plates.iterdir()] == ["plates.toml"]


def test_exposure_is_a_value_or_stops_from_the_automatic_one(solved):
    auto = auto_exposure(solved)
    assert exposure("auto") == Exposure() and exposure("auto").of(solved) == auto
    assert exposure("auto+1").of(solved) == 2 * auto and exposure("AUTO-2").of(solved) == auto / 4
    assert exposure("auto+0.5").of(solved) == pytest.approx(2**0.5 * auto)
    assert exposure("0.05").of(solved) == 0.05
    for wrong in ("0", "-1", "auto1", "auto+", "nan", "inf", "auto+1e9", "x", "auto+101", "+1"):
        with pytest.raises(typer.BadParameter, match="positive display value per radiance"):
            exposure(wrong)


def test_false_colours_are_of_a_maximum_or_automatic(solved):
    assert false_colours("500").of(solved) == Scale(500.0)
    assert false_colours("log:500").of(solved) == Scale(500.0, 3.0)
    assert false_colours("log").of(solved) == Scale(250.0, 3.0), "its brightest patch"
    assert false_colours("auto").of(solved) == Scale(round_up(683 / auto_exposure(solved)))
    assert false_colours("log") == FalseColours(True, None)
    for wrong in ("", "0", "-1", "log:", "log500", "log:0", "nan", "lin", "auto:3", ":5", "inf"):
        with pytest.raises(typer.BadParameter, match="luminance in cd/m2 at the scale's end"):
            false_colours(wrong)


def test_render_takes_an_exposure(plates, solved):
    done = run("render", "plates.toml", "-o", "a.png", "--exposure", "0.5", "--samples", "8",
               "--accuracy", "0.2", cwd=plates)  # fmt: skip
    assert done.returncode == 0 and "wrote a.png, exposure 0.5\n" in done.stderr
    expected = replace(radiosity.render(solved, samples=8), exposure=0.5).shown()
    assert np.array_equal(imageio.v3.imread(plates / "a.png"), expected)


def test_render_writes_false_colours_with_their_scale(plates):
    done = run("render", "plates.toml", "-o", "a.png", "--false-colour", "250", "--samples", "8",
               "--accuracy", "0.2", cwd=plates)  # fmt: skip
    assert done.returncode == 0, done.stderr
    found, scale = imageio.v3.imread(plates / "a.png"), Scale(250.0)
    assert found[45, 40].tolist() == scale.colours(250.0).tolist()
    assert found[25, 25].tolist() == scale.colours(100.0).tolist()
    assert found[5, 5].tolist() == scale.colours(0.0).tolist()
    assert np.array_equal(found[:, 80:], bar(scale, 80))


def test_view_takes_both(plates):
    words = ["view", "plates.toml", "--samples", "8", "--accuracy", "0.2"]
    done = run(*words, "--screenshot", "a.png", "--exposure", "0.5", cwd=plates)
    assert done.returncode == 0, done.stderr
    done = run(*words, "--screenshot", "b.png", "--false-colour", "250", cwd=plates)
    assert done.returncode == 0, done.stderr
    level = tone_map(np.float64(100 / 683), 0.5)
    assert imageio.v3.imread(plates / "a.png")[25, 25].tolist() == [level] * 3
    shown = imageio.v3.imread(plates / "b.png")
    assert shown[25, 25].tolist() == Scale(250.0).colours(100.0).tolist()
