"""Facets: fine meshes become the few polygons they tile, with the same vertices."""

from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import SQUARE, faces_of, rotation, uv_sphere
from scipy.spatial import Delaunay

from radiosity.mesh.facets import merge_facets

MESHES = Path(__file__).resolve().parent.parent / "benchmarks" / "meshes"


def cells(mask):
    """Return the unit squares (m, 4, 3) where a mask (x, y) is true."""
    x, y = np.nonzero(mask)
    return np.stack([x, y, 0 * x], axis=1)[:, None] + SQUARE


def open_grid(n, holes):
    """Return n x n cells without the (x0, x1, y0, y1) of each hole."""
    mask = np.ones((n, n), bool)
    for x0, x1, y0, y1 in holes:
        mask[x0:x1, y0:y1] = False
    return cells(mask)


def box_of(steps, width=1.0):
    """Return a cube's six sides of n x n cells, spaced in proportion to the steps (n,)."""
    t = np.concatenate([[0], np.cumsum(steps)]) / np.sum(steps) * width
    a, b = np.meshgrid(np.arange(len(steps)), np.arange(len(steps)), indexing="ij")
    a, b = a.ravel(), b.ravel()
    u = np.stack([t[a], t[a + 1], t[a + 1], t[a]], axis=1)
    w = np.stack([t[b], t[b], t[b + 1], t[b + 1]], axis=1)
    sides = []
    for axis in range(3):
        for at in (0.0, width):
            quad = np.stack([u, w, np.full_like(u, at)], axis=2)
            quad = quad if at == 0 else quad[:, ::-1]
            sides.append(np.roll(quad, axis, axis=2))
    return np.concatenate(sides)


def triangulated(rng, n, width=3.0, height=2.0):
    """Return a rectangle as triangles (t, 4, 3) of random points, some on its sides."""
    inside = rng.uniform(0.05, 0.95, (n, 2))
    side = np.sort(rng.uniform(0.05, 0.95, n // 4))
    zero, one = np.zeros_like(side), np.ones_like(side)
    ring = [(side, zero), (side, one), (zero, side), (one, side)]
    corner = SQUARE[:, :2]
    p = np.concatenate([corner, inside, *(np.stack(r, axis=1) for r in ring)])
    t = p[Delaunay(p).simplices]
    r = t - t[:, :1]
    turn = r[:, 1, 0] * r[:, 2, 1] - r[:, 1, 1] * r[:, 2, 0]
    t = np.where(turn[:, None, None] < 0, t[:, ::-1], t)[np.abs(turn) > 1e-12]
    flat = np.concatenate([t * [width, height], np.zeros((*t.shape[:2], 1))], axis=2)
    return flat[:, [0, 1, 2, 2]]


def areas(facets):
    r = facets.vertices - facets.vertices[:, :1]
    return 0.5 * np.linalg.norm(np.cross(r[:, 1:-1], r[:, 2:]).sum(axis=1), axis=1)


def checked(polygons):
    """Return the facets after the checks that hold for any mesh."""
    faces = faces_of(polygons)
    facets = merge_facets(faces)
    m = len(facets.count)
    assert facets.vertices.shape == (m, 8, 3) and facets.normal.shape == (m, 3)
    assert np.array_equal(np.unique(facets.facet), np.arange(m))
    rows = {tuple(p) for p in faces.vertices.reshape(-1, 3).tolist()}
    assert all(tuple(p) in rows for p in facets.vertices.reshape(-1, 3).tolist())  # bit for bit
    at = np.arange(8)
    last = facets.vertices[np.arange(m), facets.count - 1][:, None]
    assert np.all((facets.vertices == last)[at >= facets.count[:, None]])
    distinct = [len(np.unique(v, axis=0)) for v in facets.vertices]
    assert distinct == facets.count.tolist()
    size = np.linalg.norm(np.ptp(faces.vertices, axis=(0, 1)))
    for v, n, normal in zip(facets.vertices, facets.count, facets.normal, strict=True):
        edge = np.roll(v[:n], -1, axis=0) - v[:n]
        turn = np.cross(np.roll(edge, 1, axis=0), edge) @ normal
        assert turn.min() > 0  # convex, counter-clockwise, no corner on a side
    # rounding: of coordinates far from the origin, as a share of each facet's area
    blur = 1e-9 + 1e-15 * np.abs(faces.vertices).max() * size / areas(facets).min()
    covered = np.bincount(facets.facet, faces.areas(), m)
    assert areas(facets) == pytest.approx(covered, rel=blur)
    assert facets.normal[facets.facet] == pytest.approx(faces.normals(), abs=2e-7)
    return facets


def corners(facets):
    """Return each facet's corners as a sorted list of rows, in sorted order."""
    return sorted(
        sorted(v[:n].tolist()) for v, n in zip(facets.vertices, facets.count, strict=True)
    )


def quads_of(path):
    """Return the quadrilaterals (f, 4, 3) of an OBJ file."""
    rows = [line.split() for line in path.read_text().splitlines()]
    points = np.array([row[1:] for row in rows if row and row[0] == "v"], float)
    return points[np.array([row[1:] for row in rows if row and row[0] == "f"], int) - 1]


@pytest.mark.parametrize(
    ("name", "count"), [("room_324", 18), ("room_1296", 18), ("room_5184", 18), ("cube_1536", 6)]
)
def test_meshed_rooms_become_their_rectangles(name, count):
    facets = checked(quads_of(MESHES / f"{name}.obj"))
    assert facets.count.tolist() == [4] * count


@pytest.mark.parametrize("seed", range(3))
def test_a_meshed_box_has_six_facets(seed):
    polygons = box_of(np.random.default_rng(seed).uniform(0.5, 2, 7))
    facets = checked(polygons)
    assert facets.count.tolist() == [4] * 6
    assert np.array_equal(facets.facet, np.repeat(np.arange(6), 49))
    assert {tuple(p) for p in facets.vertices.reshape(-1, 3)} == {
        (x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)
    }


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1e4, 1e9])
@pytest.mark.parametrize("offset", [0, 1e6])
def test_turned_scaled_and_far_away(scale, offset):
    rng = np.random.default_rng(1)
    turned = (box_of(rng.uniform(0.5, 2, 6)) @ rotation(rng).T + offset) * scale
    assert checked(turned).count.tolist() == [4] * 6


def test_thin_cells_far_away_whose_normals_are_rough():
    rng = np.random.default_rng(2)
    turned = box_of([1, 1e-4, 1, 1e-4]) @ rotation(rng).T + 1e6
    facets = merge_facets(faces_of(turned))
    assert np.abs(facets.normal[facets.facet] - faces_of(turned).normals()).max() > 2e-7
    assert facets.count.tolist() == [4] * 6


def test_a_sliver_without_direction_does_not_join_a_wall_to_a_floor():
    top = [0.5, 1 + 1e-9, 0]  # eight times the rounding of coordinates at 1e6
    sliver = [[0, 1, 0], [1, 1, 0], top, top]
    wall = [top, [1, 1, 0], [1, 1, 1], [0.5, 1 + 1e-9, 1]]
    facets = merge_facets(faces_of(np.array([SQUARE, sliver, wall]) + 1e6))
    assert facets.facet.tolist() == [0, 1, 2]
    facets = merge_facets(faces_of(np.array([SQUARE, sliver, wall, SQUARE + [0, -1, 0]]) + 1e6))
    assert facets.facet.tolist() == [0, 1, 2, 0]


def test_an_l_is_cut_once_and_a_hole_four_times():
    assert len(checked(open_grid(9, [(4, 9, 4, 9)])).count) == 2
    assert len(checked(open_grid(9, [(3, 5, 4, 7)])).count) == 4
    assert len(checked(open_grid(9, [(0, 3, 0, 3), (6, 9, 0, 3)])).count) == 2  # one line for both
    assert len(checked(open_grid(12, [(3, 5, 4, 7), (7, 9, 4, 7)])).count) == 5  # two lines shared


def test_lines_that_settle_two_corners_come_first_and_lines_stop_at_lines():
    assert len(checked(open_grid(9, [(0, 2, 0, 5), (7, 9, 0, 5)])).count) == 2  # a T
    plus = [(0, 3, 0, 3), (0, 3, 6, 9), (6, 9, 0, 3), (6, 9, 6, 9)]
    assert len(checked(open_grid(9, plus)).count) == 3
    assert len(checked(open_grid(10, [(0, 6, 8, 10), (8, 10, 0, 7)])).count) == 3  # they cross


def test_cracks_at_t_junctions_go_on_to_the_outline():
    mask = np.ones((5, 5), bool)
    mask[2, 2] = False
    left = SQUARE * [0.5, 1, 1] + [2, 2, 0]
    halves = np.concatenate([cells(mask), [left, left + [0.5, 0, 0]]])
    assert len(checked(halves).count) == 3  # below, between and above the two cracks


@pytest.mark.parametrize("seed", range(5))
def test_many_holes_leave_rectangles_only(seed):
    mask = np.random.default_rng(seed).random((15, 15)) > 0.1
    polygons = cells(mask)
    facets = checked(polygons)
    assert np.all(facets.count == 4)
    assert len(facets.count) < 0.45 * len(polygons)


def test_where_no_line_goes_on_faces_stay_alone():
    rng = np.random.default_rng(0)
    shape = triangulated(rng, 60)
    middle = shape[:, :3].mean(axis=1)
    shape = shape[np.abs(middle - [1.5, 1, 0]).max(axis=1) > 0.5]
    assert len(checked(shape).count) == len(shape)


def test_a_hole_whose_lines_are_there_in_part_keeps_what_is_convex():
    two = np.concatenate([open_grid(6, [(2, 4, 2, 4)]), cells(np.ones((3, 3))) + [10, 0, 0]])
    two[0, 2] += 0.2  # one inner vertex moves in one cell only: a crack
    facets = checked(two)
    assert facets.facet[-9:].tolist() == [facets.facet[-1]] * 9


@pytest.mark.parametrize("seed", range(5))
def test_random_triangles_become_the_rectangle(seed):
    rng = np.random.default_rng(seed)
    polygons = triangulated(rng, 80) @ rotation(rng).T
    facets = checked(polygons)
    assert facets.count.tolist() == [4]


def test_corners_up_to_eight():
    for n in (3, 5, 8, 9):
        angle = 2 * np.pi * np.arange(n) / n
        ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        after, middle = np.roll(ring, -1, axis=0), np.zeros_like(ring)
        fan = np.stack([middle, ring, after, after], axis=1)
        assert checked(fan).count.tolist() == ([n] if n <= 8 else [3] * 9)


def test_opposite_sheets_and_parallel_planes_stay_apart():
    sheet = cells(np.ones((4, 4)))
    both = checked(np.concatenate([sheet, sheet[:, ::-1]]))
    assert len(both.count) == 2 and both.normal[:, 2].tolist() == [1, -1]
    step = np.concatenate([sheet, sheet + [4, 0, 1e-5]])
    assert len(checked(step).count) == 2


def test_a_slight_bend_is_kept():
    left = cells(np.ones((3, 3)))
    right = left + [3, 0, 0]
    right[..., 2] += 1e-5 * (right[..., 0] - 3)
    assert len(checked(np.concatenate([left, right])).count) == 2


def test_small_bends_do_not_chain():
    """A strip of 2,000 facets, each turned by less than the tolerance, is not flat."""
    n = 2000
    t = 8e-8 * np.arange(n + 1) * 2
    x, z = np.arange(n + 1.0), np.cumsum(np.sin(t))
    low, high = np.stack([x, 0 * x, z], axis=1), np.stack([x, 0 * x + 300, z], axis=1)
    strip = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    facets = merge_facets(faces_of(strip))
    assert len(facets.count) == n


def test_a_shallow_dome_on_a_flat_outline_is_not_flat():
    n = 100
    height = 5e-7 * n  # more than three weld distances; neighbours turn by less than 2e-7
    dome = cells(np.ones((n, n)))[:, [[0, 1, 2, 2], [0, 2, 3, 3]]].reshape(-1, 4, 3)
    dome[..., 2] = height * np.prod(np.sin(np.pi / n * dome[..., :2]), axis=2)
    assert len(merge_facets(faces_of(dome)).count) == len(dome)


def test_a_shallow_arc_is_not_straight():
    n = 100
    x = np.arange(n + 1.0)
    low = np.stack([x, 0 * x, 0 * x], axis=1)
    high = np.stack([x, 50 + 4e-7 * x * (n - x), 0 * x], axis=1)  # bulges by 1e-3 in all
    strip = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    assert len(merge_facets(faces_of(strip)).count) == n


def test_a_sheet_wound_twice_is_no_pentagon():
    angle = 4 * np.pi * np.arange(5) / 5
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    after = np.roll(ring, -1, axis=0)
    star = np.stack([0 * ring, ring, after, after], axis=1)
    assert checked(star).count.tolist() == [3] * 5


def test_overlaps_and_duplicates_stay_alone():
    sheet = cells(np.ones((3, 3)))
    assert len(checked(np.concatenate([sheet, sheet[4:5]])).count) == 10  # in the middle
    sheet = cells(np.ones((2, 2)))
    assert len(checked(np.concatenate([sheet, sheet[:1]])).count) == 5
    assert len(checked(np.concatenate([SQUARE[None], SQUARE[None]])).count) == 2
    crossing = np.concatenate([SQUARE[None], SQUARE[None] + [0.5, 0.25, 0]])
    assert len(checked(crossing).count) == 2
    other = np.concatenate([sheet, sheet[:1] + [5, 0, 0], sheet[:1] + [6, 0, 0]])
    assert len(checked(np.concatenate([other, sheet[:1]])).count) == 6  # the pair far off is one


def test_a_floor_that_walls_stand_on_is_one():
    floor = cells(np.ones((4, 4)))
    wall = np.array([[[2, y, 0], [2, y + 1, 0], [2, y + 1, 1], [2, y, 1]] for y in range(4)], float)
    both = checked(np.concatenate([floor, wall, wall[:, ::-1]]))
    assert len(both.count) == 3


def test_neighbours_share_corners_bit_for_bit():
    """Vertices that differ by rounding are one vertex, whichever face brings them."""
    rng = np.random.default_rng(0)
    polygons = box_of(rng.uniform(0.5, 2, 5))
    polygons += 1e-12 * rng.normal(size=polygons.shape)
    facets = merge_facets(faces_of(polygons))
    assert len(facets.count) == 6
    assert len(np.unique(facets.vertices.reshape(-1, 3), axis=0)) == 8
    assert corners(merge_facets(faces_of(polygons[::-1]))) == corners(facets)
    ball = uv_sphere(8)[16:-16]  # quadrilaterals
    ball += 1e-12 * rng.normal(size=ball.shape)
    facets = merge_facets(faces_of(ball))
    assert len(facets.count) == len(ball)
    expected = 16 * 7  # points on seven rings
    assert len(np.unique(facets.vertices.reshape(-1, 3), axis=0)) == expected


def test_a_sphere_stays_as_it_is():
    polygons = uv_sphere(30)
    facets = checked(polygons)
    assert np.array_equal(facets.facet, np.arange(len(polygons)))
    assert np.array_equal(facets.vertices[:, :4], polygons)


def test_the_order_of_faces_does_not_matter():
    rng = np.random.default_rng(3)
    polygons = np.concatenate(
        [open_grid(8, [(2, 4, 3, 5), (6, 8, 6, 8)]), triangulated(rng, 30) + [20, 0, 1]]
    )
    expected = corners(checked(polygons))
    for _ in range(3):
        order = rng.permutation(len(polygons))
        turn = (np.arange(4) + rng.integers(0, 4, (len(polygons), 1))) % 4
        quad = np.any(polygons[:, 2] != polygons[:, 3], axis=1)
        turned = np.where(
            quad[:, None, None], np.take_along_axis(polygons, turn[..., None], 1), polygons
        )
        assert corners(checked(turned[order])) == expected


def test_no_faces():
    facets = merge_facets(faces_of(np.empty((0, 4, 3))))
    assert facets.vertices.shape == (0, 8, 3) and len(facets.facet) == 0
