"""``radiosity view``."""

import time as clock
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import answer, completion
from radiosity.cli import display as d
from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.method import MethodOption, ShadowsOption, check_method, view_by
from radiosity.cli.progress import progress_bars, remark
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
    """Solve a scene and look at it in an interactive window.

    Without a display the gathered picture of the camera is written instead, as SCENE.png in this
    folder if --screenshot does not name a file.

    Examples
    --------
    radiosity view scenes/cornell_box.toml
    radiosity view scenes/lroom.toml --screenshot lroom.png --size 96x64 --false-colour auto
    """
    from radiosity.cli.render import noise_words
    from radiosity.transport.files import check_place
    from radiosity.view.gather import find_camera, picture_size, render
    from radiosity.view.image import write
    from radiosity.view.window import display_available, show

    begun = clock.perf_counter()
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
    shown = screenshot is None and display_available()
    with progress_bars(quiet) as progress:
        solution = view_by(method, shadows, given, asked, progress)
        if not shown:
            image = render(solution, chosen, size=pixels, samples=samples, progress=progress)
    look, told = d.Look.of(solution, exposure, false_colour), []
    if shown:
        show(
            solution, chosen, pixels, samples=samples, exposure=look.exposure, scale=look.scale
        )
    else:
        if screenshot is None:
            remark("no display: the picture is gathered and written instead of shown", quiet)
        image = replace(image, exposure=look.exposure)
        write(image, target, scale=look.scale)
        told.append(answer.picture(chosen, target, image))
        remark(f"wrote {target}{noise_words(image)}", quiet)
    if as_json:
        answer.print_answer(
            answer.pictured(solution, method, look, told, clock.perf_counter() - begun)
        )
