"""Grids as they are named: a number is the height of a plane, a word the name of a surface."""

from radiosity.scene.model import Scene
from radiosity.solve.solution import Solution
from radiosity.view.pointgrid import PointGrid
from radiosity.view.surfacegrid import surface_cells, surface_grid
from radiosity.view.workplane import plane_cells, plane_grid


def check_grid(
    scene: Scene, name: str, spacing: float | None = None, margin: float | None = None
) -> None:
    """Refuse a grid that does not fit a scene, before anything is solved.

    Raises
    ------
    ValueError
        See `plane_grid` and `surface_grid`.
    """
    height = height_of(name)
    if height is None:
        surface_cells(scene, name, spacing, margin or 0.0)
    else:
        plane_cells(scene, height, spacing, margin)


def make_grid(
    solution: Solution, name: str, spacing: float | None = None, margin: float | None = None
) -> PointGrid:
    """Return the points of a plane where the name is a number, otherwise of what has that name.

    Lengths in scene units; see `plane_grid` and `surface_grid`, also for what is refused.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1)
    >>> len(make_grid(solution, "0.75").points), len(make_grid(solution, "floor", 0.5).points)
    (40, 48)
    """
    height = height_of(name)
    if height is None:
        return surface_grid(solution, name, spacing, margin or 0.0)
    return plane_grid(solution, height, spacing, margin)


def height_of(name: str) -> float | None:
    """Return the height that a grid's name is, None where it is the name of a surface."""
    try:
        return float(name)
    except ValueError:
        return None
