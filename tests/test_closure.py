"""Repaired closure: row sums, reciprocity and signs; optimal, and no worse than before."""

import numpy as np
import pytest

from radiosity.analytic import box_form_factors
from radiosity.transport.closure import NotClosable, repaired
from radiosity.transport.operator import FormFactors, Openness

CLOSED = 1e-12  # what `repaired` promises


def symmetric(upper):
    return np.triu(upper) + np.triu(upper, 1).T


def perturbed(n, size, seed=0, zeros=0.0, certain=0.0, open_share=0.0):
    """Return (factors with errors of known spread, exact exchange, exact environment)."""
    rng = np.random.default_rng(seed)
    exact = symmetric(np.triu(rng.random((n, n)) ** 2 * (rng.random((n, n)) >= zeros), 1))
    spread = size * exact * 10 ** symmetric(rng.uniform(-1, 0, (n, n)))
    spread[symmetric(np.triu(rng.random((n, n)) < certain)) > 0] = 0.0
    share = open_share * rng.random(n)
    area = exact.sum(axis=1) / (1 - share)
    wrong = np.maximum(exact + spread * symmetric(rng.normal(size=(n, n))), 0.0)
    error = size * share
    seen = np.maximum(share + error * rng.normal(size=n), 0.0)
    return FormFactors(wrong, area, spread.astype(np.float32), Openness(seen, error)), exact, share


def assert_closed(factors):
    assert np.abs(factors.closure).max() <= CLOSED
    assert np.array_equal(factors.exchange, factors.exchange.T)
    assert factors.exchange.min() >= 0.0 and factors.environment.min() >= 0.0


def weights(factors):
    """Return (n, n) and (n,) weights of pairs and of the environment, with the floor."""
    w = factors.error.astype(float) ** 2 + (2.0**-52 * factors.exchange) ** 2
    w = np.where(factors.exchange > 0, w, 0.0)
    flux = factors.area * factors.environment
    return w, (factors.area * factors.openness.error) ** 2 + (2.0**-52 * flux) ** 2


def plain_repair(factors):
    """The slow twin: the dense KKT system in all changes and multipliers; signs left free."""
    n, (w, v) = len(factors.area), weights(factors)
    i, j = np.nonzero(np.triu(w))
    outer = np.flatnonzero(v)
    incidence = np.zeros((n, len(i) + len(outer)))
    incidence[i, np.arange(len(i))] = incidence[j, np.arange(len(i))] = 1.0
    incidence[outer, len(i) + np.arange(len(outer))] = 1.0
    sigma = np.sqrt(np.concatenate([w[i, j], v[outer]]))
    scaled = incidence * sigma
    kkt = np.block([[np.eye(len(sigma)), -scaled.T], [scaled, np.zeros((n, n))]])
    defect = -factors.closure * factors.area
    change = np.linalg.lstsq(kkt, np.concatenate([0 * sigma, defect]))[0][: len(sigma)] * sigma
    exchange, flux = factors.exchange.copy(), factors.area * factors.environment
    exchange[i, j] += change[: len(i)]
    flux[outer] += change[len(i) :]
    return symmetric(exchange), flux / factors.area


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("open_share", [0.0, 0.5])
def test_it_agrees_with_the_dense_twin(seed, open_share):
    factors, _, _ = perturbed(7, 1e-3, seed, zeros=0.2, open_share=open_share)
    result = repaired(factors)
    exchange, share = plain_repair(factors)
    assert_closed(result)
    scale = 1e-7 * np.abs(exchange - factors.exchange).max()  # float32 weights
    assert result.exchange == pytest.approx(exchange, abs=scale)
    assert result.environment == pytest.approx(share, abs=1e-9)


def test_a_group_that_sees_itself_moves_by_its_own_weight():
    factors, _, _ = perturbed(12, 1e-3)
    grouped = factors.grouped(np.arange(12) // 3)
    result = repaired(grouped)
    assert_closed(result)
    assert result.exchange == pytest.approx(plain_repair(grouped)[0], abs=1e-9)
    assert np.all(np.diag(result.exchange) != np.diag(grouped.exchange))


def test_exact_factors_stay_as_they_are():
    dims = (1.0, 2.0, 3.0)
    area = np.array([2.0, 2, 6, 6, 3, 3])
    exchange = symmetric(area[:, None] * box_form_factors(dims))
    result = repaired(FormFactors(exchange, area))
    assert_closed(result)
    assert result.exchange == pytest.approx(exchange, rel=1e-13, abs=0)  # what is left of closure
    already = repaired(result)
    assert np.array_equal(already.exchange, result.exchange)


@pytest.mark.parametrize("size", [1e-9, 1e-4, 0.3])
def test_errors_shrink_and_zeros_stay(size):
    factors, exact, _ = perturbed(80, size, zeros=0.3, certain=0.5)
    result = repaired(factors)
    assert_closed(result)
    before = np.linalg.norm(factors.exchange - exact)
    assert np.linalg.norm(result.exchange - exact) < before
    assert not result.exchange[factors.exchange == 0].any()
    assert np.array_equal(result.raw_closure, factors.closure)
    assert np.array_equal(result.error, factors.error)


def test_no_light_through_walls_however_uncertain():
    """Two rooms that no ray joins, with errors as of rays: they are closed each by itself."""
    factors, _, _ = perturbed(40, 1e-2, seed=3)
    room = np.arange(40) < 20
    between = room[:, None] != room[None]
    exchange = np.where(between, 0.0, factors.exchange)
    error = np.where(between, np.float32(0.1), factors.error)
    area = exchange.sum(axis=1) * np.random.default_rng(3).uniform(0.99, 1.01, 40)
    result = repaired(FormFactors(exchange, area, error))
    assert_closed(result)
    assert not result.exchange[between].any()


def test_certain_entries_move_by_rounding_only():
    factors, exact, _ = perturbed(60, 1e-2, certain=0.5)
    certain = (factors.error == 0) & (exact > 0)
    moved = np.abs(repaired(factors).exchange[certain] / exact[certain] - 1)
    assert moved.max() < 1e-15  # rounding; the others move by up to 1e-2


def test_a_rare_uncertain_pair_takes_what_it_can_and_certain_ones_the_rest():
    """Defects that differ in sign at the ends of the only uncertain pair: W is singular there."""
    factors, exact, _ = perturbed(10, 0.0)
    error = factors.error.copy()
    error[2, 5] = error[5, 2] = 1e-2
    area = factors.area.copy()
    area[2] += 1e-4
    area[5] -= 3e-4
    result = repaired(FormFactors(factors.exchange, area, error))
    assert_closed(result)
    assert result.exchange[2, 5] < exact[2, 5]
    assert np.abs(result.exchange - exact).max() < 2e-3  # of defects of 3e-4, not blown up


@pytest.mark.parametrize("seed", range(6))
def test_entries_held_at_zero_satisfy_the_conditions_of_the_minimum(seed):
    """Multipliers fit the free entries, and would push those at 0 further down."""
    factors, _, _ = perturbed(14, 0.6, seed, open_share=0.3)
    area = factors.area * np.where(np.arange(14) < 5, 0.6, 1.0)
    factors = FormFactors(factors.exchange, area, factors.error, factors.openness)
    result = repaired(factors)
    assert_closed(result)
    w, v = weights(factors)
    i, j = np.nonzero(np.triu(w))
    free = result.exchange[i, j] > 0
    assert 0 < np.count_nonzero(~free)
    incidence = np.zeros((len(i), 14))
    incidence[np.arange(len(i)), i] = incidence[np.arange(len(i)), j] = 1.0
    pull = (result.exchange - factors.exchange)[i, j] / w[i, j]
    flux = area * factors.environment
    outer = (area * result.environment - flux) / v
    open_rows = result.environment > 0
    equations = np.concatenate([incidence[free], np.eye(14)[open_rows]])
    lam, _, rank, _ = np.linalg.lstsq(equations, np.concatenate([pull[free], outer[open_rows]]))
    scale = np.abs(pull).max()
    assert rank == 14
    assert incidence[free] @ lam == pytest.approx(pull[free], abs=1e-6 * scale)
    assert np.all(incidence[~free] @ lam <= pull[~free] + 1e-6 * scale)


def test_the_environment_takes_its_share_by_its_error():
    """Row 0 misses 0.01: its pairs are certain, its environment is not."""
    exchange = np.array([[0, 0.5, 0.3], [0.5, 0, 0.5], [0.3, 0.5, 0]])
    openness = Openness(np.array([0.19, 0.0, 0.2]), np.array([0.05, 0.0, 0.05]))
    result = repaired(FormFactors(exchange, np.ones(3), None, openness))
    assert result.environment == pytest.approx([0.2, 0.0, 0.2], abs=1e-15)
    assert result.exchange == pytest.approx(exchange, rel=1e-15)


@pytest.mark.parametrize("seed", range(3))
def test_open_scenes_close_with_the_environment(seed):
    factors, exact, share = perturbed(50, 1e-2, seed, zeros=0.5, open_share=0.8)
    result = repaired(factors)
    assert_closed(result)
    before = np.linalg.norm(factors.environment - share)
    assert np.linalg.norm(result.environment - share) < before


def test_sealed_rows_stay_zero():
    factors, _, _ = perturbed(20, 1e-3)
    exchange, error, area = factors.exchange, factors.error.copy(), factors.area.copy()
    exchange[[3, 7]] = exchange[:, [3, 7]] = 0
    area = exchange.sum(axis=1) * 1.0001
    area[3] = 1.0
    openness = Openness(np.where(np.arange(20) == 7, 0.4, 0.0), np.zeros(20))
    sealed = FormFactors(exchange, area, error, openness)
    assert sealed.sealed.tolist() == [3, 7]
    result = repaired(sealed)
    assert_closed(result)
    assert not result.exchange[[3, 7]].any()
    assert result.environment[7] == 0.4


def test_weights_over_many_orders_of_magnitude():
    factors, exact, _ = perturbed(60, 0.0)
    rng = np.random.default_rng(5)
    spread = symmetric(10 ** rng.uniform(-15, -2, (60, 60))) * exact  # weights over 1e26
    wrong = exact + spread * symmetric(rng.normal(size=(60, 60)))
    result = repaired(FormFactors(wrong, factors.area, spread.astype(np.float32)))
    assert_closed(result)
    moved = np.abs(result.exchange - wrong)
    assert np.all(moved <= 20 * spread + 1e-15)  # no entry far beyond its own error


@pytest.mark.parametrize("area", [1e-18, 2.0**-40, 1e18])
def test_the_unit_of_length_does_not_matter(area):
    factors, _, _ = perturbed(30, 0.2, certain=0.3, open_share=0.3)
    scaled = FormFactors(
        area * factors.exchange, area * factors.area,
        (np.float64(area) * factors.error).astype(np.float32), factors.openness,
    )  # fmt: skip
    result, expected = repaired(scaled), repaired(factors)
    assert_closed(result)
    tolerance = 1e-6  # errors and weights are rounded to float32
    assert result.exchange / area == pytest.approx(expected.exchange, abs=tolerance)
    assert result.environment == pytest.approx(expected.environment, abs=tolerance)


def test_the_order_of_rows_does_not_matter():
    factors, _, _ = perturbed(30, 0.2, certain=0.3, open_share=0.3)
    order = np.random.default_rng(2).permutation(30)
    openness = Openness(factors.environment[order], factors.openness.error[order])
    block = np.ix_(order, order)
    shuffled = repaired(
        FormFactors(factors.exchange[block], factors.area[order], factors.error[block], openness)
    )
    expected = repaired(factors)
    assert shuffled.exchange == pytest.approx(expected.exchange[block], abs=1e-11)  # residual


def test_the_number_of_threads_does_not_matter(monkeypatch):
    factors, _, _ = perturbed(800, 0.3, zeros=0.2)  # in four ranges of rows
    results = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("RADIOSITY_THREADS", threads)
        results.append(repaired(factors).exchange)
    assert np.array_equal(results[0], results[1]) and np.array_equal(results[0], results[2])


def test_the_given_factors_are_left_alone():
    factors, _, _ = perturbed(10, 0.3, open_share=0.3)
    before = factors.exchange.copy(), factors.environment.copy()
    repaired(factors)
    assert np.array_equal(factors.exchange, before[0])
    assert np.array_equal(factors.environment, before[1])


def test_what_cannot_close_is_named():
    """Two rows that see only each other and have different areas."""
    with pytest.raises(NotClosable, match="row . of the form factors sums to 1") as caught:
        repaired(FormFactors(np.array([[0, 1.0], [1.0, 0]]), np.array([1.0, 2.0])))
    assert caught.value.row in (0, 1)
    assert abs(caught.value.defect) > 0.2


def test_two_rows_of_one_area_that_see_only_each_other_close():
    result = repaired(FormFactors(np.array([[0, 0.9], [0.9, 0]]), np.ones(2)))
    assert result.exchange == pytest.approx(np.array([[0, 1.0], [1.0, 0]]), abs=1e-12)


def test_one_contradiction_leaves_the_other_rows_as_they_were():
    """A pair apart that cannot close is what the error names, not a row that could."""
    factors, _, _ = perturbed(12, 1e-3)
    exchange, area = np.zeros((14, 14)), np.append(factors.area, [1.0, 2.0])
    exchange[:12, :12] = factors.exchange
    exchange[12, 13] = exchange[13, 12] = 1.0
    with pytest.raises(NotClosable) as caught:
        repaired(FormFactors(exchange, area))
    assert caught.value.row in (12, 13)


def test_a_row_that_is_not_a_number_is_named():
    factors, _, _ = perturbed(12, 1e-3)
    factors.exchange[4, 7] = np.nan
    with pytest.raises(NotClosable, match=r"row 4 .* 1 \+nan.*of row 4"):
        repaired(factors)


def test_the_row_whose_area_is_wrong_is_named():
    factors, _, _ = perturbed(12, 1e-3)
    factors.area[3] *= 40.0
    with pytest.raises(NotClosable, match="The largest defect before was .*, of row 3"):
        repaired(factors)


@pytest.mark.parametrize(("absorbed", "outside"), [(0.3, 0.0), (0.0, 0.3), (0.1, 0.2)])
def test_what_a_row_turns_out_to_lose_goes_where_others_lose_it(absorbed, outside):
    """Row 2 loses 0.2 more than rays found: to surfaces where no row sees the outside."""
    exchange = np.array([[0, 0.3, 0.4], [0.3, 0, 0.4], [0.4, 0.4, 0]])
    share = np.array([0.3, 0.3, 0.0])
    openness = Openness(share, np.array([0, 0, 0.2]), np.array([absorbed, absorbed, 0.0]))
    result = repaired(FormFactors(exchange, np.ones(3), None, openness))
    assert result.openness.share == pytest.approx([0.3, 0.3, 0.2])
    assert result.exchange == pytest.approx(exchange)
    assert result.environment[2] == pytest.approx(0.0 if outside == 0 else 0.2)
