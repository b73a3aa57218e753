"""What highlights that are not modelled would change, and what modelling them costs.

    python benchmarks/weak.py > benchmarks/weak.md

The white surfaces of the Cornell box, three quarters of it, have a lobe or a mirror that returns a
share of the light, as those of MTL and Radiance files do. Compared is irradiance at 27 points,
relative to max(Y, Y_mean / 10): with its mean albedo added to the diffuse reflectance, and with it
left out. Times of the solves are in seconds, compiling left out, one thread.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from tables import begin

import radiosity
from radiosity.light.blinn import Blinn
from radiosity.light.coherent import Constant
from radiosity.light.facets import Beckmann
from radiosity.light.photometry import luminance
from radiosity.light.shadowing import v_groove
from radiosity.light.torrance_sparrow import TorranceSparrow

SCENES = Path(__file__).resolve().parent.parent / "scenes"
ACCURACY = 0.02


def main():
    """Print the table."""
    scene = radiosity.load(SCENES / "cornell_box.toml")
    places = np.loadtxt(SCENES / "cornell_box_reference/points.csv", delimiter=",", skiprows=1)
    answer(with_white(scene, specular=Blinn(np.full(3, 0.02), 50)), places)  # compiles
    begin(
        __doc__, "material | albedo | added: median error | 95 % below | left out: median "
        "| 95 % below | s modelled | s added",
    )  # fmt: skip
    plain, _ = answer(scene, places)
    for name, key, part, albedo in cases():
        true, slow = answer(with_white(scene, **{key: part}), places)
        added, fast = answer(with_white(scene, albedo), places)
        told = []
        for found in (added, plain):
            error = np.abs(found - true) / np.maximum(true, 0.1 * true.mean())
            told += [f"{np.median(error):.1%}", f"{np.percentile(error, 95):.1%}"]
        print(f"| {name} | {albedo:.3f} | {' | '.join(told)} | {slow:.1f} | {fast:.1f} |")
        sys.stdout.flush()


def cases():
    """Yield a name, the material's key, what it is and its albedo under diffuse light."""
    for share, exponent in ((0.02, 100), (0.05, 20), (0.05, 100), (0.1, 100), (0.2, 5), (0.2, 10)):
        lobe = Blinn(np.full(3, share), exponent)
        yield f"Ks {share:g}, Ns {exponent}", "specular", lobe, float(lobe.mean_albedo[0])
    lobe = TorranceSparrow(Beckmann(0.1), v_groove, None, np.full(3, 0.05))
    yield "plastic, 0.05, 0.1", "specular", lobe, float(lobe.mean_albedo[0])
    yield "plastic, 0.05, 0", "mirror", Constant(np.full(3, 0.05), None), 0.05


def with_white(scene, more=0.0, **optics):
    """Return the scene with white that reflects ``more``, and what else."""
    materials = []
    for m in scene.materials:
        if m.name == "white":
            diffuse = m.diffuse + more
            m = replace(m, diffuse=diffuse, absorptance=1.0 - diffuse, **optics)
        materials.append(m)
    return replace(scene, materials=tuple(materials))


def answer(scene, places):
    """Return the luminance of the irradiance at the points, and the time of the solve."""
    start = time.perf_counter()
    solution = radiosity.solve(scene, ACCURACY)
    took = time.perf_counter() - start
    return luminance(solution.irradiance(places[:, :3], places[:, 3:])[0]), took


main()
