"""``radiosity report``."""

import time as clock
from typing import Annotated

import typer

from radiosity.cli import answer, completion
from radiosity.cli import display as d
from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.grid import MarginOption, SpacingOption, check_point
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import Asked, Reading, judge, reached_line, scene_of, solve_scene


def report(
    context: typer.Context,
    scene: o.SceneFile,
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="FILE.html",
            help="Write the report here: one file for any browser, which prints it to PDF.",
            autocompletion=completion.files(".html"),
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    as_json: o.Json = False,
    date: Annotated[
        str | None,
        typer.Option(
            "--date", metavar="YYYY-MM-DD",
            help="Date of the report; if not given, that of SOURCE_DATE_EPOCH, or today's.",
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    grid: Annotated[
        list[str] | None,
        typer.Option(
            "--grid", metavar="HEIGHT|NAME",
            help="Judge and map a horizontal plane at HEIGHT, or the faces of the face group or "
            "material NAME. Repeatable. If not given: the floor and, in a room, the work plane "
            "0.75 m above it.",
            autocompletion=completion.surfaces,
            rich_help_panel=o.POINTS,
        ),
    ] = None,
    spacing: SpacingOption = None,
    margin: MarginOption = None,
    camera: Annotated[
        list[str] | None,
        typer.Option(
            "--camera", metavar="NAME",
            help="Camera to show. Repeatable. If not given, the scene's first four.",
            autocompletion=completion.cameras,
            rich_help_panel=o.PICTURE,
        ),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(
            "--size", metavar="WxH",
            help="Width and height in pixels; if not given, the camera's own, at most 640.",
            rich_help_panel=o.PICTURE,
        ),
    ] = None,
    samples: o.Samples = None,
    exposure: d.ExposureOption = "auto",
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
    """Write the report that is handed over: pictures, illuminance with error bars, maps, power.

    One HTML file that needs neither network nor scripts and prints well on A4. It tells what was
    modelled and what was not, materials and lights, how even the light on planes and surfaces is,
    and how accurate all this is.

    Examples
    --------
    radiosity report scenes/office.toml -o office.html --accuracy 0.1 --size 160x120
    radiosity report scenes/lroom.toml --accuracy 0.1 --grid 0.85 --grid floor --spacing 0.5 --json
    """
    from radiosity.view import report as page

    begun, grids = clock.perf_counter(), grid or []
    _check(output, as_json, grids)
    day, pixels = page.date_of(date), o.parse_size(size)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    given = load_given(context, scene, asked, Reading(bands, ambient, unit, up), dim)
    _check_in(scene_of(given), camera, pixels, grids, spacing, margin)
    with progress_bars(quiet) as progress:
        solution = solve_scene(given, asked, progress)
    remark(reached_line(solution), quiet)
    with progress_bars(quiet) as progress:
        told = page.report(
            solution, output, cameras=camera, size=pixels, samples=samples,
            exposure=exposure.of(solution), grids=grids,
            spacing=spacing, margin=margin, date=day, command=_command(), progress=progress,
        )  # fmt: skip
    if output is not None:
        remark(f"wrote {output}", quiet)
    if as_json:
        answer.print_answer({
            **answer.solved(solution), **told.as_dict(), "seconds": clock.perf_counter() - begun,
            "written": [] if output is None else [output],
        })  # fmt: skip
    judge(solution, given)


def _check(output, as_json, grids) -> None:
    """Refuse what is wrong whatever the scene."""
    from radiosity.view.report import check_path

    if output is None and not as_json:
        raise ValueError("a report needs a file to write: add -o report.html, or --json")
    if output is not None:
        check_path(output)
    for name in grids:
        check_point(name)


def _check_in(scene, cameras, pixels, grids, spacing, margin) -> None:
    """Refuse cameras, sizes and grids that do not fit a scene, before anything is solved."""
    from radiosity.view.gather import picture_size
    from radiosity.view.grids import check_grid
    from radiosity.view.report import cameras_of
    from radiosity.view.report.zones import lowest

    for camera in cameras_of(scene, cameras):
        picture_size(camera, pixels, scene.bands)
    if not grids and not (spacing is None and margin is None):
        grids = [repr(lowest(scene))]
    for name in grids:
        check_grid(scene, name, spacing, margin)


def _command() -> str:
    """Return the command as it was typed."""
    import shlex
    import sys

    return shlex.join(["radiosity", *sys.argv[1:]])
