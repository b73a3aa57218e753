"""Faces that lie on each other: back to back where both look into free space, else face to face."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, faces_of, rotation, scene

from radiosity import form_factors, solve
from radiosity.mesh.contact import find_contacts
from radiosity.transport.facing import settled
from radiosity.transport.visibility import Visibility

ROOM, NEXT = box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1))
PANEL = 0.4 * SQUARE[None] + [0.3, 0.3, 0.5]
SHEET = np.concatenate([PANEL, PANEL[:, ::-1]])
CARPET = (0.4 * SQUARE[None] + [0.3, 0.3, 0])[:, ::-1]
LOW, HIGH = (0.3, 0.2, 0), (0.7, 0.6, 0.5)
GRID = np.concatenate([box(c, np.add(c, 1)) for c in np.ndindex(3, 3, 3)])
AROUND = SQUARE * 3 - [1, 1, 0]
UP = box((0, 0, 1), (1, 1, 2))  # a room above: its floor is face 6 after ROOM
STACK = np.concatenate([block(c, np.add(c, 1)) for c in np.ndindex(4, 4, 4)])
HOUSE = np.concatenate([ROOM, block((0, 0, 0), (1, 1, 1))])
LAMP = (0.2 * SQUARE[None] + [1.4, 1.4, 1.8])[:, ::-1]


def sides(polygons):
    """Return the sets of faces that are covered and that are hidden from behind by another one."""
    faces = faces_of(polygons)
    contacts = find_contacts(faces, np.zeros(len(faces), bool))
    found = settled(contacts, faces, Visibility(faces)).faces
    covered, hidden = ({f for f, c in found.items() if getattr(c, k)} for k in ("covers", "hides"))
    return covered, hidden


BACK_TO_BACK = {
    "two rooms": (np.concatenate([ROOM, NEXT]), {3, 8}),
    "two rooms without ceilings": (np.concatenate([np.delete(ROOM, 1, 0), np.delete(NEXT, 1, 0)]),
                                   {2, 6}),
    "a room in a row of rooms": (np.concatenate([ROOM, NEXT, NEXT + [1, 0, 0]]), {3, 8, 9, 14}),
    "a room among rooms on all sides": (GRID, set(range(6 * 13, 6 * 14))),
    "walls of two rooms that overlap in part": (
        np.concatenate([ROOM, box((1, 0.4, 0.2), (2, 1.5, 1))]), {3, 8}),
    "a table in the middle of the wall": (
        np.concatenate([ROOM, NEXT, block((0.8, 0.4, 0), (1, 0.6, 0.7))]), {8}),
    "a table in the middle of the floor above": (
        np.concatenate([ROOM, UP, block((0.4, 0.4, 1), (0.6, 0.6, 1.3))]), {1}),
    "a hanging lamp in the middle of many rooms": (
        np.concatenate([GRID, LAMP]), set(range(6 * 13, 6 * 14))),
    "a house of walls without thickness": (HOUSE, set(range(12))),
    "a sheet's two sides over the ground": (np.concatenate([AROUND[None], SHEET]), {1, 2}),
    "a sheet's two sides in a room": (np.concatenate([ROOM, SHEET]), {6, 7}),
    "a sheet's two sides, nothing else": (SHEET, {0, 1}),
}  # fmt: skip
FACE_TO_FACE = {
    "a block on the floor": (np.concatenate([ROOM, block(LOW, HIGH)]), {0, 6}),
    "a block on a floor under the sky": (np.concatenate([ROOM[:1], block(LOW, HIGH)]), {0, 1}),
    "a bin on the floor": (np.concatenate([ROOM, np.delete(block(LOW, HIGH), 1, 0)]), {0, 6}),
    "a block on a block": (
        np.concatenate([ROOM, block(LOW, HIGH), block((0.4, 0.3, 0.5), (0.6, 0.5, 0.8))]),
        {0, 6, 7, 12}),
    "a carpet the wrong way up": (np.concatenate([ROOM, CARPET]), {0, 6}),
    "a block as large as its ground": (
        np.concatenate([SQUARE[None], block((0, 0, 0), (1, 1, 0.5))]), {0, 1}),
    "a carpet the wrong way up under the sky": (np.concatenate([AROUND[None], CARPET]), {0, 1}),
}  # fmt: skip


@pytest.mark.parametrize("name", BACK_TO_BACK)
def test_free_sides_stand_back_to_back(name):
    polygons, expected = BACK_TO_BACK[name]
    covered, hidden = sides(polygons)
    assert hidden >= expected and not covered & expected


def test_what_stands_before_a_wall_covers_its_own_part_only():
    polygons = np.concatenate([ROOM, UP, block((0.4, 0.4, 1), (0.6, 0.6, 1.3))])
    covered, hidden = sides(polygons)
    assert covered == {6, 12} and hidden == {1, 6}
    lit = scene(polygons, 0.5, np.eye(len(polygons))[1])
    found = solve(lit, 0.05)
    assert found.balance.emitted == pytest.approx(1.0, rel=1e-9)
    alone = solve(scene(ROOM, 0.5, np.eye(6)[1]), 0.05)
    point = np.array([[0.3, 0.4, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    assert found.irradiance(*point)[0] == pytest.approx(alone.irradiance(*point)[0], rel=0.02)


def test_inside_a_stack_of_solids_nothing_shines():
    assert solve(scene(STACK, 0.5, 1.0), 0.1, mesh="1", order=0).balance.emitted == (
        pytest.approx(96.0)
    )


def test_a_wall_that_touches_within_tolerance_may_be_read_first_or_last():
    """Tilted by 1e-7: near to the large wall's plane all over, which is not near to its own."""
    small = box((1, 0.4, 0.4), (2, 0.6, 0.5))
    small[..., 0] += 1e-7 * (small[..., 2] - 0.45) / 0.1 * (small[..., 0] == 1)
    assert 3 in sides(np.concatenate([ROOM, small]))[1]
    assert 9 in sides(np.concatenate([small, ROOM]))[1]


@pytest.mark.parametrize("name", FACE_TO_FACE)
def test_what_lies_on_a_face_covers_it(name):
    polygons, expected = FACE_TO_FACE[name]
    assert sides(polygons) == (expected, set())


def test_a_carpet_the_wrong_way_up_covers_the_floor_of_any_storey():
    covered, hidden = sides(np.concatenate([ROOM, UP, CARPET + [0, 0, 1]]))
    assert {6, 12} <= covered and hidden == {1, 6}


@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_neither_place_nor_order_matters(size):
    rng = np.random.default_rng(0)
    polygons = np.concatenate([ROOM, NEXT, block(LOW, HIGH), SHEET + [0, 0, 0.2]])
    covered, hidden = sides(polygons)
    assert covered == {0, 12} and hidden == {3, 8, 18, 19}
    order = rng.permutation(len(polygons))
    moved = size * (polygons[order] @ rotation(rng).T + rng.normal(size=3))
    found = tuple({int(order[f]) for f in some} for some in sides(moved))
    assert found == (covered, hidden)


@pytest.mark.parametrize("order", [0, 1])
def test_a_room_does_not_know_the_room_next_door(order):
    """Its walls have a reflectance of their own, whatever stands on the other side of them."""
    emitted = np.eye(6)[1]
    one = solve(scene(ROOM, 0.5, emitted), 0.02, mesh="4", order=order)
    both = scene(np.concatenate([ROOM, NEXT]), [0.5] * 6 + [0.9] * 6, np.append(emitted, 6 * [0]))
    two = solve(both, 0.02, mesh="4", order=order)
    points = np.array([[0.98, 0.4, 0.3], [1.0, 0.4, 0.3], [0.3, 0.6, 0.0]])
    normals = np.array([[-1.0, 0, 0], [-1, 0, 0], [0, 0, 1]])
    alone, beside = (s.irradiance(points, normals)[0][:, 0] for s in (one, two))
    assert beside == pytest.approx(alone, rel=1e-3)
    assert len(two.level.rows) == len(one.level.rows)  # next door it stays dark


def test_both_sides_of_a_sheet_shine():
    """As two sheets do that stand a little apart."""
    emitted = np.array([0.0] * 6 + [1.0, 2.0])
    apart = np.concatenate([ROOM, PANEL + [0, 0, 1e-3], PANEL[:, ::-1]])
    points, normals = np.array([[0.5, 0.5, 0], [0.2, 0.5, 1]]), np.array([[0, 0, 1.0], [0, 0, -1]])
    found = []
    for polygons in (np.concatenate([ROOM, SHEET]), apart):
        solution = solve(scene(polygons, 0.3, emitted), 0.01)
        assert solution.balance.emitted == pytest.approx(3 * 0.16, rel=1e-9)
        found.append(solution.irradiance(points, normals)[0][:, 0])
    assert found[0] == pytest.approx(found[1], rel=0.01)
    assert found[0][0] > 1.2 * found[0][1]


def test_form_factors_of_rooms_side_by_side_are_those_of_each():
    alone, both = (
        form_factors((polygons.reshape(-1, 3), np.arange(4 * len(polygons)).reshape(-1, 4)))
        for polygons in (ROOM, np.concatenate([ROOM, NEXT]))
    )
    expected = np.kron(np.eye(2), alone.toarray())
    assert both.toarray() == pytest.approx(expected, abs=1e-3)
