"""Polygons seen from points, clipped, measured: tabulated cases, plain twins, closure."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, rotation

from radiosity.analytic import load_cases
from radiosity.transport.polygon import bilinear, clip, heights, point_factor


def four(vertices):
    v = np.array(vertices, float)
    return v if len(v) == 4 else v[[0, 1, 2, 2]]


def reversed_(polygon):
    return polygon[[2, 1, 0, 0]] if np.array_equal(polygon[2], polygon[3]) else polygon[::-1].copy()


def parts(polygon):
    """Polygon, unit normal, a point inside and a radius around it, and the area."""
    vector = 0.5 * np.cross(polygon[2] - polygon[0], polygon[3] - polygon[1])
    area = np.linalg.norm(vector)
    one = np.linalg.norm(np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])) / 2
    thirds = polygon[[0, 1, 2]].mean(axis=0), polygon[[0, 2, 3]].mean(axis=0)
    centre = (one * thirds[0] + (area - one) * thirds[1]) / area
    radius = np.linalg.norm(polygon - centre, axis=1).max()
    polygon = np.ascontiguousarray(polygon)  # one compiled signature
    return (polygon, vector / area, centre, radius), area


def lambert(point, normal, polygon):
    return point_factor(*map(float, point), *map(float, normal), polygon)


def clipped(polygon, point, normal):
    """Plain Sutherland-Hodgman: the vertices of the part in front of a plane."""
    h, out = (polygon - point) @ normal, []
    for k in range(len(polygon)):
        a, b, ha, hb = polygon[k - 1], polygon[k], h[k - 1], h[k]
        if ha * hb < 0:
            out.append(a + ha / (ha - hb) * (b - a))
        if hb >= 0:
            out.append(b)
    return np.array(out).reshape(-1, 3)


def quadrature(polygon, order):
    """Points and weights over a convex polygon, a fan of triangles with a Gauss rule each."""
    points, weights = [], []
    nodes, along = (x / 2 for x in np.polynomial.legendre.leggauss(order))
    nodes = nodes + 0.5
    s, t = np.meshgrid(nodes, nodes, indexing="ij")
    w = np.outer(along * nodes, along)
    for k in range(1, len(polygon) - 1):
        a, b, c = polygon[0], polygon[k], polygon[k + 1]
        x = a + s[..., None] * ((1 - t[..., None]) * (b - a) + t[..., None] * (c - a))
        points.append(x.reshape(-1, 3))
        weights.append(w.ravel() * np.linalg.norm(np.cross(b - a, c - a)))
    return np.concatenate(points), np.concatenate(weights)


def plain_point_factor(points, normal, polygon, order=24):
    """1/pi times the sum of cos cos' dA / r^2 over the part in front, a point at a time."""
    facing = parts(polygon)[0][1]
    found = []
    for x in np.atleast_2d(points):
        front = clipped(polygon, x, normal)
        if len(front) < 3 or (x - polygon[0]) @ facing <= 0:
            found.append(0.0)
            continue
        y, w = quadrature(front, order)
        r = y - x
        r2 = (r * r).sum(axis=1)
        found.append(w @ ((r @ normal) * (-r @ facing) / r2**2) / np.pi)
    return np.array(found)


def random_polygon(rng, turn=None, size=1.0):
    """A random triangle or convex planar quadrilateral, turned at random unless told how."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, 4))
    while np.diff(np.append(angle, angle[0] + 2 * np.pi)).max() > 2.8 or np.diff(angle).min() < 0.3:
        angle = np.sort(rng.uniform(0, 2 * np.pi, 4))
    flat = size * np.stack([np.cos(angle), rng.uniform(0.3, 1) * np.sin(angle), 0 * angle], axis=1)
    polygon = flat @ (rotation(rng) if turn is None else turn).T
    return polygon if rng.random() < 0.6 else polygon[[0, 1, 2, 2]]


# ---------------------------------------------------------------------- from a point


@pytest.mark.parametrize("case", load_cases("vf_element_polygon"), ids=lambda c: c["id"])
def test_point_factor_of_tabulated_cases(case):
    g = case["geometry"]
    polygon = four(g["A2"])
    if case["id"].startswith("lambert"):
        polygon = reversed_(polygon)  # these two wind away from the point
    # 1e-12: rounding of six arctangents; reached is 3e-17
    assert lambert(g["point"], g["normal"], polygon) == pytest.approx(case["value"], abs=1e-12)
    assert lambert(g["point"], g["normal"], reversed_(polygon)) == 0.0


def test_point_factor_agrees_with_its_plain_twin():
    rng = np.random.default_rng(1)
    crossing = seen = 0
    for _ in range(300):
        polygon, normal = random_polygon(rng), rotation(rng)[0]
        point = parts(polygon)[0][2] + rng.uniform(1.5, 4) * rotation(rng)[0]
        height = (polygon - point) @ normal
        crossing += height.min() < 0 < height.max()
        expected = plain_point_factor(point, normal, polygon)[0]
        seen += expected > 0
        # 1e-8: 24 x 24 Gauss points at half a radius from the plane; reached is 4e-10
        assert lambert(point, normal, polygon) == pytest.approx(expected, abs=1e-8)
    assert crossing > 30 and seen > 60


def test_point_factor_is_clipped_at_the_horizon():
    wall = np.array([[1, 1, -2], [1, -1, -2], [1, -1, 2], [1, 1, 2]], float)
    upper = wall.copy()
    upper[:2, 2] = 0.0
    above = lambert([0, 0, 0], [0, 0, 1], wall)
    # 1e-15: the same edges above the horizon, the one along it adds nothing
    assert above == pytest.approx(lambert([0, 0, 0], [0, 0, 1], upper), abs=1e-15)
    assert lambert([0, 0, 3], [0, 0, 1], wall) == 0.0
    # 1e-15: the halves of the sphere share the wall, whatever it hides
    assert lambert([0, 0, 0], [0, 0, -1], wall) == pytest.approx(above, abs=1e-15)


def test_a_point_inside_a_box_sees_nothing_else():
    rng = np.random.default_rng(2)
    room = box((0, 0, 0), (1, 2, 3))
    for _ in range(50):
        point, normal = rng.uniform(0.01, 0.99, 3) * [1, 2, 3], rotation(rng)[0]
        total = sum(lambert(point, normal, wall) for wall in room)
        assert total == pytest.approx(1.0, abs=1e-13)  # rounding of 24 arctangents


@pytest.mark.parametrize("count", [3, 4, 5, 6, 9])
def test_point_factor_takes_any_number_of_corners(count):
    rng = np.random.default_rng(count)
    for _ in range(20):
        angle = 2 * np.pi * (np.arange(count) + 0.8 * rng.random(count)) / count
        flat = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        polygon, normal = flat @ rotation(rng).T, rotation(rng)[0]
        point = 1.5 * rotation(rng)[0]
        fan = [polygon[[0, k, k + 1, k + 1]] for k in range(1, count - 1)]
        expected = sum(lambert(point, normal, triangle) for triangle in fan)
        # 1e-15: the inner edges of the fan cancel; reached is 1e-16
        assert lambert(point, normal, polygon) == pytest.approx(expected, abs=1e-15)


def test_point_factor_is_that_of_a_small_far_polygon():
    """F = A cos cos' / (pi r^2), wrong by the square of size over distance."""
    small, normal = 1e-3 * (SQUARE - [0.5, 0.5, 0]), np.array([0.6, 0.0, 0.8])
    point = np.array([0.0, 0.0, 2.0])
    found = lambert(point, -normal, small)
    # 1e-6: the square of 1e-3 over 2, times a few; reached is 4e-7
    assert found == pytest.approx(1e-6 * 0.8 / (np.pi * 4), rel=1e-6, abs=0)


# ---------------------------------------------------------------------- measured and clipped


def test_heights_are_those_of_the_vertices():
    rng = np.random.default_rng(3)
    for _ in range(50):
        polygon, point, normal = random_polygon(rng), rng.normal(size=3), rotation(rng)[0]
        expected = (polygon - point) @ normal
        low, high = heights(polygon, point, normal)
        # 1e-15: three products of numbers below 3
        assert [low, high] == pytest.approx([expected.min(), expected.max()], abs=1e-15)


def test_clip_agrees_with_its_plain_twin():
    rng, cut = np.random.default_rng(4), 0
    out = np.empty((12, 3))
    for _ in range(200):
        polygon, normal = random_polygon(rng), rotation(rng)[0]
        point = 0.5 * rng.normal(size=3)
        count = clip(polygon, point, normal, 0.0, out)
        expected = clipped(polygon, point, normal)
        cut += 0 < len(expected) and not np.array_equal(expected, polygon)
        assert count == len(expected)
        # 1e-15: one division; reached is 1e-16
        assert out[:count] == pytest.approx(expected, abs=1e-15)
    assert cut > 60


def test_clip_leaves_what_lies_in_the_plane_within_the_tolerance():
    out, up = np.empty((12, 3)), np.array([0.0, 0.0, 1.0])
    tilted = SQUARE + [[0, 0, 0.5], [0, 0, 0.5], [0, 0, -1e-9], [0, 0, 1e-9]]
    assert clip(tilted, np.zeros(3), up, 1e-8, out) == 4
    assert np.array_equal(out[:4], tilted)
    assert clip(tilted, np.zeros(3), up, 1e-10, out) == 5
    assert clip(tilted - [0, 0, 2.0], np.zeros(3), up, 1e-8, out) == 0
    # on its own storage, as a front is clipped a second time
    room = np.empty((12, 3))
    room[:4] = tilted
    assert clip(room[:4], np.zeros(3), -up, 1e-10, out) == 3


def test_bilinear_meets_corners_and_keeps_the_area():
    rng, x = np.random.default_rng(5), np.empty(3)
    nodes, weights = np.polynomial.legendre.leggauss(2)
    nodes, weights = (nodes + 1) / 2, weights / 2
    for _ in range(30):
        polygon = random_polygon(rng)
        for k, (s, t) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
            bilinear(polygon, float(s), float(t), x)
            assert np.array_equal(x, polygon[k])
        total, moment = 0.0, np.zeros(3)
        for s, u in zip(nodes, weights, strict=True):
            for t, v in zip(nodes, weights, strict=True):
                stretch = bilinear(polygon, s, t, x)
                total, moment = total + u * v * stretch, moment + u * v * stretch * x
        (_, _, centre, _), area = parts(polygon)
        assert total == pytest.approx(area, rel=1e-14)  # the stretch is linear in s and t
        assert moment / total == pytest.approx(centre, abs=1e-14)  # and cubic with x: still exact
