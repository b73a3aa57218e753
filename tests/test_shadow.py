"""The part of a polygon seen past blockers: dense sampling, and exactly nothing where due."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, rotation

from radiosity.transport.blockers import Blockers
from radiosity.transport.polygon import area_of, point_factor
from radiosity.transport.shadow import (
    OVERFLOW,
    Shadows,
    kept_within,
    make_shade,
    visible_factor,
)

GRAIN = 1e-15  # of coordinates about 1
TARGET = SQUARE[::-1] + [-0.5, -0.5, 1.0]  # above the origin, looking down
UP = np.array([0.0, 0.0, 1.0])


def blockers_of(polygons):
    """Return the kernel's blockers, whether or not they lie on the hull; no tree."""
    k = len(polygons)
    corners, count, normal = np.empty((k, 8, 3)), np.empty(k, np.int64), np.empty((k, 3))
    for m, polygon in enumerate(polygons):
        polygon = np.asarray(polygon, float)
        corners[m] = polygon[np.minimum(np.arange(8), len(polygon) - 1)]
        count[m] = len(polygon)
        across = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
        normal[m] = across / np.linalg.norm(across)
    boxes, alone = (np.zeros((2, 3)), np.ones((2, 3))), np.full((k, 8), -1)
    return Blockers(corners, count, normal, np.zeros(k, int), alone, np.zeros(k), *boxes, 1)


def seen(x, polygons, target=TARGET, normal=UP, order=None):
    """Return (visible factor, whether anything is taken away)."""
    order = np.arange(len(polygons)) if order is None else np.asarray(order)
    x, order = np.asarray(x, float), order.astype(np.int64)
    shadows = Shadows(blockers_of(polygons), order, GRAIN, make_shade(), x, False)
    return visible_factor(x, normal, target, shadows)


def whole(x, target=TARGET, normal=UP):
    return point_factor(*x, *normal, target)


def passes_through(polygon, x, y):
    """Whether the segments from x (3,) to y (k, 3) pass through a convex polygon."""
    normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
    hx, hy = (x - polygon[0]) @ normal, (y - polygon[0]) @ normal
    t = hx / np.where(hx == hy, 1.0, hx - hy)
    at = x + t[:, None] * (y - x)
    inside = hx * hy < 0
    for k in range(len(polygon)):
        edge = polygon[(k + 1) % len(polygon)] - polygon[k]
        inside &= np.cross(edge, at - polygon[k]) @ normal > 0
    return inside


def plain_factor(x, polygons, n=250):
    """The slow twin: the sum of cos cos' V/(pi r^2) over n x n cells of the target."""
    s = (np.arange(n) + 0.5) / n
    a, b, _, d = TARGET
    y = (a + s[:, None, None] * (b - a) + s[None, :, None] * (d - a)).reshape(-1, 3)
    free = np.ones(len(y), bool)
    for polygon in polygons:
        free &= ~passes_through(polygon, x, y)
    r = y - x
    return np.sum(free * r[:, 2] ** 2 / (np.pi * np.sum(r * r, axis=1) ** 2)) / n**2


def random_polygon(rng, corners):
    """Return a convex polygon somewhere between the origin and the target."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    place = rng.uniform((-0.2, -0.2, 0.3), (0.2, 0.2, 0.8))
    return ring * rng.uniform(0.1, 0.4, 3) @ rotation(rng).T + place


def screen_of(strips, rng, z=0.5):
    """Return rectangles that tile a screen of 2 x 2 which hides the target."""
    cut = np.concatenate([[-1.0], np.sort(rng.uniform(-0.4, 0.4, strips - 1)), [1.0]])
    return [np.array([[a, -1, z], [b, -1, z], [b, 1, z], [a, 1, z]]) for a, b in
            zip(cut[:-1], cut[1:], strict=True)]  # fmt: skip


# ------------------------------------------------------------------------------- the twin


@pytest.mark.parametrize("corners", [3, 4, 6, 8])
@pytest.mark.parametrize("many", [1, 3, 8])
def test_it_agrees_with_dense_sampling(corners, many):
    rng = np.random.default_rng(10 * corners + many)
    partly = 0
    for _ in range(6):
        polygons = [random_polygon(rng, corners) for _ in range(many)]
        x = rng.uniform((-0.4, -0.4, 0.0), (0.4, 0.4, 0.2))
        found, touched = seen(x, polygons)
        expected = plain_factor(x, polygons)
        # 250 x 250 cells, of which edges cut some hundred at random; reached 7e-5
        assert found == pytest.approx(expected, abs=3e-4)
        assert touched or found == whole(x)
        partly += touched and found > 0.01
    assert partly >= 3


def test_nothing_active_leaves_the_exact_factor():
    x = np.array([0.1, -0.2, 0.0])
    found, touched = seen(x, screen_of(3, np.random.default_rng(0)), order=[])
    assert found == whole(x) and not touched


# ------------------------------------------------------------------------------- exactly nothing


@pytest.mark.parametrize("strips", [1, 2, 5, 31])
@pytest.mark.parametrize("turned", [False, True])
def test_tiles_of_a_screen_hide_exactly(strips, turned):
    rng = np.random.default_rng(strips)
    for _ in range(10):
        turn = rotation(rng) if turned else np.eye(3)
        tiles = [tile @ turn.T for tile in screen_of(strips, rng)]
        x = rng.uniform((-0.4, -0.4, 0.0), (0.4, 0.4, 0.3)) @ turn.T
        found, touched = seen(x, tiles, TARGET @ turn.T, turn @ UP)
        assert touched and found == 0.0


def test_a_folded_screen_hides_exactly():
    """Tiles that meet at a ridge, at random angles."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        ridge = np.array([[rng.uniform(-0.3, 0.3), y, rng.uniform(0.3, 0.8)] for y in (-2, 2)])
        left = np.array([[-2, -2, 0.4], ridge[0], ridge[1]])
        right = np.array([ridge[0], [2, -2, 0.6], ridge[1]])
        more = [np.array([[-2, -2, 0.4], ridge[1], [-2, 2, 0.4]]),
                np.array([ridge[1], [2, -2, 0.6], [2, 2, 0.6]])]  # fmt: skip
        found, _ = seen(rng.uniform((-0.4, -0.4, 0), (0.4, 0.4, 0.1)), [left, right, *more])
        assert found == 0.0


def test_a_slit_between_tiles_is_seen():
    """Tiles a hair apart: the slit is seen and by its width, so that the zeros above are earned."""
    x = np.array([0.0, 0.0, 0.0])
    for width in (1e-3, 1e-6, 1e-9):
        tiles = [
            np.array([[-1, -1, 0.5], [0, -1, 0.5], [0, 1, 0.5], [-1, 1, 0.5]]),
            np.array([[width, -1, 0.5], [1, -1, 0.5], [1, 1, 0.5], [width, 1, 0.5]]),
        ]
        strip = np.array([[0, 0.5, 1], [2 * width, 0.5, 1], [2 * width, -0.5, 1], [0, -0.5, 1]])
        # 1e-6: a slit of 1e-9 has sides to 1e-16
        assert seen(x, tiles)[0] == pytest.approx(whole(x, strip), rel=1e-6)


# ------------------------------------------------------------------------------- invariances


def test_the_order_of_blockers_does_not_matter():
    rng = np.random.default_rng(5)
    for _ in range(20):
        polygons = [random_polygon(rng, 5) for _ in range(6)]
        x = rng.uniform((-0.4, -0.4, 0.0), (0.4, 0.4, 0.2))
        found = [seen(x, polygons, order=rng.permutation(6))[0] for _ in range(4)]
        assert found == pytest.approx([found[0]] * 4, abs=1e-12)  # rounding of Lambert's sums


def test_the_winding_of_blockers_does_not_matter():
    rng = np.random.default_rng(6)
    for _ in range(20):
        polygons = [random_polygon(rng, 5) for _ in range(3)]
        x = rng.uniform((-0.4, -0.4, 0.0), (0.4, 0.4, 0.2))
        other = [p[::-1] for p in polygons]
        assert seen(x, other)[0] == pytest.approx(seen(x, polygons)[0], abs=1e-12)  # as above


def test_parts_of_a_target_add_up():
    rng = np.random.default_rng(7)
    for _ in range(20):
        polygons = [random_polygon(rng, 5) for _ in range(4)]
        x = rng.uniform((-0.4, -0.4, 0.0), (0.4, 0.4, 0.2))
        a, b, c, d = TARGET
        s, t = rng.uniform(0.2, 0.8, 2)
        one, two = a + s * (b - a), d + t * (c - d)
        parts = [seen(x, polygons, np.array(q))[0] for q in ([a, one, two, d], [one, b, c, two])]
        assert sum(parts) == pytest.approx(seen(x, polygons)[0], abs=1e-12)  # as above


def test_shadows_side_by_side_add_up():
    x = np.array([0.05, 0.1, 0.0])
    one, two = (0.2 * (SQUARE - 0.5) + [side, 0, 0.5] for side in (-0.15, 0.2))
    hidden = [whole(x) - seen(x, p)[0] for p in ([one], [two], [one, two])]
    assert min(hidden) > 0.01
    assert hidden[0] + hidden[1] == pytest.approx(hidden[2], abs=1e-14)


def test_one_behind_another_takes_nothing_more():
    x = np.array([0.0, 0.0, 0.0])
    near, far = 0.4 * (SQUARE - 0.5) + [0, 0, 0.6], 0.3 * (SQUARE - 0.5) + [0, 0, 0.9]
    near[:, 2], far[:, 2] = 0.4, 0.75
    alone = seen(x, [near])[0]
    for order in ([0, 1], [1, 0]):
        assert seen(x, [near, far], order=order)[0] == pytest.approx(alone, abs=1e-14)


def test_turning_and_scaling_change_nothing():
    rng = np.random.default_rng(8)
    for size in (1e-2, 1.0):
        polygons = [random_polygon(rng, 6) for _ in range(4)]
        x, turn = rng.uniform((-0.4, -0.4, 0.0), (0.4, 0.4, 0.2)), rotation(rng)
        other = seen(
            size * turn @ x,
            [size * p @ turn.T for p in polygons],
            size * TARGET @ turn.T,
            turn @ UP,
        )
        assert other[0] == pytest.approx(seen(x, polygons)[0], abs=1e-12)  # as above


# ------------------------------------------------------------------------------- what cannot block


def test_what_lies_behind_takes_nothing_away():
    x = np.array([0.1, 0.1, 0.0])
    for z in (1.2, -0.3):  # behind the target, behind the point
        found, touched = seen(x, [4 * (SQUARE - 0.5) + [0, 0, z + 2]])
        assert found == whole(x) and not touched


def test_what_only_touches_takes_nothing_away():
    x = np.array([0.1, 0.1, 0.0])
    upright = np.array([[0.5, -0.5, 1], [0.5, 0.5, 1], [0.5, 0.5, 2], [0.5, -0.5, 2]])
    in_its_plane = SQUARE + [0.5, -0.5, 1.0]
    on_the_target = TARGET[::-1]
    edge_on = np.array([[0.1, -1, 0.2], [0.1, 1, 0.2], [0.1, 1, 0.8], [0.1, -1, 0.8]])
    for polygon in (upright, in_its_plane, on_the_target, edge_on):
        assert seen(x, [polygon])[0] == pytest.approx(whole(x), abs=1e-15)


def test_a_blocker_that_reaches_through_the_point_s_plane():
    """Half of it lies behind the point; the cone of its edges is one all the same."""
    x = np.array([0.0, 0.0, 0.0])
    wall = np.array([[0.1, -3, -1], [0.1, 3, -1], [0.1, 3, 5], [0.1, -3, 5.0]])
    left = np.array([[-0.5, 0.5, 1], [0.1, 0.5, 1], [0.1, -0.5, 1], [-0.5, -0.5, 1.0]])
    assert seen(x, [wall])[0] == pytest.approx(whole(x, left), abs=1e-14)
    assert plain_factor(x, [wall]) == pytest.approx(whole(x, left), abs=1e-3)


def test_a_lattice_is_right_or_given_up():
    """16 bars across 16: 289 openings, each seen for itself, or OVERFLOW, never another number."""
    edges = np.linspace(-0.5, 0.5, 34)[1:-1].reshape(16, 2) * 0.5
    bars = [np.array([[a, -2, 0.5], [b, -2, 0.5], [b, 2, 0.5], [a, 2, 0.5]]) for a, b in edges]
    bars += [bar[:, [1, 0, 2]] for bar in bars]
    x = np.array([0.01, 0.02, 0.0])
    found, _ = seen(x, bars)
    assert found == OVERFLOW or found == pytest.approx(plain_factor(x, bars), abs=5e-4)
    some, _ = seen(x, bars[:4] + bars[16:20])
    few = bars[:4] + bars[16:20]
    assert some == pytest.approx(plain_factor(x, few), abs=5e-4)  # as for random blockers


@pytest.mark.parametrize("turns", range(3))
def test_what_planes_keep_of_a_polygon_has_the_area_of_its_part(turns):
    turn = rotation(np.random.default_rng(turns)) if turns else np.eye(3)
    square, shift = SQUARE @ turn.T, 0.5 * turn[:, 0]

    def area(*planes):
        kept = kept_within(square, np.array(planes), make_shade())
        return area_of(kept) if len(kept) else 0.0

    right, slant = turn[:, 0], (turn[:, 0] + turn[:, 1]) / np.sqrt(2)
    assert area([*right, right @ shift]) == pytest.approx(0.5, rel=1e-14)
    assert area([*right, right @ shift], [*turn[:, 1], 0.25]) == pytest.approx(0.125, rel=1e-14)
    assert area([*slant, np.sqrt(0.5)]) == pytest.approx(0.5, rel=1e-14)
    assert area([*right, 2.0]) == pytest.approx(1.0, rel=1e-14)
    assert area([*right, -1.0]) == 0.0
