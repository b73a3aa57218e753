"""Options that several verbs share, and what they parse to."""

import os
import re
from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import completion

# Panels of the help.
OUTPUT, PICTURE, POINTS = "Output", "Camera and picture", "Points"
SOLVING, LIGHT, READING = "Accuracy and solving", "Light", "Reading the scene"


def with_point(text: str) -> str:
    """Return a hint where a number was typed with a comma, "" otherwise."""
    return f": write {text.replace(',', '.')}" if re.fullmatch(r"\D*\d+,\d+\D*", text) else ""


def number(text: str) -> float:
    """Return a number, or name what was typed."""
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a number{with_point(text)}") from None


def at_least(least: int):
    """Return a parser of whole numbers that names what was typed."""

    def whole(text: str) -> int:
        if not (str(text).isascii() and str(text).isdecimal() and least <= int(text) < 2**32):
            raise typer.BadParameter(f"{text!r} is not a whole number from {least} to 4294967295")
        return int(text)

    return whole


def order_of_elements(text: str) -> int:
    """Return 0 or 1, or name what was typed."""
    if text not in ("0", "1"):
        raise typer.BadParameter(f"{text!r} must be 0 (constant) or 1 (linear elements)")
    return int(text)


SceneFile = Annotated[
    str,
    typer.Argument(
        metavar="SCENE",
        help="Scene file (.toml), bare geometry (.glb, .gltf, .obj, .ply, .stl, .rad) or a "
        "solution (.radsol).",
        autocompletion=completion.files(*completion.SCENES),
    ),
]
Accuracy = Annotated[
    float,
    typer.Option(
        "--accuracy",
        metavar="EPS",
        parser=number,
        help="Relative error to aim at, from 0.0001 to below 1: 0.02 is 2 %. It chooses mesh, rays "
        "and solver tolerance.",
        rich_help_panel=SOLVING,
    ),
]
Mesh = Annotated[
    str,
    typer.Option(
        "--mesh",
        metavar="auto|input|N",
        help="Patches: chosen for the accuracy, the file's faces as they are, or N x N a face.",
        autocompletion=completion.words("auto", "input"),
        rich_help_panel=SOLVING,
    ),
]
Order = Annotated[
    int | None,
    typer.Option(
        "--order",
        metavar="0|1",
        parser=order_of_elements,
        help="Constant (0) or linear (1) elements. If not given: 1 for --mesh auto unless that is "
        "too large, else 0.",
        autocompletion=completion.words("0", "1"),
        rich_help_panel=SOLVING,
    ),
]
Solver = Annotated[
    str,
    typer.Option(
        "--solver",
        metavar="NAME",
        help="gauss-seidel, jacobi, southwell, gmres, cg (for --order 0) or direct.",
        autocompletion=completion.solvers,
        rich_help_panel=SOLVING,
    ),
]
Bands = Annotated[
    str,
    typer.Option(
        "--bands",
        metavar="auto|grey|rgb|spectral|N",
        help="Colours: one band (grey), three (rgb), or wavelengths (N of them) where spectra are "
        "given.",
        autocompletion=completion.words("auto", "grey", "rgb", "spectral"),
        rich_help_panel=READING,
    ),
]
Unit = Annotated[
    str | None,
    typer.Option(
        "--unit",
        metavar="m|cm|mm|in|ft",
        help="Unit of length of a bare geometry file; if not given, metres.",
        autocompletion=completion.words("m", "cm", "mm", "in", "ft"),
        rich_help_panel=READING,
    ),
]
Up = Annotated[
    str | None,
    typer.Option(
        "--up",
        metavar="x|y|z",
        help="Axis that points up in a bare geometry file; if not given, z (y of glTF).",
        autocompletion=completion.words("x", "y", "z"),
        rich_help_panel=READING,
    ),
]
Force = Annotated[
    bool,
    typer.Option(
        "--force",
        help="Model everything, also what the scene does not require.",
        rich_help_panel=SOLVING,
    ),
]
Time = Annotated[
    str | None,
    typer.Option(
        "--time",
        metavar="10s",
        help="Instead of an accuracy: the best answer by then, with its error; in s, min or h.",
        rich_help_panel=SOLVING,
    ),
]
Seed = Annotated[
    int,
    typer.Option(
        "--seed",
        metavar="N",
        parser=at_least(0),
        help="Seed of all sample patterns.",
        rich_help_panel=SOLVING,
    ),
]
Ambient = Annotated[
    float,
    typer.Option(
        "--ambient",
        metavar="L",
        parser=number,
        help="Radiance in W/(m2 sr) that enters open scenes from all around.",
        rich_help_panel=LIGHT,
    ),
]
Dim = Annotated[
    list[str] | None,
    typer.Option(
        "--dim",
        metavar="NAME=FACTOR",
        help="Scale a light group: 0 is off. NAME is that of lights (as info tells it), of a "
        "material that emits, or ambient. Repeatable.",
        autocompletion=completion.light_groups,
        rich_help_panel=LIGHT,
    ),
]
Memory = Annotated[
    str | None,
    typer.Option(
        "--memory",
        metavar="4GB",
        help="Most memory to use beside the program's own 0.2 GB; if not given, half of what is "
        "free.",
    ),
]
Threads = Annotated[
    int | None,
    typer.Option(
        "--threads", metavar="N", parser=at_least(1), help="Cores to use; if not given, all."
    ),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", help="No progress bars and no remarks on stderr; errors remain.")
]
Json = Annotated[
    bool,
    typer.Option(
        "--json",
        help="Print one machine-readable object on stdout, as docs/json.md describes it.",
        rich_help_panel=OUTPUT,
    ),
]
CameraName = Annotated[
    str | None,
    typer.Option(
        "--camera",
        metavar="NAME",
        help="Camera of the scene; if not given, its first.",
        autocompletion=completion.cameras,
        rich_help_panel=PICTURE,
    ),
]
Size = Annotated[
    str | None,
    typer.Option(
        "--size",
        metavar="WxH",
        help="Width and height in pixels; if not given, the camera's own.",
        rich_help_panel=PICTURE,
    ),
]
Samples = Annotated[
    int | None,
    typer.Option(
        "--samples", metavar="N", parser=at_least(1),
        help="Rays over the hemisphere of each pixel; if not given, as --accuracy asks.",
        rich_help_panel=PICTURE,
    ),
]  # fmt: skip


def parse_size(text: str | None) -> tuple[int, int] | None:
    """Return (w, h) of ``512x512``; None stays None."""
    if text is None:
        return None
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text.strip().lower())
    size = tuple(int(v) for v in match.groups()) if match else (0, 0)
    if not all(1 <= v <= 16384 for v in size):
        raise ValueError(
            f"--size {text!r} must be WIDTHxHEIGHT, 1x1 to 16384x16384: --size 512x512"
        )
    return size


def parse_memory(text: str | None) -> float | None:
    """Return bytes of ``4GB``, ``500MB`` or ``4e9``; None stays None."""
    if text is None:
        return None
    match = re.fullmatch(r"([0-9.]+(?:e[0-9]+)?)\s*([kmgt]?)i?b?", text.strip().lower())
    try:
        return float(match[1]) * 1000.0 ** " kmgt".index(match[2] or " ")
    except (TypeError, ValueError):
        hint = with_point(text)
        raise ValueError(f"--memory {text!r} must be a size such as 4GB or 500MB{hint}") from None


def parse_dim(texts: list[str] | None) -> dict[str, float]:
    """Return the factors of ``lamps=0.5`` and the like by their names."""
    found = {}
    for text in texts or []:
        name, sign, factor = text.rpartition("=")
        try:
            value = float(factor)
        except ValueError:
            sign = ""
        if not sign or not name:
            hint = with_point(factor)
            raise ValueError(f"--dim {text!r} must be NAME=FACTOR, such as lamps=0.5{hint}")
        if name in found:
            raise ValueError(f"--dim names {name!r} twice: give it one factor")
        found[name] = value
    return found


def check_plot(option: str, path: str) -> None:
    """Refuse a plot that could not be written."""
    from radiosity.transport.files import check_place

    if Path(path).suffix.lower() not in (".png", ".pdf", ".svg"):
        raise ValueError(f"{option} {path!r} must end in .png, .pdf or .svg")
    check_place(path)


def percent(share: float) -> str:
    """Return a share as text, in percent of two digits."""
    return f"{100 * share:.2g} %"


def parse_time(text: str | None) -> float | None:
    """Return seconds of ``10s``, ``2min``, ``1h`` or ``10``; None stays None."""
    if text is None:
        return None
    match = re.fullmatch(r"([0-9]*\.?[0-9]+)\s*(s|min|h)?", text.strip().lower())
    unit = {"min": 60.0, "h": 3600.0}
    seconds = float(match[1]) * unit.get(match[2], 1.0) if match else 0.0
    if not 0.0 < seconds < float("inf"):
        hint = with_point(text)
        raise ValueError(f"--time {text!r} must be a time such as 10s, 2min or 1h{hint}")
    return seconds


def use_threads(count: int | None) -> None:
    """Let all later work run on so many cores."""
    if count is not None:
        os.environ["RADIOSITY_THREADS"] = str(count)
