"""``radiosity view``."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import display as d
from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.method import MethodOption, ShadowsOption, check_method, view_by
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import Asked, Reading, scene_of


def view(
    context: typer.Context,
    scene: o.SceneFile,
    camera: o.CameraName = None,
    size: o.Size = None,
    screenshot: Annotated[
        str | None,
        typer.Option("--screenshot", help="Write the gathered picture here and open no window."),
    ] = None,
    html: Annotated[
        str | None,
        typer.Option(
            "--html", metavar="OUT.html",
            help="Write a page here that shows the solution in any browser, and open no window.",
        ),
    ] = None,
    samples: o.Samples = None,
    exposure: d.ExposureOption = "auto",
    false_colour: d.FalseColourOption = None,
    method: MethodOption = "gather",
    shadows: ShadowsOption = True,
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
    quiet: o.Quiet = False,
) -> None:
    """Solve a scene and look at it in an interactive window, or write a page that shows it.

    Without a display the gathered picture is written instead.

    Example: radiosity view scenes/cornell_box.toml
    """
    from radiosity.cli.render import noise_words
    from radiosity.transport.files import check_place
    from radiosity.view.gather import find_camera, picture_size, render
    from radiosity.view.image import write
    from radiosity.view.window import display_available, show

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
    shown = screenshot is None and html is None and display_available()
    with progress_bars(quiet) as progress:
        solution = view_by(method, shadows, given, asked, progress)
        if html is not None:
            _write_page(solution, html, chosen, exposure, quiet, progress)
            return
        if not shown:
            image = render(solution, chosen, size=pixels, samples=samples, progress=progress)
    scale = false_colour and false_colour.of(solution)
    if shown:
        show(solution, chosen, pixels, samples=samples, exposure=exposure.of(solution), scale=scale)
        return
    if screenshot is None:
        remark("no display: the picture is gathered and written instead of shown", quiet)
    write(replace(image, exposure=exposure.of(solution)), target, scale=scale)
    remark(f"wrote {target}{noise_words(image)}", quiet)


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


def _write_page(solution, path, camera, exposure, quiet, progress):
    """Write the page, and remark on its size."""
    from radiosity.view.page.page import write_page

    shown = {"exposure": exposure.value, "stops": exposure.stops}
    write_page(solution, path, camera=camera, **shown, progress=progress)
    remark(f"wrote {path}: {Path(path).stat().st_size / 1e6:.1f} MB, for any browser", quiet)
