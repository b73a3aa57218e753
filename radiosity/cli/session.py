"""What the verbs have in common: load a scene, solve it, say what was found."""

from dataclasses import dataclass, replace

import typer

from radiosity.cli.options import parse_memory, parse_time, percent, use_threads
from radiosity.cli.progress import remark
from radiosity.scene.names import counted


@dataclass(frozen=True)
class Reading:
    """The options that tell how a scene's file is read, as typed."""

    bands: str = "auto"
    ambient: float = 0.0
    unit: str | None = None
    up: str | None = None


def load_scene(path: str, mesh: str, reading: Reading, quiet: bool, accuracy: float = 0.02):
    """Return the scene of a file with ambient light, and remark on what was assumed.

    Pairs of triangles are joined to quadrilaterals, but not for ``--mesh input``.
    """
    from radiosity.light.palette import palette_of
    from radiosity.scene.files import load
    from radiosity.solve.load import is_solved

    if is_solved(path):
        raise ValueError(
            f"{path} is solved: name the scene instead; radiosity info {path} tells how it was "
            "solved and what was reached"
        )
    ambient = reading.ambient
    if not 0 <= ambient < float("inf"):
        raise ValueError(f"--ambient {ambient} must be a radiance of at least 0 W/(m2 sr)")
    scene = load(
        path, merge=mesh != "input", bands=reading.bands, accuracy=accuracy, unit=reading.unit,
        up=reading.up,
    )  # fmt: skip
    for note in scene.notes:
        remark(f"note: {note}", quiet)
    if not scene.has_light and ambient == 0:
        remark("note: nothing in the scene emits light; --ambient 1 lets some in", quiet)
    if not ambient:
        return scene
    entering = palette_of(scene.bands).light((float(ambient),) * 3)
    return replace(scene, ambient=scene.ambient + entering)


LATE = 1.5  # times the time asked that is worth a remark


@dataclass(frozen=True)
class Asked:
    """The options that every verb which solves takes, as typed."""

    accuracy: float
    mesh: str
    order: int | None
    solver: str
    force: bool
    time: str | None
    seed: int
    memory: str | None
    threads: int | None
    quiet: bool


def scene_of(given):
    """Return a scene, or that of a solution."""
    return getattr(given, "scene", given)


def solve_scene(scene, asked: Asked, progress, factors=None, goal=None, watch=None):
    """Solve a scene and remark on the result in two lines; return a solution as it is.

    ``watch(solution)`` is called with what the solver has found so far.
    """
    if scene_of(scene) is not scene:
        return scene
    import time

    from radiosity.solve.requirements import why_gmres
    from radiosity.solve.solve import solve

    use_threads(asked.threads)
    begun = time.perf_counter()
    solution = solve(
        scene, asked.accuracy, mesh=asked.mesh, order=asked.order, solver=asked.solver,
        force=asked.force, seconds=parse_time(asked.time), seed=asked.seed,
        memory=parse_memory(asked.memory), progress=progress, factors=factors,
        goal=goal, watch=watch,
    )  # fmt: skip
    seconds = time.perf_counter() - begun
    plan = solution.plan
    if plan.seconds is not None and seconds > LATE * plan.seconds:
        remark("note: the coarsest mesh that is made took longer than the time asked", asked.quiet)
    if asked.solver == "cg" and asked.order is None:
        remark("note: cg takes constant elements, as --order 0 does", asked.quiet)
    if solution.solver != asked.solver:
        why = {
            "direct": "reflectances near 1 make bounces fade slowly",
            "gmres": why_gmres(scene),
        }[solution.solver]
        remark(f"note: solved by {solution.solver}: {why}", asked.quiet)
    remark(
        f"solved {scene.name}: {counted(len(solution.patches), 'patch')}, "
        f"{counted(len(solution.history), 'iteration')} in {seconds:.1f} s",
        asked.quiet,
    )
    return solution


def reached_line(solution) -> str:
    """Return what accuracy was asked and what is estimated to be reached, as one line."""
    plan = solution.plan
    if plan.seconds is not None:
        return f"asked for {plan.seconds:g} s, estimated {percent(solution.estimate.reached)}"
    mesh = "" if plan.adapts else f" on the mesh of {len(solution.patches)} patches asked for"
    return f"asked {percent(plan.accuracy)}, estimated {percent(solution.estimate.reached)}{mesh}"


def budget_line(solution) -> str:
    """Return what the error is made of, and what halving it would cost."""
    from radiosity.solve.requirements import HALVING

    found = solution.estimate
    parts = {"mesh": found.mesh, "factors": found.kernel, "solver": solution.history[-1]}
    most = max(parts, key=parts.get)
    listed = ", ".join(f"{name} {percent(x)}" for name, x in parts.items())
    if most != "mesh":
        return f"of it: {listed}"
    return f"of it: {listed}; half the error takes about {HALVING:.0f} times as long"


def falls_short(solution) -> bool:
    """Whether a mesh that the program chose did not reach the accuracy."""
    plan = solution.plan
    return plan.adapts and plan.seconds is None and solution.estimate.reached > plan.accuracy


def judge(solution, given=None) -> None:
    """End with exit code 1 where a mesh that the program chose did not reach the accuracy.

    But not where the solution was ``given``: nothing was asked for then.
    """
    if solution is not given and falls_short(solution):
        remark(
            f"radiosity: reached an estimated error of {100 * solution.estimate.reached:.4g} %, "
            f"more than the {percent(solution.plan.accuracy)} asked, on the finest mesh that is "
            "made and fits: use a larger --accuracy or, where memory is short, allow more with "
            "--memory"
        )
        raise typer.Exit(1)
