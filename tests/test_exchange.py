"""Exchange between polygons: tabulated cases, plain twin, honest errors, invariances, closure."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, faces_of, rotation, tetrahedron
from test_polygon import (
    clipped,
    parts,
    plain_point_factor,
    quadrature,
    random_polygon,
    reversed_,
)

from radiosity.analytic import box_form_factors, load_cases, parallel_rectangles
from radiosity.mesh.triangulate import triangulate
from radiosity.transport.exchange import (
    FEWEST,
    MOST,
    _product_rule,
    exchange_area,
    load_fronts,
    make_geometry,
    make_room,
    points_needed,
)
from radiosity.transport.visibility import Visibility

ROOM = make_room()
TIGHT = 1e-13


def geometry_of(polygons):
    """Return polygons (n, 4, 3) as the kernels read them and the unit of area."""
    v = np.asarray(polygons, float)
    low, high = v.min(axis=(0, 1)), v.max(axis=(0, 1))
    size = np.linalg.norm(high - low) / 2
    local = (v - (low + high) / 2) / size
    each = [parts(p) for p in local]
    normal, centroid = (np.array([p[0][k] for p in each]) for k in (1, 2))
    return make_geometry(local, normal, centroid, np.array([p[1] for p in each])), size**2


def placed_geometry(polygons):
    """The same through `Visibility`, which knows what large coordinates have lost."""
    faces = faces_of(polygons)
    place = Visibility(faces)
    local = (faces.vertices - place.centre) * place.scale
    centroid = np.array([parts(p)[0][2] for p in local])
    area = faces.areas() * place.scale**2
    return make_geometry(local, faces.normals(), centroid, area, place.grain), place.scale**-2


def exchange(p, q, tolerance=TIGHT, of=geometry_of):
    return exchange_and_error(p, q, tolerance, of)[0]


def exchange_and_error(p, q, tolerance=TIGHT, of=geometry_of):
    geometry, unit = of(np.stack([p, q]))
    value, error = exchange_area(geometry, 0, 1, tolerance, ROOM)
    return value * unit, error * unit


def factor(p, q):
    return exchange(p, q) / parts(p)[1]


def plain_exchange(p, q, order=10, inner=14):
    """Both areas clipped at each other's plane, the outer one by Gauss points as well."""
    (_, np_, _, _), (_, nq, _, _) = parts(p)[0], parts(q)[0]
    front = clipped(p, q[0], nq)
    if len(front) < 3:
        return 0.0
    y, w = quadrature(front, order)
    return w @ plain_point_factor(y, np_, q, inner)


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


def facing(p, q):
    away = q.mean(axis=0) - p.mean(axis=0)
    p = p if parts(p)[0][1] @ away > 0 else reversed_(p)
    return p, q if parts(q)[0][1] @ away < 0 else reversed_(q)


def thinned(polygon, share):
    """The polygon pressed to a share of its height, in its plane."""
    along = polygon[1] - polygon[0]
    across = np.cross(parts(polygon)[0][1], along / np.linalg.norm(along))
    return polygon - (1 - share) * np.outer((polygon - polygon[0]) @ across, across)


# ---------------------------------------------------------------------- tabulated


def cases(name):
    return [c for c in load_cases(name) if c["geometry"]["type"].startswith("polygon_pair")]


def pieces(case):
    return [triangulate(np.array(case["geometry"][k], float)) for k in ("A1", "A2")]


def both_factors(case, tolerance=TIGHT):
    """F and its reverse, each computed from its own side."""
    one, two = pieces(case)
    geometry, _ = geometry_of(np.concatenate([one, two]))
    n, total = len(one), len(one) + len(two)
    pairs = [(i, j) for i in range(n) for j in range(n, total)]
    there = sum(exchange_area(geometry, i, j, tolerance, ROOM)[0] for i, j in pairs)
    back = sum(exchange_area(geometry, j, i, tolerance, ROOM)[0] for i, j in pairs)
    return there / geometry.area[:n].sum(), back / geometry.area[n:].sum()


def expected_factors(case):
    """F and its reverse: tabulated, or by reciprocity."""
    ratio = np.divide(*(sum(parts(p)[1] for p in polygons) for polygons in pieces(case)))
    return np.atleast_1d(case["value"])[0] * np.array([1, ratio])


PAIRS, EXTREMES = cases("vf_polygon_pairs"), cases("extremes")


def test_cases_are_all_there():
    assert len(PAIRS) == 35 and len(EXTREMES) == 9
    assert max(len(pieces(c)[0]) for c in PAIRS) == 6  # an octagon


@pytest.mark.parametrize("case", PAIRS, ids=lambda c: c["id"])
def test_exchange_of_tabulated_pairs(case):
    # 1e-13: 14 digits are tabulated; reached is 3e-14 on strips 100 gaps long, else 2e-15
    assert both_factors(case) == pytest.approx(expected_factors(case), rel=1e-13, abs=0)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
def test_tabulated_pairs_keep_the_tolerance_asked_for(tolerance):
    for case in PAIRS + EXTREMES:
        expected = expected_factors(case)
        assert both_factors(case, tolerance) == pytest.approx(expected, rel=tolerance, abs=0)


@pytest.mark.parametrize("case", EXTREMES, ids=lambda c: c["id"])
def test_exchange_of_extreme_pairs(case):
    # 1e-9: rounding of slivers 1e-6 wide; reached is 5e-10 there, else 5e-13
    assert both_factors(case) == pytest.approx(expected_factors(case), rel=1e-9, abs=0)


def test_what_a_narrow_gap_loses():
    case = next(c for c in EXTREMES if c["id"] == "gap_1e-6")
    there, back = both_factors(case)
    # 1e-12: asked; reached is 1e-15
    assert 1 - there == pytest.approx(case["value"][1], rel=0, abs=1e-12)
    assert 1 - back == pytest.approx(case["value"][1], rel=0, abs=1e-12)


def test_slivers_as_seen_from_their_own_side():
    for name in ("sliver_parallel_1e-6", "sliver_shared_edge_1e-6"):
        case = next(c for c in EXTREMES if c["id"] == name)
        # 1e-9: the width of the sliver carries 1e-10; reached is 4e-10
        assert both_factors(case)[1] == pytest.approx(case["value"][1], rel=1e-9, abs=0)


# ---------------------------------------------------------------------- the plain twin


@pytest.mark.parametrize(
    "nearest, farthest, tolerance",
    [
        (1.05, 1.49, 1e-10),  # of 10 x 14 points of the twin; reached 9e-12
        (1.51, 2.4, 1e-12),
        (2.5, 5.9, 1e-12),
        (6.1, 12.0, 1e-12),
    ],
)
def test_exchange_agrees_with_its_plain_twin(nearest, farthest, tolerance):
    worst, relative, seen = 0.0, [], 0
    for p, q in pairs_apart(3, 12, nearest, farthest):
        found, expected = exchange(p, q), plain_exchange(p, q)
        assert (found > 0) == (expected > 0)
        seen += expected > 0
        worst = max(worst, abs(found - expected) / min(parts(p)[1], parts(q)[1]))
        if expected:
            relative.append(abs(found / expected - 1))
    assert seen > 7 and worst < tolerance
    assert np.median(relative) < 1e-9  # half of the factors, relative to themselves


def product_error(points, distance):
    """Relative error of m x m times m x m Gauss points over two unit squares."""
    geometry, _ = geometry_of(np.stack([SQUARE, reversed_(SQUARE) + [0.3, 0.2, distance]]))
    exact = exchange_area(geometry, 0, 1, TIGHT, ROOM)[0]
    return abs(_product_rule(geometry, 0, 1, points, points) / exact - 1)


@pytest.mark.parametrize("points", [2, 3, 4])
def test_far_pairs_converge_with_distance(points):
    """The rule of m x m Gauss points errs by (size/distance)^2m, relative to the factor."""
    errors = [product_error(points, d) for d in (6.0, 9.0, 13.5)]
    orders = np.log(np.array(errors[:-1]) / errors[1:]) / np.log(1.5)
    assert orders == pytest.approx([2 * points] * 2, abs=0.4)  # the next term: (size/distance)^2


def test_far_pairs_converge_with_points():
    """Each point a direction gains rho^2, rho being twice the distance over half the size."""
    for points in range(FEWEST, MOST + 1):
        constant = product_error(points, 3.0) * 12.0 ** (2 * points)
        assert 4 < constant < 24, points  # reached 7 to 13


def test_more_points_are_needed_nearer_and_for_less_error():
    needed = [points_needed(far, False, 1e-6) for far in (1.2, 4.0, 8.0, 50.0, 1e4)]
    assert needed == sorted(needed[:1]) + sorted(needed[1:], reverse=True) and needed[0] == 0
    assert points_needed(8.0, True, 1e-6) >= points_needed(8.0, False, 1e-6) > 0
    assert points_needed(2.0, False, 1e-15) == 0


# ---------------------------------------------------------------------- honest errors


def plain_pair(rng):
    return facing(random_polygon(rng), random_polygon(rng) + rng.uniform(2, 16) * rotation(rng)[0])


def near_pair(rng):
    """About each other, most of them through each other's plane."""
    q = random_polygon(rng, size=10 ** rng.uniform(-1.5, 0))
    return facing(random_polygon(rng), q + 10 ** rng.uniform(-1.5, 0.7) * rotation(rng)[0])


def sliver_pair(rng):
    p, q = near_pair(rng)
    p = thinned(p, 10 ** rng.uniform(-6, -1))
    return facing(p, thinned(q, 10 ** rng.uniform(-6, -1)) if rng.random() < 0.5 else q)


def parallel_pair(rng):
    p, (_, away, *_) = (p := random_polygon(rng)), parts(p)[0]
    turn = np.array([(p[1] - p[0]) / np.linalg.norm(p[1] - p[0]), np.zeros(3), away])
    turn[1] = np.cross(away, turn[0])
    flat = random_polygon(rng, turn=np.eye(3)) + [*0.5 * rng.normal(size=2), 0]
    return facing(p, flat @ turn + p.mean(axis=0) + 10 ** rng.uniform(-4, 0) * away)


def edge_pair(rng):
    """A common edge, at angles from 1 to 178 degrees."""
    p, q = random_polygon(rng), random_polygon(rng, size=1)
    frame = [np.stack([e, n, np.cross(n, e)]) for e, n in map(edge_and_normal, (p, q))]
    c, s = np.cos(angle := rng.uniform(0.02, 3.1)), np.sin(angle)
    turned = np.array([[-1, 0, 0], [0, -c, s], [0, s, c]])  # its edge runs back along that of p
    scale = np.linalg.norm(p[1] - p[0]) / np.linalg.norm(q[1] - q[0])
    q = scale * (q - q[0]) @ frame[1].T @ turned @ frame[0] + p[1]
    q[0], q[1] = p[1], p[0]
    return p, q


def edge_and_normal(polygon):
    edge = polygon[1] - polygon[0]
    return edge / np.linalg.norm(edge), parts(polygon)[0][1]


def vertex_pair(rng):
    p, q = random_polygon(rng), random_polygon(rng, size=10 ** rng.uniform(-2, 0))
    p, q = facing(p, q - q[0] + p[0])
    q[np.all(np.abs(q - p[0]) < 1e-15, axis=1)] = p[0]
    return p, q


KINDS = [plain_pair, near_pair, sliver_pair, parallel_pair, edge_pair, vertex_pair]


def width(polygon):
    return parts(polygon)[1] / max(np.linalg.norm(polygon[k] - polygon[k - 1]) for k in range(4))


def conditioned(p, q, value):
    """What rounding of the vertices, which turns the normal of a sliver, may change."""
    return 1e-15 * sum(1 / width(x) for x in (p, q)) * min(parts(p)[1], parts(q)[1]) + 1e-15 * value


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.__name__)
def test_errors_are_honest(kind):
    rng, ratios, wrong, seen = np.random.default_rng(7), [], [], 0
    for _ in range(300):
        p, q = kind(rng)
        geometry, unit = geometry_of(np.stack([p, q]))
        exact, doubt = exchange_area(geometry, 0, 1, TIGHT, ROOM)
        if exact == 0:
            continue
        seen += 1
        doubt += conditioned(p, q, exact * unit) / unit
        for tolerance in (1e-4, 1e-6, 1e-9):
            value, error = exchange_area(geometry, 0, 1, tolerance, ROOM)
            ratios.append(abs(value - exact) / (error + doubt))
            wrong.append(abs(value - exact) / (tolerance * exact + doubt))
    assert seen > 200
    assert np.mean(np.array(ratios) > 3) <= 0.005, np.sort(ratios)[-10:]
    assert np.mean(np.array(wrong) > 1) <= 0.005, np.sort(wrong)[-10:]


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.__name__)
def test_estimates_are_of_use(kind):
    """All but pairs that rounding spoils are told to be as good as asked."""
    rng, spoilt, seen = np.random.default_rng(8), 0, 0
    for _ in range(150):
        value, error = exchange_and_error(*kind(rng), 1e-6)
        seen += value > 0
        spoilt += error > 1.001e-6 * value  # rounding may come on top
    assert seen > 100 and spoilt < 0.03 * seen  # reached: 0.9 % of slivers, else 0.1 %


def test_random_pairs_are_of_all_sorts():
    rng, triangles, straddling = np.random.default_rng(9), 0, 0
    for kind in KINDS:
        for _ in range(30):
            p, q = kind(rng)
            triangles += np.array_equal(p[2], p[3])
            height = (q - p[0]) @ parts(p)[0][1]
            straddling += height.min() < -1e-3 and height.max() > 1e-3
            assert height.max() > 0 and np.isfinite(exchange(p, q))
    assert 40 < triangles < 140 and straddling > 20


# ---------------------------------------------------------------------- invariances


def test_exchange_is_symmetric():
    for kind in KINDS:
        rng = np.random.default_rng(4)
        for _ in range(30):
            p, q = kind(rng)
            there, back = exchange(p, q), exchange(q, p)
            # 1e-12: two roundings, each of a rule of its own
            slack = 3 * conditioned(p, q, there)
            assert there == pytest.approx(back, rel=1e-12, abs=slack)


def test_exchange_does_not_depend_on_where_and_how_large():
    rng = np.random.default_rng(5)
    for p, q in pairs_apart(5, 60, 1.05, 6.0):
        turn, shift, size = rotation(rng), rng.normal(size=3), 10 ** rng.uniform(-9, 9)
        moved = [size * (x @ turn.T + shift) for x in (p, q)]
        # 1e-14 of the area: rounding of vertices a few sizes from the origin; reached 7e-16
        slack = 1e-14 * parts(p)[1]
        assert exchange(*moved) / size**2 == pytest.approx(exchange(p, q), rel=0, abs=slack)


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1.0, 1e9])
def test_scale_changes_areas_only(size):
    room = box((0, 0, 0), (1, 1, 1))
    case = next(c for c in load_cases("extremes") if c["id"] == "scale_1e9")
    for wall, expected in ((2, case["value"][0]), (1, case["value"][1])):
        found = exchange(size * room[0], size * room[wall], of=placed_geometry) / size**2
        assert found == pytest.approx(expected, rel=1e-14, abs=0)  # reached 1e-15


def test_a_place_far_from_the_origin():
    case = next(c for c in load_cases("extremes") if c["id"] == "translate_1e+06")
    offset = np.array(case["geometry"]["offset"])
    p, q = SQUARE + offset, reversed_(SQUARE) + [0, 0, 1] + offset
    # 1e-14: the coordinates are exact
    assert exchange(p, q, of=placed_geometry) == pytest.approx(case["value"], rel=1e-14, abs=0)
    rng = np.random.default_rng(10)
    for _ in range(20):
        p, q = edge_pair(rng)
        moved = exchange(p + offset, q + offset, of=placed_geometry)
        # 3e-9: vertices are rounded to 1e-10 and counted as in a plane within 4e-9
        assert moved == pytest.approx(exchange(p, q), rel=0, abs=3e-9)


def test_exchange_does_not_depend_on_the_first_vertex():
    for p, q in pairs_apart(6, 60, 1.05, 6.0):
        if np.array_equal(p[2], p[3]):
            continue
        turned = [exchange(np.roll(p, k, axis=0), q) for k in (1, 2, 3)]
        # 1e-13: as asked
        assert turned == pytest.approx([exchange(p, q)] * 3, rel=1e-13, abs=1e-16)


def test_a_triangle_is_half_of_its_square():
    one, two = SQUARE[[0, 1, 2, 2]], SQUARE[[0, 2, 3, 3]]
    for height in (0.01, 0.9, 20.0):
        above = reversed_(SQUARE) + [0.2, -0.1, height]
        together = exchange(one, above) + exchange(two, above)
        assert together == pytest.approx(exchange(SQUARE, above), rel=1e-13, abs=0)


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
    assert found == pytest.approx(parallel_rectangles(1, 1, 1), rel=1e-13)  # as asked
    found = sum(exchange(a, b) for a in cells for b in beside)
    assert found == pytest.approx(0.20004377607540316, rel=1e-13)  # C-14 of three unit edges


def test_a_straddling_polygon_counts_what_stands_above():
    wall = np.array([[2, 0, -1], [2, 0, 1], [2, 1, 1], [2, 1, -1]], float)
    upper = np.maximum(wall, [0, 0, 0])
    for away in (-1.9, 0.0, 30.0):
        p, q = exchange(SQUARE, wall + [away, 0, 0]), exchange(SQUARE, upper + [away, 0, 0])
        assert p == pytest.approx(q, rel=1e-13, abs=0)  # as asked


def test_backs_exchange_nothing():
    above = reversed_(SQUARE) + [0, 0, 1.0]
    assert exchange(SQUARE, above) > 0.19
    assert exchange(SQUARE, reversed_(above)) == 0.0
    assert exchange(reversed_(SQUARE), above) == 0.0
    assert exchange(SQUARE, SQUARE + [3.0, 0, 0]) == 0.0  # one plane
    assert exchange(SQUARE, SQUARE) == 0.0


def test_one_plane_and_back_to_back_exchange_exactly_nothing():
    rng = np.random.default_rng(11)
    for _ in range(25):
        turn, size = rotation(rng), 10 ** rng.uniform(-9, 9)
        shift = size * 10 ** rng.uniform(-1, 4) * rng.normal(size=3)
        flat = [random_polygon(rng, turn=np.eye(3)) + [*rng.normal(size=2), 0] for _ in "pq"]
        p, q = (size * x @ turn.T + shift for x in flat)
        for one, two in ((p, q), (p, reversed_(q)), (reversed_(p), q), (p, p), (p, reversed_(p))):
            for a, b in ((one, two), (two, one)):
                assert exchange_and_error(a, b, of=placed_geometry) == (0.0, 0.0)
        behind = q - size * 10 ** rng.uniform(-3, 1) * turn[:, 2]
        assert exchange_and_error(p, behind, of=placed_geometry) == (0.0, 0.0)
        assert exchange_and_error(p, reversed_(behind), of=placed_geometry) == (0.0, 0.0)


def test_boxes_and_tetrahedra_close():
    for dims in ((1, 1, 1), (4, 3, 2.5), (1, 10, 3), (1e-3, 1, 1)):
        room = box((0, 0, 0), dims)
        found = np.array([[factor(p, q) for q in room] for p in room])
        assert found.sum(axis=1) == pytest.approx(np.ones(6), abs=1e-12)
        if min(dims) >= 1:  # closed forms of plates cancel
            assert found == pytest.approx(box_form_factors(dims), abs=1e-13)
    walls = tetrahedron()
    found = np.array([[factor(p, q) for q in walls] for p in walls])
    assert found == pytest.approx((1 - np.eye(4)) / 3, abs=1e-14)  # reached 2e-16


@pytest.mark.parametrize(
    ("foot", "corners", "cut"),
    [(0.0, (4, 4), False), (0.5, (4, 4), False), (-0.5, (4, 4), True), (-1.5, (0, 0), False)],
)
def test_only_what_lies_in_front_is_loaded(foot, corners, cut):
    """A wall beside a floor, its lower part below it."""
    wall = np.array([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1.0]]) - [0.2, 0, -foot]
    geometry, _ = geometry_of([SQUARE, wall])
    assert load_fronts(geometry, 0, 1, ROOM) == (*corners, cut)
    if cut:
        area = np.linalg.norm(np.cross(*(ROOM.q[[1, 3]] - ROOM.q[0])))
        assert area / geometry.area[1] == pytest.approx(0.5)
