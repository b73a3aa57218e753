"""Two ways to gather indirect light, and how errors of pictures fall with the rays.

    python benchmarks/gather.py > benchmarks/gather.md

At points that a picture shows: exact weights of all patches, free of noise, or rays over the
hemisphere; errors are differences to 8192 other rays, relative to the mean. Of pictures, 96 x 96,
whose indirect light is smoothed between pixels, edges included: true errors, differences to 4096
rays a pixel of another seed, beside the errors that they estimate.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from tables import begin

import radiosity
from radiosity.light.photometry import luminance
from radiosity.transport.arrival import arriving
from radiosity.transport.irradiance import indirect_irradiance
from radiosity.view.camera import rays
from radiosity.view.gather import find_camera, first_rows

SCENES = Path(__file__).resolve().parent.parent / "scenes"
SIZE, FINE, STRIDE = (96, 96), 4096, 7
Y = np.array([0.2126, 0.7152, 0.0722])


def reseeded(solution, seed):
    recipe = replace(solution.plan.recipe, seed=seed)
    return replace(solution, plan=replace(solution.plan, recipe=recipe))


def timed(function):
    begun = time.process_time()
    result = function()
    return result, time.process_time() - begun


def points_seen(solution):
    """Return points and normals that a few of a picture's pixels look at."""
    camera, (w, h) = find_camera(solution.scene, None), SIZE
    xy = np.stack(np.meshgrid(np.arange(w) + 0.5, np.arange(h) + 0.5), -1).reshape(-1, 2)
    directions = rays(camera, SIZE, xy[::STRIDE])
    origins = np.broadcast_to(camera.position, directions.shape)
    rows, points = first_rows(solution, origins, directions)
    return points[rows >= 0], solution.patches.normal[rows[rows >= 0]]


def at_points(solution):
    """Yield ways to find irradiance by patches, CPU microseconds a point and rms errors."""
    points, normals = points_seen(solution)
    level, around, keys = solution.level, solution.surroundings, np.arange(len(points))

    def by_rays(samples, seed):
        return indirect_irradiance(around, points, normals, keys, range(samples), seed)[0]

    def by_links():
        sent = level.coefficients - level.emitted
        return arriving(level.senders, sent, points, normals).total

    truth = by_rays(8192, 5) @ Y
    by_links()  # compiles
    ways = {"exact weights": by_links}
    for samples in (64, 512, 2048):
        ways[f"{samples} rays"] = lambda n=samples: by_rays(n, 0)
    for name, way in ways.items():
        found, seconds = timed(way)
        error = np.sqrt(np.mean((found @ Y - truth) ** 2)) / truth.mean()
        yield name, 1e6 * seconds / len(points), error


def of_picture(solution, fine, samples):
    """Return CPU microseconds a pixel of whole pictures, true and estimated errors, and cover."""
    picture, seconds = timed(lambda: radiosity.render(solution, size=SIZE, samples=samples))
    plain = fine.lamp[..., 3] == 0 if fine.lamp is not None else np.full(SIZE[::-1], True)
    true, found = (luminance(p.pixels.astype(float))[plain] for p in (fine, picture))
    bar, mean = picture.error[plain], true.mean()
    cover = np.mean(np.abs(found - true) <= 2 * np.hypot(bar, fine.error[plain]) + 1e-9)
    rms = [np.sqrt(np.mean(e**2)) / mean for e in (found - true, bar)]
    return 1e6 * seconds / picture.error.size, *rms, cover


def main():
    begin(__doc__, "scene | way | CPU us a pixel | rms error | estimated | within two")
    for name in ("cornell_box", "lroom"):
        solution = radiosity.solve(radiosity.load(SCENES / f"{name}.toml"), 0.02)
        for way, cost, error in at_points(solution):
            print(f"| {name} | points, {way} | {cost:.0f} | {error:.2%} | | |")
        fine = radiosity.render(reseeded(solution, 9), size=SIZE, samples=FINE)
        for samples in (64, 128, 512, None):
            cost, true, bar, cover = of_picture(solution, fine, samples)
            way = "picture, default" if samples is None else f"picture, {samples} rays"
            print(f"| {name} | {way} | {cost:.0f} | {true:.2%} | {bar:.2%} | {cover:.1%} |")
            sys.stdout.flush()


main()
