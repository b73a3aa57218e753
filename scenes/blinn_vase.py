"""Make the vase of ``blinn_vase.toml``, a surface of revolution about z, and two textures for it.

The object and the patterns of Blinn's figures 7 and 8 are not published; these stand in for them.
"""

from pathlib import Path

import imageio.v3
import numpy as np
from scipy.interpolate import CubicSpline

HERE = Path(__file__).resolve().parent
RINGS, SLICES = 24, 36
# Radius at heights, along the profile from the foot to the lip.
PROFILE = np.array(
    [[0.62, 0.0], [0.59, 0.1], [0.74, 0.42], [0.97, 0.85], [1.0, 1.25], [0.76, 1.8],
     [0.46, 2.25], [0.4, 2.5], [0.47, 2.72], [0.64, 2.9]]
)  # fmt: skip
TEXELS = 192


def vase() -> str:
    """Return the vase as an OBJ file, u once around it and v from the foot to the lip."""
    steps = np.linalg.norm(np.diff(PROFILE, axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(steps)])
    radius, height = CubicSpline(arc, PROFILE)(np.linspace(0.0, arc[-1], RINGS + 1)).T
    phi = 2.0 * np.pi * np.arange(SLICES) / SLICES
    lines = ["# a vase, made by blinn_vase.py"]
    for r, z in zip(radius, height, strict=True):
        lines += [f"v {r * np.cos(p):.5f} {r * np.sin(p):.5f} {z:.5f}" for p in phi]
    for k in range(RINGS + 1):
        lines += [f"vt {j / SLICES:.5f} {k / RINGS:.5f}" for j in range(SLICES + 1)]
    for k in range(RINGS):
        for j in range(SLICES):
            v = [k * SLICES + j, k * SLICES + (j + 1) % SLICES]
            t = [k * (SLICES + 1) + j, k * (SLICES + 1) + j + 1]
            v, t = v + [i + SLICES for i in v[::-1]], t + [i + SLICES + 1 for i in t[::-1]]
            lines.append("f " + " ".join(f"{a + 1}/{b + 1}" for a, b in zip(v, t, strict=True)))
    return "\n".join(lines) + "\n"


def weave() -> np.ndarray:
    """Return (TEXELS, TEXELS) a pattern of strands, dull where they pass below."""
    v, u = (np.mgrid[:TEXELS, :TEXELS] + 0.5) / TEXELS
    across = np.sin(2 * np.pi * 12 * u) * np.sin(2 * np.pi * 10 * v)
    return 0.5 - 0.5 * np.tanh(4.0 * across)


def blots() -> np.ndarray:
    """Return (TEXELS, TEXELS) smooth random blots that repeat, dull on shiny ground."""
    around, up = np.fft.fftfreq(TEXELS), 1.8 * np.fft.fftfreq(TEXELS)  # 1.8 times round as high
    square = up[:, None] ** 2 + around[None] ** 2
    noise = np.random.default_rng(7).normal(size=(TEXELS, TEXELS))
    field = np.fft.ifft2(np.fft.fft2(noise) * np.exp(-square / (2 * 0.05**2))).real
    return 0.5 + 0.5 * np.tanh(3.0 * field / field.std())


def main() -> None:
    """Write the files beside this one."""
    (HERE / "blinn_vase.obj").write_text(vase())
    for name, values in (("weave", weave()), ("blots", blots())):
        pixels = np.round(255 * values).astype(np.uint8)
        imageio.v3.imwrite(HERE / f"blinn_vase_{name}.png", pixels)


if __name__ == "__main__":
    main()
