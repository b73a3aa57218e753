"""What cells owe to the error of points, and meshes divided where that is worth it."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, scene

import radiosity
from radiosity.light.photometry import luminance
from radiosity.mesh.division import Division
from radiosity.solve import refinement
from radiosity.solve.level import solve_level
from radiosity.solve.plan import Recipe
from radiosity.solve.reach import find_reach
from radiosity.solve.refinement import blame, refine
from radiosity.transport.arrival import all_weights

RECIPE = Recipe(order=1, factors=1e-6, rule=0.0, tolerance=1e-12, solver="direct")


def two_rooms():
    """A bright room and a dim one, and a wall with a door between them."""
    wall = [SQUARE[:, [2, 1, 0]] * [1, 0.9, 1] + [1, 0, 0]]
    wall += [w[::-1] + [1e-3, 0, 0] for w in wall]
    emitted = np.zeros(8)
    emitted[2] = 1.0
    return scene(np.concatenate([box((0, 0, 0), (2, 1, 1)), wall]), 0.6, emitted)


def levels(room):
    coarse = Division(np.full((len(room.faces), 2), 2))
    return [solve_level(room, find_reach(room, d, 0), RECIPE) for d in (coarse.divided(2), coarse)]


def test_shares_add_up_to_the_difference(monkeypatch):
    """Of one point: its weights on the fine solution less those on the coarse one."""
    monkeypatch.setattr(refinement, "SETTLED", 1e-13)
    monkeypatch.setattr(refinement, "SWEEPS", 200)
    fine, coarse = levels(two_rooms())
    x, n = np.array([[0.7, 0.0, 0.35]]), np.array([[0.0, 1.0, 0.0]])
    weights = all_weights(fine.senders, x, n)
    share = refinement._importance(fine, weights)[0] * refinement._residual(fine, coarse)
    there = weights @ refinement._put_on(fine, coarse)
    assert np.sum(share, axis=0) == pytest.approx((weights @ fine.coefficients - there)[0])
    direct = coarse.gathered(x, n).total  # a field of linear elements is one on their parts too
    assert there == pytest.approx(direct, rel=2e-5)  # of blocked factors, cut out part by part
    shares = blame(fine, coarse, x, n, np.ones(1))
    assert len(shares) == coarse.reach.patches.grid.division.count
    face = coarse.reach.patches.grid.division.face
    middles = fine.reach.patches.centroid[fine.rows]
    cells = coarse.reach.patches.centroid[coarse.reach.patches.grid.start[:-1]]
    near = np.linalg.norm(middles[:, None] - cells, axis=2)
    near[fine.reach.patches.face[fine.rows][:, None] != face] = np.inf
    parts = luminance(share).reshape(3, -1).sum(axis=0)
    mine = np.bincount(near.argmin(axis=1), parts, len(cells))  # by where they lie
    assert shares == pytest.approx(np.abs(mine), rel=1e-6, abs=1e-12)


def test_what_no_point_asks_for_gets_no_blame():
    """Two closed boxes side by side, a point in one of them."""
    emitted = np.zeros(12)
    emitted[[2, 8]] = 1.0
    rooms = [box((0, 0, 0), (1, 1, 1)), box((1.5, 0, 0), (2.5, 1, 1))]
    fine, coarse = levels(scene(np.concatenate(rooms), 0.6, emitted))
    x, n = np.array([[0.3, 0.0, 0.4]]), np.array([[0.0, 1.0, 0.0]])
    shares = blame(fine, coarse, x, n, np.ones(1)).reshape(2, -1)
    assert shares[0].max() > 1e-6 and not shares[1].any()


def test_equal_shares_are_divided_equally():
    grid = Division(np.array([[4, 4]]))
    made = refine(grid, np.ones(16), 0.25**refinement.FALL, 1e9)
    assert np.array_equal(made.splits[0], np.full(16, 2))  # 2 ** -ORDER


def test_a_single_share_is_divided_alone():
    shares = np.zeros(16)
    shares[5] = 1.0
    made = refine(Division(np.array([[4, 4]])), shares, 0.2, 1e9)
    assert made.splits[0][5] > 1 and np.all(np.delete(made.splits[0], 5) == 1)


def test_a_large_step_takes_many_cells_whatever_the_shares_promise():
    shares = 1e-3 * np.linspace(0.01, 1.0, 100)
    shares[7] = 1.0
    made = refine(Division(np.array([[10, 10]])), shares, 0.3, 1e9)
    assert 100 * 0.3**-0.6 <= made.count < 300


def test_no_more_cells_than_may_be():
    rng = np.random.default_rng(0)
    made = refine(Division(np.array([[10, 10]])), rng.uniform(size=100), 1e-3, 250)
    assert 180 < made.count <= 250
    assert refine(Division(np.array([[10, 10]])), rng.uniform(size=100), 1e-3, 100) is None
    assert refine(Division(np.array([[10, 10]])), np.zeros(100), 0.1, 1e9) is None


@pytest.mark.parametrize("x", [0.2, 1.7])
def test_a_goal_pays_for_its_points_only(x):
    room = two_rooms()
    points, normals = np.array([[x, 0.0, 0.3]]), np.array([[0.0, 1.0, 0.0]])
    everywhere = radiosity.solve(room, 0.003)
    there = radiosity.solve(room, 0.003, goal=(points, normals))
    exact = radiosity.solve(room, 0.0005, goal=(points, normals)).irradiance(points, normals)[0]
    off = np.abs(there.irradiance(points, normals)[0] / exact - 1.0)
    assert off.max() < 0.003
    # some are for what is close to the point: at 1.7 in a corner with the floor 0.61, else 0.50
    most = {0.2: 0.6, 1.7: 0.62}[x]
    assert len(there.level.rows) < most * len(everywhere.level.rows)
