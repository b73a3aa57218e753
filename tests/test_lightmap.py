"""Lightmaps: what points of the model look up is what they receive, and nothing bleeds."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from glb_for_tests import Glb, validated
from scenes_for_tests import block, box, faces_of, scene, uv_sphere

from radiosity.light.photometry import luminance
from radiosity.scene.files import load
from radiosity.solve.solve import solve
from radiosity.view.atlas import packed
from radiosity.view.export import check_suffix, save
from radiosity.view.lightmap import make_lightmap
from radiosity.view.unwrap import unwrap

SCENES = Path(__file__).resolve().parent.parent / "scenes"


def looked_up(picture, uv):
    """Return what uv (k, 2) get of a picture as a graphics card filters it, bilinearly."""
    n = len(picture)
    x, y = np.clip(uv * n - 0.5, 0, n - 1 - 1e-9).T
    i, j = y.astype(int), x.astype(int)
    a, b = (x - j)[:, None], (y - i)[:, None]
    upper = (1 - a) * picture[i, j] + a * picture[i, j + 1]
    return (1 - b) * upper + b * ((1 - a) * picture[i + 1, j] + a * picture[i + 1, j + 1])


def scattered(corners, uv, count):
    """Return random points (k, 3), their uv and normals, evenly over triangles (t, 3, 3)."""
    rng = np.random.default_rng(0)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    t = rng.choice(len(corners), count, p=area / area.sum())
    w = rng.dirichlet(np.ones(3), count)
    points, places = (np.einsum("kv,kvc->kc", w, x[t]) for x in (corners, uv))
    return points, places, cross[t] / area[t, None]


def read_exr(path):
    with OpenEXR.File(str(path)) as file:
        return file.channels()["RGB"].pixels.astype(float)


@pytest.fixture(scope="module")
def box_of_blocks(tmp_path_factory):
    """The Cornell box and the folder with its model of 96 x 96 texels."""
    solution = solve(load(SCENES / "cornell_box.toml"), accuracy=0.05)
    folder = tmp_path_factory.mktemp("lightmap")
    save(solution, folder / "box.glb", lightmap=96)
    return solution, folder


def test_looked_up_light_agrees_with_gathered_light(box_of_blocks):
    solution, folder = box_of_blocks
    glb, exr = Glb(folder / "box.glb"), read_exr(folder / "box-lightmap.exr")
    corners = glb.triangles("POSITION") / solution.scene.unit_m  # the scene has y up as well
    points, uv, normals = scattered(corners, glb.triangles("TEXCOORD_1"), 500)
    found = luminance(looked_up(exr, uv))
    expected = luminance(solution.irradiance(points, normals)[0])
    open_to_light = expected > 0  # not beneath the blocks
    assert open_to_light.sum() > 450
    area = solution.patches.area[solution.live, None]
    mean = luminance((solution.irradiance_on[solution.live] * area).sum(axis=0) / area.sum())
    error = np.abs(found - expected) / np.maximum(expected, 0.1 * mean)
    # Measured 2.5 % for 96 x 96 texels, 1.4 % for 128 x 128 and 0.1 % for 512 x 512.
    assert np.percentile(error[open_to_light], 95) < 0.05


def test_the_files_belong_together(box_of_blocks):
    solution, folder = box_of_blocks
    assert sorted(p.name for p in folder.iterdir()) == [
        "box-lightmap.exr", "box-lightmap.png", "box.glb"]  # fmt: skip
    glb = Glb(folder / "box.glb")
    image = glb.tree["images"][0]
    assert glb.view(image["bufferView"]) == (folder / "box-lightmap.png").read_bytes()
    for material in glb.tree["materials"]:
        shown = material["pbrMetallicRoughness"]["baseColorTexture"]
        assert shown == {"index": 0, "texCoord": 1} and "KHR_materials_unlit" in str(material)
    assert glb.tree["scenes"][0]["extras"]["lightmap"] == "box-lightmap.exr"
    names = [m["name"] for m in glb.tree["meshes"]]
    assert set(names) == set(solution.scene.groups)


def test_the_validator_finds_nothing(box_of_blocks):
    assert validated(box_of_blocks[1] / "box.glb") == (0, 0)


def test_a_furnace_is_even_and_its_picture_is_what_it_looks_like(tmp_path):
    """E = M_e/(1 - rho) everywhere, so no texel may differ, not even between charts."""
    polygons = box((0, 0, 0), (1, 2, 3))
    made = scene(polygons, 0.5, [[1.0, 2.0, 0.5]] * 6, unit="cm", unit_m=0.01)
    solution = solve(made, accuracy=0.1)
    found = make_lightmap(solution, 32)
    expected = np.broadcast_to([2.0, 4.0, 1.0], found.irradiance.shape)
    assert found.irradiance == pytest.approx(expected, rel=1e-4)  # of the exact factors' closure
    shown = np.minimum(found.exposure * expected / np.pi, 1.0)
    assert found.colours == pytest.approx(shown, rel=1e-2)  # the solver's tolerance
    assert found.colours.max() < 1.0


def test_nothing_leaks_under_a_block():
    """Floor beneath a block is dark; texels there must not darken the floor beside it."""
    polygons = np.concatenate([box((0, 0, 0), (4, 4, 3)), block((1, 1, 0), (3, 3, 1))])
    exitance = np.zeros((len(polygons), 3))
    exitance[1] = 1.0
    solution = solve(scene(polygons, 0.5, exitance), accuracy=0.1)
    found = make_lightmap(solution, 64)
    floor = found.face[found.layout.polygon] == 0
    points, uv, _ = scattered(found.layout.corners[floor], found.layout.uv[floor], 2000)
    e = looked_up(found.irradiance.astype(float), uv)[:, 0]
    away = np.abs(points[:, :2] - 2.0).max(axis=1)
    near = (away > 1.0) & (away < 1.1)  # nearer than a texel
    assert near.sum() > 50
    lit = solution.irradiance(points[near], np.tile([0.0, 0, 1], (near.sum(), 1)))[0][:, 0]
    assert np.all(e[near] > 0.8 * lit)
    assert 6 not in found.face  # the underside of the block


def test_both_lit_sides_of_a_sheet_have_texels_and_inside_out_rooms_are_lit():
    sheet = np.array([[[1, 1, 1], [2, 1, 1], [2, 2, 1], [1, 2, 1]]], float)
    polygons = np.concatenate([box((0, 0, 0), (3, 3, 3)), sheet])
    exitance = np.zeros((7, 3))
    exitance[1] = 1.0
    found = make_lightmap(solve(scene(polygons, 0.5, exitance), accuracy=0.2), 32)
    assert np.sum(found.face == 6) == 2
    polygons[0] = polygons[0][::-1]  # the floor's front looks outside
    found = make_lightmap(solve(scene(polygons, 0.5, exitance), accuracy=0.2), 32)
    assert found.face.tolist().count(0) == 1
    floor = found.layout.corners[found.face[found.layout.polygon] == 0]
    assert np.cross(floor[0, 1] - floor[0, 0], floor[0, 2] - floor[0, 0])[2] > 0


def test_wavelengths_become_linear_rgb():
    made = load(SCENES / "cornell_box_spectral.toml", bands="8")
    solution = solve(made, accuracy=0.3)
    found = make_lightmap(solution, 48)
    texel, side, points = found.layout.texels()
    some = np.arange(0, len(texel), 29)
    normals = made.faces.normals()[found.face[side[some]]]
    e = np.maximum(solution.level.gathered(points[some], normals).total, 0.0)
    lit = e.any(axis=1)
    rgb = found.irradiance.reshape(-1, 3)[texel[some]][lit]
    assert rgb == pytest.approx(made.bands.to_rgb(e[lit]), rel=1e-5, abs=1e-5)


def test_charts_keep_the_scale_and_do_not_meet():
    """A sphere is cut, a box falls apart: texels of different smooth surfaces never touch."""
    polygons = np.concatenate([box((2, 0, 0), (3, 1, 1)), uv_sphere(6)])
    normals = faces_of(polygons).normals()
    layout = unwrap(polygons, normals, np.zeros(len(polygons), int), 128)
    assert layout.uv.min() >= 0 and layout.uv.max() <= 1
    flat, solid = (0.5 * np.abs(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]))
                   for x in (np.pad(layout.uv, [(0, 0), (0, 0), (0, 1)]), layout.corners))
    ratio = np.linalg.norm(flat, axis=1) / np.linalg.norm(solid, axis=1)
    assert ratio.min() > 0.4 * ratio.max()
    texel, polygon, points = layout.texels()
    owner = np.full(128 * 128, -1)
    owner[texel] = np.where(polygon < 6, polygon, 6)  # the sphere is one surface
    owner = owner.reshape(128, 128)
    for one, two in ((owner[1:], owner[:-1]), (owner[:, 1:], owner[:, :-1])):
        assert not np.any((one != two) & (one >= 0) & (two >= 0))
    assert np.unique(polygon).tolist() == list(range(len(polygons)))
    away = np.abs(np.einsum("kc,kc->k", points - polygons[polygon, 0], normals[polygon]))
    assert away.max() < 1e-6


def test_other_materials_and_creases_are_other_charts():
    """Squares side by side, and with a fold of 45 degrees."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    folded = np.array([[1, 0, 0], [1.7, 0, 0.7], [1.7, 1, 0.7], [1, 1, 0]])
    for other, kind in ((square + [1, 0, 0], [0, 1]), (folded, [0, 0])):
        polygons = np.stack([square, other])
        layout = unwrap(polygons, faces_of(polygons).normals(), np.array(kind), 64)
        gap = np.abs(layout.uv[layout.polygon == 0].reshape(-1, 1, 2)
                     - layout.uv[layout.polygon == 1].reshape(1, -1, 2)).max(axis=2)  # fmt: skip
        assert gap.min() * 64 >= 4  # they share two corners in space


def test_layouts_do_not_depend_on_the_unit_or_chance():
    polygons = uv_sphere(5)
    normals, kind = faces_of(polygons).normals(), np.zeros(len(polygons), int)
    layouts = [unwrap(s * polygons, normals, kind, 64) for s in (1, 1, 2.0**-20)]
    assert all(np.array_equal(layouts[0].uv, x.uv) for x in layouts[1:])


@pytest.mark.parametrize(
    ("name", "size", "words"),
    [
        ("a.vtp", 64, "lightmap = 64 is for .glb"),
        ("a.glb", 8, "whole number from 16 to 4096"),
        ("a.glb", 5000, "whole number from 16 to 4096"),
        ("a.glb", 64.5, "whole number from 16 to 4096"),
    ],
)
def test_wrong_lightmaps_are_refused_before_the_work(name, size, words):
    with pytest.raises(ValueError, match=words):
        check_suffix(name, size)


def test_too_few_texels_are_refused(tmp_path):
    polygons = np.concatenate([box((x, 0, 0), (x + 1, 1, 1)) for x in range(0, 60, 2)])
    with pytest.raises(ValueError, match="cannot hold the 180 parts"):
        unwrap(polygons, faces_of(polygons).normals(), np.arange(len(polygons)), 16)


def test_a_failed_lightmap_leaves_the_old_files(tmp_path):
    solution = solve(scene(box((0, 0, 0), (1, 1, 1)), 0.5, 1.0), accuracy=0.3)
    (tmp_path / "a.glb").write_text("old")
    (tmp_path / "a-lightmap.png").mkdir()
    with pytest.raises(OSError, match="folder"):
        save(solution, tmp_path / "a.glb", lightmap=16)
    assert (tmp_path / "a.glb").read_text() == "old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a-lightmap.png", "a.glb"]


def solve_cli(*args):
    return subprocess.run([sys.executable, "-m", "radiosity", "solve", *map(str, args)],
                          capture_output=True, text=True)  # fmt: skip


def test_solve_writes_all_three(tmp_path):
    done = solve_cli(SCENES / "box6.toml", "--mesh", "1", "-o", tmp_path / "a.glb",
                     "--lightmap", "32")  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a-lightmap.exr", "a-lightmap.png",
                                                          "a.glb"]  # fmt: skip
    assert read_exr(tmp_path / "a-lightmap.exr").shape == (32, 32, 3)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--lightmap", "64"], "--lightmap 64 needs a file to write: add -o OUT.glb"),
        (["-o", "a.csv", "--lightmap", "64"], "--lightmap 64 is for .glb"),
    ],
)
def test_wrong_use_is_told_before_the_work(args, words):
    done = solve_cli(SCENES / "box6.toml", *args)
    assert done.returncode == 2 and words in done.stderr and "solved" not in done.stderr


def test_threads_do_not_change_a_texel(monkeypatch):
    solution = solve(load(SCENES / "cornell_box.toml"), accuracy=0.3)
    found = []
    for threads in "12":
        monkeypatch.setenv("RADIOSITY_THREADS", threads)
        found.append(make_lightmap(solution, 48).irradiance)
    assert np.array_equal(*found)


def test_what_comes_through_is_seen():
    """A translucent sheet: what comes through is seen in the picture."""
    sheet = np.array([[[0.5, 0.5, 1], [2.5, 0.5, 1], [2.5, 2.5, 1], [0.5, 2.5, 1]]], float)
    polygons = np.concatenate([box((0, 0, 0), (3, 3, 3)), sheet])
    exitance = np.zeros((7, 3))
    exitance[1] = 1.0
    made = scene(polygons, [0.5] * 6 + [0.0], exitance)
    paper = replace(made.materials[6], translucent=np.full(3, 0.2))
    solution = solve(replace(made, materials=(*made.materials[:6], paper)), accuracy=0.2)
    found = make_lightmap(solution, 32)
    texel, side, _ = found.layout.texels()
    below = np.flatnonzero(found.face == 6)[1]  # fronts come first
    shown = found.colours.reshape(-1, 3)[texel[side == below]]
    backs = (solution.patches.face == 6) & ~solution.patches.front
    expected = found.exposure * solution.radiosity[backs].mean(axis=0) / np.pi
    assert shown.mean(axis=0) == pytest.approx(expected, rel=0.05)  # it reflects nothing itself


def test_a_crash_of_xatlas_is_told_and_takes_nothing_along(monkeypatch):
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), np.array([[0, 1, 2]], "u4")
    uv, charts = packed([square], 64, 4)
    assert uv.shape == (1, 3, 2) and charts == 1
    monkeypatch.setattr("sys.executable", "false")
    with pytest.raises(ValueError, match="xatlas, which lays the surfaces out, failed 4 times"):
        packed([square], 64, 4)


def test_a_place_where_no_lightmap_can_be_written_is_refused_before_solving(tmp_path):
    (tmp_path / "out-lightmap.exr").mkdir()
    scenes = Path(__file__).resolve().parent.parent / "scenes"
    args = ["solve", scenes / "box6.toml", "-o", tmp_path / "out.glb", "--lightmap", "64"]
    done = subprocess.run([sys.executable, "-m", "radiosity", *map(str, args)],
                          capture_output=True, text=True)  # fmt: skip
    assert done.returncode != 0 and "cannot write a file over a folder" in done.stderr
    assert "patches" not in done.stdout and not (tmp_path / "out.glb").exists()
