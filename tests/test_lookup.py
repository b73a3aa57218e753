"""From a point on a face back to its patch, against a search through all patches."""

import numpy as np
import pytest
from scenes_for_tests import SKEW, TRIANGLE, block, box, faces_of, meshed, rotation

from radiosity.mesh.contact import find_contacts
from radiosity.mesh.division import Division
from radiosity.mesh.patches import make_patches
from radiosity.transport.lookup import CUT, cut_side, make_table, whole_side

PARALLELOGRAM = np.array([[0, 0, 0], [2, 0.3, 0], [2.6, 1.5, 0], [0.6, 1.2, 0]])
TRAPEZOID = np.array([[0, 0, 0], [3, 0, 0], [2, 1, 0], [0.5, 1, 0]])
ROOM = np.concatenate([box((0, 0, 0), (1, 1, 1)), block((0.31, 0.2, 0), (0.7, 0.63, 0.5))])


def side_of(table, face, x, d):
    """What a ray along d that ends at x meets, as the transport asks."""
    side = whole_side(table, face, x, *map(float, d))
    return cut_side(table, face, x, d) if side == CUT else side


def margin(polygon, normal, x):
    """How far x lies inside the nearest edge of a convex polygon."""
    corners = polygon[:3] if np.array_equal(polygon[2], polygon[3]) else polygon
    edge = np.roll(corners, -1, axis=0) - corners
    inward = np.cross(normal, edge) / np.linalg.norm(edge, axis=1, keepdims=True)
    return ((x - corners) * inward).sum(axis=1).min()


def random_points(rng, faces, count):
    """Faces drawn at random with a point inside of each."""
    which = rng.integers(0, len(faces), count)
    a, b, c, d = np.moveaxis(faces.vertices[which], 1, 0)
    one = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    two = np.linalg.norm(np.cross(c - a, d - a), axis=1)
    first = (rng.random(count) * (one + two) < one)[:, None]
    u, v = rng.random((2, count, 1))
    flip = u + v > 1
    u, v = np.where(flip, 1 - u, u), np.where(flip, 1 - v, v)
    return which, a + np.where(first, u * (b - a) + v * (c - a), u * (c - a) + v * (d - a))


@pytest.mark.parametrize("polygon", [TRIANGLE, PARALLELOGRAM, TRAPEZOID, SKEW])
@pytest.mark.parametrize("shape", [(1, 1), (3, 2), (7, 10)])
@pytest.mark.parametrize("depth", [0, 1, 3])
def test_the_side_found_holds_the_point(polygon, shape, depth):
    rng = np.random.default_rng(0)
    turn, size = rotation(rng), 10 ** rng.uniform(-3, 3)
    faces = faces_of(size * (polygon @ turn.T + 1)[None])
    shape = (shape[0], 0) if faces.is_triangle[0] else shape
    nothing = find_contacts(faces, np.zeros(1, bool))
    division = Division(np.array([shape]))
    for _ in range(depth):
        division = division.divided(rng.choice([1, 1, 1, 2, 3], division.count))
    patches = make_patches(faces, division, nothing)
    table, normal = make_table(faces, patches), faces.normals()[0]
    _, points = random_points(rng, faces, 300)
    for x in points:
        d = rotation(rng)[0]
        side = side_of(table, 0, x, d)
        assert side % 2 == (d @ normal > 0)  # a ray along the normal comes from behind
        # rounding: a point on a border may go either way
        assert margin(patches.vertices[side // 2], normal, x) > -1e-9 * size
    every = {side_of(table, 0, c.copy(), -normal) for c in patches.centroid}
    assert every == {2 * k for k in range(len(patches))}


@pytest.mark.parametrize("n", [1, 2, 5])
def test_parts_of_cut_cells_are_found(n):
    rng = np.random.default_rng(1)
    sunken = np.concatenate([ROOM[:6], block((0.3, 0.2, -0.1), (0.7, 0.6, 0.5), bottom=False)])
    faces = faces_of(sunken @ rotation(rng).T)
    _, table, patches = meshed(faces, n)
    assert np.diff(patches.grid.start).max() > 1
    for face, x in zip(*random_points(rng, faces, 400), strict=True):
        d = rotation(rng)[0]
        side = side_of(table, face, x, d)
        front = side // 2
        assert patches.face[front] == face and side % 2 == (d @ faces.normals()[face] > 0)
        assert margin(patches.vertices[front], patches.normal[front], x) > -1e-9  # rounding


@pytest.mark.parametrize("n", [1, 3, 4])
def test_a_covered_front_sends_the_ray_to_the_face_behind(n):
    """A ray that comes from inside the block through its bottom meets what lies under the floor."""
    rng = np.random.default_rng(2)
    faces = faces_of(ROOM)
    _, table, patches = meshed(faces, n)
    for _ in range(200):
        x = rng.uniform((0.31, 0.2, 0), (0.7, 0.63, 0))
        down, up = np.array([0.1, 0.2, -1.0]), np.array([0.1, 0.2, 1.0])
        inner, outer = side_of(table, 0, x, down), side_of(table, 6, x, up)
        # from inside the block: the back of its bottom; from below: the back of the floor
        assert patches.face[inner // 2] == 6 and inner % 2 == 1
        assert patches.face[outer // 2] == 0 and outer % 2 == 1
        assert side_of(table, 6, x, down) == inner and side_of(table, 0, x, up) == outer
        for side in (inner, outer):
            assert margin(patches.vertices[side // 2], patches.normal[side // 2], x) > -1e-9


def test_a_lamp_in_the_ceiling_is_met_in_its_place():
    lamp = np.array([[0.4, 0.4, 1], [0.4, 0.6, 1], [0.6, 0.6, 1], [0.6, 0.4, 1]])
    faces = faces_of(np.concatenate([ROOM[:6], lamp[None]]))
    _, table, patches = meshed(faces, 3, emits=np.arange(7) == 6)
    rng, up = np.random.default_rng(3), np.array([0.0, 0.1, 1.0])
    for x in rng.uniform((0.2, 0.2, 1), (0.8, 0.8, 1), (300, 3)):
        within = np.all(np.abs(x[:2] - 0.5) < 0.1)
        for face in (1, 6) if within else (1,):
            side = side_of(table, face, x, up)
            assert side % 2 == 0 and patches.face[side // 2] == (6 if within else 1)
            assert not patches.covered[side // 2]
