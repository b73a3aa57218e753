"""Whether any setting of the options beats the default: less time at no larger error.

    python benchmarks/defaults.py > benchmarks/defaults.md

For each scene and accuracy the default is solved, and what it says of its error waited for; then
every other setting. The best is the fastest whose true error, against a far finer solution, is no
larger than the default's; "beaten by" is the default's time over its. Settings that take more than
twice as long are not waited for.
"""

import sys
import time
from pathlib import Path

import numpy as np
from rooms import SCENES as ROOMS
from tables import begin

import radiosity
from radiosity.solve.methods import NotConverged
from radiosity.solve.plan import SOLVER_NAMES
from radiosity.solve.tradeoff import make_reference

SCENES = Path(__file__).resolve().parent.parent / "scenes"
ASKED = (0.1, 0.05, 0.03, 0.01, 0.003)
MESHES = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 24)
MOST = 2500  # patches that are waited for
REPEATS = 3


def scenes():
    yield "cornell_box", radiosity.load(SCENES / "cornell_box.toml")
    yield "lroom", radiosity.load(SCENES / "lroom.toml")
    yield "two rooms", ROOMS["two rooms"]()
    yield "table", ROOMS["table"]()


def settings(scene, accuracy):
    """Yield a name and the options of each setting but the default."""
    for solver in SOLVER_NAMES[1:]:
        yield f"--solver {solver}", {"solver": solver}
    yield "--force", {"force": True}
    yield "--order 0", {"order": 0}
    for n in MESHES:
        cells = len(scene.faces) * n * n
        if cells <= MOST:
            yield f"--mesh {n} --order 1", {"mesh": str(n), "order": 1}
            yield f"--mesh {n}", {"mesh": str(n)}


def measured(scene, accuracy, options, enough=np.inf):
    """Return a solution, and the least seconds of a few that it and its estimate took.

    None where the first one takes more than ``enough``.
    """
    spent = []
    for _ in range(REPEATS):
        begun = time.perf_counter()
        try:
            solution = radiosity.solve(scene, accuracy, **options)
        except NotConverged:  # a mesh so coarse that its factors create light
            return None, np.inf
        solution.estimate  # noqa: B018  what it says of its error is part of the answer
        spent.append(time.perf_counter() - begun)
        if spent[0] > enough:
            return None, np.inf
    return solution, min(spent)


def main():
    begin(
        __doc__,
        "scene | asked | s | true error | fastest other as good | s | its error | beaten by",
    )
    for name, scene in scenes():
        reference = make_reference(scene, 0.003)
        for asked in ASKED:
            default, seconds = measured(scene, asked, {})
            error = reference.error_of(default)
            best = None
            for other, options in settings(scene, asked):
                solution, spent = measured(scene, asked, options, 2.0 * seconds + 0.1)
                if solution is None:
                    continue
                wrong = reference.error_of(solution)
                print(name, asked, other, f"{spent:.3f} {wrong:.4f}", file=sys.stderr)
                if wrong <= error and (best is None or spent < best[1]):
                    best = other, spent, wrong
            row = [name, f"{asked:g}", f"{seconds:.2f}", f"{error:.4f}", "none", "", "", ""]
            if best is not None:
                ratio = seconds / best[1]
                row[4:] = best[0], f"{best[1]:.2f}", f"{best[2]:.4f}", f"{ratio:.2f}"
            print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
