"""The solvers against each other, against numpy, and their error bounds against the truth."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scenes_for_tests import box, scene
from scipy.sparse.linalg import aslinearoperator

from radiosity.solve import methods
from radiosity.solve.equations import System
from radiosity.solve.methods import (
    SOLVERS,
    NotConverged,
    cg,
    direct,
    gauss_seidel,
    gmres,
    jacobi,
    southwell,
)
from radiosity.solve.plan import SOLVER_NAMES
from radiosity.solve.solve import solve
from radiosity.transport.operator import FormFactors, Openness


def random_system(rng, n=40, bands=3, most=0.9, closed=True):
    """Symmetric exchange areas, positive and of row sum 1 (or up to 1), and random terms."""
    exchange = rng.random((n, n)) * (rng.random((n, n)) < 0.5)
    exchange += exchange.T + 0.01
    np.fill_diagonal(exchange, 0)
    area = exchange.sum(axis=1) * (1 if closed else rng.uniform(1.0, 2.0, n))
    rho = rng.uniform(0, most, (n, bands))
    emission = rng.random((n, bands)) * (rng.random((n, 1)) < 0.2)
    emission[0] = 1.0
    share = 1.0 - exchange.sum(axis=1) / area
    openness = Openness(np.where(share > 1e-15, share, 0.0), np.zeros(n))
    return system_of(FormFactors(exchange, area, openness=openness), rho, emission)


def system_of(factors, rho, emission):
    return System(factors, rho, 1.0 - rho, emission)


def even_room(n, rho, lamps=7):
    """n patches that see each other alike, of which the first emit."""
    exchange = np.ones((n, n)) - np.eye(n)
    emission = np.zeros((n, 1))
    emission[:lamps] = 1.0
    return system_of(
        FormFactors(exchange, exchange.sum(axis=1)), np.full((n, 1), float(rho)), emission
    )


def plain(system):
    factors, rho, emission = system.factors, system.reflectance, system.source
    matrix = factors.toarray()
    n, bands = rho.shape
    solved = [
        np.linalg.solve(np.eye(n) - rho[:, k, None] * matrix, emission[:, k]) for k in range(bands)
    ]
    return np.stack(solved, axis=1)


def test_the_operator_is_its_matrix():
    rng = np.random.default_rng(0)
    system = random_system(rng)
    factors, emission = system.factors, system.source
    matrix = factors.toarray()
    assert factors @ emission == pytest.approx(matrix @ emission, rel=1e-13)
    assert factors @ emission[:, 0] == pytest.approx(matrix @ emission[:, 0], rel=1e-13)
    assert factors.row_sums() == pytest.approx(matrix.sum(axis=1), rel=1e-13)
    assert even_room(40, 0.7).margin == pytest.approx(0.3, rel=1e-13)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("most", [0.0, 0.5, 0.99])
def test_all_solvers_give_what_numpy_gives(name, closed, most):
    rng = np.random.default_rng(1)
    for _ in range(5):
        system = random_system(rng, most=most, closed=closed)
        b, history = SOLVERS[name](system, 1e-10)
        expected = plain(system)
        assert b == pytest.approx(expected, abs=1e-10 * expected.max())  # the tolerance asked
        assert history[-1] <= 1e-10


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-6])
def test_the_bound_is_no_lie(name, tolerance):
    rng = np.random.default_rng(2)
    for n in (20, 20, 20, 150):  # more than Gauss-Seidel takes at once
        system = random_system(rng, n=n, most=0.95)
        b, history = SOLVERS[name](system, tolerance)
        expected = plain(system)
        error = np.abs(b - expected).max() / np.abs(b).max()
        assert error <= history[-1] * (1 + 1e-9) + 1e-14  # 1e-14: rounding of the plain solution
        assert history[-1] <= tolerance


def test_the_bound_is_at_most_the_condition_too_large():
    """At reflectance .9 everywhere the bound is at most (1 + .9)/(1 - .9) times the error."""
    rng = np.random.default_rng(3)
    system = random_system(rng)
    system = system_of(system.factors, np.full((40, 3), 0.9), system.source)
    b, history = gauss_seidel(system, 1e-3)
    error = np.abs(b - plain(system)).max() / np.abs(b).max()
    assert history[-1] <= 19 * error * (1 + 1e-9)


def test_history_falls_steadily():
    rng = np.random.default_rng(4)
    _, history = gauss_seidel(random_system(rng, most=0.95), 1e-10)
    assert np.all(np.diff(history) < 0)


@pytest.mark.parametrize("name", SOLVERS)
def test_bands_do_not_mix(name):
    system = random_system(np.random.default_rng(5))
    factors, rho, emission = system.factors, system.reflectance, system.source
    emission[:, 1] = 0.0
    together, _ = SOLVERS[name](system, 1e-12)
    assert np.all(together[:, 1] == 0)
    alone, _ = SOLVERS[name](system_of(factors, rho[:, :1], emission[:, :1]), 1e-12)
    assert together[:, :1] == pytest.approx(alone, rel=1e-10)


@pytest.mark.parametrize("name", SOLVERS)
def test_solutions_scale_with_the_emission(name):
    system = random_system(np.random.default_rng(6))
    one, _ = SOLVERS[name](system, 1e-11)
    for size in (1e-12, 1e12):
        other, _ = SOLVERS[name](replace(system, source=size * system.source), 1e-11)
        assert other / size == pytest.approx(one, abs=1e-10 * one.max())


@pytest.mark.parametrize("name", SOLVERS)
def test_terms_are_left_as_they_were(name):
    system = random_system(np.random.default_rng(7))
    before = system.reflectance.copy(), system.source.copy()
    SOLVERS[name](system, 1e-6)
    assert np.array_equal(system.reflectance, before[0])
    assert np.array_equal(system.source, before[1])


@pytest.mark.parametrize("name", SOLVERS)
def test_darkness_is_solved(name):
    system = random_system(np.random.default_rng(8))
    b, history = SOLVERS[name](replace(system, source=0 * system.source), 1e-6)
    assert np.all(b == 0) and history[-1] == 0


@pytest.mark.parametrize("left", [1e-3, 1e-6, 1e-9, 1e-12])
def test_near_reflectance_1_direct_is_right_to_rounding(left):
    """A furnace, and one emitter of 30: means and differences against exact fractions.

    n equal patches, one emits 1: B_other = rho E_other, and with absorptance a the two kinds of B
    solve a 2 x 2 system, here in fractions.
    """
    n = 30
    exchange = np.ones((n, n)) - np.eye(n)
    factors = FormFactors(exchange, exchange.sum(axis=1))
    a = Fraction(left)
    rho = np.full((n, 1), float(1 - a))
    for lamps in (n, 1):
        source = np.zeros((n, 1))
        source[:lamps] = 1.0
        b, _ = direct(System(factors, rho, np.full((n, 1), left), source), 1e-6)
        r, others = 1 - a, n - 1
        if lamps == n:
            assert b[:, 0] == pytest.approx(np.full(n, float(1 / a)), rel=1e-13)
            continue
        # x = 1 + r y, y = r (x + (others - 1) y) / others
        y = (r / others) / (1 - r * r / others - r * Fraction(others - 1, others))
        x = 1 + r * y
        assert b[1:, 0] == pytest.approx(np.full(n - 1, float(y)), rel=1e-13)
        # 1e-15 / left: what rounding of B itself leaves of a difference
        assert b[0, 0] - b[1, 0] == pytest.approx(float(x - y), rel=1e-13 + 1e-15 / left)


def test_near_reflectance_1_open_rooms_lose_by_their_openness():
    """All rows reflect all and lose a share out: B from the plain matrix in fractions."""
    n, share = 5, 1e-9
    exchange = np.ones((n, n)) - np.eye(n)
    area = np.full(n, (n - 1) / (1 - share))
    factors = FormFactors(exchange, area, openness=Openness(np.full(n, share), np.zeros(n)))
    system = System(factors, np.ones((n, 1)), np.zeros((n, 1)), np.ones((n, 1)))
    b, _ = direct(system, 1e-6)
    assert b[:, 0] == pytest.approx(np.full(n, 1 / share), rel=1e-7)  # the share's own digits


def test_the_direct_solver_bounds_its_error_where_single_rows_absorb_nothing():
    """No row but one loses light: 1 / min(1 - rho row sum) would be infinite."""
    found = solve(scene(box((0, 0, 0), (4, 3, 2.5)), [1, 1, 1, 1, 1, 0.5], [0, 1, 0, 0, 0, 0]), 0.1)
    assert found.solver == "direct" and 0.0 < found.history[-1] < 1e-10


def test_bounds_with_a_gain_of_their_own_hold():
    system = random_system(np.random.default_rng(2), n=30)
    matrix = np.eye(30) - system.reflectance[:, :1] * system.factors.toarray()
    exact = np.linalg.solve(matrix, system.source[:, :1])
    one = System(system.factors, *(x[:, :1] for x in (
        system.reflectance, system.absorptance, system.source)))  # fmt: skip
    off = exact + 0.01 * np.random.default_rng(3).normal(size=exact.shape)
    gain = np.abs(np.linalg.inv(matrix)).sum(axis=1).max()
    error = np.abs(off - exact).max() / np.abs(off).max()
    assert error <= one.bound(off, gain=np.array([gain])) <= one.bound(off) * (1 + 1e-9)


@pytest.mark.parametrize(
    "solver, said",
    [
        (gauss_seidel, "Gauss-Seidel"), (gmres, "GMRES"), (jacobi, "Jacobi"), (cg, "CG"),
        (southwell, "Southwell"),
    ],
)  # fmt: skip
def test_iterations_stop_and_say_where_they_are(solver, said, monkeypatch):
    monkeypatch.setattr(methods, "LIMIT", 1 if solver is gmres else 3)
    system = random_system(np.random.default_rng(9), n=200)
    system = system_of(system.factors, np.full(system.source.shape, 0.9999), system.source)
    with pytest.raises(NotConverged, match="use --solver direct") as stopped:
        solver(system, 1e-14)
    assert str(stopped.value).startswith(f"{said} stopped at an error bound of ")
    assert len(stopped.value.history) >= 3
    assert f"{stopped.value.history[-1]:.2e}" in str(stopped.value)


def test_a_singular_system_is_refused_by_every_solver(monkeypatch):
    """Reflectance 1 in a closed scene: no bound holds, and none is claimed."""
    monkeypatch.setattr(methods, "LIMIT", 20)
    system = random_system(np.random.default_rng(10))
    system = system_of(system.factors, np.ones(system.source.shape), system.source)
    for name in SOLVERS:
        with pytest.raises(NotConverged):
            SOLVERS[name](system, 1e-6)


def test_southwell_shows_useful_pictures_early():
    """With the ambient correction the mean is right from the start; shooting alone lacks light."""
    system, seen = even_room(100, 0.8), []
    b, _ = southwell(system, 1e-6, seen.append)
    assert len(seen) >= methods.PICTURES
    first = seen[0].mean()
    assert first == pytest.approx(b.mean(), rel=0.02)
    assert seen[-1] == pytest.approx(b, rel=1e-3)


@pytest.mark.parametrize("solver", [jacobi, gauss_seidel])
def test_iterates_are_shown(solver):
    seen = []
    b, history = solver(even_room(20, 0.5), 1e-6, lambda x: seen.append(x.copy()))
    assert len(seen) == len(history) - 1
    assert np.abs(seen[-1] - b).max() < np.abs(seen[0] - b).max()


def test_cg_refuses_factors_that_are_not_symmetric():
    system = even_room(5, 0.5)
    with pytest.raises(ValueError, match="needs reciprocal factors: use order 0, or gmres"):
        cg(replace(system, factors=aslinearoperator(system.factors.toarray())), 1e-6)


def test_the_names_that_plans_know_are_those_of_the_solvers():
    """Plans are made without loading them."""
    assert tuple(SOLVERS) == SOLVER_NAMES
