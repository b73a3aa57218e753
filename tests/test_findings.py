"""What is odd about a mesh: found where it is, nowhere else, however the mesh is turned."""

from itertools import combinations, permutations
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import block, box, faces_of, halves, uv_sphere

from radiosity.mesh.bodies import find_bodies
from radiosity.mesh.contact import find_contacts
from radiosity.mesh.crossing import crossing_faces
from radiosity.mesh.duplicates import repeated
from radiosity.mesh.faces import Faces
from radiosity.mesh.findings import find_flaws
from radiosity.mesh.gaps import near_vertices, reach_of, t_junctions
from radiosity.mesh.seams import BRANCHED, OPEN, find_seams
from radiosity.mesh.winding import find_shells, inside_out, turned
from radiosity.scene.files import load

SCENES = Path(__file__).parents[1] / "scenes"
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
ROOM = box((0, 0, 0), (4, 4, 3))


def flaws(polygons, emits=False, merge=False):
    faces = Faces.from_polygons(polygons, 0, 0, merge)
    emits = np.broadcast_to(emits, len(faces))
    return find_flaws(faces, emits, find_contacts(faces, emits))


def counts(found):
    return {f.kind: f.count for f in found.found}


@pytest.mark.parametrize("merge", [True, False])
@pytest.mark.parametrize(
    ("polygons", "closed"),
    [
        (ROOM, (0, 1, 0)),
        (block((0, 0, 0), (1, 1, 1)), (1, 0, 0)),
        (halves(ROOM), (0, 1, 0)),
        (uv_sphere(6), (0, 1, 0)),
        (np.concatenate([ROOM, block((1, 1, 0), (2, 2, 1))]), (1, 1, 0)),  # contact is no flaw
        (np.concatenate([ROOM, block((1, 1, 0), (2, 2, 1), bottom=False)]), (0, 1, 1)),
        (np.concatenate([block((0, 0, 0), (1, 1, 1)), block((1, 1, 0), (2, 2, 1))]), (1, 0, 0)),
        (np.concatenate([SQUARE[None], SQUARE[None, ::-1]]), (1, 0, 0)),  # a sheet's two sides
    ],
    ids=["room", "block", "triangles", "sphere", "standing", "bottomless", "edge", "sheet"],
)
def test_sound_meshes_have_no_findings(polygons, closed, merge):
    found = flaws(polygons, merge=merge)
    assert found.found == ()
    assert (found.outward, found.inward, found.open) == closed


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda p: p.stem)
def test_shipped_scenes_raise_no_false_alarm(path):
    """Rectangles of frames and ceilings do not meet corner to corner; a board lies on a wall."""
    scene = load(path)
    emits = np.array([m.emits for m in scene.materials])[scene.faces.material]
    found = counts(find_flaws(scene.faces, emits, find_contacts(scene.faces, emits)))
    juncts = path.stem.startswith(("cornell", "living_room", "lroom", "museum"))
    expected = {"overlapping"} if path.stem == "meeting_room" else set()
    assert set(found) == ({"T-junction"} if juncts else expected)


def shifted(polygon, x=0.0, y=0.0, z=0.0):
    return polygon + np.array([x, y, z])


CASES = {
    "degenerate": ([SQUARE, SQUARE * [1, 0, 0]], {"degenerate": 1}),
    "overlapping": ([SQUARE, shifted(SQUARE, 0.5, 0.25)], {"overlapping": 1}),
    "crossing": ([SQUARE, shifted(SQUARE[:, [2, 0, 1]], 0.5, 0.25, -0.5)], {"crossing": 1}),
    "near": ([SQUARE, shifted(SQUARE, 1 + 4e-6)], {"near": 2}),
    "short": ([SQUARE, shifted(SQUARE * [1, 4e-6, 1], 3)], {}),
    "far": ([SQUARE, shifted(SQUARE, 1 + 1e-4)], {}),
    "T-junction": ([SQUARE, shifted(SQUARE * 0.5, 1), shifted(SQUARE * 0.5, 1, 0.5)],
                   {"T-junction": 1}),  # fmt: skip
    "branched": ([SQUARE, shifted(SQUARE, -1), SQUARE[:, [2, 1, 0]]], {"branched": 1}),
    "winding": ([SQUARE, shifted(SQUARE, 1), shifted(SQUARE, 2)[::-1]], {"winding": 1}),
    "inside out": ([*ROOM, *block((1, 1, 1), (2, 2, 2))[:, ::-1]], {"inside out": 1}),
}


@pytest.mark.parametrize("name", CASES)
def test_each_kind_on_a_few_faces(name):
    polygons, expected = CASES[name]
    found = flaws(np.array(polygons))
    assert counts(found) == expected
    low, high = np.min(polygons, axis=(0, 1)) - 1e-9, np.max(polygons, axis=(0, 1)) + 1e-9
    for f in found.found:
        assert all(np.all((p >= low) & (p <= high)) for p in np.array(f.points))
        assert len(f.faces) == len(f.points) <= 3


def test_places_are_those_of_the_oddity():
    (near,) = flaws(np.array(CASES["near"][0])).found
    np.testing.assert_allclose(sorted(near.points), [[1, 0, 0], [1, 1, 0]], atol=1e-5)
    (junction,) = flaws(np.array(CASES["T-junction"][0])).found
    np.testing.assert_allclose(junction.points, [[1, 0.5, 0]])
    (crossing,) = flaws(np.array(CASES["crossing"][0])).found
    np.testing.assert_allclose(crossing.points, [[0.5, 0.625, 0]])
    (branch,) = flaws(np.array(CASES["branched"][0])).found
    np.testing.assert_allclose(branch.points, [[0, 0.5, 0]])


def test_a_lamp_in_the_plane_of_a_wall_is_no_flaw():
    polygons = np.array([SQUARE, shifted(SQUARE * 0.5, 0.25, 0.25)])
    assert counts(flaws(polygons, [False, True])) == {}
    assert counts(flaws(polygons, [True, True])) == {"overlapping": 1}


def soup(rng, n=40):
    """Return triangles of random sizes, some of which share vertices or repeat others."""
    size = rng.uniform(0.1, 0.7, (n, 1, 1))
    made = rng.random((n, 1, 3)) + size * rng.normal(0, 0.5, (n, 3, 3))
    made[5:9, 0], made[9, :2] = made[:4, 1], made[3, :2][::-1]
    made[10, 0] = (made[11, 0] + made[11, 1]) / 2  # a T-junction
    made[12, 0] = made[13, 2] + 1e-6  # nearly meets
    return made[:, [0, 1, 2, 2]]


@pytest.mark.parametrize("seed", range(4))
def test_the_fast_ways_find_what_all_pairs_show(seed):
    faces = faces_of(soup(np.random.default_rng(seed)))
    seams = find_seams(faces)
    pairs, _ = crossing_faces(faces)
    slow = slow_crossings(faces.vertices[:, :3])
    nearly = {(12, 13)}  # meet within what counts as touching, 5e-7 of the size
    assert set(map(tuple, pairs.tolist())) - nearly == set(slow) - nearly
    assert len(pairs) > 5
    assert len(near_vertices(faces, seams)[0]) == slow_near(faces) >= 1
    assert len(t_junctions(faces, seams)[0]) == slow_junctions(faces) >= 1
    kinds = np.bincount(seams.kinds(), minlength=3)
    assert kinds[OPEN] == 3 * 40 - 2 and kinds[BRANCHED] == 0  # two share one edge


def slow_crossings(triangles):
    """Return the pairs of triangles of which a side of one meets the inside of the other."""
    found = []
    for (i, p), (j, q) in combinations(enumerate(triangles), 2):
        if any(pierces(a[k], a[k - 1], b) for a, b in ((p, q), (q, p)) for k in range(3)):
            found.append((i, j))
    return found


def pierces(start, end, triangle):
    a, b, c = triangle
    try:
        t, u, v = np.linalg.solve(np.stack([start - end, b - a, c - a], axis=1), start - a)
    except np.linalg.LinAlgError:
        return False
    return 1e-5 < t < 1 - 1e-5 and u > 1e-5 and v > 1e-5 and u + v < 1 - 1e-5


def slow_near(faces):
    points = np.unique(faces.vertices[:, :3].reshape(-1, 3), axis=0)
    gaps = [np.linalg.norm(a - b) for a, b in combinations(points, 2)]
    return sum(g <= reach_of(faces) for g in gaps)


def slow_junctions(faces):
    points = np.unique(faces.vertices[:, :3].reshape(-1, 3), axis=0)
    reach, found = reach_of(faces), set()
    for k, p in enumerate(points):
        for t in faces.vertices[:, :3]:
            for a, b in zip(t, np.roll(t, 1, axis=0), strict=True):
                length = np.linalg.norm(b - a)
                along = (p - a) @ (b - a) / length
                off = np.linalg.norm(p - a - along / length * (b - a))
                if off <= reach < along < length - reach:
                    found.add(k)
    return len(found)


@pytest.mark.parametrize("seed", range(3))
def test_findings_do_not_depend_on_order_place_or_size(seed):
    rng = np.random.default_rng(seed)
    apart = (np.array(CASES[kind][0]) + 5 * k for k, kind in enumerate(CASES, 1))
    polygons = np.concatenate([soup(rng), *apart])
    expected = flaws(polygons)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = polygons[rng.permutation(len(polygons))] @ turn.T * 37.0
    found = flaws(moved)
    assert counts(found) == counts(expected)
    assert (found.open, found.inward, found.outward) == (
        expected.open, expected.inward, expected.outward
    )  # fmt: skip


def test_repeated_faces_are_those_of_one_winding_and_surface():
    rng = np.random.default_rng(1)
    quad, triangle = rng.random((4, 3)), rng.random((3, 3))[[0, 1, 2, 2]]
    same = [np.roll(quad, k, axis=0) for k in range(4)]
    same += [np.roll(triangle[:3], k, axis=0)[[0, 1, 2, 2]] for k in range(3)]
    other = [quad[::-1], triangle[[1, 0, 2, 2]], quad + 1e-9, quad[[0, 2, 1, 3]]]
    v = np.array(same + other)
    found = repeated(v, np.zeros(len(v), int))
    assert found.tolist() == [False, True, True, True, False, True, True] + [False] * 4
    assert not repeated(v, np.arange(len(v))).any()
    of_two = repeated(v[[0, 1, 2, 3]], np.array([0, 1, 1, 0]))
    assert of_two.tolist() == [False, False, True, True]
    assert repeated(np.array([quad * 0.0, quad * -0.0]), np.zeros(2, int)).tolist() == [False, True]


def test_joining_drops_repeated_faces_and_counts_them():
    twice = np.concatenate([halves(ROOM), halves(ROOM)])
    faces = Faces.from_polygons(twice, 0, 0)
    assert (len(faces), faces.duplicates) == (6, 12)
    assert len(Faces.from_polygons(twice, 0, 0, merge=False)) == 24
    assert len(Faces.from_polygons(twice, 0, np.arange(24) // 12)) == 12  # of two groups
    joined = Faces.concatenate([faces, faces]).without_duplicates()
    assert (len(joined), joined.duplicates) == (6, 30)


@pytest.mark.parametrize("seed", range(3))
def test_shells_tell_the_smaller_part_of_a_body(seed):
    """As many faces as were turned are odd, in the body they belong to; it stays no body."""
    rng = np.random.default_rng(seed)
    polygons = np.concatenate([uv_sphere(5)[:, ::-1], uv_sphere(4) * 0.3])
    odd = rng.random(len(polygons)) < 0.2
    faces = turned(faces_of(polygons), odd)
    shells = find_shells(faces, find_seams(faces))
    np.testing.assert_array_equal(shells.odd, odd)
    assert shells.closed.all() and shells.orientable.all()
    outer = shells.of_face[0]
    assert shells.volume[outer] > 3.0 and shells.volume[1 - outer] == pytest.approx(
        -0.027 * 4 * np.pi / 3, rel=0.3  # a coarse sphere holds less
    )
    assert find_bodies(faces).count == 0 and find_bodies(turned(faces, odd)).count == 2


def test_turned_faces_keep_their_first_corner_and_coordinates():
    uv = np.broadcast_to(SQUARE[:, :2], (2, 4, 2))
    v = np.array([SQUARE, SQUARE[[0, 1, 2, 2]]])
    faces = Faces.from_polygons(v, 0, 0, False, uv, np.broadcast_to([0, 0, 1.0], (2, 4, 3)))
    back = turned(faces, np.array([True, True]))
    np.testing.assert_allclose(back.normals(), [[0, 0, -1]] * 2)
    np.testing.assert_array_equal(back.uv[0], SQUARE[[0, 3, 2, 1], :2])
    np.testing.assert_array_equal(back.vertices[:, 0], faces.vertices[:, 0])
    np.testing.assert_array_equal(back.corner_normals, np.broadcast_to([0, 0, -1.0], (2, 4, 3)))
    np.testing.assert_array_equal(back.is_triangle, [False, True])


def test_a_projective_plane_has_no_inside():
    """The six-vertex triangulation: closed, each edge has two faces, and it cannot be oriented."""
    rows = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 1), (1, 2, 4), (2, 3, 5), (3, 4, 1),
            (4, 5, 2), (5, 1, 3)]  # fmt: skip
    points = np.random.default_rng(2).random((6, 3))
    faces = Faces.from_triangles(points[np.array(rows)], 0, 0, False)
    shells = find_shells(faces, find_seams(faces))
    assert shells.closed.tolist() == [True] and shells.orientable.tolist() == [False]
    assert not shells.odd.any() and shells.volume.tolist() == [0.0]


def test_rooms_and_furniture_are_not_inside_out():
    lamp = block((1, 1, 1), (2, 2, 2))
    for polygons in permutations([ROOM, lamp, block((3, 3, 0), (3.5, 3.5, 1))]):
        faces = faces_of(np.concatenate(polygons))
        assert not inside_out(faces, find_shells(faces, find_seams(faces))).any()
    faces = faces_of(np.concatenate([ROOM, lamp[:, ::-1]]))
    assert inside_out(faces, find_shells(faces, find_seams(faces))).sum() == 1
