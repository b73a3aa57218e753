"""Quadrature rules: orders and constants of Gauss, the graded rule at its ends, the choice."""

from math import factorial

import numpy as np
import pytest

from radiosity.transport.rules import GRADED, LONGEST, NODES, ORDERS, WEIGHTS, gauss_index

GAUSS = list(range(len(ORDERS)))
REACHED = (2e-8, 1e-11, 1e-14)  # 1e-6, 1e-9 and 1e-13 are promised; reached 1.2e-8, 6e-12, 7e-16


def gauss(index, f):
    m = ORDERS[index]
    return WEIGHTS[index, :m] @ f(NODES[index, :m])


def graded(rule, f):
    return rule[1] @ f(rule[0])


@pytest.mark.parametrize("index", GAUSS, ids=lambda k: f"{ORDERS[k]} points")
def test_gauss_rules_are_exact_to_their_order(index):
    m = int(ORDERS[index])
    for power in range(2 * m):
        # 1e-15: rounding; reached is 4e-16
        assert gauss(index, lambda x, n=power: x**n) == pytest.approx(1 / (power + 1), abs=1e-15)
    assert np.all(WEIGHTS[index, :m] > 0) and not np.any(WEIGHTS[index, m:])
    assert np.all(np.diff(NODES[index, :m]) > 0)


@pytest.mark.parametrize("index", [k for k in GAUSS if ORDERS[k] <= 6])
def test_gauss_rules_err_by_the_known_constant(index):
    """On x^2m by (m!)^4 / ((2m + 1) (2m)!^2), of the monic Legendre polynomial on [0, 1]."""
    m = int(ORDERS[index])
    constant = factorial(m) ** 4 / ((2 * m + 1) * factorial(2 * m) ** 2)
    error = 1 / (2 * m + 1) - gauss(index, lambda x: x ** (2 * m))
    assert error == pytest.approx(constant, rel=1e-7, abs=1e-16)  # 1e-16: rounding


def test_orders_rise_and_fit():
    assert np.all(np.diff(ORDERS) > 0) and ORDERS[-1] <= LONGEST
    assert NODES.shape == WEIGHTS.shape == (len(ORDERS), LONGEST)


# B(2, 3/2) (psi(2) - psi(7/2)), the gammas cancel
LOG_AND_ROOT = 4 / 15 * (1 - (46 / 15 - 2 * np.log(2)))
ENDS = {
    "x ln x": (lambda x: x * np.log(x), -1 / 4),
    "its mirror image": (lambda x: (1 - x) * np.log1p(-x), -1 / 4),
    "half a circle": (lambda x: np.sqrt(x * (1 - x)), np.pi / 8),
    "both": (lambda x: x * np.log(x) * np.sqrt(1 - x), LOG_AND_ROOT),
    "smooth": (np.exp, np.e - 1),
    "one": (np.ones_like, 1.0),
}


@pytest.mark.parametrize("rule, tolerance", list(zip(GRADED, REACHED, strict=True)), ids=REACHED)
@pytest.mark.parametrize("end", ENDS)
def test_graded_rules_take_ends_that_are_not_smooth(rule, tolerance, end):
    f, expected = ENDS[end]
    assert graded(rule, f) == pytest.approx(expected, rel=tolerance, abs=0)


def test_graded_rules_are_of_use_where_gauss_is_not():
    """24 points of Gauss err by 7e-7 on x ln x, 29 graded ones by 1e-12."""
    f = ENDS["x ln x"][0]
    assert abs(gauss(GAUSS[-1], f) + 0.25) > 1e4 * abs(graded(GRADED[1], f) + 0.25)


def test_graded_rules_are_symmetric_and_lie_inside():
    for x, w in GRADED:
        assert len(x) == len(w) <= LONGEST
        assert np.all((0 < x) & (x < 1)) and np.all(np.diff(x) > 0) and np.all(w > 0)
        assert x + x[::-1] == pytest.approx(np.ones(len(x)), abs=1e-15)  # rounding of 1 - x
        assert w == pytest.approx(w[::-1], rel=1e-13)  # rounding of cosh, 1 in 1e16 of e^36


@pytest.mark.parametrize("c", [0.05, 0.3, 1.0, 4.0, 30.0])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_the_order_chosen_meets_the_tolerance(c, tolerance):
    """On 1/(x + c), whose pole gives rho = 1 + 2 c + sqrt((1 + 2 c)^2 - 1)."""
    a = 1 + 2 * c
    index = gauss_index(a + np.sqrt(a * a - 1), tolerance)
    if index < 0:
        assert c == 0.05 and tolerance == 1e-12  # 32 points would do
        return
    exact = np.log1p(1 / c)
    errors = [abs(gauss(k, lambda x: 1 / (x + c)) / exact - 1) for k in GAUSS]
    assert errors[index] <= 1.5 * tolerance  # the bound leaves out a factor of about 1; reached 1.2
    assert index == 0 or errors[index - 1] > tolerance  # and no order is wasted


def test_the_order_rises_towards_the_pole():
    chosen = [gauss_index(rho, 1e-6) for rho in (1e9, 20.0, 5.0, 2.0, 1.5, 1.2)]
    assert chosen[:-1] == sorted(chosen[:-1]) and chosen[0] == 0
    assert chosen[-1] == -1 == gauss_index(1.0, 0.5)  # no order is high enough
