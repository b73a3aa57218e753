"""Closure: the least change, weighed by error estimates, after which every row sums to 1."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from radiosity.transport.operator import FormFactors, Openness
from radiosity.transport.threads import over_ranges

# Defects end below TARGET, which the rounding of sums over thousands of entries leaves room for;
# a result with one above BOUND is not handed out.
TARGET, BOUND = 1e-13, 1e-12
# Relative errors granted to every entry beside its own estimate, the next where one did not do.
FLOORS = (2.0**-52, 1e-8, 1e-4, 1.0)
PASSES, STEPS = 30, 300
ROWS, ALONE = 256, 700


class NotClosable(RuntimeError):
    """Row sums that no change of the entries within their signs and zeros brings to 1.

    Attributes
    ----------
    row : int
        The row that is left furthest from 1.
    defect : float
        Its row sum + environment - 1 when the repair ended.

    Examples
    --------
    >>> import numpy as np
    >>> from radiosity import FormFactors
    >>> from radiosity.transport.closure import repaired
    >>> repaired(FormFactors(np.array([[0, 1.0], [1.0, 0]]), np.array([1.0, 3.0])))
    Traceback (most recent call last):
    radiosity.transport.closure.NotClosable: row 0 of the form factors sums to 1 ...
    """

    def __init__(self, raw: np.ndarray, left: np.ndarray):
        first, row = int(np.argmax(np.abs(raw))), int(np.argmax(np.abs(left)))
        self.row, self.defect = row, float(left[row])
        super().__init__(
            f"row {row} of the form factors sums to 1 {raw[row]:+.3e}, and the repair brings it no "
            f"nearer than 1 {left[row]:+.3e} (bound {BOUND:.0e}): the rows that it sees have no "
            f"room for it. The largest defect before was {raw[first]:+.3e}, of row {first}: "
            "probably its area is wrong, or it is part of a pair that sees each other at factor 0"
        )


def repaired(factors: FormFactors) -> FormFactors:
    """Return the factors nearest to these whose exposed rows sum to 1 with the environment.

    Weighted least squares with reciprocity and signs kept: with G_ij = A_i F_ij and errors s,

        min  sum_{i<=j} dG_ij^2 / w_ij + sum_i (A_i de_i)^2 / v_i
        s.t. sum_j (G + dG)_ij + A_i (e + de)_i = A_i,   dG = dG^T,   G + dG >= 0,   e + de >= 0

    and w_ij = s_ij^2 + (floor G_ij)^2, v_i likewise. Stationarity: G + dG = max(0, G + w_ij
    (lam_i + lam_j)), so the multipliers solve a piecewise linear system, here by Newton's method
    (Qi, Sun 2006, on nearest correlation matrices) with conjugate residuals inside. Entries that
    are 0 stay 0, or repair would let light through walls. The floor is rounding at first: entries
    of error 0 stay exact to rounding. It grows only for defects that uncertain entries cannot take.

    Parameters
    ----------
    factors : FormFactors
        Symmetric to the bit; sealed rows stay 0.

    Returns
    -------
    FormFactors
        Every exposed row within 1e-12 of 1, symmetric to the bit, with the errors as they were
        and ``raw_closure`` the defects before. The same for any number of threads.

    Raises
    ------
    NotClosable
        Where no such matrix exists or none was found; names the worst row.
    """
    raw = factors.closure
    exchange, share, left = factors.exchange, factors.openness.share, raw
    exposed = factors.exposed
    if TARGET < _worst(raw) < np.inf:
        exchange, flux = exchange.copy(), factors.area * share
        for floor in FLOORS:
            left = _balance(factors, exposed, exchange, flux, left, floor)
            if _worst(left) <= TARGET:
                break
        share = np.where(exposed, flux / np.where(exposed, factors.area, 1.0), share)
    if not _worst(left) <= BOUND:
        raise NotClosable(raw, left)
    openness = _openness(factors, share)
    return factors.replaced(exchange=exchange, openness=openness, raw_closure=raw)


def _openness(factors, share):
    """Return a repaired share of light that leaves the rows, of which the same part is absorbed.

    Where nothing left the row before: all of it in scenes whose rows see surfaces only, else none.
    The errors stay those before the repair, as those of the pairs do.
    """
    before, out = factors.openness, factors.environment
    absorbed = np.broadcast_to(before.absorbed, share.shape)
    inside = not np.any(out > 0) and np.any(absorbed > 0)
    some = before.share > 0
    part = np.where(some, absorbed / np.where(some, before.share, 1.0), float(inside))
    return Openness(share, before.error, share * part)


def _worst(defects):
    return np.abs(defects).max(initial=0.0)


@dataclass(frozen=True)
class _Weights:
    """Weights w_ij = pair_ij size_i size_j of the pairs, outer_i size_i^2 of the environment.

    ``pair`` (n, n) float32 holds half of w_ii on its diagonal and is negative where the entry is
    held at 0; scaled by ``size`` (n,) its magnitudes sum, with ``outer`` (n,), to about 1 a row.
    """

    pair: np.ndarray
    size: np.ndarray
    outer: np.ndarray


def _weights(factors, exposed, floor):
    n, exchange, outside = len(factors.area), factors.exchange, factors.openness
    outer = factors.area**2 * (outside.error**2 + (floor * outside.share) ** 2)
    total, pair = outer.copy(), np.empty((n, n), np.float32)
    _by_rows(lambda a, b: _weight_sums(a, b, exchange, factors.error, exposed, floor, total), n)
    size = np.where(exposed, np.sqrt(total), 0.0)
    inverse = _inverse(size)
    _by_rows(lambda a, b: _pair_weights(a, b, exchange, factors.error, inverse, floor, pair), n)
    return _Weights(pair, size, outer * inverse**2)


def _balance(factors, exposed, exchange, flux, left, floor):
    """Move ``exchange`` and ``flux`` = A e, in place, to the sums; return the defects left."""
    defect = left * factors.area
    weights = _weights(factors, exposed, floor)
    per_area = _inverse(np.where(exposed, factors.area, 0.0))
    slope, turned, before = np.where(weights.size > 0.0, 1.0, 0.0), False, np.inf
    for _ in range(PASSES):
        worst = _worst(defect * per_area)
        if worst <= TARGET or (not turned and worst > 0.5 * before):
            break
        multipliers = _multipliers(weights, slope, -defect, per_area)
        sums, slope, turned = _move(weights, exchange, flux, multipliers)
        defect, before = np.where(exposed, sums - factors.area, 0.0), worst
    _by_rows(lambda a, b: _clip(a, b, exchange), len(flux))
    np.maximum(flux, 0.0, out=flux)
    return defect * per_area


def _move(weights, exchange, flux, y):
    """Add w_ij (lam_i + lam_j) with lam = y / size; return the sums, slopes and whether any turned.

    The sums are those of what is positive; the slope of a row is the weight, in units of size^2,
    of what is free to move.
    """
    n = len(y)
    sums, slope, turned = np.empty(n), np.empty(n), np.zeros(n, bool)
    pair, size = weights.pair, weights.size
    _by_rows(lambda a, b: _move_rows(a, b, exchange, pair, size, y, sums, slope, turned), n)
    was_held = flux < 0.0
    flux += weights.outer * size * y
    held = flux < 0.0
    slope = slope * _inverse(size) + np.where(held, 0.0, weights.outer)
    return sums + np.maximum(flux, 0.0), slope, turned.any() or bool(np.any(held != was_held))


def _multipliers(weights, slope, defect, per_area):
    """Solve (diag(slope) + pair) y = defect / size by conjugate residuals (Stiefel 1955).

    Preconditioned by the diagonal. The residual falls at every step, also where the matrix is
    singular; then it ends at the least one.
    """
    c = _inverse(np.sqrt(slope))
    r = c * _inverse(weights.size) * defect
    scale = _worst(r)
    r *= _inverse(scale)
    relative = np.sqrt(slope) * weights.size * per_area * scale
    x, p = np.zeros_like(r), r
    ar = ap = _applied(weights.pair, c, r)
    curvature = np.sum(r * ar)
    for _ in range(STEPS):
        if not curvature > 1e-15 * np.sum(r * r):
            break
        step = curvature / np.sum(ap * ap)
        x, r = x + step * p, r - step * ap
        if _worst(relative * r) <= 0.2 * TARGET:
            break
        ar = _applied(weights.pair, c, r)
        turn = np.sum(r * ar) / curvature
        curvature *= turn
        p, ap = r + turn * p, ar + turn * ap
    return c * x * scale


def _applied(pair, c, x):
    """Return (1 + c pair c) x; rows with c = 0 have nothing that is free to move."""
    scaled, product = c * x, np.empty(len(x))
    _by_rows(lambda a, b: _product(a, b, pair, scaled, product), len(x))
    return np.where(c > 0.0, x, 0.0) + c * product


def _inverse(x):
    """Return 1 / x, and 0 where x is 0."""
    return np.where(x > 0.0, 1.0 / np.where(x > 0.0, x, 1.0), 0.0)


def _by_rows(work, n):
    """Call ``work(start, stop)`` for ranges of 0..n, in one go where threads cost more."""
    if n <= ALONE:
        work(0, n)
    else:
        over_ranges(work, n, ROWS)


@njit(cache=True, nogil=True)
def _weight(g, s, floor):
    """Return w of an entry; one that no light was seen to pass stays 0, whatever its error."""
    return (np.float64(s) ** 2 + (floor * g) ** 2) if g > 0.0 else 0.0


@njit(cache=True, nogil=True, fastmath={"reassoc", "nsz"})
def _weight_sums(first, stop, exchange, error, exposed, floor, total):
    for i in range(first, stop):
        summed = 0.0
        for j in range(exchange.shape[1]):
            summed += _weight(exchange[i, j], error[i, j], floor) * exposed[j]
        total[i] += summed - 0.5 * _weight(exchange[i, i], error[i, i], floor)


@njit(cache=True, nogil=True)
def _pair_weights(first, stop, exchange, error, inverse, floor, pair):
    for i in range(first, stop):
        for j in range(exchange.shape[1]):
            weight = _weight(exchange[i, j], error[i, j], floor)
            pair[i, j] = weight * (inverse[i] * inverse[j])
        pair[i, i] *= np.float32(0.5)


@njit(cache=True, nogil=True)
def _move_rows(first, stop, exchange, pair, size, y, sums, slope, turned):
    """Symmetric to the bit: the sum of two products does not depend on their order."""
    for i in range(first, stop):
        changes = 0
        for j in range(len(y)):
            w = abs(pair[i, j])
            g = exchange[i, j] + w * (size[j] * y[i] + size[i] * y[j])
            exchange[i, j] = g
            marked = w if g >= 0.0 else -w
            changes += marked != pair[i, j]
            pair[i, j] = marked
        sums[i], slope[i] = _positive(exchange[i], pair[i], size)
        turned[i] = changes > 0


@njit(cache=True, nogil=True, fastmath={"reassoc", "nsz"})
def _positive(row, pair, size):
    total = free = 0.0
    for j in range(len(row)):
        total += max(row[j], 0.0)
        free += max(pair[j], np.float32(0.0)) * size[j]
    return total, free


@njit(cache=True, nogil=True, fastmath={"reassoc", "nsz", "contract"})
def _product(first, stop, pair, x, product):
    for i in range(first, stop):
        total = 0.0
        for j in range(len(x)):
            total += max(pair[i, j], np.float32(0.0)) * x[j]
        product[i] = total


@njit(cache=True, nogil=True)
def _clip(first, stop, exchange):
    for i in range(first, stop):
        for j in range(exchange.shape[1]):
            if exchange[i, j] <= 0.0:
                exchange[i, j] = 0.0
