"""The shipped scenes: those with a closed form meet it, and the Cornell box its reference."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import radiosity

SCENES = Path(__file__).resolve().parent.parent / "scenes"


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda p: p.stem)
def test_scene_loads_without_remarks(path):
    scene = radiosity.load(path)
    assert scene.notes == ()
    assert scene.cameras


@pytest.mark.parametrize("name", ["box6", "enclosure", "furnace", "sphere"])
def test_scene_meets_its_own_truth(name):
    path = SCENES / f"{name}.toml"
    mesh = str(radiosity.load(path).truth.mesh)
    scene = radiosity.load(path, merge=mesh != "input")
    solution = radiosity.solve(scene, mesh=mesh)
    assert solution.closed
    assert solution.truth_error() < scene.truth.relative_tolerance


def test_a_wrong_truth_is_seen():
    scene = radiosity.load(SCENES / "box6.toml")
    solution = radiosity.solve(scene, mesh="1")
    scene.truth.radiosity["floor"][:] *= 1.01
    assert solution.truth_error() == pytest.approx(0.01, rel=0.02)


def test_cornell_box_reproduction(tmp_path):
    picture = tmp_path / "box.png"
    done = subprocess.run(
        [sys.executable, str(SCENES / "cornell_box.py"), "--size", "64", "-o", str(picture)],
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "median error" in done.stdout


def test_cornell_box_reproduction_fails_where_it_is_too_coarse(tmp_path):
    done = subprocess.run(
        [sys.executable, str(SCENES / "cornell_box.py"), "--size", "64", "--samples", "8",
         "--accuracy", "0.5", "-o", str(tmp_path / "box.png")],
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == 1, done.stdout


def test_blocks_cut_the_floor_and_what_they_cover_stays_dark():
    solution = radiosity.solve(radiosity.load(SCENES / "cornell_box.toml"), 0.1)
    dark = ~solution.live & solution.patches.front
    area = solution.patches.area[dark].sum()

    def footprint(corners):
        x, z = np.array(corners, float).T
        return 0.5 * abs(x @ np.roll(z, -1) - z @ np.roll(x, -1))

    short = [[130, 65], [82, 225], [240, 272], [290, 114]]
    tall = [[423, 247], [265, 296], [314, 456], [472, 406]]
    assert area == pytest.approx(footprint(short) + footprint(tall), rel=1e-9)
    assert not solution.radiosity[dark].any()
    assert len(solution.patches) == solution.patches.fronts  # no back is lit


def test_cornell_box_balances_its_power():
    solution = radiosity.solve(radiosity.load(SCENES / "cornell_box.toml"), 0.05)
    lamp = np.array([17, 12, 4]) * np.pi * 0.130 * 0.105  # W from radiance and area in m2
    np.testing.assert_allclose(solution.balance.emitted, lamp, rtol=1e-12)
    assert solution.balance.defect < 0.005  # escaped power is measured with rays of its own
