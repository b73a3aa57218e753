"""``radiosity probe``."""

import sys
from typing import Annotated

import typer

from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import Asked, judge, reached_line, scene_of, solve_scene

COLUMNS = ["x", "y", "z", "nx", "ny", "nz"]


def probe(
    context: typer.Context,
    scene: o.SceneFile,
    points: Annotated[
        str, typer.Argument(metavar="POINTS.csv", help="Columns x,y,z,nx,ny,nz; - for stdin.")
    ],
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Write .csv here instead of stdout.")
    ] = None,
    accuracy: o.Accuracy = 0.02,
    bands: o.Bands = "auto",
    mesh: o.Mesh = "auto",
    order: o.Order = None,
    solver: o.Solver = "gauss-seidel",
    force: o.Force = False,
    time: o.Time = None,
    seed: o.Seed = 0,
    ambient: o.Ambient = 0.0,
    dim: o.Dim = None,
    memory: o.Memory = None,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
) -> None:
    """Irradiance in W/m2 and illuminance in lx at points, in the scene's unit of length.

    Example: radiosity probe scenes/cornell_box.toml points.csv -o light.csv
    """
    from radiosity.transport.files import check_place, written_whole

    where = read_points(points)
    if output:
        check_place(output)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    given = load_given(context, scene, asked, bands, ambient, dim)
    model = scene_of(given)
    with progress_bars(quiet) as progress:
        goal = where[:, :3], where[:, 3:]
        solution = solve_scene(given, asked, progress, goal=goal)
        irradiance, error = solution.irradiance(where[:, :3], where[:, 3:], progress)
    text = table(where, irradiance, error, model.bands)
    remark(reached_line(solution), quiet)
    if output is None:
        sys.stdout.write(text)
    else:
        with written_whole(output) as temporary:
            temporary.write_text(text)
        remark(f"wrote {output}", quiet)
    judge(solution, given)


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
