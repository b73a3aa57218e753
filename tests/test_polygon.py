"""Point factors and exchange areas: tabulated cases, plain twins, invariances, closure."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, rotation, tetrahedron

from radiosity.analytic import box_form_factors, load_cases, parallel_rectangles
from radiosity.transport.polygon import GAUSS, exchange_area, point_factor


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


def exchange(p, q):
    return exchange_area(*parts(p)[0], *parts(q)[0], GAUSS)


def factor(p, q):
    return exchange(p, q) / parts(p)[1]


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


def plain_exchange(p, q):
    """Both areas clipped at each other's plane, the outer one by Gauss points as well."""
    (_, np_, _, _), (_, nq, _, _) = parts(p)[0], parts(q)[0]
    front = clipped(p, q[0], nq)
    if len(front) < 3:
        return 0.0
    y, w = quadrature(front, 10)
    return w @ plain_point_factor(y, np_, q, 14)


def random_polygon(rng, centre=(0, 0, 0), size=1.0):
    """A random triangle or convex planar quadrilateral."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, 4))
    while np.diff(np.append(angle, angle[0] + 2 * np.pi)).max() > 2.8 or np.diff(angle).min() < 0.3:
        angle = np.sort(rng.uniform(0, 2 * np.pi, 4))
    flat = size * np.stack([np.cos(angle), rng.uniform(0.3, 1) * np.sin(angle), 0 * angle], axis=1)
    polygon = flat @ rotation(rng).T + centre
    return polygon if rng.random() < 0.6 else polygon[[0, 1, 2, 2]]


def pairs_apart(seed, count, nearest, farthest):
    """Pairs of random polygons whose circles are nearest to farthest radii apart."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        p = random_polygon(rng, size=rng.uniform(0.2, 1))
        away = rotation(rng)[0]
        q = random_polygon(rng, size=rng.uniform(0.2, 1))
        if rng.random() < 0.8:  # most of them face each other
            p = p if parts(p)[0][1] @ away > 0 else reversed_(p)
            q = q if parts(q)[0][1] @ away < 0 else reversed_(q)
        reach = parts(p)[0][3] + parts(q)[0][3]
        yield p, q + away * reach * rng.uniform(nearest, farthest)


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


# ---------------------------------------------------------------------- between polygons

PAIRS = [
    case
    for case in load_cases("vf_polygon_pairs")
    if max(len(case["geometry"][k]) for k in ("A1", "A2")) <= 4
]
# relative error reached, where it is not below 2e-9
REACHED = {
    "strip_parallel_L100_w1_d1": 1.5e-5,  # 16 points a piece on edges 100 gaps long
    "strip_perp_L100_w1_h1": 6e-6,
    "C11_1.0x1.0_h0.1": 6e-8,  # edges 10 gaps long
    "C14_l3.0_w0.5_h2.0": 6e-8,
    "C11_1.0x1.0_h10.0": 3e-9,  # 3 x 3 Gauss points beyond 6 radii
}


@pytest.mark.parametrize("case", PAIRS, ids=lambda c: c["id"])
def test_exchange_of_tabulated_pairs(case):
    g = case["geometry"]
    found = factor(four(g["A1"]), four(g["A2"]))
    assert found == pytest.approx(case["value"], rel=REACHED.get(case["id"], 2e-9))


def test_cases_are_all_there():
    assert len(PAIRS) == 30 and REACHED.keys() <= {c["id"] for c in PAIRS}


def errors_against_twin(nearest, farthest, count=12):
    """Error over the smaller area, the mean of F and the number of pairs that see each other."""
    worst, relative, seen = 0.0, [], 0
    for p, q in pairs_apart(3, count, nearest, farthest):
        found, expected = exchange(p, q), plain_exchange(p, q)
        assert (found > 0) == (expected > 0)
        seen += expected > 0
        worst = max(worst, abs(found - expected) / min(parts(p)[1], parts(q)[1]))
        if expected:
            relative.append(abs(found / expected - 1))
    return worst, np.median(relative), seen


@pytest.mark.parametrize(
    "nearest, farthest, tolerance",
    [
        (1.05, 1.49, 1e-10),  # 16 graded points a contour edge against 10 x 14; reached 6e-12
        (1.51, 2.4, 1e-10),  # 6 x 6 Gauss points; reached 2e-11
        (2.5, 5.9, 1e-10),  # 4 x 4 Gauss points; reached 2e-12
        (6.1, 12.0, 1e-10),  # 3 x 3 Gauss points; reached 2e-12
    ],
)
def test_exchange_agrees_with_its_plain_twin(nearest, farthest, tolerance):
    worst, typical, seen = errors_against_twin(nearest, farthest)
    assert seen > 7 and worst < tolerance
    assert typical < 1e-8  # half of the factors, relative to themselves; reached 7e-10


def test_far_pairs_converge_with_distance():
    """The far rule of m x m Gauss points errs by (size/distance)^2m, relative to the factor."""
    points, errors, distance = len(GAUSS[0][0]), [], np.array([9.0, 13.5, 20.25])
    for d in distance:
        q = reversed_(SQUARE) + [0.3, 0.2, d]
        errors.append(abs(exchange(SQUARE, q) / plain_exchange(SQUARE, q) - 1))
    orders = np.log(np.array(errors[:-1]) / errors[1:]) / np.log(1.5)
    assert errors[0] < 1e-8  # reached 5e-9
    assert orders == pytest.approx(2 * points, abs=0.4)  # the next term: (size/distance)^2


def test_exchange_is_symmetric():
    for nearest, farthest in ((1.05, 1.5), (1.5, 4.0), (4.0, 10.0)):
        for p, q in pairs_apart(4, 40, nearest, farthest):
            # each direction has the accuracy of its rule, since the roles are swapped
            assert exchange(p, q) == pytest.approx(exchange(q, p), rel=1e-7, abs=1e-9)


def test_exchange_does_not_depend_on_where_and_how_large():
    rng = np.random.default_rng(5)
    for p, q in pairs_apart(5, 40, 1.05, 6.0):
        turn, shift, size = rotation(rng), rng.normal(size=3), 10 ** rng.uniform(-6, 6)
        moved = [size * (x @ turn.T + shift) for x in (p, q)]
        # 1e-11 of the area: rounding of vertices a few sizes from the origin, through a logarithm
        tolerance = 1e-11 * parts(p)[1]
        assert exchange(*moved) / size**2 == pytest.approx(exchange(p, q), abs=tolerance)


def test_exchange_does_not_depend_on_the_first_vertex():
    for p, q in pairs_apart(6, 40, 1.05, 6.0):
        if np.array_equal(p[2], p[3]):
            continue
        turned = [exchange(np.roll(p, k, axis=0).copy(), q) for k in (1, 2, 3)]
        assert turned == pytest.approx([exchange(p, q)] * 3, rel=1e-5, abs=1e-9)  # the rule's own


def test_a_triangle_is_half_of_its_square():
    one, two = SQUARE[[0, 1, 2, 2]], SQUARE[[0, 2, 3, 3]]
    above = reversed_(SQUARE) + [0.2, -0.1, 0.9]
    # 1e-8: 16 graded points an edge
    together = exchange(one, above) + exchange(two, above)
    assert together == pytest.approx(exchange(SQUARE, above), rel=1e-8)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_exchange_adds_up_under_subdivision(n):
    """Both squares in n x n cells: touching, near and far pairs together give C-11 and C-14."""
    x = np.linspace(0, 1, n + 1)
    cells = [
        np.array([[a, c, 0], [b, c, 0], [b, d, 0], [a, d, 0]])
        for a, b in zip(x[:-1], x[1:], strict=True)
        for c, d in zip(x[:-1], x[1:], strict=True)
    ]
    opposite = [reversed_(c) + [0, 0, 1] for c in cells]
    beside = [reversed_(c)[:, [2, 1, 0]] for c in cells]  # x = 0
    found = sum(exchange(a, b) for a in cells for b in opposite)
    assert found == pytest.approx(parallel_rectangles(1, 1, 1), rel=1e-6)  # 4 x 4 and 2 x 2 rules
    found = sum(exchange(a, b) for a in cells for b in beside)
    assert found == pytest.approx(0.20004377607540316, rel=1e-6)  # C-14 of three unit edges


def test_backs_exchange_nothing():
    above = reversed_(SQUARE) + [0, 0, 1.0]
    assert exchange(SQUARE, above) > 0.19
    assert exchange(SQUARE, reversed_(above)) == 0.0
    assert exchange(reversed_(SQUARE), above) == 0.0
    assert exchange(SQUARE, SQUARE + [3.0, 0, 0]) == 0.0  # one plane
    assert exchange(SQUARE, SQUARE) == 0.0


def test_a_straddling_polygon_counts_what_stands_above():
    wall = four([[2, 0, -1], [2, 0, 1], [2, 1, 1], [2, 1, -1]])
    upper = np.maximum(wall, [0, 0, 0])
    assert exchange(SQUARE, wall) == pytest.approx(exchange(SQUARE, upper), rel=1e-6)  # two rules


def test_boxes_and_tetrahedra_close():
    for dims in ((1, 1, 1), (4, 3, 2.5), (1, 10, 3)):
        room = box((0, 0, 0), dims)
        found = np.array([[factor(p, q) for q in room] for p in room])
        # 1e-6: the contour rule at edges ten times as long as the gap
        assert found == pytest.approx(box_form_factors(dims), abs=1e-6)
        assert found.sum(axis=1) == pytest.approx(np.ones(6), abs=1e-6)
    walls = tetrahedron()
    found = np.array([[factor(p, q) for q in walls] for p in walls])
    assert found == pytest.approx((1 - np.eye(4)) / 3, abs=1e-9)  # reached 6e-11
