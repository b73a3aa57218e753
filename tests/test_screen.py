"""Runs of polygons at once against the scalar code and plain sums."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE
from test_exchange import geometry_of
from test_polygon import random_polygon

from radiosity.transport.exchange import FEWEST, FIRST, MOST, _product_rule
from radiosity.transport.polygon import heights
from radiosity.transport.screen import (
    HIGH_I,
    HIGH_J,
    LOW_I,
    LOW_J,
    RUN,
    make_columns,
    products,
    screen,
)
from radiosity.transport.screen import SQUARE as SQUARED

COUNT = 2 * RUN + 7  # two whole runs and a short one
RUNS = [(0, RUN), (1, RUN), (RUN, RUN), (COUNT - 7, 7), (5, 1), (5, 0)]


@pytest.fixture(scope="module")
def geometry():
    rng = np.random.default_rng(1)
    size = 10 ** rng.uniform(-2, 0, COUNT)
    polygons = [random_polygon(rng, size=s) + rng.normal(size=3) for s in size]
    return geometry_of(np.stack(polygons))[0]


@pytest.fixture(scope="module")
def columns(geometry):
    return make_columns(geometry)


@pytest.mark.parametrize("first, count", RUNS)
def test_heights_and_distances_agree_with_the_scalar_ones(geometry, columns, first, count):
    for i in (0, 17, COUNT - 1):
        table = np.full((6, RUN), np.nan)
        screen(columns, geometry, i, first, count, table)
        assert np.isnan(table[:, count:]).all()  # nothing is written beyond the run
        for k in range(count):
            j = first + k
            ci, cj = geometry.centroid[i], geometry.centroid[j]
            of_i = heights(geometry.vertices[i], cj, geometry.normal[j])
            of_j = heights(geometry.vertices[j], ci, geometry.normal[i])
            # 2e-15: three products of coordinates below 2; reached 4e-16
            assert table[[LOW_I, HIGH_I], k] == pytest.approx(of_i, rel=0, abs=2e-15)
            assert table[[LOW_J, HIGH_J], k] == pytest.approx(of_j, rel=0, abs=2e-15)
            assert table[SQUARED, k] == pytest.approx(((ci - cj) ** 2).sum(), rel=1e-15, abs=0)


@pytest.mark.parametrize("points", range(FEWEST, MOST + 1))
@pytest.mark.parametrize("first, count", RUNS)
def test_products_agree_with_the_scalar_ones(geometry, columns, points, first, count):
    for i in (0, 17, COUNT - 1):
        out = np.full(RUN, np.nan)
        products(columns, geometry, i, first, count, points, out)
        assert np.isnan(out[count:]).all()
        for k in range(count):
            if first + k == i:
                continue  # its points coincide with themselves
            expected = _product_rule(geometry, i, first + k, points, points)
            size = np.abs(plain_terms(geometry, i, first + k, points)).sum()
            # 1e-14 of the terms: up to 36 x 36 of either sign in another order
            assert out[k] == pytest.approx(expected, rel=0, abs=1e-14 * size)


def plain_terms(geometry, i, j, points):
    """w w' cos cos' / (pi r^2) of all pairs of points, with its sign."""
    part = slice(FIRST[points], FIRST[points + 1])
    r = geometry.points[j][:, None, part] - geometry.points[i][:, part, None]
    one = np.einsum("cab,c->ab", r, geometry.normal[i])
    two = np.einsum("cab,c->ab", -r, geometry.normal[j])
    weights = np.outer(geometry.weights[i, part], geometry.weights[j, part])
    return weights * one * two / ((r * r).sum(axis=0) ** 2 * np.pi)


def test_products_agree_with_plain_sums(geometry, columns):
    out = np.empty(RUN)
    for points in range(FEWEST, MOST + 1):
        products(columns, geometry, 3, RUN, RUN, points, out)
        for k in range(RUN):
            terms = plain_terms(geometry, 3, RUN + k, points)
            # 1e-14 of the terms: sums in another order
            assert out[k] == pytest.approx(terms.sum(), rel=0, abs=1e-14 * np.abs(terms).sum())


def test_two_far_squares_by_hand():
    """At distance d: A A' / (pi d^2), wrong by 2 / (3 d^2)."""
    above = SQUARE[::-1] + [0, 0, 100.0]
    geometry, unit = geometry_of(np.stack([SQUARE, above]))
    out, table = np.empty(RUN), np.empty((6, RUN))
    products(make_columns(geometry), geometry, 0, 1, 1, FEWEST, out)
    assert out[0] * unit == pytest.approx((1 - 2 / 3e4) / (np.pi * 1e4), rel=1e-7, abs=0)
    screen(make_columns(geometry), geometry, 0, 1, 1, table)
    assert table[SQUARED, 0] * unit == pytest.approx(1e4, rel=1e-14)
    assert table[[LOW_I, HIGH_I, LOW_J, HIGH_J], 0] * unit**0.5 == pytest.approx(100.0, rel=1e-14)
