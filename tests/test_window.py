"""The window: the camera's picture, gathered where it rests. Off-screen; needs some OpenGL."""

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from virtual_screen import virtual_screen

from radiosity.scene.files import load
from radiosity.scene.model import Camera
from radiosity.solve.solve import solve
from radiosity.view import gather, progressive, window
from radiosity.view.camera import project
from radiosity.view.falsecolour import Scale
from radiosity.view.image import tone_map
from radiosity.view.shading import auto_exposure
from radiosity.view.standpoint import current_camera
from radiosity.view.tones import Tones
from radiosity.view.window import Window, gathering, screen, viewer

ROOT = Path(__file__).resolve().parent.parent
SIZE = (96, 96)
DRAW = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(16, 16))
plotter.add_mesh(pyvista.Sphere())
assert plotter.screenshot(return_img=True).any()
"""


@pytest.fixture(scope="session")
def opengl():
    """Skip where VTK cannot draw; a child finds out, since VTK may take its process down."""
    pytest.importorskip("pyvista")
    probe = subprocess.run([sys.executable, "-c", DRAW], capture_output=True, text=True, timeout=60)
    if probe.returncode:
        pytest.skip(
            "VTK cannot draw off-screen here (exit status "
            f"{probe.returncode}); Debian needs libegl1 libegl-mesa0 libgl1-mesa-dri"
        )


@pytest.fixture(scope="module")
def glossy():
    return solve(load(ROOT / "scenes/cornell_glossy.toml"), accuracy=0.1)


@pytest.fixture
def opened(opengl, monkeypatch):
    """Return a function that opens windows, soon at rest, and closes them after the test."""
    monkeypatch.setattr(gathering, "REST", 0.02)
    windows = []

    def make(solution, *args, **options):
        windows.append(Window(solution, *args, off_screen=True, **options))
        return windows[-1]

    yield make
    for each in windows:
        each.close()


def shot(win):
    """Return the pixels as they are on the screen, texts and all."""
    return np.asarray(win.plotter.screenshot(return_img=True))[:, :, :3]


def press(win, key):
    interactor = win.plotter.iren.interactor
    interactor.SetKeySym(key)
    interactor.InvokeEvent("KeyPressEvent")


def gather_fully(win, limit=30.0):
    """Let time pass as the loop does until the picture is complete."""
    end = time.monotonic() + limit
    while not win.finished:
        assert time.monotonic() < end, "the gathering does not finish"
        win.tick()
        time.sleep(0.005)


def orbit(win, degrees):
    win.plotter.renderer.GetActiveCamera().Azimuth(degrees)
    win.plotter.render()


def face_of(solution, group, towards=(0.0, 0, 0)):
    """Return the vertices (4, 3) of that face of a group which faces a point most."""
    faces = solution.scene.faces
    mine = faces.group == solution.scene.groups.index(group)
    ahead = np.asarray(towards) - faces.vertices[mine].mean(axis=1)
    facing = np.einsum("fc,fc->f", faces.normals()[mine], ahead)
    return faces.vertices[mine][np.argmax(facing)]


CAMERAS = {
    "home": None,
    "oblique": Camera(
        "oblique", np.array([120.0, 90, -300]), np.array([300.0, 430, 220]),
        np.array([0.3, 1, 0.1]), 58.0, (200, 150),
    ),
    "orthographic": Camera(
        "upwards", np.array([90.0, 250, 60]), np.array([220.0, 540, 190]),
        np.array([1.0, 1, 0.1]), None, (200, 150), height=700.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("size", [(200, 150), (120, 210)])
@pytest.mark.parametrize("name", CAMERAS)
def test_the_camera_and_the_window_project_alike(glossy, opened, name, size):
    camera = CAMERAS[name] or glossy.scene.cameras["front"]
    win = opened(glossy, camera, size)
    points = np.random.default_rng(0).uniform(50, 500, (50, 3))
    expected, depth = project(camera, size, points)
    renderer = win.plotter.renderer
    for point, at in zip(points[depth > 0], expected[depth > 0], strict=True):
        renderer.SetWorldPoint(*point, 1)
        renderer.WorldToDisplay()
        x, y, _ = renderer.GetDisplayPoint()
        assert [x, size[1] - y] == pytest.approx(at, abs=0.01 * max(1, np.abs(at).max() / 100))


@pytest.mark.parametrize("name", CAMERAS)
def test_a_drawn_polygon_covers_the_pixels_that_the_camera_says(glossy, opened, name):
    camera = CAMERAS[name] or glossy.scene.cameras["front"]
    size = (200, 150)
    win = opened(glossy, camera, size)
    win.plotter.disable_anti_aliasing()  # which shifts edges by how bright their sides are
    white = shot_of_light(win)
    corners = project(camera, size, face_of(glossy, "light"))[0]
    inside = signed_distance(corners, size)
    assert np.sum(inside > 0.5) > 30, "the lamp must be in the picture"
    wrong = white != (inside > 0)
    assert np.abs(inside[wrong]).max(initial=0) < 0.1  # pixels
    rows, columns = np.nonzero(white)
    centre = np.nonzero(inside > 0)
    shift = [rows.mean() - centre[0].mean(), columns.mean() - centre[1].mean()]
    assert np.abs(shift).max() < 0.02  # pixels


def shot_of_light(win):
    """Return which pixels show the lamp, the only thing bright in blue."""
    return win.screenshot()[:, :, 2] > 200


def signed_distance(corners, size):
    """Return (h, w) distance in pixels of the pixel centres to a convex polygon's sides."""
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    edge = np.roll(corners, -1, axis=0) - corners
    area = np.sum(corners[:, 0] * np.roll(corners[:, 1], -1) - corners[:, 1] * np.roll(
        corners[:, 0], -1))  # fmt: skip
    normal = np.stack([-edge[:, 1], edge[:, 0]], axis=1) * np.sign(area)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    each = [n[0] * (x - c[0]) + n[1] * (y - c[1]) for n, c in zip(normal, corners, strict=True)]
    return np.min(each, axis=0)


def test_surfaces_show_the_interpolated_radiosity_in_the_pictures_tones(glossy, opened):
    win = opened(glossy, None, SIZE)
    wall = face_of(glossy, "right_green")
    back = glossy.patches.face == np.flatnonzero(
        np.all(glossy.scene.faces.vertices == wall, axis=(1, 2))
    )
    centre = glossy.patches.centroid[back]
    at = project(glossy.scene.cameras["front"], SIZE, centre)[0].astype(int)
    expected = tone_map(glossy.radiosity[back] / np.pi, auto_exposure(glossy))
    found = win.screenshot()[at[:, 1], at[:, 0]]
    differ = np.abs(found.astype(int) - expected).max(axis=1)
    assert np.median(differ) < 12  # of 255: a pixel is not the centroid


def test_a_gathered_window_is_the_rendered_picture(glossy, opened):
    win = opened(glossy, None, SIZE, samples=48)
    gather_fully(win)
    image = gather.render(glossy, current_camera(win.plotter, "now"), samples=48)
    differ = np.abs(shot(win).astype(int) - image.shown())
    assert differ.max() <= 2
    home = gather.render(glossy, size=SIZE, samples=48)
    differ = np.abs(shot(win).astype(int) - home.shown())
    assert np.mean(differ > 2) < 1e-3  # rounding of the camera may turn a sample at an edge


def test_an_orthographic_window_gathers_zooms_and_returns(glossy, opened):
    home = CAMERAS["orthographic"]
    win = opened(glossy, home, SIZE, samples=16)
    plain = win.screenshot()
    gather_fully(win)
    seen = current_camera(win.plotter, "now")
    assert seen.orthographic and seen.height == 700.0 and seen.fov is None
    image = gather.render(glossy, seen, samples=16)
    differ = np.abs(shot(win).astype(int) - image.shown())
    assert differ.max() <= 2
    assert np.abs(shot(win).astype(int) - plain).mean() < 20  # the same things at the same places
    win.plotter.camera.zoom(2.0)
    win.tick()
    assert current_camera(win.plotter, "now").height == 350.0
    assert not win.finished, "another extent is another view"
    press(win, "r")
    assert current_camera(win.plotter, "now").height == 700.0


def test_passes_are_shown_as_they_come(glossy, opened):
    win = opened(glossy, None, SIZE, samples=32)
    seen = []
    while not win.finished:
        win.tick()
        seen.append(shot(win))
        time.sleep(0.005)
    one = gather.render(glossy, size=SIZE, samples=16)
    first = one.shown()
    closest = min(np.mean(np.any(first != s, axis=2)) for s in seen)
    assert closest < 1e-3


def highlight(win, solution, pixels, face):
    """Return luminances (k,) of points of a face in a picture, NaN where another hides them."""
    camera = current_camera(win.plotter, "now")
    s, t = np.meshgrid(np.linspace(0.05, 0.95, 12), np.linspace(0.05, 0.95, 24))
    s, t = s.reshape(-1, 1), t.reshape(-1, 1)
    a, b, c, d = face
    points = (1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d
    offset = points - camera.position
    ahead = offset / np.linalg.norm(offset, axis=1, keepdims=True)
    _, met = gather.first_rows(solution, np.broadcast_to(camera.position, points.shape), ahead)
    at = project(camera, camera.size, points)[0].astype(int)
    seen = np.linalg.norm(met - points, axis=1) < 1.0  # mm
    value = np.full(len(points), np.nan)
    value[seen] = (pixels[at[seen, 1], at[seen, 0]] / 255.0) @ [0.2126, 0.7152, 0.0722]
    return value


def test_orbiting_moves_the_highlight(glossy, opened):
    win = opened(glossy, None, SIZE, samples=64)
    block = face_of(glossy, "tall_block", towards=glossy.scene.cameras["front"].position)
    wall = face_of(glossy, "back")
    seen = {}
    for view in ("home", "orbited"):
        if view == "orbited":
            orbit(win, 15)
        flat = win.screenshot()
        gather_fully(win)
        full = shot(win)
        for name, face in (("block", block), ("wall", wall)):
            seen[view, name, "raster"] = highlight(win, glossy, flat, face)
            seen[view, name, "gathered"] = highlight(win, glossy, full, face)

    def change(name, how):
        differ = np.abs(seen["home", name, how] - seen["orbited", name, how])
        assert np.sum(np.isfinite(differ)) > 100, "enough points must be seen in both views"
        return np.nanpercentile(differ, 90)

    assert change("block", "gathered") > 0.06  # of white
    assert change("block", "gathered") > 3 * change("block", "raster")
    assert change("block", "gathered") > 3 * change("wall", "gathered")


def test_moving_uncovers_the_surfaces_and_gathers_again_at_rest(glossy, opened, monkeypatch):
    monkeypatch.setattr(gathering, "REST", 0.2)
    win = opened(glossy, None, SIZE, samples=16)
    plain = win.screenshot()
    gather_fully(win)
    gathered = shot(win)
    orbit(win, 5)
    moved = win.screenshot()  # before any tick: the very frame that moves shows the surfaces
    assert not win.finished
    orbit(win, -5)
    assert np.abs(win.screenshot().astype(int) - plain).max() <= 2
    assert np.mean(moved != plain) > 0.1
    win.tick()
    assert not win.gathered.begun, "it moved just now"
    gather_fully(win)
    assert np.mean(np.any(shot(win) != gathered, axis=2)) < 1e-3
    win.plotter.window_size = (64, 48)
    win.plotter.render()
    assert not win.finished
    gather_fully(win)
    assert shot(win).shape == (48, 64, 3)


def test_back_faces_let_one_look_into_a_closed_room(opened):
    solution = solve(load(ROOT / "scenes/box6.toml"), accuracy=0.1)
    down, up = np.array([2.0, 1.5, 0]), np.array([0, 1.0, 0])
    above = Camera("above", np.array([2.0, 1.5, 8]), down, up, 40.0, SIZE)
    within = Camera("within", np.array([2.0, 1.5, 2.4]), down, up, 40.0, SIZE)
    win = opened(solution, above)
    floor = opened(solution, within).screenshot()[48, 48].astype(int)
    seen = win.screenshot()[48, 48].astype(int)
    assert floor.min() > 50 and np.abs(seen - floor).max() <= 3
    win.display.surfaces.actor.prop.culling = "none"
    ceiling = win.screenshot()[48, 48].astype(int)
    assert np.abs(ceiling - floor).min() > 50, "the roof would hide the floor"


def test_key_e_draws_edges_and_takes_them_away(glossy, opened):
    win = opened(glossy, None, SIZE)
    plain = win.screenshot()
    press(win, "e")
    edges = win.screenshot()
    assert win.display.surfaces.edges and np.mean(np.any(edges != plain, axis=2)) > 0.05
    press(win, "e")
    assert np.array_equal(win.screenshot(), plain)


def test_key_e_leaves_the_gathered_picture_until_they_are_gone(glossy, opened):
    win = opened(glossy, None, SIZE, samples=16)
    press(win, "e")
    edges = win.screenshot()
    press(win, "e")
    gather_fully(win)
    press(win, "e")
    win.tick()
    assert not win.gathered.begun and np.array_equal(win.screenshot(), edges)
    press(win, "e")
    gather_fully(win)


def test_key_g_uncovers_and_covers(glossy, opened):
    win = opened(glossy, None, SIZE, samples=16)
    before = shot(win)
    gather_fully(win)
    assert not np.array_equal(shot(win), before)
    press(win, "G")
    win.tick()
    assert not win.gathering and np.array_equal(shot(win), before)
    assert not win.gathered.begun
    press(win, "g")
    win.tick()
    assert win.gathered.begun, "at once"


def test_key_r_returns_to_the_scenes_camera(glossy, opened):
    win = opened(glossy, None, SIZE)
    plain = win.screenshot()
    orbit(win, 30)
    win.plotter.camera.zoom(1.5)
    win.plotter.render()
    assert np.mean(win.screenshot() != plain) > 0.3
    press(win, "r")
    assert np.array_equal(win.screenshot(), plain)
    camera, home = current_camera(win.plotter, "now"), glossy.scene.cameras["front"]
    assert camera.position == pytest.approx(home.position) and camera.fov == home.fov
    assert camera.size == SIZE and camera.name == "now"


def test_key_c_goes_through_the_scenes_cameras(glossy, opened):
    front, up = glossy.scene.cameras["front"], CAMERAS["orthographic"]
    both = replace(glossy, scene=replace(glossy.scene, cameras={"front": front, "up": up}))
    win = opened(both, "front", SIZE)
    plain = win.screenshot()
    press(win, "c")
    assert current_camera(win.plotter, "now").height == up.height
    orbit(win, 30)
    press(win, "r")
    seen = current_camera(win.plotter, "now")
    assert seen.position == pytest.approx(up.position) and seen.orthographic
    press(win, "c")
    assert np.array_equal(win.screenshot(), plain)
    other = opened(both, CAMERAS["oblique"], SIZE)  # none of the scene's
    press(other, "c")
    assert np.array_equal(other.screenshot(), plain)


def test_vtks_own_keys_do_nothing(glossy, opened):
    win = opened(glossy, None, SIZE)
    plain = win.screenshot()
    interactor = win.plotter.iren.interactor
    for key in "wsre3jtpfC":
        interactor.SetKeyCode(key)
        interactor.SetKeySym(key)
        interactor.InvokeEvent("CharEvent")
    assert np.array_equal(win.screenshot(), plain)


def test_key_f2_saves_what_is_shown_without_texts(glossy, opened, tmp_path, monkeypatch):
    import imageio.v3

    monkeypatch.chdir(tmp_path)
    win = opened(glossy, None, SIZE)
    press(win, "F2")
    press(win, "F2")
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "cornell_glossy-1.png", "cornell_glossy-2.png"]  # fmt: skip
    assert win._message[0] == f"saved cornell_glossy-2.png in {tmp_path}"
    assert np.array_equal(imageio.v3.imread("cornell_glossy-1.png"), win.screenshot())


def test_dragging_turns_about_the_scene_even_if_the_target_is_near(glossy, opened):
    win = opened(glossy, None, SIZE)  # its target lies 1 mm before the camera
    pivot = current_camera(win.plotter, "now").target
    low = glossy.scene.faces.vertices.min(axis=(0, 1))
    high = glossy.scene.faces.vertices.max(axis=(0, 1))
    assert np.all((low < pivot) & (pivot < high))


def test_closing_does_not_wait_for_the_gathering(glossy, opened, monkeypatch):
    whole = gather.passes

    def slow(*args, **options):
        for image in whole(*args, **options):
            time.sleep(2.0)
            yield image

    monkeypatch.setattr(progressive.gather, "passes", slow)
    win = opened(glossy, None, SIZE, samples=512)
    time.sleep(0.03)
    win.tick()
    thread = win.gathered._job.thread
    start = time.monotonic()
    win.close()
    assert time.monotonic() - start < viewer.PARTING + 0.5
    thread.join(5.0)
    assert not thread.is_alive(), "it ends after the pass that it was in"


def test_a_failed_gathering_is_told_and_leaves_the_surfaces(glossy, opened, monkeypatch):
    def broken(*args, **options):
        raise MemoryError("no room for the picture")
        yield

    monkeypatch.setattr(progressive.gather, "passes", broken)
    win = opened(glossy, None, SIZE)
    time.sleep(0.03)
    win.tick()
    win.gathered._job.thread.join(5.0)
    with pytest.raises(MemoryError, match="no room"):
        win.tick()
    assert not win.gathering
    win.tick()


def test_a_window_keeps_the_exposure_asked_when_it_gathers(glossy, opened):
    tones = Tones(3.0 * auto_exposure(glossy))
    win = opened(glossy, None, SIZE, samples=16, tones=lambda _: tones)
    assert win.screenshot().mean() > opened(glossy, None, SIZE).screenshot().mean() + 20
    gather_fully(win)
    image = gather.render(glossy, current_camera(win.plotter, "now"), samples=16)
    differ = np.abs(shot(win).astype(int) - replace(image, exposure=tones.exposure).shown())
    assert differ.max() <= 2
    with pytest.raises(ValueError, match="exposure = 0 must be positive"):
        window.show(glossy, off_screen=True, exposure=0)


def test_a_window_in_false_colours_gathers_in_them(glossy, opened):
    scale = Scale(300.0)
    win = opened(glossy, None, SIZE, samples=16, tones=lambda _: Tones(1.0, scale))
    plain = win.screenshot()
    gather_fully(win)
    image = gather.render(glossy, current_camera(win.plotter, "now"), samples=16)
    expected = scale.colours(image.luminance)
    found = shot(win)
    assert np.mean(np.any(found != expected, axis=2)) < 1e-3
    assert np.abs(plain.astype(int) - expected).mean() < 20  # surfaces, alike


def test_show_off_screen_returns_the_picture(glossy, opened):
    picture = window.show(glossy, size=(40, 30), off_screen=True)
    assert picture.shape == (30, 40, 3) and picture.dtype == np.uint8 and picture.any()
    with pytest.raises(ValueError, match="front"):
        window.show(glossy, "side", off_screen=True)


def test_without_a_display_there_is_no_window(glossy, monkeypatch):
    monkeypatch.setattr(screen.sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert not window.display_available.__wrapped__()
    monkeypatch.setenv("DISPLAY", ":4711")
    assert not window.display_available.__wrapped__()
    monkeypatch.setattr(screen.sys, "platform", "darwin")
    assert window.display_available.__wrapped__()
    pytest.importorskip("pyvista")
    monkeypatch.setattr(screen, "display_available", lambda: False)
    with pytest.raises(RuntimeError, match=r"DISPLAY = ':4711'.*off_screen=True"):
        window.show(glossy)


LOOP = """
import sys, time
from radiosity.scene.files import load
from radiosity.solve.solve import solve
from radiosity.view.window import Window, display_available
assert display_available()
win = Window(solve(load(sys.argv[1]), accuracy=0.1), size=(96, 96), samples=160)
keys, look = win.plotter.iren.interactor, win.tick
def press(key):
    keys.SetKeySym(key)
    keys.InvokeEvent("KeyPressEvent")
def tick():
    look()
    if win.finished:
        print("gathered", time.monotonic() - start, flush=True)
        press("q")
win.tick = tick
start = time.monotonic()
win.run()
win.close()
print("closed", flush=True)
"""


def test_the_loop_lets_the_thread_compute_and_q_ends_it(opengl, tmp_path):
    """A real window: VTK's own loop would hold the interpreter's lock (20 s a pass, not 0.1)."""
    with virtual_screen(tmp_path, (320, 240)) as screen:
        child = subprocess.run(
            [sys.executable, "-c", LOOP, str(ROOT / "scenes/cornell_glossy.toml")],
            env=screen.environment | {"PYTHONPATH": str(ROOT)},
            capture_output=True, text=True, timeout=60,
        )  # fmt: skip
    assert child.returncode == 0, child.stderr
    gathered, closed = child.stdout.splitlines()[-2:]
    assert closed == "closed"
    assert float(gathered.split()[1]) < 20.0  # seconds, for 10 passes of about 0.1
