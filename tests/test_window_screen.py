"""The window on a real screen, driven by real key and mouse events; its pixels are judged."""

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_window import opengl  # noqa: F401
from virtual_screen import virtual_screen

from radiosity.light.photometry import illuminance
from radiosity.scene.files import load
from radiosity.solve.solve import solve
from radiosity.view.camera import project, rays
from radiosity.view.image import tone_map
from radiosity.view.scales import illuminance_scale
from radiosity.view.shading import auto_exposure
from radiosity.view.sightlines import first_rows
from radiosity.view.window.drawing import panel
from radiosity.view.window.geometry import Corners
from radiosity.view.window.hud import MARGIN, line_height
from radiosity.view.window.lamps import FULL, Lamps
from radiosity.view.window.panels import lamp_rows, reading_rows
from radiosity.view.window.picking import with_error

ROOT = Path(__file__).resolve().parent.parent
SCENE, SIZE, AMBIENT = ROOT / "scenes/cornell_box.toml", (480, 480), 0.3


@pytest.fixture(scope="module")
def solved():
    """Return what the window solves: two groups of light, the lamp and ambient light."""
    scene = load(SCENE)
    return solve(replace(scene, ambient=np.full(3, AMBIENT)), accuracy=0.1)


@pytest.fixture(scope="module")
def screen(tmp_path_factory, opengl):  # noqa: F811
    with virtual_screen(tmp_path_factory.mktemp("screen"), SIZE) as started:
        yield started


def view(screen, folder, *words):
    """Start ``radiosity view`` in a folder."""
    command = [sys.executable, "-m", "radiosity", "view", *map(str, words)]
    return subprocess.Popen(
        command, cwd=folder, env=screen.environment | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def ended(child, limit=240.0):  # what compiles is waited for
    """Return the exit code and what was said on stderr."""
    said = child.communicate(timeout=limit)[1]
    assert "Traceback" not in said, said
    return child.returncode, said


def centres(solution):
    """Return patches whose middle the camera sees, away from the panels, and their pixels."""
    camera, patches = solution.scene.cameras["front"], solution.patches
    at, _ = project(camera, SIZE, patches.centroid)
    free = np.all((at > 0.15 * np.array(SIZE)) & (at < 0.8 * np.array(SIZE)), axis=1)
    free &= ~solution.emission.any(axis=1)
    ahead = patches.centroid - camera.position
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    seen, _ = first_rows(solution, np.broadcast_to(camera.position, ahead.shape), ahead)
    rows = np.flatnonzero(free & (seen == np.arange(len(patches))))
    return rows, at[rows].astype(int)


def shown(pixels, at, expected, most=14):
    """Whether pixels have about these colours: a pixel is not a patch's mean."""
    found = pixels[at[:, 1], at[:, 0]].astype(int)
    return np.median(np.abs(found - expected).max(axis=1)) < most


def holds(pixels, part, left, top):
    """Whether a panel's words are on the screen at a place, whatever shines through it."""
    height, width, _ = part.shape
    there = pixels[top : top + height, left : left + width].astype(int)
    ink = part[:, :, :3].max(axis=2) > 200
    return ink.sum() > 20 and np.abs(there[ink] - part[ink, :3]).mean() < 8


def test_keys_and_mouse_on_the_screen(solved, screen, tmp_path):
    words = "--accuracy", 0.1, "--ambient", AMBIENT, "--size", "{}x{}".format(*SIZE)
    child = view(screen, tmp_path, SCENE, *words)
    try:
        rows, at = centres(solved)
        assert len(rows) > 10
        exposure = auto_exposure(solved)
        plain = tone_map(solved.radiosity[rows] / np.pi, exposure)
        screen.until(lambda p: shown(p, at, plain), "the solution, smooth and tone-mapped")
        screen.key("g")  # the smooth view stays

        screen.xdotool("mousemove", 240, 200, "key", "f")
        scale = illuminance_scale(solved)
        colours = scale.colours(solved.illuminance[rows])
        false = screen.until(lambda p: shown(p, at, colours), "illuminance in false colours")
        table = {tuple(c) for c in scale.colours(scale.luminance((np.arange(256) + 0.5) / 256))}
        columns = [len(table & set(map(tuple, false[:, x]))) for x in range(SIZE[0] // 2, SIZE[0])]
        assert max(columns) > 200, "a scale with all of the colours stands at the right"

        def refined(pixels):
            wall = (slice(120, 250), slice(160, 340))  # most of the back wall, without panels
            return shown(pixels, at, colours) and np.any(pixels != false, axis=2)[wall].mean() > 0.5

        screen.until(refined, "about the same illuminance, but on the fine mesh")
        pick(solved, screen)
        screen.key("f", "f")  # over luminance back to the picture
        screen.until(lambda p: shown(p, at, plain), "the picture again")
        dim(solved, screen, rows, at, exposure)

        screen.key("F2")
        saved = tmp_path / "cornell_box-1.png"
        end = time.monotonic() + 10
        while not saved.exists():
            assert time.monotonic() < end
            time.sleep(0.05)
        screen.key("q")
        code, said = ended(child)
        assert code == 0, said
    finally:
        child.kill()


def pick(solution, screen):
    """Click on the back wall and find its illuminance, gathered there, on the screen."""
    camera, x, y = solution.scene.cameras["front"], 300, 160
    origin, ahead = (v[0] for v in rays(camera, SIZE, np.array([[x + 0.5, y + 0.5]])))
    depth = solution.scene.faces.vertices[:, :, 2].max()
    point, normal = origin + (depth - origin[2]) / ahead[2] * ahead, np.array([0.0, 0, -1])
    e, error = solution.irradiance(point[None], normal[None])
    bands = solution.scene.bands
    lux = with_error(illuminance(e, bands)[0], illuminance(error, bands)[0])
    words = reading_rows([lux])
    part = panel(words, line_height(SIZE)).pixels
    part = part[: -MARGIN, : -MARGIN]  # its lower right corner is further away below other lines
    screen.click(x, y)

    def told(pixels):
        places = range(SIZE[0] // 3, SIZE[0] - part.shape[1])
        return any(holds(pixels, part, left, MARGIN) for left in places)

    pixels = screen.until(told, lux)
    ring = pixels[y - 12 : y + 13, x - 12 : x + 13].astype(int)
    white = np.abs(ring - 242).max(axis=2) < 20
    assert white.sum() > 20, "the point is marked"


def dim(solution, screen, rows, at, exposure):
    """Drag the lamp's slider to a third, and find the picture as dark as it must be."""
    lamps = Lamps(solution, Corners(solution))
    control = panel(lamp_rows(lamps, 9), line_height(SIZE)).controls[0]
    y = MARGIN + (control.top + control.bottom) // 2
    low, high = (MARGIN + v for v in control.track)
    x = round(low + (high - low) / 6)
    factor = round(control.value(x + 0.5 - MARGIN) * FULL, 2)
    screen.drag((round((low + high) / 2), y), (x, y))
    less = solution.dimmed({"light": factor}).radiosity[rows]
    assert 0.3 < factor < 0.37 and less.mean() < 0.7 * solution.radiosity[rows].mean()
    expected = tone_map(less / np.pi, exposure)
    screen.until(lambda p: shown(p, at, expected, 8), "the light of a lamp dimmed by the mouse")
    screen.key("1")
    off = tone_map(solution.dimmed({"light": 0.0}).radiosity[rows] / np.pi, exposure)
    screen.until(lambda p: shown(p, at, off, 8), "what the ambient light alone does")


def test_closing_while_solving_ends_cleanly(screen, tmp_path):
    child = view(screen, tmp_path, SCENE, "--accuracy", 0.003, "--quiet")
    try:
        screen.until(lambda p: p[200:300].std() > 10, "the scene while it is solved")
        time.sleep(0.5)
        screen.xdotool("mousemove", 240, 200, "key", "q")
        code, said = ended(child)
        assert code == 130 and said == ""  # given up, as by Ctrl-C
    finally:
        child.kill()


def test_what_ends_the_solve_is_told_once(screen, tmp_path):
    child = view(screen, tmp_path, SCENE, "--mesh", 40, "--memory", "1MB", "--quiet")
    code, said = ended(child)
    assert code == 3 and said.startswith("radiosity: ") and "memory" in said
