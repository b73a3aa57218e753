"""``radiosity render``."""

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

PICTURES = ".png", ".exr", ".hdr", ".npy"
FORBIDDEN = '/\\<>:"|?*'  # in file names, here or on other systems


def render(
    context: typer.Context,
    scene: o.SceneFile,
    output: Annotated[
        str,
        typer.Option(
            "-o", "--output", metavar="FILE",
            help="Picture: .png for the eye, or .exr, .hdr, .npy with linear radiance.",
            autocompletion=completion.files(*PICTURES),
            rich_help_panel=o.OUTPUT,
        ),
    ],
    as_json: o.Json = False,
    camera: o.CameraName = None,
    all_cameras: Annotated[
        bool,
        typer.Option(
            "--all",
            help="Every camera, solved once: -o room.png is room-NAME.png each.",
            rich_help_panel=o.PICTURE,
        ),
    ] = False,
    size: o.Size = None,
    samples: o.Samples = None,
    method: MethodOption = "gather",
    shadows: ShadowsOption = True,
    exposure: d.ExposureOption = "auto",
    false_colour: d.FalseColourOption = None,
    gamma: Annotated[
        float | None,
        typer.Option(
            "--gamma", metavar="G", parser=o.number,
            help="Exponent of the screen for .png; if not given, sRGB's curve.",
            rich_help_panel=o.PICTURE,
        ),
    ] = None,
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
    """Write a camera's picture: soft shadows, interreflection and highlights, gathered per pixel.

    Told on stderr are the exposure, and the noise that is estimated to be left.

    Examples
    --------
    radiosity render scenes/cornell_box.toml -o cornell.png --size 128x128
    radiosity render scenes/lroom.toml --all --false-colour log:1000 -o lroom.png --size 64x64
    radiosity render scenes/mirror_room.toml -o quick.png --size 96x96 --method raytrace
    radiosity render scenes/office.toml -o dimmed.exr --dim desk=0.3 --size 64x64 --accuracy 0.1
    """
    from radiosity.transport.files import check_place
    from radiosity.view.gather import picture_size

    begun = clock.perf_counter()
    d.check_display(output, exposure, gamma, false_colour)
    check_place(output)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    check_method(method, shadows, asked)
    given = load_given(context, scene, asked, Reading(bands, ambient, unit, up), dim)
    model = scene_of(given)
    views = _views(model, camera, all_cameras, Path(output))
    pixels = o.parse_size(size)
    for chosen, path in views:
        picture_size(chosen, pixels, model.bands)
        check_place(path)
    with progress_bars(quiet) as progress:
        solution = view_by(method, shadows, given, asked, progress)
    look = d.Look.of(solution, exposure, false_colour, gamma)
    told = [
        rendered(solution, chosen, path, pixels, samples, look, quiet) for chosen, path in views
    ]
    if as_json:
        answer.print_answer(
            answer.pictured(solution, method, look, told, clock.perf_counter() - begun)
        )


def rendered(solution, camera, path, size, samples, look, quiet) -> dict:
    """Gather and write a camera's picture; return what is told of it."""
    from radiosity.view.gather import render as gather
    from radiosity.view.image import write

    with progress_bars(quiet) as progress:
        image = gather(solution, camera, size=size, samples=samples, progress=progress)
    image = replace(image, exposure=look.exposure)
    write(image, path, look.gamma, look.scale)
    if image.outside and look.scale is None:
        remark(f"note: {outside_line(image)}", quiet)
    remark(f"wrote {path}{_told(path, image, look.scale)}{noise_words(image)}", quiet)
    return answer.picture(camera, path, image)


def _views(scene, camera, all_cameras, output) -> list:
    """Return the cameras to render, each with its file."""
    from radiosity.view.gather import find_camera

    if not all_cameras:
        return [(find_camera(scene, camera), output)]
    if camera is not None:
        raise ValueError(f"--camera {camera} and --all exclude each other: give one of them")
    _check_names(scene.cameras)
    return [
        (each, output.with_name(f"{output.stem}-{name}{output.suffix}"))
        for name, each in scene.cameras.items()
    ]


def _check_names(names):
    """Raise ValueError where cameras' names cannot be parts of files' names, or of the same one."""
    seen = {}
    for name in names:
        bad = [c for c in name if c in FORBIDDEN or not c.isprintable()]
        if bad or not name.strip():
            what = f"holds {bad[0]!r}" if bad else "is blank"
            raise ValueError(
                f"--all: the camera's name {name!r} {what}, which file names cannot: rename it in "
                "the scene file or render it by --camera"
            )
        same = seen.setdefault(name.casefold(), name)
        if same != name:
            raise ValueError(
                f"--all: the cameras {same!r} and {name!r} differ in case only, which some systems "
                "take for one file: rename one or render them by --camera"
            )


def _told(path, image, scale) -> str:
    """Return the exposure of a picture for the eye, to be given again."""
    if path.suffix.lower() != ".png" or scale is not None:
        return ""
    return f", exposure {image.exposure:.4g}"


def noise_words(image) -> str:
    """Return the estimated noise of a picture, "" where it is not known."""
    if image.noise is None:
        return ""
    return f": noise {o.percent(image.noise)} of the mean luminance, rms, estimated"


def outside_line(image) -> str:
    """Return how many pixels a screen cannot show, and what became of them."""
    share = image.outside / image.pixels[..., 0].size
    return (
        f"{image.outside} pixels ({o.percent(share)}) lie outside of sRGB: .exr and .npy keep "
        "them, .png greys them"
    )
