"""``radiosity tradeoff``."""

import time as clock
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import options as o
from radiosity.cli.answer import print_answer
from radiosity.cli.progress import remark
from radiosity.cli.session import Reading, load_scene

HEAD = ("way", "asked", "patches", "time s", "factors MB", "estimated", "true error")
WIDTHS = (26, 8, 9, 9, 12, 11, 12)
PICTURE_HEAD = ("picture by", "time s", "error, rms", "  file")
PICTURE_WIDTHS = (26, 9, 12, 0)
SOLVER_HEAD = ("solver", "iterations", "time s", "error bound")
SOLVER_WIDTHS = (16, 12, 10, 13)
BEST, OF_SOLVERS = 0.003, 0.02  # accuracies by default


def tradeoff(
    scene: o.SceneFile,
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="FILE",
            help="Plot: .png, .pdf or .svg; if not given, SCENE_tradeoff.png (SCENE_solvers.png) "
            "in this folder.",
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    as_json: o.Json = False,
    solvers: Annotated[
        bool,
        typer.Option(
            "--solvers",
            help="Instead: all solvers on one mesh of constant elements, with a plot of their "
            "convergence. In one band, unless --bands says otherwise.",
            rich_help_panel=o.SOLVING,
        ),
    ] = False,
    accuracy: Annotated[
        float | None,
        typer.Option(
            "--accuracy", metavar="EPS", parser=o.number,
            help="The best that is asked, from 0.001 to 0.1; if not given, 0.003, or 0.02 with "
            "--solvers.",
            rich_help_panel=o.SOLVING,
        ),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(
            "--size", metavar="WxH",
            help="Pixels of the pictures; if not given, the camera's, at most 160 a side.",
            rich_help_panel=o.PICTURE,
        ),
    ] = None,
    ambient: o.Ambient = 0.0,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
) -> None:
    """Measure speed against accuracy on this machine: tables, a plot and pictures.

    Printed are time, memory, estimated and true error of accuracies from 10 % down to the best that
    is asked, of kinds of elements, solvers and --force; the true error is that against a solution
    far finer. Pictures of the first camera by --method gather, raytrace and local are written
    beside the plot.

    Examples
    --------
    radiosity tradeoff scenes/box6.toml --accuracy 0.05 --size 64x64
    radiosity tradeoff scenes/box6.toml --solvers -o solvers.png
    """
    begun, asked = clock.perf_counter(), accuracy
    if asked is None:
        asked = OF_SOLVERS if solvers else BEST
    target = output or f"{Path(scene).stem}_{'solvers' if solvers else 'tradeoff'}.png"
    o.check_plot("-o", target)
    pixels = _picture_size(size, solvers)
    if not 1e-3 <= asked <= 0.1:
        raise ValueError(
            f"--accuracy {asked:g} must lie in [0.001, 0.1] here: 0.01 measures from 10 % to 1 %"
        )
    if solvers and bands == "auto":
        bands = "grey"
    model = load_scene(scene, "auto", Reading(bands, ambient, unit, up), quiet, asked)
    o.use_threads(threads)
    measure = _compare_solvers if solvers else partial(_measure, pixels)
    told = measure(model, asked, target, _keep_quiet if as_json else _say, quiet)
    remark(f"wrote {target}", quiet)
    if as_json:
        written = [target, *(picture["file"] for picture in told.get("pictures", []))]
        print_answer({
            "scene": model.name, "accuracy": asked, **NOTHING, **told, "plot": target,
            "seconds": clock.perf_counter() - begun, "written": written,
        })  # fmt: skip


def _picture_size(text, solvers):
    """Return (w, h) of the pictures as typed, None for the default."""
    if solvers and text is not None:
        raise ValueError("--size is of pictures, and --solvers makes none: leave one of them out")
    return o.parse_size(text)


NOTHING = {"reference": None, "trials": [], "pictures": [], "solvers": []}


def _measure(size, model, accuracy, target, say, quiet) -> dict:
    """Return trials and pictures, shown as they come; write plot and pictures."""
    from radiosity.solve.tradeoff import make_reference, trials
    from radiosity.view.plot import plot_tradeoff

    reference = make_reference(model, accuracy)
    remark(f"reference: {o.percent(reference.estimated)} estimated for 95 % of it", quiet)
    say(_line(HEAD, WIDTHS))
    found = []
    for trial in trials(model, accuracy, reference):
        found.append(trial)
        say(row(trial))
    pictures, told = _pictures(model, accuracy, reference, target, size, say)
    plot_tradeoff(found, model.name, target, pictures)
    return {
        "reference": reference.estimated, "trials": [asdict(t) for t in found], "pictures": told,
    }  # fmt: skip


def _pictures(model, accuracy, reference, target, size, say):
    """Return the trials of pictures, and what is told of them; write the pictures."""
    from radiosity.solve.tradeoff import COMPARED
    from radiosity.view.levels import picture_trials

    pictures, told = [], []
    say(_line(PICTURE_HEAD, PICTURE_WIDTHS))
    coarse = max(COMPARED, accuracy)
    for trial in picture_trials(model, coarse, reference.solution, size):
        file = _written(trial, target)
        pictures.append(trial)
        told.append({
            "way": trial.way, "seconds": trial.seconds, "error": trial.error, "file": file,
        })  # fmt: skip
        say(picture_row(trial, file))
    return pictures, told


def _compare_solvers(model, accuracy, target, say, quiet) -> dict:
    """Return all solvers on one mesh, shown as they come; write the plot."""
    from radiosity.solve.solve import solve
    from radiosity.solve.tradeoff import solver_trials
    from radiosity.view.plot import plot_histories

    solution = solve(model, accuracy, order=0)
    found, count = [], len(solution.patches)
    remark(f"solved {model.name}: {count} patches, constant elements", quiet)
    say(_line(SOLVER_HEAD, SOLVER_WIDTHS))
    for trial in solver_trials(solution):
        found.append(trial)
        say(solver_row(trial))
    iterate = [t for t in found if len(t.history) > 1] or found
    histories, tolerance = {t.solver: t.history for t in iterate}, solution.level.recipe.tolerance
    plot_histories(histories, model.name, target, tolerance)
    told = [asdict(t) | {"patches": count, "iterations": len(t.history)} for t in found]
    return {"solvers": told}


def _say(line: str):
    print(line, flush=True)


def _keep_quiet(line: str):
    """Say nothing: stdout is for the object."""


def solver_row(trial) -> str:
    """Return a solver's trial as one line of the table."""
    cells = (
        trial.solver, str(len(trial.history)), f"{trial.seconds:.3g}", f"{trial.history[-1]:.1e}",
    )  # fmt: skip
    return _line(cells, SOLVER_WIDTHS)


def _written(trial, plot) -> str:
    """Write the picture of a trial beside the plot and return its name."""
    from radiosity.view.image import write

    name = trial.way.replace(", ", "-").replace(" ", "-")
    path = str(Path(plot).with_name(f"{Path(plot).stem}-{name}.png"))
    write(trial.image, path)
    return path


def picture_row(trial, file: str) -> str:
    """Return a picture's trial as one line of the table."""
    cells = trial.way, f"{trial.seconds:.3g}", o.percent(trial.error), "  " + file
    return _line(cells, PICTURE_WIDTHS)


def _line(cells, widths) -> str:
    return "".join(f"{c:{'<' if k == 0 else '>'}{widths[k]}}" for k, c in enumerate(cells))


def row(trial) -> str:
    """Return a trial as one line of the table."""
    cells = (
        trial.way, o.percent(trial.accuracy), str(trial.patches), f"{trial.seconds:.3g}",
        f"{trial.memory / 1e6:.3g}", o.percent(trial.estimated), o.percent(trial.error),
    )  # fmt: skip
    return _line(cells, WIDTHS)
