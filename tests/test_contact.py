"""Contact: what touches, covers or crosses, and what does not."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, faces_of, meshed, rotation

from radiosity.mesh import boxes
from radiosity.mesh import contact as module
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


def pairwise(faces, emits):
    """Return what `find_contacts` does, by looking at every pair of faces: its plain twin."""
    v, normals, found = faces.vertices, faces.normals(), {}
    low, high = v.min(axis=1), v.max(axis=1)
    touch = module.TOUCH * np.linalg.norm(high.max(axis=0) - low.min(axis=0))
    for f in range(len(v)):
        near = np.all(low <= high[f] + touch, axis=1) & np.all(high >= low[f] - touch, axis=1)
        others = np.delete(np.flatnonzero(near), np.count_nonzero(near[:f]))
        height = (v[others] - v[f, 0]) @ normals[f]
        meets = (height.min(axis=1) <= touch) & (height.max(axis=1) >= -touch)
        one = module._contact(f, others[meets], height[meets], faces, normals, emits, touch)
        if one is not None:
            found[f] = one
    return found


def divided(polygons, n):
    """Return quadrilaterals (f, 4, 3) as n x n each."""
    t = np.linspace(0, 1, n + 1)
    corner = [t[:-1], t[1:], t[1:], t[:-1]]
    a = np.stack([np.repeat(x, n) for x in corner], axis=1)
    b = np.stack([np.tile(x, n) for x in np.roll(corner, 1, axis=0)], axis=1)
    weight = np.stack([(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b], axis=2)
    return np.einsum("ckw,fwx->fckx", weight, polygons).reshape(-1, 4, 3)


def crowded(rng):
    """Return a scene of everything that touches: meshed rooms, blocks, sheets and triangles."""
    turn = rotation(rng) if rng.random() < 0.5 else np.eye(3)
    flip = slice(None, None, rng.choice([-1, 1]))
    parts = [divided(ROOM[:, flip], rng.integers(1, 5))]
    for _ in range(rng.integers(1, 4)):
        low = rng.integers(0, 4, 3) / 5 * [1, 1, rng.integers(0, 2)]
        high = low + rng.integers(1, 3, 3) / 5
        parts.append(divided(block(low, high, bottom=rng.random() < 0.5), rng.integers(1, 4)))
    angle = rng.uniform(0, np.pi)
    tilt = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0]])
    lamp = 0.4 * (SQUARE[:, :2] - 0.5) @ tilt + [0.5, 0.5, rng.integers(0, 2)]
    parts.append(divided(lamp[None, :: rng.choice([-1, 1])], rng.integers(1, 4)))
    parts.append(rng.random((6, 4, 3))[:, [0, 1, 2, 2]])
    polygons = np.concatenate(parts)
    order = rng.permutation(len(polygons))
    return faces_of((polygons @ turn.T)[order]), (rng.random(len(polygons)) < 0.2)[order]


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("chunk", [7, boxes.CHUNK])
def test_contacts_are_those_of_every_pair(seed, chunk, monkeypatch):
    monkeypatch.setattr(boxes, "CHUNK", chunk)
    faces, emits = crowded(np.random.default_rng(seed))
    found, expected = find_contacts(faces, emits).faces, pairwise(faces, emits)
    assert list(found) == list(expected) and len(found) > 5
    for f, one in found.items():
        other = expected[f]
        # rounding: heights of several vertices at once may be summed in another order
        np.testing.assert_allclose(one.segments, other.segments, rtol=0, atol=1e-12)
        for mine, twin in ((one.covers, other.covers), (one.hides, other.hides)):
            assert [g for g, _ in mine] == [g for g, _ in twin]
            assert all(np.array_equal(p, q) for (_, p), (_, q) in zip(mine, twin, strict=True))


def test_few_pairs_of_a_fine_mesh_are_looked_at_one_by_one(monkeypatch):
    calls = []
    plain = module._contact
    monkeypatch.setattr(module, "_contact", lambda *a: calls.append(len(a[1])) or plain(*a))
    assert find_contacts(faces_of(divided(ROOM, 12)), np.zeros(864, bool)).faces == {}
    wedge = np.array(
        [SQUARE, SQUARE[[1, 0, 3, 2]] * [1, 0.8, 0] + SQUARE[[1, 0, 3, 2]][:, [2, 2, 1]]]
    )
    assert find_contacts(faces_of(divided(wedge, 12)), np.zeros(288, bool)).faces == {}
    assert sum(calls) == 0
    assert find_contacts(faces_of(np.empty((0, 4, 3))), np.zeros(0, bool)).faces == {}


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


def test_a_shining_block_covers_the_floor():
    """Unlike a lamp that stands alone, a body has an inside that its back looks at."""
    area = covered_area(np.concatenate([ROOM, block(LOW, HIGH)]), emits=range(6, 12))
    assert area[[0, 6]] == pytest.approx([0.16, 0.16], rel=1e-12)  # rounding


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
