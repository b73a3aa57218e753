"""What a verb is given in place of SCENE: a scene to be solved, or a solution; and what is dimmed.

A solution knows how it was solved: options of solving are refused, not ignored.
"""

import typer

from radiosity.cli.options import parse_dim, parse_memory, use_threads
from radiosity.cli.progress import remark
from radiosity.cli.session import Asked, Reading, load_scene

SOLVING = (
    "accuracy", "bands", "mesh", "order", "solver", "force", "time", "seed", "ambient", "unit",
    "up", "factors",
)  # fmt: skip


def load_given(
    context: typer.Context, path: str, asked: Asked, reading: Reading, dim: list[str] | None
):
    """Return the scene of a file, or the solution that it holds, dimmed as asked.

    Raises
    ------
    ValueError
        Options of solving with a file that is solved; wrong names or factors of --dim.
    """
    from radiosity.scene.groups import dimmed
    from radiosity.solve.load import is_solved

    factors = parse_dim(dim)
    if not is_solved(path):
        scene = load_scene(path, asked.mesh, reading, asked.quiet, asked.accuracy)
        return dimmed(scene, factors)
    refuse_solving(context, path)
    use_threads(asked.threads)
    from radiosity.solve.container import read_solution

    solution = read_solution(path, parse_memory(asked.memory))
    for note in solution.scene.notes:
        remark(f"note: {note}", asked.quiet)
    remark(f"read {path}: {len(solution.patches)} patches, solved before", asked.quiet)
    return solution.dimmed(factors)


def refuse_solving(context: typer.Context, path: str) -> None:
    """Raise ValueError where options of solving were typed, for a file that is solved."""
    typed = [
        f"--{name}" for name in SOLVING if name in context.params
        and context.get_parameter_source(name).name == "COMMANDLINE"
    ]  # fmt: skip
    if typed:
        raise ValueError(
            f"{path} is solved, so {', '.join(typed)} cannot change it any more: leave out what "
            "belongs to solving, or name the scene"
        )
