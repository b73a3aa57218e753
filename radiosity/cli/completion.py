"""What the shell offers after Tab: files by suffix, choices, names that the typed SCENE has.

Nothing is solved for it; where a scene cannot be read, nothing is offered.
"""

import os
from collections.abc import Callable, Iterable

SCENES = (".toml", ".radsol", ".glb", ".gltf", ".obj", ".ply", ".stl", ".rad")
MESHES = (".obj", ".ply", ".stl", ".glb", ".gltf", ".rad")


def words(*choices: str) -> Callable[[str], list[str]]:
    """Return what offers words."""
    return lambda incomplete: list(choices)


def files(*suffixes: str) -> Callable[[str], list[str]]:
    """Return what offers files with one of the suffixes, and folders."""

    def offered(incomplete: str) -> list[str]:
        found = list(_beside(incomplete, suffixes))
        if len(found) == 1 and found[0].endswith("/"):  # look into the only folder
            found += _beside(found[0], suffixes)
        return found

    return offered


def _beside(incomplete: str, suffixes) -> Iterable[str]:
    folder, begun = os.path.split(incomplete)
    try:
        entries = sorted(os.scandir(os.path.expanduser(folder or ".")), key=lambda e: e.name)
    except OSError:
        return
    for entry in entries:
        if entry.name.startswith(begun) and (begun or not entry.name.startswith(".")):
            place = os.path.join(folder, entry.name)
            if entry.is_dir():
                yield place + "/"
            elif entry.name.lower().endswith(suffixes):
                yield place


def solvers(incomplete: str) -> list[str]:
    """Return the names of solvers."""
    from radiosity.solve.plan import SOLVER_NAMES

    return list(SOLVER_NAMES)


def suites(incomplete: str) -> list[str]:
    """Return the suites of `verify`."""
    from radiosity.solve.verification import SUITES

    return list(SUITES)


def cameras(ctx, incomplete: str) -> list[str]:
    """Return the cameras of the scene that is typed."""
    return [name for scene in _typed(ctx) for name in scene.cameras]


def light_groups(ctx, incomplete: str) -> list[str]:
    """Return what of the typed scene can be dimmed, ready for its factor."""
    from radiosity.scene.groups import light_groups as groups

    return [f"{name}=" for scene in _typed(ctx) for name in groups(scene)]


def surfaces(ctx, incomplete: str) -> list[str]:
    """Return the face groups and materials of the scene that is typed."""
    return [
        name
        for scene in _typed(ctx)
        for name in dict.fromkeys([*scene.groups, *(m.name for m in scene.materials)])
    ]


def _typed(ctx) -> list:
    """Return the scene that is typed, if there is one that can be read."""
    from radiosity.solve.load import load

    # Where the last word is an option that lacks its value, arguments are left unread.
    typed = [ctx.params.get("scene"), *ctx.args]
    paths = [path for path in typed if path and path.lower().endswith(SCENES)]
    try:
        given = [load(path) for path in paths[:1]]
    except (ValueError, OSError, RuntimeError):
        return []
    return [getattr(x, "scene", x) for x in given]
