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
    if grid is not None:
        check_point(grid)
    if grid is None and not (spacing is None and margin is None):
        given = "--spacing" if spacing is not None else "--margin"
        raise ValueError(f"{given} is for --grid: the points of {points} are as they are")


def check_point(grid: str) -> None:
    """Refuse a height with a decimal comma."""
    if "," not in grid:
        return
    try:
        float(grid.replace(",", "."))
    except ValueError:
        return
    raise ValueError(f"--grid {grid!r} is not a height{o.with_point(grid)}")


def summary(grid, found, unit: str) -> str:
    """Return how even the light over a grid is, as text."""
    cell = " x ".join(f"{x:.4g}" for x in grid.spacing)
    rows = [
        f"points    {len(grid.points)} in cells of {cell} {unit}, margin {grid.margin:.4g} {unit}, "
        f"{grid.left_out} left out{WHY if grid.left_out else ''}",
        f"{'':12}{'lx':>12}{'error':>12}",
    ]
    for name in ("mean", "minimum", "maximum"):
        rows.append(_row(name, getattr(found, name), getattr(found, f"{name}_error")))
    rows.append(_row("U0 min/mean", found.u0, found.u0_error))
    rows.append(_row("Ud min/max", found.ud, found.ud_error))
    return "\n".join(rows)


WHY = ": in bodies, outside, or nearer than the margin to what stands there"


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
