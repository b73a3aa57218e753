"""Factors between linear elements: rows of closed rooms, constant fields, what leaves open ones."""

import numpy as np
import pytest
from scenes_for_tests import block, box, faces_of, meshed

from radiosity.analytic import box_form_factors
from radiosity.mesh.elements import make_elements
from radiosity.transport.arrival import make_senders
from radiosity.transport.factors import patch_geometry
from radiosity.transport.linear import linear_factors

ROOM = np.concatenate([
    box((0, 0, 0), (1, 1, 1)), block((0.3, 0.3, 0), (0.5, 0.6, 0.4), False)])  # fmt: skip


def factors_of(polygons, n, tolerance=0.0):
    visibility, _, patches = meshed(faces_of(polygons), n)
    rows = np.flatnonzero(~patches.covered)
    middle = patches.centroid[rows]
    under = (middle[:, 2] == 0) & np.all(np.abs(middle[:, :2] - [0.4, 0.45]) < [0.1, 0.15], axis=1)
    rows = rows[~under] if len(polygons) > 6 else rows
    elements = make_elements(patches, rows, 1)
    geometry = patch_geometry(patches, visibility, rows)
    senders = make_senders(elements, geometry, visibility, tolerance)
    return elements, linear_factors(senders, patches.area[rows])


@pytest.mark.parametrize("tolerance", [0.0, 1e-4, 1e-2])
def test_rows_of_a_closed_room_sum_to_1_whatever_the_tolerance(tolerance):
    """A constant field arrives as it is: slopes 0, and means 1 up to rounding."""
    elements, factors = factors_of(ROOM, 4, tolerance)
    n = len(elements)
    one = np.concatenate([np.ones(n), np.zeros(2 * n)])
    assert factors @ one == pytest.approx(one, abs=1e-12)
    assert not factors.outside.any()


def test_an_open_box_loses_what_its_lid_would_get():
    elements, factors = factors_of(box((0, 0, 0), (1, 1, 1))[[0, 2, 3, 4, 5]], 6)
    lost = factors.outside[: len(elements)].reshape(5, -1).mean(axis=1)
    exact = box_form_factors((1, 1, 1))[[0, 2, 3, 4, 5], 1]
    assert lost == pytest.approx(exact, abs=2e-3)  # means by 2 x 2 points beside shared edges
    one = np.repeat([1.0, 0.0, 0.0], len(elements))[:, None]
    escaping = factors.escaping(elements, one)[:, 0]
    assert escaping == pytest.approx(factors.outside[: len(elements)], rel=1e-12)


def test_without_slopes_only_means_are_exchanged():
    elements, factors = factors_of(ROOM, 2)
    n, flat = len(elements), factors.without_slopes()
    assert np.array_equal(flat.matrix[:n, :n], factors.matrix[:n, :n])
    assert not flat.matrix[n:].any() and not flat.matrix[:, n:].any()
    assert factors.matrix[n:].any() and not flat.outside[n:].any()
