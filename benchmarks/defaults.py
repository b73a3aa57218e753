"""Whether any setting of the options beats the default: less time at no larger error.

    python benchmarks/defaults.py > benchmarks/defaults.md

For each scene and accuracy the default is solved, and what it says of its error waited for; then
every other setting. The best is the fastest whose true error, against a far finer solution, is no
larger than the default's. Both are timed again in turn; "beaten by" is the default's time over its.
Once a mesh takes more than twice as long, and 0.1 s, finer ones of its order are left out.
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
    for name in ("two rooms", "table", "two rooms, triangles"):
        yield name, ROOMS[name]()


def settings(scene):
    """Yield a name and the options of each setting but the default, those of a mesh by its size."""
    for solver in SOLVER_NAMES[1:]:
        yield f"--solver {solver}", {"solver": solver}
    yield "--force", {"force": True}
    yield "--order 0", {"order": 0}
    for order, text in ((1, " --order 1"), (0, "")):
        for n in MESHES:
            if len(scene.faces) * n * n <= MOST:
                yield f"--mesh {n}{text}", {"mesh": str(n), "order": order}


def timed(scene, accuracy, options):
    """Return a solution and the seconds that it and what it says of its error took."""
    begun = time.perf_counter()
    solution = radiosity.solve(scene, accuracy, **options)
    solution.estimate  # noqa: B018  part of the answer
    return solution, time.perf_counter() - begun


def best_other(scene, accuracy, reference, seconds, error):
    """Return seconds, name, options and error of the fastest setting of at most ``error``."""
    best = (np.inf,)
    slow = set()  # orders whose finer meshes are not waited for: coarser ones took too long
    for name, options in settings(scene):
        if "mesh" in options and options["order"] in slow:
            continue
        try:
            solution, spent = timed(scene, accuracy, options)
        except NotConverged:  # a mesh so coarse that its factors create light
            continue
        wrong = reference.error_of(solution)
        print(scene.name, accuracy, name, f"{spent:.3f} {wrong:.4f}", file=sys.stderr)
        if spent > 2.0 * seconds + 0.1:
            if "mesh" in options:
                slow.add(options["order"])
        elif wrong <= error:
            again = (timed(scene, accuracy, options)[1] for _ in range(REPEATS - 1))
            best = min(best, (min(spent, *again), name, options, wrong), key=lambda b: b[0])
    return best


def main():
    begin(
        __doc__,
        "scene | asked | s | true error | fastest other as good | s | its error | beaten by",
    )
    for name, scene in scenes():
        reference = make_reference(scene, 0.003)
        for asked in ASKED:
            found = [timed(scene, asked, {}) for _ in range(REPEATS)]
            seconds = min(spent for _, spent in found)
            error = reference.error_of(found[0][0])
            row = [name, f"{asked:g}", f"{seconds:.2f}", f"{error:.4f}", "none", "", "", ""]
            _, *best = best_other(scene, asked, reference, seconds, error)
            if best:
                other, options, wrong = best
                turns = [[timed(scene, asked, o)[1] for o in ({}, options)] for _ in range(REPEATS)]
                mine, its = np.min(turns, axis=0)
                row[2] = f"{mine:.2f}"
                row[4:] = other, f"{its:.2f}", f"{wrong:.4f}", f"{mine / its:.2f}"
            print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
