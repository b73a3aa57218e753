"""``radiosity view``."""

import time as clock
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import answer, completion
from radiosity.cli import display as d
from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.method import MethodOption, ShadowsOption, check_method, view_by
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.render import rendered
from radiosity.cli.session import Asked, Reading, scene_of


def view(
    context: typer.Context,
    scene: o.SceneFile,
    screenshot: Annotated[
        str | None,
        typer.Option(
            "--screenshot",
            metavar="FILE",
            help="Write the gathered picture here and open no window.",
            autocompletion=completion.files(".png", ".exr", ".hdr", ".npy"),
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    html: Annotated[
        str | None,
        typer.Option(
            "--html",
            metavar="FILE.html",
            help="Write a page here that shows the solution in any browser, and open no window.",
            autocompletion=completion.files(".html"),
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    as_json: o.Json = False,
    camera: o.CameraName = None,
    size: o.Size = None,
    samples: o.Samples = None,
    method: MethodOption = "gather",
    shadows: ShadowsOption = True,
    exposure: d.ExposureOption = "auto",
    false_colour: d.FalseColourOption = None,
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
    """Solve a scene and look at it in an interactive window, or write a page that shows it.

    The window opens at once and shows light spreading while it is solved; key h lists its keys.
    Without a display the gathered picture of the camera is written instead, as SCENE.png in this
    folder if --screenshot does not name a file.

    Examples
    --------
    radiosity view scenes/cornell_box.toml
    radiosity view scenes/lroom.toml --screenshot lroom.png --size 96x64 --false-colour auto
    radiosity view scenes/box6.toml --accuracy 0.1 --html box6.html
    """
    from radiosity.transport.files import check_place
    from radiosity.view.gather import find_camera, picture_size

    begun = clock.perf_counter()
    if html is not None:
        _check_page(context, html)
    target = screenshot or f"{Path(scene).stem}.png"
    d.check_display(target, exposure, None, false_colour)
    if screenshot:
        check_place(screenshot)
    pixels = o.parse_size(size)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    check_method(method, shadows, asked)
    given = load_given(context, scene, asked, Reading(bands, ambient, unit, up), dim)
    model = scene_of(given)
    chosen = find_camera(model, camera)
    picture_size(chosen, pixels, model.bands)
    solve = partial(view_by, method, shadows, given, asked)
    looked = partial(d.Look.of, asked=exposure, colours=false_colour)
    if html is None and screenshot is None and _has_display(quiet):
        solution, told = _opened(model, solve, chosen, pixels, samples, looked), []
        if solution is None:
            _leave(as_json)
        look = looked(solution)
    else:
        with progress_bars(quiet) as progress:
            solution = solve(progress)
        look, told = looked(solution), []
        if html is not None:
            look = replace(look, exposure=_write_page(solution, html, chosen, exposure, quiet))
        else:
            told.append(rendered(solution, chosen, Path(target), pixels, samples, look, quiet))
    if as_json:
        seconds = clock.perf_counter() - begun
        answer.print_answer(answer.pictured(solution, method, look, told, seconds, html))


def _has_display(quiet) -> bool:
    """Return whether a window can be opened, and remark where not."""
    from radiosity.view.window import display_available

    if display_available():
        return True
    remark("no display: the picture is gathered and written instead of shown", quiet)
    return False


def _opened(scene, solve, camera, size, samples, looked):
    """Show a window until it is closed; return the solution, None where there is none yet."""
    from radiosity.view.tones import Tones
    from radiosity.view.window import show_solving

    def tones(solution):
        look = looked(solution)
        return Tones(look.exposure, look.scale)

    return show_solving(scene, solve, camera, size, samples=samples, tones=tones)


UNFINISHED = 130  # exit code where the window was closed before the scene was solved


def _leave(as_json):
    """End without an answer."""
    if as_json:
        answer.print_failure("the window was closed before the scene was solved", UNFINISHED)
    raise typer.Exit(UNFINISHED)
WINDOWS = "screenshot", "size", "samples", "false_colour", "method", "shadows"


def _check_page(context, path):
    """Refuse what a page does not take, and a place where none can be written."""
    from radiosity.transport.files import check_place

    for name in WINDOWS:
        if context.get_parameter_source(name).name == "COMMANDLINE":
            option = {"shadows": "no-shadows"}.get(name, name).replace("_", "-")
            raise ValueError(
                f"--{option} does nothing to a page, which shows gathered light, turns and has "
                "false colours of its own: leave it out beside --html"
            )
    if Path(path).suffix.lower() != ".html":
        raise ValueError(f"--html {path!r}: a page's name must end in .html")
    check_place(path)


def _write_page(solution, path, camera, exposure, quiet):
    """Write the page, and remark on its size; return its exposure."""
    from radiosity.view.page.contents import page_exposure
    from radiosity.view.page.page import write_page

    shown = exposure.value or page_exposure(solution) * 2.0**exposure.stops
    with progress_bars(quiet) as progress:
        write_page(solution, path, camera=camera, exposure=shown, progress=progress)
    remark(f"wrote {path}: {Path(path).stat().st_size / 1e6:.1f} MB, for any browser", quiet)
    return shown
