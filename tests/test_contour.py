"""The double contour integral: edge pairs by quadrature and closed form, splits, rounding."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, rotation
from scipy.integrate import quad
from test_exchange import pairs_apart, plain_exchange

from radiosity.analytic import parallel_rectangles
from radiosity.transport.contour import _edge_pair, _log_integral, contour_exchange
from radiosity.transport.rules import GRADED

FINE = GRADED[2]
SCRATCH = np.empty((4, 64))


def edge_pair(p0, p1, q0, q1, tolerance=1e-14, grade=FINE):
    """Integral of ln r dx . dx' over two edges, and of its magnitude."""
    found = np.zeros(2)
    _edge_pair(*(np.array(x, float) for x in (p0, p1, q0, q1)), tolerance, grade, SCRATCH, found)
    return found


def foot(x, start, direction, length):
    """Where on an edge a point is nearest, if that is not an end."""
    t = (x - start) @ direction
    return [t] if 1e-14 < t < length - 1e-14 else None


def plain_edge_pair(p0, p1, q0, q1, split=None):
    """The same by adaptive quadrature along both edges; the outer one split where told."""
    p0, p1, q0, q1 = (np.array(x, float) for x in (p0, p1, q0, q1))
    la, lb = np.linalg.norm(p1 - p0), np.linalg.norm(q1 - q0)
    d, e = (p1 - p0) / la, (q1 - q0) / lb
    precise = {"epsabs": 1e-13, "epsrel": 1e-12, "limit": 200}

    def inner(t):
        x = p0 + t * d
        return quad(
            lambda s: 0.5 * np.log(max(1e-300, ((q0 + s * e - x) ** 2).sum())), 0, lb,
            points=foot(x, q0, e, lb), **precise,
        )[0]  # fmt: skip

    return d @ e * quad(inner, 0, la, points=split, **precise)[0]


def random_edges(rng):
    p = rng.normal(size=(2, 3))
    return (*p, *(rng.normal(size=(2, 3)) + 2 * rotation(rng)[0]))


# ---------------------------------------------------------------------- pairs of edges


@pytest.mark.parametrize("seed", range(4))
def test_apart_edges_agree_with_quadrature(seed):
    edges = random_edges(np.random.default_rng(seed))
    # 1e-12: as asked of the quadrature; reached is 2e-15
    assert edge_pair(*edges)[0] == pytest.approx(plain_edge_pair(*edges), rel=0, abs=1e-12)


def corner_integral(angle, b):
    """Integral of ln |t d - s e| over 0 < t < 1 and 0 < s < b, by t = x y or s = b x y.

    ln r is homogeneous but for ln x, and along y it is the logarithm of |y - z| for a complex z.
    """
    z = b * np.exp(1j * angle)
    there = np.log(b) + line_logarithm(1 / z)
    return b * (there + line_logarithm(z) - 1) / 2


def line_logarithm(z):
    """Integral of ln |y - z| over 0 < y < 1."""
    return ((1 - z) * np.log(1 - z) + z * np.log(-z)).real - 1


@pytest.mark.parametrize("angle", [1e-4, 1, 30, 89, 150, 179.9])
def test_edges_with_a_common_end(angle):
    turn = np.radians(angle)
    d, e = np.array([1, 0, 0]), np.array([np.cos(turn), np.sin(turn), 0])
    expected = d @ e * corner_integral(turn, 0.7)
    o = np.zeros(3)
    # 1e-14: rounding of the closed form; reached 7e-16
    assert edge_pair(o, d, o, 0.7 * e)[0] == pytest.approx(expected, rel=0, abs=1e-14)
    assert edge_pair(o, d, 0.7 * e, o)[0] == pytest.approx(-expected, rel=0, abs=1e-14)


@pytest.mark.parametrize("gap", [0.0, 1e-7, 1e-3, 0.1])
@pytest.mark.parametrize("angle", [5, 120])
def test_crossing_edges_that_nearly_meet(gap, angle):
    turn = np.radians(angle)
    tip = np.array([np.cos(turn), np.sin(turn), 0])
    up = np.array([0.1, 0.2, 0]), [0, 0, gap]
    edges = [-1, 0, 0], [1.3, 0, 0], -0.8 * tip + up[1], 0.9 * tip + up[1]
    expected = plain_edge_pair(*edges, split=[1.0])
    # 1e-11: what quadrature reaches about the crossing
    assert edge_pair(*edges)[0] == pytest.approx(expected, rel=0, abs=1e-11)


def line_integral(x):
    """Twice integrated ln |x|."""
    return 0.0 if x == 0 else x * x / 2 * np.log(abs(x)) - 3 * x * x / 4


@pytest.mark.parametrize("start", [0.0, 0.3, 1.0, 1.0 + 1e-9, 1.5, 7.0])
def test_edges_on_one_line(start):
    """Overlapping, touching end to end, and apart: differences of the twice integrated ln |x|."""
    stop = start + 0.8
    edges = [0, 0, 0], [1, 0, 0], [start, 0, 0], [stop, 0, 0]
    ends = [stop, start - 1], [start, stop - 1]
    expected = sum(map(line_integral, ends[0])) - sum(map(line_integral, ends[1]))
    assert edge_pair(*edges)[0] == pytest.approx(expected, rel=0, abs=1e-14)  # reached 1e-15


def ribbon_integral(h):
    """Integral of ln sqrt((t - s)^2 + h^2) over 0 < s, t < 1: 2 int (1 - u) ln sqrt(u^2 + h^2)."""
    long = 1 + h * h
    return (
        0.5 * np.log(long) - 2 + 2 * h * np.arctan(1 / h)
        - 0.5 * (long * np.log(long) - h * h * np.log(h * h) - 1) + 0.5 * np.log(long)
    )  # fmt: skip


@pytest.mark.parametrize("h", [1e-9, 1e-6, 1e-3, 0.1, 1.0, 10.0])
def test_parallel_edges(h):
    edges = [0, 0, 0], [1, 0, 0], [1, h, 0], [0, h, 0]
    # 1e-14: rounding; the closed form loses h^2 eps
    assert edge_pair(*edges)[0] == pytest.approx(
        -ribbon_integral(h), rel=0, abs=1e-14 * max(1, h * h)
    )


def test_edges_that_add_nothing():
    assert edge_pair([0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 2, 0])[0] == 0.0  # at right angles
    assert edge_pair([0, 0, 0], [0, 0, 0], [0, 1, 0], [1, 2, 0])[0] == 0.0  # no length
    assert edge_pair([0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 0])[0] == 0.0


def test_the_inner_integral_agrees_with_quadrature():
    """E4, from points about, on and beyond the edge."""
    e = np.array([0.6, 0.0, 0.8])
    for along, aside in ((0.4, 0.7), (0.4, 1e-5), (-1.0, 0.2), (3.0, 0.1), (0.4, 0.0), (0.0, 0.0)):
        r = along * e + aside * np.array([0.8, 0.0, -0.6])
        found = _log_integral(*r, *e, 1.7)
        expected = quad(
            lambda s, r=r: 0.5 * np.log(max(1e-300, ((r - s * e) ** 2).sum())), 0, 1.7,
            points=[min(1.7, max(0.0, along))], epsabs=1e-13, limit=300,
        )[0]  # fmt: skip
        assert found == pytest.approx(expected, rel=0, abs=1e-12)  # as asked of the quadrature


@pytest.mark.parametrize("seed", range(20))
def test_parts_of_an_edge_add_up(seed):
    rng = np.random.default_rng(seed)
    p0, p1, q0, q1 = random_edges(rng)
    if seed % 2:
        q0 = p0 if seed % 4 == 1 else p0 + 0.4 * (p1 - p0)  # touching at an end or inside
    share = rng.uniform(0.1, 0.9)
    whole = edge_pair(p0, p1, q0, q1)
    middle, other = p0 + share * (p1 - p0), q0 + (1 - share) * (q1 - q0)
    # 1e-14 of the magnitude: rounding of the split; reached is 2e-15
    slack = 1e-14 * whole[1]
    both = edge_pair(p0, middle, q0, q1) + edge_pair(middle, p1, q0, q1)
    assert both[0] == pytest.approx(whole[0], rel=0, abs=slack)
    both = edge_pair(p0, p1, q0, other) + edge_pair(p0, p1, other, q1)
    assert both[0] == pytest.approx(whole[0], rel=0, abs=slack)
    assert edge_pair(q0, q1, p0, p1)[0] == pytest.approx(whole[0], rel=0, abs=slack)
    assert edge_pair(p1, p0, q0, q1)[0] == pytest.approx(-whole[0], rel=0, abs=slack)


@pytest.mark.parametrize(
    "tolerance, grade", [(1e-4, GRADED[0]), (1e-6, GRADED[0]), (1e-9, GRADED[1]), (1e-12, FINE)]
)
def test_the_error_follows_the_tolerance(tolerance, grade):
    rng, worst = np.random.default_rng(3), 0.0
    for k in range(60):
        p0, p1, q0, q1 = random_edges(rng)
        q0 = q0 if k % 3 else p0
        fine, size = edge_pair(p0, p1, q0, q1)
        worst = max(worst, abs(edge_pair(p0, p1, q0, q1, tolerance, grade)[0] - fine) / size)
    assert worst < tolerance


# ---------------------------------------------------------------------- polygons


def contour(p, q, tolerance=1e-14):
    found = np.empty(3)
    contour_exchange(p, len(p), q, len(q), tolerance, SCRATCH, found)
    return found[0], found[1]


def test_polygons_agree_with_the_plain_twin():
    seen = 0
    for p, q in pairs_apart(3, 6, 1.05, 2.0):
        expected = plain_exchange(p, q)
        fronts = (
            (q - p[0]) @ np.cross(p[1] - p[0], p[2] - p[0]),
            (p - q[0]) @ np.cross(q[1] - q[0], q[2] - q[0]),
        )
        if expected == 0 or min(map(np.min, fronts)) < 0:
            continue
        seen += 1
        assert contour(p, q)[0] == pytest.approx(expected, rel=0, abs=1e-10)  # of the twin's points
    assert seen > 2


def test_rounding_is_estimated():
    """Strips of small width, where the parts of the contour cancel, against plain Gauss."""
    ratios = []
    for width in 10.0 ** -np.arange(5):
        for gap in (0.3, 1.0, 2.7):
            strip = np.array([[0, 0, gap], [0, width, gap], [1, width, gap], [1, 0, gap]])
            value, error = contour(SQUARE, strip)
            exact = strip_exchange(width, gap)
            twin = 5e-15 * exact  # rounding of 1600 x 1600 terms
            ratios.append(max(0.0, abs(value - exact) - twin) / error)
            assert error < 1e-15 + 1e-15 * width
    assert max(ratios) < 2  # reached 1.3
    assert max(ratios) > 0.1  # nor is it far too cautious


def strip_exchange(width, gap):
    """A F from a square to a strip above its edge by 40 Gauss points along x, x', y and y'."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    nodes, weights = (nodes + 1) / 2, weights / 2
    x = nodes[:, None] - nodes[None]
    y = nodes[:, None] - width * nodes[None]
    flat, across = (x * x).ravel(), (y * y).ravel()
    w = np.outer(weights, weights).ravel()
    kernel = gap * gap / (flat[:, None] + across[None] + gap * gap) ** 2
    return width * (w @ kernel @ w) / np.pi


@pytest.mark.parametrize("gap", [1e-6, 1e-3, 0.1, 1.0])
def test_opposite_squares_at_any_gap(gap):
    above = SQUARE[::-1] + [0, 0, gap]
    value, error = contour(SQUARE, above)
    # 1e-14: the closed form's own rounding; reached 2e-15
    assert value == pytest.approx(parallel_rectangles(1, 1, gap), rel=0, abs=1e-14)
    assert 1e-17 < error < 1e-14
