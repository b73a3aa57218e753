"""``radiosity view``."""

import time as clock
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
    with progress_bars(quiet) as progress:
        solution = view_by(method, shadows, given, asked, progress)
    look, told = d.Look.of(solution, exposure, false_colour), []
    if html is not None:
        _write_page(solution, html, chosen, look.exposure, quiet)
    elif screenshot is None and _opened(solution, chosen, pixels, samples, look):
        pass
    else:
        if screenshot is None:
            remark("no display: the picture is gathered and written instead of shown", quiet)
        told.append(rendered(solution, chosen, Path(target), pixels, samples, look, quiet))
    if as_json:
        seconds = clock.perf_counter() - begun
        answer.print_answer(answer.pictured(solution, method, look, told, seconds, html))


def _opened(solution, camera, size, samples, look) -> bool:
    """Show a window until it is closed; return False where none can be opened."""
    from radiosity.view.window import display_available, show

    if not display_available():
        return False
    show(solution, camera, size, samples=samples, exposure=look.exposure, scale=look.scale)
    return True


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
    if Path(path).suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"--html {path!r}: a page's name must end in .html")
    check_place(path)


def _write_page(solution, path, camera, exposure, quiet):
    """Write the page, and remark on its size."""
    from radiosity.view.page.page import write_page

    with progress_bars(quiet) as progress:
        write_page(solution, path, camera=camera, exposure=exposure, progress=progress)
    remark(f"wrote {path}: {Path(path).stat().st_size / 1e6:.1f} MB, for any browser", quiet)
