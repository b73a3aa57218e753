"""Make the pictures and the ball of ``textured_room.toml``: tiles, bricks and 128 flat faces."""

from pathlib import Path

import imageio.v3
import numpy as np

HERE = Path(__file__).resolve().parent
SIZE = 192
GLAZES = np.array([[0.85, 0.8, 0.7], [0.25, 0.42, 0.5], [0.8, 0.55, 0.35], [0.55, 0.6, 0.5]])
GROUT = np.array([0.45, 0.43, 0.4])


def from_edges(rows: int, columns: int, shift: float) -> np.ndarray:
    """Return (SIZE, SIZE) distances in texels to the nearest edge of blocks laid in rows."""
    y, x = np.mgrid[:SIZE, :SIZE] + 0.5
    tall, wide = SIZE / rows, SIZE / columns
    x = (x + wide * shift * (y // tall % 2)) % wide
    return np.minimum.reduce([x, wide - x, y % tall, tall - y % tall])


def tiles() -> np.ndarray:
    """Return (SIZE, SIZE, 3) sRGB values of 4 x 4 glazed tiles."""
    y, x = np.mgrid[:SIZE, :SIZE] * 4 // SIZE
    glaze = GLAZES[(x + 2 * y + x * y) % 4]
    return np.where((from_edges(4, 4, 0.0) < 2.0)[..., None], GROUT, glaze)


def bricks() -> np.ndarray:
    """Return (SIZE, SIZE) heights of 6 rows of 3 bricks with round edges, 1 the highest."""
    rise = np.clip((from_edges(6, 3, 0.5) - 1.5) / 6.0, 0.0, 1.0)
    return rise * rise * (3.0 - 2.0 * rise)


def ball(rings: int = 8, slices: int = 16) -> str:
    """Return a unit ball on the ground as an OBJ file; its normals are left to ``smooth``."""
    theta, phi = np.pi * np.arange(rings + 1) / rings, 2 * np.pi * np.arange(slices) / slices
    t, p = np.meshgrid(theta[1:-1], phi, indexing="ij")
    points = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t) + 1], axis=-1)
    lines = ["v 0 0 2", *("v {:.9f} {:.9f} {:.9f}".format(*v) for v in points.reshape(-1, 3))]
    last = len(lines) + 1
    lines.append("v 0 0 0")
    for k in range(slices):
        here, there = 2 + k, 2 + (k + 1) % slices
        lines.append(f"f 1 {here} {there}")
        for ring in range(rings - 2):
            a, b = ring * slices, (ring + 1) * slices
            lines.append(f"f {here + a} {here + b} {there + b} {there + a}")
        low = (rings - 2) * slices
        lines.append(f"f {last} {there + low} {here + low}")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the files beside this one."""
    for name, values in (("tiles", tiles()), ("bricks", bricks())):
        pixels = np.round(255 * values).astype(np.uint8)
        imageio.v3.imwrite(HERE / f"textured_room_{name}.png", pixels)
    (HERE / "textured_room_ball.obj").write_text(ball())


if __name__ == "__main__":
    main()
