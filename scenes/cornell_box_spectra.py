"""Compare the Cornell box in wavelengths, in three bands, and path-traced, as CIE Delta E.

    python scenes/cornell_box_spectra.py [--size 256] [-o cornell_spectra.png]

Draws the box from its measured spectra in 32 wavelengths, the same spectra in three bands, and the
path-traced reference, whose three bands were published with the box; below them the differences
CIEDE2000, as a screen shows the pictures (D65 is white). A path tracer leaves noise, so the
reference is compared over blocks of 8 x 8 of its pixels, and at equal mean luminance, for its lamp
was given another brightness. The same three bands by this program are compared with it, too: what
is left there is the error of both programs. Exits 1 where that has a mean above 0.5.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from compared import Reference, blocks, reference

import radiosity
from radiosity.light.colour import RGB_TO_XYZ, delta_e_2000, in_gamut, lab
from radiosity.light.photometry import luminance

HERE = Path(__file__).resolve().parent
WAVELENGTHS, SAMPLES, BOUND = 32, 128, 0.5
LEAST, MOST = 0.05, 10.0  # Delta E at the ends of the scale


def main() -> int:
    """Draw and print the comparison; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--accuracy", type=float, default=0.02)
    parser.add_argument("--size", type=int, default=256, help="pixels: 64, 128 or 256 a side")
    parser.add_argument("-o", "--output", default="cornell_spectra.png")
    args = parser.parse_args()
    if args.size not in (64, 128, 256):
        parser.error(f"--size {args.size} must be 64, 128 or 256: the reference has 256 pixels")
    spectral = picture("cornell_box_spectral", WAVELENGTHS, args)
    three = picture("cornell_box_spectral", "rgb", args)
    published = picture("cornell_box", "rgb", args)
    truth = reference("cornell_box")
    pixels = differences(spectral.pixels, three.pixels, spectral.exposure)
    side = args.size // len(truth.inside)
    seen = np.kron(truth.inside, np.ones((side, side), bool))
    maps = {
        f"{WAVELENGTHS} wavelengths - three bands": np.where(seen, pixels, np.nan),
        f"{WAVELENGTHS} wavelengths - reference": against(spectral, truth),
        "published bands - reference": against(published, truth),
    }
    brighter = level(spectral.pixels, truth.inside) / level(truth.pixels, truth.inside)
    traced = radiosity.Image(truth.pixels * brighter, spectral.exposure)
    pictures = {
        f"measured spectra, {WAVELENGTHS} wavelengths": spectral.shown(),
        "measured spectra, three bands": three.shown(),
        "path-traced reference": traced.shown(),
    }
    for name, found in maps.items():
        print(f"Delta E 2000, {name}: {told(found)}")
    draw(pictures, maps, args.output)
    print(f"the reference is shown {brighter:.3f} times as bright as it is; {args.output}")
    return int(np.nanmean(maps["published bands - reference"]) > BOUND)


def picture(name: str, bands, args) -> radiosity.Image:
    """Return the gathered picture of a scene in some bands.

    With as many samples in all, whose noise is then alike and does not look like colour.
    """
    solution = radiosity.solve(radiosity.load(HERE / f"{name}.toml", bands=bands), args.accuracy)
    return radiosity.render(solution, size=(args.size, args.size), samples=SAMPLES)


def level(pixels: np.ndarray, inside: np.ndarray) -> float:
    """Return the mean luminance of the blocks that are compared."""
    return luminance(blocks(pixels, len(inside)))[inside].mean()


def against(image: radiosity.Image, truth: Reference) -> np.ndarray:
    """Return Delta E (b, b) of blocks at equal mean luminance, NaN where not compared."""
    found, expected = (blocks(x, len(truth.inside)) for x in (image.pixels, truth.pixels))
    scale = level(image.pixels, truth.inside) / level(truth.pixels, truth.inside)
    differ = differences(found, expected * scale, image.exposure)
    return np.where(truth.inside, differ, np.nan)


def differences(one: np.ndarray, two: np.ndarray, exposure: float) -> np.ndarray:
    """Return CIEDE2000 (...) between radiances (..., 3) as a screen shows them."""
    white = RGB_TO_XYZ.sum(axis=1)
    shown = (np.clip(in_gamut(x.astype(float) * exposure), 0, 1) @ RGB_TO_XYZ.T for x in (one, two))
    return delta_e_2000(*(lab(xyz, white) for xyz in shown))


def told(found: np.ndarray) -> str:
    """Return a map's mean and 95th percentile in words."""
    return f"mean {np.nanmean(found):.2f}, 95 % below {np.nanpercentile(found, 95):.2f}"


def draw(pictures: dict, maps: dict, path: str) -> None:
    """Write the pictures above the maps of Delta E."""
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure
    from matplotlib.ticker import FormatStrFormatter

    figure = Figure(figsize=(9.6, 6.9), layout="constrained")
    axes = figure.subplots(2, 3)
    for place, (name, shown) in zip(axes[0], pictures.items(), strict=True):
        place.imshow(shown)
        place.set_title(name, fontsize=9)
    for place, (name, found) in zip(axes[1], maps.items(), strict=True):
        shown = np.maximum(found, LEAST)
        drawn = place.imshow(shown, norm=LogNorm(LEAST, MOST), interpolation="nearest")
        place.set_title(f"$\\Delta E_{{00}}$, {name}\n{told(found)}", fontsize=9)
    for place in axes.flat:
        place.set_axis_off()
    bar = figure.colorbar(drawn, ax=axes[1], label="CIEDE2000", shrink=0.9)
    bar.set_ticks([0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10], minor=False)
    bar.minorticks_off()
    bar.ax.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    figure.savefig(path, dpi=100)


if __name__ == "__main__":
    sys.exit(main())
