"""``radiosity probe``."""

import sys
import time as clock
from typing import Annotated

import typer

from radiosity.cli import answer, completion
from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.grid import (
    GridOption,
    MarginOption,
    SpacingOption,
    as_dict,
    check_grid,
    summary,
)
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import Asked, Reading, judge, reached_line, scene_of, solve_scene

COLUMNS = ["x", "y", "z", "nx", "ny", "nz"]


def probe(
    context: typer.Context,
    scene: o.SceneFile,
    points: Annotated[
        str | None,
        typer.Argument(
            metavar="[POINTS.csv]",
            help="Points in scene units, and the side that receives: columns x,y,z,nx,ny,nz; - "
            "for stdin.",
            autocompletion=completion.files(".csv"),
        ),
    ] = None,
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="FILE.csv", help="Write the table here instead of stdout.",
            autocompletion=completion.files(".csv"),
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    as_json: o.Json = False,
    grid: GridOption = None,
    spacing: SpacingOption = None,
    margin: MarginOption = None,
    accuracy: o.Accuracy = 0.02,
    time: o.Time = None,
    mesh: o.Mesh = "auto",
    order: o.Order = None,
    solver: o.Solver = "gauss-seidel",
    force: o.Force = False,
    seed: o.Seed = 0,
    ambient: o.Ambient = 0.0,
    dim: o.Dim = None,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
    memory: o.Memory = None,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
) -> None:
    """Print irradiance in W/m2 and illuminance in lx at points or over a grid, with error bars.

    The table's columns are those of the points and E_r, E_g, E_b (W/m2), illuminance and its
    estimated error (lx). With --grid also how even the light is: mean, minimum, maximum, ratios.

    Examples
    --------
    radiosity probe scenes/cornell_box.toml scenes/cornell_box_reference/points.csv -o light.csv
    radiosity probe scenes/lroom.toml --grid 0.75 -o plane.csv
    radiosity probe scenes/lroom.toml --grid floor --spacing 0.5 --json
    """
    from radiosity.transport.files import check_place

    begun = clock.perf_counter()
    check_grid(points, grid, spacing, margin)
    where = None if points is None else read_points(points)
    if output:
        check_place(output)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    given = load_given(context, scene, asked, Reading(bands, ambient, unit, up), dim)
    from radiosity.view import grids  # loads much: what is mistyped is told before

    if grid is not None:
        grids.check_grid(scene_of(given), grid, spacing, margin)
    else:
        _note_strays(scene_of(given), where, quiet)
    with progress_bars(quiet) as progress:
        goal = None if where is None else (where[:, :3], where[:, 3:])
        solution = solve_scene(given, asked, progress, goal=goal)
        made = None if grid is None else grids.make_grid(solution, grid, spacing, margin)
        if made is not None:
            where = _rows(made)
        irradiance, error = solution.irradiance(where[:, :3], where[:, 3:], progress)
    remark(reached_line(solution), quiet)
    told = _tell(solution, where, made, irradiance, error, output, as_json, quiet)
    if as_json:
        answer.print_answer({**told, "seconds": clock.perf_counter() - begun})
    judge(solution, given)


def _note_strays(scene, where, quiet):
    """Remark on points that lie outside of the scene's extent, as where units are mixed up."""
    import numpy as np

    low, high = (f(scene.faces.vertices, axis=(0, 1)) for f in (np.min, np.max))
    slack = 0.01 * np.linalg.norm(high - low)
    strays = int(np.any((where[:, :3] < low - slack) | (where[:, :3] > high + slack), axis=1).sum())
    if strays:
        reach = ", ".join(f"{a:g} to {b:g}" for a, b in zip(low, high, strict=True))
        remark(
            f"note: {strays} of {len(where)} points lie outside of the scene, which reaches from "
            f"{reach} {scene.unit}: are they in {scene.unit}?",
            quiet,
        )


def _rows(grid):
    """Return (k, 6) positions and normals of a grid."""
    import numpy as np

    return np.hstack([grid.points, grid.normals])


def _tell(solution, where, grid, irradiance, error, output, as_json, quiet) -> dict:
    """Write the table to its file, or to stdout, and beside it what a grid comes to.

    Returns what is told as JSON.
    """
    from radiosity.light.photometry import illuminance
    from radiosity.transport.files import written_whole
    from radiosity.view.pointgrid import evenness

    scene = solution.scene
    text = table(where, irradiance, error, scene.bands)
    if output is not None:
        with written_whole(output) as temporary:
            temporary.write_text(text)
        remark(f"wrote {output}", quiet)
    found = grid and evenness(illuminance(irradiance, scene.bands), illuminance(error, scene.bands))
    if as_json:
        return _facts(solution, grid, found, text, output)
    if output is None:
        sys.stdout.write(text)
    if grid is not None:  # beside a table on stdout it is no part of it
        print(summary(grid, found, scene.unit), file=sys.stderr if output is None else sys.stdout)
    return {}


def _facts(solution, grid, found, text, output) -> dict:
    """Return what was reached, what a grid comes to, and the rows of the table."""
    import csv

    rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(text.splitlines())]
    even = {"grid": None, "illuminance_lx": None}
    return {
        "scene": solution.scene.name,
        **answer.solved(solution),
        **(even if grid is None else as_dict(grid, found, solution.scene.unit)),
        "points": rows,
        "written": [] if output is None else [output],
    }


def read_points(path: str):
    """Return (k, 6) positions and normals of a CSV file with a header; ``-`` is stdin.

    Raises
    ------
    ValueError
        Naming the file, every wrong line (up to ten) and what it must hold.
    """
    import csv

    import numpy as np

    name = "stdin" if path == "-" else path
    try:
        text = sys.stdin.read() if path == "-" else _read_text(path)
    except UnicodeDecodeError:
        raise ValueError(f"{name}: not a text file in UTF-8") from None
    rows = csv.reader(text.splitlines())
    header = [h.strip() for h in next(rows, [])]
    missing = [c for c in COLUMNS if c not in header]
    if missing:
        raise ValueError(
            f"{name}, line 1: columns {', '.join(missing)} are missing: "
            f"the first line must name {','.join(COLUMNS)}"
            + (", with commas in between" if ";" in "".join(header) else "")
        )
    order = [header.index(c) for c in COLUMNS]
    values, problems = [], []
    for number, row in enumerate(rows, 2):
        if not row or not "".join(row).strip():
            continue
        try:
            values.append(_numbers(row, order, len(header)))
        except ValueError as error:
            problems.append(f"{name}, line {number}: {error}")
    if problems:
        more = [f"and {len(problems) - 10} more"] if len(problems) > 10 else []
        raise ValueError("\n".join(problems[:10] + more))
    if not values:
        raise ValueError(f"{name}: no points after the header: add lines of six numbers")
    return np.array(values)


def _read_text(path: str) -> str:
    with open(path, encoding="utf-8-sig") as file:
        return file.read()


def _numbers(row, order, width):
    """Return position and normal of a row, checked."""
    from math import hypot, isfinite

    if len(row) != width:
        raise ValueError(f"has {len(row)} values where the header names {width}")
    found = []
    for name, k in zip(COLUMNS, order, strict=True):
        try:
            found.append(float(row[k]))
        except ValueError:
            raise ValueError(f"{name} = {row[k]!r} is not a number") from None
        if not isfinite(found[-1]):
            raise ValueError(f"{name} = {row[k]} must be finite")
    if hypot(*found[3:]) == 0:
        raise ValueError("nx, ny, nz = 0, 0, 0 is no direction: give the side that receives light")
    return found


def table(points, irradiance, error, bands) -> str:
    """Return CSV text: the points, E_r, E_g, E_b in W/m2, illuminance and its error in lx."""
    import numpy as np

    from radiosity.light.photometry import illuminance

    lines = [",".join(COLUMNS + ["E_r", "E_g", "E_b", "illuminance", "error"])]
    lux, bar = illuminance(irradiance, bands), illuminance(error, bands)
    values = np.column_stack([bands.to_rgb(irradiance), lux, bar])
    for where, found in zip(points, values, strict=True):
        cells = [f"{v:.10g}" for v in where] + [f"{v:.8g}" for v in found]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"
