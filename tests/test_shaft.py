"""The shaft of a pair: its planes against linear programs; what rays may be trusted with."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, faces_of, meshed, normal_of, ring, rotation
from scipy.optimize import linprog

import radiosity
from radiosity.transport import factors
from radiosity.transport.blockers import drop_beside, make_blockers
from radiosity.transport.closure import repaired
from radiosity.transport.exchange import make_geometry
from radiosity.transport.factors import form_factors
from radiosity.transport.near import APART, FLAT, PARTLY, nearest
from radiosity.transport.pairs import NEAR, RAYS
from radiosity.transport.shaft import (
    beside,
    box_beside,
    edge_normals,
    half_shaft_planes,
    outline_planes,
    shaft_planes,
)

GRAIN = 1e-15  # of coordinates about 1
SLACK = 4 * GRAIN


def is_apart(hull, polygon):
    """Whether some plane has a hull on one side and a polygon beyond it, 1e-6 away."""
    points, signs = np.concatenate([-hull, polygon]), np.repeat([1, -1], [len(hull), len(polygon)])
    rows = np.c_[points, signs]
    limit = np.repeat([0.0, -1.0], [len(hull), len(polygon)])
    found = linprog(np.zeros(4), A_ub=rows, b_ub=limit, bounds=[(-1e6, 1e6)] * 4)
    return found.status == 0


def facing_pairs(rng, count):
    """Yield quadrilaterals 0 and 1, each wholly in front of the other, as a geometry."""
    while count:
        p, q = ring(rng, 4, 0.3), ring(rng, 4, 0.3)
        p = p if normal_of(p)[2] > 0 else p[::-1]
        q = (q if normal_of(q)[2] < 0 else q[::-1]) + [0, 0, 1]
        normals = np.array([normal_of(p), normal_of(q)])
        if ((q - p[0]) @ normals[0]).min() > 0 and ((p - q[0]) @ normals[1]).min() > 0:
            both = np.array([p, q])
            yield make_geometry(both, normals, both.mean(axis=1), np.ones(2), GRAIN)
            count -= 1


def planes_of(geometry):
    planes = np.empty((10, 4))
    return planes[: shaft_planes(geometry, 0, 1, SLACK, planes)]


def test_planes_touch_the_shaft_from_outside():
    rng = np.random.default_rng(1)
    for geometry in facing_pairs(rng, 50):
        hull = geometry.vertices.reshape(-1, 3)
        planes = planes_of(geometry)
        assert len(planes) == 10
        assert np.linalg.norm(planes[:, :3], axis=1) == pytest.approx(1)
        above = hull @ planes[:, :3].T - planes[:, 3]
        assert above.max(axis=0) == pytest.approx(0, abs=1e-14)


def test_planes_leave_out_no_part_of_polygons_that_cross_each_others_planes():
    rng, crossing, planes = np.random.default_rng(4), 0, np.empty((10, 4))
    for _ in range(200):
        both = np.array([ring(rng, 4, 0.3), ring(rng, 4, 0.3) + rng.uniform(-1, 1, 3)])
        normals = np.array([normal_of(p) for p in both])
        geometry = make_geometry(both, normals, both.mean(axis=1), np.ones(2), GRAIN)
        count = shaft_planes(geometry, 0, 1, SLACK, planes) - 2  # not the polygons' own
        hull = both.reshape(-1, 3)
        assert (hull @ planes[:count, :3].T - planes[:count, 3]).max(initial=0) <= SLACK + 1e-15
        crossing += count < 8
    assert crossing > 100


def test_normals_of_edges_point_outward_in_the_plane():
    rng, edges = np.random.default_rng(5), np.empty((5, 3))
    for _ in range(50):
        polygon = ring(rng, 5, 0.3)
        normal = normal_of(polygon)
        edge_normals(polygon, normal, 1e-12, edges)
        along = np.roll(polygon, -1, axis=0) - polygon
        assert np.linalg.norm(edges, axis=1) == pytest.approx(1)
        assert edges @ normal == pytest.approx(0, abs=1e-15)
        assert np.einsum("ec,ec->e", edges, along) == pytest.approx(0, abs=1e-15)
        middle = polygon.mean(axis=0)
        assert np.einsum("ec,ec->e", edges, polygon - middle).min() > 0


@pytest.mark.parametrize(("moved", "kept"), [(0.0, True), (1e-11, True), (-1e-11, False)])
def test_edges_whose_direction_rounding_decides_have_no_normal(moved, kept):
    """A short edge between two long ones, its end moved out or in by ten times its length."""
    polygon = np.array([[0, 0, 0], [1, 0, 0], [1, 1e-12, 0], [0, 1, 0]])
    polygon[2, 0] += moved
    edges = np.empty((4, 3))
    edge_normals(polygon, np.array([0, 0, 1.0]), SLACK, edges)
    assert np.all(edges[1] == 0) != kept
    assert np.linalg.norm(edges[[0, 3]], axis=1) == pytest.approx(1)


def test_a_corner_off_the_plane_makes_no_planes_that_leave_it_out():
    """However far inside the edge it lies: the sine of the plane's slope counts."""
    bent = SQUARE - [[0, 0, 0], [0, 0, 0], [0, 0, 1e-6], [0, 0, 0]]
    beyond = np.array([[0, -1, 1e-8], [1, -1, 1e-8], [1, -2, 1e-8], [0, -2, 1e-8]])
    planes = np.empty((8, 4))
    up = np.array([0, 0, 1.0])
    count = outline_planes(bent, up, beyond, -up, SLACK, planes)
    assert count > 0
    assert (bent @ planes[:count, :3].T - planes[:count, 3]).max() <= SLACK


def test_any_polygons_have_the_planes_of_patches():
    planes = np.empty((10, 4))
    for geometry in facing_pairs(np.random.default_rng(6), 20):
        expected = planes_of(geometry)[:-2]
        (p, n), (q, o) = zip(geometry.vertices, geometry.normal, strict=True)
        found = planes[: outline_planes(p, n, q, o, SLACK, planes)]
        assert np.array_equal(found, expected)


def test_half_a_shaft_holds_the_whole_one():
    rng = np.random.default_rng(2)
    for geometry in facing_pairs(rng, 20):
        planes, q = np.empty((5, 4)), geometry.vertices[1]
        corners = np.array(np.meshgrid(*zip(q.min(axis=0), q.max(axis=0), strict=True)))
        corners = corners.reshape(3, -1).T
        half = planes[: half_shaft_planes(geometry, 0, corners, SLACK, planes)]
        for plane in half[:-1]:  # all but that of the polygon, which the box may cross
            hull = np.concatenate([geometry.vertices[0], corners])
            assert (hull @ plane[:3] - plane[3]).max() <= 1e-14


def test_what_is_dropped_lies_beside_the_shaft_and_little_else_does():
    """Against a linear program that looks for any plane between the shaft's hull and a blocker."""
    rng = np.random.default_rng(8)
    dropped = apart = 0
    for geometry in facing_pairs(rng, 240):
        rings = [ring(rng, 4, 0.15) + rng.uniform(-0.5, 0.5, 3) + [0, 0, 0.5] for _ in range(4)]
        corners = np.array([r[[0, 1, 2, 3, 3, 3, 3, 3]] for r in rings])
        normals = np.array([normal_of(r) for r in rings])
        blockers = make_blockers(corners, np.full(4, 4), normals, np.full(4, 4), GRAIN)
        found = np.arange(len(blockers.count))
        kept = drop_beside(blockers, found, len(found), planes_of(geometry), SLACK)
        hull = geometry.vertices.reshape(-1, 3)
        for b in range(len(blockers.count)):
            own = blockers.corners[b, : blockers.count[b]]
            if b not in found[:kept]:
                assert is_apart(hull, own)
                dropped += 1
            apart += is_apart(hull, own)
    assert apart > 200
    assert dropped >= 0.9 * apart


def test_boxes_are_beside_where_all_that_they_hold_is():
    rng, some = np.random.default_rng(3), 0
    for geometry in facing_pairs(rng, 200):
        planes = planes_of(geometry)
        inside = ring(rng, 4, 0.2) + rng.uniform(-0.6, 0.6, 3) + [0, 0, 0.5]
        low, high = inside.min(axis=0), inside.max(axis=0)
        if box_beside(low, high, planes, SLACK):
            assert beside(inside, planes, SLACK)
            some += 1
        elif not beside(inside, planes, SLACK):
            corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
            assert not beside(corners, planes, SLACK)
    assert some > 30


# ------------------------------------------------------------------------------- near or not


@pytest.mark.parametrize(
    ("height", "rise", "near"),
    [(0.5, 0.0, FLAT), (0.5, 20, FLAT), (0.5, 30, PARTLY), (0.5, 1 / NEAR, PARTLY), (2, 20, APART),
     (-1, 0, APART), (0.03, 0.0, FLAT), (0.02, 0.0, PARTLY)],
)  # fmt: skip
def test_only_what_comes_near_to_the_front_is_near(height, rise, near):
    """A sheet so many times NEAR above a floor, turned at random; and one far aside."""
    rng, up = np.random.default_rng(4), np.array([0, 0, 1.0])
    for _ in range(20):
        turn = rotation(rng)
        floor = (SQUARE @ turn.T)[None]
        geometry = make_geometry(floor, (turn @ up)[None], floor.mean(axis=1), np.ones(1), GRAIN)
        sheet = 0.5 * SQUARE + [0.2, 0.3, height * NEAR]
        sheet[2:, 2] += rise * NEAR
        sheet = sheet @ turn.T
        for shift, expected in ((0, near), (turn @ [3.0, 0, 0], APART)):
            corners = (sheet + shift)[[0, 1, 2, 3, 3, 3, 3, 3]][None]
            hull = np.concatenate([corners, corners - turn @ up, corners + turn @ up])
            normals = np.tile(normal_of(corners[0, :4]), (3, 1))
            blockers = make_blockers(hull, np.full(3, 4), normals, np.full(3, 3), GRAIN)
            assert len(blockers.count) == 1
            planes, walk = np.empty((6, 4)), np.empty(64, np.int64)
            assert nearest(blockers, geometry, 0, NEAR, planes, walk) == expected


def cluttered(rng, count):
    """Return a room with many small sheets in its middle, meshed."""
    sheets = [(SQUARE - [0.5, 0.5, 0]) * rng.uniform(0.15, 0.4) @ rotation(rng).T
              + rng.uniform(-0.6, 0.6, 3) for _ in range(count)]  # fmt: skip
    faces = faces_of(np.concatenate([box((-1, -1, -1), (1, 1, 1)), sheets]))
    visibility, _, patches = meshed(faces, 4)
    live = np.asarray(patches.face < 6)
    return visibility, patches, live


@pytest.mark.parametrize("accuracy", [0.1, 0.03])
def test_rays_and_exact_shadows_agree_where_rays_may_be_taken(accuracy, monkeypatch):
    """More than FEWER blockers: rays at a coarse accuracy, exact at a finer one."""
    traced, refined = [], factors.refined_shares
    monkeypatch.setattr(
        factors, "refined_shares", lambda *given: traced.append(given[1]) or refined(*given)
    )
    visibility, patches, live = cluttered(np.random.default_rng(5), 60)
    coarse = form_factors(patches, visibility, live, accuracy)
    fine = form_factors(patches, visibility, live, 5e-3)
    assert len(traced) == 1  # none at the finer one
    wrong = np.abs(coarse.exchange - fine.exchange)
    assert (wrong.sum(axis=1)[live] / patches.area[live]).max() < accuracy
    at = tuple(traced[0].T)
    assert len(at[0]) > 300
    # standard errors, neither too small nor too careful
    assert 0.7 < np.sqrt(np.mean((wrong[at] / coarse.error[at]) ** 2)) < 1.1


@pytest.mark.parametrize("gap", [1e-4, 1e-5, 5e-6])
def test_no_clutter_lets_light_through_a_wall(gap):
    """A room full of sheets in a shell so near that rays would start beyond the wall."""
    rng = np.random.default_rng(7)
    sheets = [0.08 * SQUARE @ rotation(rng).T + rng.uniform(0.2, 0.7, 3) for _ in range(300)]
    shell = box((-gap, -gap, -gap), (1 + gap, 1 + gap, 1 + gap))
    polygons = np.concatenate([box((0, 0, 0), (1, 1, 1)), shell, sheets]) @ rotation(rng).T
    visibility, _, patches = meshed(faces_of(polygons), 3)
    room, around = patches.face < 6, (patches.face >= 6) & (patches.face < 12)
    found = form_factors(patches, visibility, np.asarray(room | around), 0.1)
    assert np.all(found.exchange[np.ix_(room, around)] == 0)
    assert np.all(found.row_sums()[room] > 0.3)


def tiled_ceiling(n):
    """Return a room, n x n patches a wall, below whose ceiling hang tiles that overlap.

    They are no rows and hang nearer than what rays are lifted by.
    """
    rng = np.random.default_rng(6)
    tiles = [0.1 * SQUARE[::-1] * [1.02, 1.02, 1] + [0.1 * a, 0.1 * b, 1 - rng.uniform(4e-6, 6e-6)]
             for a in range(10) for b in range(10)]  # fmt: skip
    faces = faces_of(np.concatenate([box((-0.1, -0.1, 0), (1.1, 1.1, 1)), tiles]))
    visibility, _, patches = meshed(faces, n)
    assert len(visibility.blockers.count) == 100
    return form_factors(patches, visibility, np.asarray(patches.face < 6), 0.1), patches


def test_rays_that_could_start_beyond_a_blocker_are_not_taken():
    found, patches = tiled_ceiling(4)
    middle = np.abs(patches.centroid[:, :2] - 0.5).max(axis=1) < 0.3
    up, down = (np.flatnonzero((patches.face == f) & middle) for f in (1, 0))
    assert len(up) == len(down) == 4
    assert found.exchange[np.ix_(up, down)].max() < 1e-9
    # nor does the repair give to others what the tiles absorb, which openness rays start beyond
    closed, ceiling = repaired(found), patches.face == 1
    assert found.openness.share[ceiling].max() == 0
    lost = (1 - found.row_sums())[ceiling]
    assert lost.min() > 0.3
    assert np.abs(closed.openness.share[ceiling] - lost).max() < found.row_errors()[ceiling].max()


@pytest.mark.parametrize("n", [1, 2])
def test_where_too_many_blockers_are_too_near_the_errors_say_so(n):
    """The floor sees what the tiles leave of the ceiling, the ceiling mostly tiles."""
    found, patches = tiled_ceiling(n)
    up, down = (np.flatnonzero(patches.face == f) for f in (1, 0))
    square, floor = (
        np.array([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1.0]]) * [1.002, 1.002, 1],
        np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]) * 1.2 - [0.1, 0.1, 0],
    )
    corners = np.concatenate([square, floor, floor[::-1] + [0, 0, 1]])
    exact = radiosity.form_factors((corners, np.arange(12).reshape(3, 4)[:2]), repair=False)
    whole = radiosity.form_factors((corners, np.arange(12).reshape(3, 4)[1:]), repair=False)
    seen = whole.exchange[0, 1] - exact.exchange[0, 1]
    wrong = abs(found.exchange[np.ix_(up, down)].sum() - seen)
    assert 0.01 < wrong < found.error[np.ix_(up, down)].sum()
    covered = 1.002**2 / 1.44
    absorbed = (found.openness.share * patches.area)[up].sum() / 1.44
    assert abs(absorbed - covered) < (found.openness.error * patches.area)[up].sum() / 1.44 + (
        found.row_errors()[up].max()
    )


def test_marks_for_rays_tell_what_hangs_too_near_for_them(monkeypatch):
    """Strips so near that rays start beyond them hide half a ceiling; clutter asks for rays."""
    marks = []
    monkeypatch.setattr(
        factors, "_trace_rest", lambda exchange, error, *_: marks.append(error[0, 1])
    )
    rng = np.random.default_rng(8)
    strips = [SQUARE[::-1] * [1, 0.05, 1] + [0, 0.1 * k, 1 - 5e-6] for k in range(10)]
    clutter = [0.01 * SQUARE @ rotation(rng).T + rng.uniform(0.3, 0.7, 3) for _ in range(60)]
    room = box((-0.1, -0.1, -0.1), (1.1, 1.1, 1.1))  # what lies on the hull blocks nothing
    polygons = np.concatenate([SQUARE[None], SQUARE[None, ::-1] + [0, 0, 1], strips, clutter, room])
    visibility, _, patches = meshed(faces_of(polygons), 1)
    form_factors(patches, visibility, np.asarray(patches.face < 2), 0.1)
    hidden = RAYS - marks[0]
    assert 0.5 - 1e-4 < hidden < 0.51
