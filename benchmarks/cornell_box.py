"""Accuracy and time on the Cornell box.

    python benchmarks/cornell_box.py > benchmarks/cornell_box.md

Irradiance at the 27 reference points and the 256 x 256 picture against path tracing (Mitsuba 3),
for several accuracies. Times are warm, on all cores, without start-up.
"""

import sys
import time
from pathlib import Path

import numpy as np

import radiosity
from radiosity.light.photometry import luminance

SCENES = Path(__file__).resolve().parent.parent / "scenes"
REFERENCE = SCENES / "cornell_box_reference"


def timed(function):
    begun = time.perf_counter()
    result = function()
    return result, time.perf_counter() - begun


def picture_error(pixels):
    """Relative rms error of luminance over interior pixels, the reference's noise taken out."""
    data = np.load(REFERENCE / "image.npz", allow_pickle=False)
    y, noise = luminance(data["image"].astype(float)), luminance(data["se"].astype(float))
    inside = data["interior"].astype(bool) & (y > 0) & (y < 10 * np.median(y[y > 0]))
    scale = np.maximum(y, 0.1 * y[inside].mean())
    square = ((luminance(pixels.astype(float)) - y) / scale) ** 2 - (noise / scale) ** 2
    return np.sqrt(max(0.0, square[inside].mean()))


def point_errors(solution):
    table = np.genfromtxt(REFERENCE / "irradiance.csv", delimiter=",", names=True, dtype=None,
                          encoding="utf-8")  # fmt: skip
    columns = [np.stack([table[c] for c in names], axis=1) for names in
               (("x", "y", "z"), ("nx", "ny", "nz"), ("E_r", "E_g", "E_b"))]  # fmt: skip
    found, _ = solution.irradiance(columns[0], columns[1])
    area = solution.patches.area[solution.live]
    mean = area @ luminance(solution.irradiance_on[solution.live]) / area.sum()
    y = luminance(columns[2])
    return np.abs(luminance(found) - y) / np.maximum(y, 0.1 * mean)


def main():
    scene = radiosity.load(SCENES / "cornell_box.toml")
    radiosity.render(radiosity.solve(scene, 0.2), size=(8, 8))  # compiles
    print(
        "| accuracy | patches | solve s | probe s | median error | 95 % "
        "| picture s | picture error |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for accuracy in (0.1, 0.05, 0.02, 0.01, 0.003):
        solution, solve_s = timed(lambda a=accuracy: radiosity.solve(scene, a))
        errors, probe_s = timed(lambda s=solution: point_errors(s))
        image, render_s = timed(lambda s=solution: radiosity.render(s, size=(256, 256)))
        print(
            f"| {accuracy:g} | {len(solution.patches)} | {solve_s:.2f} | {probe_s:.2f} "
            f"| {np.median(errors):.2%} | {np.percentile(errors, 95):.2%} "
            f"| {render_s:.1f} | {picture_error(image.pixels):.2%} |"
        )
        sys.stdout.flush()


main()
