"""The solvers against each other, against numpy, and their error bounds against the truth."""

import numpy as np
import pytest

from radiosity.solve import methods
from radiosity.solve.methods import (
    SOLVERS,
    NotConverged,
    contraction,
    direct,
    gauss_seidel,
    gmres,
)
from radiosity.transport.operator import FormFactors


def random_system(rng, n=40, bands=3, most=0.9, closed=True):
    """Symmetric exchange areas, positive and of row sum 1 (or up to 1), and random terms."""
    exchange = rng.random((n, n)) * (rng.random((n, n)) < 0.5)
    exchange += exchange.T + 0.01
    np.fill_diagonal(exchange, 0)
    area = exchange.sum(axis=1) * (1 if closed else rng.uniform(1.0, 2.0, n))
    rho = rng.uniform(0, most, (n, bands))
    emission = rng.random((n, bands)) * (rng.random((n, 1)) < 0.2)
    emission[0] = 1.0
    return FormFactors(exchange, area), rho, emission


def plain(factors, rho, emission):
    matrix = factors.toarray()
    n, bands = rho.shape
    solved = [
        np.linalg.solve(np.eye(n) - rho[:, k, None] * matrix, emission[:, k]) for k in range(bands)
    ]
    return np.stack(solved, axis=1)


def test_the_operator_is_its_matrix():
    rng = np.random.default_rng(0)
    factors, _, emission = random_system(rng)
    matrix = factors.toarray()
    assert factors @ emission == pytest.approx(matrix @ emission, rel=1e-13)
    assert factors @ emission[:, 0] == pytest.approx(matrix @ emission[:, 0], rel=1e-13)
    assert factors.row_sums() == pytest.approx(matrix.sum(axis=1), rel=1e-13)
    assert contraction(factors, np.full((40, 1), 0.7)) == pytest.approx(0.7, rel=1e-13)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("most", [0.0, 0.5, 0.99])
def test_all_solvers_give_what_numpy_gives(name, closed, most):
    rng = np.random.default_rng(1)
    for _ in range(5):
        system = random_system(rng, most=most, closed=closed)
        b, history = SOLVERS[name](*system, 1e-10)
        expected = plain(*system)
        assert b == pytest.approx(expected, abs=1e-10 * expected.max())  # the tolerance asked
        assert history[-1] <= 1e-10


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-6])
def test_the_bound_is_no_lie(name, tolerance):
    rng = np.random.default_rng(2)
    for _ in range(10):
        system = random_system(rng, n=20, most=0.95)
        b, history = SOLVERS[name](*system, tolerance)
        expected = plain(*system)
        error = np.abs(b - expected).max() / np.abs(b).max()
        assert error <= history[-1] * (1 + 1e-9) + 1e-14  # 1e-14: rounding of the plain solution
        assert history[-1] <= tolerance


def test_the_bound_is_at_most_the_condition_too_large():
    """At reflectance .9 everywhere the bound is at most (1 + .9)/(1 - .9) times the error."""
    rng = np.random.default_rng(3)
    factors, _, emission = random_system(rng)
    rho = np.full((40, 3), 0.9)
    b, history = gauss_seidel(factors, rho, emission, 1e-3)
    error = np.abs(b - plain(factors, rho, emission)).max() / np.abs(b).max()
    assert history[-1] <= 19 * error * (1 + 1e-9)


def test_gauss_seidel_is_twice_as_fast_as_bounces():
    """A bounce (Jacobi) shrinks the error by rho; a sweep of a dense, even system by rho^2."""
    n, rho = 100, 0.8
    exchange = np.ones((n, n)) - np.eye(n)
    factors = FormFactors(exchange, exchange.sum(axis=1))
    emission = np.zeros((n, 1))
    emission[:7] = 1.0
    _, history = gauss_seidel(factors, np.full((n, 1), rho), emission, 1e-12)
    rate = (history[-1] / history[4]) ** (1 / (len(history) - 5))
    speed = np.log(rate) / np.log(rho)
    assert 1.7 < speed < 3.0  # 2 for two-cyclic systems, a little more here
    bounces = np.log(1e-12) / np.log(rho)
    assert len(history) < 0.6 * bounces


def test_history_falls_steadily():
    rng = np.random.default_rng(4)
    _, history = gauss_seidel(*random_system(rng, most=0.95), 1e-10)
    assert np.all(np.diff(history) < 0)


@pytest.mark.parametrize("name", SOLVERS)
def test_bands_do_not_mix(name):
    factors, rho, emission = random_system(np.random.default_rng(5))
    emission[:, 1] = 0.0
    together, _ = SOLVERS[name](factors, rho, emission, 1e-12)
    assert np.all(together[:, 1] == 0)
    alone, _ = SOLVERS[name](factors, rho[:, :1], emission[:, :1], 1e-12)
    assert together[:, :1] == pytest.approx(alone, rel=1e-10)


@pytest.mark.parametrize("name", SOLVERS)
def test_solutions_scale_with_the_emission(name):
    factors, rho, emission = random_system(np.random.default_rng(6))
    one, _ = SOLVERS[name](factors, rho, emission, 1e-11)
    for size in (1e-12, 1e12):
        other, _ = SOLVERS[name](factors, rho, size * emission, 1e-11)
        assert other / size == pytest.approx(one, abs=1e-10 * one.max())


@pytest.mark.parametrize("name", SOLVERS)
def test_terms_are_left_as_they_were(name):
    factors, rho, emission = random_system(np.random.default_rng(7))
    before = rho.copy(), emission.copy()
    SOLVERS[name](factors, rho, emission, 1e-6)
    assert np.array_equal(rho, before[0]) and np.array_equal(emission, before[1])


@pytest.mark.parametrize("name", SOLVERS)
def test_darkness_is_solved(name):
    factors, rho, emission = random_system(np.random.default_rng(8))
    b, history = SOLVERS[name](factors, rho, 0 * emission, 1e-6)
    assert np.all(b == 0) and history[-1] == 0


def test_near_reflectance_1_direct_still_holds():
    n = 30
    exchange = np.ones((n, n)) - np.eye(n)
    factors = FormFactors(exchange, exchange.sum(axis=1))
    for left in (1e-3, 1e-6, 1e-9):
        b, _ = direct(factors, np.full((n, 1), 1 - left), np.ones((n, 1)), 1e-6)
        # 1e-16/left: rounding of 1 - rho in double precision
        assert b == pytest.approx(np.full((n, 1), 1 / left), rel=1e-14 + 1e-15 / left)


@pytest.mark.parametrize("solver, said", [(gauss_seidel, "Gauss-Seidel"), (gmres, "GMRES")])
def test_iterations_stop_and_say_where_they_are(solver, said, monkeypatch):
    monkeypatch.setattr(methods, "LIMIT", 3 if solver is gauss_seidel else 1)
    factors, _, emission = random_system(np.random.default_rng(9), n=200)
    rho = np.full(emission.shape, 0.9999)
    with pytest.raises(NotConverged, match="use --solver direct") as stopped:
        solver(factors, rho, emission, 1e-14)
    assert str(stopped.value).startswith(f"{said} stopped at an error bound of ")
    assert len(stopped.value.history) >= 3
    assert f"{stopped.value.history[-1]:.2e}" in str(stopped.value)


def test_a_singular_system_is_refused_by_every_solver(monkeypatch):
    """Reflectance 1 in a closed scene: no bound holds, and none is claimed."""
    monkeypatch.setattr(methods, "LIMIT", 20)
    factors, _, emission = random_system(np.random.default_rng(10))
    rho = np.ones(emission.shape)
    for name in ("gauss-seidel", "gmres"):
        with pytest.raises(NotConverged):
            SOLVERS[name](factors, rho, emission, 1e-6)
