"""Form factors from the command line, and solutions that reuse them."""

import json
import sys

import numpy as np
import pytest
import typer
from test_cli import BOX, refused
from test_cli import radiosity as run

import radiosity
from radiosity.cli import formfactors
from radiosity.solve import assembly
from radiosity.solve.assembly import scene_factors
from radiosity.transport.closure import NotClosable
from radiosity.transport.operator import FormFactors
from radiosity.transport.store import load_factors, save_factors

CUBE = """\
g floor
f 1 2 3 4
g ceiling
f 5 8 7 6
g walls
f 1 4 8 5
f 2 6 7 3
f 1 5 6 2
f 4 3 7 8
"""
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
ADJACENT, OPPOSITE = 0.20004377607540316, 0.19982489569838738  # C-14, C-11
SCREENED = 0.11562060213241498  # Walton & Shapiro, verification/vf_obstructed.json
PLATES = [
    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
    [(0, 1, 1), (1, 1, 1), (1, 0, 1), (0, 0, 1)],
]
SCREEN = [[(0.25, 0.25, 0.75), (0.75, 0.25, 0.75), (0.75, 0.75, 0.75), (0.25, 0.75, 0.75)]]


def write_obj(path, polygons):
    """Write polygons as an OBJ file and return its path as text."""
    lines = [f"v {x} {y} {z}" for p in polygons for x, y, z in p]
    ends = np.cumsum([len(p) for p in polygons])
    for p, end in zip(polygons, ends, strict=True):
        lines.append("f " + " ".join(str(k + 1) for k in range(end - len(p), end)))
    path.write_text("\n".join(lines) + "\n")
    return str(path)


@pytest.fixture
def cube(tmp_path):
    path = tmp_path / "cube.obj"
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + CUBE)
    return str(path)


def equal(one, two):
    """Tell whether two matrices have the same exchange, areas and openness to the bit."""
    return (
        np.array_equal(one.exchange, two.exchange)
        and np.array_equal(one.area, two.area)
        and np.array_equal(one.environment, two.environment)
    )


def test_the_summary_says_what_was_reached_and_the_file_holds_it(cube, tmp_path):
    process = run("formfactors", cube, "-o", str(tmp_path / "F.npz"))
    assert process.returncode == 0, process.stderr
    lines = dict(line.split(maxsplit=1) for line in process.stdout.splitlines())
    assert lines["rows"] == "6 (0 triangles, 6 quadrilaterals)"
    assert lines["scene"] == "closed" and lines["sealed"] == "none"
    assert "0.001 asked" in lines["error"] and lines["memory"] == "16.2 kB predicted"
    assert "saved" in process.stderr
    factors = load_factors(tmp_path / "F.npz")
    assert equal(factors, radiosity.form_factors(cube))
    assert factors.toarray()[0] == pytest.approx([0, OPPOSITE, *[ADJACENT] * 4], rel=1e-9)


def test_rows_are_the_faces_of_the_file(tmp_path):
    """An L, a line without area, a screen above it: whatever pieces they are made of."""
    polygons = [[(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)],
                [(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 1), (1, 1, 1), (1, 0, 1), (0, 0, 1)],
                [(5, 5, 0), (6, 5, 0), (5, 6, 0)]]  # fmt: skip
    path = write_obj(tmp_path / "mixed.obj", polygons)
    process = run("formfactors", path, "-o", str(tmp_path / "F.npz"))
    lines = dict(line.split(maxsplit=1) for line in process.stdout.splitlines())
    assert lines["rows"] == "4 (1 triangles, 1 quadrilaterals, 2 others)"
    assert lines["sealed"] == "1: 1"
    factors = load_factors(tmp_path / "F.npz")
    assert factors.area == pytest.approx([3, 0, 1, 0.5])
    # verification/vf_polygon_pairs.json, concave_L_to_square
    assert factors.toarray()[0, 2] == pytest.approx(0.12397529133434736, rel=1e-9)


def test_rows_that_fail_to_close_beyond_their_errors_end_in_1(capsys):
    """A defect that no estimate explains is an error that was made."""
    area, error = np.ones(2), np.full((2, 2), 1e-6, np.float32)
    for sums, code in ((1.0 + 1e-4, 0), (1.05, 1)):
        factors = FormFactors(np.array([[0, sums], [sums, 0]]), area, error)
        found = formfactors.Found(factors, np.full(2, 3), np.zeros(2, int), ["all"], 0)
        facts = formfactors._facts(found, 1e-3, True, 0.0)
        assert facts["unexplained"] == pytest.approx(sums - 1)
        if code:
            with pytest.raises(typer.Exit) as end:
                formfactors._judge(facts)
            assert end.value.exit_code == code
            assert "fails to close by 5.00e-02" in capsys.readouterr().err
        else:
            formfactors._judge(facts)


def test_without_an_output_only_the_summary_is_printed(cube, tmp_path):
    process = run("formfactors", cube, "--json", "--quiet", cwd=tmp_path)
    facts = json.loads(process.stdout)
    assert facts["rows"] == 6 and facts["closed"] and facts["sealed"] == []
    assert 0 <= facts["closure_max"] < 1e-12 and facts["reciprocity"] < 1e-14
    assert facts["error"] <= facts["accuracy"] == 1e-3 and facts["seconds"] > 0
    assert facts["output"] is None and process.stderr == ""
    assert [p.name for p in tmp_path.iterdir()] == ["cube.obj"]


def test_groups_are_summed(cube, tmp_path):
    process = run("formfactors", cube, "--by-group", "-o", str(tmp_path / "F.npz"))
    assert "3: floor, ceiling, walls" in process.stdout
    factors = load_factors(tmp_path / "F.npz")
    assert factors.area == pytest.approx([1, 1, 4])
    expected = [[0, OPPOSITE, 4 * ADJACENT], [OPPOSITE, 0, 4 * ADJACENT],
                [ADJACENT, ADJACENT, 2 * ADJACENT + OPPOSITE]]  # fmt: skip
    assert factors.toarray() == pytest.approx(np.array(expected), rel=1e-9)
    table = process.stdout.split("from, to")[1].splitlines()
    assert table[0].split() == ["floor", "ceiling", "walls", "no", "row"]
    shown = [line.split() for line in table[1:4]]
    assert [row[0] for row in shown] == ["floor", "ceiling", "walls"]
    values = np.array([row[1:] for row in shown], float)
    assert values[:, :3] == pytest.approx(factors.toarray(), abs=1e-6)
    assert np.all(values[:, 3] == 0)


def test_other_formats_are_written(cube, tmp_path):
    expected = radiosity.form_factors(cube).toarray()
    assert run("formfactors", cube, "-o", str(tmp_path / "F.csv")).returncode == 0
    assert np.array_equal(np.loadtxt(tmp_path / "F.csv", delimiter=","), expected)
    text = tmp_path / "F.dat"
    assert run("formfactors", cube, "--format", "view3d", "-o", str(text)).returncode == 0
    assert text.read_text().startswith("View3D 1.0 0 1 0 6")
    assert load_factors(text, "view3d").toarray() == pytest.approx(expected, rel=1e-15)


def test_obstructions_block_and_are_no_rows(tmp_path):
    plates = write_obj(tmp_path / "plates.obj", PLATES)
    screen = write_obj(tmp_path / "screen.obj", SCREEN)
    process = run("formfactors", plates, "--obstructions", screen, "--accuracy", "1e-5",
                  "-o", str(tmp_path / "F.npz"))  # fmt: skip
    assert process.returncode == 0, process.stderr
    assert "rows          2 " in process.stdout
    assert "open: up to" in process.stdout and "meets surfaces that are no rows" in process.stdout
    factors = load_factors(tmp_path / "F.npz")
    assert factors.toarray()[0, 1] == pytest.approx(SCREENED, abs=1e-5)  # the accuracy asked for
    text = str(tmp_path / "F.txt")
    process = run("formfactors", plates, "--obstructions", screen, "-o", text)
    assert "text counts what meets surfaces without rows as leaving" in process.stderr


def test_backs_are_rows_where_asked(tmp_path):
    screen = write_obj(tmp_path / "screen.obj", SCREEN)
    process = run("formfactors", screen, "--two-sided", "--by-group", "--json")
    facts = json.loads(process.stdout)
    assert facts["rows"] == 2 and facts["environment_max"] == 1
    assert len(facts["groups"]) == 2 and facts["groups"][1].endswith("(back)")
    assert facts["group_factors"] == [[0, 0], [0, 0]] and facts["group_openness"] == [1, 1]


def test_raw_factors_keep_their_defects(tmp_path):
    room = [*(np.array(p) for p in PLATES), *(np.array(p) for p in SCREEN)]
    plates = write_obj(tmp_path / "plates.obj", room)
    facts = [json.loads(run("formfactors", plates, "--json", *more).stdout) for more in
             ([], ["--raw"])]  # fmt: skip
    assert facts[0]["closure_max"] < 1e-12 < 1e-5 < facts[1]["closure_max"]
    assert facts[1]["closure_max"] == facts[0]["closure_raw_max"]
    assert "no, as --raw asks" in run("formfactors", plates, "--raw").stdout


def test_threads_change_no_bit(cube, tmp_path):
    plates = write_obj(tmp_path / "plates.obj", PLATES + SCREEN)
    for n in "12":
        run("formfactors", plates, "--threads", n, "-o", str(tmp_path / f"{n}.npz"))
    assert equal(*(load_factors(tmp_path / f"{n}.npz") for n in "12"))


def test_an_error_above_the_asked_one_is_said_and_still_written(cube, tmp_path, monkeypatch):
    factors = radiosity.form_factors(cube)
    factors.error[:] = 1e-2 * factors.exchange
    found = in_process(
        monkeypatch, lambda *args, **options: factors,
        "formfactors", cube, "-o", str(tmp_path / "F.npz"),
    )  # fmt: skip
    assert found == 1
    assert equal(load_factors(tmp_path / "F.npz"), factors)


def test_rows_that_cannot_be_closed_end_with_exit_code_1(cube, tmp_path, monkeypatch, capsys):
    def fail(*args, **options):
        raise NotClosable(np.array([0.25, 0]), np.array([0.25, 0]))

    place = tmp_path / "F.npz"
    assert in_process(monkeypatch, fail, "formfactors", cube, "-o", str(place)) == 1
    said = capsys.readouterr()
    assert "row 0" in said.err and "--raw" in said.err and said.out == ""
    assert not place.exists()


def test_an_impossible_place_is_found_before_the_work(cube, tmp_path, monkeypatch, capsys):
    place = str(tmp_path / "no" / "F.npz")
    assert in_process(monkeypatch, None, "formfactors", cube, "-o", place) == 2
    assert "does not exist; create it first" in capsys.readouterr().err


def in_process(monkeypatch, form_factors, *args):
    """Run the command line here with other form factors; return its exit code."""
    from radiosity.cli.main import run as main
    from radiosity.solve import matrix

    monkeypatch.setattr(matrix, "form_factors", form_factors)
    monkeypatch.setattr(sys, "argv", ["radiosity", *args])
    with pytest.raises(SystemExit) as end:
        main()
    return end.value.code


def test_a_matrix_beyond_the_memory_is_refused_before_work(cube, tmp_path):
    process = run("formfactors", cube, "--memory", "1KB", "-o", "F.npz", cwd=tmp_path)
    refused(process, "form factors of 6 faces need about", "--memory", code=3)
    scene = run("formfactors", BOX, "--mesh", "9", "--memory", "1KB")
    refused(scene, "486 patches need about", "--mesh", code=3)
    assert not (tmp_path / "F.npz").exists()
    assert run("formfactors", cube, "-o", "F.npz", cwd=tmp_path).returncode == 0
    saved = run("solve", cube, "--factors", "F.npz", "--memory", "1KB", cwd=tmp_path)
    refused(saved, "6 patches need about", "--memory", code=3)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["none.obj"], ["none.obj: does not exist"]),
        (["cube.obj", "--obstructions", "none.obj"], ["none.obj: does not exist"]),
        (["cube.obj", "--accuracy", "2"], ["--accuracy 2 must lie in [1e-09, 0.5]"]),
        (["cube.obj", "--accuracy", "much"], ["'much' is not a number"]),
        (["cube.obj", "--mesh", "4"], ["--mesh does not apply", ".toml scene"]),
        (["cube.obj", "--ambient", "1"], ["--ambient does not apply"]),
        ([BOX, "--two-sided"], ["--two-sided does not apply", "lit backs are rows"]),
        ([BOX, "--obstructions", "cube.obj"], ["--obstructions does not apply"]),
        ([BOX, "--mesh", "few"], ["--mesh 'few' must be auto, input or a number"]),
        (["cube.obj", "--format", "csv"], ["--format csv needs a file to write: add -o FILE"]),
        (["cube.obj", "-o", "F.npz", "--format", "csv"], [".npz is the suffix of the format npz"]),
        (["cube.obj", "-o", "F.xls"], ["'.xls' must be one of npz, csv and view3d"]),
        (["cube.obj", "-o", "no/F.npz"], ["folder", "does not exist; create it first"]),
        (["cube.obj", "-o", "."], [".: is a folder; add the name of a file, such as F.npz"]),
        (["cube.obj", "-o", "/dev/full", "--format", "npz"], ["/dev/full: cannot write: No space"]),
        (["cube.obj", "--memory", "much"], ["--memory 'much' must be a size such as 4GB"]),
    ],
)
def test_wrong_input_is_refused_and_nothing_is_written(cube, tmp_path, args, words):
    refused(run("formfactors", *args, cwd=tmp_path), *words)
    assert [p.name for p in tmp_path.iterdir()] == ["cube.obj"]


# A closed room with a lamp as its ceiling, and a panel in it that is lit on both sides.
ROOM = """\
[[geometry]]
file = "cube.obj"
material = "wall"
[[geometry]]
material = "panel"
polygons = [[[0.3, 0.2, 0.4], [0.7, 0.2, 0.4], [0.7, 0.7, 0.6], [0.3, 0.7, 0.6]]]
[[geometry]]
material = "lamp"
polygons = [[[0.4, 0.4, 0.9], [0.4, 0.6, 0.9], [0.6, 0.6, 0.9], [0.6, 0.4, 0.9]]]
[materials.wall]
diffuse = {wall}
[materials.panel]
diffuse = [0.2, 0.5, 0.7]
[materials.lamp]
diffuse = 0.0
emission = {{ exitance = {lamp} }}
"""


@pytest.fixture
def room(cube, tmp_path):
    """Write the room in given colours; return its path as text."""

    def write(wall, lamp, name="room.toml"):
        (tmp_path / name).write_text(ROOM.format(wall=wall, lamp=lamp))
        return str(tmp_path / name)

    return write


def test_other_colours_and_lamps_reuse_the_factors(room, tmp_path, monkeypatch):
    options = ["--mesh", "3", "--accuracy", "0.1"]
    place = str(tmp_path / "F.npz")
    made = run("formfactors", room(0.5, 100), *options, "-o", place)
    assert made.returncode == 0, made.stderr
    other = room("[0.8, 0.6, 0.3]", "[10, 30, 50]")
    fresh = radiosity.solve(radiosity.load(other), 0.1, mesh="3")
    assert not fresh.patches.front.all()  # the panel's back is a row too
    saved = run("solve", other, *options, "--factors", place, "-o", str(tmp_path / "B.npz"))
    assert saved.returncode == 0, saved.stderr
    monkeypatch.setattr(assembly, "form_factors", None)  # nothing is assembled again
    reused = radiosity.solve(radiosity.load(other), 0.1, mesh="3", factors=load_factors(place))
    scale = fresh.radiosity.max()
    assert reused.radiosity == pytest.approx(fresh.radiosity, abs=1e-12 * scale)
    written = np.load(tmp_path / "B.npz")
    found = next(written[k] for k in written.files if k.startswith("radiosity"))
    assert found == pytest.approx(fresh.radiosity, abs=1e-6 * scale)  # if it is written shorter


def test_a_mesh_files_factors_fit_where_every_face_is_lit(cube, tmp_path):
    scene = tmp_path / "furnace.toml"
    scene.write_text('[[geometry]]\nfile = "cube.obj"\nmaterial = "m"\n'
                     "[materials.m]\ndiffuse = 0.5\nemission = { exitance = 2 }\n")  # fmt: skip
    for place in ("F.npz", "F.out"):
        run("formfactors", cube, "-o", str(tmp_path / place))
        out = tmp_path / "B.csv"
        process = run("solve", str(scene), "--mesh", "input", "--factors", str(tmp_path / place),
                      "-o", str(out))  # fmt: skip
        assert process.returncode == 0, process.stderr
        assert "balanced within" in process.stdout and "emitted               12" in process.stdout


def test_view3ds_six_digits_are_closed_before_they_are_used(cube, tmp_path):
    scene = radiosity.load(BOX)
    factors = scene_factors(scene, 0.1, mesh="1").factors
    text = tmp_path / "F.out"
    save_factors(factors, text)
    head, *rows = text.read_text().splitlines()
    short = [" ".join(f"{float(x):.6f}" for x in row.split()) for row in rows]
    text.write_text("\n".join([head, *short]) + "\n")
    solution = radiosity.solve(scene, 0.1, mesh="1", solver="direct", factors=load_factors(text))
    assert solution.balance.defect < 1e-12  # six digits would leave 1e-6 a bounce
    assert solution.truth_error() < 1e-4  # stated


# Two closed cubes apart: only the first one has a lamp, or both have.
TWO = """\
[[geometry]]
file = "cube.obj"
material = "one"
[[geometry]]
file = "cube.obj"
material = "two"
translate = [3, 0, 0]
[materials.one]
diffuse = 0.5
emission = {{ exitance = 1 }}
[materials.two]
diffuse = 0.5
{emission}
"""


def test_other_lit_sides_do_not_fit(cube, tmp_path):
    scenes = []
    for name, emission in (("dark", ""), ("lit", "emission = { exitance = 1 }")):
        (tmp_path / f"{name}.toml").write_text(TWO.format(emission=emission))
        scenes.append(radiosity.load(tmp_path / f"{name}.toml"))
    dark, lit = (scene_factors(s, 0.1, mesh="1").factors for s in scenes)
    assert dark.sealed.tolist() == [6, 7, 8, 9, 10, 11]
    with pytest.raises(ValueError, match="row 6, the front of a cell of face 6, has no area in"):
        radiosity.solve(scenes[1], 0.1, mesh="1", factors=dark)
    with pytest.raises(ValueError, match="row 6, .* has area 1 in them, but light does not reach"):
        radiosity.solve(scenes[0], 0.1, mesh="1", factors=lit)


def test_other_meshes_do_not_fit_and_the_way_out_is_told(cube, tmp_path):
    place = str(tmp_path / "F.npz")
    run("formfactors", cube, "-o", place)
    out = tmp_path / "B.csv"
    process = run("solve", BOX, "--mesh", "input", "--factors", place, "-o", str(out))
    refused(
        process, "row 0, the front of a cell of face 0", "has area 1 in them and 12 in the scene",
        "radiosity formfactors SCENE",
    )  # fmt: skip
    finer = run("solve", BOX, "--mesh", "2", "--factors", place)
    refused(finer, "6 rows, the scene has 24")
    assert not out.exists()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("none.npz", ["none.npz: No such file"]),
        ("cube.obj", ["'.obj' must be one of npz, csv and view3d"]),
        ("text.npz", ["text.npz: is broken or no .npz file of plain arrays"]),
    ],
)
def test_files_that_hold_no_factors_are_refused(cube, tmp_path, name, words):
    (tmp_path / "text.npz").write_text("F\n")
    refused(run("solve", BOX, "--factors", name, cwd=tmp_path), *words)
