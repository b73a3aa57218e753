"""The survey: what light reaches, and how much of the outside a side sees."""

from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, faces_of, meshed, rotation

from radiosity.mesh.division import divisions
from radiosity.scene.files import load
from radiosity.solve.reach import find_reach
from radiosity.transport import survey as survey_module
from radiosity.transport.survey import sides_that_see_out, survey

ROOM = box((0, 0, 0), (1, 1, 1))


def surveyed(polygons, n, lamps):
    """Survey of faces of which those in ``lamps`` shine from their fronts."""
    faces = faces_of(polygons)
    emits = np.isin(np.arange(len(faces)), lamps)
    visibility, table, patches = meshed(faces, n, emits)
    sources = np.zeros((patches.fronts, 2), bool)
    sources[:, 0] = emits[patches.face]
    return survey(visibility, table, patches, sources), patches, (visibility, table)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_a_closed_room_is_closed_and_dark_outside(size):
    turned = size * (ROOM @ rotation(np.random.default_rng(0)).T + 3)
    found, _, _ = surveyed(turned, 4, [1])
    assert found[:, 0].all() and not found[:, 1].any()


def test_a_room_that_emits_nothing_is_dark():
    found, _, _ = surveyed(ROOM, 2, [])
    assert not found.any()


def test_an_open_scene_lights_its_outside_only_where_light_gets():
    """Light of a box without lid escapes upwards, and meets no wall from outside."""
    found, _, _ = surveyed(ROOM[[0, 2, 3, 4, 5]], 3, [0])
    assert found[:, 0].all() and not found[:, 1].any()


@pytest.mark.parametrize("n", [1, 2, 5])
def test_a_sealed_cavity_stays_dark(n):
    """A block without bottom: its inside and the floor under it meet no light."""
    low, high = (0.3, 0.2, 0), (0.7, 0.6, 0.5)
    found, patches, _ = surveyed(np.concatenate([ROOM, block(low, high, False)]), n, [1])
    middle = patches.centroid[:, :2]
    under = (patches.face == 0) & np.all((middle > low[:2]) & (middle < high[:2]), axis=1)
    assert under.sum() > 0
    assert not found[under].any()
    assert found[~under, 0].all() and not found[:, 1].any()


def test_a_covered_floor_stays_dark():
    polygons = np.concatenate([ROOM, block((0.3, 0.2, 0), (0.7, 0.6, 0.5))])
    found, patches, _ = surveyed(polygons, 3, [1])
    assert patches.covered.any() and not found[patches.covered].any()
    assert found[~patches.covered, 0].all() and not found[:, 1].any()


def test_a_shell_around_a_room_is_never_reached():
    shell = box((-0.01, -0.01, -0.01), (1.01, 1.01, 1.01))
    found, patches, _ = surveyed(np.concatenate([ROOM, shell]), 4, [1])
    assert not found[patches.face >= 6].any()


def test_a_sheet_in_a_room_is_lit_on_both_sides():
    sheet = 0.4 * SQUARE + [0.3, 0.3, 0.5]
    found, patches, _ = surveyed(np.concatenate([ROOM, sheet[None]]), 3, [1])
    mine = patches.face == 6
    assert found[mine].all() and not found[~mine, 1].any()


def test_light_follows_through_a_second_room():
    """Two rooms joined by a hole in the wall between them: the far one is lit by the walls."""
    one, two = box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1))
    upper = np.array([[1, 0, 0.8], [1, 0, 1], [1, 1, 1], [1, 1, 0.8]])
    lower = np.array([[1, 0, 0], [1, 0, 0.6], [1, 1, 0.6], [1, 1, 0]])
    rooms = np.concatenate([np.delete(one, 3, 0), np.delete(two, 2, 0), [upper, lower]])
    found, _, _ = surveyed(rooms, 4, [0])
    assert found[:, 0].all()
    shut = np.concatenate([rooms, np.array([[[1, 0, 0.6], [1, 0, 0.8], [1, 1, 0.8], [1, 1, 0.6]]])])
    found, patches, _ = surveyed(shut, 4, [0])
    assert not found[(patches.face >= 5) & (patches.face < 10)].any()


def test_rooms_that_nothing_blocks_in_are_followed_without_rays(monkeypatch):
    """The same as with rays, for boxes with and without a lid, inside and out, and a gap."""
    gap = np.array([SQUARE, SQUARE[::-1] + [0, 0, 1e-6]])
    for polygons, lamps in ((ROOM, [1]), (ROOM[1:], [0]), (ROOM[:, ::-1], [1]), (gap, [0])):
        free, _, (visibility, table) = surveyed(polygons, 2, lamps)
        assert not visibility.can_block
        traced = "first_hits", "blocked"
        with monkeypatch.context() as patch:
            for name in traced:
                patch.setattr(type(visibility), name, None)
            assert np.array_equal(surveyed(polygons, 2, lamps)[0], free)
        if polygons is not gap:
            monkeypatch.setattr(survey_module, "MOST_FREE", 0)
            assert np.array_equal(surveyed(polygons, 2, lamps)[0], free)
            monkeypatch.undo()
    assert free[:, 0].all() and not free[:, 1].any()


def test_what_sees_out():
    found, patches, (visibility, table) = surveyed(ROOM, 2, [])
    out = sides_that_see_out(visibility, table, patches)
    assert not out[:, 0].any() and out[:, 1].all()
    _, patches, (visibility, table) = surveyed(ROOM[[0, 2, 3, 4, 5]], 2, [])
    assert sides_that_see_out(visibility, table, patches).all()


def test_no_ray_slips_through_an_edge_into_a_block():
    """One of millions of rays met the inside of the short block; seeds and mesh that it did on."""
    room = load(Path(__file__).resolve().parent.parent / "scenes" / "cornell_box.toml")
    division = divisions(room.faces, np.sqrt(room.faces.areas().sum() / 3000))
    reach = find_reach(room, division, 0)
    assert reach.patches.front.all()
    x, y, z = reach.patches.centroid.T
    under = (y < 1e-6) & (np.abs(x - 186) < 40) & (np.abs(z - 168) < 40)
    assert under.any() and not reach.live[under].any()
