"""Linear elements: what is linear is kept, means are means, and nothing depends on the frame."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, faces_of, meshed, rotation

from radiosity.mesh.elements import make_elements, make_nodes
from radiosity.transport.arrival import all_weights, make_senders
from radiosity.transport.factors import patch_geometry

SHAPES = {
    "square": SQUARE,
    "long": SQUARE * [7, 0.01, 1],
    "triangle": SQUARE[[0, 1, 2, 2]],
    "trapezium": np.array([[0, 0, 0], [3, 0, 0], [2, 1, 0], [0.5, 1, 0]], float),
}


def elements_of(polygon, order=1, n=2):
    _, _, patches = meshed(faces_of(polygon[None]), n)
    return patches, make_elements(patches, np.arange(len(patches)), order)


@pytest.mark.parametrize("polygon", SHAPES.values(), ids=SHAPES)
def test_linear_fields_are_kept_exactly(polygon):
    rng = np.random.default_rng(0)
    turn = rotation(rng)
    patches, elements = elements_of(polygon @ turn.T + rng.normal(size=3))
    nodes, slope = make_nodes(elements), rng.normal(size=3)
    values = 2.0 + nodes.points @ slope
    b = nodes.fit @ values[:, None]
    assert b[: len(elements), 0] == pytest.approx(2.0 + patches.centroid @ slope, rel=1e-12)
    inside = patches.vertices[:, :3].mean(axis=1)
    found = elements.at(inside, np.arange(len(elements)), b)[:, 0]
    assert found == pytest.approx(2.0 + inside @ slope, rel=1e-11)
    normal = patches.normal[0]
    expected = np.tile(slope - (slope @ normal) * normal, (len(elements), 1, 1))
    assert elements.gradients(b) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("polygon", SHAPES.values(), ids=SHAPES)
def test_the_first_coefficient_is_the_mean(polygon):
    """Of a field of degree 2, on parallelograms and triangles: their nodes integrate it exactly."""
    patches, elements = elements_of(polygon, n=1)
    nodes = make_nodes(elements)
    b = nodes.fit @ (nodes.points[:, 0] ** 2 + nodes.points[:, 1])[:, None]
    exact = mean_of_square_plus_y(polygon)
    if polygon is not SHAPES["trapezium"]:
        assert b[0, 0] == pytest.approx(exact, rel=1e-12)
    else:  # its map from the square stretches unevenly
        assert b[0, 0] == pytest.approx(exact, rel=2e-3)


def mean_of_square_plus_y(polygon):
    """By the midpoint rule on 400 x 400 cells of the two triangles of a polygon."""
    total = area = 0.0
    for a, b, c in (polygon[[0, 1, 2]], polygon[[0, 2, 3]]):
        size = np.linalg.norm(np.cross(b - a, c - a)) / 2
        if size > 0:  # degree 2: the midpoints of the sides
            middles = np.array([(a + b) / 2, (b + c) / 2, (c + a) / 2])
            total += size * np.mean(middles[:, 0] ** 2 + middles[:, 1])
            area += size
    return total / area


def test_nodes_lie_inside_and_belong_to_their_patch():
    patches, elements = elements_of(SHAPES["trapezium"], n=3)
    nodes = make_nodes(elements)
    assert np.bincount(nodes.owner).tolist() == [4] * 9
    assert np.all(np.diff(nodes.owner) >= 0)
    apart = np.linalg.norm(nodes.points - patches.centroid[nodes.owner], axis=1)
    assert np.all(apart < patches.radius[nodes.owner])


def test_constant_elements_have_one_coefficient():
    _, elements = elements_of(SQUARE, order=0)
    values = np.arange(4.0)[:, None]
    assert elements.width == 1
    assert np.array_equal(elements.at(np.zeros((4, 3)), np.arange(4), values), values)
    assert not elements.gradients(values).any()


def test_middles_of_what_points_see():
    """Factors and first moments of small far squares: their middles are their centroids."""
    square = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]])[::-1]
    visibility, _, patches = meshed(faces_of(np.array([square + [0, 0, 2], square + [3, 1, 2]])), 1)
    elements = make_elements(patches, np.arange(2), 1)
    geometry = patch_geometry(patches, visibility, np.arange(2))
    senders = make_senders(elements, geometry, visibility, 0.0)
    point = np.zeros((1, 3))
    weights = all_weights(senders, point, np.array([[0.0, 0.0, 1.0]]))
    found = elements.middles(weights[[0, 0]], np.array([0, 1]))
    assert found == pytest.approx(elements.centroid, abs=2e-3)
    steep = elements.middles(np.array([[0.5, 0, 0.02, 0, 0.01, 0]]), np.array([0]))[0]
    radii = 1.0 / np.linalg.norm(elements.axes[0], axis=1)
    along = (steep - elements.centroid[0]) @ elements.axes[0].T * radii
    assert along == pytest.approx([0.04 * radii[0], 0.02 * radii[1]])
