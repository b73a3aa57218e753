"""Closed bodies among the faces, and who lies on their free side."""

import numpy as np
import pytest
from scenes_for_tests import (
    SQUARE,
    block,
    box,
    faces_of,
    l_room,
    meshed,
    rotation,
    tetrahedron,
    uv_sphere,
)

from radiosity.mesh.bodies import find_bodies, free_of
from radiosity.transport.visibility import Visibility

ROOM = box((0, 0, 0), (4, 3, 2))
BLOCK = block((1, 1, 0.5), (2, 2, 1.5))


def normals_of(polygons):
    return faces_of(polygons).normals()


def is_free(body, points, slack=1e-9):
    return free_of(body, body[:, 0], normals_of(body), np.asarray(points, float), slack)


# ------------------------------------------------------------------------------- bodies


@pytest.mark.parametrize("polygons", [ROOM, BLOCK, tetrahedron(), uv_sphere(6)])
def test_a_closed_surface_is_one_body(polygons):
    bodies = find_bodies(faces_of(polygons))
    assert bodies.count == 1
    assert np.all(bodies.of_face == 0)


def test_a_corner_on_an_edge_leaves_it_open():
    """The L-room's floor is cut where a wall is not: its corner lies on an edge of that wall."""
    assert find_bodies(faces_of(l_room())).count == 0


def test_apart_they_are_counted_apart():
    bodies = find_bodies(faces_of(np.concatenate([ROOM, BLOCK])))
    assert bodies.count == 2
    assert len(set(bodies.of_face[:6])) == len(set(bodies.of_face[6:])) == 1


@pytest.mark.parametrize("missing", range(6))
def test_with_a_face_missing_it_is_none(missing):
    bodies = find_bodies(faces_of(np.concatenate([np.delete(ROOM, missing, 0), BLOCK])))
    assert bodies.count == 1
    assert np.all(bodies.of_face[:5] == 1)  # the count: no body


def test_with_a_face_turned_over_it_is_none():
    turned = np.concatenate([ROOM[:5], ROOM[5:, ::-1]])
    assert find_bodies(faces_of(turned)).count == 0


def test_a_sheet_on_an_edge_makes_it_none():
    """Three faces at one edge: no inside and outside any more."""
    sheet = np.array([[0, 0, 0], [4, 0, 0], [4, -1, -1], [0, -1, -1]], float)
    assert find_bodies(faces_of(np.concatenate([ROOM, [sheet]]))).count == 0


def test_no_faces_no_bodies():
    bodies = find_bodies(faces_of(np.zeros((0, 4, 3))))
    assert bodies.count == 0 and len(bodies.of_face) == 0


# ------------------------------------------------------------------------------- free sides


def moved(centre, size=0.2):
    return (SQUARE - [0.5, 0.5, 0]) * size + centre


@pytest.mark.parametrize("turned", [False, True])
def test_inside_of_a_convex_room_is_free_and_outside_is_not(turned):
    rng = np.random.default_rng(3)
    turn = rotation(rng) if turned else np.eye(3)
    for room, centre in ((ROOM, (2, 1.5, 1)), (tetrahedron(), (0, 0, 0))):
        inside, outside, across = (moved(c) @ turn.T for c in (centre, (9, 9, 9), room[0, 0]))
        assert is_free(room @ turn.T, [inside, outside, across]).tolist() == [True, False, False]


@pytest.mark.parametrize("turned", [False, True])
def test_outside_of_a_convex_block_is_free_and_inside_is_not(turned):
    rng = np.random.default_rng(4)
    turn = rotation(rng) if turned else np.eye(3)
    points = [moved(c) @ turn.T for c in ((3, 1.5, 1), (1.5, 1.5, 1), (2, 1.5, 1), (1.5, 1.5, 1.5))]
    # beside it, inside it, across its wall, on its top
    assert is_free(BLOCK @ turn.T, points).tolist() == [True, False, False, True]


def test_of_a_body_that_is_not_convex_what_is_beside_its_box_is_free():
    outside = l_room()[:, ::-1]
    points = [moved((5, 1, 1)), moved((2, 2, 1)), moved((0.5, 0.5, 1))]
    # beside the box, in the notch, which is not sure, and inside
    assert is_free(outside, points).tolist() == [True, False, False]
    assert not is_free(l_room(), points).any()  # looks inward: nothing is sure


def test_too_much_to_look_at_is_not_sure(monkeypatch):
    monkeypatch.setattr("radiosity.mesh.bodies.LARGEST", 10)
    assert not is_free(ROOM, [moved((2, 1.5, 1))]).any()


def test_patches_of_a_body_are_free_on_their_fronts():
    """Fronts of a body's own faces look into its free side, backs into what it encloses."""
    _, _, patches = meshed(faces_of(np.concatenate([ROOM, BLOCK])), 2)
    visibility = Visibility(faces_of(np.concatenate([ROOM, BLOCK])))
    free = visibility.free_sides(patches)
    assert free.shape == (len(patches), 3) and not free[:, 2].any()
    room, block_ = visibility._of_face[0], visibility._of_face[6]
    of_room = patches.face < 6
    assert np.array_equal(free[of_room, room], patches.front[of_room])
    assert np.array_equal(free[~of_room, block_], patches.front[~of_room])
    assert free[~of_room, room].all()
    assert free[of_room, block_].all()  # walls, from either side, are outside of the block
