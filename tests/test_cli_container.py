"""The command line with .radsol files: nothing is solved again, and light is dimmed."""

import numpy as np
import pytest
from test_cli import FURNACE, radiosity, refused

from radiosity.cli.options import parse_dim
from radiosity.cli.session import Reading, load_scene
from radiosity.scene.model import SceneError
from radiosity.solve.load import load


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    folder = tmp_path_factory.mktemp("room")
    process = radiosity("solve", FURNACE, "--mesh", "1", "-o", "room.radsol", cwd=folder)
    assert process.returncode == 0 and (folder / "room.radsol").stat().st_size > 1000
    return folder


def test_info_tells_what_can_be_dimmed(room):
    out = radiosity("info", "room.radsol", cwd=room).stdout
    assert "solved: 6 patches, constant elements" in out and "asked 2 %" in out
    assert out.splitlines()[-1].startswith("dim: ")


def test_what_was_solved_is_probed_and_dimmed(room):
    """In the furnace the irradiance is B everywhere, 1.25, 4 and 2.5 W/m2."""
    points = "x,y,z,nx,ny,nz\n0.5,0.5,0.5,0,0,1\n"
    names = load(room / "room.radsol").groups
    dim = [x for name in names for x in ("--dim", f"{name}=0.5")]
    process = radiosity("probe", "room.radsol", "-", *dim, cwd=room, stdin=points)
    assert process.returncode == 0 and "solved before" in process.stderr
    found = [float(x) for x in process.stdout.splitlines()[1].split(",")[6:9]]
    assert found == pytest.approx([0.625, 2.0, 1.25], rel=1e-4)


def test_pictures_come_from_what_was_solved(room):
    asked = "-o", "room.npy", "--size", "8x6", "--samples", "8"
    process = radiosity("render", "room.radsol", *asked, cwd=room)
    assert process.returncode == 0 and "solved before" in process.stderr
    expected = np.array([1.25, 4.0, 2.5]) / np.pi  # L = B / pi everywhere
    assert np.load(room / "room.npy") == pytest.approx(np.tile(expected, (6, 8, 1)), rel=1e-4)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (("render", "room.radsol", "-o", "a.png", "--accuracy", "0.1", "--ambient", "1"),
         ("is solved, so --accuracy, --ambient cannot change it",)),
        (("solve", FURNACE, "--dim", "sun=1"), ("no light group is called 'sun'", "the scene has")),
    ],
)  # fmt: skip
def test_what_is_refused(room, asked, words):
    refused(radiosity(*asked, cwd=room), *words)


def test_verbs_that_plan_a_solution_want_a_scene(room):
    path = str(room / "room.radsol")
    with pytest.raises(ValueError, match="is solved: name the scene instead; radiosity info"):
        load_scene(path, "auto", Reading(), True)
    with pytest.raises(SceneError, match="does not exist: did you mean room.radsol"):
        load(room / "rom.radsol")


def test_factors_as_typed():
    assert parse_dim(["lamps=0.5", "a=b=2"]) == {"lamps": 0.5, "a=b": 2.0} and parse_dim(None) == {}
    for wrong in (["lamps"], ["=1"], ["lamps=x"], ["lamps=1", "lamps=2"]):
        with pytest.raises(ValueError, match="--dim"):
            parse_dim(wrong)
