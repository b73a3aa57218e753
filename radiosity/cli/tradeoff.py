"""``radiosity tradeoff``."""

from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import options as o
from radiosity.cli.progress import remark
from radiosity.cli.session import load_scene

HEAD = ("way", "asked", "patches", "time s", "factors MB", "estimated", "true error")
WIDTHS = (26, 8, 9, 9, 12, 11, 12)


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
    ambient: o.Ambient = 0.0,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
    as_json: o.Json = False,
) -> None:
    """Measure speed against accuracy on this machine: a table, and a log-log plot.

    The true error is that against a solution far finer than the best that is asked.

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
    model = load_scene(scene, "auto", ambient, quiet, bands, accuracy)
    o.use_threads(threads)
    from radiosity.solve.tradeoff import make_reference, trials
    from radiosity.view.plot import plot_tradeoff

    reference = make_reference(model, accuracy)
    remark(f"reference: {o.percent(reference.estimated)} estimated for 95 % of it", quiet)
    found = []
    if not as_json:
        print("".join(f"{h:{'<' if k == 0 else '>'}{WIDTHS[k]}}" for k, h in enumerate(HEAD)))
    for trial in trials(model, accuracy, reference):
        found.append(trial)
        if not as_json:
            print(row(trial), flush=True)
    if as_json:
        print(_as_json(found, reference, target))
    plot_tradeoff(found, model.name, target)
    remark(f"wrote {target}", quiet)


def row(trial) -> str:
    """Return a trial as one line of the table."""
    cells = (
        trial.way, o.percent(trial.accuracy), str(trial.patches), f"{trial.seconds:.3g}",
        f"{trial.memory / 1e6:.3g}", o.percent(trial.estimated), o.percent(trial.error),
    )  # fmt: skip
    return "".join(f"{c:{'<' if k == 0 else '>'}{WIDTHS[k]}}" for k, c in enumerate(cells))


def _as_json(found, reference, plot) -> str:
    import json
    from dataclasses import asdict

    return json.dumps(
        {"reference": reference.estimated, "trials": [asdict(t) for t in found], "plot": plot}
    )
