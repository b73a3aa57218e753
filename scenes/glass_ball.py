"""Make the ball of ``glass_ball.toml``: a unit sphere as an OBJ file with smooth normals."""

from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
RINGS, SLICES = 8, 16


def ball(rings: int = RINGS, slices: int = SLICES) -> str:
    """Return a unit ball about the origin, whose normals point from its centre."""
    theta, phi = np.pi * np.arange(rings + 1) / rings, 2 * np.pi * np.arange(slices) / slices
    t, p = np.meshgrid(theta[1:-1], phi, indexing="ij")
    around = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)
    points = np.concatenate([[[0, 0, 1]], around.reshape(-1, 3), [[0, 0, -1]]])
    lines = [f"{key} {x:.9f} {y:.9f} {z:.9f}" for key in ("v", "vn") for x, y, z in points]
    last = len(points)
    for k in range(slices):
        here, there = 2 + k, 2 + (k + 1) % slices
        lines.append(_face(1, here, there))
        for ring in range(rings - 2):
            a, b = ring * slices, (ring + 1) * slices
            lines.append(_face(here + a, here + b, there + b, there + a))
        low = (rings - 2) * slices
        lines.append(_face(last, there + low, here + low))
    return "\n".join(lines) + "\n"


def _face(*corners) -> str:
    return "f " + " ".join(f"{k}//{k}" for k in corners)


if __name__ == "__main__":
    (HERE / "glass_ball.obj").write_text(ball())
