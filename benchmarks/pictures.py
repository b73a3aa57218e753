"""Pictures at default samples against path tracing (Mitsuba 3), same camera and size.

    python benchmarks/pictures.py > benchmarks/pictures.md

Errors are of luminance over pixels that see one flat face and no lamp, relative to the mean of the
reference, its own variance subtracted.
"""

import sys
import time
from pathlib import Path

import numpy as np
from tables import begin

import radiosity
from radiosity.light.photometry import luminance

SCENES = Path(__file__).resolve().parent.parent / "scenes"
NAMES = "cornell_box", "lroom", "point_spot", "cornell_glossy"
ACCURACIES = 0.05, 0.02, 0.01
BLOCK = 8
HEAD = (
    "scene | accuracy | solve s | picture s | CPU s | blocks of 8 x 8, rms | pixels, rms "
    "| noise, estimated"
)


def timed(function):
    begun, worked = time.perf_counter(), time.process_time()
    result = function()
    return result, time.perf_counter() - begun, time.process_time() - worked


def reference(name):
    """Return luminance, its standard error, and which pixels to compare."""
    data = np.load(SCENES / f"{name}_reference" / "image.npz")
    lamp = [k for k, n in enumerate(data["object_names"]) if n == "light"]
    inside = data["interior"] & ~np.isin(data["object_id"], lamp)
    return luminance(data["image"].astype(float)), luminance(data["se"].astype(float)), inside


def errors(picture, truth, noise, inside):
    """Return the rms errors of block means and of pixels, relative to the mean."""
    inside = inside & (picture.lamp[..., 3] == 0 if picture.lamp is not None else True)
    differ = luminance(picture.pixels.astype(float)) - truth
    squares, height = [], truth.shape[0]
    for y in range(0, height, BLOCK):
        for x in range(0, truth.shape[1], BLOCK):
            block = np.s_[y : y + BLOCK, x : x + BLOCK]
            mine = inside[block]
            if mine.any():
                own = np.sum(noise[block][mine] ** 2) / mine.sum() ** 2
                squares.append(differ[block][mine].mean() ** 2 - own)
    pixel = np.mean(differ[inside] ** 2 - noise[inside] ** 2)
    mean = truth[inside].mean()
    return [np.sqrt(max(0.0, s)) / mean for s in (np.mean(squares), pixel)]


def main():
    begin(__doc__, HEAD)
    for name in NAMES:
        scene, known = radiosity.load(SCENES / f"{name}.toml"), reference(name)
        size = known[0].shape[::-1]
        radiosity.render(radiosity.solve(scene, 0.2), size=(16, 16))  # compiles
        for accuracy in ACCURACIES:
            solution, solving, _ = timed(lambda s=scene, a=accuracy: radiosity.solve(s, a))
            picture, took, work = timed(lambda s=solution, z=size: radiosity.render(s, size=z))
            block, pixel = errors(picture, *known)
            print(
                f"| {name} | {accuracy:g} | {solving:.2f} | {took:.1f} | {work:.1f} | {block:.2%} "
                f"| {pixel:.2%} | {picture.noise:.2%} |"
            )
            sys.stdout.flush()


main()
