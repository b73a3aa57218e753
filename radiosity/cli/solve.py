"""``radiosity solve``."""

import time as clock
from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import answer, completion
from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.outcome import facts, summary
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import Asked, Reading, judge, solve_scene

SUFFIXES = ".radsol", ".vtp", ".glb", ".csv", ".npz"


def solve(
    context: typer.Context,
    scene: o.SceneFile,
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="FILE",
            help="Save to .radsol (all of it), .vtp (ParaView), .glb, .html (page), .csv or .npz.",
            autocompletion=completion.files(*SUFFIXES),
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    lightmap: Annotated[
        int | None,
        typer.Option(
            "--lightmap",
            metavar="N",
            parser=o.at_least(1),
            help="Bake the light of a .glb into N x N texels, written beside it too.",
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    history: Annotated[
        str | None,
        typer.Option(
            "--history",
            metavar="FILE",
            help="Plot the solver's error bound after each iteration (of gmres and cg, band after "
            "band): .png, .pdf or .svg.",
            rich_help_panel=o.OUTPUT,
        ),
    ] = None,
    as_json: o.Json = False,
    accuracy: o.Accuracy = 0.02,
    time: o.Time = None,
    mesh: o.Mesh = "auto",
    order: o.Order = None,
    solver: o.Solver = "gauss-seidel",
    factors: Annotated[
        str | None,
        typer.Option(
            "--factors",
            metavar="F.npz",
            help="Reuse what formfactors SCENE wrote, with the same --mesh and --accuracy.",
            autocompletion=completion.files(".npz", ".out", ".vf", ".txt"),
            rich_help_panel=o.SOLVING,
        ),
    ] = None,
    force: o.Force = False,
    seed: o.Seed = 0,
    ambient: o.Ambient = 0.0,
    dim: o.Dim = None,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
    memory: o.Memory = None,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
) -> None:
    """Solve a scene, print its power balance and save the solution.

    Printed are the size of the mesh, the power that is emitted, absorbed and lost to the outside in
    each band, and the error: what was asked, what is estimated to be reached, what it is made of.
    A .radsol file keeps the solution whole, and every verb takes it in place of SCENE.

    Examples
    --------
    radiosity solve scenes/cornell_box.toml -o cornell.radsol
    radiosity solve scenes/cornell_box.toml --accuracy 0.01 -o cornell.vtp
    radiosity solve scenes/cornell_box.toml --time 1s
    radiosity solve scenes/cornell_box.toml --solver jacobi --history jacobi.png
    """
    begun = clock.perf_counter()
    _check_places(output, lightmap, history)
    saved = _load(factors, memory)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    given = load_given(context, scene, asked, Reading(bands, ambient, unit, up), dim)
    with progress_bars(quiet) as progress:
        solution = solve_scene(given, asked, progress, saved)
    if not as_json:
        print(summary(solution))
    written = _write(solution, output, lightmap, history, quiet)
    if as_json:
        answer.print_answer({
            **facts(solution), "seconds": clock.perf_counter() - begun, "written": written,
        })  # fmt: skip
    judge(solution, given)


def _check_places(output, lightmap, history):
    """Refuse files that could not be written, before anything is solved."""
    from radiosity.transport.files import check_place
    from radiosity.view.export import check_suffix

    if output:
        check_suffix(output, lightmap)
        check_place(output)
        if lightmap is not None:
            from radiosity.view.lightmap import beside

            for place in beside(Path(output)):
                check_place(place)
    elif lightmap is not None:
        raise ValueError(f"--lightmap {lightmap} needs a file to write: add -o OUT.glb")
    if history:
        o.check_plot("--history", history)


def _write(solution, output, lightmap, history, quiet) -> list[str]:
    """Write the files that are asked for and return their names."""
    from radiosity.view.export import save

    written = []
    if output:
        with progress_bars(quiet) as progress:
            save(solution, output, lightmap=lightmap, progress=progress)
        written.append(output)
        if lightmap is not None:
            from radiosity.view.lightmap import beside

            written += map(str, beside(Path(output)))
    if history:
        from radiosity.view.plot import plot_histories

        histories = {solution.solver: solution.history}
        plot_histories(histories, solution.scene.name, history, solution.level.recipe.tolerance)
        written.append(history)
    for path in written:
        remark(f"saved {path}", quiet)
    return written


def _load(path, memory):
    """Return the factors of a file, None where none is named; Refused where a solve would not fit.

    Nothing of the matrix is read before.
    """
    if path is None:
        return None
    from radiosity.solve.plan import check_memory
    from radiosity.transport.operator import FormFactors
    from radiosity.transport.store import count_rows

    check_memory(count_rows(path), o.parse_memory(memory))
    return FormFactors.load(path)
