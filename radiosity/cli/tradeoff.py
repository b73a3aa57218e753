"""``radiosity tradeoff``."""

from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import options as o
from radiosity.cli.progress import remark
from radiosity.cli.session import Reading, load_scene

HEAD = ("way", "asked", "patches", "time s", "factors MB", "estimated", "true error")
WIDTHS = (26, 8, 9, 9, 12, 11, 12)
PICTURE_HEAD = ("picture by", "time s", "error, rms", "  file")
PICTURE_WIDTHS = (26, 9, 12, 0)


def tradeoff(
    scene: o.SceneFile,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", help="Plot; SCENE_tradeoff.png here if not given."),
    ] = None,
    accuracy: Annotated[
        float,
        typer.Option(
            "--accuracy", metavar="EPS", parser=o.number, help="The best that is asked: 0.001."
        ),
    ] = 0.003,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
    ambient: o.Ambient = 0.0,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
    as_json: o.Json = False,
) -> None:
    """Measure speed against accuracy on this machine: two tables, a log-log plot and pictures.

    The true error is that against a solution far finer than the best that is asked. Pictures of the
    first camera by --method gather, raytrace and local are written beside the plot.

    Example: radiosity tradeoff scenes/cornell_box.toml --accuracy 0.01
    """
    from radiosity.transport.files import check_place

    target = output or f"{Path(scene).stem}_tradeoff.png"
    if Path(target).suffix.lower() not in (".png", ".pdf", ".svg"):
        raise ValueError(f"-o {target!r} must end in .png, .pdf or .svg")
    check_place(target)
    if not 1e-3 <= accuracy <= 0.1:
        raise ValueError(
            f"--accuracy {accuracy:g} must lie in [0.001, 0.1] here: 0.01 measures from 10 % to 1 %"
        )
    model = load_scene(scene, "auto", Reading(bands, ambient, unit, up), quiet, accuracy)
    o.use_threads(threads)
    from radiosity.solve.tradeoff import COMPARED, make_reference, trials
    from radiosity.view.levels import picture_trials
    from radiosity.view.plot import plot_tradeoff

    reference = make_reference(model, accuracy)
    remark(f"reference: {o.percent(reference.estimated)} estimated for 95 % of it", quiet)
    found = []
    if not as_json:
        print(_line(HEAD, WIDTHS))
    for trial in trials(model, accuracy, reference):
        found.append(trial)
        if not as_json:
            print(row(trial), flush=True)
    pictures, files = [], []
    for trial in picture_trials(model, max(COMPARED, accuracy), reference.solution):
        if not as_json and not pictures:
            print(_line(PICTURE_HEAD, PICTURE_WIDTHS))
        pictures.append(trial)
        files.append(_written(trial, target))
        if not as_json:
            print(picture_row(trial, files[-1]), flush=True)
    if as_json:
        print(_as_json(found, reference, target, pictures, files))
    plot_tradeoff(found, model.name, target, pictures)
    remark(f"wrote {target}", quiet)


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


def _as_json(found, reference, plot, pictures, files) -> str:
    import json
    from dataclasses import asdict

    shown = [
        {"way": t.way, "seconds": t.seconds, "error": t.error, "file": file}
        for t, file in zip(pictures, files, strict=True)
    ]
    return json.dumps({
        "reference": reference.estimated, "trials": [asdict(t) for t in found],
        "pictures": shown, "plot": plot,
    })  # fmt: skip
