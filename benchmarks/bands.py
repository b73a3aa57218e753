"""What wavelengths cost and what they are worth: the Cornell box with measured spectra.

    OPENBLAS_NUM_THREADS=1 python benchmarks/bands.py > benchmarks/bands.md

Colours of 1000 points, seen from the front, against those of 128 wavelengths on the same mesh;
L* = 100 is what the automatic exposure shows as white, with the lamp's chromaticity. Times are
warm, the least of several, taken in turn, as ratios to red, green and blue: of a solution to 2 %
with its error, and of its picture of 128 x 128 pixels with 32 samples; linear algebra on one core,
whose threads wait for each other where others use the machine.
"""

import time
from pathlib import Path

import numpy as np
from tables import begin

import radiosity
from radiosity.light.colour import RGB_TO_XYZ, delta_e_76, delta_e_2000, lab
from radiosity.solve.tradeoff import _points_on
from radiosity.view.shading import auto_exposure

SCENE = Path(__file__).resolve().parent.parent / "scenes" / "cornell_box_spectral.toml"
TRIED = "grey", "rgb", "8", "12", "16", "24", "32", "61"
FINEST, TIMES = "128", 5


def colours(bands):
    """Return X, Y, Z of the light that leaves points (k, 3), and of white."""
    scene = radiosity.load(SCENE, bands=bands)
    solution = radiosity.solve(scene, mesh="4", order=1)
    points, normals = _points_on(solution)
    rows = solution.scene.faces.material[_face_of(solution, points, normals)]
    e = solution.irradiance(points, normals)[0]
    rho = np.array([m.diffuse for m in scene.materials])[rows]
    light = next(m.emission for m in scene.materials if m.emits)
    seen, white = (scene.bands.to_rgb(x) @ RGB_TO_XYZ.T for x in (rho * e / np.pi, light))
    return seen, white / (white[1] * auto_exposure(solution))


def _face_of(solution, points, normals):
    """Return the face that each point was put on: that of the nearest patch that looks its way."""
    patches = solution.patches
    apart = np.linalg.norm(points[:, None] - patches.centroid, axis=2)
    apart[normals @ patches.normal.T < 1 - 1e-9] = np.inf
    off = np.abs(np.einsum("knc,nc->kn", points[:, None] - patches.centroid, patches.normal))
    apart[off > 1e-6 * np.ptp(patches.centroid)] = np.inf
    return patches.face[np.argmin(apart, axis=1)]


def seconds():
    """Return the least times (tried, 2) of a solution and of its picture."""
    found = np.full((len(TRIED), 2), np.inf)
    for _ in range(1 + TIMES):  # the first one compiles
        for k, bands in enumerate(TRIED):
            begun = time.perf_counter()
            solution = radiosity.solve(radiosity.load(SCENE, bands=bands), 0.02)
            assert solution.estimate.reached < 0.02
            solved = time.perf_counter()
            radiosity.render(solution, size=(128, 128), samples=32)
            spent = solved - begun, time.perf_counter() - solved
            found[k] = np.minimum(found[k], spent)
    return found


def main():
    columns = "bands | solve | picture | CIEDE2000 mean | 95 % | most | CIE76 mean | 95 % | most"
    begin(__doc__, columns)
    exact, white = colours(FINEST)
    spent = seconds()
    ratio = spent / spent[TRIED.index("rgb")]
    for bands, (solve, picture) in zip(TRIED, ratio, strict=True):
        two = lab(colours(bands)[0], white), lab(exact, white)
        cells = [f"{solve:.2f}", f"{picture:.2f}"]
        for difference in (delta_e_2000(*two), delta_e_76(*two)):
            for x in (difference.mean(), np.percentile(difference, 95), difference.max()):
                cells.append(f"{x:.2f}")
        print(f"| {bands} | " + " | ".join(cells) + " |", flush=True)
    least = spent[TRIED.index("rgb")]
    print(f"\nRGB took {least[0]:.2f} s and {least[1]:.2f} s; {TIMES} rounds, best of each.")


if __name__ == "__main__":
    main()
