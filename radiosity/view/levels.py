"""The three levels of light in pictures side by side: time and error of each, measured."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from radiosity.light.photometry import luminance
from radiosity.scene.model import Scene
from radiosity.solve.solution import Solution
from radiosity.solve.solve import solve
from radiosity.view import gather
from radiosity.view.image import Image
from radiosity.view.methods import make_stage

LONGEST = 160  # pixels of the longer side of what is compared
REFERENCE_SAMPLES = 2048  # rays over each pixel's hemisphere of the reference
WARM = (8, 6)  # pixels of a picture that loads compiled code


@dataclass(frozen=True)
class PictureTrial:
    """One way to make a picture, and what came of it.

    Attributes
    ----------
    way : str
        The method, and "no shadows" where lights cast none.
    seconds : float
        Warm, of solving where a solution is needed, and of the picture.
    error : float
        Rms error of the luminance of pixels without lamps, over their mean in the reference.
    image : Image
        With the exposure of the reference.
    """

    way: str
    seconds: float
    error: float
    image: Image


def compared_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return a picture's (w, h) in pixels, made smaller to be compared."""
    less = min(1.0, LONGEST / max(size))
    return tuple(max(1, round(less * side)) for side in size)


def picture_trials(
    scene: Scene, accuracy: float, reference: Solution, size: tuple[int, int] | None = None
) -> Iterator[PictureTrial]:
    """Yield the methods' pictures of the first camera, compared with one of a finer solution.

    Of ``size`` (w, h) in pixels, or the camera's own, made smaller by `compared_size`.
    """
    camera = gather.find_camera(scene, None)
    size = size or compared_size(camera.size)
    best = gather.render(reference, camera, size=size, samples=REFERENCE_SAMPLES)
    ways = {
        "gather": lambda: solve(scene, accuracy),
        "raytrace": lambda: make_stage(scene, False, accuracy=accuracy),
        "local": lambda: make_stage(scene, True, accuracy=accuracy),
        "local, no shadows": lambda: make_stage(scene, True, shadows=False, accuracy=accuracy),
    }
    for way, make in ways.items():
        gather.render(make(), camera, size=WARM)
        begun = time.perf_counter()
        image = gather.render(make(), camera, size=size)
        seconds = time.perf_counter() - begun
        shown = replace(image, exposure=best.exposure)
        yield PictureTrial(way, seconds, picture_error(image, best), shown)


def picture_error(image: Image, reference: Image) -> float:
    """Return the rms error of the luminance over its mean, of pixels that show no lamp."""
    plain = np.ones(reference.pixels.shape[:2], bool)
    if reference.lamp is not None:
        plain = reference.lamp[..., -1] == 0
    found, true = (luminance(x.pixels.astype(float))[plain] for x in (image, reference))
    mean = true.mean() if plain.any() else 0.0
    return float(np.sqrt(np.mean((found - true) ** 2)) / mean) if mean > 0 else 0.0
