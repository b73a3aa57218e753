"""What rows send to no row: closed forms within the estimate, and exactly nothing where due."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, faces_of, l_room, meshed, rotation, uv_sphere

from radiosity.analytic import point_to_parallel_rectangle
from radiosity.transport.environment import measure_openness
from radiosity.transport.factors import form_factors

OPPOSITE = np.stack([SQUARE, SQUARE[::-1] + [0, 0, 1.0]])
F12 = 0.19982489569838738  # Howell C-11: verification/vf_obstructed.json, `unobstructed`
NOISE = 0.01  # of a share of 4096 rays at least: random ones would err by 0.008
ROOM = box((0, 0, 0), (1, 1, 1))
WITHOUT_LID = ROOM[[0, 2, 3, 4, 5]]


def openness_of(polygons, n=1, accuracy=1e-3, live=None, backs=None, seed=0):
    """Return the openness of patches, and these."""
    visibility, _, patches = meshed(faces_of(polygons), n)
    if backs is not None:
        patches = patches.with_backs(np.isin(patches.face, backs))
    live = ~patches.covered[: patches.fronts] if live is None else live(patches)
    live = np.concatenate([live, np.ones(len(patches) - len(live), bool)])
    return measure_openness(patches, visibility, live, accuracy, seed), patches


def to_the_lid(centroids):
    """Return the factor from points of the floor to the open lid of the unit cube (B-3)."""
    x, y = centroids[:, 0], centroids[:, 1]
    return sum(point_to_parallel_rectangle(a, b, 1.0) for a in (x, 1 - x) for b in (y, 1 - y))


# ------------------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("room", [ROOM, ROOM * 1000 + 1e5], ids=["near", "far"])
def test_no_ray_slips_through_a_corner(room):
    """Those from the edges of a closed room stay inside; with these seeds some start there."""
    _, _, cells = meshed(faces_of(room), 16)
    for seed in (308, 346, 412, 535, 551, 624, 1170, 1555):
        found, _ = openness_of(cells.vertices, 1, accuracy=0.1, seed=seed)
        assert np.all(found.share == 0) and np.all(found.error == 0)


@pytest.mark.parametrize("corners", [[0, 1, 2, 2], [0, 1, 3, 3], [0, 1, 2, 3]])
def test_rays_start_evenly_on_any_shape(corners):
    """What two faces do not send to each other leaves: 1 - F, for triangles and a trapezoid."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.7, 1, 0]], float)
    polygons = np.stack([square[corners], SQUARE[::-1] + [0, 1.0, 0.5]])
    found, patches = openness_of(polygons)
    visibility, _, _ = meshed(faces_of(polygons), 1)
    F = form_factors(patches, visibility, np.ones(2, bool), 1e-9).toarray()
    assert np.all(np.abs(found.share - (1 - F.sum(axis=1))) < 3 * found.error)


@pytest.mark.parametrize("accuracy", [0.1, 0.01, 1e-3])
def test_parallel_squares_see_the_rest_outside(accuracy):
    found, _ = openness_of(OPPOSITE, accuracy=accuracy)
    assert np.all(np.abs(found.share - (1 - F12)) < 2 * found.error)
    assert np.all(found.error <= accuracy)  # 2 rows: no scene has more rays a row
    assert np.all(found.error < 4e-3) and np.all(found.absorbed == 0)


def test_estimates_are_honest():
    """A box without lid: errors against closed forms, over many rows and seeds."""
    floor, ratio = None, []
    for seed in range(4):
        found, patches = openness_of(WITHOUT_LID, 5, 0.01, seed=seed)
        floor = np.flatnonzero(patches.face == 0)
        x = np.linspace(-0.1, 0.1, 21)[1::2] * 0.955  # midpoints of cells of 1/5, 10 x 10
        grid = np.stack(np.meshgrid(x, x, [0.0], indexing="ij"), -1).reshape(-1, 3)
        exact = np.array([to_the_lid(c + grid).mean() for c in patches.centroid[floor]])
        ratio.append((found.share[floor] - exact) / found.error[floor])
    ratio = np.array(ratio)
    assert 0.2 < np.sqrt(np.mean(ratio**2)) < 1  # neither too small nor by saying "anything"
    assert np.abs(ratio).max() < 3
    assert abs(ratio.mean()) < 0.3  # 100 of them: no bias


def test_estimates_of_small_shares_are_honest():
    """Small sheets in a closed room: what its exact rows lack is what the rays should find."""
    rng, ratio = np.random.default_rng(3), []
    for _ in range(24):
        sheet = 0.1 * SQUARE @ rotation(rng).T + rng.uniform(0.3, 0.7, 3)
        visibility, _, patches = meshed(faces_of(np.concatenate([ROOM, sheet[None]])), 1)
        found = form_factors(patches, visibility, np.asarray(patches.face < 6), 1e-3)
        live = np.flatnonzero(found.openness.share > 0)
        assert len(live) == 6 and found.openness.share.max() < 0.04
        ratio.append(found.closure[live] / found.openness.error[live])
    assert 0.5 < np.sqrt(np.mean(np.square(ratio))) < 1
    assert np.abs(ratio).max() < 3.5  # of 144


def test_errors_fall_with_the_accuracy_asked():
    found = [openness_of(WITHOUT_LID, 14, a)[0] for a in (0.1, 0.01)]
    asked = [f.error[f.share > 0] for f in found]
    assert asked[0].max() <= 0.1 and asked[1].max() <= 0.01
    assert asked[1].max() < asked[0].max() / 2  # in a mesh so fine that few rays are the start


def test_a_convex_body_sees_nothing_but_the_outside():
    found, _ = openness_of(block((0, 0, 0), (1, 2, 3)), 2)
    assert np.all(found.share == 1) and np.all(found.absorbed == 0)


# ------------------------------------------------------------------------------- exactly nothing

ROOMS = {
    "box": ROOM,
    "block": np.concatenate([ROOM, block((0.3, 0.2, 0), (0.7, 0.6, 0.5))]),
    "l_room": l_room(),
    "sphere": uv_sphere(6),
}


@pytest.mark.parametrize("name", ROOMS)
@pytest.mark.parametrize("gap", [0.1, 1e-4])
def test_a_closed_room_sends_nothing_elsewhere(name, gap):
    """Not to the outside and not to a shell around it, whose rows are none."""
    rng, room = np.random.default_rng(1), ROOMS[name]
    shell = box(room.min(axis=(0, 1)) - gap, room.max(axis=(0, 1)) + gap)
    for size, offset in ((1.0, 0.0), (1e-3, 0.0), (1e3, 0.0), (1.0, 1e4)):
        turn = np.eye(3) if size == 1.0 else rotation(rng)
        polygons = size * np.concatenate([room, shell]) @ turn.T + offset
        found, patches = openness_of(polygons, 2, live=lambda p: ~p.covered & (p.face < len(room)))
        assert np.all(found.share == 0) and np.all(found.error == 0)
        assert np.all(found.absorbed == 0)


# ------------------------------------------------------------------------------- what absorbs


def test_a_sheet_that_is_no_row_absorbs():
    """Squares with a sheet that reaches beyond both in the middle: all F12 ends there."""
    sheet = 40 * (SQUARE - [0.5, 0.5, 0]) + [0.5, 0.5, 0.5]
    found, _ = openness_of(np.concatenate([OPPOSITE, sheet[None]]), live=lambda p: p.face != 2)
    assert np.all(found.share[:2] == 1) and np.all(found.absorbed[:2] > 0.998)
    assert found.share[2] == 0  # no row


def test_a_small_sheet_absorbs_what_meets_it():
    """A square as large as the other, half way: C-11 again, at distance 0.5."""
    found, _ = openness_of(
        np.concatenate([OPPOSITE, SQUARE[None] + [0, 0, 0.5]]), live=lambda p: p.face != 2
    )
    nearer = 0.41525329  # Howell C-11 with X = Y = 2
    assert found.absorbed[:2] == pytest.approx(nearer, abs=NOISE)
    assert np.all(found.share[:2] == 1)  # none gets past it to the other


def test_backs_without_rows_absorb_and_with_rows_do_not():
    """The lower square sees the back of a sheet; with that a row, its share is missing."""
    polygons = np.stack([SQUARE, SQUARE + [0, 0, 1.0]])
    one, _ = openness_of(polygons)
    two, _ = openness_of(polygons, backs=[0, 1])
    assert one.share[0] == 1 and one.absorbed[0] == pytest.approx(F12, abs=NOISE)
    assert two.share[0] == pytest.approx(1 - F12, abs=2 * two.error[0])
    assert two.absorbed[0] == 0
    assert len(two.share) == 4 and two.share[3] == pytest.approx(1 - F12, abs=2 * two.error[3])
    assert np.all(two.share[1:3] == 1)  # outer sides


def test_dead_rows_have_none_and_absorb():
    found, patches = openness_of(ROOM, 2, live=lambda p: p.face != 1)
    dead = patches.face == 1
    assert np.all(found.share[dead] == 0) and np.all(found.absorbed[dead] == 0)
    assert np.all(found.share[~dead] > 0)
    assert np.array_equal(found.share[~dead], found.absorbed[~dead])


# ------------------------------------------------------------------------------- invariances


def test_turning_and_scaling_change_only_noise():
    one, _ = openness_of(WITHOUT_LID, 2, 0.01)
    turn = rotation(np.random.default_rng(2))
    for size, offset in ((1e-6, 0.0), (1e6, 0.0), (1.0, 1e4)):
        other, _ = openness_of(size * WITHOUT_LID @ turn.T + offset, 2, 0.01)
        assert np.all(np.abs(one.share - other.share) < 2 * (one.error + other.error))


def test_threads_and_runs_change_no_bit_and_seeds_some(monkeypatch):
    found = []
    for threads, seed in (("1", 0), ("2", 0), ("2", 0), ("2", 1)):
        monkeypatch.setenv("RADIOSITY_THREADS", threads)
        found.append(openness_of(WITHOUT_LID, 6, 0.01, seed=seed)[0])
    for other in found[1:3]:
        assert np.array_equal(found[0].share, other.share)
        assert np.array_equal(found[0].absorbed, other.absorbed)
    assert not np.array_equal(found[0].share, found[3].share)
    apart = np.abs(found[0].share - found[3].share)
    assert np.all(apart < 3 * (found[0].error + found[3].error))


def test_rows_whose_few_rays_all_miss_a_hole_are_not_certain():
    """A small window, from most rows below 1 %: no row fails to close beyond three errors."""
    window = [[[0, 0, 1], [0, 1, 1], [0.4, 1, 1], [0.4, 0, 1]],
              [[0.55, 0, 1], [0.55, 1, 1], [1, 1, 1], [1, 0, 1]],
              [[0.4, 0, 1], [0.4, 0.4, 1], [0.55, 0.4, 1], [0.55, 0, 1]],
              [[0.4, 0.55, 1], [0.4, 1, 1], [0.55, 1, 1], [0.55, 0.55, 1]]]  # fmt: skip
    visibility, _, patches = meshed(faces_of(np.concatenate([WITHOUT_LID, window])), 9)
    for seed in range(3):
        found = form_factors(patches, visibility, np.ones(len(patches), bool), 0.01, seed)
        unexplained = np.abs(found.closure) - 3 * found.openness.error - found.row_errors()
        assert unexplained.max() < 0.5 * 0.01  # 0.9 where such rows were certain of 0
