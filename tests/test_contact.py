"""Contact: what touches, covers or crosses, and what does not."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, faces_of, meshed, rotation

from radiosity.mesh.contact import find_contacts

ROOM = box((0, 0, 0), (1, 1, 1))
LOW, HIGH = (0.3, 0.2, 0), (0.7, 0.6, 0.5)


def contacts(polygons, emits=()):
    flags = np.isin(np.arange(len(polygons)), emits)
    return find_contacts(faces_of(polygons), flags).faces


def covered_area(polygons, n=3, emits=()):
    """Return the covered area of every face."""
    faces = faces_of(polygons)
    _, _, patches = meshed(faces, n, np.isin(np.arange(len(faces)), emits))
    areas = np.bincount(patches.face, patches.area, len(faces))
    assert areas == pytest.approx(faces.areas(), rel=1e-12)  # rounding: cuts keep the area
    return np.bincount(patches.face, patches.area * patches.covered, len(faces))


def test_faces_that_meet_at_edges_or_not_at_all_have_no_contact():
    assert contacts(ROOM) == {}
    assert contacts(block((0, 0, 0), (1, 1, 1))) == {}
    floating = block((0.3, 0.3, 0.2), (0.6, 0.6, 0.5))
    assert contacts(np.concatenate([ROOM, floating])) == {}
    beside = SQUARE + [1.0, 0, 0]
    assert contacts(np.array([SQUARE, beside])) == {}


def test_a_gap_is_no_contact():
    lifted = block((0.3, 0.3, 1e-4), (0.6, 0.6, 0.5))
    assert contacts(np.concatenate([ROOM, lifted])) == {}


def test_a_block_without_bottom_cuts_the_floor_on_its_footprint():
    found = contacts(np.concatenate([ROOM, block(LOW, HIGH, bottom=False)]))
    assert list(found) == [0]
    floor = found[0]
    assert floor.covers == [] and len(floor.segments) == 4
    corners = {tuple(np.round(p, 12)) for p in floor.segments.reshape(-1, 3)}
    assert corners == {(x, y, 0.0) for x in (0.3, 0.7) for y in (0.2, 0.6)}


@pytest.mark.parametrize("n", [1, 2, 5])
def test_patches_of_the_floor_lie_in_or_out_of_the_footprint(n):
    faces = faces_of(np.concatenate([ROOM, block(LOW, HIGH, bottom=False)]))
    _, _, patches = meshed(faces, n)
    floor = np.flatnonzero(patches.face == 0)
    inside = np.all((patches.centroid > LOW) & (patches.centroid < HIGH), axis=1) | np.all(
        (patches.centroid[:, :2] > LOW[:2]) & (patches.centroid[:, :2] < HIGH[:2]), axis=1
    )
    assert not patches.covered.any()
    # rounding: cut exactly on the footprint of 0.4 x 0.4, no patch straddles it
    assert patches.area[floor][inside[floor]].sum() == pytest.approx(0.16, rel=1e-12)
    v = patches.vertices[floor][inside[floor]].reshape(-1, 3)[:, :2]
    assert v.min(axis=0) == pytest.approx(LOW[:2]) and v.max(axis=0) == pytest.approx(HIGH[:2])


@pytest.mark.parametrize("n", [1, 3, 4])
def test_a_block_with_bottom_covers_the_floor_and_is_covered(n):
    polygons = np.concatenate([ROOM, block(LOW, HIGH)])
    area = covered_area(polygons, n)
    assert area[[0, 6]] == pytest.approx([0.16, 0.16], rel=1e-12)  # rounding
    assert np.delete(area, [0, 6]).max() == 0.0


def test_each_side_of_a_contact_knows_the_other():
    faces = faces_of(np.concatenate([ROOM, block(LOW, HIGH)]))
    _, _, patches = meshed(faces, 4)
    behind = patches.behind[patches.covered, 0]
    assert np.array_equal(np.unique(behind[patches.face[patches.covered] == 0]), [6])
    assert np.array_equal(np.unique(behind[patches.face[patches.covered] == 6]), [0])
    assert np.all(patches.behind[~patches.covered] == -1)


@pytest.mark.parametrize("lamp_first", [False, True])
def test_a_lamp_in_the_plane_of_the_ceiling_wins(lamp_first):
    lamp = np.array([[0.4, 0.4, 1], [0.4, 0.6, 1], [0.6, 0.6, 1], [0.6, 0.4, 1]])[None]
    parts = (lamp, ROOM) if lamp_first else (ROOM, lamp)
    polygons = np.concatenate(parts)
    at, ceiling = (0, 2) if lamp_first else (6, 1)
    area = covered_area(polygons, 3, emits=[at])
    assert area[ceiling] == pytest.approx(0.04, rel=1e-12)  # rounding
    assert area.sum() == pytest.approx(0.04, rel=1e-12)


def test_of_two_dark_faces_in_one_plane_the_first_wins():
    small = SQUARE * 0.4 + [0.3, 0.3, 0]
    assert covered_area(np.array([SQUARE, small])) == pytest.approx([0, 0.16], rel=1e-12)
    assert covered_area(np.array([small, SQUARE])) == pytest.approx([0, 0.16], rel=1e-12)


def test_duplicates_cover_each_other_once():
    assert covered_area(np.array([SQUARE, SQUARE])) == pytest.approx([0, 1], rel=1e-12)
    back = SQUARE[::-1]
    assert covered_area(np.array([SQUARE, back])) == pytest.approx([1, 1], rel=1e-12)


def test_a_sunken_block_cuts_the_floor_where_it_crosses():
    sunken = block((0.3, 0.2, -0.1), (0.7, 0.6, 0.5))
    found = contacts(np.concatenate([ROOM, sunken]))
    floor = found.pop(0)
    assert floor.covers == [] and len(floor.segments) == 4
    assert floor.segments[..., 2] == pytest.approx(0.0, abs=1e-15)  # rounding
    length = np.linalg.norm(floor.segments[:, 1] - floor.segments[:, 0], axis=1)
    assert length == pytest.approx(0.4, rel=1e-12)  # clipped to nothing but the footprint
    assert sorted(found) == [8, 9, 10, 11]  # the four walls of the block, cut at the floor's height
    for wall in found.values():
        assert wall.segments[..., 2] == pytest.approx(0.0, abs=1e-15)


def test_a_wall_that_sticks_out_cuts_only_where_it_runs():
    fin = np.array([[0.5, -1, -1], [0.5, 0.4, -1], [0.5, 0.4, 1], [0.5, -1, 1]])
    segment = contacts(np.array([SQUARE, fin]))[0].segments
    assert sorted(map(tuple, np.round(segment[0], 12))) == [(0.5, 0.0, 0.0), (0.5, 0.4, 0.0)]


def test_contacts_turn_and_scale_with_the_scene():
    rng = np.random.default_rng(0)
    polygons = np.concatenate([ROOM, block(LOW, HIGH)])
    expected = covered_area(polygons)
    for size in (1e-6, 1.0, 1e6):
        turned = size * (polygons @ rotation(rng).T + rng.normal(size=3))
        # 1e-6: contacts are found to a millionth of the scene, positions keep their rounding
        assert covered_area(turned) / size**2 == pytest.approx(expected, abs=1e-6)


def test_the_order_of_faces_does_not_matter():
    polygons = np.concatenate([ROOM, block(LOW, HIGH)])
    order = np.random.default_rng(0).permutation(len(polygons))
    assert covered_area(polygons[order]) == pytest.approx(covered_area(polygons)[order], abs=1e-14)


def test_a_lamp_on_an_inside_out_ceiling_stands_back_to_back_with_it():
    """Opposite sides of one plane: a block covers a floor; a covered lamp would be of no use."""
    ceiling, lamp = SQUARE + [0, 0, 1], (0.2 * SQUARE + [0.4, 0.4, 1])[::-1]
    _, _, patches = meshed(faces_of(np.array([ceiling, lamp])), 3, np.array([False, True]))
    assert not patches.covered.any()
    hidden = patches.behind[:, 1]
    area = np.bincount(patches.face, patches.area * (hidden >= 0))
    assert area == pytest.approx([0.04, 0.04], rel=1e-12)  # rounding: cuts keep the area
    assert set(hidden[(patches.face == 0) & (hidden >= 0)]) == {1}
