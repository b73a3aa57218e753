"""``radiosity plan``."""

from dataclasses import asdict

from radiosity.cli import options as o
from radiosity.cli.answer import print_answer
from radiosity.cli.session import Reading, load_scene


def plan(
    scene: o.SceneFile,
    as_json: o.Json = False,
    accuracy: o.Accuracy = 0.02,
    mesh: o.Mesh = "auto",
    order: o.Order = None,
    solver: o.Solver = "gauss-seidel",
    force: o.Force = False,
    ambient: o.Ambient = 0.0,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
) -> None:
    """Say what a scene requires to be modelled, what is skipped and why, and what it will cost.

    Printed are the decisions, each with its reason, and the patches, the time and the memory that
    are expected. For that the first, coarse meshes are tried; of many faces, a small share of the
    rays.

    Examples
    --------
    radiosity plan scenes/cornell_box.toml
    radiosity plan scenes/cornell_box.toml --accuracy 0.01 --json
    """
    from radiosity.solve.forecast import plan as forecast_of

    model = load_scene(scene, mesh, Reading(bands, ambient, unit, up), quiet, accuracy)
    o.use_threads(threads)
    forecast = forecast_of(model, accuracy, mesh=mesh, order=order, solver=solver, force=force)
    if as_json:
        print_answer(facts(forecast, model.name))
    else:
        print(table(forecast, model.name))


def table(forecast, name: str) -> str:
    """Return the decisions and what they will cost as text."""
    return f"{name} at an accuracy of {o.percent(forecast.plan.accuracy)}\n\n{forecast}"


def facts(forecast, name: str) -> dict:
    """Return what `table` tells, for JSON."""
    return {
        "scene": name,
        "accuracy": forecast.plan.accuracy,
        "requirements": [asdict(r) for r in forecast.requirements],
        "patches": int(forecast.patches),
        "seconds": float(forecast.seconds),
        "memory_bytes": int(forecast.memory),
    }
