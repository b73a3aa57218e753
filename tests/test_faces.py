import numpy as np
import pytest
from scipy.spatial import Delaunay

from radiosity.mesh import faces as module
from radiosity.mesh.faces import Faces

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)


def halves(quad):
    quad = np.asarray(quad, float)
    return quad[[[0, 1, 2], [0, 2, 3]]]


def grid(n):
    x, y = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n)))
    corner = np.stack([x, y, 0 * x], axis=1).astype(float)
    return corner[:, None] + SQUARE


def rotation(seed):
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def test_two_halves_become_the_square_with_its_winding_and_first_vertex():
    faces = Faces.from_triangles(halves(SQUARE), 3, 5)
    np.testing.assert_array_equal(faces.vertices, [SQUARE])
    assert (faces.material.tolist(), faces.group.tolist()) == ([3], [5])
    np.testing.assert_array_equal(faces.normals(), [[0, 0, 1]])


@pytest.mark.parametrize("turn", [0, 1, 2])
@pytest.mark.parametrize("other", [0, 1, 2])
def test_the_shared_edge_may_be_any_edge_of_either(turn, other):
    one, two = halves(SQUARE)
    faces = Faces.from_triangles([np.roll(one, turn, 0), np.roll(two, other, 0)], 0, 0)
    assert len(faces) == 1
    np.testing.assert_array_equal(faces.vertices[0, 0], np.roll(one, turn, 0)[0])
    np.testing.assert_array_equal(faces.normals(), [[0, 0, 1]])
    np.testing.assert_allclose(faces.areas(), 1)


@pytest.mark.parametrize(
    ("material", "group"), [([0, 1], [0, 0]), ([0, 0], [0, 1]), ([0, 1], [1, 0])]
)
def test_surfaces_are_not_mixed(material, group):
    faces = Faces.from_triangles(halves(SQUARE), material, group)
    assert len(faces) == 2
    assert faces.material.tolist() == material
    assert faces.group.tolist() == group


def test_opposite_orientations_and_back_to_back_copies_stay_apart():
    one, two = halves(SQUARE)
    assert len(Faces.from_triangles([one, two[::-1]], 0, 0)) == 2
    both = np.concatenate([halves(SQUARE), halves(SQUARE)[:, ::-1]])
    for order in ([0, 1, 2, 3], [0, 2, 1, 3], [2, 0, 3, 1]):
        faces = Faces.from_triangles(both[order], 0, 0)
        assert len(faces) == 2
        np.testing.assert_allclose(faces.areas(), 1)
        assert sorted(faces.normals()[:, 2]) == [-1, 1]


@pytest.mark.parametrize(("lift", "count"), [(1e-4, 2), (3e-6, 2), (1e-7, 1), (0, 1)])
def test_only_planar_pairs_are_joined(lift, count):
    quad = SQUARE.copy()
    quad[3, 2] = lift
    for scale in (1, 1e-6, 1e6):
        assert len(Faces.from_triangles(halves(quad * scale), 0, 0)) == count


def test_concave_and_sharp_pairs_stay_apart():
    dart = [[0, 0, 0], [2, 0, 0], [0.5, 0.5, 0], [0, 2, 0]]
    spindle = [[0, 0, 0], [10, -0.5, 0], [20, 0, 0], [10, 0.5, 0]]
    arrow = [[0, 0, 0], [0.94, -0.342, 0], [0.742, 0, 0], [0.94, 0.342, 0]]  # 40, 40, 240, 40
    bent = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0]]  # a triangle with a corner of 180 degrees
    assert len(Faces.from_triangles(halves(dart), 0, 0)) == 2
    assert len(Faces.from_triangles(halves(arrow), 0, 0)) == 2
    assert len(Faces.from_triangles(np.array(spindle)[[[0, 1, 3], [1, 2, 3]]], 0, 0)) == 2
    assert len(Faces.from_triangles(np.array(bent)[[[0, 1, 3], [1, 2, 3]]], 0, 0)) == 2


def test_the_best_shape_goes_first():
    """Of a strip of squares every second edge is a diagonal: parallelograms must not win."""
    strip = np.concatenate([halves(q) for q in grid(4)[:4]])
    faces = Faces.from_triangles(strip[[1, 2, 0, 3, 4, 5, 6, 7]], 0, 0)
    assert len(faces) == 4
    edges = np.roll(faces.vertices, -1, axis=1) - faces.vertices
    np.testing.assert_allclose(np.linalg.norm(edges, axis=2), 1)


def test_unwelded_vertices_of_rounded_files_are_one():
    rng = np.random.default_rng(1)
    triangles = np.concatenate([halves(q) for q in grid(6)]) @ rotation(2).T + 100
    noisy = triangles + 1e-8 * rng.normal(size=triangles.shape)
    assert len(Faces.from_triangles(noisy, 0, 0)) == 36


def test_faces_without_area_are_dropped_and_counted():
    line = [[0, 0, 0], [1, 1, 1], [3, 3, 3]]
    point = [[5, 5, 5]] * 3
    far = np.array([[0, 0, 0], [1, 2, 3], [2, 4, 6]]) * 0.1 + 1e6  # straight up to rounding
    faces = Faces.from_triangles([line, SQUARE[:3], point, far], [0, 1, 2, 3], 0)
    assert faces.degenerate == 3
    assert faces.material.tolist() == [1]
    needle = [[0, 0, 0], [1, 0, 0], [1, 1e-9, 0]]
    assert len(Faces.from_triangles([needle], 0, 0)) == 1


def test_merge_can_be_left_out_and_quads_pass_through():
    assert len(Faces.from_triangles(halves(SQUARE), 0, 0, merge=False)) == 2
    mixed = np.concatenate([halves(SQUARE + 5)[:, [0, 1, 2, 2]], [SQUARE]])
    faces = Faces.from_polygons(mixed, [0, 0, 1], 0)
    np.testing.assert_array_equal(faces.vertices, [SQUARE + 5, SQUARE])
    assert faces.material.tolist() == [0, 1]


def greedy_twin(triangles):
    """All pairs of triangles, tried one by one, best corner first."""
    pairs = []
    for i in range(len(triangles)):
        for j in range(i + 1, len(triangles)):
            for k in range(3):
                a, b, c = np.roll(triangles[i], -k, axis=0)
                for m in range(3):
                    p, q, d = np.roll(triangles[j], -m, axis=0)
                    if np.allclose(a, q, atol=1e-9) and np.allclose(b, p, atol=1e-9):
                        pairs.append((twin_score(np.array([a, d, b, c])), i, j))
    used, chosen = set(), []
    for score, i, j in sorted((round(s, 6), i, j) for s, i, j in pairs if s is not None):
        if score <= np.cos(np.radians(30)) and not used & {i, j}:
            used |= {i, j}
            chosen.append((i, j))
    return len(triangles) - len(chosen), sorted(chosen)


def twin_score(quad):
    cosines, turns = [], []
    for k in range(4):
        u, v = quad[k] - quad[k - 1], quad[(k + 1) % 4] - quad[k]
        cosines.append(abs(u @ v) / np.linalg.norm(u) / np.linalg.norm(v))
        turns.append(np.cross(u, v)[2])
    return max(cosines) if min(turns) > 0 else None


@pytest.mark.parametrize("seed", range(5))
def test_merging_equals_its_plain_twin_on_random_sheets(seed):
    rng = np.random.default_rng(seed)
    points = np.column_stack([rng.uniform(size=(25, 2)), np.zeros(25)])
    triangles = points[Delaunay(points[:, :2]).simplices]
    area = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])[:, 2] / 2
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    faces = Faces.from_triangles(triangles, 0, 0)
    count, chosen = greedy_twin(triangles)
    assert len(chosen) > 5
    assert len(faces) == count
    assert np.count_nonzero(~faces.is_triangle) == len(chosen)
    starts = {tuple(triangles[i][0]) for i, _ in chosen}
    assert {tuple(v) for v in faces.vertices[~faces.is_triangle][:, 0]} == starts
    np.testing.assert_allclose(faces.areas().sum(), np.abs(area).sum())


def test_many_faces_on_one_edge_are_bounded_work():
    angle = np.linspace(0, 2 * np.pi, 3000)
    fan = np.zeros((3000, 3, 3))
    fan[:, 1, 2] = 1
    fan[:, 2, 0], fan[:, 2, 1] = np.cos(angle), np.sin(angle)
    fan[::2] = fan[::2][:, [1, 0, 2]]
    pairs = module._neighbours(fan, np.zeros(3000, int))[0]
    assert 1500 <= len(pairs) <= 8 * 3 * 1500  # all pairs of the axis would be 2 million
    assert len(Faces.from_triangles(fan, 0, 0)) > 0


def test_concatenate_keeps_order_and_adds_up_what_was_dropped():
    one = Faces.from_triangles([SQUARE[:3], [[0, 0, 0]] * 3], 1, 2)
    two = Faces.from_triangles(halves(SQUARE), 3, 4)
    faces = Faces.concatenate([one, two])
    assert (len(faces), faces.degenerate) == (2, 1)
    assert (faces.material.tolist(), faces.group.tolist()) == ([1, 3], [2, 4])
    assert len(Faces.concatenate([])) == 0
    assert len(Faces.from_triangles(np.empty((0, 3, 3)), 0, 0)) == 0
