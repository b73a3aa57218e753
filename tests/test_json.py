"""``--json``: what every verb prints is one object that its schema describes, and all of it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator, ValidationError
from referencing import Registry, Resource
from test_cli import BOX, CORNELL, FURNACE, SCENES
from typer.main import get_command

from radiosity.cli import main

SCHEMAS = {
    path.stem: json.loads(path.read_text())
    for path in sorted((Path(main.__file__).parent / "schemas").glob("*.json"))
}
REGISTRY = Registry().with_resources(
    (f"{name}.json", Resource.from_contents(schema)) for name, schema in SCHEMAS.items()
)
ALIEN = str(SCENES.parent / "tests" / "foreign" / "alien.glb")
MESH = str(SCENES / "cornell_box.obj")
QUICK = "--accuracy", "0.1"
FEW = "--size", "8x6", "--samples", "4"
PLACES = "x,y,z,nx,ny,nz\n1,1,0.5,0,0,1\n"


def validate(name, answer):
    Draft202012Validator(SCHEMAS[name], registry=REGISTRY).validate(answer)


@pytest.fixture
def told(capsys, monkeypatch, tmp_path):
    """Return what runs the command line in this process: ``(exit code, object on stdout)``."""
    monkeypatch.setattr(main.signal, "signal", lambda *_: None)  # pytest keeps its own
    monkeypatch.chdir(tmp_path)
    (tmp_path / "points.csv").write_text(PLACES)

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["radiosity", *words, "--json"])
        with pytest.raises(SystemExit) as end:
            main.run()
        out = capsys.readouterr().out
        assert out.endswith("}\n")
        return end.value.code or 0, json.loads(out, parse_constant=pytest.fail)

    return run


ANSWERED = [
    ["solve", FURNACE, *QUICK, "-o", "a.npz", "--history", "a.svg"],
    ["solve", FURNACE, "--time", "0.1s"],
    ["solve", str(SCENES / "cornell_box_spectral.toml"), "--mesh", "1", "--bands", "8"],
    ["render", FURNACE, *QUICK, "-o", "a.png", *FEW, "--false-colour", "log"],
    ["render", BOX, "-o", "a.npy", *FEW, "--method", "local"],
    ["view", BOX, *QUICK, "--screenshot", "a.png", *FEW],
    ["view", BOX, *QUICK, "--html", "a.html"],
    ["probe", BOX, "points.csv", *QUICK],
    ["probe", BOX, *QUICK, "--grid", "1", "-o", "a.csv"],
    ["report", BOX, *QUICK, "--grid", "1", "--grid", "floor", "-o", "a.html", *FEW],
    ["report", str(SCENES / "point_spot.toml"), *QUICK],
    ["plan", BOX, *QUICK],
    ["tradeoff", BOX, *QUICK, "--solvers"],
    ["formfactors", MESH, *QUICK, "--by-group", "-o", "F.npz"],
    ["formfactors", BOX, *QUICK, "--mesh", "1"],
    ["verify", "--suite", "elements"],
    ["info", CORNELL],
    ["info", str(SCENES / "office.toml")],
    ["info", str(SCENES / "point_spot.toml")],
    ["info", str(SCENES / "glass_ball.toml")],
    ["materials", ALIEN],
]


@pytest.mark.parametrize("words", ANSWERED, ids=lambda words: f"{words[0]} {Path(words[1]).stem}")
def test_every_answer_is_as_its_schema_says(told, words):
    code, answer = told(*words)
    assert code == 0
    validate(words[0], answer)
    assert all(Path(path).stat().st_size > 0 for path in answer.get("written", []))


def test_every_verb_has_a_schema_and_is_tried():
    verbs = set(get_command(main.app).commands)
    assert verbs <= set(SCHEMAS) and {words[0] for words in ANSWERED} == verbs


def test_a_solution_that_was_saved_is_described(told):
    told("solve", FURNACE, "--mesh", "1", "-o", "room.radsol")
    code, answer = told("info", "room.radsol")
    validate("info", answer)
    assert code == 0 and answer["solved"]["patches"] == 6 and answer["solved"]["can_dim"]
    assert told("solve", "room.radsol")[1]["estimated_error"] == answer["solved"]["estimated_error"]


def test_what_is_told_is_what_was_found(told):
    """In a furnace all that is emitted is absorbed, and the light is even."""
    _, solved = told("solve", FURNACE, *QUICK)
    assert solved["reached"] and solved["closed"] and solved["error_bound"] == solved["history"][-1]
    assert len(solved["history"]) == solved["iterations"]
    assert solved["power"]["emitted"] == pytest.approx(solved["power"]["absorbed"], rel=1e-5)
    assert solved["truth"]["error"] < 1e-5  # the solver's tolerance is 1e-6
    _, even = told("probe", FURNACE, *QUICK, "--grid", "0.5")
    assert even["illuminance_lx"]["u0"] == pytest.approx(1, abs=1e-5)
    assert len(even["points"]) == even["grid"]["points"]


def test_numbers_that_do_not_exist_are_null(told, tmp_path):
    (tmp_path / "dark.toml").write_text(Path(FURNACE).read_text().replace("emission", "# "))
    code, even = told("probe", "dark.toml", *QUICK, "--grid", "0.5")
    validate("probe", even)
    assert code == 0 and even["illuminance_lx"]["u0"] is None


def test_what_falls_short_is_told_with_exit_code_1(told):
    code, answer = told("solve", CORNELL, "--accuracy", "0.02", "--memory", "8MB")
    validate("solve", answer)
    assert code == 1 and not answer["reached"]
    assert answer["estimated_error"] > answer["accuracy"] == 0.02


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["solve", "none.toml"], 2, "none.toml: does not exist"),
        (["solve", BOX, "--order", "x"], 2, "--order 'x' must be 0 (constant)"),
        (["fly", BOX], 2, "'fly' is no verb"),
        (["solve", CORNELL, "--memory", "1MB"], 3, "more than the"),
        (["tradeoff", BOX, "-o", "a.txt"], 2, "must end in .png"),
    ],
)
def test_where_there_is_no_answer_the_object_says_why(told, words, code, said):
    found, answer = told(*words)
    validate("error", answer)
    assert found == code == answer["exit_code"] and said in answer["error"]


def test_stdout_holds_nothing_else():
    """In a real process, with all remarks on: a line of JSON; they are on stderr."""
    words = [sys.executable, "-m", "radiosity", "solve", FURNACE, *QUICK, "--json"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert done.stdout.count("\n") == 1 and "solved" in done.stderr
    validate("solve", json.loads(done.stdout))


def described(schema):
    """Yield every key of a schema, at any depth, with what is said of it."""
    for key, said in schema.get("properties", {}).items():
        yield key, said
        yield from described(said)
        yield from described(said.get("items", {}))


@pytest.mark.parametrize("name", SCHEMAS)
def test_schemas_describe_every_key_and_allow_no_other(name):
    schema = SCHEMAS[name]
    Draft202012Validator.check_schema(schema)
    if name in ("parts", "materials"):
        return
    for key, said in described(schema):
        assert "$ref" in said or len(said["description"]) > 5, key
    assert schema["additionalProperties"] is False
    with pytest.raises(ValidationError):
        validate(name, {})


def test_a_key_more_is_found(told):
    _, answer = told("plan", BOX, *QUICK)
    with pytest.raises(ValidationError, match="surprise"):
        validate("plan", answer | {"surprise": 1})
