"""The scenes with a mirror and with glass, small: what must be seen in their pictures."""

import subprocess
import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity.view.camera import project

SCENES = Path(__file__).resolve().parent.parent / "scenes"


def pictured(name, size, method="raytrace"):
    scene = radiosity.load(SCENES / f"{name}.toml")
    of = radiosity.solve(scene, 0.3) if method == "gather" else scene
    pixels = radiosity.render(of, size=size, samples=16, method=method).pixels
    return scene.cameras["front"], pixels


def seen_at(camera, pixels, point):
    """Return the pixel (3,) that shows a point."""
    xy, _ = project(camera, pixels.shape[1::-1], np.array([point], float))
    return pixels[int(xy[0, 1]), int(xy[0, 0])]


def test_the_mirror_shows_the_side_of_the_block_that_is_turned_away():
    """Where its image stands, mirrored in y = 4.999: blue, which the camera sees nowhere else.

    The lamp does not see that side: the mirror lights it.
    """
    camera, pixels = pictured("mirror_room", (64, 64), "gather")
    r, g, b = seen_at(camera, pixels, [1.5, 2 * 4.999 - 3.3, 0.8])
    assert b > 2 * r and b > 2 * g
    away = pixels.copy()
    mirror, _ = project(camera, (64, 64), np.array([[0.6, 4.999, 2.3], [3.4, 4.999, 0.5]]))
    (left, top), (right, bottom) = mirror.round().astype(int)
    away[top - 1 : bottom + 2, left - 1 : right + 2] = 0
    assert not np.any((away[..., 2] > 2 * away[..., 0]) & (away[..., 2] > 0.05))


def test_the_ball_shows_what_lies_behind_the_other_way_round():
    camera, pixels = pictured("glass_ball", (128, 128))
    beside = [seen_at(camera, pixels, [x, 2.999, 1.5]) for x in (0.8, 2.2)]
    assert beside[0][0] > 2 * beside[0][2] and beside[1][2] > 2 * beside[1][0]  # orange, teal
    through = [seen_at(camera, pixels, [x, 1.1, 0.45]) for x in (1.3, 1.7)]
    assert through[0][2] > through[0][0] and through[1][0] > through[1][2]


def test_the_ball_s_file_is_what_its_script_makes():
    sys.path.insert(0, str(SCENES))
    try:
        from glass_ball import ball
    finally:
        sys.path.remove(str(SCENES))
    assert (SCENES / "glass_ball.obj").read_text() == ball()


def test_levels_are_pictured_side_by_side(tmp_path):
    out = tmp_path / "levels.png"
    done = subprocess.run(
        [sys.executable, str(SCENES / "three_levels.py"), str(SCENES / "box6.toml"), "-o", str(out),
         "--accuracy", "0.3", "--size", "24", "24"],
        capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert out.read_bytes().startswith(b"\x89PNG")
