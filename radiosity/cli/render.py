"""``radiosity render``."""

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

FORBIDDEN = '/\\<>:"|?*'  # in file names, here or on other systems


def render(
    context: typer.Context,
    scene: o.SceneFile,
    output: Annotated[
        str, typer.Option("-o", "--output", help="Picture: .png, or linear .exr, .hdr, .npy.")
    ],
    camera: o.CameraName = None,
    all_cameras: Annotated[
        bool,
        typer.Option("--all", help="Every camera, solved once: -o room.png is room-NAME.png each."),
    ] = False,
    size: o.Size = None,
    samples: o.Samples = None,
    gamma: Annotated[
        float | None,
        typer.Option(
            "--gamma", metavar="G", parser=o.number, help="Of the screen, instead of sRGB: .png."
        ),
    ] = None,
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
    """Gather a camera's picture: soft shadows, interreflection and highlights, per pixel.

    Example: radiosity render scenes/cornell_box.toml -o cornell.png --size 512x512
    """
    from radiosity.transport.files import check_place
    from radiosity.view.gather import picture_size
    from radiosity.view.gather import render as gather
    from radiosity.view.image import write

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
    for chosen, path in views:
        with progress_bars(quiet) as progress:
            image = gather(solution, chosen, size=pixels, samples=samples, progress=progress)
        image = replace(image, exposure=exposure.of(solution))
        write(image, path, gamma, false_colour and false_colour.of(solution))
        if image.outside and false_colour is None:
            remark(f"note: {outside_line(image)}", quiet)
        remark(f"wrote {path}{_told(path, image, false_colour)}{noise_words(image)}", quiet)


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


def _told(path, image, false_colour) -> str:
    """Return the exposure of a picture for the eye, to be given again."""
    if path.suffix.lower() != ".png" or false_colour is not None:
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
