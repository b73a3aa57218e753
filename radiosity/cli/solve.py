"""``radiosity solve``."""

import time as clock
from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import answer, completion
from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import (
    Asked,
    Reading,
    budget_line,
    falls_short,
    judge,
    reached_line,
    solve_scene,
)

SUFFIXES = ".radsol", ".vtp", ".glb", ".csv", ".npz"


def solve(
    context: typer.Context,
    scene: o.SceneFile,
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="FILE",
            help="Save to .radsol (all of it), .vtp (ParaView), .glb, .csv or .npz.",
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
            help="Plot the solver's error bound after each iteration: .png, .pdf or .svg.",
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
        check_plot("--history", history)


def check_plot(option: str, path: str) -> None:
    """Refuse a plot that could not be written."""
    from radiosity.transport.files import check_place

    if Path(path).suffix.lower() not in (".png", ".pdf", ".svg"):
        raise ValueError(f"{option} {path!r} must end in .png, .pdf or .svg")
    check_place(path)


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


def summary(solution) -> str:
    """Return the size of the solution, its power balance and its error as text."""
    told = facts(solution)
    rows = [
        f"patches       {told['patches']} ({told['covered']} covered, {told['unlit']} unlit)",
        f"scene         {'closed' if told['closed'] else 'open'}",
        f"solver        {told['solver']}, {told['iterations']} iterations, "
        f"error bound {told['error_bound']:.1e}",
        *_power_rows(told["power"]),
    ]
    rows.append(f"  balanced within {told['power']['defect']:.1e} of the power emitted")
    rows.append(f"error         {reached_line(solution)}")
    rows.append(f"  {budget_line(solution)}")
    if told["truth"]:
        error, bound, mesh = told["truth"].values()
        rows.append(f"truth: relative error {error:.2e}, stated {bound:g} on mesh {mesh}")
    return "\n".join(rows)


def facts(solution) -> dict:
    """Return what is to be said of a solution, for JSON."""
    patches, found, truth = solution.patches, solution.estimate, solution.scene.truth
    return {
        "scene": solution.scene.name,
        **answer.solved(solution),
        "reached": not falls_short(solution),
        "covered": int(patches.covered.sum()),
        "unlit": int((~solution.live[: patches.fronts] & ~patches.covered).sum()),
        "closed": solution.closed,
        "error_bound": solution.history[-1],
        "history": solution.history,
        "error_of": {
            "mesh": found.mesh, "factors": found.kernel, "solver": solution.history[-1],
        },
        "power": _power(solution.balance, solution.scene.bands),
        "truth": truth and {
            "error": solution.truth_error(), "tolerance": truth.relative_tolerance,
            "mesh": truth.mesh,
        },
        "notes": list(solution.scene.notes),
    }  # fmt: skip


def _power(balance, bands) -> dict:
    """Return where the emitted power goes, a value a band; of wavelengths in lumens."""
    from radiosity.light.photometry import photometric

    found = {name: getattr(balance, name) for name in ("emitted", "absorbed", "escaped")}
    unit, names = "W", [{"r": "red", "g": "green", "b": "blue"}.get(n, n) for n in bands.names]
    if bands.wavelengths is not None:
        unit, names = "lm", ["luminous"]
        found = {name: [photometric(power, bands)] for name, power in found.items()}
    return {"unit": unit, "bands": names, **found, "defect": balance.defect}


def _power_rows(power) -> list[str]:
    """Return where the emitted power goes, a column a band."""
    head = f"power in {power['unit']:2}" + "".join(f"{name:>14}" for name in power["bands"])
    return [head] + [
        f"  {name:10}" + "".join(f"{v:14.6g}" for v in power[name])
        for name in ("emitted", "absorbed", "escaped")
    ]
