"""What is asked, what is said, and what is true: errors, error bars and times of reference scenes.

    python benchmarks/accuracy.py > benchmarks/accuracy.md

References: path tracing of other programs (`scenes/*_reference`), of which two standard errors are
allowed, and our own far finer solutions at 500 points of all surfaces. The error is that which
`--accuracy` bounds: relative to the luminance at a point or a tenth of its mean; 95 % lie below.
"""

import time
from pathlib import Path

import numpy as np
from rooms import SCENES as ROOMS
from tables import begin

import radiosity
from radiosity.light.photometry import luminance
from radiosity.solve.tradeoff import make_reference

SCENES = Path(__file__).resolve().parent.parent / "scenes"
ASKED = (0.1, 0.03, 0.01, 0.003)
REFERENCES = ("cornell_box", "lroom", "furnace", "point_spot", "cornell_glossy")


def columns(path, *names):
    table = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    return np.stack([table[n] for n in names], axis=1)


def others(name):
    """Return points, normals, luminance of the irradiance and its two standard errors."""
    folder = SCENES / f"{name}_reference"
    p = columns(folder / "points.csv", *"xyz", "nx", "ny", "nz")
    e = columns(folder / "irradiance.csv", "E_r", "E_g", "E_b")
    se = columns(folder / "irradiance.csv", "se_r", "se_g", "se_b")
    weights = luminance(np.eye(3))
    return p[:, :3], p[:, 3:], luminance(e), 2 * np.sqrt(se**2 @ weights**2)


def row(name, scene, points, normals, y, rest, mean, dark=None):
    """Print one line for each accuracy; return the pooled squares and coverage."""
    pooled = []
    for asked in ASKED:
        radiosity.solve(scene, asked)
        begun = time.perf_counter()
        solution = radiosity.solve(scene, asked)
        seconds = time.perf_counter() - begun
        e, bar = solution.irradiance(points, normals)
        scale = np.maximum(y, 0.1 * mean)
        off = np.abs(luminance(e) - y)
        beyond = np.maximum(off - rest, 0.0) / scale
        covered = np.mean(off <= luminance(bar) + rest)
        some = slice(None) if dark is None else dark
        error = np.percentile(beyond[some], 95)
        print(
            f"| {name} | {asked:g} | {len(solution.level.rows)} | {seconds:.2f} "
            f"| {solution.estimate.reached:.4f} | {error:.4f} | {covered:.3f} "
            f"| {'yes' if error <= asked else 'NO'} |",
            flush=True,
        )
        pooled.append(
            (covered, np.mean((luminance(bar) / scale) ** 2), np.mean((off / scale) ** 2))
        )
    return pooled


def main():
    begin(__doc__, "scene | asked | patches | solve s | said | true | bars cover | kept")
    pooled = []
    for name in REFERENCES:
        scene = radiosity.load(SCENES / f"{name}.toml")
        points, normals, y, rest = others(name)
        mean = radiosity.solve(scene, 0.02).estimate.scale
        pooled += row(f"{name}, other programs", scene, points, normals, y, rest, mean)
        if name == "lroom":
            dark = y < np.median(y)
            pooled += row("lroom, its dark points", scene, points, normals, y, rest, mean, dark)
    for name, make in ROOMS.items():
        scene = make()
        exact = make_reference(scene, 0.003)
        y = luminance(exact.irradiance)
        pooled += row(name, scene, exact.points, exact.normals, y, 0 * y, exact.scale)
    cover, bars, errors = np.mean(pooled, axis=0)
    print(
        f"\nPooled: bars cover {cover:.1%} of the errors and are {np.sqrt(bars / errors):.2f} "
        "times as large (rms)."
    )


if __name__ == "__main__":
    main()
