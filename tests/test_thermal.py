"""Net heat between grey surfaces, by view factors and as a scene, against closed forms."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

import radiosity
from radiosity.analytic import parallel_rectangles

SCENE = Path(__file__).resolve().parent.parent / "scenes" / "enclosure.toml"
SIGMA = 5.670374419e-8  # W/(m2 K4)
HOT, COLD = 800.0, 400.0  # K
EPS_HOT, EPS_COLD = 0.8, 0.5


@pytest.fixture(scope="module")
def fine():
    return by_scene("auto")


def by_factors(mesh, T, eps):
    """Return (n,) W that leave the faces of a mesh: (I - (1 - eps) F) J = eps sigma T^4."""
    F = radiosity.form_factors(mesh, accuracy=0.01)
    emitted = eps * SIGMA * T**4
    J = np.linalg.solve(np.eye(len(T)) - (1 - eps)[:, None] * F.toarray(), emitted)
    return F.area * (J - F @ J), F


def by_scene(mesh, accuracy=0.02):
    """Return W by material of the scene, and its solution."""
    scene = radiosity.load(SCENE, bands="grey")
    solution = radiosity.solve(scene, accuracy, mesh=mesh)
    heat = solution.patches.area * (solution.radiosity - solution.irradiance_on)[:, 0]
    material = scene.faces.material[solution.patches.face]
    return {m.name: heat[material == k].sum() for k, m in enumerate(scene.materials)}, solution


def network():
    """Return W between the plates of the scene, each of its surfaces taken as uniform."""
    straight = parallel_rectangles(1.0, 1.0, 1.0)
    space = 1.0 / (straight + 1.0 / (2.0 / (1.0 - straight)))
    surfaces = (1 - EPS_HOT) / EPS_HOT + (1 - EPS_COLD) / EPS_COLD
    return SIGMA * (HOT**4 - COLD**4) / (surfaces + space)


def test_concentric_spheres():
    inner = trimesh.creation.icosphere(subdivisions=1, radius=0.5)
    outer = trimesh.creation.icosphere(subdivisions=1, radius=1.0)
    outer.invert()
    hot = np.arange(160) < 80
    T, eps = np.where(hot, HOT, COLD), np.where(hot, EPS_HOT, EPS_COLD)
    heat, F = by_factors(inner + outer, T, eps)
    ratio = F.area[hot].sum() / F.area[~hot].sum()
    flux = SIGMA * (HOT**4 - COLD**4) / (1 / EPS_HOT + ratio * (1 / EPS_COLD - 1))
    expected = flux * F.area[hot].sum()
    assert heat[hot].sum() == pytest.approx(expected, rel=1e-5)  # faces are uniform to 2e-6
    assert abs(heat.sum()) < 1e-12 * expected


def test_uniform_surfaces_are_the_network_of_the_textbooks():
    heat, solution = by_scene("1")
    assert heat["hot"] == pytest.approx(network(), rel=1e-9)
    assert heat["cold"] == pytest.approx(-network(), rel=1e-9)
    assert abs(heat["walls"]) < 1e-9 * network(), "they reradiate"
    assert len(solution.patches) == 6


def test_both_ways_agree_on_fine_meshes(fine):
    room = trimesh.creation.box()
    room.invert()
    room = room.subdivide().subdivide()
    z = room.triangles_center[:, 2]
    floor, ceiling = z < -0.499, z > 0.499
    eps = np.where(floor, EPS_HOT, np.where(ceiling, EPS_COLD, 0.0))
    heat, _ = by_factors(room, np.where(floor, HOT, COLD), eps)
    scene, solution = fine
    # 192 constant triangles are off by 0.4 % (768: by 0.06 %)
    assert heat[floor].sum() == pytest.approx(scene["hot"], rel=0.006)
    assert scene["hot"] == pytest.approx(-scene["cold"], rel=0.002)
    assert scene["hot"] < 0.95 * network(), "uniform walls pass too much on"
    assert solution.estimate.reached < 0.02


def test_the_script_prints_the_same_heat_and_draws(tmp_path, fine):
    picture = tmp_path / "enclosure.png"
    done = subprocess.run(
        [sys.executable, str(SCENE.with_name("enclosure.py")), "--size", "24", "-o", str(picture)],
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    lines = re.findall(r"(\w+) +(-?[0-9.]+) W net", done.stdout)
    found = {name: float(heat) for name, heat in lines}
    assert found == pytest.approx(fine[0], abs=0.06)  # printed to 0.1 W
    assert picture.read_bytes().startswith(b"\x89PNG")
