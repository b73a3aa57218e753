"""``radiosity solve``."""

from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import options as o
from radiosity.cli.given import load_given
from radiosity.cli.progress import progress_bars, remark
from radiosity.cli.session import (
    Asked,
    Reading,
    budget_line,
    judge,
    reached_line,
    scene_of,
    solve_scene,
)


def solve(
    context: typer.Context,
    scene: o.SceneFile,
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output",
            help="Save to .radsol (all of it), .vtp (ParaView), .glb, .html (page), .csv or .npz.",
        ),
    ] = None,
    lightmap: Annotated[
        int | None,
        typer.Option(
            "--lightmap",
            metavar="N",
            parser=o.at_least(1),
            help="Bake the light of a .glb into N x N texels, written beside it too.",
        ),
    ] = None,
    factors: Annotated[
        str | None,
        typer.Option(
            "--factors",
            metavar="F.npz",
            help="Reuse what formfactors SCENE wrote, with the same --mesh and --accuracy.",
        ),
    ] = None,
    accuracy: o.Accuracy = 0.02,
    bands: o.Bands = "auto",
    unit: o.Unit = None,
    up: o.Up = None,
    mesh: o.Mesh = "auto",
    order: o.Order = None,
    solver: o.Solver = "gauss-seidel",
    force: o.Force = False,
    time: o.Time = None,
    seed: o.Seed = 0,
    ambient: o.Ambient = 0.0,
    dim: o.Dim = None,
    memory: o.Memory = None,
    threads: o.Threads = None,
    quiet: o.Quiet = False,
) -> None:
    """Solve a scene, print its power balance and save the result.

    Example: radiosity solve scenes/cornell_box.toml -o cornell.vtp
    """
    from radiosity.transport.files import check_place
    from radiosity.view.export import check_suffix, save

    if output:
        check_suffix(output, lightmap)
        check_place(output)
        if lightmap is not None:
            from radiosity.view.lightmap import beside

            for place in beside(Path(output)):
                check_place(place)
    elif lightmap is not None:
        raise ValueError(f"--lightmap {lightmap} needs a file to write: add -o OUT.glb")
    saved = _load(factors, memory)
    asked = Asked(accuracy, mesh, order, solver, force, time, seed, memory, threads, quiet)
    given = load_given(context, scene, asked, Reading(bands, ambient, unit, up), dim)
    model = scene_of(given)
    with progress_bars(quiet) as progress:
        solution = solve_scene(given, asked, progress, saved)
    print(summary(solution))
    if output:
        with progress_bars(quiet) as progress:
            save(solution, output, lightmap=lightmap, progress=progress)
        remark(f"saved {output}", quiet)
    error = solution.truth_error()
    if error is not None:
        bound = model.truth.relative_tolerance
        print(f"truth: relative error {error:.2e}, stated {bound:g} on mesh {model.truth.mesh}")
    judge(solution, given)


def _load(path, memory):
    """Return the factors of a file, None where none is named; Refused where a solve would not fit.

    Nothing of the matrix is read before.
    """
    if path is None:
        return None
    from radiosity.solve.plan import check_memory
    from radiosity.transport.store import count_rows, load_factors

    check_memory(count_rows(path), o.parse_memory(memory))
    return load_factors(path)


def summary(solution) -> str:
    """Return the size of the solution and its power balance as text."""
    balance, patches = solution.balance, solution.patches
    sealed = int((~solution.live[: patches.fronts] & ~patches.covered).sum())
    rows = [
        f"patches       {len(patches)} ({int(patches.covered.sum())} covered, {sealed} unlit)",
        f"scene         {'closed' if solution.closed else 'open'}",
        f"solver        {solution.solver}, {len(solution.history)} iterations, "
        f"error bound {solution.history[-1]:.1e}",
        *_power_rows(balance, solution.scene.bands),
    ]
    rows.append(f"  balanced within {balance.defect:.1e} of the power emitted")
    rows.append(f"error         {reached_line(solution)}")
    rows.append(f"  {budget_line(solution)}")
    return "\n".join(rows)


def _power_rows(balance, bands) -> list[str]:
    """Return where the emitted power goes, a column a band; of wavelengths in lumens."""
    from radiosity.light.photometry import photometric

    rows = {name: getattr(balance, name) for name in ("emitted", "absorbed", "escaped")}
    unit = "W"
    heads = [{"r": "red", "g": "green", "b": "blue"}.get(name, name) for name in bands.names]
    if bands.wavelengths is not None:
        unit, heads = "lm", ["luminous"]
        rows = {name: [photometric(power, bands)] for name, power in rows.items()}
    head = f"power in {unit:2}" + "".join(f"{h:>14}" for h in heads)
    return [head] + [
        f"  {name:10}" + "".join(f"{v:14.6g}" for v in values) for name, values in rows.items()
    ]
