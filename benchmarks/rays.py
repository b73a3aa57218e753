"""Form factors of a cluttered room, where rays decide, beside the same rays traced alone.

    python benchmarks/rays.py > benchmarks/rays.md

Each wall of a room is meshed; a cloud of small leaves, obstructions without rows, hides part of it
from the rest. The rays that the assembly traces are kept and traced again, in the same chunks, on
the same threads, and nothing else. Times are the best of three, in turn, warm.
"""

import time
from itertools import product

import numpy as np

import radiosity
from radiosity.transport.threads import core_count, over_ranges
from radiosity.transport.visibility import Visibility

CELLS, LEAVES, ROUNDS = 10, 2000, 3
SIZE = np.array([6.0, 4.0, 3.0])
ACCURACIES = 0.1, 0.03, 0.01


def walls():
    """Return vertices (k, 3) and quadrilaterals (n, 4) of a room, CELLS x CELLS a wall."""
    quads = []
    for axis, end in product(range(3), (0.0, 1.0)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for a, b in product(range(CELLS), repeat=2):
            quad = np.full((4, 3), end)
            quad[:, u] = (np.array([0, 1, 1, 0]) + a) / CELLS
            quad[:, v] = (np.array([0, 0, 1, 1]) + b) / CELLS
            quads.append((quad if end == 0 else quad[::-1]) * SIZE)
    return flat(quads)


def leaves():
    """Return a cloud of squares of 8 cm, turned at random, in the middle half of the room."""
    rng = np.random.default_rng(1)
    square = 0.04 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    quads = []
    for _ in range(LEAVES):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        quads.append(square @ turn[:2] + SIZE * rng.uniform(0.25, 0.75, 3))
    return flat(quads)


def flat(quads):
    return np.concatenate(quads), np.arange(4 * len(quads)).reshape(-1, 4)


def assembly(accuracy, meshes):
    room, clutter = meshes
    return radiosity.form_factors(room, accuracy, obstructions=clutter, repair=False)


class Kept:
    """The scene and the rays of an assembly, to be traced again."""

    def __init__(self, accuracy, meshes):
        self.calls = []
        blocked, first_hits = Visibility.blocked, Visibility.first_hits

        def keep(method):
            def kept(visibility, origins, directions):
                self.calls.append((method, visibility, origins.copy(), directions.copy()))
                return method(visibility, origins, directions)

            return kept

        Visibility.blocked, Visibility.first_hits = keep(blocked), keep(first_hits)
        try:
            assembly(accuracy, meshes)
        finally:
            Visibility.blocked, Visibility.first_hits = blocked, first_hits

    @property
    def count(self):
        return sum(len(call[2]) for call in self.calls)

    def trace(self):
        def work(a, b):
            for method, *rays in self.calls[a:b]:
                method(*rays)

        over_ranges(work, len(self.calls), 1)


def seconds(function, *args):
    """Return wall-clock and processor seconds of a call."""
    wall, cpu = time.perf_counter(), time.process_time()
    function(*args)
    return time.perf_counter() - wall, time.process_time() - cpu


def main():
    meshes = walls(), leaves()
    assembly(0.5, meshes)  # compiles
    print("| accuracy | rays | whole assembly s | cores used | rays alone s | ratio |")
    print("|---|---|---|---|---|---|")
    for accuracy in ACCURACIES:
        kept = Kept(accuracy, meshes)
        whole, alone = [], []
        for _ in range(ROUNDS):
            whole.append(seconds(assembly, accuracy, meshes))
            alone.append(seconds(kept.trace))
        (w, cpu), (r, _) = min(whole), min(alone)
        print(
            f"| {accuracy:g} | {kept.count:,} | {w:.2f} | {cpu / w:.2f} | {r:.2f} | {w / r:.2f} |"
        )
    rows = 6 * CELLS**2
    print(
        f"\n{rows} patches, {LEAVES} leaves, {core_count()} cores. {ROUNDS} rounds, best of each."
    )
    print("Asked: at most 1.8 times the rays alone, all cores used.")


if __name__ == "__main__":
    main()
