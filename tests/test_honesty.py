"""Estimates hold in scenes that are made to fool sample points, rays and the repair."""

from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box
from test_contact import divided

import radiosity

SCENES = Path(__file__).resolve().parent.parent / "scenes"
FLOOR = SQUARE


def ceiling(height):
    return SQUARE[::-1] + [0, 0, height]


def rectangle(low, high):
    """Return the rectangle between two corners that share one coordinate."""
    axis = int(np.argmin(np.abs(np.subtract(high, low))))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    corners = np.tile(np.array(low, float), (4, 1))
    corners[1:3, u], corners[2:, v] = high[u], high[v]
    return corners


def sheet(low, high, z):
    """Return the rectangle between two corners (x, y) at a height."""
    return rectangle((*low, z), (*high, z))


def mesh_of(polygons):
    corners = np.array(polygons, float).reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(len(polygons), -1)


def raw(rows, accuracy, obstructions=None, **options):
    blocking = None if obstructions is None else mesh_of(obstructions)
    return radiosity.form_factors(
        mesh_of(rows), accuracy, obstructions=blocking, repair=False, **options
    )


SPECK = sheet((0.45, 0.45), (0.46, 0.46), 0.49)


@pytest.mark.parametrize("accuracy", [0.1, 1e-2, 1e-4])
@pytest.mark.parametrize("wide", [0.05, 0.1, 0.15, 0.19])
def test_a_slit_between_sample_points_is_found_from_the_other_side(wide, accuracy):
    """Light enters by a slit close to the floor; a speck makes the floor the side sampled."""
    rows, low = [FLOOR, ceiling(0.5)], 0.28
    screens = [sheet((-1, -1), (low, 2), 0.005), sheet((low + wide, -1), (2, 2), 0.005)]
    expected = raw(rows, 1e-6, screens).exchange[0, 1]
    assert 0.4 * wide < expected < wide
    found = raw(rows, accuracy, [*screens, SPECK])
    assert abs(found.exchange[0, 1] - expected) < 1.5 * found.error[0, 1] + 2e-4  # the speck's
    assert found.error[0, 1] <= accuracy


@pytest.mark.parametrize("accuracy", [1e-2, 1e-4, 1e-5])
@pytest.mark.parametrize("size", [1e-2, 1e-3])
def test_a_speck_does_not_end_the_search_for_other_shadows(size, accuracy):
    rows, strip = [FLOOR, ceiling(1.0)], sheet((0.28, 0), (0.47, 1), 0.005)
    expected = raw(rows, 1e-6, [strip]).exchange[0, 1]
    assert 0.15 < expected < 0.16  # 0.2 without
    speck = sheet((0.4, 0.4), (0.4 + size, 0.4 + size), 0.999)
    found = raw(rows, accuracy, [strip, speck])
    assert abs(found.exchange[0, 1] - expected) < found.error[0, 1] + size**2


def test_a_blocker_that_a_polygon_just_pokes_through_is_seen():
    """Cutting along its plane takes nothing from the middle of the ceiling but rounding."""
    emitter = [[0.914, 0.253, 0.465], [0.501, 0.286, 0.454], [0.779, 0.056, 0.45]]
    blocker = np.array([[0.892, 0.274, 0.684], [0.795, 0.465, 0.855], [0.696, 0.369, 0.739]])
    corners = np.concatenate([emitter, ceiling(1.0)])
    found = radiosity.form_factors(
        (corners, [[0, 1, 2], [3, 4, 5, 6]]),
        1e-5,
        repair=False,
        obstructions=(blocker, [[0, 1, 2]]),
    )
    # 8e6 rays: 0.38025 +- 0.00022
    assert found.toarray()[0, 1] == pytest.approx(0.38025, abs=5e-4)


@pytest.mark.parametrize("seed", range(6))
def test_closed_rooms_with_two_bodies_close_within_their_estimates(seed):
    rng, room = np.random.default_rng(seed), box((0, 0, 0), (1, 1, 1))
    corners, faces = [*room.reshape(-1, 3)], np.arange(24).reshape(6, 4).tolist()
    for x in (0.27, 0.73):
        p = np.clip([x, 0.5, 0.5] + rng.uniform(-0.2, 0.2, (4, 3)), 0.02, 0.98)
        p = p if np.linalg.det(p[1:] - p[0]) > 0 else p[[1, 0, 2, 3]]
        faces += [
            [len(corners) + k for k in f] for f in ([0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2])
        ]
        corners += [*p]
    found = radiosity.form_factors((np.array(corners), faces), 1e-3, repair=False)
    assert found.is_closed
    assert np.all(np.abs(found.closure) < 2 * found.row_errors() + 1e-12)


# Two walls of a `box`, and rectangles close to one or both, which leave slivers open between all
# sample points.
SLIVERS = {
    "both ends": (
        (5, 4),
        [((0.7849, 0.002, -0.0324), (1.1661, 0.002, 0.8002)),
         ((0.0141, 0.9925, 0.0064), (1.0102, 0.9925, 0.655)),
         ((0.1449, 0.018, 0.1139), (0.9141, 0.018, 1.0253))],
    ),
    "a corner": (
        (0, 3),
        [((0.7312, 0.4423, 0.0355), (0.8252, 0.5107, 0.0355)),
         ((0.6598, 0.2996, 0.0024), (0.9803, 0.7337, 0.0024)),
         ((0.9944, -0.0636, 0.0084), (1.1945, 0.6421, 0.0084)),
         ((0.9697, 0.0106, 0.9093), (0.9697, 0.418, 1.1267)),
         ((0.9454, 0.0328, 0.0823), (0.9454, 0.8955, 0.4894)),
         ((0.9905, -0.0202, 0.3649), (0.9905, 0.8581, 0.8008))],
    ),
}  # fmt: skip


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3])
@pytest.mark.parametrize("where", SLIVERS)
def test_slivers_that_sheets_leave_at_both_ends_are_found(where, accuracy):
    pair, sheets = SLIVERS[where]
    walls, sheets = box((0, 0, 0), (1, 1, 1))[[*pair]], [rectangle(*s) for s in sheets]
    fine = raw(divided(walls, 5), 1e-3, sheets)
    expected, doubt = fine.exchange[:25, 25:].sum(), fine.error[:25, 25:].max()
    found = raw(walls, accuracy, sheets)
    assert abs(found.exchange[0, 1] - expected) < 1.5 * found.error[0, 1] + 5 * doubt


@pytest.mark.parametrize("gap", [0.5, 0.05, 0.01])
def test_rays_of_unequal_weight_count_for_fewer(gap):
    """Between near plates a few of the rays carry all the weight."""
    tiles = [sheet((a, b), (a + 0.1, b + 0.1), gap / 2) for a in np.arange(7) / 7 + 0.02
             for b in np.arange(7) / 7 + 0.02]  # fmt: skip
    found = [raw([FLOOR, ceiling(gap)], 1e-2, tiles, seed=seed) for seed in range(8)]
    value = np.array([f.exchange[0, 1] for f in found])
    stated = np.mean([f.error[0, 1] for f in found])
    assert 0 < value.std() < 2 * stated < 20 * value.std()


@pytest.mark.parametrize("gap", [2e-6, 8e-6, 1e-4, 1e-2])
def test_light_that_leaves_by_a_narrow_gap_is_not_given_to_the_rows(gap):
    """Too little for rays to find, or nearer than they start: the exact factor tells."""
    exact = raw([FLOOR, ceiling(gap)], 1e-3)
    missing = 1.0 - exact.exchange[0, 1]
    assert abs(exact.environment - missing).max() <= 3 * exact.openness.error.max()
    closed = radiosity.form_factors(mesh_of([FLOOR, ceiling(gap)]), 1e-3)
    assert closed.exchange[0, 1] == pytest.approx(exact.exchange[0, 1], abs=1e-12)
    assert closed.environment == pytest.approx(np.full(2, missing), rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_a_closed_room_with_a_thin_slab_on_its_floor_stays_closed(seed):
    """So thin that rays from beneath start beyond it; blocks leave the rows some defect."""
    rng = np.random.default_rng(seed)
    corner = rng.uniform(0.1, 0.5, 2)
    slab = block(
        (*corner, 0), (*(corner + rng.uniform(0.1, 0.4, 2)), 10 ** rng.uniform(-5.3, -4.7))
    )
    room, blocks = divided(box((0, 0, 0), (1, 1, 1)), 3), []
    for low in rng.uniform(0.05, 0.7, (6, 3)) * [1, 1, 0.8] + [0, 0, 0.1]:
        blocks += [*block(low, low + rng.uniform(0.03, 0.2, 3))]
    found = radiosity.form_factors(mesh_of([*room, *slab, *blocks]), 1e-2)
    assert found.is_closed and np.all(found.environment == 0)
    assert np.abs(found.raw_closure).max() > 1e-6


@pytest.mark.parametrize("width", [1e-3, 1e-4, 3e-5])
def test_slivers_do_not_meet_themselves(width):
    for seed in range(5):
        rng = np.random.default_rng(seed)
        a, b = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
        middle = np.full(3, 0.5)
        corners = [*box((0, 0, 0), (1, 1, 1)).reshape(-1, 3), middle - 0.3 * a, middle + 0.3 * a,
                   middle + width * b]  # fmt: skip
        faces = [*np.arange(24).reshape(6, 4).tolist(), [24, 25, 26]]
        found = radiosity.form_factors((np.array(corners), faces), 1e-3, repair=False)
        assert found.openness.share[6] == 0


def test_no_light_is_negative_and_bars_reach_what_was_cut_off():
    """At the foot of the Cornell box's short block lines through a steep rise fall below 0."""
    solution = radiosity.solve(radiosity.load(SCENES / "cornell_box.toml"), 0.02)
    point = [[209.221, 0.0322, 89.262], [278.0, 0.0, 40.0]]
    normal = [[0.29283, 0, -0.95617], [0, 1, 0]]
    found, error = solution.irradiance(point, normal)
    raw = solution.level.gathered(np.array(point), np.array(normal)).total
    assert raw[0].min() < -1e-3 and raw[1].min() > 0.0
    assert np.array_equal(found, np.maximum(raw, 0.0))
    assert np.all(error[0] > -raw[0])
