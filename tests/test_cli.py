"""The command line as a user meets it: results, messages and exit codes, in a real process."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from radiosity.analytic import load_cases
from radiosity.cli.tradeoff import row
from radiosity.solve.tradeoff import Trial
from radiosity.solve.verification import SUITES
from radiosity.view.image import Image
from radiosity.view.levels import PictureTrial
from radiosity.view.plot import plot_tradeoff

SCENES = Path(__file__).resolve().parent.parent / "scenes"
CORNELL, BOX, FURNACE = (
    str(SCENES / f"{n}.toml") for n in ("cornell_box", "box6", "furnace")
)
POINTS = str(SCENES / "cornell_box_reference" / "points.csv")


def radiosity(*args, cwd=None, stdin=None, **env):
    """Run the command line; return the finished process."""
    return subprocess.run(
        [sys.executable, "-m", "radiosity", *args],
        capture_output=True, text=True, cwd=cwd, input=stdin, timeout=300,
        env={**os.environ, **env},
    )  # fmt: skip


def refused(process, *words, code=2):
    """Assert one clear message on stderr: no traceback, nothing on stdout."""
    assert process.returncode == code, process.stderr
    assert "Traceback" not in process.stderr
    assert process.stdout == ""
    for word in words:
        assert word in process.stderr


def test_help_names_every_verb():
    process = radiosity("--help")
    assert process.returncode == 0
    for verb in (
        "view", "solve", "render", "probe", "plan", "tradeoff", "formfactors", "info", "verify",
        "materials",
    ):  # fmt: skip
        assert verb in process.stdout


def test_help_imports_nothing_heavy():
    code = "import sys, radiosity.cli.main; print([m for m in sys.modules])"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout
    for heavy in ("'numpy'", "'numba'", "'pyvista'", "'scipy'", "'pydantic'", "'trimesh'"):
        assert heavy not in loaded


def test_info_describes_the_scene():
    out = radiosity("info", CORNELL).stdout
    assert "faces 20 (quadrilaterals 18, triangles 2)" in out
    assert "0.725 0.71 0.68" in out and "17 12 4" in out
    assert "front" in out and "mm" in out


def test_materials_shows_what_they_were_read_as():
    out = radiosity("materials", CORNELL).stdout
    assert "# as the scene file has it\n[materials.red]\ndiffuse = [0.63, 0.065, 0.05]" in out
    alien = str(SCENES.parent / "tests" / "foreign" / "alien.glb")
    found = json.loads(radiosity("materials", alien, "--json").stdout)
    info = radiosity("info", alien).stdout
    for name, said in found.items():
        assert f"read as: {name}: {said['origin']}" in info
        assert said["origin"].startswith("glTF: base colour") and said["table"]["diffuse"]
    refused(radiosity("materials", "nothing.glb"), "does not exist")


def test_solve_prints_the_balance_and_meets_the_truth(tmp_path):
    process = radiosity("solve", BOX, "--mesh", "1", "-o", str(tmp_path / "out.csv"))
    assert process.returncode == 0, process.stderr
    assert "closed" in process.stdout
    truth = process.stdout.split("relative error ")[1].split(",")[0]
    assert float(truth) < 1e-6  # stated 1e-4; the exact factors reach 4e-7
    rows = list(csv.DictReader((tmp_path / "out.csv").open()))
    assert len(rows) == 6
    assert float(rows[1]["illuminance_lx"]) > 0


@pytest.mark.parametrize("solver", ["gmres", "direct"])
def test_every_solver_meets_the_furnace(solver):
    out = radiosity("solve", FURNACE, "--solver", solver, "--accuracy", "0.1").stdout
    assert float(out.split("relative error ")[1].split(",")[0]) < 1e-6


def test_probe_meets_the_reference(tmp_path):
    out = tmp_path / "light.csv"
    process = radiosity("probe", CORNELL, POINTS, "-o", str(out))
    assert process.returncode == 0, process.stderr
    rows = list(csv.DictReader(out.open()))
    assert list(rows[0]) == [*"xyz", "nx", "ny", "nz", "E_r", "E_g", "E_b", "illuminance", "error"]
    found = np.array([[float(r[f"E_{b}"]) for b in "rgb"] for r in rows])
    table = np.genfromtxt(
        SCENES / "cornell_box_reference" / "irradiance.csv", delimiter=",", names=True,
        dtype=None, encoding="utf-8",
    )  # fmt: skip
    expected = np.stack([table[f"E_{b}"] for b in "rgb"], axis=1)
    weights = np.array([0.2126, 0.7152, 0.0722])
    y, truth = found @ weights, expected @ weights
    errors = np.abs(y - truth) / np.maximum(truth, 0.1 * truth.mean())
    assert np.median(errors) < 0.01
    assert np.percentile(errors, 95) < 0.03
    lux = np.array([float(r["illuminance"]) for r in rows])
    np.testing.assert_allclose(lux, 683 * y, rtol=1e-6)  # seven digits are printed


def test_probe_reads_stdin_and_writes_stdout():
    process = radiosity("probe", FURNACE, "-", "--accuracy", "0.5",
                        stdin="nz,ny,nx,z,y,x\n1,0,0,0,1,1\n")  # fmt: skip
    last = process.stdout.splitlines()[-1].split(",")
    assert [float(v) for v in last[:6]] == [1, 1, 0, 0, 0, 1]
    np.testing.assert_allclose([float(v) for v in last[6:9]], [1.25, 4, 2.5], rtol=1e-5)


def test_render_writes_linear_and_shown_pictures(tmp_path):
    for suffix in (".npy", ".exr", ".hdr", ".png"):
        out = tmp_path / f"picture{suffix}"
        process = radiosity("render", FURNACE, "-o", str(out), "--size", "24x16",
                            "--samples", "16", "--accuracy", "0.5")  # fmt: skip
        assert process.returncode == 0, process.stderr
        assert out.stat().st_size > 0
    pixels = np.load(tmp_path / "picture.npy")
    assert pixels.shape == (16, 24, 3)
    np.testing.assert_allclose(
        pixels, np.broadcast_to(np.array([1.25, 4, 2.5]) / np.pi, pixels.shape), rtol=1e-4
    )  # every sight line in a furnace meets B/pi; the coarse mesh's row sums bound it


def test_view_without_a_display_writes_the_picture_and_says_so(tmp_path):
    process = radiosity("view", FURNACE, "--size", "32x32", "--samples", "16", "--accuracy", "0.5",
                        cwd=tmp_path, DISPLAY="", WAYLAND_DISPLAY="")  # fmt: skip
    assert process.returncode == 0, process.stderr
    assert "no display" in process.stderr
    assert (tmp_path / "furnace.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_verify_runs_all_suites():
    process = radiosity("verify")
    assert process.returncode == 0
    assert {line.split()[0] for line in process.stdout.splitlines()} >= set(SUITES)


def test_verify_reports_every_case_of_a_suite_within_its_bound():
    """Of one suite: test_readme.py runs all of them."""
    process = radiosity("verify", "--suite", "elements")
    assert process.returncode == 0, process.stdout
    assert "all within their bounds" in process.stdout
    for case in load_cases("vf_element_polygon"):
        assert case["id"] in process.stdout
    helped = radiosity("verify", "--help").stdout
    assert all(name in helped for name in SUITES)


def test_plan_says_what_is_required_in_words_and_as_json():
    out = radiosity("plan", BOX).stdout
    lines = [" ".join(line.split()[:2]) for line in out.splitlines()]
    for line in ("visibility nothing", "environment nothing", "elements linear", "time about"):
        assert line in lines
    found = json.loads(radiosity("plan", CORNELL, "--json").stdout)
    models = {r["name"]: r["model"] for r in found["requirements"]}
    assert models["visibility"] == "exact shadows" and models["environment"] == "black"
    assert found["patches"] > 100 and found["seconds"] > 0 and found["memory_bytes"] > 1e8


def test_solve_says_what_it_reached():
    out = radiosity("solve", BOX, "--accuracy", "0.1").stdout
    assert re.search(r"error +asked 10 %, estimated [0-9.]+ %\n", out)
    out = radiosity("solve", BOX, "--mesh", "2").stdout
    assert "asked 2 %, estimated" in out and "on the mesh of 24 patches asked for" in out
    out = radiosity("solve", BOX, "--time", "1s").stdout
    assert "asked for 1 s, estimated" in out


def test_what_cannot_be_reached_ends_with_exit_code_1(tmp_path):
    """Memory for some six hundred patches: what was reached is said, and saved."""
    out = tmp_path / "box.csv"
    args = "--accuracy", "0.003", "--memory", "40MB", "-o", str(out)
    process = radiosity("solve", CORNELL, *args)
    assert process.returncode == 1, process.stderr
    assert "reached an estimated error of" in process.stderr
    assert "allow more with --memory" in process.stderr
    assert out.exists()


def test_tradeoff_writes_a_table_and_a_plot(tmp_path):
    """As JSON; test_manual.py runs it in words."""
    process = radiosity(
        "tradeoff", BOX, "--accuracy", "0.1", "--size", "48x48", "--json", cwd=tmp_path
    )
    assert process.returncode == 0, process.stderr
    assert (tmp_path / "box6_tradeoff.png").stat().st_size > 5000
    told = json.loads(process.stdout)
    found = [Trial(**t) for t in told["trials"]]
    rows = [row(t) for t in found]
    for way in ("linear", "constant", "clusters", "cg, order 0", "everything forced"):
        assert any(r.startswith(way) for r in rows)
    best = found[0]
    assert best.way == "linear" and best.error < 0.1 and best.estimated < 0.1
    error = {p["way"]: p["error"] for p in told["pictures"]}
    assert error["gather"] < 0.02 < error["local"] < error["raytrace"]
    assert all((tmp_path / p["file"]).exists() for p in told["pictures"])
    picture = PictureTrial("local", 0.3, 0.2, Image(np.ones((2, 2, 3))))
    plot_tradeoff(found, "box", tmp_path / "t.svg", [picture])
    assert (tmp_path / "t.svg").read_text().startswith("<?xml")


def test_threads_change_nothing():
    one, two = (radiosity("probe", CORNELL, POINTS, "--accuracy", "0.2", "--threads", n).stdout
                for n in "12")  # fmt: skip
    assert one == two and len(one) > 1000


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["solve", "absent.toml"], ["absent.toml"]),
        (["solve", str(SCENES)], ["scenes"]),
        (["solve", CORNELL, "--accuracy", "7"], ["--accuracy 7 must", "[0.0001, 1)"]),
        (["solve", CORNELL, "--accuracy", "nan"], ["--accuracy nan"]),
        (["solve", CORNELL, "--accuracy", "two"], ["'two'"]),
        (["solve", CORNELL, "--mesh", "0"], ["--mesh '0'", "1 to 1024"]),
        (["solve", CORNELL, "--order", "2"], ["--order '2'", "0 (constant) or 1 (linear"]),
        (["solve", CORNELL, "--time", "soon"], ["--time 'soon'", "10s, 2min or 1h"]),
        (["solve", CORNELL, "--time", "1s", "--mesh", "4"], ["--mesh '4'", "use auto"]),
        (["solve", CORNELL, "--solver", "cg", "--order", "1"], ["'cg'", "use order 0, or gmres"]),
        (["plan", CORNELL, "--accuracy", "0"], ["--accuracy 0 must", "[0.0001, 1)"]),
        (["tradeoff", CORNELL, "--accuracy", "0.5"], ["--accuracy 0.5", "[0.001, 0.1]"]),
        (["tradeoff", CORNELL, "-o", "plot.txt"], ["plot.txt", ".png, .pdf or .svg"]),
        (["solve", CORNELL, "--mesh", "fine"], ["--mesh 'fine'", "auto, input"]),
        (["solve", CORNELL, "--solver", "magic"], ["'magic'", "gauss-seidel"]),
        (["solve", CORNELL, "--memory", "lots"], ["--memory 'lots'", "4GB"]),
        (["solve", CORNELL, "--ambient", "-1"], ["--ambient -1", "at least 0"]),
        (["solve", CORNELL, "-o", "out.xyz"], [".xyz", ".vtp"]),
        (["solve", CORNELL, "-o", "no/such/folder/out.csv"], ["does not exist"]),
        (["render", CORNELL], ["--output"]),
        (["render", CORNELL, "-o", "a.jpg"], [".jpg", ".png"]),
        (["render", CORNELL, "-o", "a.png", "--size", "0x9"], ["0x9", "WIDTHxHEIGHT"]),
        (["render", CORNELL, "-o", "a.png", "--camera", "nobody"], ["nobody", "front"]),
        (["render", CORNELL, "-o", "a.png", "--samples", "0"], ["0"]),
        (["probe", CORNELL, "absent.csv"], ["absent.csv"]),
        (["probe", CORNELL, CORNELL], ["line 1", "nx"]),
        (["verify", "--suite", "none"], ["'none'", "rooms"]),
        (["fly", CORNELL], ["fly"]),
        (["solve", CORNELL, "--colour"], ["--colour"]),
    ],
)
def test_wrong_input_ends_in_one_message(args, words, tmp_path):
    refused(radiosity(*args, cwd=tmp_path), *words)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["line 1", "missing"]),
        ("x,y,z,nx,ny,nz\n", ["no points"]),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0\n", ["line 2", "5 values"]),
        ("x,y,z,nx,ny,nz\n1,2,three,0,0,1\n", ["line 2", "z = 'three'"]),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,inf,3,0,0,1\n", ["line 3", "finite"]),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0,0\n", ["line 2", "direction"]),
    ],
)
def test_wrong_points_are_named_by_line(text, words):
    refused(radiosity("probe", FURNACE, "-", stdin=text), "stdin", *words)


def test_a_matrix_beyond_the_memory_is_refused_at_once():
    begun = time.perf_counter()
    process = radiosity("solve", CORNELL, "--memory", "1MB")
    refused(process, "patches need", "MB", "--memory", code=3)
    assert time.perf_counter() - begun < 30  # nothing was computed; a loaded machine starts slowly


def test_interrupt_leaves_nothing_half_written(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "radiosity", "render", CORNELL, "-o", "a.png", "--samples", "99999"],
        cwd=tmp_path, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    for line in process.stderr:
        if "solved" in line:
            break
    process.send_signal(signal.SIGINT)
    _, rest = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "interrupted" in rest and "Traceback" not in rest
    assert not list(tmp_path.iterdir())


def test_a_scene_that_emits_nothing_is_dark_and_says_how_to_light_it(tmp_path):
    scene = tmp_path / "dark.toml"
    scene.write_text(
        '[[geometry]]\nmaterial = "m"\npolygons = [[[0,0,0],[1,0,0],[1,1,0]]]\n'
        "[materials.m]\ndiffuse = 0.5\n"
    )
    process = radiosity("solve", str(scene))
    assert process.returncode == 0, process.stderr
    assert "--ambient 1" in process.stderr
    assert "emitted                0" in process.stdout
    lit = radiosity("solve", str(scene), "--ambient", "1")
    assert "escaped" in lit.stdout and "--ambient 1" not in lit.stderr


def test_points_that_cannot_be_meant_are_questioned(tmp_path):
    (tmp_path / "p.csv").write_text("x,y,z,nx,ny,nz\n1,1,1,0,0,1\n1000,1000,1000,0,0,1\n")
    done = radiosity("probe", BOX, "p.csv", "--accuracy", "0.1", cwd=tmp_path)
    assert done.returncode == 0
    assert "note: 1 of 2 points lie outside of the scene, which reaches from 0 to 4" in done.stderr
    (tmp_path / "p.csv").write_text("x;y;z;nx;ny;nz\n1;1;1;0;0;1\n")
    done = radiosity("probe", BOX, "p.csv", cwd=tmp_path)
    assert done.returncode == 2 and "with commas in between" in done.stderr
