"""What ``radiosity solve`` says of a solution: as text, and for JSON."""

from radiosity.cli.answer import solved
from radiosity.cli.session import budget_line, falls_short, reached_line
from radiosity.scene.names import counted


def summary(solution) -> str:
    """Return the size of the solution, its power balance and its error as text."""
    told = facts(solution)
    rows = [
        f"patches       {told['patches']} ({told['covered']} covered, {told['unlit']} unlit)",
        f"scene         {'closed' if told['closed'] else 'open'}",
        f"solver        {told['solver']}, {counted(told['iterations'], 'iteration')}, "
        f"error bound {told['error_bound']:.1e}",
        *_power_rows(told["power"]),
    ]
    rows.append(f"  balanced within {told['power']['defect']:.1e} of the power emitted")
    rows.append(f"error         {reached_line(solution)}")
    rows.append(f"  {budget_line(solution)}")
    if told["truth"]:
        error, bound, mesh = told["truth"].values()
        rows.append(f"truth: relative error {error:.2e}, stated {bound:g} on mesh {mesh}")
        if solution.plan.adapts and mesh != "auto":
            rows[-1] += ": another mesh answers another question"
    return "\n".join(rows)


def facts(solution) -> dict:
    """Return what is to be said of a solution, for JSON."""
    patches, found, truth = solution.patches, solution.estimate, solution.scene.truth
    return {
        "scene": solution.scene.name,
        **solved(solution),
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
