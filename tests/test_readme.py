"""Every command and example of the README runs as printed (set-up and the test command aside)."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()
BIN = Path(sys.executable).parent


def commands():
    """Return the README's commands without making the environment, which .ci/run does."""
    lines = [line for block in re.findall(r"```sh\n(.*?)```", README, re.S)
             for line in block.strip().splitlines()]  # fmt: skip
    return [line.split(" && ")[-1] for line in lines if not line.endswith("pytest")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the scenes, as in a clone."""
    here = tmp_path_factory.mktemp("readme")
    shutil.copytree(ROOT / "scenes", here / "scenes")
    return here


def test_the_two_first_commands_set_everything_up():
    first, second = re.findall(r"```sh\n(.*?)```", README, re.S)[:2]
    setup = "python3 -m venv .venv && .venv/bin/pip install "
    assert first.startswith(setup + ". && .venv/bin/radiosity view scenes/cornell_box.toml")
    assert second.strip() == setup + "'.[test]' && .venv/bin/pytest"
    assert len(commands()) >= 6


@pytest.mark.parametrize("command", commands())
def test_command(command, folder):
    words = shlex.split(command, comments=True)
    assert words[0].startswith(".venv/bin/")
    words[0] = str(BIN / words[0].removeprefix(".venv/bin/"))
    done = subprocess.run(
        words, cwd=folder, capture_output=True, text=True, timeout=600,
        env={**os.environ, "DISPLAY": "", "WAYLAND_DISPLAY": ""},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    for option, value in zip(words, words[1:], strict=False):
        if option in ("-o", "--html"):
            assert (folder / value).stat().st_size > 0


def test_python_example(folder):
    example = re.search(r"```python\n(.*?)```", README, re.S)[1]
    assert len([line for line in example.splitlines() if line.strip()]) <= 10
    done = subprocess.run(
        [sys.executable, "-c", example], cwd=folder, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr


def test_links_and_pictures_exist():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target
