"""Form factors of meshes: no leak, closed rows, honest errors, any input, any number of threads."""

import tracemalloc
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, l_room, rotation

import radiosity
from radiosity.analytic import load_cases
from radiosity.mesh.bodies import find_bodies
from radiosity.mesh.faces import Faces
from radiosity.solve import matrix
from radiosity.solve.plan import Refused, check_factors

MESHES = Path(__file__).resolve().parent.parent / "benchmarks" / "meshes"


def mesh_of(polygons):
    """Return (vertices, faces) of polygons (n, 4, 3), no vertex shared."""
    corners = np.asarray(polygons, float).reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 4)


def cells(polygons, n):
    """Return every quadrilateral divided into n x n."""
    s, t = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    found = []
    for a, b, c, d in np.asarray(polygons, float):
        s_, t_ = s[..., None], t[..., None]
        x = (1 - s_) * (1 - t_) * a + s_ * (1 - t_) * b + s_ * t_ * c + (1 - s_) * t_ * d
        quads = np.stack([x[:-1, :-1], x[1:, :-1], x[1:, 1:], x[:-1, 1:]], axis=2)
        found.append(quads.reshape(-1, 4, 3))
    return np.concatenate(found)


@cache
def furnished(name="room_324"):
    """Return the closed Cornell room with two blocks (n, 4, 3), in units of its height."""
    vertices, faces = [], []
    for line in (MESHES / f"{name}.obj").read_text().splitlines():
        kind, *rest = line.split() or [""]
        if kind == "v":
            vertices.append([float(x) for x in rest])
        elif kind == "f":
            faces.append([int(x) - 1 for x in rest])
    return np.array(vertices)[np.array(faces)] / 548.8


def with_block():
    standing = block((0.3, 0.2, 0), (0.7, 0.6, 0.5))
    return np.concatenate([cells(box((0, 0, 0), (1, 1, 1)), 3), standing])


ROOMS = {"furnished": furnished, "block": with_block, "l_room": l_room}


# ------------------------------------------------------------------------------- leaks


@pytest.mark.parametrize("name", ROOMS)
@pytest.mark.parametrize("gap", [0.1, 1e-4])
def test_a_shell_around_a_closed_room_receives_exactly_nothing(name, gap):
    room = ROOMS[name]()
    low, high = room.min(axis=(0, 1)), room.max(axis=(0, 1))
    shell = cells(box(low - gap, high + gap), 2)
    rng = np.random.default_rng(3)
    places = [(1.0, 0.0, 0.1), (1e-3, 0.0, 0.01), (1e3, 0.0, 0.1), (1.0, 1e6, 0.1)]
    if name != "furnished":
        places.append((1.0, 0.0, 1e-4))
    for scale, offset, accuracy in places:
        turn = rotation(rng) if scale != 1.0 else np.eye(3)
        polygons = np.concatenate([room, shell]) @ turn.T * scale + offset
        raw = radiosity.form_factors(mesh_of(polygons), accuracy, repair=False)
        assert np.all(raw.exchange[: len(room), len(room) :] == 0), (scale, offset)
        assert np.all(raw.exchange[len(room) :, : len(room)] == 0)


@pytest.mark.parametrize("name", ROOMS)
@pytest.mark.parametrize("gap", [0.1, 1e-4])
def test_nor_does_it_after_the_repair(name, gap):
    room = ROOMS[name]()
    low, high = room.min(axis=(0, 1)), room.max(axis=(0, 1))
    rng = np.random.default_rng(5)
    for turn in (np.eye(3), rotation(rng)):
        polygons = np.concatenate([room, box(low - gap, high + gap)]) @ turn.T
        closed = radiosity.form_factors(mesh_of(polygons), 0.1)
        assert np.all(closed.exchange[: len(room), len(room) :] == 0)
        inside = np.flatnonzero(closed.exposed[: len(room)])
        assert closed.row_sums()[inside] == pytest.approx(1.0, abs=1e-12)  # rounding


# ------------------------------------------------------------------------------- closure


@pytest.mark.parametrize("name", ROOMS)
def test_rows_of_closed_rooms(name):
    factors = radiosity.form_factors(mesh_of(ROOMS[name]()), 1e-3)
    assert factors.is_closed
    assert np.abs(factors.raw_closure).max() < 1e-3  # as asked
    exposed = factors.exposed
    assert factors.row_sums()[exposed] == pytest.approx(1.0, abs=1e-12)  # rounding
    f, area = factors.toarray(), factors.area
    flow = area[:, None] * f
    assert np.abs(flow - flow.T).max() <= 1e-14 * flow.max()
    assert f.min() == 0.0
    # the bottom on which the block stands
    assert len(factors.sealed) == (1 if name == "block" else 0)


def test_a_block_half_through_the_floor():
    """Patches that are half inside of it are cut; what is inside sees the block's backs."""
    sunk = block((0.3, 0.2, -0.5), (0.7, 0.6, 0.5))
    room = np.concatenate([cells(box((0, 0, 0), (1, 1, 1)), 3), sunk])
    factors = radiosity.form_factors(mesh_of(room), 1e-3)
    total = factors.row_sums() + factors.openness.share
    assert total[factors.exposed] == pytest.approx(1.0, abs=1e-12)  # rounding
    ceiling = slice(9, 18)
    assert np.abs(factors.raw_closure[ceiling]).max() < 1e-3  # as asked


@pytest.mark.slow
def test_rows_of_the_finer_room():
    factors = radiosity.form_factors(mesh_of(furnished("room_1296")), 1e-3)
    assert np.abs(factors.raw_closure).max() < 1e-3  # as asked
    assert factors.row_sums() == pytest.approx(1.0, abs=1e-12)  # rounding


# ------------------------------------------------------------------------------- errors


@cache
def truth():
    return radiosity.form_factors(mesh_of(furnished()), 1e-4, repair=False)


@pytest.mark.parametrize("accuracy", [0.3, 0.1, 0.03, 0.01])
def test_row_errors_are_what_was_asked_and_what_is_estimated(accuracy):
    factors = radiosity.form_factors(mesh_of(furnished()), accuracy, repair=False)
    error = np.abs(factors.exchange - truth().exchange).sum(axis=1) / factors.area
    assert error.max() <= accuracy
    # two estimates: the reference errs as well
    covered = error <= factors.row_errors() + truth().row_errors()
    assert covered.mean() >= 0.95
    assert error.max() < 0.2 * accuracy + 1e-4  # far below: shadows fill a part of each row only


def test_surfaces_agree_with_monte_carlo():
    """18 surfaces of the room against 2^20 rays each, good to about 5e-5."""
    table = np.loadtxt(MESHES / "room_surface_factors.csv", delimiter=",")
    text = (MESHES / "room_324.obj").read_text().splitlines()
    group, labels = -1, []
    for line in text:
        group += line.startswith("g ")
        if line.startswith("f "):
            labels.append(group)
    factors = radiosity.form_factors(mesh_of(furnished()), 0.01).grouped(np.array(labels))
    assert np.sqrt(np.mean((factors.toarray() - table) ** 2)) < 5e-5  # the table's own error
    assert factors.row_sums() == pytest.approx(1.0, abs=1e-12)  # rounding


@pytest.mark.parametrize("case", load_cases("vf_obstructed"), ids=lambda c: c["id"])
@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_obstructed_cases(case, accuracy):
    g = case["geometry"]
    if "A1" not in g:
        pytest.skip("whole matrices are below")
    factors = radiosity.form_factors(
        mesh_of([g["A1"], g["A2"]]), accuracy, obstructions=mesh_of(g["blockers"]), repair=False
    )
    assert factors.toarray()[0, 1] == pytest.approx(case["value"], abs=accuracy)
    assert abs(factors.toarray()[0, 1] - case["value"]) <= factors.row_errors()[0] + 1e-9


CASES = {c["id"]: c for c in load_cases("vf_obstructed")}


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_the_matrix_of_the_l_room(accuracy):
    """View3D's L-room (Pinney & Bean) with concave floor and ceiling, 8 x 8 factors."""
    case = CASES["L_room_F"]
    corners = [np.array(f, float) for f in case["geometry"]["faces"].values()]
    starts = np.cumsum([0] + [len(f) for f in corners])
    faces = [list(range(a, b)) for a, b in zip(starts[:-1], starts[1:], strict=True)]
    for repair in (True, False):
        found = radiosity.form_factors((np.concatenate(corners), faces), accuracy, repair=repair)
        assert np.abs(found.toarray() - case["value"]).sum(axis=1).max() < accuracy
        assert found.area == pytest.approx(case["geometry"]["area"])


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5])
def test_the_matrix_of_a_cube_in_a_cube(accuracy):
    case = CASES["cube_in_cube_matrix_a0.333"]
    a, value = case["geometry"]["a"], case["value"]
    room = np.concatenate([box((0, 0, 0), (1, 1, 1)), block([(1 - a) / 2] * 3, [(1 + a) / 2] * 3)])
    f = radiosity.form_factors(mesh_of(room), accuracy).toarray()
    opposite, same = np.arange(6) ^ 1, np.arange(6)
    beside = np.array([[k // 2 != m // 2 for m in range(6)] for k in range(6)])
    for found, name in [
        (f[:6, 6:].sum(axis=1), "outer_to_inner_total"),
        (f[same, opposite], "outer_to_opposite_outer"),
        (f[:6, :6][beside], "outer_to_each_adjacent_outer"),
        (f[6 + same, same], "inner_face_to_facing_outer"),
        (f[6:, :6][beside], "inner_face_to_each_side_outer"),
        (f[same, 6 + same], "outer_face_to_facing_inner_face"),
        (f[:6, 6:][beside], "outer_face_to_each_other_inner_side_face"),
        (f[same, 6 + opposite], "outer_face_to_opposite_far_inner_face"),
    ]:
        assert found == pytest.approx(value[name], abs=accuracy), name


@pytest.mark.parametrize("gap", [0.1, 0.01])
def test_a_screen_near_a_corner(gap):
    """A tighter accuracy is kept too: against cells of the same mesh, each with fewer kinks."""
    wall = np.array([[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]], float)
    screen = np.array([[0.9, 0.1, 0], [1, 0.1, 0.1], [1, 0.9, 0.1], [0.9, 0.9, 0]])
    screen = mesh_of([screen + [-gap, 0, gap]])
    parts = np.concatenate([cells([SQUARE], 8), cells([wall], 8)])
    fine = radiosity.form_factors(mesh_of(parts), 1e-5, obstructions=screen, repair=False)
    exact = fine.exchange[:64, 64:].sum()
    for accuracy in (1e-2, 1e-3, 1e-4, 1e-5):
        found = radiosity.form_factors(
            mesh_of([SQUARE, wall]), accuracy, obstructions=screen, repair=False
        )
        assert found.toarray()[0, 1] == pytest.approx(exact, abs=accuracy + 1e-5)


# ------------------------------------------------------------------------------- hard cases


def test_a_closed_room_with_obstructions_stays_closed_after_the_repair():
    room = box((0, 0, 0), (1, 1, 1))
    inner = mesh_of(block((0.4, 0.4, 0.4), (0.6, 0.6, 0.6)))
    for repair in (False, True):
        found = radiosity.form_factors(mesh_of(room), 0.01, obstructions=inner, repair=repair)
        assert np.all(found.environment == 0) and found.is_closed
        assert found.openness.absorbed.min() > 0


def strip(path, half, height):
    """Return a solid strip about a polyline of right angles (8, 4, 3) a segment, ends last."""
    path = np.array(path, float)
    along = np.diff(path, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    left = np.stack([-along[:, 1], along[:, 0]], axis=1)
    before, after = np.vstack([left[:1], left]), np.vstack([left, left[-1:]])
    mitre = np.where(np.all(before == after, axis=1)[:, None], before, before + after) * half
    a, b = (np.insert(path + mitre, 2, 0, axis=1), np.insert(path - mitre, 2, 0, axis=1))
    up, faces = np.array([0, 0, height]), []
    for k in range(len(along)):
        faces += [[b[k], b[k + 1], b[k + 1] + up, b[k] + up],
                  [a[k + 1], a[k], a[k] + up, a[k + 1] + up],
                  [a[k], a[k + 1], b[k + 1], b[k]],
                  [b[k] + up, b[k + 1] + up, a[k + 1] + up, a[k] + up]]  # fmt: skip
    faces += [[a[0], b[0], b[0] + up, a[0] + up], [b[-1], a[-1], a[-1] + up, b[-1] + up]]
    return np.array(faces)


def test_a_body_that_crosses_itself_seals_its_inside():
    """Its walls where it passes through itself see nothing, though it is closed and wound alike."""
    knot = strip([(0, 0), (0.9, 0), (1.1, 0), (3, 0), (3, 2), (1, 2), (1, 0.1), (1, -0.1), (1, -1)],
                 0.2, 0.5)  # fmt: skip
    assert find_bodies(Faces.from_polygons(knot, 0, 0, merge=False)).count == 1
    room = box((-2, -3, -2), (5, 4, 3))
    raw = radiosity.form_factors(mesh_of(np.concatenate([room, knot])), 1e-3, repair=False)
    inside = 6 + np.array([4, 5, 24, 25])  # side walls of the second segment and the seventh
    assert np.all(raw.exchange[inside] == 0)
    assert np.abs(raw.closure[6:]).max() < 1e-3  # also of walls that meet where no corners are


@pytest.mark.parametrize("warp", [3e-6, 5e-6, 1e-5])
def test_a_warped_bystander_does_not_hide_what_is_certain(warp):
    """Its unevenness is its own and blurs no slit elsewhere."""
    slit = [[[-1, -1, 0.5], [0.4999, -1, 0.5], [0.4999, 2, 0.5], [-1, 2, 0.5]],
            [[0.5001, -1, 0.5], [2, -1, 0.5], [2, 2, 0.5], [0.5001, 2, 0.5]]]  # fmt: skip
    warped = np.array([[3, 3, 0], [11, 3, 0], [11, 11, warp], [3, 11, 0]])
    pair = [SQUARE, SQUARE[::-1] + [0, 0, 1]]
    exact = radiosity.form_factors(
        mesh_of(pair), 1e-6, obstructions=mesh_of(slit), repair=False
    ).toarray()[0, 1]
    found = radiosity.form_factors(
        mesh_of([*pair, warped]), 1e-6, obstructions=mesh_of(slit), repair=False
    )
    assert found.toarray()[0, 1] == pytest.approx(exact, rel=1e-9) and exact > 5e-5


def test_no_area_and_no_faces_are_refused_in_words():
    vertices = np.zeros((3, 3))
    with pytest.raises(ValueError, match="none of the 1 faces"):
        radiosity.form_factors((vertices, [[0, 1, 2]]))
    with pytest.raises(TypeError, match="mesh is a NoneType"):
        radiosity.form_factors(None)
    with pytest.raises(ValueError, match="faces must be an array"):
        radiosity.form_factors((vertices, [0, 1, 2]))


# ------------------------------------------------------------------------------- threads


@pytest.mark.parametrize("repair", [True, False])
def test_threads_and_runs_change_no_bit(repair, monkeypatch):
    found = []
    for threads in ("1", "2", "2"):
        monkeypatch.setenv("RADIOSITY_THREADS", threads)
        found.append(radiosity.form_factors(mesh_of(furnished()), 0.1, repair=repair))
    for other in found[1:]:
        assert np.array_equal(found[0].exchange, other.exchange)
        assert np.array_equal(found[0].error, other.error)
        assert np.array_equal(found[0].environment, other.environment)


# ------------------------------------------------------------------------------- input

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


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3, 1e-5])
def test_no_shadow_falls_between_the_points_of_both_rules(accuracy):
    """A tilted sheet whose shadow enters a quarter of the wall between its corners."""
    floor = np.array([[0.5, 0, 0], [1, 0, 0], [1, 0.5, 0], [0.5, 0.5, 0]])
    wall = np.array([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], float)
    sheet = [[[0.2, 0.2, 0.3], [0.8, 0.2, 0.3], [0.8, 0.8, 0.7], [0.2, 0.8, 0.7]]]
    factor = [
        radiosity.form_factors(
            mesh_of([floor, *parts]), accuracy, obstructions=mesh_of(sheet), repair=False
        ).toarray()[0, 1:].sum()
        for parts in ([wall], cells([wall], 4))
    ]  # fmt: skip
    assert factor[0] == pytest.approx(factor[1], abs=2 * accuracy)
    assert factor[0] == pytest.approx(0.0794007, abs=accuracy)  # 2 million rays: 0.0795 +- 1e-4


def test_a_face_given_twice_is_seen_once():
    room = np.concatenate([box((0, 0, 0), (1, 2, 3)), box((0, 0, 0), (1, 2, 3))[:1]])
    found = radiosity.form_factors(mesh_of(room), 1e-3, repair=False)
    assert found.sealed.tolist() == [6]
    assert np.all(found.openness.share == 0)
    assert found.row_sums()[:6] == pytest.approx(1.0, abs=1e-9)


def test_a_mesh_that_is_covered_all_over_is_refused():
    room = box((0, 0, 0), (1, 1, 1))
    with pytest.raises(ValueError, match=r"all 6 rows are covered by faces .* turn round"):
        radiosity.form_factors(mesh_of(room), 1e-3, obstructions=mesh_of(room[:, ::-1]))


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


def test_more_memory_than_allowed_is_refused_before_the_work():
    with pytest.raises(Refused, match=r"324 faces need about .* more than the 1.0 MB allowed"):
        radiosity.form_factors(mesh_of(furnished()), 1e-3, memory=1e6)
    sheets = mesh_of(np.repeat([SQUARE], 2000, axis=0) + np.arange(2000)[:, None, None])
    with pytest.raises(Refused, match=r"2 faces, 2002 in all, need about 5.0 MB"):
        radiosity.form_factors(mesh_of(OPPOSITE), 1e-3, obstructions=sheets, memory=4e6)


@pytest.mark.parametrize("case", ["rays", "contacts"])
def test_no_more_memory_is_used_than_predicted(case, monkeypatch):
    """Rows by numpy's own count; the pieces that contacts cut them into are predicted again."""
    room = cells(box((0, 0, 0), (1, 1, 1)), 16)
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
