"""Solvers of the radiosity system B = M_e + rho F B, one function each, one interface (E7).

A solver takes ``(system, tolerance, watch)`` and returns ``(B, history)``: coefficients of the
radiosity (m, bands) and the error bound after each iteration. It stops when the bound
max|residual| / min(1 - rho row sum), relative to max B, is below ``tolerance``: a bound where B is
constant on each patch, an estimate where it is linear. ``watch(B)``, where one is given, is called
with every iterate of those that make useful pictures early.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numba import njit

from radiosity.solve.equations import System
from radiosity.transport.operator import FormFactors

LIMIT, RESTART = 1000, 50
NEAR = 1e-3  # margins below which the direct solver avoids subtractions
ALIKE = 14  # digits of sources that must agree
BLOCK = 64  # rows that Gauss-Seidel multiplies at once
PICTURES = 8  # that shooting shows while it sends as often as there are coefficients
Watch = Callable[[np.ndarray], None]


class NotConverged(RuntimeError):
    """An iteration did not reach its tolerance; ``history`` holds its error bounds.

    Examples
    --------
    >>> from radiosity import NotConverged
    >>> raise NotConverged("Jacobi", [0.5, 0.1], 1e-3)
    Traceback (most recent call last):
    radiosity.solve.methods.NotConverged: Jacobi stopped at an error bound of 1.00e-01 after 2 ...
    """

    def __init__(self, method: str, history: list[float], tolerance: float):
        self.history = history
        last = f"{history[-1]:.2e}" if history else "nothing"
        super().__init__(
            f"{method} stopped at an error bound of {last} after {len(history)} iterations, "
            f"above the tolerance {tolerance:.2e}: use --solver direct or let more be absorbed"
        )


class Unbalanced(NotConverged):
    """A solution that makes or loses light; ``history`` holds its solver's error bounds."""

    def __init__(self, defect: float, history: list[float], order: int, caught: bool = False):
        self.history = history
        way_out = "use a finer --mesh, or auto" if order else "make the form factors anew"
        if caught:
            way_out = (
                "mirrors, or total reflection inside of clear bodies, keep it for too long, or it "
                "goes from face to face inside of a body that absorbs: let mirrors absorb more, or "
                "take lamps and faces out of clear bodies"
            )
        RuntimeError.__init__(
            self, f"{defect:.3g} of the light emitted is neither absorbed nor leaves: {way_out}"
        )


def jacobi(system: System, tolerance: float, watch: Watch | None = None):
    """Jacobi, bounce by bounce: B_k is the light after k reflections."""
    b, history = system.source.copy(), []
    for _ in range(LIMIT):
        residual = system.residual(b)
        history.append(system.bound(b, residual))
        if history[-1] <= tolerance:
            return b, history
        b = b + residual
        if watch is not None:
            watch(b)
    raise NotConverged("Jacobi", history, tolerance)


def gauss_seidel(system: System, tolerance: float, watch: Watch | None = None):
    """Gauss-Seidel: each patch gathers from the newest radiosities of all others.

    A sweep leaves the residual rho_i sum over j >= i of F_ij (change of B_j), so that its largest
    change bounds it.
    """
    b, history = system.source.copy(), []
    matrix, area = system.factors.rows()
    share = np.divide(1.0, area, out=np.zeros(len(area)), where=area > 0.0)
    gain = system.reflectance * share[:, None]
    blocks = [slice(first, first + BLOCK) for first in range(0, len(b), BLOCK)]
    sums = np.empty(len(b))
    for k in blocks:
        sums[k] = np.abs(matrix[k]).sum(axis=1)
    most = gain * sums[:, None]
    for _ in range(LIMIT):
        before = b.copy()
        for k in blocks:
            _sweep(matrix[k, k], gain[k], system.source[k], matrix[k] @ b, b[k])
        history.append(system.bound(b, most * np.abs(b - before).max(axis=0, initial=0.0)))
        if history[-1] <= tolerance:
            return b, history
        if watch is not None:
            watch(b)
    raise NotConverged("Gauss-Seidel", history, tolerance)


@njit(cache=True, nogil=True)
def _sweep(matrix, gain, source, arriving, b):
    """Renew the rows of a block, whose own matrix is given, from what arrives by the old ones."""
    n, bands = b.shape
    for i in range(n):
        for k in range(bands):
            change = source[i, k] + gain[i, k] * arriving[i, k] - b[i, k]
            b[i, k] += change
            for j in range(i + 1, n):
                arriving[j, k] += matrix[j, i] * change


def southwell(system: System, tolerance: float, watch: Watch | None = None):
    """Southwell, shooting: the patch with most unshot power sends it to all others.

    Progressive refinement of Cohen et al. (1988): useful pictures early. ``watch`` gets B with
    their ambient correction, the unshot light spread evenly over all surfaces with its reflections;
    the answer is without it.
    """
    matrix, area = system.factors.rows()
    columns = np.ascontiguousarray(matrix.T)
    weight, rho = system.factors.weight, system.reflectance
    b, unshot, history = system.source.copy(), system.source.copy(), []
    for _ in range(LIMIT):
        for _ in range(PICTURES):
            _shoot(columns, area, rho, weight, b, unshot, -(-len(b) // PICTURES))
            if watch is not None:
                watch(_with_ambient(system, b, unshot))
        history.append(system.bound(b))
        if history[-1] <= tolerance:
            return b, history
    raise NotConverged("Southwell", history, tolerance)


@njit(cache=True, nogil=True)
def _shoot(columns, area, rho, weight, b, unshot, shots):
    """Let the coefficients with most unshot power, each after the other, send it out."""
    n, bands = b.shape
    sent = np.empty(bands)
    for _ in range(shots):
        best, most = -1, 0.0
        for i in range(n):
            power = 0.0
            for k in range(bands):
                power += abs(unshot[i, k])
            power *= weight[i]
            if power > most:
                best, most = i, power
        if best < 0:
            return
        for k in range(bands):
            sent[k] = unshot[best, k]
            unshot[best, k] = 0.0
        for j in range(n):
            f = columns[best, j]
            if f != 0.0:
                for k in range(bands):
                    gain = rho[j, k] * f / area[j] * sent[k]
                    b[j, k] += gain
                    unshot[j, k] += gain


def _with_ambient(system, b, unshot):
    """Return B with the unshot light spread evenly over all patches, and all its reflections."""
    n = len(system.factors.area)
    share, rho = system.factors.area / system.factors.area.sum(), system.reflectance[:n]
    shown = b.copy()
    shown[:n] += rho * (share @ unshot[:n] / np.maximum(1.0 - share @ rho, 1e-12))
    return shown


def gmres(system: System, tolerance: float, watch: Watch | None = None):
    """GMRES (scipy), a band at a time; the history bounds each band's error after each step."""
    from scipy.sparse.linalg import LinearOperator
    from scipy.sparse.linalg import gmres as scipy_gmres

    source = system.source
    b, history = source.copy(), []
    n, left = len(b), max(system.margin, 1e-12)
    for k in np.flatnonzero(source.any(axis=0)):
        band = system.of_bands(slice(k, k + 1))
        matrix = LinearOperator(
            (n, n), lambda x, s=band: x - s.scattered(s.arriving(x.reshape(n, 1)))[:, 0]
        )
        scale = np.linalg.norm(source[:, k]) / (left * np.abs(source[:, k]).max())
        b[:, k], stopped = scipy_gmres(
            matrix, source[:, k], x0=source[:, k], rtol=tolerance / scale, restart=RESTART,
            maxiter=-(-LIMIT // RESTART), callback_type="pr_norm",
            callback=lambda norm, s=scale: history.append(float(norm * s)),
        )  # fmt: skip
        if stopped:
            raise NotConverged("GMRES", history, tolerance)
    return _finished("GMRES", system, b, history, tolerance)


def cg(system: System, tolerance: float, watch: Watch | None = None):
    """Conjugate gradients on the symmetric form, a band at a time (E16).

    With S = A^1/2 F A^-1/2, symmetric by reciprocity: (I - rho^1/2 S rho^1/2) z = rho^1/2 S A^1/2
    M_e and B = M_e + rho^1/2 A^-1/2 z, which is right where rho = 0 too.

    Raises
    ------
    ValueError
        For elements of order 1, whose factors are not symmetric.
    """
    if not isinstance(system.factors, FormFactors):
        raise ValueError("solver = 'cg' needs reciprocal factors: use order 0, or gmres")
    b, history, exchange = system.source.copy(), [], system.factors.exchange
    root = np.sqrt(np.where(system.factors.area > 0, system.factors.area, np.inf))
    for k in np.flatnonzero(system.source.any(axis=0)):
        half = np.sqrt(system.reflectance[:, k]) / root
        z, residual = np.zeros(len(b)), half * (exchange @ system.source[:, k])
        step, square = residual.copy(), residual @ residual
        for _ in range(LIMIT):
            b[:, k] = system.source[:, k] + half * z
            history.append(_bound_of(system, b, k))
            if history[-1] <= tolerance or square == 0.0:
                break
            product = step - half * (exchange @ (half * step))
            along = square / (step @ product)
            z, residual = z + along * step, residual - along * product
            before, square = square, residual @ residual
            step = residual + square / before * step
    return _finished("CG", system, b, history, tolerance)


def _bound_of(system, b, k):
    """Return the bound of the error in one band."""
    band = b[:, k : k + 1]
    return system.bound(band, system.of_bands(slice(k, k + 1)).residual(band))


def direct(system: System, tolerance: float, watch: Watch | None = None):
    """Elimination; bands of one reflectance share it.

    By LAPACK; where reflectances are near 1 by that of Grassmann, Taksar and Heyman (1985), in
    which nothing is subtracted, so that every B is right to rounding however small 1 - rho is.
    What a residual of 1 everywhere would change bounds the gain of errors, as the inverse of
    I - rho F has no negative term.
    """
    b, gain = np.empty_like(system.source), np.empty(system.source.shape[1])
    which = np.unique(system.laws, axis=1, return_inverse=True)[1].ravel()
    reciprocal = isinstance(system.factors, FormFactors) and system.is_plain
    careful = reciprocal and system.margin < NEAR
    eliminate = _without_subtraction if careful else _by_lapack
    for k in range(which.max() + 1):
        bands = np.flatnonzero(which == k)
        source = np.column_stack([system.source[:, bands], np.ones(len(b))])
        found = eliminate(system.of_bands(bands[:1]), source)
        b[:, bands], gain[bands] = found[:, :-1], np.abs(found[:, -1]).max(initial=0.0)
    history = [tolerance if careful else system.bound(b, gain=gain)]
    if not np.all(np.isfinite(b)):
        raise NotConverged("the direct solver, on a matrix that is singular,", history, tolerance)
    return b, history


def _by_lapack(system, source):
    """Solve the equations of one band for the columns of ``source``."""
    from scipy.linalg import lu_factor, lu_solve

    matrix, area = system.factors.rows()
    scale = np.where(area > 0, area, 1.0)[:, None]
    sent = system.reflectance / scale * matrix
    if system.sheets is not None:
        sent += system.sheets.passed(matrix / scale)
    if system.chains is not None:
        sent += system.scattered(system.chains.matrix[system.chains.which[0]])
    return lu_solve(lu_factor(np.eye(len(source)) - sent), source)


def _without_subtraction(system, source):
    factors, rho, absorptance = system.factors, system.reflectance[:, 0], system.absorptance[:, 0]
    matrix = rho[:, None] * factors.toarray()
    return _eliminate(matrix, absorptance + rho * factors.openness.share, source.copy())


@njit(cache=True, nogil=True)
def _eliminate(a, excess, b):
    """Solve (diag(excess + sums of rows of a without diagonal) - a) x = b, all of it positive."""
    n, bands = b.shape
    pivot = np.empty(n)
    for k in range(n):
        pivot[k] = excess[k]
        for j in range(k + 1, n):
            pivot[k] += a[k, j]
        if pivot[k] == 0.0:
            b[:] = np.nan
            return b
        for i in range(k + 1, n):
            if a[i, k] == 0.0:
                continue
            share = a[i, k] / pivot[k]
            excess[i] += share * excess[k]
            for c in range(bands):
                b[i, c] += share * b[k, c]
            for j in range(k + 1, n):
                a[i, j] += share * a[k, j]
    for k in range(n - 1, -1, -1):
        for c in range(bands):
            for j in range(k + 1, n):
                b[k, c] += a[k, j] * b[j, c]
            b[k, c] /= pivot[k]
    return b


def _finished(name, system, b, history, tolerance):
    """Return the answer of bands solved one by one where all of it meets the tolerance."""
    history.append(system.bound(b))
    if history[-1] > tolerance:
        raise NotConverged(name, history, tolerance)
    return b, history


SOLVERS = {
    "gauss-seidel": gauss_seidel, "jacobi": jacobi, "southwell": southwell, "gmres": gmres,
    "cg": cg, "direct": direct,
}  # fmt: skip


def solve_bands(
    solver: str, system: System, tolerance: float, force: bool = False, watch: Watch | None = None
) -> tuple[np.ndarray, list[float]]:
    """Solve a system by the solver of a name; bands that differ by a factor are solved once.

    ``force`` solves all of them. ``watch`` gets all bands.
    """
    scale, which = proportional_bands(system)
    first = np.unique(which, return_index=True)[1]
    if force or len(first) == len(which):
        return SOLVERS[solver](system, tolerance, watch)
    part = system.of_bands(first)
    part = replace(part, source=part.source / scale[first])
    seen = None if watch is None else lambda b: watch(b[:, which] * scale)
    b, history = SOLVERS[solver](part, tolerance, seen)
    return b[:, which] * scale, history


def proportional_bands(system: System) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest source of each band, 1 where there is none, and which bands are alike.

    Alike are bands of the same reflectances whose sources differ by a factor only, up to rounding.
    """
    scale = system.source.max(axis=0, initial=0.0)
    scale = np.where(scale > 0.0, scale, 1.0)
    shape = np.round(system.source / scale, ALIKE)
    both = np.concatenate([system.laws, shape])
    return scale, np.unique(both, axis=1, return_inverse=True)[1].ravel()
