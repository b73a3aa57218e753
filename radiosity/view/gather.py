"""Final gather: the light that reaches every pixel, computed per pixel, pass by pass (E8).

A pass adds one jittered sight line a pixel, a few rays to every light and some over the
hemisphere. The mean over the passes is the picture, so a window can show each as it comes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit

from radiosity.light.photometry import luminance
from radiosity.scene.model import Camera
from radiosity.solve.solution import Solution
from radiosity.transport.hemisphere import MISS, meet
from radiosity.transport.irradiance import direct_irradiance, indirect_irradiance
from radiosity.transport.sampling import hashed, sobol
from radiosity.transport.threads import Progress, over_ranges, silent
from radiosity.transport.visibility import LIFT
from radiosity.view.camera import rays
from radiosity.view.gloss import glossy_radiance
from radiosity.view.image import Image, exposure_for

SAMPLES = 256  # rays over a pixel's hemisphere by default
A_PASS = 16  # of them in one pass
LIGHT_RAYS = 4  # to each light in one pass
PIXELS_AT_ONCE = 4096
LAYERS = 16  # unmodelled backs that a sight line passes through


@dataclass(frozen=True)
class Shading:
    """What `radiance` needs to know of every patch: emission, diffuse reflectance, its lobe."""

    emission: np.ndarray  # (n, 3) W/(m2 sr)
    diffuse: np.ndarray  # (n, 3)
    lobe: np.ndarray  # (n,) index into lobes, -1 for none
    lobes: tuple


def render(
    solution: Solution,
    camera: Camera | str | None = None,
    *,
    size: tuple[int, int] | None = None,
    samples: int = SAMPLES,
    progress: Progress = silent,
) -> Image:
    """Gather a camera's picture.

    Parameters
    ----------
    solution : Solution
    camera : Camera or str, optional
        One of the scene's by name; its first by default.
    size : (w, h), optional
        Pixels, instead of the camera's own.
    samples : int
        Rays over each pixel's hemisphere.

    Returns
    -------
    Image
        (h, w, 3) radiance in W/(m2 sr), with the solution's automatic exposure.

    Raises
    ------
    ValueError
        No such camera, or a size or number of samples out of range.
    """
    count = pass_count(samples)
    total = count
    for image in passes(solution, camera, size=size, samples=samples):
        progress("final gather", total - count + 1, total)
        count -= 1
    return image


def pass_count(samples: int) -> int:
    """Return how many passes so many rays a pixel take."""
    if not 1 <= samples <= 1 << 20:
        raise ValueError(f"samples = {samples} must lie between 1 and 1048576 rays a pixel")
    return -(-samples // A_PASS)


def passes(
    solution: Solution,
    camera: Camera | str | None = None,
    *,
    size: tuple[int, int] | None = None,
    samples: int = SAMPLES,
) -> Iterator[Image]:
    """Yield the picture as it grows, after each pass; the last one is `render`'s."""
    camera = find_camera(solution.scene, camera)
    width, height = size or camera.size
    if not (1 <= width <= 16384 and 1 <= height <= 16384):
        raise ValueError(f"size = {width}x{height} must lie between 1x1 and 16384x16384 pixels")
    shading, exposure = make_shading(solution), auto_exposure(solution)
    total = np.zeros((width * height, 3))
    for index in range(pass_count(samples)):
        over_ranges(
            lambda a, b, k=index: _add(solution, shading, camera, (width, height), k, a, b, total),
            len(total), PIXELS_AT_ONCE,
        )  # fmt: skip
        yield Image((total / (index + 1)).reshape(height, width, 3), exposure)


def find_camera(scene, camera: Camera | str | None) -> Camera:
    """Return a camera of the scene by name, the first where none is named."""
    if isinstance(camera, Camera):
        return camera
    if camera is None:
        return next(iter(scene.cameras.values()))
    if camera not in scene.cameras:
        raise ValueError(
            f"camera = {camera!r} is not in the scene; it has {', '.join(scene.cameras)}"
        )
    return scene.cameras[camera]


def make_shading(solution: Solution) -> Shading:
    """Return the optical properties of every patch's active side."""
    scene, patches = solution.scene, solution.patches
    material = scene.faces.material[patches.face]
    lobes = tuple(m.specular for m in scene.materials)
    lobe = np.where([s is None for s in lobes], -1, np.arange(len(lobes)))[material]
    two_sided = np.array([m.two_sided for m in scene.materials])[material]
    reflects = patches.front | two_sided
    diffuse = np.array([m.diffuse for m in scene.materials])[material] * reflects[:, None]
    return Shading(solution.emission / np.pi, diffuse, np.where(reflects, lobe, -1), lobes)


def auto_exposure(solution: Solution) -> float:
    """Return one exposure for all views of a solution, from what its surfaces reflect."""
    reflected = (solution.radiosity - solution.emission) / np.pi
    dark = solution.live & ~solution.emission.any(axis=1)
    if not dark.any():
        reflected, dark = solution.radiosity / np.pi, solution.live
    return exposure_for(luminance(np.maximum(reflected[dark], 0)), solution.patches.area[dark])


@njit(cache=True, nogil=True)
def _jitter(first, width, index, seed, xy):
    for k in range(len(xy)):
        shift = hashed(first + k, 1, seed)
        xy[k, 0] = (first + k) % width + sobol(index, 0, shift)
        xy[k, 1] = (first + k) // width + sobol(index, 1, shift >> np.uint64(32))


def _add(solution, shading, camera, size, index, a, b, total):
    """Add one pass's radiance of the pixels a to b - 1."""
    xy = np.empty((b - a, 2))
    _jitter(a, size[0], index, solution.seed, xy)
    directions = rays(camera, size, xy)
    rows, points = first_rows(solution, np.broadcast_to(camera.position, directions.shape), directions)
    seen = rows >= 0
    total[a:b][rows == MISS] += solution.surroundings.field.outside / np.pi
    k = np.flatnonzero(seen)
    if len(k):
        total[a + k] += radiance(
            solution, shading, rows[k], points[k], -directions[k], a + k, index
        )


def first_rows(solution: Solution, origins: np.ndarray, directions: np.ndarray):
    """Follow sight lines to the first patch that is modelled, through backs that are not.

    Returns
    -------
    rows : (k,) int
        Patch, -1 where the sight line leaves the scene, -2 where it ends on a dark front.
    points : (k, 3) float64
        Where, in scene units.
    """
    around = solution.surroundings
    centre, scale = around.visibility.centre, around.visibility.scale
    start = ((origins - centre) * scale).astype(np.float32)
    ahead = directions.astype(np.float32)
    rows = np.full(len(start), MISS)
    active = np.arange(len(start))
    for _ in range(LAYERS):
        sides, ends = meet(around.visibility, around.table, start[active], ahead[active])
        start[active] = ends
        row = np.where(sides >= 0, around.field.row[sides], MISS)
        back = (sides >= 0) & (sides % 2 == 1)
        row[(sides >= 0) & ~back & (row < 0)] = -2
        rows[active] = row
        active = active[back & (row < 0)]
        if not len(active):
            break
        start[active] += 2 * LIFT * ahead[active]
    return rows, centre + start / scale


def radiance(solution: Solution, shading: Shading, rows, points, to_view, keys, index: int):
    """Return (k, 3) radiance in W/(m2 sr) that leaves points of patches towards the viewer.

    L = emission + diffuse E/pi + the lobe's reflection, with E gathered at the point.
    """
    around, seed = solution.surroundings, solution.seed
    normals = solution.patches.normal[rows]
    looks = range(index * A_PASS, (index + 1) * A_PASS)
    aims = range(index * LIGHT_RAYS, (index + 1) * LIGHT_RAYS)
    arriving, _ = indirect_irradiance(around, points, normals, keys, looks, seed)
    arriving += direct_irradiance(around, points, normals, keys, aims, seed)
    leaving = shading.emission[rows] + shading.diffuse[rows] * arriving / np.pi
    for which, lobe in enumerate(shading.lobes):
        k = np.flatnonzero(shading.lobe[rows] == which)
        if lobe is not None and len(k):
            leaving[k] += glossy_radiance(
                around, lobe, points[k], normals[k], to_view[k], keys[k], aims, seed
            )
    return leaving
