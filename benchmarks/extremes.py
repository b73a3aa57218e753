"""Numerical stability at the extremes: expected, found, error and time of each case.

    python benchmarks/extremes.py > benchmarks/extremes.md

The suites `extremes` and `limits` of `radiosity verify`, refusals, and a million triangles.
"""

import time

import numpy as np
from rooms import furnished
from tables import begin

import radiosity
from radiosity.solve.limits import ROOM, room_of
from radiosity.solve.verification import run_suites

REFUSED = {
    "reflectance 1 in a closed room": lambda: room_of(ROOM, 1.0, [0, 1, 0, 0, 0, 0]),
    "reflectance that is no number": lambda: room_of(ROOM, np.nan, 1.0),
    "reflectance above 1": lambda: room_of(ROOM, 1.5, 1.0),
    "infinite emission": lambda: room_of(ROOM, 0.5, np.inf),
}


def main():
    begin(__doc__, "case | expected | found | error | bound | seconds")
    for c in run_suites(["extremes", "limits"]):
        kept = "" if c.passed else " NOT KEPT"
        values = f"{c.expected:.10g} | {c.found:.10g} | {c.error:.1e} | {c.bound:.0e}{kept}"
        print(f"| {c.case} | {values} | {c.seconds:.3f} |", flush=True)
    for name, make in REFUSED.items():
        begun = time.perf_counter()
        try:
            radiosity.solve(make(), 0.1)
            found = "NOT refused"
        except ValueError as error:
            found = str(error).splitlines()[0].replace("|", "\\|")
        print(f"| {name} | refused | {found} | | | {time.perf_counter() - begun:.3f} |", flush=True)
    begun = time.perf_counter()
    solution = radiosity.solve(furnished(1_000_000), 0.1)
    seconds, said = time.perf_counter() - begun, solution.estimate.reached
    print(f"| {len(solution.scene.faces)} triangles at 10 % | 0.1 | {said:.3g} (said) | | "
          f"| {seconds:.0f} |")  # fmt: skip


if __name__ == "__main__":
    main()
