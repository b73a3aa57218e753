"""Outlines that run to holes and back, as convex faces."""

import numpy as np
import pytest

from radiosity.mesh.keyholes import has_seams, seamed_parts
from radiosity.mesh.triangulate import NoArea

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
HOLE = [[1, 1], [1, 2], [2, 2], [2, 1], [1, 1]]
DIAMOND = [[3, 2.5], [2.5, 3], [3, 3.5], [3.5, 3], [3, 2.5]]


def outline(*rings, degrees=0.0):
    """Rings in a plane that is turned, one after the other; back to the first point in between."""
    flat = np.array([p for k, ring in enumerate(rings) for p in ring + [rings[0][0]] * (k > 0)])
    points = np.concatenate([flat, np.zeros((len(flat), 1))], axis=1)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[c, s, 0], [-s * 0.6, c * 0.6, 0.8], [0.8 * s, -0.8 * c, 0.6]]) + 5.0


def areas(quads):
    return 0.5 * np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])


@pytest.mark.parametrize("degrees", [0.0, 17.0])
def test_two_holes_are_left_out(degrees):
    polygon = outline(SQUARE, HOLE, DIAMOND, degrees=degrees)
    assert has_seams(polygon)
    parts = areas(seamed_parts(polygon))
    normal = parts.sum(axis=0) / np.linalg.norm(parts.sum(axis=0))
    assert (parts @ normal > 0).all()  # all look one way
    assert np.linalg.norm(parts.sum(axis=0)) == pytest.approx(16 - 1 - 0.5, rel=1e-12)


def test_the_way_round_is_kept():
    polygon = outline(SQUARE, HOLE)
    one, other = (areas(seamed_parts(p)).sum(axis=0) for p in (polygon, polygon[::-1]))
    np.testing.assert_allclose(one, -other, rtol=1e-12)


def test_few_faces_are_made_and_none_covers_a_hole():
    quads = seamed_parts(outline(SQUARE, HOLE))
    assert len(quads) == 4
    low, high = quads.min(axis=1), quads.max(axis=1)
    middle = outline([[1.5, 1.5]])[0]
    assert not ((low < middle) & (middle < high)).all(axis=1).any()


def test_vertices_that_differ_by_rounding_are_one():
    polygon = outline(SQUARE, HOLE)
    polygon += np.random.default_rng(1).uniform(-1e-9, 1e-9, polygon.shape)
    assert has_seams(polygon)
    assert len(seamed_parts(polygon)) == 4


def test_an_outline_without_seams_has_none():
    assert not has_seams(outline(SQUARE)[:-1])


def test_there_and_back_has_no_area():
    with pytest.raises(NoArea):
        seamed_parts(outline([[0, 0], [1, 0], [2, 0], [1, 0]]))
