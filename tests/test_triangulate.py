import numpy as np
import pytest

from radiosity.mesh.faces import Faces
from radiosity.mesh.triangulate import NoArea, convex_quads, triangulate


def lifted(points, seed=3):
    """Points (n, 2) in some plane of space, and the plane's normal."""
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    q *= np.sign(np.linalg.det(q))
    return np.asarray(points, float) @ q[:, :2].T + [1, 2, 3], q[:, 2]


def shoelace(points):
    x, y = np.asarray(points, float).T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def inside(point, polygon):
    """Even-odd rule."""
    odd = False
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if (y0 > point[1]) != (y1 > point[1]):
            odd ^= point[0] < x0 + (point[1] - y0) / (y1 - y0) * (x1 - x0)
    return odd


L = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
DART = [(0, 0), (2, 0), (0.5, 0.5), (0, 2)]
COMB = [(0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (5, 1), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3),
        (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]  # fmt: skip
KEYHOLE = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
STAR = [
    ((1 + k % 2) * np.cos(k * np.pi / 7), (1 + k % 2) * np.sin(k * np.pi / 7)) for k in range(14)
]


@pytest.mark.parametrize(
    "points", [L, DART, COMB, KEYHOLE, STAR], ids="L dart comb keyhole star".split()
)
@pytest.mark.parametrize("seed", [1, 2])
def test_parts_cover_the_polygon_once_and_look_the_same_way(points, seed):
    polygon, normal = lifted(points, seed)
    parts = triangulate(polygon)
    faces = Faces.from_polygons(parts, 0, 0, merge=False)
    assert len(faces) == len(parts)
    np.testing.assert_allclose(faces.areas().sum(), shoelace(points), rtol=1e-12)
    np.testing.assert_allclose(faces.normals(), np.tile(normal, (len(parts), 1)), atol=1e-12)
    flat = [triangulate(np.column_stack([points, np.zeros(len(points))]))][0]
    assert all(inside(c[:2], points) for c in flat[:, :3].mean(axis=1))


def test_reversed_order_looks_the_other_way():
    polygon, normal = lifted(L)
    faces = Faces.from_polygons(triangulate(polygon[::-1]), 0, 0)
    np.testing.assert_allclose(faces.normals() @ normal, -1)


def test_convex_triangles_and_quadrilaterals_stay_as_they_are():
    quad, _ = lifted([(0, 0), (3, 0), (2, 1), (0, 1)])
    np.testing.assert_array_equal(triangulate(quad), [quad])
    np.testing.assert_array_equal(triangulate(quad[:3]), quad[None, [0, 1, 2, 2]])


def test_repeated_and_straight_vertices_are_dropped():
    square = [(0, 0), (1, 0), (2, 0), (2, 0), (2, 2), (0, 2), (0, 0)]
    parts = triangulate(lifted(square)[0])
    assert len(parts) == 2
    triangle = triangulate(lifted([(0, 0), (1, 0), (2, 0), (0, 2)])[0])
    assert triangle.shape == (1, 4, 3)


@pytest.mark.parametrize("scale", [1e-6, 1, 1e6])
def test_quadrilateral_that_is_not_planar_becomes_two_triangles(scale):
    quad = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.01]]) * scale
    np.testing.assert_array_equal(triangulate(quad), quad[[[0, 1, 2, 2], [0, 2, 3, 3]]])
    quad[3, 2] *= 1e-6
    assert len(triangulate(quad)) == 1


def test_dart_is_cut_at_its_inner_corner_even_where_not_planar():
    dart = np.column_stack([DART, [0, 0, 0.05, 0]])[[1, 2, 3, 0]]  # inner corner at place 1
    faces = Faces.from_polygons(triangulate(dart), 0, 0, merge=False)
    assert len(faces) == 2
    assert (faces.normals()[:, 2] > 0.9).all()


@pytest.mark.parametrize(
    ("points", "text"),
    [
        ([(0, 0), (1, 0)], "has 2 vertices, a polygon needs at least 3"),
        (
            [(0, 0), (1, 1), (1, 0), (0, 1)],
            r"crosses itself: edge 0 \(from vertex 0\) meets edge 2",
        ),
        ([(0, 0), (4, 0), (4, 4), (3, -1), (0, 4)], "crosses itself: edge 0 .* meets edge 2"),
        ([(0, 0), (1, 1), (2, 2), (2, 0), (1, 1), (0, 2)], "crosses itself"),
        ([(0, 0), (1, 0), (2, 0), (5, 0)], "has no area: all its vertices lie on one line"),
        ([(1, 1), (1, 1), (1, 1)], "has no area"),
    ],
)
def test_what_is_no_polygon_is_refused(points, text):
    with pytest.raises(ValueError, match=text):
        triangulate(lifted(points)[0])


def test_polygon_that_is_not_planar_is_refused_with_the_bound():
    polygon = np.column_stack([L, [0, 0, 0, 0, 0, 1e-3]])
    with pytest.raises(
        ValueError, match=r"is not planar: vertex \d lies .* off the mean plane"
    ) as e:
        triangulate(polygon)
    assert "1e-06 of its size" in str(e.value)
    assert len(triangulate(polygon, flatness=np.inf)) == 4
    polygon[:, 2] *= 1e-4
    assert len(triangulate(polygon)) == 4


def test_no_area_can_be_told_from_other_errors():
    with pytest.raises(NoArea):
        triangulate([[0, 0, 0], [1, 1, 1], [2, 2, 2]])


def test_convex_quads_tells_each_from_each():
    quads = np.zeros((5, 4, 3))
    quads[:, :, :2] = [(0, 0), (1, 0), (1, 1), (0, 1)]
    quads[1, 2, 2] = 1e-3  # bent
    quads[2, 2, :2] = 0.4  # concave
    quads[3, 1:3] = quads[3, 2:0:-1].copy()  # crossing
    quads[4, 1, :2] = 0.5, 0.5  # a corner of 180 degrees, on the diagonal
    quads[4, 3] = [0, 1, 0]
    quads[4, 0], quads[4, 2] = [0, 0, 0], [1, 1, 0]
    assert convex_quads(quads).tolist() == [True, False, False, False, False]


def test_polygons_of_very_many_vertices_are_refused():
    angle = np.linspace(0, 2 * np.pi, 4097, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    with pytest.raises(ValueError, match="has 4097 vertices, at most 4096 are split: divide it"):
        triangulate(circle)
