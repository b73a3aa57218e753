"""Files for other programs: they come back as the solution has them, whole or not at all."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import block, box, scene

from radiosity.light.bands import RGB
from radiosity.light.photometry import illuminance
from radiosity.solve.solve import solve
from radiosity.view import export
from radiosity.view.export import arrays, check_suffix, columns, save
from radiosity.view.polydata import shown_patches, to_pyvista


@pytest.fixture(scope="module")
def solution():
    """A room in centimetres, lit from above, with a block and a hanging sheet lit on both sides."""
    sheet = np.array([[[3, 3, 1], [3.5, 3, 1], [3, 3.5, 1], [3, 3.5, 1]]], float)
    faces = np.concatenate([box((0, 0, 0), (4, 4, 3)), block((1, 1, 0), (2, 2, 1)), sheet])
    exitance = np.zeros((len(faces), 3))
    exitance[1] = [3.0, 2.0, 1.0]
    return solve(scene(faces, 0.5, exitance, unit="cm", unit_m=0.01), accuracy=0.1)


@pytest.fixture(scope="module")
def table(solution, tmp_path_factory):
    path = tmp_path_factory.mktemp("csv") / "room.csv"
    save(solution, path)
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_csv_has_a_row_for_every_patch_side(solution, table):
    assert list(table[0]) == list(columns(RGB))
    assert [int(row["index"]) for row in table] == shown_patches(solution).tolist()
    sides = [row["side"] for row in table]
    assert sides.count("back") == len(solution.patches) - solution.patches.fronts > 0


def test_csv_keeps_every_digit(solution, table):
    shown = shown_patches(solution)
    for name, values in {
        "emission": solution.emission,
        "irradiance": solution.irradiance_on,
        "radiosity": solution.radiosity,
    }.items():
        read = [[float(row[f"{name}_{band}_W_m2"]) for band in "rgb"] for row in table]
        assert np.array_equal(read, values[shown]), name
    read = [[float(row[axis]) for axis in "xyz"] for row in table]
    assert np.array_equal(read, solution.patches.centroid[shown])
    read = [float(row["illuminance_lx"]) for row in table]
    assert np.array_equal(read, solution.illuminance[shown])


def test_csv_names_materials_and_turns_normals_with_the_side(solution, table):
    for row in table:
        assert row["material"] == f"m{row['face']}" and row["group"] == "all"
    sheet = [row for row in table if row["face"] == "12"]
    assert {(row["side"], float(row["nz"])) for row in sheet} == {("front", 1), ("back", -1)}
    assert not any(value == "-0.0" for row in table for value in row.values())


def test_areas_are_in_square_metres(table):
    room_and_block = 2 * 16 + 4 * 12 - 1 + 5
    sheet = 2 * 0.125  # both sides
    total = sum(float(row["area_m2"]) for row in table)
    assert total == pytest.approx(1e-4 * (room_and_block + sheet), rel=1e-9)


def test_emitted_power_is_that_of_the_scene(solution, table):
    power = sum(float(r["area_m2"]) * float(r["emission_r_W_m2"]) for r in table)
    assert power == pytest.approx(3.0 * 16e-4, rel=1e-12)
    assert power == pytest.approx(solution.balance.emitted[0], rel=1e-12)


def test_npz_comes_back_without_pickle(solution, tmp_path):
    path = tmp_path / "room.npz"
    save(solution, path)
    with np.load(path, allow_pickle=False) as read:
        expected = arrays(solution)
        assert set(read.files) == set(expected)
        for name, values in expected.items():
            assert read[name].dtype == values.dtype and np.array_equal(read[name], values), name
        b = read["emission"] + read["reflectance"] * read["irradiance"]
        assert read["radiosity"] == pytest.approx(b, rel=1e-2)  # the solver's tolerance, 0.1/10
        assert read["material_names"][read["material"][0]] == "m0"
        assert str(read["unit"]) == "cm" and float(read["unit_m"]) == 0.01


def test_vtp_comes_back_as_it_went(solution, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / "room.vtp"
    save(solution, path)
    read, shown = pyvista.read(path), shown_patches(solution)
    assert read.n_cells == len(shown)
    for name, values in {
        "radiosity_W_m2": solution.radiosity,
        "irradiance_W_m2": solution.irradiance_on,
        "emission_W_m2": solution.emission,
        "reflectance": solution.reflectance,
        "illuminance_lx": solution.illuminance,
        "error_lx": illuminance(solution.error, RGB),
    }.items():
        assert np.array_equal(read.cell_data[name], values[shown]), name
    assert np.array_equal(read.points.reshape(-1, 3), to_pyvista(solution).points)
    assert list(read.field_data["unit"]) == ["cm"] and list(read.field_data["bands"]) == [*"rgb"]


@pytest.mark.parametrize("name", ["room.stl", "room", "room.csv.gz"])
def test_other_suffixes_are_refused_before_the_work(solution, tmp_path, name):
    for refuse in (lambda p: check_suffix(p), lambda p: save(solution, p)):
        with pytest.raises(ValueError, match=r"\.vtp .*\.csv .*\.npz") as caught:
            refuse(tmp_path / name)
        assert name in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_suffixes_in_capitals_are_fine(solution, tmp_path):
    save(solution, tmp_path / "ROOM.CSV")
    assert (tmp_path / "ROOM.CSV").read_text().startswith("index,face,material")
    pyvista = pytest.importorskip("pyvista")
    save(solution, tmp_path / "ROOM.VTP")
    assert pyvista.read(tmp_path / "ROOM.VTP").n_cells == len(shown_patches(solution))


def test_names_of_any_alphabet_survive(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    room = scene(box((0, 0, 0), (1, 1, 1)), 0.5, [0, 1, 0, 0, 0, 0])
    materials = tuple(replace(m, name=f"weiß {m.name}, \u6728") for m in room.materials)
    solution = solve(replace(room, materials=materials, name="Küche"), accuracy=0.1)
    for suffix in (".vtp", ".csv", ".npz"):
        save(solution, tmp_path / f"küche{suffix}")
    names = pyvista.read(tmp_path / "küche.vtp").GetFieldData().GetAbstractArray("material_names")
    assert [names.GetValue(k) for k in range(6)] == [m.name for m in materials]
    with open(tmp_path / "küche.csv", newline="", encoding="utf-8") as file:
        assert {row["material"] for row in csv.DictReader(file)} == {m.name for m in materials}
    with np.load(tmp_path / "küche.npz") as read:
        assert read["material_names"].tolist() == [m.name for m in materials]


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".vtp", ".glb"])
def test_a_failed_export_leaves_the_old_file(solution, tmp_path, monkeypatch, suffix):
    path = tmp_path / f"room{suffix}"
    path.write_text("old")

    def break_off(solution, temporary):
        temporary.write_text("half")
        raise OSError("disk full")

    monkeypatch.setitem(export._WRITERS, suffix, break_off)
    with pytest.raises(OSError, match="disk full"):
        save(solution, path)
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]
