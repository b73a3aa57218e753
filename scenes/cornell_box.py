"""Reproduce the Cornell box: solve it, gather its picture, and compare both with path tracing.

    python scenes/cornell_box.py [--accuracy 0.02] [--size 256] [-o cornell_box.png]

Prints irradiance at 27 points beside the reference (Mitsuba 3, path tracing) and the errors,
relative to the luminance there or a tenth of its mean, whichever is larger.
Exits 1 where the median error of the irradiance exceeds 1 % or the error of the picture 2 %.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity.light.photometry import luminance

HERE = Path(__file__).resolve().parent
REFERENCE = HERE / "cornell_box_reference"
MEDIAN_BOUND, PICTURE_BOUND = 0.01, 0.02
BLOCK = 8  # pixels: both pictures are noisy, so blocks of 8 x 8 are compared
BLOCKS = 32


def main() -> int:
    """Run the comparison; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--accuracy", type=float, default=0.02)
    parser.add_argument("--size", type=int, default=256, help="pixels: 64, 128 or 256 a side")
    parser.add_argument("--samples", type=int, default=128, help="rays over a pixel's hemisphere")
    parser.add_argument("-o", "--output", default="cornell_box.png")
    args = parser.parse_args()
    if args.size not in (64, 128, 256):
        parser.error(f"--size {args.size} must be 64, 128 or 256: the reference has 256 pixels")
    if Path(args.output).suffix not in (".png", ".exr", ".hdr", ".npy"):
        parser.error(f"-o {args.output!r} must end in .png, .exr, .hdr or .npy")
    solution = radiosity.solve(radiosity.load(HERE / "cornell_box.toml"), args.accuracy)
    errors = point_errors(solution)
    image = radiosity.render(solution, size=(args.size, args.size), samples=args.samples)
    radiosity.write(image, args.output)
    picture = picture_error(image.pixels)
    median, high = np.median(errors), np.percentile(errors, 95)
    print(f"irradiance: median error {median:.2%}, 95 % below {high:.2%}, {len(errors)} points")
    print(f"picture: relative rms error {picture:.2%} over blocks of single faces; {args.output}")
    return int(median > MEDIAN_BOUND or picture > PICTURE_BOUND)


def point_errors(solution) -> np.ndarray:
    """Print irradiance beside the reference; return the errors relative to max(Y, Y_mean / 10)."""
    points = np.loadtxt(REFERENCE / "points.csv", delimiter=",", skiprows=1)
    table = np.genfromtxt(
        REFERENCE / "irradiance.csv", delimiter=",", names=True, dtype=None, encoding="utf-8"
    )
    reference = np.stack([table[f"E_{band}"] for band in "rgb"], axis=1)
    found, _ = solution.irradiance(points[:, :3], points[:, 3:])
    area = solution.patches.area[solution.live]
    mean = area @ luminance(solution.irradiance_on[solution.live]) / area.sum()
    y, y_reference = luminance(found), luminance(reference)
    errors = np.abs(y - y_reference) / np.maximum(y_reference, 0.1 * mean)
    print(f"{'surface':12}{'E r':>9}{'g':>9}{'b':>9}{'reference':>13}{'g':>9}{'b':>9}{'error':>9}")
    for row, e, r, error in zip(table, found, reference, errors, strict=True):
        mine, theirs = "".join(f"{v:9.4f}" for v in e), "".join(f"{v:9.4f}" for v in r[1:])
        print(f"{row['object']:12}{mine}{r[0]:13.4f}{theirs}{error:9.2%}")
    return errors


def picture_error(pixels: np.ndarray) -> float:
    """Return the rms error of luminance over blocks of interior pixels, relative as above."""
    data = np.load(REFERENCE / "image.npz", allow_pickle=False)
    reference = luminance(data["image"].astype(float))
    size = reference.shape[0] // BLOCKS
    lit = reference[reference > 0]
    inside = data["interior"].astype(bool) & (reference < 10 * np.median(lit))  # not the lamp
    counts = _block_sums(inside.astype(float), size)
    whole = counts == size * size
    expected = _block_sums(reference, size) / size**2
    mine = _block_sums(luminance(pixels.astype(float)), len(pixels) // BLOCKS)
    found = mine / (len(pixels) // BLOCKS) ** 2
    found, expected = found[whole], expected[whole]
    scale = np.maximum(expected, 0.1 * expected.mean())
    return float(np.sqrt(np.mean(((found - expected) / scale) ** 2)))


def _block_sums(values: np.ndarray, size: int) -> np.ndarray:
    return values.reshape(BLOCKS, size, BLOCKS, size).sum(axis=(1, 3))


if __name__ == "__main__":
    sys.exit(main())
