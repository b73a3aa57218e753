"""Form factors of whatever users hold: any mesh, obstructions, files, wrong input, memory."""

import tracemalloc

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, rotation
from test_matrix import MESHES, cells, furnished, mesh_of

import radiosity
from radiosity.solve import matrix
from radiosity.solve.plan import Refused, check_factors

OPPOSITE = np.stack([SQUARE, SQUARE[::-1] + [0, 0, 1.0]])
F12 = 0.19982489569838738  # Howell C-11


def test_the_environment_is_what_opposite_squares_do_not_see():
    factors = radiosity.form_factors(mesh_of(OPPOSITE), 1e-3)
    assert factors.toarray()[0, 1] == pytest.approx(F12, rel=1e-9)  # its error is known as nil
    assert factors.environment == pytest.approx(1 - F12, abs=1e-12)  # so this takes the defect
    measured = radiosity.form_factors(mesh_of(OPPOSITE), 1e-3, repair=False)
    wrong = np.abs(measured.environment - (1 - F12))
    assert np.all(wrong < 3 * measured.openness.error)
    assert not measured.is_closed


def test_meshes_of_any_kind_give_the_same_rows():
    import pyvista
    import trimesh

    room = trimesh.creation.box()
    room.invert()
    expected = radiosity.form_factors(room, 1e-6).toarray()
    poly = pyvista.PolyData(room.vertices, np.insert(room.faces, 0, 3, axis=1))
    for mesh in (poly, (room.vertices, room.faces), (room.vertices.tolist(), room.faces.tolist())):
        assert np.array_equal(radiosity.form_factors(mesh, 1e-6).toarray(), expected)
    assert expected.sum(axis=1) == pytest.approx(1.0, abs=1e-12)


def test_two_sided_rows_and_obstructions():
    sheet = 0.5 * SQUARE + [0.25, 0.25, 0.75]
    factors = radiosity.form_factors(
        mesh_of(OPPOSITE), 1e-4, obstructions=mesh_of([sheet]), two_sided=True
    )
    f = factors.toarray()
    assert f.shape == (4, 4)
    assert f[0, 1] == pytest.approx(0.11562060213241498, abs=1e-4)  # Walton & Shapiro
    assert np.all(f[2:] == 0)
    assert factors.environment[2:] == pytest.approx(1.0)
    assert np.all(factors.openness.absorbed[:2] > 0.05)  # the sheet


def test_the_mesh_itself_may_be_given_as_what_blocks():
    """As other tools want it: of faces that coincide the row is the one that is seen."""
    room = mesh_of(furnished())
    alone = radiosity.form_factors(room, 0.1, repair=False)
    found = radiosity.form_factors(room, 0.1, obstructions=room, repair=False)
    assert np.all(found.openness.share == 0)
    apart = np.abs(found.toarray() - alone.toarray()).sum(axis=1)
    assert np.all(apart <= found.row_errors() + alone.row_errors() + 1e-12)
    assert np.abs(radiosity.form_factors(room, 0.1, obstructions=room).closure).max() < 1e-12


def test_a_sheet_on_the_floor_is_no_part_of_the_floor():
    """Whoever looks down meets its back; the floor under it is covered."""
    room, sheet = box((0, 0, 0), (1, 1, 1)), 0.5 * SQUARE[None, ::-1] + [0.25, 0.25, 0]
    found = radiosity.form_factors(mesh_of(room), 1e-3, obstructions=mesh_of(sheet), repair=False)
    assert found.area[0] == pytest.approx(0.75)
    assert np.all(found.openness.absorbed[1:] > 0.03)
    assert np.all(np.abs(found.closure) < 4 * found.openness.error + 1e-9)
    up = mesh_of(np.concatenate([room[1:2], sheet[:, ::-1]]))
    seen = radiosity.form_factors(up, 1e-9).toarray()[0, 1]  # of the sheet by the ceiling
    assert found.openness.error[1] < 1e-3
    assert abs(found.openness.absorbed[1] - seen) < 2 * found.openness.error[1]


def test_a_face_given_twice_is_seen_once():
    room = np.concatenate([box((0, 0, 0), (1, 2, 3)), box((0, 0, 0), (1, 2, 3))[:1]])
    found = radiosity.form_factors(mesh_of(room), 1e-3, repair=False)
    assert found.sealed.tolist() == [6]
    assert np.all(found.openness.share == 0)
    assert found.row_sums()[:6] == pytest.approx(1.0, abs=1e-9)


def test_a_mesh_that_is_covered_all_over_is_refused():
    places = np.array([[0.0, 0, 0], [2, 0, 0]])
    ground = mesh_of(SQUARE + places[:, None])
    blocks = np.concatenate([block(low, low + [1, 1, 0.5]) for low in places])
    with pytest.raises(ValueError, match=r"all 2 rows are covered by faces .* turn round"):
        radiosity.form_factors(ground, 1e-3, obstructions=mesh_of(blocks))


def test_a_room_in_a_shell_on_its_walls_sees_what_it_sees_without():
    room = box((0, 0, 0), (1, 1, 1))
    found = radiosity.form_factors(mesh_of(room), 1e-3, obstructions=mesh_of(room[:, ::-1]))
    alone = radiosity.form_factors(mesh_of(room), 1e-3)
    assert found.toarray() == pytest.approx(alone.toarray(), abs=1e-6)


def test_concave_rows_and_rows_without_area():
    corners = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0],
                        [0, 1, 1], [1, 1, 1], [1, 0, 1], [0, 0, 1]], float)  # fmt: skip
    faces = [[0, 1, 2, 3, 4, 5], [0, 1, 1], [6, 7, 8, 9]]
    factors = radiosity.form_factors((corners, faces), 1e-4)
    # verification/vf_polygon_pairs.json, concave_L_to_square
    assert factors.toarray()[0, 2] == pytest.approx(0.12397529133434736, rel=1e-9)
    assert factors.area == pytest.approx([3.0, 0.0, 1.0])
    assert factors.sealed.tolist() == [1]


def test_files_are_read():
    factors = radiosity.form_factors(MESHES / "room_324.obj", 0.3)
    assert factors.shape == (324, 324)
    with pytest.raises(ValueError, match="does not exist"):
        radiosity.form_factors(MESHES / "room_325.obj")


def test_wrong_input_is_named():
    bad = SQUARE.copy()
    bad[2, 1] = np.nan
    for mesh, message in [
        (mesh_of([bad]), r"vertex 2 = .*nan.* must be finite"),
        ((SQUARE, [[0, 1, 2, 7]]), "face 0 = .* names a vertex that does not exist: there are 4"),
        ((SQUARE, np.array([[0.0, 1, 2]])), "must hold whole numbers"),
        ((SQUARE, []), "has no faces"),
    ]:
        with pytest.raises(ValueError, match=message):
            radiosity.form_factors(mesh)
    with pytest.raises(TypeError, match="must be a trimesh.Trimesh"):
        radiosity.form_factors(3.0)
    with pytest.raises(ValueError, match=r"accuracy = 2 must lie in"):
        radiosity.form_factors(mesh_of(OPPOSITE), 2.0)
    with pytest.raises(ValueError, match=r"accuracy = 'fine' must be a number"):
        radiosity.form_factors(mesh_of(OPPOSITE), "fine")
    for memory in ("4GB", -1):
        with pytest.raises(ValueError, match=f"memory = {memory!r} must be a number of bytes"):
            radiosity.form_factors(mesh_of(OPPOSITE), memory=memory)
    with pytest.raises(ValueError, match=r"seed = -1 must be a whole number from 0"):
        radiosity.form_factors(mesh_of(OPPOSITE), seed=-1)


def test_more_memory_than_allowed_is_refused_before_the_work():
    with pytest.raises(Refused, match=r"324 faces need about .* more than the 1.0 MB allowed"):
        radiosity.form_factors(mesh_of(furnished()), 1e-3, memory=1e6)
    sheets = mesh_of(np.repeat([SQUARE], 2000, axis=0) + np.arange(2000)[:, None, None])
    with pytest.raises(Refused, match=r"2 faces, 2002 in all, need about 5.0 MB"):
        radiosity.form_factors(mesh_of(OPPOSITE), 1e-3, obstructions=sheets, memory=4e6)


@pytest.mark.parametrize("case", ["rays", "contacts"])
def test_no_more_memory_is_used_than_predicted(case, monkeypatch):
    """Rows by numpy's own count; the pieces that contacts cut them into are predicted again."""
    room = cells(box((0, 0, 0), (1, 1, 1)), 16 if case == "rays" else 12)
    rng = np.random.default_rng(0)
    leaves = [0.06 * SQUARE @ rotation(rng).T + rng.uniform(0.2, 0.8, 3) for _ in range(300)]
    blocks = [0.05 * block((0, 0, 0), (1, 1, 1)) + [x, y, 0] for x in np.arange(0.06, 0.9, 0.1)
              for y in np.arange(0.06, 0.9, 0.1)]  # fmt: skip
    blocking = mesh_of(leaves if case == "rays" else np.concatenate(blocks))
    predicted = []
    monkeypatch.setattr(matrix, "check_factors",
                        lambda *a: predicted.append(check_factors(*a)))  # fmt: skip
    radiosity.form_factors(mesh_of(room[:24]), 0.3, obstructions=blocking)  # compiles
    tracemalloc.start()
    try:
        radiosity.form_factors(mesh_of(room), 0.1, obstructions=blocking)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert 0.3 * predicted[-1] < peak < predicted[-1]


def test_no_area_and_no_faces_are_refused_in_words():
    vertices = np.zeros((3, 3))
    with pytest.raises(ValueError, match="none of the 1 faces"):
        radiosity.form_factors((vertices, [[0, 1, 2]]))
    with pytest.raises(TypeError, match="mesh is a NoneType"):
        radiosity.form_factors(None)
    with pytest.raises(ValueError, match="faces must be an array"):
        radiosity.form_factors((vertices, [0, 1, 2]))
