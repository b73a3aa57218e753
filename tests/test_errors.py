"""Wrong command lines end in one message; exceptions are of the kinds in docs/errors.md."""

import re
import sys
from pathlib import Path

import pytest
from test_cli import BOX, CORNELL, SCENES

import radiosity
from radiosity.cli import main
from radiosity.scene.names import UnknownName

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "errors.md").read_text()
MESH = str(SCENES / "cornell_box.obj")


@pytest.fixture
def refused(capsys, monkeypatch, tmp_path):
    """Return what runs a wrong command line in this process and returns its only message."""
    monkeypatch.setattr(main.signal, "signal", lambda *_: None)  # pytest keeps its own
    monkeypatch.chdir(tmp_path)

    def run(*words, code=2):
        monkeypatch.setattr(sys, "argv", ["radiosity", *words])
        with pytest.raises(SystemExit) as end:
            main.run()
        out, err = capsys.readouterr()
        assert end.value.code == code and out == "" and not list(tmp_path.iterdir())
        assert err.startswith("radiosity: ") and err.count("\n") == 1 and len(err) < 300
        return err

    return run


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["sovle", BOX], "'sovle' is no verb: did you mean solve?"),
        (["fly"], "'fly' is no verb: known are view, solve"),
        (["--versoin"], "--versoin is no option of radiosity: did you mean --version?"),
        (["solve"], "SCENE is missing, see radiosity solve --help"),
        (["render", BOX], "-o/--output is missing: Picture"),
        (["solve", BOX, "more"], "unexpected extra argument(s) (more): see radiosity solve --help"),
        (["solve", BOX, "--acuracy", "1"], "--acuracy is no option of radiosity solve: did you "
         "mean --accuracy?"),
        (["plan", BOX, "--time", "3s"], "--time is no option of radiosity plan: see"),
        (["solve", BOX, "--accuracy"], "--accuracy requires an argument"),
        (["solve", BOX, "--quiet=1"], "--quiet does not take a value"),
        (["solve", BOX, "--order", "7"], "--order '7' must be 0 (constant) or 1 (linear elements)"),
        (["solve", BOX, "--accuracy", "0,02"], "--accuracy '0,02' is not a number: write 0.02"),
        (["solve", BOX, "--time", "1,5s"], "such as 10s, 2min or 1h: write 1.5s"),
        (["solve", BOX, "--memory", "1,5GB"], "such as 4GB or 500MB: write 1.5GB"),
        (["solve", BOX, "--dim", "ceiling=0,5"], "such as lamps=0.5: write 0.5"),
        (["solve", BOX, "--history", "h.txt"], "--history 'h.txt' must end in .png, .pdf or .svg"),
        (["render", BOX, "-o", "a.png", "--exposure", "0,05"], "such as 0.05: write 0.05"),
        (["render", BOX, "-o", "a.png", "--false-colour", "1,5"], "--false-colour '1,5' must be"),
        (["render", BOX, "-o", "a.png", "--camera", "insde"], "no camera is called 'insde': did "
         "you mean 'inside'?"),
        (["probe", BOX, "--grid", "0,75"], "--grid '0,75' is not a height: write 0.75"),
        (["probe", BOX, "--grid", "flor"], "is called 'flor': did you mean 'floor'?"),
        (["tradeoff", BOX, "--solver", "x"], "--solver is no option of radiosity tradeoff: did "
         "you mean --solvers?"),
        (["solve", str(SCENES)], "is a folder: name a file in it"),
        (["formfactors", MESH, "--accuracy", "7"], "--accuracy 7 must lie in [1e-09, 0.5]"),
        (["verify", "--suite", "none"], "--suite 'none' must be one of elements"),
    ],
)  # fmt: skip
def test_one_message_says_what_is_meant(refused, words, told):
    assert told in refused(*words)


def test_what_does_not_fit_is_refused_with_exit_code_3(refused):
    assert "more than the 0 bytes allowed" in refused("solve", CORNELL, "--memory", "0", code=3)


def test_a_name_that_was_not_typed_is_left_as_it_is():
    """The function's own word stands where no option of that name was given."""
    from radiosity.cli.usage import as_typed

    assert as_typed("accuracy = 7 must lie") == "accuracy = 7 must lie"


def test_names_can_be_caught_apart_and_offer_what_there_is():
    scene = radiosity.load(BOX)
    with pytest.raises(UnknownName, match="no camera is called 'up': the scene has") as raised:
        radiosity.render(scene, "up")
    assert raised.value.known == list(scene.cameras) and raised.value.name == "up"
    with pytest.raises(UnknownName, match="' and 5 more$"):
        raise UnknownName("camera", "x", [f"c{k}" for k in range(25)])


@pytest.mark.parametrize("example", re.findall(r"```python\n(.*?)```", PAGE, re.S))
def test_examples_of_the_page_run(example, monkeypatch, capsys):
    monkeypatch.chdir(SCENES.parent)
    exec(example, {})
    assert re.search(r"only \d|more than the .* allowed", capsys.readouterr().out)


def test_the_page_names_the_kinds_and_what_they_are():
    from radiosity.scene import names

    rows = re.findall(r"^\| `radiosity\.(?:scene\.names\.)?(\w+)` \| `(\w+)` \|", PAGE, re.M)
    assert len(rows) == 5
    for name, base in rows:
        kind = getattr(names, name, None) or getattr(radiosity, name)
        assert issubclass(kind, {"ValueError": ValueError, "RuntimeError": RuntimeError}[base])
    functions = [n for n in radiosity.__all__ if n[0].islower()]
    assert all(f"`{name}`" in PAGE for name in functions)


def test_what_is_no_scene_or_no_solution_is_named_with_the_way_out(tmp_path):
    room = radiosity.load(SCENES / "box6.toml")
    for wrong in ("room.toml", radiosity.solve(room, 0.1)):
        for call in (radiosity.solve, radiosity.plan):
            with pytest.raises(TypeError, match="is no Scene: radiosity.load reads one"):
                call(wrong)
    for call in (
        radiosity.plot, radiosity.to_pyvista,
        lambda x: radiosity.save(x, tmp_path / "a.csv"),
        lambda x: radiosity.report(x, tmp_path / "a.html"),
    ):  # fmt: skip
        with pytest.raises(TypeError, match="is not solved: radiosity.solve"):
            call(room)
        with pytest.raises(TypeError, match="is no Solution: radiosity.load reads"):
            call("room.radsol")
    assert not list(tmp_path.iterdir())


def test_arguments_of_the_wrong_kind_are_named(tmp_path):
    room = radiosity.load(SCENES / "furnace.toml")
    solution = radiosity.solve(room, 0.1)
    for words, call in {
        "accuracy = '2%' must be a number": lambda: radiosity.solve(room, "2%"),
        r"size = 100 must be \(width, height\)": lambda: radiosity.render(solution, size=100),
        "size = '100x80' must be": lambda: radiosity.render(solution, size="100x80"),
        "'wall' must be factors by light group": lambda: solution.dimmed("wall"),
        "is no Image: radiosity.render": lambda: radiosity.write(solution, tmp_path / "a.png"),
        "None is no Solution": lambda: radiosity.to_pyvista(None),
    }.items():
        with pytest.raises(TypeError, match=words):
            call()
    assert not list(tmp_path.iterdir())


def test_a_grid_of_a_report_needs_no_list():
    solution = radiosity.solve(radiosity.load(SCENES / "furnace.toml"), 0.1)
    told = [radiosity.report(solution, None, grids=x) for x in (0.75, "0.75", ["0.75"])]
    assert [figures.grids[0].grid for figures in told] == ["0.75"] * 3


def test_meshes_are_numbers_too():
    room = radiosity.load(SCENES / "furnace.toml")
    number, text = (radiosity.solve(room, mesh=mesh) for mesh in (2, "2"))
    assert len(number.patches) == len(text.patches) == 24
    with pytest.raises(ValueError, match="mesh = '0.5' must be auto, input or a number"):
        radiosity.solve(room, mesh=0.5)
