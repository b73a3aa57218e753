"""Exchange past blockers: against a plain twin, closed forms, its own estimate; exact ends."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, faces_of, rotation

from radiosity.analytic import load_cases
from radiosity.transport.exchange import exchange_area, load_fronts, make_geometry, make_room
from radiosity.transport.partial import partial_exchange
from radiosity.transport.polygon import bilinear
from radiosity.transport.shadow import Shadows, make_shade, visible_factor
from radiosity.transport.visibility import Visibility

BELOW, ABOVE = SQUARE, SQUARE[::-1] + [0, 0, 1.0]
HULL = 8 * (SQUARE - [0.5, 0.5, 0]) + [0, 0, -4], 8 * (SQUARE - [0.5, 0.5, 0]) + [0, 0, 4]
WALL = np.array([[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]], float)[::-1]


def sheet(low, high, z):
    (x, y), (X, Y) = low, high
    return np.array([[x, y, z], [X, y, z], [X, Y, z], [x, Y, z]], float)


class Pair:
    """Polygons 0 and 1 of a scene, all others between them, in a hull that makes them block."""

    def __init__(self, p, q, *between):
        faces = faces_of(np.array([p, q, *between, *HULL]))
        self.visibility = Visibility(faces)
        local = (faces.vertices - self.visibility.centre) * self.visibility.scale
        self.geometry = make_geometry(
            local, faces.normals(), local.mean(axis=1),
            faces.areas() * self.visibility.scale**2, self.visibility.grain,
        )  # fmt: skip
        near = np.abs(self.visibility.blockers.corners).max(axis=(1, 2)) < 0.9
        self.active = np.flatnonzero(near & self._is_between(between))

    def _is_between(self, between):
        scale, centre = self.visibility.scale, self.visibility.centre
        middles = [(np.mean(b, axis=0) - centre) * scale for b in between]
        corners, count = self.visibility.blockers.corners, self.visibility.blockers.count
        own = np.array([corners[b, : count[b]].mean(axis=0) for b in range(len(count))])
        return np.array([any(np.allclose(o, m) for m in middles) for o in own], bool)

    def shadows(self, active, x):
        return Shadows(
            self.visibility.blockers, active, self.geometry.grain.max(), make_shade(), x, False
        )

    def exchange(self, tolerance, i=0, j=1, order=None):
        """Return visible share, its error and the unoccluded exchange, all as shares of this."""
        room = make_room()
        whole, _ = exchange_area(self.geometry, i, j, 1e-12, room)
        counts = load_fronts(self.geometry, i, j, room)[:2]
        active = self.active if order is None else self.active[order]
        shadows = self.shadows(active, room.x)
        seen, error = partial_exchange(
            self.geometry, i, j, *counts, whole, tolerance, shadows, room
        )
        return seen / whole, error / whole

    def plain_share(self, n=160, i=0, j=1):
        """The slow twin: visible and unoccluded factors summed over n x n points of polygon i."""
        g, x = self.geometry, np.empty(3)
        some, none = self.shadows(self.active, x), self.shadows(self.active[:0], x)
        seen = whole = 0.0
        for s in (np.arange(n) + 0.5) / n:
            for t in (np.arange(n) + 0.5) / n:
                w = bilinear(g.vertices[i], s, t, x)
                args = x, g.normal[i], g.vertices[j]
                seen += w * visible_factor(*args, some)[0]
                whole += w * visible_factor(*args, none)[0]
        return seen / whole


def random_pair(rng, count):
    """Squares that face each other at random angles with random sheets in the middle."""
    turn = rotation(rng)
    if turn[2, 2] < 0.6:
        return random_pair(rng, count)
    sheets = [(SQUARE - [0.5, 0.5, 0]) * rng.uniform(0.1, 0.7) @ rotation(rng).T
              + rng.uniform((0.2, 0.2, 0.35), (0.8, 0.8, 1.0)) for _ in range(count)]  # fmt: skip
    return Pair(BELOW, (ABOVE - [0.5, 0.5, 0]) @ turn.T + [0.5, 0.5, 0.9], *sheets)


# ------------------------------------------------------------------------------- the twin


@pytest.mark.parametrize("count", [1, 2, 5])
def test_it_agrees_with_the_plain_twin(count):
    rng, partly = np.random.default_rng(count), 0
    for _ in range(5):
        pair = random_pair(rng, count)
        assert len(pair.active) == count
        expected = pair.plain_share()
        share, error = pair.exchange(1e-4)
        assert abs(share - expected) < max(error, 1e-4)  # 160 x 160 midpoints: 2e-5
        partly += 0.05 < share < 0.95
    assert partly >= 2


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2, 1e-3, 1e-4])
def test_errors_keep_the_tolerance_and_the_estimate(tolerance):
    """Against 1e-6, over random pairs: nearly all below the estimate, none above the asked."""
    rng, inside, used = np.random.default_rng(11), [], []
    for _ in range(40):
        pair = random_pair(rng, rng.integers(1, 4))
        share, error = pair.exchange(tolerance)
        wrong = abs(share - pair.exchange(1e-6)[0])
        assert wrong <= tolerance
        inside.append(wrong <= error + 1e-6)
        used.append(error)
    assert np.mean(inside) >= 0.95
    assert np.max(used) <= tolerance


CASES = [c for c in load_cases("vf_obstructed") if "A1" in c["geometry"]]


@pytest.mark.parametrize("case", CASES, ids=lambda c: c["id"])
def test_closed_forms_from_either_side(case):
    g = case["geometry"]
    pair = Pair(g["A1"], g["A2"], *g["blockers"])
    whole, _ = exchange_area(pair.geometry, 0, 1, 1e-12, make_room())
    exact = case["value"] * pair.geometry.area[0] / whole
    for i, j in ((0, 1), (1, 0)):
        for tolerance in (1e-3, 1e-5):
            share, error = pair.exchange(tolerance, i, j)
            assert share == pytest.approx(exact, abs=tolerance)
            assert abs(share - exact) <= error + 1e-9


# ------------------------------------------------------------------------------- exact ends


def test_without_shadow_the_exchange_is_whole_to_the_bit():
    aside = sheet((1.5, 0), (2, 1), 0.5)
    for p, q in ((BELOW, ABOVE), (BELOW, WALL)):
        pair = Pair(p, q, aside)
        assert len(pair.active) == 1
        share, error = pair.exchange(1e-3)
        assert share == 1 and error == 0


@pytest.mark.parametrize("turned", [False, True])
def test_tiles_that_cover_leave_exactly_nothing(turned):
    """No tile covers the shaft alone, all together do."""
    rng = np.random.default_rng(1)
    for _ in range(10):
        turn = rotation(rng) if turned else np.eye(3)
        cut = rng.uniform(0.2, 0.8)
        tiles = [sheet((-0.5, -0.5), (cut, 1.5), 0.5), sheet((cut, -0.5), (1.5, 1.5), 0.5)]
        faces = [x @ turn.T for x in (BELOW, ABOVE, *tiles)]
        pair = Pair(*faces)
        if len(pair.active) == 2:  # else the two are one facet, which hides the pair by itself
            assert pair.exchange(1e-2) == (0.0, 0.0)


def corner():
    """Return a floor and a wall with a screen across their corner, and the exact visible share.

    Below the screen strip sees strip, above it the rest sees the rest, and nothing else.
    """
    screen = np.array([[0.9, 0, 0], [1, 0, 0.1], [1, 1, 0.1], [0.9, 1, 0]])
    floor = [sheet((0, 0), (0.9, 1), 0), sheet((0.9, 0), (1, 1), 0)]
    wall = [np.array([[1, 0, a], [1, 0, b], [1, 1, b], [1, 1, a]]) for a, b in ((0.1, 1), (0, 0.1))]
    parts = [unoccluded(p, q) for p, q in zip(floor, wall, strict=True)]
    return Pair(BELOW, WALL, screen), sum(parts) / unoccluded(BELOW, WALL)


def unoccluded(p, q):
    pair = Pair(p, q)
    return exchange_area(pair.geometry, 0, 1, 1e-12, make_room())[0] / pair.visibility.scale**2


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_a_screen_across_a_corner(tolerance):
    """The kernel is singular where the screen hides most of it."""
    pair, exact = corner()
    for i, j in ((0, 1), (1, 0)):
        share, error = pair.exchange(tolerance, i, j)
        assert abs(share - exact) <= min(error, tolerance)


def test_asking_for_more_never_gives_less():
    pair, exact = corner()
    errors = [abs(pair.exchange(t)[0] - exact) for t in (1e-4, 1e-5, 1e-6)]
    assert max(errors) <= 1e-4


# ------------------------------------------------------------------------------- invariances


def test_order_and_side_of_blockers_do_not_matter():
    rng = np.random.default_rng(4)
    for _ in range(10):
        pair = random_pair(rng, 4)
        one, _ = pair.exchange(1e-4)
        other, _ = pair.exchange(1e-4, order=rng.permutation(4))
        assert other == pytest.approx(one, abs=1e-11)  # rounding; cells could be divided otherwise
        assert pair.exchange(1e-4, 1, 0)[0] == pytest.approx(one, abs=2e-4)


def test_what_one_hides_and_what_both_hide():
    """Sheets side by side in full view: what they hide adds up; one behind another adds less."""
    one, two = sheet((0.1, 0.1), (0.4, 0.9), 0.5), sheet((0.6, 0.1), (0.9, 0.9), 0.5)
    hidden = [1 - Pair(BELOW, ABOVE, *s).exchange(1e-5)[0] for s in ((one,), (two,), (one, two))]
    assert hidden[0] == pytest.approx(hidden[1], abs=2e-5)  # mirror images
    assert hidden[2] == pytest.approx(hidden[0] + hidden[1], abs=3e-5)  # the tolerance of three
    under = one + [0, 0, -0.2]
    both = 1 - Pair(BELOW, ABOVE, one, under).exchange(1e-5)[0]
    assert hidden[0] + 0.01 < both < 2 * hidden[0] - 0.01
