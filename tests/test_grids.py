"""Grids on planes and surfaces: where points lie, and light that is known in closed form."""

import csv
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import block, box, l_room, scene, uv_sphere

from radiosity.analytic import point_to_parallel_rectangle
from radiosity.light.photometry import illuminance
from radiosity.light.sources import Point
from radiosity.solve.solve import solve
from radiosity.view.pointgrid import evenness, standard_spacing
from radiosity.view.surfacegrid import surface_grid
from radiosity.view.workplane import plane_grid

SCENES = Path(__file__).resolve().parent.parent / "scenes"
CEILING = 1


def glowing(polygons, face=CEILING, **more):
    """A room one of whose faces shines."""
    exitance = np.zeros((len(polygons), 3))
    exitance[face] = 1.0
    return solve(scene(polygons, 0.5, exitance, **more), accuracy=0.2)


def measured(solution, grid):
    found, error = solution.irradiance(grid.points, grid.normals)
    lux = (illuminance(x, solution.scene.bands) for x in (found, error))
    return evenness(*lux)


def test_a_point_light_over_a_plane():
    """E = I h/d^3, in a black box: mean, extremes and uniformity by the inverse square law."""
    light = Point(np.array([2.0, 3.0, 2.5]), np.full(3, 10.0))
    made = scene(box((0, 0, 0), (6, 5, 3)), 0.0, lights=(light,))
    solution = solve(made, accuracy=0.1)
    grid = plane_grid(solution, 0.8, spacing=0.5)
    x, y = (np.arange(0.75 - 0.25, n - 0.5, 0.5) + 0.25 for n in (6, 5))
    x, y = x[x < 5.5], y[y < 4.5]
    d2 = (x[:, None] - 2) ** 2 + (y - 3) ** 2 + 1.7**2
    expected = 683 * 10 * 1.7 / d2.ravel() ** 1.5
    assert len(grid.points) == 10 * 8 and grid.left_out == 0 and grid.spacing == (0.5, 0.5)
    assert grid.margin == 0.5 and np.all(grid.points[:, 2] == 0.8)
    found = measured(solution, grid)
    assert found.mean == pytest.approx(expected.mean(), rel=1e-9)
    assert found.minimum == pytest.approx(expected.min(), rel=1e-9)
    assert found.maximum == pytest.approx(expected.max(), rel=1e-9)
    assert found.u0 == pytest.approx(expected.min() / expected.mean(), rel=1e-9)
    assert found.ud == pytest.approx(expected.min() / expected.max(), rel=1e-9)


def test_a_square_light_over_a_plane():
    """E = M F, F the factor from a point to four rectangles with a corner above it."""
    lamp = np.array([[[1.5, 1.5, 2.9], [1.5, 2.5, 2.9], [2.5, 2.5, 2.9], [2.5, 1.5, 2.9]]])
    exitance = np.zeros((7, 3))
    exitance[6] = 20.0
    made = scene(np.concatenate([box((0, 0, 0), (4, 4, 3)), lamp]), 0.0, exitance)
    solution = solve(made, accuracy=0.1)
    grid = plane_grid(solution, 0.9, spacing=1.0)
    assert len(grid.points) == 9
    found = solution.irradiance(grid.points, grid.normals)[0][:, 0]
    expected = [
        20.0 * sum(i * j * corner_factor(a - x, b - y)
                   for a, i in ((2.5, 1), (1.5, -1)) for b, j in ((2.5, 1), (1.5, -1)))
        for x, y, _ in grid.points
    ]  # fmt: skip
    assert found == pytest.approx(np.array(expected), rel=1e-3)  # 0.1 asked, 2.4e-4 measured


def corner_factor(a, b):
    """The factor of a rectangle 2 m above that reaches from over the point to (a, b), signed."""
    if a == 0 or b == 0:
        return 0.0
    return np.sign(a * b) * point_to_parallel_rectangle(abs(a), abs(b), 2.0)


def test_a_furnace_is_even():
    solution = solve(scene(box((0, 0, 0), (4, 3, 2.5)), 0.5, 1.0), accuracy=0.1)
    for grid in (plane_grid(solution, 0.75), surface_grid(solution, "all")):
        found = measured(solution, grid)
        assert found.mean == pytest.approx(683 * 2.0, rel=1e-4)
        assert found.u0 == pytest.approx(1.0, abs=1e-4) and found.ud <= found.u0 <= 1.0


def test_spacing_is_the_standards():
    """The table that Fagerhult gives with the formula."""
    table = {0.4: 0.1054, 1: 0.2, 2: 0.3247, 5: 0.6158, 10: 1.0, 25: 1.896, 50: 3.079, 100: 5.0}
    for length, p in table.items():
        assert standard_spacing(np.array([length, length])) == pytest.approx(p, rel=1e-3)
    assert standard_spacing(np.array([1e3, 1e3])) == 10.0
    solution = glowing(box((0, 0, 0), (11, 6, 3)))
    grid = plane_grid(solution, 0.75)  # 10 m x 5 m within the margin: d = 5 m, 9 cells
    assert grid.spacing == pytest.approx((10 / 18, 5 / 9)) and len(grid.points) == 18 * 9


def test_only_rooms_count_and_margins_keep_off_walls():
    """Half of the floor shines, up against the block's underside too."""
    solution = glowing(np.concatenate([l_room(), block((0.2, 2.2, 0), (0.6, 2.6, 1))]))
    grid = plane_grid(solution, 0.5, spacing=0.1, margin=0.0)
    x, y = grid.points[:, :2].T
    inside = (x < 1) | (y < 1)
    in_block = (x > 0.2) & (x < 0.6) & (y > 2.2) & (y < 2.6)
    assert inside.all() and not in_block.any()
    assert len(x) == 500 - 16 and grid.left_out == 900 - 484  # cells of 0.01 m2 in 5 m2
    kept = plane_grid(solution, 0.5, spacing=0.05, margin=0.3)
    x, y = kept.points[:, :2].T
    off = np.hypot(np.maximum(np.maximum(0.2 - x, x - 0.6), 0),
                   np.maximum(np.maximum(2.2 - y, y - 2.6), 0))  # fmt: skip
    corner = np.hypot(np.maximum(1 - x, 0), np.maximum(1 - y, 0))  # of the walls, at (1, 1)
    assert min(x.min(), y.min(), 3 - x.max(), 3 - y.max()) >= 0.3 and off.min() >= 0.3
    assert corner.min() >= 0.3 and corner.min() < 0.36  # rounded by that corner, no more
    shining = surface_grid(solution, "m1", spacing=0.1)  # light under the block is none
    assert len(shining.points) == 200 - 16
    floor = surface_grid(solution, "all", spacing=0.05, margin=0.3).points
    x, y = floor[floor[:, 2] == 0, :2].T
    corner = np.hypot(np.maximum(1 - x, 0), np.maximum(1 - y, 0))
    assert 0.295 < corner.min() < 0.36 and x.max() > 2.6 and y.max() > 2.6
    above = plane_grid(solution, 1.5, spacing=0.1, margin=0.0)
    assert len(above.points) == 500  # over the block


def test_what_ends_below_the_plane_is_no_wall():
    desk = block((1, 1, 0), (3, 2, 0.7))
    solution = glowing(np.concatenate([box((0, 0, 0), (4, 4, 3)), desk]))
    on_it = plane_grid(solution, 0.7, spacing=0.5, margin=0.5)
    assert len(on_it.points) == 36 and on_it.left_out == 0
    floor = plane_grid(solution, 0.0, spacing=0.25, margin=0.25)
    x, y = floor.points[:, :2].T
    assert not np.any((x > 0.75) & (x < 3.25) & (y > 0.75) & (y < 2.25))


@pytest.mark.parametrize("up", "xyz")
def test_the_plane_lies_across_up(up):
    turn = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[up]
    solution = glowing(box((0, 0, 0), (4, 5, 3))[..., turn], up=up)
    grid = plane_grid(solution, 0.75, spacing=1.0)
    k = "xyz".index(up)
    assert np.all(grid.points[:, k] == 0.75) and np.all(grid.normals == np.eye(3)[k])
    assert len(grid.points) == 3 * 4


def test_units_change_nothing_but_the_numbers():
    metres = plane_grid(glowing(box((0, 0, 0), (4, 5, 3))), 0.75)
    solution = glowing(box((0, 0, 0), (400, 500, 300)), unit="cm", unit_m=0.01)
    grid = plane_grid(solution, 75)
    assert grid.points == pytest.approx(100 * metres.points) and grid.margin == 50


def test_a_small_room_has_a_smaller_margin():
    assert plane_grid(glowing(box((0, 0, 0), (2, 1, 1))), 0.5).margin == pytest.approx(0.15)


def test_surfaces_are_covered_but_for_what_stands_on_them():
    polygons = np.concatenate([box((0, 0, 0), (4, 4, 3)), block((1, 1, 0), (2, 2, 1))])
    solution = glowing(polygons)
    floor = surface_grid(solution, "m0", spacing=0.25)
    assert len(floor.points) == 256 - 16 and floor.left_out == 16
    assert np.all(floor.points[:, 2] == 0) and np.all(floor.normals == [0, 0, 1])
    inner = surface_grid(solution, "m0", spacing=0.25, margin=0.5)
    assert inner.points[:, :2].min() > 0.5 and len(inner.points) == 144 - 16
    walls = surface_grid(solution, "all", spacing=0.5)
    area = 2 * 16 + 4 * 12 - 1 + 5
    assert len(walls.points) == area * 4
    assert len(np.unique(walls.normals, axis=0)) == 6


def test_surfaces_of_many_small_faces_have_points_on_each_and_look_where_light_is():
    solution = glowing(uv_sphere(4))  # seen from inside
    grid = surface_grid(solution, "all", spacing=5.0)
    assert len(grid.points) == 32
    assert np.einsum("kc,kc->k", grid.points, grid.normals).max() < 0
    small = box((0, 0, 0), (0.1, 0.1, 0.1))[:1] + [[[1, 1, 1]], [[2, 2, 1]]]
    apart = np.concatenate([box((0, 0, 0), (3, 3, 3)), small])
    made = scene(apart, 0.5, [[float(k == CEILING)] * 3 for k in range(8)])
    pair = replace(made.faces, group=(np.arange(8) > 5).astype(int))
    solution = solve(replace(made, faces=pair, groups=("room", "pair")), accuracy=0.2)
    grid = surface_grid(solution, "pair", spacing=5.0)  # its middle lies on neither of them
    assert grid.points == pytest.approx(np.array([[1.05, 1.05, 1.0]])) and grid.left_out == 0
    inside_out = box((0, 0, 0), (2, 2, 2))
    inside_out[0] = inside_out[0][::-1]
    grid = surface_grid(glowing(inside_out), "m0")
    assert np.all(grid.normals == [0, 0, 1])


def test_errors_of_ratios_are_of_first_order():
    lux, error = np.array([100.0, 250.0, 400.0]), np.array([1.0, 2.0, 6.0])
    found, step = evenness(lux, error), 1e-6
    worse = evenness(lux + step * error * [1, -1, -1], error)
    assert (worse.ud - found.ud) / step == pytest.approx(found.ud_error, rel=1e-4)
    mean = found.mean - step * error.mean()
    assert ((100 + step) / mean - found.u0) / step == pytest.approx(found.u0_error, rel=1e-4)
    dark = evenness(np.zeros(3), np.zeros(3))
    assert dark.mean == 0 and np.isnan(dark.u0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda s: plane_grid(s, 3.5), "height 3.5 must lie within the scene, from z = 0 to 3 m"),
        (lambda s: plane_grid(s, float("nan")), "height nan must lie"),
        (lambda s: plane_grid(s, 1, margin=2), "margin = 2 must be less than half .* 4 m"),
        (lambda s: plane_grid(s, 1, margin=-1), "margin = -1 must be at least 0 m"),
        (lambda s: plane_grid(s, 1, spacing=0), "spacing = 0 must be above 0 m"),
        (lambda s: plane_grid(s, 1, spacing=1e-4), "9e.08 points is above 1000000"),
        (lambda s: surface_grid(s, "m0", spacing=1e-4), "points is above 1000000"),
        (lambda s: surface_grid(s, "moon"), "'moon': the scene has 'all', 'm0', 'm1'"),
        (lambda s: surface_grid(s, "m6"), "none of its points is lit"),
    ],
)
def test_impossible_grids_are_refused(make, words):
    """m6 lies outside of the room, where no light is."""
    polygons = np.concatenate([box((0, 0, 0), (4, 4, 3)), [[[0, 0, -1], [1, 0, -1], [1, 1, -1],
                                                           [0, 1, -1]]]])  # fmt: skip
    with pytest.raises(ValueError, match=words):
        make(glowing(polygons if "m6" in words or words.startswith("none") else polygons[:6]))


def run(*args):
    return subprocess.run([sys.executable, "-m", "radiosity", "probe", *map(str, args)],
                          capture_output=True, text=True)  # fmt: skip


def test_probe_prints_the_table_and_what_it_comes_to(tmp_path):
    lroom = SCENES / "lroom.toml"
    done = run(lroom, "--grid", "0.75", "--accuracy", "0.1", "--quiet", "-o", tmp_path / "a.csv")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "a.csv").open()))
    lux = np.array([float(r["illuminance"]) for r in rows])
    told = {line[:12].strip(): line[12:].split() for line in done.stdout.splitlines()}
    assert len(rows) == 32 and done.stdout.startswith("points    32 in cells of 0.5556 x 0.5556 m")
    for name, value in {"mean": lux.mean(), "minimum": lux.min(), "maximum": lux.max(),
                        "U0 min/mean": lux.min() / lux.mean()}.items():  # fmt: skip
        assert float(told[name][0]) == pytest.approx(value, rel=1e-4)
    done = run(lroom, "--grid", "floor", "--accuracy", "0.1", "--json", "--spacing", "1")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    lux = [p["illuminance"] for p in answer["points"]]
    assert answer["grid"]["points"] == len(lux) == 20
    assert answer["illuminance_lx"]["mean"] == pytest.approx(np.mean(lux), rel=1e-6)
    assert 0 < answer["estimated_error"] <= answer["accuracy"] == 0.1


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ([], "POINTS.csv is missing: give a file (- for stdin), or --grid HEIGHT"),
        (["a.csv", "--grid", "1"], "POINTS 'a.csv' and --grid 1 exclude each other"),
        (["a.csv", "--margin", "1"], "--margin is for --grid"),
        (["--grid", "9"], "height 9 must lie within the scene, from z = 0 to 2.6 m"),
        (["--grid", "flor"], "no face group or material is called 'flor': did you mean 'floor'?"),
    ],
)
def test_wrong_use_of_probe_is_told_before_the_work(args, words):
    done = run(SCENES / "lroom.toml", *args)
    assert done.returncode == 2 and words in done.stderr and "solved" not in done.stderr
    assert "Traceback" not in done.stderr


def two_rooms(*strengths):
    """Two closed rooms side by side, a point light in each, and a block and a hood in the first."""
    rooms = np.concatenate([box((0, 0, 0), (2, 2, 2)), box((3, 0, 0), (5, 2, 2))])
    hood = block((1.4, 1.4, 0), (1.8, 1.8, 1), bottom=False)
    solids = [block((0.2, 0.2, 0), (0.6, 0.6, 1)), hood]
    lights = tuple(
        Point(np.array([x, 1.0, 1.8]), np.full(3, 10.0 * strength))
        for x, strength in zip((1, 4), strengths, strict=False)
    )
    return solve(scene(np.concatenate([rooms, *solids]), 0.5, lights=lights), accuracy=0.2)


@pytest.mark.parametrize("strengths", [(1, 1), (1, 0), (0, 0), ()])
def test_points_of_dark_rooms_count_and_those_inside_of_bodies_do_not(strengths):
    """A hood, a block without a bottom, has the floor's front below it all the same."""
    solution = two_rooms(*strengths)
    grid = plane_grid(solution, 0.8, spacing=0.2, margin=0.0)
    x, y = grid.points[:, :2].T
    assert len(x) == 2 * 100 - 2 * 4 and not np.any((x > 2) & (x < 3))
    for low in (0.2, 1.4):
        assert not np.any((np.abs(x - low - 0.2) < 0.2) & (np.abs(y - low - 0.2) < 0.2))
    found = measured(solution, grid)
    if strengths == (1, 0):
        assert found.minimum == 0 and found.u0 == 0 and found.mean > 0
    if not any(strengths):
        assert found.maximum == 0 and np.isnan(found.u0) and np.isnan(found.ud_error)


@pytest.mark.parametrize("strength", [0.0, 1.0])
def test_a_room_turned_inside_out_has_points_where_no_light_is(strength):
    polygons = np.concatenate([box((0, 0, 0), (2, 2, 2))[:, ::-1], block((0, 0, 0), (1, 1, 1))])
    light = Point(np.array([1.5, 1.5, 1.8]), np.full(3, strength))
    solution = solve(scene(polygons, 0.5, lights=(light,)), accuracy=0.2)
    grid = plane_grid(solution, 0.5, spacing=0.25, margin=0.0)
    assert len(grid.points) == 64 - 16


def test_probe_tells_a_dark_grid_without_ratios():
    lroom = SCENES / "lroom.toml"
    dark = lroom, "--grid", "0.75", "--accuracy", "0.1", "--dim", "black=0", "--quiet"
    done = run(*dark, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)["illuminance_lx"]
    assert told["mean"] == told["maximum"] == 0 and told["u0"] is told["ud_error"] is None
    lines = run(*dark).stderr.splitlines()
    assert lines[-2:] == [f"{name:12}{'-':>12}{'-':>12}" for name in ("U0 min/mean", "Ud min/max")]
