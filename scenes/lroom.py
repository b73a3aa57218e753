"""Compare the picture of the L-shaped room, lit round a corner, with path tracing.

    python scenes/lroom.py [--size 192] [-o lroom.png]

The lamp hangs in the leg at the right; what is seen at the end of the other leg has been reflected
twice and more. Draws the picture, the path-traced reference and the difference of luminance over
blocks. Exits 1 where its rms exceeds 2 % of the mean.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from compared import SIDE, deviation, reference

import radiosity

HERE = Path(__file__).resolve().parent
BOUND = 0.02
BRIGHTER = 4.0  # than the room's automatic exposure, which its lit leg decides
SCALE = 5.0  # per cent at the ends of the scale


def main() -> int:
    """Draw and print the comparison; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--accuracy", type=float, default=0.02)
    parser.add_argument("--size", type=int, default=192, help="pixels: 48, 96 or 192 a side")
    parser.add_argument("-o", "--output", default="lroom.png")
    args = parser.parse_args()
    if args.size not in (48, 96, 192):
        parser.error(f"--size {args.size} must be 48, 96 or 192: the reference has 192 pixels")
    solution = radiosity.solve(radiosity.load(HERE / "lroom.toml"), args.accuracy)
    image = radiosity.render(solution, size=(args.size, args.size))
    truth = reference("lroom")
    found, rms = deviation(image.pixels, truth)
    image = replace(image, exposure=BRIGHTER * image.exposure)
    traced = radiosity.Image(truth.pixels, image.exposure)
    draw(image.shown(), traced.shown(), 100.0 * found, f"rms {rms:.2%} of the mean", args.output)
    print(f"luminance over blocks of {SIDE} x {SIDE} pixels: rms error {rms:.2%}; {args.output}")
    return int(rms > BOUND)


def draw(shown, traced, per_cent, words: str, path: str) -> None:
    """Write the pictures and the map of their difference, side by side."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.4, 3.7), layout="constrained")
    axes = figure.subplots(1, 3)
    axes[0].imshow(shown)
    axes[0].set_title("radiosity", fontsize=9)
    axes[1].imshow(traced)
    axes[1].set_title("path-traced reference", fontsize=9)
    drawn = axes[2].imshow(
        per_cent, cmap="coolwarm", vmin=-SCALE, vmax=SCALE, interpolation="nearest"
    )
    axes[2].set_title(f"difference, {SIDE} x {SIDE} blocks: {words}", fontsize=9)
    for place in axes:
        place.set_axis_off()
    figure.colorbar(drawn, ax=axes[2], label="% of the mean", shrink=0.9)
    figure.savefig(path, dpi=100)


if __name__ == "__main__":
    sys.exit(main())
