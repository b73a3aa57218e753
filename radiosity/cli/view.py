"""``radiosity view``."""

from dataclasses import replace
from functools import partial
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
    """Solve a scene and look at it in an interactive window.

    The window opens at once and shows light spreading while it is solved; key h lists its keys.
    Without a display the gathered picture is written instead.

    Example: radiosity view scenes/cornell_box.toml
    """
    from radiosity.cli.render import noise_words
    from radiosity.transport.files import check_place
    from radiosity.view.gather import find_camera, picture_size
    from radiosity.view.image import write
    from radiosity.view.window import display_available, show_solving

    target = screenshot or f"{Path(scene).stem}.png"
    d.check_display(target, exposure, None, false_colour)
    if screenshot:
        check_place(screenshot)
    pixels = o.parse_size(size)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    check_method(method, shadows, asked)
    given = load_given(context, scene, asked, Reading(bands, ambient, unit, up), dim)
    chosen = find_camera(scene_of(given), camera)
    picture_size(chosen, pixels, scene_of(given).bands)
    work = partial(view_by, method, shadows, given, asked)
    if screenshot is None and display_available():
        tones = _tones(exposure, false_colour)
        show_solving(scene_of(given), work, chosen, pixels, samples=samples, tones=tones)
        return
    image, scale = _gather(work, chosen, pixels, samples, exposure, false_colour, quiet)
    if screenshot is None:
        remark("no display: the picture is gathered and written instead of shown", quiet)
    write(image, target, scale=scale)
    remark(f"wrote {target}{noise_words(image)}", quiet)


def _tones(exposure, false_colour):
    """Return what tells how a solution is shown at first."""

    def tones(solution):
        from radiosity.view.tones import Tones

        return Tones(exposure.of(solution), false_colour and false_colour.of(solution))

    return tones


def _gather(work, camera, pixels, samples, exposure, false_colour, quiet):
    """Return the gathered picture, exposed, and the scale of its false colours."""
    from radiosity.view.gather import render

    with progress_bars(quiet) as progress:
        solution = work(progress)
        image = render(solution, camera, size=pixels, samples=samples, progress=progress)
    exposed = replace(image, exposure=exposure.of(solution))
    return exposed, false_colour and false_colour.of(solution)
