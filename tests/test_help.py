"""Help and its pages in docs/: what verbs do, options with what they mean, examples that run."""

import importlib.util
import re
import resource
import shlex
import shutil
import sys
from pathlib import Path

import pytest
from test_cli import radiosity
from typer.main import get_command

from radiosity.cli import main
from radiosity.cli.verb import sections
from radiosity.solve.plan import SOLVER_NAMES
from radiosity.view.methods import METHODS

ROOT = Path(__file__).resolve().parent.parent
MAIN = get_command(main.app)
VERBS = MAIN.commands
ELSEWHERE = "view", "tradeoff", "verify"  # test_readme.py runs these


def examples(command):
    return dict(sections(command.help)[1:])["Examples"].strip().splitlines()


@pytest.fixture(scope="module")
def reference():
    """Return the script that makes the pages."""
    spec = importlib.util.spec_from_file_location("reference", ROOT / "docs" / "reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("page", ["cli.md", "json.md"])
def test_pages_are_what_the_program_says(reference, page):
    made = {"cli.md": reference.command_line, "json.md": reference.answers}[page]()
    assert (ROOT / "docs" / page).read_text() == made, "run python docs/reference.py"
    assert "None" not in made and made.isascii()


@pytest.mark.parametrize("name", VERBS)
def test_each_verb_says_what_it_does_and_has_examples(name):
    verb = VERBS[name]
    first = verb.help.splitlines()[0]
    assert first.endswith(".") and len(first) <= 100
    assert 2 <= len(examples(verb)) <= 4
    for param in verb.params:
        assert param.help and param.help[0].isupper() | (param.help.split()[0].islower())
        assert param.help.endswith(".") and (param.metavar or param.is_flag), param.name


@pytest.mark.parametrize("name", VERBS)
def test_examples_are_command_lines(name):
    for line in examples(VERBS[name]):
        program, verb, *words = shlex.split(line)
        assert program == "radiosity"
        VERBS[verb].make_context(verb, words)  # raises where they are none
        assert all((ROOT / w).exists() for w in words if w.startswith("scenes/")), line


def test_examples_run(tmp_path, monkeypatch, capsys):
    """In the order of the help: later ones may read what earlier ones wrote."""
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(main.signal, "signal", lambda *_: None)  # pytest keeps its own
    for verb in VERBS:
        for line in examples(VERBS[verb]) if verb not in ELSEWHERE else ():
            monkeypatch.setattr(sys, "argv", shlex.split(line))
            with pytest.raises(SystemExit) as end:
                main.run()
            assert not end.value.code, f"{line}\n{capsys.readouterr().err}"


def test_names_in_the_help_are_those_that_are_known():
    """They stand there in words, since help may not load what knows them."""
    helped = {p.name: p.help + str(p.metavar) for p in VERBS["render"].params}
    assert all(name in helped["solver"] for name in SOLVER_NAMES)
    assert all(name in helped["method"] for name in METHODS)


def test_help_is_quick_and_has_the_exit_codes_once():
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = radiosity("--help").stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    assert seconds < 0.3  # of the processor's: 0.12; others may run beside this test
    codes = re.findall(r"^ +(\d+)  ", out.split("Exit codes:")[1], re.M)
    assert codes == ["0", "1", "2", "3", "130"]
    assert all("Exit codes" not in verb.help for verb in VERBS.values())
    assert radiosity().stdout == out
    assert re.fullmatch(r"radiosity \d+\.\d+\.\d+\n", radiosity("--version").stdout)


@pytest.mark.parametrize("word", ["color", "group of light", "groups of light", "--false-color "])
def test_one_word_has_one_meaning(word):
    texts = [MAIN.help, *(v.help + "".join(p.help for p in v.params) for v in VERBS.values())]
    assert not any(word in text for text in texts)
