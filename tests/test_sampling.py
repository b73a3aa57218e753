"""Sample points: stratified in every elementary interval, shifted by hashes, cosine directions."""

import numpy as np
import pytest
from scenes_for_tests import rotation
from scipy.stats import qmc

from radiosity.transport.sampling import cosine_direction, hashed, shuffled, sobol


def points(first, count, dimensions, shifts=None):
    shifts = [np.uint64(0)] * 4 if shifts is None else shifts
    return np.array(
        [[sobol(k, d, shifts[d]) for d in dimensions] for k in range(first, first + count)]
    )


def random_shifts(seed):
    one, two = np.uint64(hashed(seed, 1, 2)), np.uint64(hashed(seed, 1, 3))
    return [one, one >> np.uint64(32), two, two >> np.uint64(32)]


SHIFTS = [None, random_shifts(1), random_shifts(2)]


def plain_sobol(count):
    """Sobol in four dimensions by the recurrences, digit sums over GF(2) in plain integers."""
    columns = [[1] * 32]
    for degree, coefficients, start in ((1, [], [1]), (2, [1], [1, 3]), (3, [0, 1], [1, 3, 1])):
        m = list(start)
        while len(m) < 32:
            value = m[-degree] ^ (m[-degree] * 2**degree)
            for k, a in enumerate(coefficients, 1):
                value ^= a * m[-k] * 2**k
            m.append(value)
        columns.append(m)
    out = np.zeros((count, 4))
    for n in range(count):
        for d, m in enumerate(columns):
            bits = 0
            for k in range(32):
                if n >> k & 1:
                    bits ^= m[k] << (31 - k)
            out[n, d] = bits / 2**32
    return out


def test_sobol_agrees_with_its_plain_twin():
    assert np.array_equal(points(0, 300, range(4)), plain_sobol(300))


def test_sobol_has_the_points_of_joe_and_kuo():
    """scipy's generator, which visits the same points in another order (Gray code)."""
    expected = qmc.Sobol(4, scramble=False, bits=32).random(256)
    found = points(0, 256, range(4))
    assert np.array_equal(found[np.lexsort(found.T)], expected[np.lexsort(expected.T)])


def test_first_points():
    assert points(0, 4, (0, 1)).tolist() == [[0, 0], [0.5, 0.5], [0.25, 0.75], [0.75, 0.25]]


@pytest.mark.parametrize("shifts", SHIFTS, ids=["plain", "shifted", "shifted again"])
@pytest.mark.parametrize("m", [4, 6, 8])
@pytest.mark.parametrize("block", [0, 1, 5])
def test_two_dimensions_are_a_net(m, block, shifts):
    """A (0, m, 2)-net: 2^m points put just one into each of the 2^m boxes 2^-i x 2^-(m-i)."""
    xy = points(block * 2**m, 2**m, (0, 1), shifts)
    assert np.all((xy >= 0) & (xy < 1))
    for i in range(m + 1):
        cell = np.floor(xy * [2**i, 2 ** (m - i)]).astype(int)
        assert len(np.unique(cell[:, 0] * 2 ** (m - i) + cell[:, 1])) == 2**m


@pytest.mark.parametrize("shifts", SHIFTS, ids=["plain", "shifted", "shifted again"])
def test_every_dimension_is_stratified(shifts):
    xyzw = points(256, 256, range(4), shifts)
    for x in xyzw.T:
        assert np.array_equal(np.sort(np.floor(x * 256)), np.arange(256))


def test_four_dimensions_are_even():
    """4096 points in 4 x 4 x 4 x 4 boxes: 16 each (t = 3 of this sequence, 4096 = 2^(8 + 4))."""
    cell = np.floor(points(4096, 4096, range(4), random_shifts(3)) * 4).astype(int)
    counts = np.bincount(cell @ [64, 16, 4, 1], minlength=256)
    assert counts.min() == counts.max() == 16


def test_smooth_integrals_converge_as_one_over_n():
    """Error of a mean over n = 2^m shifted points, rms over shifts: random points give n^-1/2."""
    rms = []
    for m in (6, 8, 10):
        found = []
        for seed in range(12):
            x = points(0, 2**m, range(4), random_shifts(seed))
            found.append(np.prod(1 + 0.5 * (x - 0.5), axis=1).mean() - 1.0)
        rms.append(np.sqrt(np.mean(np.square(found))))
    orders = np.log(np.array(rms[:-1]) / rms[1:]) / np.log(4)
    assert rms[0] < 0.01
    assert orders.mean() > 0.9  # a digital shift keeps the net's order of about 1, not more


def test_hashes_differ_in_every_argument():
    values = {int(hashed(a, b, c)) for a in range(12) for b in range(12) for c in range(12)}
    assert len(values) == 12**3
    bits = np.array([[int(v) >> k & 1 for k in range(64)] for v in values])
    assert np.abs(bits.mean(axis=0) - 0.5).max() < 0.06  # 5 standard errors of 1728 coins


def test_hashes_are_repeatable():
    assert hashed(1, 2, 3) == hashed(1, 2, 3)
    assert int(hashed(0, 0, 0)) != int(hashed(0, 0, 1))


def test_patterns_of_two_hashes_differ():
    one, two = (points(0, 64, (0, 1), random_shifts(k)) for k in (5, 6))
    assert np.abs(one - two).min() > 0
    assert np.abs(np.corrcoef(one[:, 0], two[:, 0])[0, 1]) < 0.999


def directions(normal, count=4096, shifts=None):
    out = np.empty((count, 3))
    for k, (u, v) in enumerate(points(0, count, (0, 1), shifts)):
        cosine_direction(u, v, normal, out[k])
    return out


NORMALS = [
    np.array([0.0, 0.0, 1.0]),
    np.array([0.0, 0.0, -1.0]),
    np.array([1.0, 0.0, 0.0]),
    np.array([0.6, -0.8, -0.0]),
    *rotation(np.random.default_rng(0)),
]


@pytest.mark.parametrize("normal", NORMALS, ids=lambda n: ",".join(f"{x:.2g}" for x in n))
def test_directions_have_the_moments_of_a_cosine(normal):
    """Density cos/pi: <c> = 2/3, <c^2> = 1/2, <d> = 2 n/3, <d d> = 1/4 (I + n n)."""
    d = directions(normal, shifts=random_shifts(7))
    assert np.linalg.norm(d, axis=1) == pytest.approx(np.ones(len(d)), abs=1e-14)  # rounding
    cosine = d @ normal
    assert cosine.min() >= 0
    # 1e-3: 4096 Sobol points; random ones would be off by 4e-3
    assert cosine.mean() == pytest.approx(2 / 3, abs=1e-3)
    assert (cosine**2).mean() == pytest.approx(1 / 2, abs=1e-3)
    assert (cosine**4).mean() == pytest.approx(1 / 3, abs=1e-3)
    assert d.mean(axis=0) == pytest.approx(2 / 3 * normal, abs=1e-3)
    expected = (np.eye(3) + np.outer(normal, normal)) / 4
    assert d.T @ d / len(d) == pytest.approx(expected, abs=1e-3)


def test_extreme_samples_stay_on_the_hemisphere():
    out = np.empty(3)
    for u in (0.0, 1 - 2.0**-32):
        for v in (0.0, 1 - 2.0**-32):
            for normal in NORMALS:
                cosine_direction(u, v, normal, out)
                assert np.linalg.norm(out) == pytest.approx(1.0, abs=1e-14)
                assert out @ normal >= -1e-15


@pytest.mark.parametrize("key", [0, 7, np.uint64(2**63 + 12345)])
def test_shuffled_blocks_stay_blocks(key):
    """Of any 2^k points from a multiple of 2^k on, so stretches of a sequence stay even."""
    for bits in (1, 3, 6):
        for block in range(4):
            order = [shuffled((block << bits) + k, key) for k in range(1 << bits)]
            assert len({x >> bits for x in order}) == 1
            assert {x & ((1 << bits) - 1) for x in order} == set(range(1 << bits))


def test_shuffled_orders_are_independent_of_the_sequence():
    """Pairs of a point's place and its rays fill the square: in step, they would lie on lines."""
    count = 256

    def mean(order):
        same = [(sobol(order(k), 0, 0) < 0.5) == (sobol(4 * k, 0, 0) < 0.125) for k in range(count)]
        return np.mean(same)

    assert mean(lambda k: k) in (0.0, 1.0)
    keys = [np.uint64(hashed(k, 2, 0)) for k in range(40)]
    means = np.array([mean(lambda k, key=key: shuffled(k, key)) for key in keys])
    assert abs(means.mean() - 0.5) < 4 * means.std() / np.sqrt(40) + 0.01
