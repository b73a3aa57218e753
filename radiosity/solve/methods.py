"""Solvers of the radiosity system B = M_e + rho F B, one function each, one interface.

A solver takes ``(factors, rho, emission, tolerance)`` with rho and emission (n, bands) and returns
``(B, history)``: radiosities (n, bands) and the error bound after each iteration. It stops when
the bound max|residual| / (1 - max rho row sum), relative to max B, is below ``tolerance``.
"""

import numpy as np
from numba import njit

from radiosity.transport.operator import FormFactors

LIMIT, RESTART = 1000, 50


class NotConverged(RuntimeError):
    """An iteration did not reach its tolerance; ``history`` holds its error bounds."""

    def __init__(self, method: str, history: list[float], tolerance: float):
        self.history = history
        last = f"{history[-1]:.2e}" if history else "nothing"
        super().__init__(
            f"{method} stopped at an error bound of {last} after {len(history)} iterations, "
            f"above the tolerance {tolerance:.2e}: use --solver direct or let more be absorbed"
        )


@njit(cache=True, nogil=True)
def _sweep(exchange, area, rho, emission, b):
    n, bands = b.shape
    arriving = np.empty(bands)
    for i in range(n):
        arriving[:] = 0.0
        row = exchange[i]
        for j in range(n):
            f = row[j]
            if f != 0.0:
                for k in range(bands):
                    arriving[k] += f * b[j, k]
        for k in range(bands):
            incident = arriving[k] / area[i] if area[i] > 0.0 else 0.0
            b[i, k] = emission[i, k] + rho[i, k] * incident


def contraction(factors: FormFactors, rho: np.ndarray) -> float:
    """Return max_i rho_i sum_j F_ij, the factor by which each bounce shrinks an error."""
    return float((rho * factors.row_sums()[:, None]).max(initial=0.0))


def gauss_seidel(factors: FormFactors, rho, emission, tolerance):
    """Gauss-Seidel: each patch gathers from the newest radiosities of all others."""
    b = emission.copy()
    history = []
    for _ in range(LIMIT):
        _sweep(factors.exchange, factors.area, rho, emission, b)
        history.append(_bound(factors, rho, emission, b))
        if history[-1] <= tolerance:
            return b, history
    raise NotConverged("Gauss-Seidel", history, tolerance)


def gmres(factors: FormFactors, rho, emission, tolerance):
    """GMRES (scipy), a band at a time; the history bounds each band's error after each step."""
    from scipy.sparse.linalg import LinearOperator
    from scipy.sparse.linalg import gmres as scipy_gmres

    b, history = emission.copy(), []
    n, left = len(b), max(1.0 - contraction(factors, rho), 1e-12)
    for k in np.flatnonzero(emission.any(axis=0)):
        system = LinearOperator((n, n), lambda x, r=rho[:, k]: x - r * (factors @ x))
        scale = np.linalg.norm(emission[:, k]) / (left * emission[:, k].max())
        b[:, k], stopped = scipy_gmres(
            system, emission[:, k], x0=emission[:, k], rtol=tolerance / scale, restart=RESTART,
            maxiter=-(-LIMIT // RESTART), callback_type="pr_norm",
            callback=lambda norm, s=scale: history.append(float(norm * s)),
        )  # fmt: skip
        if stopped:
            raise NotConverged("GMRES", history, tolerance)
    history.append(_bound(factors, rho, emission, b))
    if history[-1] > tolerance:
        raise NotConverged("GMRES", history, tolerance)
    return b, history


def direct(factors: FormFactors, rho, emission, tolerance):
    """LU factorisation (LAPACK); bands of one reflectance share it."""
    from scipy.linalg import lu_factor, lu_solve

    b = np.empty_like(emission)
    distinct, which = np.unique(rho, axis=1, return_inverse=True)
    matrix = factors.toarray()
    for k in range(distinct.shape[1]):
        bands = np.flatnonzero(which.ravel() == k)
        lu = lu_factor(np.eye(len(rho)) - distinct[:, k, None] * matrix)
        b[:, bands] = lu_solve(lu, emission[:, bands])
    history = [_bound(factors, rho, emission, b)]
    if not np.all(np.isfinite(b)) or b.min(initial=0.0) < -tolerance * b.max(initial=0.0):
        raise NotConverged("the direct solver, on a matrix that is singular,", history, tolerance)
    return b, history


def _bound(factors, rho, emission, b) -> float:
    """Return the bound of the largest error in B, relative to the largest B."""
    residual = np.abs(emission + rho * (factors @ b) - b).max(initial=0.0)
    left = 1.0 - contraction(factors, rho)
    largest = np.abs(b).max(initial=0.0)
    if residual == 0.0:
        return 0.0
    return float(residual / (max(left, 0.0) * largest)) if left > 0.0 else float("inf")


SOLVERS = {"gauss-seidel": gauss_seidel, "gmres": gmres, "direct": direct}
