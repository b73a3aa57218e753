"""Quadrature rules on [0, 1]: Gauss-Legendre of several orders, and one graded to both ends."""

import math

import numpy as np
from numba import njit

ORDERS = np.array([1, 2, 3, 4, 5, 6, 8, 12, 16, 24])
LONGEST = 64


def _gauss_rules():
    nodes, weights = np.zeros((2, len(ORDERS), LONGEST))
    for k, m in enumerate(ORDERS):
        x, w = np.polynomial.legendre.leggauss(m)
        nodes[k, :m], weights[k, :m] = (x + 1) / 2, w / 2
    return nodes, weights


def _graded_rule(half: int, reach: float):
    """Return the tanh-sinh rule of 2 half + 1 nodes (Takahasi & Mori 1974)."""
    u = np.linspace(-reach, reach, 2 * half + 1)
    inner = np.pi / 2 * np.sinh(u)
    x = 1 / (1 + np.exp(-2 * inner))
    w = reach / half * np.pi / 4 * np.cosh(u) / np.cosh(inner) ** 2
    return x, w / w.sum()


NODES, WEIGHTS = _gauss_rules()
# Ends with logarithms or kinks, to relative 1e-6, 1e-9 and 1e-13.
GRADED = tuple(_graded_rule(half, reach) for half, reach in ((8, 2.3), (14, 2.7), (24, 3.1)))


@njit(cache=True, nogil=True, error_model="numpy")
def gauss_index(rho, tolerance):
    """Return which of ORDERS errs by at most ``tolerance``; -1 where none does.

    The error of m points falls like rho^(-2 m), rho being the sum of the half axes of the largest
    ellipse about [-1, 1] in which the integrand is analytic (Davis & Rabinowitz 1984).
    """
    if rho <= 1.05:
        return -1
    needed = -math.log(tolerance) / (2.0 * math.log(rho))
    for k in range(len(ORDERS)):
        if ORDERS[k] >= needed:
            return k
    return -1
