"""The house rules: imports go down only, heavy libraries stay in their rooms, files stay small."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "radiosity"
FLOORS = {"light": 0, "mesh": 0, "scene": 1, "transport": 2, "solve": 3, "view": 4, "cli": 5}
MAY_USE = {
    "light": set(),
    "mesh": set(),
    "scene": {"light", "mesh"},
    "transport": {"light", "mesh"},
    "solve": {"light", "mesh", "scene", "transport", "analytic"},
    "view": {"light", "mesh", "scene", "transport", "solve"},
    "cli": set(FLOORS) - {"cli"} | {"analytic"},
}
MODULES = sorted(PACKAGE.rglob("*.py"))


def imports(path):
    """Yield every module that a file imports, at any depth of nesting."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module


def room(path):
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else None


def name(path):
    return str(path.relative_to(PACKAGE))


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_imports_go_down_only(path):
    here = room(path)
    if here is None:
        return
    for module in imports(path):
        parts = module.split(".")
        if parts[0] == "radiosity" and len(parts) > 1 and parts[1] != here:
            assert parts[1] in MAY_USE[here], f"{name(path)} imports {module}"


@pytest.mark.parametrize(
    ("library", "allowed"),
    [
        ("embreex", {"transport/visibility.py"}),
        ("pyvista", {"view"}),
        ("vtkmodules", {"view"}),
        ("pydantic", {"scene"}),
        ("typer", {"cli"}),
        ("rich", {"cli"}),
    ],
)
def test_library_stays_in_its_room(library, allowed):
    users = {p for p in MODULES if any(m.split(".")[0] == library for m in imports(p))}
    outside = {name(p) for p in users if name(p) not in allowed and room(p) not in allowed}
    assert not outside, f"{library} is imported by {outside}"


def test_ground_floor_needs_numpy_and_scipy_only():
    for path in MODULES:
        if room(path) in ("light", "mesh"):
            used = {m.split(".")[0] for m in imports(path)}
            assert not used & {"numba", "trimesh", "embreex", "pyvista"}, name(path)


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_files_and_functions_are_readable_in_one_sitting(path):
    text = path.read_text()
    assert len(text.splitlines()) <= 400, f"{name(path)} is longer than 400 lines"
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            first = node.body[1] if ast.get_docstring(node) and len(node.body) > 1 else node.body[0]
            length = node.end_lineno - first.lineno + 1
            assert length <= 40, f"{name(path)}: {node.name} has {length} lines"


def test_no_drawer_for_odds_and_ends():
    names = {p.stem for p in MODULES}
    assert not names & {"utils", "util", "core", "common", "helpers", "misc"}


def test_public_names_are_few_and_exist():
    import radiosity

    assert len(radiosity.__all__) <= 20
    for public in radiosity.__all__:
        assert getattr(radiosity, public) is not None
