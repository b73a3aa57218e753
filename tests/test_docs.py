"""The examples in docstrings run, and every public name has one."""

import doctest
import re
import shutil
from importlib import import_module
from pathlib import Path

import pytest

import radiosity

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = Path(radiosity.__file__).resolve().parent  # where it is installed
MODULES = [
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")
    for path in sorted(PACKAGE.rglob("*.py")) if ">>>" in path.read_text()
]  # fmt: skip


@pytest.mark.parametrize("name", MODULES)
def test_examples(name, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    monkeypatch.chdir(tmp_path)
    module = import_module(name)
    found = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    assert found.attempted > 0 and found.failed == 0


@pytest.mark.parametrize("name", radiosity.__all__)
def test_examples_of_public_names_can_be_pasted(name, tmp_path, monkeypatch):
    """They import what they use, and run in a folder with the scenes."""
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    monkeypatch.chdir(tmp_path)
    described = getattr(radiosity, name)
    text = described.__call__.__doc__ if name == "solve" else described.__doc__
    example = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    found = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example)
    assert found.attempted > 0 and found.failed == 0 and "+SKIP" not in text


def test_the_scene_of_the_manual_loads(tmp_path):
    text = (ROOT / "docs" / "scene.md").read_text()
    (tmp_path / "room.toml").write_text(re.search(r"```toml\n(.*?)```", text, re.S)[1])
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
    (tmp_path / "furniture.obj").write_text(square)
    scene = radiosity.load(tmp_path / "room.toml")
    assert [m.name for m in scene.materials] == ["wood", "polished", "paper", "lamp"]
    assert scene.faces.areas().tolist() == pytest.approx([100.0**2, 20.0**2])  # cm2
    assert scene.materials[3].emits and scene.materials[2].translucent.tolist() == [0.5] * 3
    assert len(scene.lights) == 1 and scene.ambient.tolist() == [0.5, 0.6, 0.8]
    assert scene.cameras["front"].fov == 40
