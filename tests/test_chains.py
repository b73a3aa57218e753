"""Extended form factors: furnaces with mirrors, glass and lobes, closed forms, the balance."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import block, box

from radiosity.light.coherent import Constant, FresnelMirror, FresnelPassage
from radiosity.light.fresnel import reflectance
from radiosity.light.phong import Phong
from radiosity.light.sources import Directional, Flood, Point
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Material, Scene, SceneError
from radiosity.solve.chains import arriving_by_chains
from radiosity.solve.clustered import solve_clusters
from radiosity.solve.plan import make_plan, plan_of_clusters
from radiosity.solve.reach import find_reach
from radiosity.solve.solve import solve

ONE, GLASS = np.ones(3), np.array([1.5])
WALLS = box((0, 0, 0), (4, 3, 2.5))
BODY = block((1, 1, 0.5), (2, 2, 1.5))
PERFECT = {"mirror": Constant(ONE)}
CLEAR = {"mirror": FresnelMirror(GLASS), "transmit": FresnelPassage(GLASS)}


def surface(name, rho, exitance=0.0, **optics):
    rho = rho * ONE
    return Material(name, rho, 1 - rho, exitance * ONE / np.pi, **optics)


def scene_of(parts, materials, **more):
    kind = np.repeat(np.arange(len(parts)), [len(p) for p in parts])
    faces = Faces.from_polygons(np.concatenate(parts), kind, 0, merge=False)
    return Scene("test", faces, tuple(materials), ("all",), **more)


FURNACES = {
    "mirror wall": scene_of(
        [WALLS[1:], WALLS[:1]], [surface("w", 0.5, 1.0), surface("m", 0.0, **PERFECT)]
    ),
    "mirror block": scene_of(
        [WALLS, BODY], [surface("w", 0.5, 1.0), surface("m", 0.0, **PERFECT)]
    ),
    "glass block": scene_of([WALLS, BODY], [surface("w", 0.5, 1.0), surface("g", 0.0, **CLEAR)]),
}


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("name", list(FURNACES))
def test_what_takes_no_light_leaves_a_furnace_even(name, order):
    """Walls of M and rho have B = M/(1 - rho) whatever lossless body is in the room."""
    solution = solve(FURNACES[name], 0.05, order=order, mesh="auto" if order else "3")
    walls = solution.live & (solution.emission[:, 0] > 0)
    assert solution.radiosity[walls] == pytest.approx(2.0, abs=0.03)
    area = solution.patches.area[walls]
    assert area @ solution.radiosity[walls, 0] / area.sum() == pytest.approx(2.0, abs=0.005)
    found, _ = solution.irradiance([[2, 1.5, 0.01], [3.5, 0.3, 1]], [[0, 0, 1], [1, 0, 0]])
    assert found == pytest.approx(2.0, abs=0.03)
    assert solution.balance.defect < 0.01


def test_inside_of_glass_the_irradiance_is_n_squared_times_as_large():
    """L/n^2 is that of the furnace in all directions that leave the block: cones about its axes.

    E/(n^2 E_furnace) of a black chip in it is 1/n^2, of the cone about its normal, and
    (b - sin(b) cos(b))/pi of each of the other four, sin(b) = 1/n. No light gets into the rest.
    """
    chip = np.array([[[1.4, 1.4, 1], [1.6, 1.4, 1], [1.6, 1.6, 1], [1.4, 1.6, 1]]])
    materials = [surface("w", 0.5, 1.0), surface("g", 0.0, **CLEAR), surface("chip", 0.0)]
    solution = solve(scene_of([WALLS, BODY, chip], materials), 0.1)
    found, _ = solution.irradiance([[1.5, 1.5, 1.0]], [[0, 0, 1.0]])
    critical = np.arcsin(1 / 1.5)
    share = 1 / 1.5**2 + 4 * (critical - np.sin(critical) * np.cos(critical)) / np.pi
    assert found[0, 0] == pytest.approx(2.0 * 1.5**2 * share, rel=0.02)


def gloss_over_a_floor(exponent, lamp):
    """A black ceiling over a glossy black floor under a lamp: E on the ceiling by the lobe alone.

    E(x) = int f(L, V) E_l(y) cos cos' / r^2 dA over the floor, on a fine grid.
    """
    size, height, n = 2.0, 1.0, 400
    floor = np.array([[[-size, -size, 0], [size, -size, 0], [size, size, 0], [-size, size, 0]]])
    ceiling = (floor + [0, 0, height])[:, ::-1]
    lobe = Phong(0.8 * ONE, exponent)
    glossy = surface("glossy", 0.0, specular=lobe)
    scene = scene_of([floor, ceiling], [glossy, surface("black", 0.0)], lights=(lamp,))
    points = np.array([[0.3, -0.2, height], [1.0, 0.4, height]])
    along = (np.arange(n) + 0.5) / n * 2 * size - size
    y = np.stack([*np.meshgrid(along, along), np.zeros((n, n))], axis=-1).reshape(-1, 3)
    to_light, _, arriving = lamp.reaching(y, 1.0)
    exact = []
    for x in points:
        d = x - y
        r2 = np.sum(d**2, axis=1)
        view = d / np.sqrt(r2)[:, None]
        radiance = lobe.value(to_light, view) * arriving * to_light[:, 2:]
        exact.append((radiance * (view[:, 2] ** 2 / r2)[:, None]).sum(axis=0) * (2 * size / n) ** 2)
    return scene, points, np.array(exact)


@pytest.mark.parametrize("exponent", [3.0, 50.0])
def test_a_lobe_carries_the_light_of_a_lamp(exponent):
    lamp = Point(np.array([0.0, 0.1, 0.6]), 10 * ONE)
    scene, points, exact = gloss_over_a_floor(exponent, lamp)
    solution = solve(scene, 0.02)
    normals = np.tile([0, 0, -1.0], (2, 1))
    to_light, distance, arriving = lamp.reaching(points, 1.0)
    direct = arriving * np.maximum(-to_light[:, 2:], 0.0)
    found, bars = solution.irradiance(points, normals)
    assert np.all(direct > 0)  # the lamp itself lights the ceiling, too
    assert found - direct == pytest.approx(exact, rel=0.02)
    assert np.all(np.abs(found - direct - exact) <= bars)
    assert solution.balance.defect < 0.02


def slab(absorption=0.0):
    """A pane of 0.2 between a lamp or the sun above and a black floor."""
    floor = np.array([[[-3.0, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]])
    pane = block((-2.5, -2.5, 0.5), (2.5, 2.5, 0.7))
    glass = surface("g", 0.0, **CLEAR)
    glass = replace(glass, absorption=absorption * ONE) if absorption else glass
    return floor, pane, [surface("floor", 0.0), glass]


@pytest.mark.parametrize("absorption", [0.0, 2.0])
def test_a_pane_dims_and_draws_near_a_lamp_behind_it(absorption):
    """E on the axis: I T^2 R^(2k) e^(-a t (2k + 1))/(h - t + (2k + 1) t/n)^2, summed over k."""
    floor, pane, materials = slab(absorption)
    height, t, n = 2.0, 0.2, 1.5
    lamp = Point(np.array([0.0, 0, height]), 10 * ONE)
    scene = scene_of([floor, pane], materials, lights=(lamp,))
    r = float(reflectance(1.0, n))
    exact = sum(
        10 * (1 - r) ** 2 * r ** (2 * k) * np.exp(-absorption * t * (2 * k + 1))
        / (height - t + (2 * k + 1) * t / n) ** 2
        for k in range(5)
    )  # fmt: skip
    solution = solve(scene, 0.05)
    found, bars = solution.irradiance([[0.0, 0, 0]], [[0, 0, 1.0]])
    assert found[0, 0] == pytest.approx(exact, rel=0.03)
    assert abs(found[0, 0] - exact) <= bars[0, 0]
    assert solution.balance.defect < 0.01


@pytest.mark.parametrize("absorption", [0.3, 30.0])
def test_what_a_body_swallows_of_a_lamp_is_in_the_balance(absorption):
    """Faces that emit, a glass cube that absorbs, black walls: nothing is lost but what is."""
    lamp = np.array([[[1.0, 1, 2.4], [1, 2, 2.4], [2, 2, 2.4], [2, 1, 2.4]]])
    ink = replace(surface("ink", 0.0, **CLEAR), absorption=absorption * ONE)
    scene = scene_of([WALLS, BODY, lamp], [surface("w", 0.3), ink, surface("lamp", 0.0, 10.0)])
    solution = solve(scene, 0.2, mesh="3")
    assert solution.balance.defect < 0.01
    clear = solve(replace(scene, materials=FURNACES["glass block"].materials + scene.materials[2:]),
                  0.2, mesh="3")  # fmt: skip
    assert solution.irradiance_on.sum() < clear.irradiance_on.sum()


def test_a_lamp_in_a_mirror_lights_what_is_beyond_a_lobe():
    """Lamp, mirror, glossy floor, black ceiling: as if the lamp hung at its image's place."""
    lamp = Flood(np.array([0.0, 0.1, 0.6]), 10 * ONE, axis=np.array([0.96, 0, -0.28]), exponent=9.0)
    scene, points, _ = gloss_over_a_floor(5.0, lamp)
    wall = np.array([[[2.0, 2, 0], [2, -2, 0], [2, -2, 1], [2, 2, 1]]])
    mirror = surface("m", 0.0, mirror=Constant(ONE))
    turned = lamp.moved(np.diag([-1.0, 1, 1]), np.array([4.0, 0, 0]))
    parts = [scene.faces.vertices[:1], scene.faces.vertices[1:], wall]
    normals = np.tile([0, 0, -1.0], (2, 1))
    found = solve(scene_of(parts, [*scene.materials, mirror], lights=(lamp,)), 0.02)
    wide = [x * [3, 1, 1] for x in parts[:2]]
    both = solve(scene_of(wide, scene.materials, lights=(lamp, turned)), 0.02)
    one, _ = found.irradiance(points, normals)
    two, _ = both.irradiance(points, normals)
    alone, _ = solve(scene, 0.02).irradiance(points, normals)
    assert np.all(one - alone > 0.1 * two)
    assert one == pytest.approx(two, rel=0.03)


def test_the_sun_shines_through_a_window():
    """A pane of the transmittance 0.8 in the roof of a black shed, straight through."""
    window = np.array([[[1.0, 1, 2.5], [1, 2, 2.5], [3, 2, 2.5], [3, 1, 2.5]]])
    clear = surface("window", 0.0, transmit=Constant(0.8 * ONE))
    roof = [np.array([[[a, c, 2.5], [a, d, 2.5], [b, d, 2.5], [b, c, 2.5]]], float)
            for a, b, c, d in ((0, 4, 0, 1), (0, 4, 2, 3), (0, 1, 1, 2), (3, 4, 1, 2))]  # fmt: skip
    sun = Directional(np.array([0.6, 0, -0.8]), 5 * ONE)
    sides = np.concatenate([WALLS[[0, 2, 3, 4, 5]], *roof])
    scene = scene_of([sides, window], [surface("w", 0.0), clear], lights=(sun,))
    solution = solve(scene, 0.05)
    points = np.array([[3.6, 1.5, 0], [1.5, 1.5, 0], [2.0, 2.5, 0]])  # lit, and beside the patch
    found, bars = solution.irradiance(points, np.tile([0, 0, 1.0], (3, 1)))
    assert found[0, 0] == pytest.approx(0.8 * 5 * 0.8, rel=0.05)
    assert np.all(found[1:] == 0)
    level, area = solution.level, solution.patches.area[solution.level.rows]
    floor = solution.patches.face[level.rows] == 0
    floor &= solution.patches.front[level.rows]
    assert (area * level.arriving[: len(area), 0])[floor].sum() == pytest.approx(
        1.125 * 0.8 * 5 * 0.8, rel=1e-3
    )  # the rest of the beam falls on a wall


def test_a_mirror_has_a_colour_and_takes_the_rest():
    share = np.array([0.9, 0.5, 0.0])
    mirror = surface("m", 0.0, mirror=Constant(share))
    scene = scene_of([WALLS[:1], WALLS[1:2]], [surface("lamp", 0.0, 1.0), mirror])
    solution = solve(scene, 0.05)
    level = solution.level
    rows = np.flatnonzero(solution.patches.face[level.rows] == 0)
    found = level.arriving[rows]
    assert np.all(found[:, 2] == 0) and np.all(found[:, 0] > 0)
    assert found[:, 1] / found[:, 0] == pytest.approx(5 / 9, rel=1e-9)
    emitted, lost = solution.balance.emitted, solution.balance.absorbed
    assert solution.balance.defect < 0.01 and np.all(lost < emitted)


def test_chains_are_reciprocal():
    """A_i X_ij = A_j X_ji, but for the noise of rays."""
    solution = solve(FURNACES["glass block"], 0.02, order=0, mesh="8")
    level = solution.level
    face, area = solution.patches.face[level.rows], solution.patches.area[level.rows]
    wall = np.array([face == k for k in range(6)], float)
    exchange = (wall * area) @ level.chains.matrix[0] @ wall.T
    assert np.abs(exchange - exchange.T).max() < 0.03 * exchange.max()


def test_errors_of_rays_are_told():
    level = solve(FURNACES["glass block"], 0.3, order=1, mesh="1").level
    points = np.random.default_rng(3).uniform((0.1, 0.1, 0), (3.9, 2.9, 0), (60, 3))
    normals = np.tile([0, 0, 1.0], (60, 1))
    args = level.tracer, level.coefficients, np.zeros(3), points, normals
    exact = arriving_by_chains(*args, 1 << 15).total[:, 0]
    found = arriving_by_chains(*args, 256)
    off = np.abs(found.total[:, 0] - exact)
    assert np.mean(off <= 2 * found.error[:, 0]) > 0.85
    assert found.error[:, 0].mean() < 3 * np.sqrt(np.mean(off**2))
    finer = arriving_by_chains(*args, 4096)
    assert np.sqrt(np.mean((finer.total[:, 0] - exact) ** 2)) < 0.3 * np.sqrt(np.mean(off**2))


def test_light_that_never_fades_is_refused():
    white = [surface("w", 1.0, 1.0), surface("m", 0.0, **PERFECT)]
    with pytest.raises(SceneError, match="light never fades"):
        solve(scene_of([WALLS[1:], WALLS[:1]], white), 0.1)


def test_clusters_get_what_elements_get():
    scene = FURNACES["mirror block"]
    scene = replace(scene, materials=(surface("w", 0.5, 0.0), scene.materials[1]))
    lamp = np.array([[[2.5, 1, 2.4], [2.5, 2, 2.4], [3, 2, 2.4], [3, 1, 2.4]]], float)
    parts = [WALLS, BODY, lamp]
    scene = scene_of(parts, [*scene.materials, surface("lamp", 0.0, 20.0)])
    exact = solve(scene, 0.02)
    recipe = plan_of_clusters(scene, 0.05).recipe
    division = make_plan(scene, 0.1, "6").division
    level = solve_clusters(scene, find_reach(scene, division, 0), recipe, 200)
    here, area = level.rows, level.reach.patches.area[level.rows]
    walls = scene.faces.material[level.reach.patches.face[here]] == 0
    mean = area[walls] @ level.arriving[walls] / area[walls].sum()
    there = exact.level.rows
    again = scene.faces.material[exact.patches.face[there]] == 0
    size = exact.patches.area[there][again]
    assert mean == pytest.approx(size @ exact.irradiance_on[there][again] / size.sum(), rel=0.01)
