"""What highlights that are not modelled would change, and what modelling them costs.

    python benchmarks/weak.py > benchmarks/weak.md

The Cornell box whose white surfaces, three quarters of it, have a lobe (N.H)^n that returns a share
of the light, as materials of MTL and Radiance files have. Compared is irradiance at 27 points,
relative to max(Y, Y_mean / 10): with the share added to the diffuse reflectance, and with it left
out. Times of the solves are in seconds, compiling left out.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from tables import begin

import radiosity
from radiosity.light.blinn import Blinn
from radiosity.light.photometry import luminance

SCENES = Path(__file__).resolve().parent.parent / "scenes"
ACCURACY = 0.02
CASES = (
    (0.02, 100), (0.05, 100), (0.1, 100), (0.2, 100), (0.2, 5), (0.2, 10), (0.2, 20), (0.2, 1000),
)  # fmt: skip


def main():
    """Print the table."""
    scene = radiosity.load(SCENES / "cornell_box.toml")
    places = np.loadtxt(SCENES / "cornell_box_reference/points.csv", delimiter=",", skiprows=1)
    answer(with_white(scene, 0.02, 0.02, 50), places)  # compiles
    begin(
        __doc__, "share | n | added: median error | 95 % below | left out: median | 95 % below "
        "| s with lobe | s without",
    )  # fmt: skip
    for share, exponent in CASES:
        true, slow = answer(with_white(scene, 0.0, share, exponent), places)
        added, fast = answer(with_white(scene, share, 0.0, exponent), places)
        without, _ = answer(scene, places)
        told = []
        for found in (added, without):
            error = np.abs(found - true) / np.maximum(true, 0.1 * true.mean())
            told += [f"{np.median(error):.1%}", f"{np.percentile(error, 95):.1%}"]
        print(f"| {share:g} | {exponent} | {' | '.join(told)} | {slow:.1f} | {fast:.1f} |")
        sys.stdout.flush()


def with_white(scene, more, share, exponent):
    """Return the scene with white that reflects ``more``, and ``share`` in a lobe."""
    materials = []
    for m in scene.materials:
        if m.name == "white":
            lobe = Blinn(np.full(3, share), exponent) if share else None
            diffuse = m.diffuse + more
            m = replace(m, diffuse=diffuse, absorptance=1.0 - diffuse, specular=lobe)
        materials.append(m)
    return replace(scene, materials=tuple(materials))


def answer(scene, places):
    """Return the luminance of the irradiance at the points, and the time of the solve."""
    start = time.perf_counter()
    solution = radiosity.solve(scene, ACCURACY)
    took = time.perf_counter() - start
    return luminance(solution.irradiance(places[:, :3], places[:, 3:])[0]), took


main()
