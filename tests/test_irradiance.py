"""Irradiance at points: direct light in closed form, furnaces, and errors that cover the truth."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, rotation, scene

from radiosity.analytic import furnace, point_to_parallel_rectangle
from radiosity.solve.solve import solve
from radiosity.transport.hemisphere import look_out
from radiosity.transport.irradiance import indirect_irradiance

ROOM = box((0, 0, 0), (4, 3, 2.5))
UP = [0.0, 0.0, 1.0]


def on_walls(rng, low, high, count):
    """Random points on the walls of a box, with normals that look inside."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    points = rng.uniform(low, high, (count, 3))
    axis, far = rng.integers(0, 3, count), rng.integers(0, 2, count)
    k = np.arange(count)
    points[k, axis] = np.where(far, high[axis], low[axis])
    normals = np.zeros((count, 3))
    normals[k, axis] = np.where(far, -1.0, 1.0)
    return points, normals


def lamp_above(extra=()):
    """A black floor 2 x 2, a lamp 1 x 0.5 at height 1 that looks down, M_e = 3, 2, 1."""
    floor = 2 * SQUARE
    lamp = (SQUARE * [1, 0.5, 1])[::-1] + [0.5, 0.75, 1.0]
    polygons = np.array([floor, lamp, *extra])
    exitance = np.zeros((len(polygons), 3))
    exitance[1] = [3.0, 2.0, 1.0]
    return scene(polygons, 0.0, exitance)


def quarters(x, y, low, high, height):
    """B-3 four times, with its sign where the foot of the point lies outside the rectangle."""
    total = 0.0
    for a in (high[0] - x, x - low[0]):
        for b in (high[1] - y, y - low[1]):
            form = point_to_parallel_rectangle(np.abs(a) + 1e-300, np.abs(b) + 1e-300, height)
            total = total + np.sign(a) * np.sign(b) * form
    return total


@pytest.mark.parametrize("rays", [False, True])
def test_direct_light_of_a_rectangle_is_exact(rays):
    """B-3. With ``rays`` a sheet that stands aside makes the scene one that needs them."""
    aside = [SQUARE[[0, 1, 2, 2]] * 0.1 + [1.9, 1.9, -3]] if rays else ()
    solution = solve(lamp_above(aside), 0.05, mesh="2")
    assert (len(solution.surroundings.visibility.blockers.count) > 0) == rays
    points = np.random.default_rng(0).uniform((0, 0, 0), (2, 2, 0), (200, 3))
    found, error = solution.irradiance(points, np.tile(UP, (200, 1)))
    exact = quarters(points[:, 0], points[:, 1], (0.5, 0.75), (1.5, 1.25), 1.0)
    # 1e-12: Lambert's sum is exact, and no ray is lost on the way
    assert found == pytest.approx(exact[:, None] * [3.0, 2.0, 1.0], rel=1e-12)
    assert error.max() < 1e-15


def test_lamps_shine_from_their_fronts_only():
    solution = solve(lamp_above(), 0.05, mesh="2")
    found, _ = solution.irradiance([[1, 1, 2.0], [1, 1, 0.5]], [[0, 0, -1.0], [0, 0, -1.0]])
    assert np.all(found == 0)


def test_normals_of_any_length():
    solution = solve(lamp_above(), 0.05, mesh="2")
    found, _ = solution.irradiance([[1, 1, 0]] * 2, [[0, 0, 1], [0, 0, 1e-6]])
    assert np.array_equal(found[0], found[1])


def test_shadows_of_a_screen():
    """A screen at half height: full shadow under it, half a lamp at the edge of its shadow."""
    screen = np.array([[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [1.0, 2.0, 0.5], [0.0, 2.0, 0.5]])
    solution = solve(lamp_above([screen]), 0.01, mesh="2")
    points = np.array([[0.2, 1, 0], [0.49, 1, 0], [1.0, 1.0, 0], [1.51, 1, 0], [1.9, 1, 0]])
    found = solution.irradiance(points, np.tile(UP, (5, 1)))[0][:, 0] / 3
    whole = quarters(points[:, 0], points[:, 1], (0.5, 0.75), (1.5, 1.25), 1.0)
    assert np.all(found[:2] == 0)  # the lamp from .5 to 1.5 casts full shadow where x < .5
    assert found[3:] == pytest.approx(whole[3:], rel=1e-12)  # and none where x > 1.5
    half = quarters(points[2, 0], points[2, 1], (1.0, 0.75), (1.5, 1.25), 1.0)
    # 2 %: 512 rays, of which the screen's edge takes half, in strata
    assert found[2] == pytest.approx(half, rel=0.02)


@pytest.mark.parametrize("rho", [0.5, 0.9])
@pytest.mark.parametrize("split", [1, 3])
def test_a_furnace_is_the_same_everywhere(rho, split):
    """Six lamps are sampled one by one; 54 are too many and count as patches."""
    s = np.linspace(0, 1, split + 1)
    polygons = np.concatenate(
        [
            [w[0] + a * (w[1] - w[0]) + b * (w[3] - w[0]) for a, b in
             ((s[i], s[j]), (s[i + 1], s[j]), (s[i + 1], s[j + 1]), (s[i], s[j + 1]))]
            for w in ROOM for i in range(split) for j in range(split)
        ]
    ).reshape(-1, 4, 3)  # fmt: skip
    solution = solve(scene(polygons, rho, 1.0), 0.01, mesh=str(4 // split))
    assert (len(solution.surroundings.lights.polygons) == 6) == (split == 1)
    rng = np.random.default_rng(1)
    points, normals = on_walls(rng, (0, 0, 0), (4, 3, 2.5), 100)
    within = rng.uniform((0.1, 0.1, 0.1), (3.9, 2.9, 2.4), (50, 3))
    points = np.concatenate([points, within])
    normals = np.concatenate([normals, rng.normal(size=(50, 3))])
    found, error = solution.irradiance(points, normals)
    # 1e-6: radiosities to 1e-7, and every ray meets a wall
    assert found == pytest.approx(np.full((150, 3), furnace(1.0, rho)), rel=1e-6)
    assert error.max() < 1e-6


def test_sky_through_an_open_lid():
    """Black walls: E at a point of the floor is pi L times the factor to the lid."""
    walls = box((0, 0, 0), (1, 1, 1))[[0, 2, 3, 4, 5]]
    solution = solve(scene(walls, 0.0, ambient=np.ones(3)), 0.01, mesh="2")
    points = np.random.default_rng(2).uniform((0, 0, 0), (1, 1, 0), (100, 3))
    found, error = solution.irradiance(points, np.tile(UP, (100, 1)))
    exact = np.pi * quarters(points[:, 0], points[:, 1], (0, 0), (1, 1), 1.0)
    off = found[:, 0] / exact - 1
    # 2048 Sobol rays a point: random ones would err by 1.5 to 4 %
    assert np.sqrt(np.mean(off**2)) < 0.01 and abs(off.mean()) < 3e-3
    assert np.all(np.abs(off) < 0.04)
    # the estimate: two halves of the rays, three times their standard error
    assert np.mean(np.abs(found - exact[:, None]) <= error) > 0.8


def test_points_of_a_convex_body_see_only_sky():
    solution = solve(scene(block((0, 0, 0), (1, 1, 1)), 0.5, ambient=np.array([1.0, 2, 3])), 0.05)
    points = [[0.3, 0.4, 1.0], [1.0, 0.2, 0.3], [0.1, 0.0, 0.9]]
    found, error = solution.irradiance(points, [[0, 0, 1], [1, 0, 0], [0, -1, 0]])
    assert found == pytest.approx(np.pi * np.array([[1.0, 2.0, 3.0]] * 3), rel=1e-12)
    assert np.all(error < 1e-12)


def furnished(turn=None, size=1.0):
    """A room with a lamp in the ceiling, coloured walls and two blocks, as in Cornell."""
    lamp = np.array([[0.4, 0.4, 1], [0.4, 0.6, 1], [0.6, 0.6, 1], [0.6, 0.4, 1]])
    polygons = np.concatenate([
        box((0, 0, 0), (1, 1, 1)), lamp[None],
        block((0.15, 0.5, 0), (0.4, 0.75, 0.6)), block((0.55, 0.2, 0), (0.85, 0.5, 0.3), False),
    ])  # fmt: skip
    rho = np.full((len(polygons), 3), 0.7)
    rho[2], rho[3], rho[6] = [0.6, 0.1, 0.1], [0.1, 0.5, 0.1], 0.0
    exitance = np.zeros((len(polygons), 3))
    exitance[6] = 10.0
    polygons = polygons if turn is None else polygons @ turn.T
    return scene(size * polygons, rho, exitance)


def points_in_the_furnished_room(count):
    rng = np.random.default_rng(3)
    points, normals = on_walls(rng, (0, 0, 0), (1, 1, 1), 4 * count)
    hidden = np.zeros(4 * count, bool)
    for low, high in (((0.15, 0.5, 0), (0.4, 0.75, 0.6)), ((0.55, 0.2, 0), (0.85, 0.5, 0.3))):
        hidden |= np.all((points >= low) & (points <= high), axis=1)
    return points[~hidden][:count], normals[~hidden][:count]


def test_errors_cover_a_finer_solution():
    """Nearly all errors lie below the estimate, which is not large by much either.

    Two standard errors of the finer solution are allowed for, as it is no truth either.
    """
    points, normals = points_in_the_furnished_room(120)
    fine, rest = solve(furnished(), 0.015).irradiance(points, normals)
    coarse, error = solve(furnished(), 0.05).irradiance(points, normals)
    off = np.abs(coarse - fine)
    assert np.mean(off <= error + 2 / 3 * rest) >= 0.9  # reached .95
    assert np.sqrt(np.mean(error**2)) < 10 * np.sqrt(np.mean(off**2))  # not by saying "anything"
    assert np.percentile(off / fine.mean(axis=0), 95) < 0.05  # the accuracy asked; reached .011


def with_linear_field(solution, slope, base=10.0):
    """Every patch sends out base + slope . x, as its value and its gradient say; no lamps."""
    around, patches = solution.surroundings, solution.patches
    n = patches.normal
    in_plane = slope[None] - (n @ slope)[:, None] * n
    field = around.field._replace(
        value=np.repeat((base + patches.centroid @ slope)[:, None], 3, axis=1),
        gradient=np.repeat(in_plane[:, None], 3, axis=1),
        direct=np.zeros((2, 0, 3)),
    )
    return replace(around, field=field)


def test_patches_shine_with_their_gradients():
    """A field that is linear in space, against the plain mean over where the rays end."""
    slope, rng = np.array([0.7, -1.1, 0.4]), np.random.default_rng(6)
    around = with_linear_field(solve(scene(ROOM, 0.5, 1.0), 0.1, mesh="2"), slope)
    points, normals = on_walls(rng, (0, 0, 0), (4, 3, 2.5), 40)
    keys, samples = np.arange(40), range(256)
    smooth, flat, _ = indirect_irradiance(around, points, normals, keys, samples, 0)
    visibility = around.visibility
    _, hits = look_out(visibility, around.table, points, normals, keys, samples, 0)
    ends = visibility.centre + hits.astype(float) / visibility.scale
    exact = (10.0 + ends @ slope).mean(axis=1)
    # 1e-5: ray ends in single precision of a room 4 long
    assert smooth == pytest.approx(np.repeat(exact[:, None], 3, axis=1), rel=1e-5)
    off = np.abs(flat[:, 0] - exact)
    assert off.max() > 0.05  # constant patches would show; and so would a wrong sign
    # the field integrated over the hemisphere by 64 x 64 Gauss points is the truth behind both
    assert np.sqrt(np.mean((smooth[:, 0] / linear_light(points, normals, slope) - 1) ** 2)) < 2e-3


def linear_light(points, normals, slope):
    """E from walls of a box that send out 10 + slope . x, by directions over the hemisphere."""
    u, w = np.polynomial.legendre.leggauss(64)
    u, w = (u + 1) / 2, w / 2
    phi = 2 * np.pi * (np.arange(128) + 0.5) / 128
    found = []
    for x, n in zip(points, normals, strict=True):
        across = np.cross(n, [0.3, 0.5, 0.8])
        across /= np.linalg.norm(across)
        frame = np.array([across, np.cross(n, across), n])
        r, z = np.sqrt(u)[:, None], np.sqrt(1 - u)[:, None]
        d = np.stack([r * np.cos(phi), r * np.sin(phi), z + 0 * phi], axis=2) @ frame
        with np.errstate(divide="ignore"):
            wall = np.where(d > 0, [4, 3, 2.5] - x, -x) / d
        reach = np.where(np.abs(d) > 1e-12, wall, np.inf).min(axis=2)
        found.append(w @ (10.0 + (x + reach[..., None] * d) @ slope).mean(axis=1))
    return np.array(found)


def test_irradiance_agrees_with_the_patch_means():
    """Gathered at random points of the ceiling, the mean is the patches' own mean."""
    solution = solve(furnished(), 0.05)
    rng = np.random.default_rng(4)
    points = rng.uniform((0, 0, 0), (0, 1, 1), (200, 3))
    found, _ = solution.irradiance(points, np.tile([1.0, 0, 0], (200, 1)))
    mine = solution.patches.face == 2
    mean = np.average(solution.irradiance_on[mine], axis=0, weights=solution.patches.area[mine])
    # 200 random points of a field that varies by 40 %: 3 %
    assert found.mean(axis=0) == pytest.approx(mean, rel=0.06)


def test_turning_and_scaling_change_only_noise():
    points, normals = points_in_the_furnished_room(30)
    one, error = solve(furnished(), 0.1).irradiance(points, normals)
    turn = rotation(np.random.default_rng(5))
    other, _ = solve(furnished(turn, 1e3), 0.1).irradiance(1e3 * points @ turn.T, normals @ turn.T)
    scale = one.mean(axis=0)
    assert np.sqrt(np.mean(((one - other) / scale) ** 2)) < 0.03  # 256 rays about turned frames


def test_the_number_of_threads_changes_no_bit(monkeypatch):
    points, normals = points_in_the_furnished_room(300)
    solution = solve(furnished(), 0.2)
    monkeypatch.setenv("RADIOSITY_THREADS", "1")
    one, _ = solution.irradiance(points, normals)
    monkeypatch.setenv("RADIOSITY_THREADS", "2")
    two, _ = solution.irradiance(points, normals)
    assert np.array_equal(one, two)


@pytest.mark.parametrize(
    "points, normals, message",
    [
        ([[0, 0, 0]], [[0, 0, 0]], r"point 1: .* must be finite, and the normal longer than 0"),
        ([[0, 0, 0], [0, np.nan, 0]], [[0, 0, 1], [0, 0, 1]], "point 2: position"),
        ([[0, 0, 0]], [[0, 0, np.inf]], "point 1: position"),
        ([0, 0, 0], [0, 0, 1], r"must both have the shape \(k, 3\)"),
        ([[0, 0, 0]], [[0, 0, 1], [0, 0, 1]], r"points \(1, 3\) and normals \(2, 3\)"),
    ],
)
def test_impossible_points_are_refused(points, normals, message):
    with pytest.raises(ValueError, match=message):
        solve(lamp_above(), 0.1, mesh="1").irradiance(points, normals)
