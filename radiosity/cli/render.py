"""``radiosity render``."""

from typing import Annotated

import typer

from radiosity.cli import options as o
from radiosity.cli.method import MethodOption, ShadowsOption, check_method, view_by
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import Asked, load_scene


def render(
    scene: o.SceneFile,
    output: Annotated[
        str, typer.Option("-o", "--output", help="Picture: .png, or linear .exr, .hdr, .npy.")
    ],
    camera: o.CameraName = None,
    size: o.Size = None,
    samples: o.Samples = None,
    gamma: Annotated[
        float | None,
        typer.Option(
            "--gamma", metavar="G", parser=o.number, help="Of the screen, instead of sRGB: .png."
        ),
    ] = None,
    method: MethodOption = "gather",
    shadows: ShadowsOption = True,
    accuracy: o.Accuracy = 0.02,
    bands: o.Bands = "auto",
    mesh: o.Mesh = "auto",
    order: o.Order = None,
    solver: o.Solver = "gauss-seidel",
    force: o.Force = False,
    time: o.Time = None,
    seed: o.Seed = 0,
    ambient: o.Ambient = 0.0,
    memory: o.Memory = None,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
) -> None:
    """Gather a camera's picture: soft shadows, interreflection and highlights, per pixel.

    Example: radiosity render scenes/cornell_box.toml -o cornell.png --size 512x512
    """
    from radiosity.transport.files import check_place
    from radiosity.view.gather import find_camera, picture_size
    from radiosity.view.gather import render as gather
    from radiosity.view.image import check_suffix, write

    check_suffix(output, gamma)
    check_place(output)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    check_method(method, shadows, asked)
    model = load_scene(scene, mesh, ambient, quiet, bands, accuracy)
    chosen = find_camera(model, camera)
    pixels = picture_size(chosen, o.parse_size(size), model.bands)
    with progress_bars(quiet) as progress:
        solution = view_by(method, shadows, model, asked, progress)
        image = gather(solution, chosen, size=pixels, samples=samples, progress=progress)
    write(image, output, gamma)
    if image.outside:
        remark(f"note: {outside_line(image)}", quiet)
    remark(f"wrote {output}{noise_words(image)}", quiet)


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
