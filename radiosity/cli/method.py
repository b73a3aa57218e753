"""``--method`` and ``--shadows``: which of three levels of light a picture models."""

from typing import Annotated

import typer

from radiosity.cli import completion
from radiosity.cli.options import PICTURE, use_threads
from radiosity.cli.session import Asked, scene_of, solve_scene

MethodOption = Annotated[
    str,
    typer.Option(
        "--method",
        metavar="gather|raytrace|local",
        help="All light (gather), light along mirrored and refracted lines only (raytrace), or "
        "local shading.",
        autocompletion=completion.words("gather", "raytrace", "local"),
        rich_help_panel=PICTURE,
    ),
]
ShadowsOption = Annotated[
    bool,
    typer.Option(
        "--shadows/--no-shadows",
        help="Whether lights cast shadows; without, for --method local.",
        rich_help_panel=PICTURE,
    ),
]


def check_method(method: str, shadows: bool, asked: Asked) -> None:
    """Raise ValueError where options contradict each other.

    Options that only a solution knows are refused where none is made.
    """
    from radiosity.view import methods

    methods.check_method(method, shadows)
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
