"""Grids of points for ``probe``: the options, and what is told of their values."""

from dataclasses import asdict
from typing import Annotated

import typer

from radiosity.cli import completion
from radiosity.cli import options as o

GridOption = Annotated[
    str | None,
    typer.Option(
        "--grid",
        metavar="HEIGHT|NAME",
        help="Instead of POINTS: a horizontal plane at HEIGHT, or all faces of the face group or "
        "material NAME.",
        autocompletion=completion.surfaces,
        rich_help_panel=o.POINTS,
    ),
]
SpacingOption = Annotated[
    float | None,
    typer.Option(
        "--spacing",
        metavar="D",
        parser=o.number,
        help="Largest cell of --grid, in scene units; if not given, as EN 12464-1 asks.",
        rich_help_panel=o.POINTS,
    ),
]
MarginOption = Annotated[
    float | None,
    typer.Option(
        "--margin",
        metavar="D",
        parser=o.number,
        help="Band that --grid leaves out, in scene units: along walls (if not given, as "
        "EN 12464-1 asks), or along the edges of NAME (if not given, 0).",
        rich_help_panel=o.POINTS,
    ),
]


def check_grid(points, grid, spacing, margin) -> None:
    """Refuse POINTS beside --grid, neither of them, and options of a grid that is not asked for."""
    if points is not None and grid is not None:
        raise ValueError(f"POINTS {points!r} and --grid {grid} exclude each other: give one")
    if points is None and grid is None:
        raise ValueError(
            "POINTS.csv is missing: give a file (- for stdin), or --grid HEIGHT to have the points "
            "of a work plane made"
        )
    if grid is not None and _height(grid) is None and _height(grid.replace(",", ".")) is not None:
        raise ValueError(f"--grid {grid!r} is not a height{o.with_point(grid)}")
    if grid is None and not (spacing is None and margin is None):
        given = "--spacing" if spacing is not None else "--margin"
        raise ValueError(f"{given} is for --grid: the points of {points} are as they are")


def check_grid_in(scene, grid: str | None, spacing, margin) -> None:
    """Refuse a grid that does not fit a scene, before anything is solved."""
    from radiosity.view.surfacegrid import surface_cells
    from radiosity.view.workplane import plane_cells

    if grid is None:
        return
    height = _height(grid)
    if height is None:
        surface_cells(scene, grid, spacing, margin or 0.0)
    else:
        plane_cells(scene, height, spacing, margin)


def make_grid(solution, grid: str, spacing: float | None, margin: float | None):
    """Return the points of a plane where ``grid`` is a number, otherwise of what has that name."""
    from radiosity.view.surfacegrid import surface_grid
    from radiosity.view.workplane import plane_grid

    height = _height(grid)
    if height is None:
        return surface_grid(solution, grid, spacing, margin or 0.0)
    return plane_grid(solution, height, spacing, margin)


def _height(grid):
    try:
        return float(grid)
    except ValueError:
        return None


def summary(grid, found, unit: str) -> str:
    """Return how even the light over a grid is, as text."""
    cell = " x ".join(f"{x:.4g}" for x in grid.spacing)
    rows = [
        f"points    {len(grid.points)} in cells of {cell} {unit}, margin {grid.margin:.4g} {unit}, "
        f"{grid.left_out} left out",
        f"{'':12}{'lx':>12}{'error':>12}",
    ]
    for name in ("mean", "minimum", "maximum"):
        rows.append(_row(name, getattr(found, name), getattr(found, f"{name}_error")))
    rows.append(_row("U0 min/mean", found.u0, found.u0_error))
    rows.append(_row("Ud min/max", found.ud, found.ud_error))
    return "\n".join(rows)


def _row(name, value, error):
    if value != value:  # nan: all is dark
        return f"{name:12}{'-':>12}{'-':>12}"
    return f"{name:12}{value:12.5g}{error:12.2g}"


def as_dict(grid, found, unit: str) -> dict:
    """Return what `summary` tells, for JSON."""
    return {
        "grid": {
            "points": len(grid.points),
            "left_out": grid.left_out,
            "spacing": list(grid.spacing),
            "margin": grid.margin,
            "unit": unit,
        },
        "illuminance_lx": asdict(found),
    }
