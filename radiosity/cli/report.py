"""``radiosity report``."""

from typing import Annotated

import typer

from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.grid import MarginOption, SpacingOption
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import Asked, Reading, judge, reached_line, scene_of, solve_scene


def report(
    context: typer.Context,
    scene: o.SceneFile,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", help="Write the report here: one .html, for any browser."),
    ] = None,
    camera: Annotated[
        list[str] | None,
        typer.Option(
            "--camera", metavar="NAME", help="Show this one; repeatable. The first four by default."
        ),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(
            "--size", metavar="WxH", help="Pixels; the cameras' own, at most 640, by default."
        ),
    ] = None,
    samples: o.Samples = None,
    grid: Annotated[
        list[str] | None,
        typer.Option(
            "--grid",
            metavar="HEIGHT|NAME",
            help="Judge this plane, or this group's or material's faces; repeatable. By default "
            "the floor and, in a room, the plane 0.75 m above it.",
        ),
    ] = None,
    spacing: SpacingOption = None,
    margin: MarginOption = None,
    date: Annotated[
        str | None,
        typer.Option(
            "--date",
            metavar="YYYY-MM-DD",
            help="To stand there, instead of SOURCE_DATE_EPOCH's or today's.",
        ),
    ] = None,
    accuracy: o.Accuracy = 0.02,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
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
    as_json: o.Json = False,
    quiet: o.Quiet = False,
) -> None:
    """Write what one hands over: pictures, illuminance with errors, maps, model, accuracy.

    With --json the same figures on stdout, with or without a file.

    Example: radiosity report scenes/office.toml -o office.html
    """
    from radiosity.view import report as page

    if output is None and not as_json:
        raise ValueError("a report needs a file to write: add -o report.html, or --json")
    if output is not None:
        page.check_path(output)
    day, pixels = page.date_of(date), o.parse_size(size)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    given = load_given(context, scene, asked, Reading(bands, ambient, unit, up), dim)
    _check(scene_of(given), camera, pixels, grid or (), spacing, margin)
    with progress_bars(quiet) as progress:
        solution = solve_scene(given, asked, progress)
    remark(reached_line(solution), quiet)
    with progress_bars(quiet) as progress:
        told = page.report(
            solution, output, cameras=camera, size=pixels, samples=samples, grids=grid or (),
            spacing=spacing, margin=margin, date=day, command=_command(), progress=progress,
        )  # fmt: skip
    if as_json:
        import json

        print(json.dumps(told.as_dict()))
    if output is not None:
        remark(f"wrote {output}", quiet)
    judge(solution, given)


def _check(scene, cameras, pixels, grids, spacing, margin) -> None:
    """Refuse cameras, sizes and grids that are none, before anything is solved."""
    from radiosity.view.gather import picture_size
    from radiosity.view.grids import check_grid
    from radiosity.view.report import cameras_of

    for camera in cameras_of(scene, cameras):
        picture_size(camera, pixels, scene.bands)
    for name in grids:
        check_grid(scene, name, spacing, margin)


def _command() -> str:
    """Return the command as it was typed."""
    import shlex
    import sys

    return shlex.join(["radiosity", *sys.argv[1:]])
