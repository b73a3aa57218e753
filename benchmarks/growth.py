"""How time and memory grow with the number of triangles, at an accuracy of 10 %.

    python benchmarks/growth.py > benchmarks/growth.md

A room with 24 ellipsoids, each size in a process of its own; start-up and compiling left out.
"""

import json
import resource
import subprocess
import sys
import time

import numpy as np
from tables import begin

SIZES = (10_000, 30_000, 100_000, 300_000)


def one(triangles):
    """Solve one size; print what it took as JSON."""
    from rooms import furnished

    import radiosity

    radiosity.solve(furnished(3000), 0.3)
    model = furnished(triangles)
    begun = time.perf_counter()
    solution = radiosity.solve(model, 0.1)
    seconds = time.perf_counter() - begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    said = solution.estimate.reached
    clusters = len(solution.level.factors.area)
    print(json.dumps([len(model.faces), clusters, seconds, peak, said]))


def main():
    begin(__doc__, "triangles | clusters | seconds | GB | error said")
    found = []
    for size in SIZES:
        run = [sys.executable, __file__, str(size)]
        done = subprocess.run(run, capture_output=True, text=True, check=True)
        found.append(json.loads(done.stdout.splitlines()[-1]))
        n, clusters, seconds, peak, said = found[-1]
        print(f"| {n} | {clusters} | {seconds:.1f} | {peak / 1e9:.2f} | {said:.3f} |", flush=True)
    n, _, seconds, peak, _ = np.array(found).T
    slopes = [np.polyfit(np.log(n), np.log(x), 1)[0] for x in (seconds, peak)]
    print(f"\nExponents: time {slopes[0]:.2f}, memory {slopes[1]:.2f}.")


if __name__ == "__main__":
    one(int(sys.argv[1])) if len(sys.argv) > 1 else main()
