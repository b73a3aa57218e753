"""What it costs to read rough dielectric coats of glTF as part of the diffuse reflectance.

    OPENBLAS_NUM_THREADS=1 python benchmarks/coats.py > benchmarks/coats.md

Irradiance at 400 points of the Cornell box and of a room with a table, all surfaces under a coat of
an index of 1.5 and glTF's roughness r, modelled as a lobe (asked for 2 %). Against it the coat as
part of the diffuse reflectance, as `radiosity.scene.gltf.materials` reads it from r = 0.4 on, and
left out, as it does from 0.9 on: the mean and the 95th percentile of the relative difference, and
how much more processor time the lobe takes.
"""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from rooms import table
from tables import begin

import radiosity
from radiosity.light.facets import TrowbridgeReitz
from radiosity.light.photometry import luminance
from radiosity.light.shadowing import smith
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.scene.gltf.materials import coat_albedo
from radiosity.solve.tradeoff import _points_on

SCENE = Path(__file__).resolve().parent.parent / "scenes" / "cornell_box.toml"
ROUGH, F0, POINTS = (0.3, 0.4, 0.5, 0.7, 0.9), np.full(3, 0.04), 400


def coated(scene, roughness):
    """Return a scene whose surfaces have a coat above them."""
    lobe = TorranceSparrow(TrowbridgeReitz(roughness**2), smith, np.array([1.5]))
    return _with(scene, lambda m: replace(m, specular=lobe))


def folded(scene, roughness):
    """Return a scene whose surfaces reflect diffusely what a coat above them does."""
    coat = coat_albedo(F0, roughness)

    def thicker(m):
        rho = coat + m.diffuse * (1 - coat)
        return replace(m, diffuse=rho, absorptance=1 - rho)

    return _with(scene, thicker)


def _with(scene, change):
    materials = tuple(m if m.emits else change(m) for m in scene.materials)
    return replace(scene, materials=materials, truth=None)


def lit(scene, points, accuracy=0.02):
    """Return the illuminance at points, over 683, and the time of the solution."""
    begun = time.process_time()
    solution = radiosity.solve(scene, accuracy)
    took = time.process_time() - begun
    return luminance(solution.irradiance(*points)[0]), took


def main():
    begin(__doc__, "scene | r | part of diffuse: mean | 95 % | left out: mean | 95 % | lobe's time")
    for name, scene in (("Cornell box", radiosity.load(SCENE)), ("table", table())):
        every = _points_on(radiosity.solve(scene, 0.05))
        chosen = np.random.default_rng(0).permutation(len(every[0]))[:POINTS]
        points = tuple(x[chosen] for x in every)
        plain, _ = lit(scene, points)
        plain, usual = lit(scene, points)  # the first one compiles
        for r in ROUGH:
            truth, took = lit(coated(scene, r), points)
            apart = [(x / truth - 1) for x in (lit(folded(scene, r), points)[0], plain)]
            words = " | ".join(
                f"{100 * x.mean():+.1f} % | {100 * np.percentile(np.abs(x), 95):.1f} %"
                for x in apart
            )
            print(f"| {name} | {r} | {words} | {took / usual:.0f} x |", flush=True)


if __name__ == "__main__":
    main()
