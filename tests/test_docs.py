"""The examples in docstrings run, and every public name has one."""

import doctest
import shutil
from importlib import import_module
from pathlib import Path

import pytest

import radiosity

ROOT = Path(radiosity.__file__).resolve().parent
MODULES = [
    ".".join(("radiosity", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")
    for path in sorted(ROOT.rglob("*.py")) if ">>>" in path.read_text()
]  # fmt: skip


@pytest.mark.parametrize("name", MODULES)
def test_examples(name, tmp_path, monkeypatch):
    shutil.copytree(ROOT.parent / "scenes", tmp_path / "scenes")
    monkeypatch.chdir(tmp_path)
    module = import_module(name)
    found = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    assert found.attempted > 0 and found.failed == 0


@pytest.mark.parametrize("name", radiosity.__all__)
def test_public_names_have_an_example(name):
    described = getattr(radiosity, name)
    text = described.__call__.__doc__ if name == "solve" else described.__doc__
    assert ">>>" in text and "+SKIP" not in text
