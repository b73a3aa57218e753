"""Draw the thermal enclosure from inside: its radiosity J in kW/m2; print the net heat.

    python scenes/enclosure.py [--size 320] [-o enclosure.png]

Bands of 1 kW/m2; docs/thermal.md tells the rest.
"""

import argparse
from pathlib import Path

import numpy as np

import radiosity

HERE = Path(__file__).resolve().parent


def main() -> None:
    """Solve, print net heat by material, and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=320, help="pixels a side")
    parser.add_argument("-o", "--output", default="enclosure.png")
    args = parser.parse_args()
    scene = radiosity.load(HERE / "enclosure.toml", bands="grey")
    solution = radiosity.solve(scene)
    area = solution.patches.area * scene.unit_m**2
    heat = area * (solution.radiosity - solution.irradiance_on)[:, 0]
    material = scene.faces.material[solution.patches.face]
    for k, made_of in enumerate(scene.materials):
        print(f"{made_of.name:<8}{heat[material == k].sum() + 0.0:>10.1f} W net")
    image = radiosity.render(solution, size=(args.size, args.size))
    draw(np.pi * image.pixels[:, :, 0] / 1000.0, args.output)


def draw(exitance: np.ndarray, path: str) -> None:
    """Write (h, w) radiosities in kW/m2 in false colours with a scale."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2, 4.2), layout="constrained")
    axes = figure.subplots()
    drawn = axes.imshow(exitance, cmap=colormaps["inferno"].resampled(23), vmin=0.0, vmax=23.0)
    axes.set_axis_off()
    figure.colorbar(drawn, ax=axes, label="radiosity J in kW/m2", shrink=0.9)
    figure.savefig(path, dpi=100)


if __name__ == "__main__":
    main()
