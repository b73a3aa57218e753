"""What the shell offers after Tab, in a real bash."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

from radiosity.cli import completion
from radiosity.cli.main import app
from radiosity.scene.files import read_geometry
from radiosity.scene.model import SceneError

SCENES = Path(__file__).resolve().parent.parent / "scenes"
BASH = shutil.which("bash")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with scenes, and the program by its name."""
    here = tmp_path_factory.mktemp("shell")
    shutil.copytree(SCENES / "luminaires", here / "scenes" / "luminaires")
    for name in ("office.toml", "box6.toml"):
        shutil.copy(SCENES / name, here / "scenes" / name)
    (here / "scenes" / "broken.toml").write_text("name = ")
    (here / "bin").mkdir()
    program = here / "bin" / "radiosity"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m radiosity "$@"\n')
    program.chmod(0o755)
    return here


def offered(folder, typed):
    """Return what bash offers where Tab is pressed after what is typed."""
    words = typed.split(" ")
    script = f"""
        eval "$(_RADIOSITY_COMPLETE=source_bash radiosity)"
        COMP_WORDS=({" ".join(f"'{w}'" for w in words)}) COMP_CWORD={len(words) - 1}
        $(complete -p radiosity | sed 's/.*-F \\([^ ]*\\).*/\\1/') radiosity
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    path = f"{folder / 'bin'}:{os.environ['PATH']}"
    done = subprocess.run(
        [BASH, "--norc", "-c", script], capture_output=True, text=True, cwd=folder, timeout=20,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "PATH": path},
    )  # fmt: skip
    assert done.stderr == "", done.stderr
    return done.stdout.splitlines()


@pytest.mark.skipif(BASH is None, reason="needs bash")
@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("radiosity pr", ["probe"]),
        ("radiosity render --cam", ["--camera"]),
        ("radiosity solve --solver g", ["gauss-seidel", "gmres"]),
        ("radiosity solve --mesh ", ["auto", "input"]),
        ("radiosity render scenes/o", ["scenes/office.toml"]),
        ("radiosity render scenes/lum", ["scenes/luminaires/"]),
        ("radiosity render scenes/office.toml --camera ", ["front"]),
        ("radiosity probe scenes/office.toml --dim ", ["desk=", "floor="]),
        ("radiosity probe scenes/office.toml --grid fl", ["floor"]),
        ("radiosity render scenes/broken.toml --camera ", [""]),
        ("radiosity render --camera ", [""]),
        ("radiosity fly --h", ["--help"]),
    ],
)
def test_bash_offers(folder, typed, expected):
    assert offered(folder, typed) == expected


@pytest.mark.parametrize("typed", ["radiosity ", "radiosity solve --"])
def test_fish_is_offered_one_line_a_word(typed):
    """Whatever stands in a line of its own is taken for a word."""
    words = {"_RADIOSITY_COMPLETE": "complete_fish", "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    done = subprocess.run(
        [sys.executable, "-m", "radiosity"], capture_output=True, text=True, timeout=60,
        env={**os.environ, **words, "_TYPER_COMPLETE_ARGS": typed},
    )  # fmt: skip
    lines = [line.split("\t")[0] for line in done.stdout.splitlines() if line]
    verbs = get_command(app).commands
    options = [o for p in verbs["solve"].params for o in p.opts if o.startswith("--")]
    assert set(lines) == (set(verbs) if typed == "radiosity " else {*options, "--help"})


def test_only_scenes_and_folders_are_offered_as_scenes(folder, monkeypatch):
    monkeypatch.chdir(folder)
    (folder / "scenes" / "picture.png").write_bytes(b"")
    offer = completion.files(*completion.SCENES)
    expected = [f"scenes/{n}" for n in ("box6.toml", "broken.toml", "luminaires/", "office.toml")]
    assert offer("scenes/") == expected
    assert offer("sc") == ["scenes/", *expected]  # the only folder is looked into
    assert offer("none/") == []


def test_the_suffixes_are_those_that_are_read(tmp_path):
    with pytest.raises(SceneError) as raised:
        read_geometry(tmp_path / "a.xyz")
    assert all(suffix in str(raised.value) for suffix in completion.MESHES)
    assert str(raised.value).count(".") - 2 == len(completion.MESHES) + 1  # of .toml; .xyz twice
    assert set(completion.SCENES) == {".toml", ".radsol", *completion.MESHES}


def test_every_option_with_choices_offers_them():
    for name, verb in get_command(app).commands.items():
        for param in verb.params:
            if param.metavar in ("auto|input|N", "npz|csv|view3d", "x|y|z", "0|1", "NAME"):
                assert param._custom_shell_complete is not None, f"{name} {param.opts}"
