"""Form factors of meshes: no leak, closed rows, honest errors, any number of threads."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, l_room, rotation

import radiosity
from radiosity.analytic import load_cases
from radiosity.mesh.bodies import find_bodies
from radiosity.mesh.faces import Faces

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
    if name == "block":  # the room of the fewest faces
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
