"""``--method`` and ``--shadows``: which of three levels of light a picture models."""

from typing import Annotated

import typer

from radiosity.cli.options import use_threads
from radiosity.cli.session import Asked, scene_of, solve_scene

MethodOption = Annotated[
    str,
    typer.Option(
        "--method",
        metavar="gather|raytrace|local",
        help="All light, or only along mirrored and refracted lines, or local shading.",
    ),
]
ShadowsOption = Annotated[
    bool, typer.Option("--shadows/--no-shadows", help="Of lights, for --method local.")
]


def check_method(method: str, shadows: bool, asked: Asked) -> None:
    """Raise ValueError where options contradict each other.

    Options that only a solution knows are refused where none is made.
    """
    from radiosity.view import methods

    if method not in methods.METHODS:
        raise ValueError(f"--method {method!r} must be one of {', '.join(methods.METHODS)}")
    if not shadows and method != "local":
        raise ValueError(
            f"--no-shadows belongs to --method local: {method} always models the shadows of lights"
        )
    given = {
        "--mesh": asked.mesh != "auto", "--order": asked.order is not None,
        "--solver": asked.solver != "gauss-seidel", "--force": asked.force,
        "--time": asked.time is not None, "--memory": asked.memory is not None,
    }  # fmt: skip
    for option in [name for name, used in given.items() if used]:
        if method != "gather":
            raise ValueError(
                f"{option} belongs to --method gather: {method} solves nothing; leave it out"
            )


def view_by(method: str, shadows: bool, given, asked: Asked, progress, watch=None):
    """Return what pictures of a scene are made of: its solution, or what stands for one.

    ``watch(solution)`` is shown what a solver has found so far.
    """
    if method == "gather":
        return solve_scene(given, asked, progress, watch=watch)
    from radiosity.view.methods import make_stage

    use_threads(asked.threads)
    accuracy, seed, scene = asked.accuracy, asked.seed, scene_of(given)
    if scene is not given:
        accuracy, seed = given.plan.accuracy, given.seed
    return make_stage(scene, method == "local", shadows=shadows, accuracy=accuracy, seed=seed)
