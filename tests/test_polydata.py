"""The mesh for pyvista: one cell a patch side, wound and coloured as the solution has it."""

import numpy as np
import pytest

pytest.importorskip("pyvista")

from scenes_for_tests import block, box, scene

from radiosity.solve.solve import solve
from radiosity.view.polydata import corner_radiosity, shown_patches, to_pyvista

LIT = 1  # the ceiling
STOOD_ON = 6  # the underside of the block


@pytest.fixture(scope="module")
def solution():
    """A closed room whose ceiling shines, with a solid block on its floor."""
    faces = np.concatenate([box((0, 0, 0), (4, 4, 3)), block((1, 1, 0), (2, 2, 1))])
    exitance = np.zeros((len(faces), 3))
    exitance[LIT] = [3.0, 2.0, 1.0]
    return solve(scene(faces, 0.5, exitance, unit="cm", unit_m=0.01), accuracy=0.1)


@pytest.fixture(scope="module")
def mesh(solution):
    return to_pyvista(solution)


def corners(mesh):
    return [mesh.points[mesh.get_cell(k).point_ids] for k in range(mesh.n_cells)]


def test_a_cell_for_every_patch_side_but_those_in_contact(solution, mesh):
    assert solution.patches.covered.any()
    assert mesh.n_cells == len(solution.patches) - solution.patches.covered.sum()
    shown = shown_patches(solution)
    assert mesh.cell_data["patch"].tolist() == shown.tolist()
    assert STOOD_ON not in mesh.cell_data["face"]
    assert np.all(mesh.cell_data["face"] == solution.patches.face[shown])


def test_cells_wind_counter_clockwise_seen_from_the_active_side(solution, mesh):
    normals = np.asarray(mesh.compute_normals(
        point_normals=False, consistent_normals=False, auto_orient_normals=False,
        flip_normals=False, split_vertices=False).cell_data["Normals"])  # fmt: skip
    assert normals == pytest.approx(solution.patches.normal[shown_patches(solution)], abs=1e-6)


def test_areas_are_those_of_the_room_in_scene_units(mesh):
    sizes = mesh.compute_cell_sizes(length=False, volume=False).cell_data["Area"]
    room_and_block = 2 * 16 + 4 * 12 - 1 + 5  # the block covers 1 of the floor and stands on it
    assert np.sum(sizes) == pytest.approx(room_and_block, rel=1e-9)


def test_cell_data_is_the_solution_of_each_patch(solution, mesh):
    shown = shown_patches(solution)
    for name, expected in {
        "radiosity_W_m2": solution.radiosity,
        "irradiance_W_m2": solution.irradiance_on,
        "illuminance_lx": solution.illuminance,
        "reflectance": solution.reflectance,
    }.items():
        assert np.array_equal(mesh.cell_data[name], expected[shown]), name
    lit = mesh.cell_data["face"] == LIT
    assert np.all(mesh.cell_data["radiosity_W_m2"][lit][:, 0] > 3.0)
    weighted = mesh.cell_data["irradiance_W_m2"] @ [0.2126, 0.7152, 0.0722]
    assert mesh.cell_data["illuminance_lx"] == pytest.approx(683 * weighted, rel=1e-12)


def test_points_carry_the_smooth_field_of_their_own_cell(solution, mesh):
    smooth = corner_radiosity(solution)[shown_patches(solution)]
    vertices = solution.patches.vertices[shown_patches(solution)]
    assert mesh.n_points == sum(len(c) for c in corners(mesh))
    for k in range(0, mesh.n_cells, 7):
        ids = mesh.get_cell(k).point_ids
        assert np.array_equal(mesh.points[ids], vertices[k][: len(ids)])
        assert np.array_equal(mesh.point_data["radiosity_W_m2"][ids], smooth[k][: len(ids)])


def test_the_field_is_continuous_on_a_face_and_jumps_at_creases(mesh):
    values = mesh.point_data["radiosity_W_m2"][:, 0]
    face = np.repeat(mesh.cell_data["face"], [len(c) for c in corners(mesh)])
    at = {}
    for f, x, v in zip(face, np.round(mesh.points, 6).tolist(), values, strict=True):
        at.setdefault(tuple(x), {}).setdefault(f, []).append(v)
    assert max(np.ptp(v) for faces in at.values() for v in faces.values()) < 1e-12
    several = [[v[0] for v in faces.values()] for faces in at.values() if len(faces) > 1]
    assert max(np.ptp(v) for v in several) > 1.0  # W/m2, where ceiling and walls meet


def test_triangles_stay_triangles_and_backs_are_cells_of_their_own():
    sheet = np.array([[[1, 1, 1], [2, 1, 1], [1, 2, 1], [1, 2, 1]]], float)
    faces = np.concatenate([box((0, 0, 0), (3, 3, 3)), sheet])
    exitance = np.zeros(7)
    exitance[LIT] = 1.0
    solution = solve(scene(faces, 0.5, exitance), accuracy=0.1)
    mesh = to_pyvista(solution)
    mine = np.flatnonzero(mesh.cell_data["face"] == 6)
    assert {mesh.get_cell(k).n_points for k in mine} == {3}
    side = mesh.cell_data["side"][mine]
    assert sorted(set(side)) == [0, 1] and np.sum(side == 0) == np.sum(side == 1)
    lit = mesh.cell_data["illuminance_lx"][mine]
    assert lit[side == 0].min() > 2 * lit[side == 1].max()  # the front faces the ceiling
    assert np.all(mesh.cell_data["side"][mesh.cell_data["face"] < 6] == 0)


def test_names_and_unit_say_what_the_numbers_mean(mesh):
    assert list(mesh.field_data["unit"]) == ["cm"]
    assert mesh.field_data["unit_m"][0] == 0.01
    names = list(mesh.field_data["material_names"])
    assert names[mesh.cell_data["material"][mesh.cell_data["face"] == LIT][0]] == "m1"
    assert list(mesh.field_data["side_names"]) == ["front", "back"]
    assert list(mesh.field_data["group_names"]) == ["all"]
