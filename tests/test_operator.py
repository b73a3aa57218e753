"""The form-factor operator: products, sums, groups, openness."""

import numpy as np
import pytest

from radiosity.analytic import box_form_factors
from radiosity.transport.operator import FormFactors, Openness

ROUNDING = 1e-14  # sums over fewer than 20 terms near 1


def box(dims=(1.0, 2.0, 3.0)):
    """The exact factors of a box's six faces, symmetric to the bit."""
    x, y, z = dims
    area = np.array([x * y, x * y, y * z, y * z, x * z, x * z])
    g = np.triu(area[:, None] * box_form_factors(dims), 1)
    return FormFactors(g + g.T, area)


def random_factors(n=9, seed=0):
    """Open factors with errors; the last row sees nothing, the one before has no area."""
    rng = np.random.default_rng(seed)
    g, s = np.triu(rng.random((2, n, n)), 1)
    g[:, -2:] = s[:, -2:] = 0
    area = np.append(rng.uniform(8, 9, n - 2), [0.0, 1.0])
    share = np.append(rng.random(n - 2), [0.3, 0.0])
    return FormFactors(g + g.T, area, (s + s.T).astype(np.float32), Openness(share, share / 7))


def test_it_multiplies_as_its_array_does():
    factors = random_factors()
    x = np.random.default_rng(1).random((9, 3))
    assert factors @ x == pytest.approx(factors.toarray() @ x, rel=ROUNDING)
    assert factors @ x[:, 0] == pytest.approx(factors.toarray() @ x[:, 0], rel=ROUNDING)


def test_its_transpose_multiplies_as_its_arrays_does():
    factors = random_factors()
    for x in (np.arange(9.0), np.arange(18.0).reshape(9, 2)):
        assert factors.T @ x == pytest.approx(factors.toarray().T @ x, rel=1e-13)
        assert factors.H @ x == pytest.approx(factors.toarray().T @ x, rel=1e-13)


def test_rows_are_divided_by_the_area_that_light_leaves():
    dims = (1.0, 2.0, 3.0)
    assert box(dims).toarray() == pytest.approx(box_form_factors(dims), rel=1e-12)  # quadrature
    assert box(dims).row_sums() == pytest.approx(np.ones(6), rel=1e-12)


def test_a_box_is_closed_reciprocal_and_exposed():
    factors = box()
    assert factors.is_closed and factors.exposed.all() and factors.sealed.size == 0
    assert factors.reciprocity == 0.0
    assert np.abs(factors.closure).max() < 1e-12
    assert np.array_equal(factors.raw_closure, factors.closure)


def test_rows_without_sight_or_area_are_sealed_and_have_no_defect():
    factors = random_factors()
    assert factors.sealed.tolist() == [7, 8]
    assert not factors.exposed[7:].any() and factors.exposed[:7].all()
    assert factors.closure[7:].tolist() == [0.0, 0.0]
    expected = factors.toarray().sum(axis=1) + factors.environment - 1
    assert factors.closure[:7] == pytest.approx(expected[:7], abs=ROUNDING)
    assert np.isfinite(factors.toarray()).all()


def test_a_row_that_sees_only_the_environment_is_exposed():
    factors = FormFactors(np.zeros((2, 2)), np.ones(2), None, Openness(np.array([1.0, 0]), 0))
    assert factors.sealed.tolist() == [1] and not factors.is_closed


def test_reciprocity_finds_the_largest_difference_in_any_block():
    g = np.ones((600, 600))
    g[590, 3] = 1.25
    assert FormFactors(g, np.ones(600)).reciprocity == 0.25 / 1.25


def test_row_errors_sum_magnitudes_per_area():
    factors = random_factors()
    expected = factors.error[:7].sum(axis=1) / factors.area[:7]
    assert factors.row_errors()[:7] == pytest.approx(expected, rel=1e-6)  # float32
    assert factors.row_errors()[7:].tolist() == [0.0, 0.0]


def test_groups_are_sums_over_their_rows_and_columns():
    labels, places = np.array([1, 0, 0, 1, -1, 2, 2, 0, 1]), np.arange(27.0).reshape(9, 3)
    factors = random_factors().replaced(centroid=places)
    grouped = factors.grouped(labels)
    for g in range(3):
        rows = labels == g
        area = factors.area[rows]
        assert grouped.area[g] == pytest.approx(area.sum(), rel=ROUNDING)
        assert grouped.environment[g] == pytest.approx(
            np.average(factors.environment[rows], weights=area), rel=ROUNDING
        )
        middle = np.average(places[rows], axis=0, weights=area)
        assert grouped.centroid[g] == pytest.approx(middle, rel=1e-13)
        for h in range(3):
            block = np.ix_(rows, labels == h)
            assert grouped.exchange[g, h] == pytest.approx(factors.exchange[block].sum(), rel=1e-13)
            assert grouped.error[g, h] == pytest.approx(factors.error[block].sum(), rel=1e-6)
    assert np.array_equal(grouped.exchange, grouped.exchange.T)
    assert np.array_equal(grouped.error, grouped.error.T) and grouped.error.dtype == np.float32


def test_groups_of_a_closed_scene_are_closed():
    grouped = box().grouped(np.array([0, 0, 1, 1, 2, 1]))
    assert grouped.row_sums() == pytest.approx(np.ones(3), rel=1e-12)
    assert grouped.exchange[0, 0] > 0


def test_one_group_a_row_changes_nothing():
    factors = random_factors()
    grouped = factors.grouped(np.arange(9))
    assert np.array_equal(grouped.exchange, factors.exchange)
    assert np.array_equal(grouped.error, factors.error)


def test_wrong_labels_and_shapes_are_named():
    with pytest.raises(ValueError, match=r"float64 \(6,\).*int \(6,\)"):
        box().grouped(np.zeros(6))
    with pytest.raises(ValueError, match=r"int64 \(5,\)"):
        box().grouped(np.zeros(5, np.int64))
    with pytest.raises(ValueError, match="up to 1000000000, but .* below 6, the number of rows"):
        box().grouped(np.array([0, 1, 2, 3, 4, 10**9]))
    with pytest.raises(ValueError, match="up to 2, but must be below 2, the number of groups"):
        box().grouped(np.array([0, 1, 2, 0, 1, 2]), 2)
    with pytest.raises(ValueError, match=r"exchange has shape \(6, 6\), but must be \(5, 5\)"):
        FormFactors(box().exchange, np.ones(5))
    with pytest.raises(ValueError, match="error has shape"):
        FormFactors(box().exchange, np.ones(6), np.zeros((5, 5), np.float32))
