"""Form factors between patches: closed forms, blockers, reciprocity, closure, any thread count."""

import numpy as np
import pytest
from scenes_for_tests import (
    SQUARE,
    block,
    box,
    faces_of,
    l_room,
    meshed,
    rotation,
    tetrahedron,
)

from radiosity.analytic import box_form_factors
from radiosity.transport.factors import form_factors
from radiosity.transport.occlusion import seen_share
from radiosity.transport.survey import survey

OPPOSITE = np.stack([SQUARE, SQUARE[::-1] + [0, 0, 1.0]])


def factors_of(polygons, n, rays=64, seed=0, convex=None):
    faces = faces_of(polygons)
    visibility, _, patches = meshed(faces, n)
    if convex is not None:
        visibility.convex = convex
    live = ~patches.covered
    return form_factors(patches, visibility, live, rays, seed), patches


def between(factors, patches, i, j):
    """F from face i to face j, the patches' exchange areas summed."""
    block = factors.exchange[patches.face == i][:, patches.face == j]
    return block.sum() / factors.area[patches.face == i].sum()


def table(factors, patches):
    m = patches.face.max() + 1
    return np.array([[between(factors, patches, i, j) for j in range(m)] for i in range(m)])


@pytest.mark.parametrize("dims", [(1, 1, 1), (4, 3, 2.5), (2, 3, 4)])
@pytest.mark.parametrize("n", [1, 3])
def test_boxes_have_the_exact_factors(dims, n):
    found = table(*factors_of(box((0, 0, 0), dims), n))
    # 1e-6: touching pairs by 16 graded Gauss points an edge; reached 2e-9 and 6e-9
    assert found == pytest.approx(box_form_factors(dims), abs=1e-6)


def test_rows_of_a_closed_convex_room_add_up_to_1():
    for polygons in (box((0, 0, 0), (4, 3, 2.5)), tetrahedron()):
        factors, _ = factors_of(polygons, 4)
        assert factors.row_sums() == pytest.approx(1.0, abs=1e-6)  # as above


def test_rays_take_nothing_away_where_nothing_stands():
    """A convex room with shadow rays forced on: not one of them may be blocked by the walls."""
    for size in (1e-3, 1.0, 1e3):
        turn = rotation(np.random.default_rng(0))
        room = size * (box((0, 0, 0), (4, 3, 2.5)) @ turn.T + 2)
        without, _ = factors_of(room, 4)
        forced, _ = factors_of(room, 4, rays=16, convex=False)
        assert np.array_equal(forced.exchange, without.exchange)


def test_factors_are_reciprocal_and_positive():
    factors, patches = factors_of(np.concatenate([l_room(), 0.3 * SQUARE[None] + 0.4]), 3, 16)
    assert np.array_equal(factors.exchange, factors.exchange.T)
    assert factors.exchange.min() == 0 and np.all(np.diag(factors.exchange) == 0)
    assert np.array_equal(factors.area, patches.area)


def blocker(low, high, z):
    (x, y), (X, Y) = low, high
    return np.array([[x, y, z], [X, y, z], [X, Y, z], [x, Y, z]], float)


# unit squares at distance 1 with a square between them, to 12 digits by integration over the
# clipped visible part: verification/vf_obstructed.json, walton_shapiro_3_4 (Walton, NISTIR 6925,
# and Shapiro, FACET), mid_s0.5, mid_half_plane, offcentre_third
OBSTRUCTED = {
    "walton_shapiro_3_4": (blocker((0.25, 0.25), (0.75, 0.75), 0.75), 0.11562060213241498),
    "mid_s0.5": (blocker((0.25, 0.25), (0.75, 0.75), 0.5), 0.09950629459898475),
    "mid_half_plane": (blocker((0, 0), (0.5, 1), 0.5), 0.09991244784919356),
    "offcentre_third": (blocker((0.1, 0.5), (0.4, 0.9), 1 / 3), 0.16872425457171986),
}


@pytest.mark.parametrize("name", OBSTRUCTED)
def test_a_blocker_between_squares(name):
    sheet, exact = OBSTRUCTED[name]
    factors, patches = factors_of(np.concatenate([OPPOSITE, sheet[None]]), 6, rays=64)
    # 1296 pairs with 64 rays each, most of them in the penumbra; reached 2e-5 to 1.5e-3
    assert between(factors, patches, 0, 1) == pytest.approx(exact, rel=4e-3)


def test_a_blocker_between_triangles():
    """The squares as two triangles each: points must be even on these too."""
    sheet, exact = OBSTRUCTED["walton_shapiro_3_4"]
    halves = OPPOSITE[:, [[0, 1, 2, 2], [0, 2, 3, 3]]].reshape(4, 4, 3)
    factors, patches = factors_of(np.concatenate([halves, sheet[None]]), 3, rays=64)
    found = np.mean([between(factors, patches, i, 2) + between(factors, patches, i, 3)
                     for i in (0, 1)])  # fmt: skip
    assert found == pytest.approx(exact, rel=1e-2)  # 324 pairs with 64 rays each; reached 3e-3


@pytest.mark.parametrize("grow", ["rays", "mesh"])
def test_blocked_factors_converge(grow):
    """Root mean square over seeds of the error at the Walton-Shapiro blocker."""
    sheet, exact = OBSTRUCTED["walton_shapiro_3_4"]
    polygons = np.concatenate([OPPOSITE, sheet[None]])
    errors = []
    for k in range(3):
        n, rays = (3, 16 * 8**k) if grow == "rays" else (2 * 2**k, 16)
        found = [
            between(*factors_of(polygons, n, rays, seed), 0, 1) / exact - 1 for seed in range(4)
        ]
        errors.append(np.sqrt(np.mean(np.square(found))))
    # reached .9 to .08 % by rays, 2.8 to .1 % by mesh
    assert errors[0] < 0.04 and errors[-1] < 2e-3
    # random rays would give 64^(1/2) = 8 and 256^(1/2) = 16; reached 11 and 28
    assert errors[0] / errors[-1] > 6


def blocked_by(screen, a, b):
    """Whether the segments from a to b (k, 3) pass through a convex quadrilateral."""
    normal = np.cross(screen[1] - screen[0], screen[3] - screen[0])
    ha, hb = (a - screen[0]) @ normal, (b - screen[0]) @ normal
    through = a + (ha / np.where(ha == hb, 1.0, ha - hb))[:, None] * (b - a)
    inside = ha * hb < 0
    for k in range(4):
        edge = screen[(k + 1) % 4] - screen[k]
        inside &= np.cross(edge, through - screen[k]) @ normal > 0
    return inside


def plain_share(p, q, screen, rng, count=200_000):
    """sum(w V)/sum(w) over random pairs of points, w = cos cos' / r^2, by rejection."""
    ends = []
    for polygon in (p, q):
        low, high = polygon.min(axis=0), polygon.max(axis=0)
        normal = np.cross(polygon[2] - polygon[0], polygon[3] - polygon[1])
        axis = np.argmax(np.abs(normal))
        x = rng.uniform(low, high, (6 * count, 3))
        x[:, axis] -= ((x - polygon[0]) @ normal) / normal[axis]
        keep = np.ones(len(x), bool)
        for k in range(4):
            edge = polygon[(k + 1) % 4] - polygon[k]
            keep &= np.cross(edge, x - polygon[k]) @ normal >= 0
        ends.append((x[keep][:count], normal / np.linalg.norm(normal)))
    (x, np_), (y, nq) = ends
    m = min(len(x), len(y))
    x, y = x[:m], y[:m]
    d = y - x
    r2 = (d * d).sum(axis=1)
    w = np.maximum(d @ np_, 0) * np.maximum(-d @ nq, 0) / r2**2
    return (w * ~blocked_by(screen, x, y)).sum() / w.sum()


SHARES = {
    # floor and wall at right angles: the wall's foot is near and seen at a slant, its top is not
    "slanted": (SQUARE, np.array([[1.2, 0, 0], [1.2, 0, 2], [1.2, 1, 2], [1.2, 1, 0.0]]),
                np.array([[1.1, -1, 0], [1.1, 2, 0], [1.1, 2, 0.8], [1.1, -1, 0.8]])),
    "trapezoid": (np.array([[0, 0, 0], [3, 0, 0], [1.2, 1, 0], [1.0, 1, 0.0]]),
                  np.array([[0, 0, 1], [0, 1, 1], [3, 1, 1], [3, 0, 1.0]]),
                  np.array([[-1, -1, 0.5], [1, -1, 0.5], [1, 2, 0.5], [-1, 2, 0.5]])),
    "triangle": (SQUARE[[0, 1, 2, 2]], np.array([[2, 0, 0], [2, 1, 2], [2, 1, 0], [2, 1, 0.0]]),
                 np.array([[1.5, -1, 0], [1.5, 0.6, 0], [1.5, 0.6, 3], [1.5, -1, 3]])),
}  # fmt: skip


@pytest.mark.parametrize("name", SHARES)
def test_shares_agree_with_their_plain_twin(name):
    """Both cosines, the distance and the area stretch weigh the shadow rays; each way round."""
    p, q, screen = SHARES[name]
    faces = faces_of(np.stack([p, q, screen]))
    visibility, _, patches = meshed(faces, 1)
    sides = patches.vertices, patches.normal
    expected = plain_share(p, q, screen, np.random.default_rng(0))
    assert 0.2 < expected < 0.8
    pairs = np.array([[0, 1], [1, 0]])
    found = seen_share(visibility, pairs, sides, sides, np.arange(3), range(16384), 0)
    # 200,000 random pairs against 16,384 of Sobol; reached 5e-3, most of it the twin's
    assert found == pytest.approx(np.full(2, expected), rel=1e-2)


def test_a_full_screen_lets_nothing_through():
    factors, patches = factors_of(np.concatenate([OPPOSITE, SQUARE[None] + [0, 0, 0.5]]), 4)
    assert between(factors, patches, 0, 1) == 0.0


def test_the_l_room_hides_its_arms():
    """View3D's L-room (Pinney & Bean): verification/vf_obstructed.json, L_room_F, by quadrature.

    Walls 1 and 6 look along the arms, 2 and 5 close them, 3 and 4 meet in the inner corner.
    """
    factors, patches = factors_of(l_room(), 6, rays=32)
    exact = {(4, 5): 0.11315441430358075, (4, 6): 0.3780928977993503, (4, 7): 0.02747340570751167,
             (4, 8): 0.03289024756308783, (4, 9): 0.18235590366859572, (5, 4): 0.33946324291074226,
             (5, 7): 0.0, (5, 8): 0.0, (6, 7): 0.0}  # fmt: skip
    for (i, j), expected in exact.items():
        # 0.5 % of 32 rays a pair in the penumbra
        assert between(factors, patches, i, j) == pytest.approx(expected, rel=5e-3, abs=1e-12)
    assert factors.row_sums() == pytest.approx(1.0, abs=0.05)  # single rows: 32 rays a pair
    mean = np.average(factors.row_sums(), weights=factors.area)
    assert mean == pytest.approx(1.0, abs=2e-3)  # over the room the errors average out


def test_row_sums_and_the_open_share_make_1():
    """A box without lid, in which a block stands: what does not arrive leaves."""
    room = box((0, 0, 0), (1, 1, 1))[[0, 2, 3, 4, 5]]
    polygons = np.concatenate([room, block((0.3, 0.3, 0), (0.6, 0.7, 0.5), bottom=False)])
    faces = faces_of(polygons)
    visibility, table_, patches = meshed(faces, 4)
    sources = np.stack([~patches.covered & (patches.face == 1), np.zeros(len(patches), bool)], 1)
    found = survey(visibility, table_, patches, sources)
    live = found.lit[:, 0]
    factors = form_factors(patches, visibility, live, 64)
    total = factors.row_sums()[live] + found.open_share[live, 0]
    # 256 rays a patch for the open share, 64 for each pair, random ones would err by 0.03
    assert np.sqrt(np.mean((total - 1) ** 2)) < 0.03
    assert np.average(total, weights=patches.area[live]) == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize("polygons", [l_room(), box((0, 0, 0), (1, 2, 3))])
def test_the_number_of_threads_changes_no_bit(polygons, monkeypatch):
    monkeypatch.setenv("RADIOSITY_THREADS", "1")
    one, _ = factors_of(polygons, 5, 16)
    monkeypatch.setenv("RADIOSITY_THREADS", "2")
    two, _ = factors_of(polygons, 5, 16)
    assert np.array_equal(one.exchange, two.exchange)


def test_seeds_change_rays_but_not_the_exact_part():
    one, patches = factors_of(l_room(), 3, 16, seed=1)
    two, _ = factors_of(l_room(), 3, 16, seed=2)
    again, _ = factors_of(l_room(), 3, 16, seed=1)
    assert np.array_equal(one.exchange, again.exchange)
    assert not np.array_equal(one.exchange, two.exchange)
    seen = between(one, patches, 4, 6), between(two, patches, 4, 6)
    assert seen[0] == pytest.approx(seen[1], rel=1e-12)  # these see each other from everywhere


def test_dead_patches_exchange_nothing():
    faces = faces_of(box((0, 0, 0), (1, 1, 1)))
    visibility, _, patches = meshed(faces, 2)
    live = patches.face != 3
    factors = form_factors(patches, visibility, live, 4)
    assert np.all(factors.exchange[~live] == 0) and np.all(factors.exchange[:, ~live] == 0)
    assert between(factors, patches, 0, 1) > 0.19


def test_backs_of_a_sheet_have_factors_of_their_own():
    polygons = np.concatenate([OPPOSITE, blocker((0.25, 0.25), (0.75, 0.75), 0.5)[None]])
    visibility, _, patches = meshed(faces_of(polygons), 2)
    both = patches.with_backs(patches.face == 2)
    factors = form_factors(both, visibility, np.ones(len(both), bool), 16)
    up, down = both.front & (both.face == 2), ~both.front
    floor, ceiling = both.face == 0, both.face == 1
    assert factors.exchange[up][:, ceiling].sum() > 0.1
    below, above = factors.exchange[down][:, floor].sum(), factors.exchange[up][:, ceiling].sum()
    assert below == pytest.approx(above, rel=1e-12)  # mirror images, no ray is blocked
    assert factors.exchange[up][:, floor].sum() == 0 == factors.exchange[down][:, ceiling].sum()


def test_progress_is_told():
    calls = []
    faces = faces_of(l_room())
    visibility, _, patches = meshed(faces, 2)
    form_factors(patches, visibility, ~patches.covered, 4, 0, lambda *call: calls.append(call))
    stages = {c[0] for c in calls}
    assert stages == {"form factors", "visibility"}
    for stage in stages:
        last = [c for c in calls if c[0] == stage][-1]
        assert last[1] == last[2]
