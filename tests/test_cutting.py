"""Cutting cells: areas add up, parts stay convex and as they wind, slivers are left alone."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, rotation

from radiosity.mesh.cutting import cut_cell


def vector_areas(parts):
    return 0.5 * np.cross(parts[:, 2] - parts[:, 0], parts[:, 3] - parts[:, 1])


def is_convex(part, normal):
    corners = part[:3] if np.array_equal(part[2], part[3]) else part
    edge = np.roll(corners, -1, axis=0) - corners
    return ((np.cross(edge, np.roll(edge, -1, axis=0)) @ normal) > -1e-12).all()


def line(*ends):
    return np.array([[*ends[0], 0], [*ends[1], 0]], float)


def test_no_segment_leaves_the_cell_as_it_is():
    assert np.array_equal(cut_cell(SQUARE, np.empty((0, 2, 3))), SQUARE[None])


def test_a_line_across_makes_two_rectangles():
    parts = cut_cell(SQUARE, line((0.25, -1), (0.25, 2))[None])
    assert sorted(vector_areas(parts)[:, 2]) == pytest.approx([0.25, 0.75], rel=1e-14)
    assert not any(np.array_equal(p[2], p[3]) for p in parts)


def test_a_diagonal_makes_two_triangles():
    parts = cut_cell(SQUARE, line((0, 0), (1, 1))[None])
    assert len(parts) == 2 and all(np.array_equal(p[2], p[3]) for p in parts)


def test_a_segment_that_ends_inside_cuts_along_its_whole_line():
    parts = cut_cell(SQUARE, line((0.4, 0.3), (0.4, 0.5))[None])
    assert sorted(vector_areas(parts)[:, 2]) == pytest.approx([0.4, 0.6], rel=1e-14)


@pytest.mark.parametrize(
    "segment",
    [
        line((2, 0), (2, 1)),  # beside
        line((0.5, 1.1), (0.5, 2)),  # its line passes through, it does not
        line((0, 0), (1, 0)),  # along an edge
        line((0.5, 1), (0.5, 2)),  # ends on an edge
        line((1e-6, -1), (1e-6, 2)),  # would cut off a sliver below 1e-5 of the area
    ],
)
def test_segments_that_do_not_reach_the_inside_cut_nothing(segment):
    assert len(cut_cell(SQUARE, segment[None])) == 1


def test_a_footprint_is_cut_out():
    corners = [(0.3, 0.2), (0.7, 0.2), (0.7, 0.6), (0.3, 0.6)]
    edges = [line(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    parts = cut_cell(SQUARE, np.array(edges))
    middle = parts.mean(axis=1)
    inside = np.all((middle[:, :2] > [0.3, 0.2]) & (middle[:, :2] < [0.7, 0.6]), axis=1)
    assert vector_areas(parts[inside])[:, 2].sum() == pytest.approx(0.16, rel=1e-13)
    assert vector_areas(parts)[:, 2].sum() == pytest.approx(1.0, rel=1e-13)


def test_random_cuts_keep_area_plane_winding_and_convexity():
    rng = np.random.default_rng(0)
    for _ in range(100):
        turn, size = rotation(rng), 10 ** rng.uniform(-4, 4)
        angle = np.cumsum(rng.uniform(0.4, 1.4, 4))
        cell = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        cell = cell if rng.random() < 0.6 else cell[[0, 1, 2, 2]]
        ends = rng.uniform(-1, 1, (rng.integers(1, 5), 2, 2))
        segments = np.dstack([ends, np.zeros(ends.shape[:2])])
        parts = cut_cell(size * cell @ turn.T, size * segments @ turn.T)
        whole = vector_areas(size * cell[None] @ turn.T)[0]
        # 1e-12: rounding of crossings, a few a part
        assert vector_areas(parts).sum(axis=0) == pytest.approx(whole, abs=1e-12 * size**2)
        assert np.linalg.norm(vector_areas(parts), axis=1).sum() == pytest.approx(
            np.linalg.norm(whole), rel=1e-12
        )
        assert all(is_convex(p / size, turn[:, 2]) for p in parts)


def test_the_order_of_cuts_does_not_change_what_is_covered():
    rng = np.random.default_rng(1)
    ends = rng.uniform(0, 1, (4, 2, 2))
    segments = np.dstack([ends, np.zeros((4, 2))])
    one, two = cut_cell(SQUARE, segments), cut_cell(SQUARE, segments[::-1])
    assert vector_areas(one).sum(0) == pytest.approx(vector_areas(two).sum(0), rel=1e-13)
