"""What `plan` predicts, and takes to, against what solving takes: patches, seconds, memory.

    python benchmarks/plan.py > benchmarks/plan.md

Seconds are warm, in one process: of planning, predicted, and of solving and its estimate; memory is
predicted, and the peak of a process that does nothing else, the program and its code included.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from rooms import SCENES as ROOMS
from rooms import furnished
from tables import begin

import radiosity
from radiosity.solve.plan import make_plan
from radiosity.solve.requirements import foresee

HERE = Path(__file__).resolve().parent

ASKED = (0.1, 0.03, 0.01, 0.003)
FILES = ("lroom", "box6")
FURNISHED = 20_000  # triangles, not at 0.003


def made(name):
    if name == "furnished":
        return furnished(FURNISHED)
    if name in ROOMS:
        return ROOMS[name]()
    return radiosity.load(HERE.parent / "scenes" / f"{name}.toml")


def peak(name, asked):
    """Return the bytes at the peak of a process that solves a scene."""
    code = (
        "import plan, radiosity\n"
        f"radiosity.solve(plan.made({name!r}), {asked}).estimate\n"
        "print([x.split()[1] for x in open('/proc/self/status') if x.startswith('VmHWM')][0])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=HERE, capture_output=True, text=True, check=True
    )
    return 1024.0 * int(done.stdout.split()[-1])


def main():
    begin(
        __doc__,
        "scene | asked | planned in | patches | found | s | took | time ratio | MB | peak "
        "| memory ratio",
    )
    ratios = []
    for name in (*FILES, *ROOMS, "furnished"):
        scene = made(name)
        for asked in ASKED[: 3 if name == "furnished" else None]:
            plan = make_plan(scene, asked)
            foresee(scene, plan)  # compiled code is loaded
            begun = time.perf_counter()
            seen = foresee(scene, plan)
            planned = time.perf_counter() - begun
            spent = []
            for _ in range(3):
                begun = time.perf_counter()
                solution = radiosity.solve(scene, asked)
                solution.estimate  # noqa: B018  part of the answer
                spent.append(time.perf_counter() - begun)
            took, memory = min(spent[1:]), peak(name, asked)
            ratios.append((seen.seconds / took, seen.memory / memory))
            patches = len(solution.level.rows)
            print(
                f"| {name} | {asked:g} | {planned:.2f} | {seen.patches} | {patches} "
                f"| {seen.seconds:.2f} | {took:.2f} | {ratios[-1][0]:.2f} "
                f"| {seen.memory / 1e6:.0f} | {memory / 1e6:.0f} | {ratios[-1][1]:.2f} |",
                flush=True,
            )
    times, memories = np.array(ratios).T
    print(
        f"\nTime within 2 times in {np.sum(np.abs(np.log2(times)) <= 1)} of {len(times)}, memory "
        f"within 25 % in {np.sum(np.abs(memories - 1) <= 0.25)}."
    )


if __name__ == "__main__":
    main()
