"""Reading what a user names: a scene to be solved, or a solution that was saved."""

from pathlib import Path
from typing import TYPE_CHECKING

from radiosity.light.palette import ACCURACY
from radiosity.scene import files
from radiosity.scene.model import Scene

if TYPE_CHECKING:
    from radiosity.solve.solution import Solution

SOLVED = ".radsol"


def is_solved(path: str | Path) -> bool:
    """Whether a path names a file that holds a solution."""
    return Path(path).suffix.lower() == SOLVED


def load(
    path: str | Path, merge: bool = True, bands: str | int = "auto", accuracy: float = ACCURACY,
    unit: str | None = None, up: str | None = None,
) -> "Scene | Solution":  # fmt: skip
    """Return the scene of a file, or the solution that a ``.radsol`` file holds.

    Parameters
    ----------
    path : str or Path
        ``.radsol``, as `radiosity.save` writes; of all others see `radiosity.scene.files.load`,
        for which the other parameters are, too.

    Returns
    -------
    Scene or Solution

    Raises
    ------
    SceneError
        Lists everything that is wrong with the file and with those it names.
    ValueError
        Unknown ``bands``, or an option of scenes for a file that is solved.

    Examples
    --------
    >>> import radiosity
    >>> scene = radiosity.load("scenes/box6.toml")
    >>> scene.name, len(scene.faces), scene.unit
    ('Room of six faces', 6, 'm')
    >>> radiosity.save(radiosity.solve(scene, 0.1), "room.radsol")
    >>> solution = radiosity.load("room.radsol")
    >>> radiosity.render(solution, size=(8, 6), samples=8).pixels.shape
    (6, 8, 3)
    """
    if not is_solved(path):
        return files.load(path, merge, bands, accuracy, unit, up)
    asked = {"merge": not merge, "bands": bands != "auto", "accuracy": accuracy != ACCURACY}
    asked |= {"unit": unit is not None, "up": up is not None}
    for name in [name for name, given in asked.items() if given]:
        raise ValueError(f"{name} is for scenes, but {path} is solved: leave it out")
    from radiosity.solve.container import read_solution  # scenes need none of it

    return read_solution(path)
