"""What it takes to save a solution, to load it, and to dim its light, beside solving.

    python benchmarks/container.py > benchmarks/container.md

Start-up and compiling left out. ``apart``: solving what each group of light does, with the factors
at hand; ``dim``: a mixture of them, with its error estimated anew. The rooms with lamps have eight
more lights, each a group.
"""

import os
import tempfile
import time
from dataclasses import replace

import numpy as np
from rooms import CORNELL, furnished
from tables import begin

import radiosity
from radiosity.light.sources import Point


def with_lamps(scene):
    """Return a scene with eight points of light under its middle, each a group."""
    low, high = (f(scene.faces.vertices, axis=(0, 1)) for f in (np.min, np.max))
    share = np.array([[0.3, 0.3], [0.7, 0.3], [0.3, 0.7], [0.7, 0.7]])
    power = (scene.unit_m * np.ptp([low, high], axis=0).max()) ** 2
    lights = tuple(
        Point(low + (high - low) * [x, height, y], np.full(3, 0.1 * power), group=f"lamp {k}{n}")
        for n, height in enumerate((0.75, 0.9)) for k, (x, y) in enumerate(share)
    )  # fmt: skip
    return replace(scene, lights=lights)


CASES = {
    "cornell_box, 1 %": (lambda: radiosity.load(CORNELL), 0.01),
    "cornell_box with lamps, 1 %": (lambda: with_lamps(radiosity.load(CORNELL)), 0.01),
    "mirror_room, 5 %": (lambda: radiosity.load(CORNELL.with_name("mirror_room.toml")), 0.05),
    "furnished, 30,000 triangles, 10 %": (lambda: furnished(30_000), 0.1),
    "the same with lamps, 10 %": (lambda: with_lamps(furnished(30_000)), 0.1),
}


def clocked(work, *what):
    begun = time.perf_counter()
    found = work(*what)
    return found, time.perf_counter() - begun


def row(name, scene, accuracy, path):
    """Return the times and the size of one case."""
    solution, solving = clocked(radiosity.solve, scene, accuracy)
    _, apart = clocked(lambda: solution.shares)
    _, saving = clocked(radiosity.save, solution, path)
    loaded, loading = clocked(radiosity.load, path)
    factors = dict.fromkeys(loaded.groups, 0.5) | {loaded.groups[0]: 0.25}
    _, dim = clocked(lambda: loaded.dimmed(factors).estimate)
    size = os.path.getsize(path) / 1e6
    cells = (
        name, len(solution.patches), len(solution.groups), f"{solving:.2f}", f"{apart:.2f}",
        f"{saving:.2f}", f"{size:.2f}", f"{loading:.2f}", f"{dim:.2f}",
    )  # fmt: skip
    return "| " + " | ".join(map(str, cells)) + " |"


def main():
    begin(__doc__, "scene | patches | groups | solve s | apart s | save s | MB | load s | dim s")
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "answer.radsol")
        for make, _ in CASES.values():  # compiled code is loaded
            radiosity.save(radiosity.solve(make(), 0.3), path)
            radiosity.load(path)
        for name, (make, accuracy) in CASES.items():
            print(row(name, make(), accuracy, path), flush=True)


if __name__ == "__main__":
    main()
