"""Picture a scene by all methods side by side: radiosity, ray tracing, local shading, no shadows.

python scenes/three_levels.py scenes/cornell_box.toml -o three_levels.png
"""

import argparse
from dataclasses import replace

import numpy as np

import radiosity
from radiosity.view.image import Image, write

GAP = 6  # pixels between pictures


def side_by_side(scene, accuracy: float, size: tuple[int, int]) -> Image:
    """Return the pictures of a scene's first camera beside each other, of one exposure."""
    solution = radiosity.solve(scene, accuracy)
    ways = ("gather", True), ("raytrace", True), ("local", True), ("local", False)
    images = [
        radiosity.render(solution, size=size, method=method, shadows=shadows)
        for method, shadows in ways
    ]
    gap = np.zeros((size[1], GAP, 3))
    parts = [part for image in images for part in (gap, image.pixels)][1:]
    return replace(images[0], pixels=np.concatenate(parts, axis=1), error=None, lamp=None)


def main() -> None:
    """Read the command line and write the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene")
    parser.add_argument("-o", default="three_levels.png")
    parser.add_argument("--accuracy", type=float, default=0.02)
    parser.add_argument("--size", type=int, nargs=2, default=(256, 256))
    asked = parser.parse_args()
    write(side_by_side(radiosity.load(asked.scene), asked.accuracy, tuple(asked.size)), asked.o)


if __name__ == "__main__":
    main()
