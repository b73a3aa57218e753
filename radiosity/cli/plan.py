"""``radiosity plan``."""

from radiosity.cli import options as o
from radiosity.cli.session import Reading, load_scene


def plan(
    scene: o.SceneFile,
    accuracy: o.Accuracy = 0.02,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
    mesh: o.Mesh = "auto",
    order: o.Order = None,
    solver: o.Solver = "gauss-seidel",
    ambient: o.Ambient = 0.0,
    force: o.Force = False,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
    as_json: o.Json = False,
) -> None:
    """Say what a scene requires to be modelled, what is skipped, and the time and memory it takes.

    The first, coarse meshes are tried, of many faces a small share of the rays.

    Example: radiosity plan scenes/cornell_box.toml --accuracy 0.01
    """
    model = load_scene(scene, mesh, Reading(bands, ambient, unit, up), quiet, accuracy)
    o.use_threads(threads)
    from radiosity.solve.plan import make_plan
    from radiosity.solve.requirements import foresee

    planned = make_plan(model, accuracy, mesh, order=order, solver=solver, force=force)
    forecast = foresee(model, planned)
    print(_as_json(forecast) if as_json else table(forecast, model.name))


def table(forecast, name: str) -> str:
    """Return the decisions and what they will cost as text."""
    from radiosity.solve.plan import size_text

    lines = [f"{name} at an accuracy of {o.percent(forecast.plan.accuracy)}", ""]
    for r in forecast.requirements:
        lines.append(f"{r.name:17}{r.model:18}{r.reason}")
    lines += [
        "",
        f"{'patches':17}about {forecast.patches}",
        f"{'time':17}about {forecast.seconds:.2g} s, start-up left out",
        f"{'memory':17}about {size_text(forecast.memory)}",
    ]
    return "\n".join(lines)


def _as_json(forecast) -> str:
    import json
    from dataclasses import asdict

    return json.dumps(
        {
            "accuracy": forecast.plan.accuracy,
            "requirements": [asdict(r) for r in forecast.requirements],
            "patches": forecast.patches,
            "seconds": forecast.seconds,
            "memory_bytes": int(forecast.memory),
        }
    )
