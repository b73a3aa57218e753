"""Files of solutions at 2 % asked: what lightmaps are worth, and time and size of each kind.

    python benchmarks/exports.py > benchmarks/exports.md

Errors are those of the luminance of irradiance at 500 random points, 95 % of which are better, in
the norm of the accuracy: of values that the elements hold and of gathered ones against a solution
at 0.3 %, of lightmaps that are read back from their files and looked up bilinearly against gathered
values. Times are seconds of one core.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from tables import begin

import radiosity
from radiosity.view.gltf import to_gltf
from radiosity.view.lightmap import beside

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))
from glb_for_tests import Glb  # noqa: E402
from test_lightmap import looked_up, read_exr, scattered  # noqa: E402  what reads, written once

SIZES, COUNT = (128, 256, 512), 500


def error(found, expected, solution):
    """Return what 95 % of the errors stay below."""
    y, live = solution.scene.bands.luminance, solution.live
    mean = np.average(y(solution.irradiance_on[live]), weights=solution.patches.area[live])
    off = np.abs(y(found) - y(expected)) / np.maximum(y(expected), 0.1 * mean)
    return np.percentile(off, 95)


def timed(work):
    """Return what a function does and the seconds that it takes of one core."""
    begun = time.process_time()
    found = work()
    return found, time.process_time() - begun


def points_on(solution):
    """Return COUNT random points on the lit patches, their normals and patches."""
    rng, patches = np.random.default_rng(0), solution.patches
    area = patches.area * solution.live
    rows = rng.choice(len(area), COUNT, p=area / area.sum())
    w = rng.dirichlet(np.ones(3), COUNT)
    half = np.where(rng.random(COUNT)[:, None] < 0.5, [0, 1, 2], [0, 2, 3])
    corners = patches.vertices[rows[:, None], half]
    return np.einsum("kv,kvc->kc", w, corners), patches.normal[rows], rows


def values(name, solution, fine):
    """Print the errors of elements, gathered values and lightmaps."""
    points, normals, rows = points_on(solution)
    expected = fine.level.gathered(points, normals).total
    solution.level.gathered(points, normals)  # compiled
    gathered, seconds = timed(lambda: solution.level.gathered(points, normals).total)
    level = solution.level
    owner = np.searchsorted(level.rows, rows)
    elements = level.senders.elements.at(points, owner, level.arriving)
    print(f"| {name} | elements | {error(elements, expected, solution):.4f} | | |")
    print(f"| | gathered | {error(gathered, expected, solution):.4f} | "
          f"{1e3 * seconds / len(points):.3f} ms a point | |")  # fmt: skip
    back = np.linalg.inv(to_gltf(solution.scene, np.eye(3)))
    for size in SIZES:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "map.glb"
            _, seconds = timed(lambda: radiosity.save(solution, path, lightmap=size))  # noqa: B023
            glb, exr = Glb(path), read_exr(beside(path)[0])
            sizes = ", ".join(f"{p.stat().st_size / 1e3:.0f}" for p in (path, *beside(path)))
        corners = glb.triangles("POSITION") @ back
        points, uv, normals = scattered(corners, glb.triangles("TEXCOORD_1"), COUNT)
        expected = solution.level.gathered(points, normals).total
        seen = expected.any(axis=1)  # not under a block
        off = error(looked_up(exr, uv)[seen], expected[seen], solution)
        print(f"| | lightmap {size} x {size} | {off:.4f} | {seconds:.1f} s | {sizes} |")


def files(name, solution):
    """Print time and size of the other kinds of files."""
    with tempfile.TemporaryDirectory() as folder:
        for suffix in (".vtp", ".glb", ".csv", ".npz"):
            path = Path(folder) / f"out{suffix}"
            radiosity.save(solution, path)
            _, seconds = timed(lambda path=path: radiosity.save(solution, path))
            print(f"| {name} | {suffix} | {path.stat().st_size / 1e3:.1f} | {seconds:.3f} |")
            name = ""


def main():
    names = "cornell_box", "lroom"
    solutions = {}
    begin(__doc__, "scene | values | error, 95 % | time | kB: .glb, .exr, .png")
    for name in names:
        scene = radiosity.load(ROOT / "scenes" / f"{name}.toml")
        solutions[name] = radiosity.solve(scene)
        values(name, solutions[name], radiosity.solve(scene, 0.003))
    print("\n| | file | kB | s |\n|---|---|---|---|\n", end="")
    for name in names:
        files(name, solutions[name])


if __name__ == "__main__":
    main()
