"""The parts of the window that need no graphics, and its panels and commands off the screen."""

import threading
import time
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from test_window import opengl, press  # noqa: F401

from radiosity.light.photometry import illuminance, photometric
from radiosity.scene.files import load
from radiosity.solve.solve import solve
from radiosity.view.camera import project
from radiosity.view.falsecolour import Scale
from radiosity.view.methods import make_stage
from radiosity.view.polydata import to_pyvista
from radiosity.view.scales import error_shares, illuminance_scale, luminance_scale, round_numbers
from radiosity.view.sightlines import first_rows
from radiosity.view.standpoint import current_camera
from radiosity.view.tones import Tones
from radiosity.view.window import Window, gathering
from radiosity.view.window.geometry import Corners, bare_faces
from radiosity.view.window.later import Later
from radiosity.view.window.look import RANGE, Look
from radiosity.view.window.panels import ALL
from radiosity.view.window.picking import read, seen_at, with_error, words
from radiosity.view.window.saving import save_all
from radiosity.view.window.solving import Solving
from radiosity.view.window.surfaces import contours, triangles_of

ROOT = Path(__file__).resolve().parent.parent
SIZE = (480, 480)


@pytest.fixture(scope="module")
def lit():
    """Return a solution of two groups of light, the lamp and ambient light."""
    scene = load(ROOT / "scenes/cornell_box.toml")
    return solve(replace(scene, ambient=np.full(3, 0.3)), accuracy=0.1)


@pytest.fixture
def opened(opengl, lit, monkeypatch):  # noqa: F811
    """Return a window off the screen that gathers nothing, unless it is told to."""
    win = Window(lit, size=SIZE, samples=8, off_screen=True)
    win.gathering = False
    yield win
    win.close()


def settle(win, until=lambda win: True, limit=20.0):
    """Let time pass until threads have ended and a condition holds."""
    end = time.monotonic() + limit
    while True:
        win.tick()
        busy = win.display.lamps.waiting or win.pick.measuring or win.display.estimating
        if not busy and until(win):
            win.tick()
            return
        assert time.monotonic() < end
        time.sleep(0.01)


def test_lines_lie_where_the_interpolated_value_is_theirs():
    rng = np.random.default_rng(1)
    points, triangles = rng.uniform(0, 1, (60, 3)), rng.permutation(60).reshape(20, 3)
    slope = np.array([0.3, -0.8, 0.5])
    ends, normals, at = contours(points, triangles, points @ slope, [-0.2, 0.1])
    assert len(ends) > 10 and set(at) == {-0.2, 0.1}
    assert ends @ slope == pytest.approx(np.repeat(at, 2).reshape(-1, 2), abs=1e-12)
    along = ends[:, 1] - ends[:, 0]
    assert np.einsum("kc,kc->k", along, normals) == pytest.approx(0.0, abs=1e-12)


def test_cells_are_drawn_as_fans():
    cells = np.array([4, 0, 1, 2, 3, 3, 4, 5, 6])
    assert triangles_of(cells).tolist() == [[0, 1, 2], [4, 5, 6], [0, 2, 3]]


def test_bare_faces_show_their_shapes_in_their_colours(lit):
    scene = lit.scene
    points, cells, rgb = bare_faces(scene, scene.cameras["front"])
    assert len(points) == len(rgb) and cells.max() == len(points) - 1
    white = scene.bands.to_rgb(scene.materials[0].diffuse)
    triangles = triangles_of(cells)
    shades = {}
    for name, axis, value in (("back", 2, 559.2), ("floor", 1, 0.0), ("ceiling", 1, 548.8)):
        mine = np.isclose(points[triangles][:, :, axis], value, atol=0.05).all(axis=1)
        shade = rgb[triangles[mine]].reshape(-1, 3) / white
        shades[name] = shade[np.ptp(shade, axis=1) < 1e-9, 0].max()
    assert shades["back"] > shades["floor"] + 0.1 > shades["ceiling"] + 0.2
    assert shades["ceiling"] == pytest.approx(0.35) and shades["back"] < 1.0


def test_corners_keep_means_and_steps(lit):
    corners = Corners(lit)
    flat = corners.flat(lit.illuminance)
    assert set(np.unique(flat)) == set(np.unique(lit.illuminance[corners.shown]))
    smooth, same = corners.smooth(lit.radiosity), to_pyvista(lit)
    assert corners.points == pytest.approx(same.points, rel=1e-6)
    expected = same.point_data["radiosity_W_m2"]
    bright = expected.min(axis=1) > 0.3 * expected.mean()
    assert bright.mean() > 0.3 and smooth[bright] == pytest.approx(expected[bright], rel=1e-6)


def test_later_returns_or_keeps_the_error():
    failed = Later(lambda: 1 / 0)
    failed.thread.join()
    assert failed.ready and isinstance(failed.error, ZeroDivisionError) and failed.result is None


def test_a_solve_tells_its_stage_and_ends_at_its_next_report():
    gate, early = threading.Event(), threading.Event()

    def work(progress, watch):
        progress("form factors", 1, 4)
        watch("half")
        early.set()
        gate.wait(5.0)
        progress("form factors", 2, 4)
        return "whole"

    one, two = Solving(work), Solving(work)
    one.start()
    two.start()
    early.wait(5.0)
    time.sleep(0.05)
    assert (one.newest, one.stage.name, one.stage.share, one.ready) == (
        "half", "form factors", 0.25, False)  # fmt: skip
    two.stop(0.0)
    gate.set()
    for each in (one, two):
        each.thread.join(5.0)
        assert each.ready and each.error is None
    assert one.newest == "whole" and two.newest == "half"
    left = replace(one.stage, begun=10.0, told=12.0)
    assert left.left() == pytest.approx(2.0) and left.over(16.5) and not left.over(12.5)
    assert replace(left, told=10.1).left() is None
    failed = Solving(lambda progress, watch: 1 / 0)
    failed.start()
    failed.thread.join(5.0)
    assert isinstance(failed.error, ZeroDivisionError)


def test_exposure_goes_by_stops_and_scales_by_round_ends(lit):
    look = Look(Tones(0.2), automatic=0.1)
    assert look.from_automatic == pytest.approx(1.0)
    look.step(up=True)
    assert look.exposure == pytest.approx(0.2 * 2**0.5)
    look.expose(-RANGE)
    assert look.exposure == pytest.approx(0.1 / 2**RANGE)
    look.adapt(0.4)
    assert look.exposure == pytest.approx(0.4)
    look.mode = "illuminance"
    first = look.scale(lit)
    assert first == illuminance_scale(lit) and first.unit == "lx"
    look.step(up=True)
    assert 1.5 * first.maximum < look.scale(lit).maximum < 3 * first.maximum
    look.adapt(0.4)
    assert look.scale(lit) == first and look.exposure == pytest.approx(0.4)
    look.logarithmic = True
    assert look.scale(lit).decades == 3.0
    assert luminance_scale(lit).unit == "cd/m\u00b2"
    assert round_numbers(Scale(800.0, 0.0, "lx")).tolist() == [100, 200, 300, 400, 500, 600, 700,
                                                               800]  # fmt: skip


def test_a_reading_is_what_the_solution_gathers(lit):
    camera = replace(lit.scene.cameras["front"], size=SIZE)
    place = seen_at(lit, camera, 300.5, 160.5)
    found = read(lit, place)
    e, error = lit.irradiance(place.point[None], [[0, 0, -1]])
    assert found.illuminance == pytest.approx(illuminance(e, lit.scene.bands)[0])
    assert found.error == pytest.approx(illuminance(error, lit.scene.bands)[0])
    rho = lit.scene.materials[0].diffuse
    assert found.luminance == pytest.approx(float(photometric(rho * e[0] / np.pi)))
    assert (found.material, found.group, found.back, found.unit) == ("white", "back", False, "mm")
    assert any("reflects 71.1 %" in line for line in words(found))
    assert seen_at(lit, camera, 1.5, 1.5).patch == -1  # beside the box
    assert with_error(0.01234, 0.0005) == "0.0123 \u00b1 0.0005 lx"
    assert with_error(3120.0, 42.0) == "3120 \u00b1 42 lx"


def test_without_a_solution_a_reading_has_no_error(lit):
    stage = make_stage(lit.scene, local=True, accuracy=0.1)
    camera = replace(lit.scene.cameras["front"], size=SIZE)
    found = read(stage, seen_at(stage, camera, 300.5, 160.5))
    assert found.error == np.inf and words(found)[0].endswith("lx, error unknown")


def test_errors_are_relative_as_the_accuracy_is(lit):
    lamp = lit.dimmed({"ambient": 0.0})
    lux, error, live = lamp.illuminance, illuminance(lamp.error, lamp.scene.bands), lamp.live
    mean = np.average(lux[live], weights=lamp.patches.area[live])
    for mine, base in ((lux > 0.1 * mean, lux), (lux < 0.1 * mean, np.full(len(lux), 0.1 * mean))):
        mine = mine & live
        assert mine.any()
        assert error_shares(lamp)[mine] == pytest.approx(100 * error[mine] / base[mine])


def test_dimmed_light_is_the_dimmed_solutions(opened, lit):
    whole = [x.copy() for x in opened.display.lamps.at_corners()]
    opened.dim("light", 0.4)
    settle(opened)
    lamps, corners = opened.display.lamps, Corners(lit)
    expected = lit.dimmed({"light": 0.4})
    b, e = lamps.at_corners()
    for found, values in ((b, expected.radiosity), (e, expected.irradiance_on)):
        assert found == pytest.approx(np.maximum(corners.smooth(values), 0.0), abs=1e-9)
    assert np.array_equal(lamps.solution.radiosity, expected.radiosity)
    press(opened, "1")
    settle(opened)
    assert lamps.factors == {"light": 0.0, "ambient": 1.0}
    off = lit.dimmed(lamps.factors)
    assert np.array_equal(lamps.solution.radiosity, off.radiosity)
    press(opened, "1")
    assert lamps.factors == {"light": 0.4, "ambient": 1.0}  # as bright as before
    opened.dim("light", 1.0)
    settle(opened)
    for found, before in zip(lamps.at_corners(), whole, strict=True):
        assert np.array_equal(found, before)
    press(opened, "9")  # no such group
    assert lamps.factors == {"light": 1.0, "ambient": 1.0}


def overlaps(win):
    """Return which pairs of panels lie over each other, and which leave the window."""
    places = {n: p for n in ALL if (p := win.hud.place_of(n)) is not None}
    found = [
        (one, two)
        for (one, (x, y, w, h)), (two, (u, v, wide, high)) in combinations(places.items(), 2)
        if x < u + wide and u < x + w and y < v + high and v < y + h and "help" not in (one, two)
    ]
    width, height = win.size
    return found + [
        n for n, (x, y, w, h) in places.items()
        if x < 0 or y < 0 or x + w > width or y + h > height
    ]  # fmt: skip


def test_no_panel_lies_over_another(opened):
    opened.plotter.window_size = (640, 480)
    press(opened, "p")
    opened.commands.pick(300.5, 160.5)
    settle(opened)
    opened.say("a message of many words, such as where a file was written: " + "folder/" * 12)
    for size in ((512, 512), (400, 300), (900, 400), (1100, 800)):
        opened.plotter.window_size = size
        for mode in ("picture", "illuminance", "error"):
            opened.show_mode(mode)
            opened.plotter.render()
            assert opened.hud.place_of("hint") and opened.hud.place_of("notes")
            assert not overlaps(opened), (size, mode)
        press(opened, "h")
        opened.plotter.render()
        assert opened.hud.place_of("help") and not overlaps(opened)
        press(opened, "Escape")
    opened.plotter.window_size = (120, 90)
    opened.plotter.render()
    assert not any(opened.hud.place_of(name) for name in ALL), "no room for words"


def test_help_lies_over_what_came_later(opened):
    def within():
        pixels = np.asarray(opened.plotter.screenshot(return_img=True))[:, :, :3].astype(int)
        return pixels[y + 8 : y + h - 8, x + 8 : x + w - 8]  # its corners are round

    press(opened, "h")
    opened.plotter.render()
    x, y, w, h = opened.hud.place_of("help")
    before = within()
    opened.commands.pick(300.5, 160.5)
    settle(opened)
    left, top, _, high = opened.hud.place_of("reading")
    assert left < x + w - 20 and y + 20 < top + high, "it lies there, too"
    assert np.abs(within() - before).max() < 20  # nearly opaque


def test_false_colours_are_interpolated_in_lux(opened, lit):
    press(opened, "f")
    press(opened, "i")
    opened.tick()
    scale = illuminance_scale(lit)
    assert opened.display.scale == scale and not len(opened.display.levels)
    rows = np.flatnonzero(lit.patches.front & lit.live)
    camera = lit.scene.cameras["front"]
    at, _ = project(camera, SIZE, lit.patches.centroid[rows])
    ahead = lit.patches.centroid[rows] - camera.position
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    seen, _ = first_rows(lit, np.broadcast_to(camera.position, ahead.shape), ahead)
    good = (seen == rows) & (at > 90).all(axis=1) & (at < 350).all(axis=1)
    pixels = opened.screenshot()[at[good, 1].astype(int), at[good, 0].astype(int)]
    table = scale.colours(scale.luminance((np.arange(256) + 0.5) / 256)).astype(int)
    far = np.abs(pixels[:, None].astype(int) - table).sum(axis=2)
    assert far.min(axis=1).max() <= 6, "only colours of the scale"
    lux = scale.maximum * (far.argmin(axis=1) + 0.5) / 256
    expected = np.minimum(lit.illuminance[rows[good]], scale.maximum)
    assert np.median(np.abs(lux / expected - 1.0)) < 0.1
    before = opened.screenshot()
    press(opened, "i")
    opened.tick()
    assert len(opened.display.levels) > 3
    lines = np.any(opened.screenshot() != before, axis=2)
    assert 0.002 < lines[90:350, 90:350].mean() < 0.2


def test_lines_on_sides_that_face_away_are_not_drawn(opened):
    press(opened, "f")
    opened.tick()
    ends, normals, _ = opened.display.surfaces._segments
    drawn = opened.display.surfaces._lines.mapper.dataset.n_cells
    eye = np.array(opened.plotter.camera.position)
    assert drawn == np.sum(np.sum((eye - ends[:, 0]) * normals, axis=1) > 0)
    assert drawn < len(ends)


def test_the_error_is_shown_with_its_scale(opened, lit):
    press(opened, "x")
    settle(opened, lambda win: win.display.scale is not None)
    assert opened.display.look.mode == "error" and opened.display.scale.unit == "%"
    assert opened.display.scale.maximum >= error_shares(lit)[lit.live].max()
    press(opened, "x")
    assert opened.display.look.mode == "picture"


def test_walking_keeps_the_height_of_the_eyes(opened, lit):
    before = current_camera(opened.plotter, "a")
    press(opened, "w")
    opened.commands.halt("w")
    after = current_camera(opened.plotter, "b")
    move = after.position - before.position
    assert move[2] > 0 and abs(move[1]) < 1e-9 and move[0] == pytest.approx(0.0, abs=1e-6)
    assert after.target - after.position == pytest.approx(before.target - before.position)
    extent = np.linalg.norm(np.ptp(lit.scene.faces.vertices, axis=(0, 1)))
    assert np.linalg.norm(move) == pytest.approx(0.2 * 0.08 * extent)
    press(opened, "Prior")
    opened.commands.halt("Prior")
    assert current_camera(opened.plotter, "c").position[1] > after.position[1]
    sight = current_camera(opened.plotter, "c")
    assert opened.commands.look_around(0.5, 0.0)  # half the window's height: 45 degrees
    turned = current_camera(opened.plotter, "d")
    assert turned.position == pytest.approx(sight.position)
    one, two = (c.target - c.position for c in (sight, turned))
    cosine = one @ two / np.linalg.norm(one) / np.linalg.norm(two)
    assert cosine == pytest.approx(np.cos(np.radians(45)), abs=1e-3)
    press(opened, "o")
    assert not opened.commands.look_around(0.5, 0.0)
    assert current_camera(opened.plotter, "e").position == pytest.approx(turned.position)


def test_an_exposed_picture_is_gathered_once(opened, monkeypatch):
    monkeypatch.setattr(gathering, "REST", 0.02)
    opened.gathering = True
    settle(opened, lambda win: win.finished)
    image = opened.gathered.image
    for _ in range(3):
        press(opened, "plus")
    assert not opened.finished
    settle(opened, lambda win: win.finished)
    assert opened.gathered.image is image
    shown = np.asarray(opened.plotter.screenshot(return_img=True))[100:300, 150:350, :3]
    exposure = opened.display.look.exposure
    assert exposure == pytest.approx(opened.display.look.automatic * 2**1.5)
    expected = replace(image, exposure=exposure).shown()[100:300, 150:350]
    assert np.abs(shown.astype(int) - expected).max() <= 2


def test_radiance_and_solution_are_saved_together(opened, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(gathering, "REST", 0.02)
    opened.gathering = True
    settle(opened, lambda win: win.finished)
    press(opened, "F3")
    settle(opened, lambda win: win._saving is None)
    names = sorted(p.name for p in tmp_path.iterdir())
    assert names == ["cornell_box-1.exr", "cornell_box-1.radsol"]
    told = opened._message[0]
    assert told == f"saved cornell_box-1.exr and cornell_box-1.radsol in {tmp_path}"
    import OpenEXR

    with OpenEXR.File(str(tmp_path / names[0])) as file:
        pixels = file.parts[0].channels["RGB"].pixels
    assert np.array_equal(pixels, opened.gathered.image.pixels)


def test_what_cannot_be_saved_is_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def full(place):
        raise OSError(28, "No space left on device", str(place))

    assert save_all("room.toml", {".png": full}).startswith("not saved: ")
    (tmp_path / "room-1.exr").touch()
    assert "room-2.png" in save_all("room.toml", {".png": lambda p: p.touch(), ".exr": Path.touch})


def test_closing_waits_for_what_is_saved(opened, tmp_path):
    def slow():
        time.sleep(0.3)
        (tmp_path / "kept").touch()
        return "saved"

    opened.save(slow)
    opened.save(lambda: (tmp_path / "second").touch())  # one at a time
    opened.close()
    assert [p.name for p in tmp_path.iterdir()] == ["kept"]


def test_nothing_is_saved_while_the_lamps_are_told_apart(opened, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    gate, lamps = threading.Event(), opened.display.lamps
    told_apart = lamps._told_apart
    monkeypatch.setattr(lamps, "_told_apart", lambda: gate.wait(20) and told_apart())
    opened.dim(lamps.names[0], 0.0)
    assert lamps.waiting
    opened.commands.save_light()
    assert not list(tmp_path.iterdir()) and "told apart" in opened._message[0]
    gate.set()


def test_a_lamp_comes_back_as_bright_as_it_was(opened):
    lamps = opened.display.lamps
    opened.dim(lamps.names[0], 0.3)
    found = []
    for _ in range(3):
        opened.commands.switch_light(0)
        found.append(lamps.factors[lamps.names[0]])
    assert found == [0.0, 0.3, 0.0]


def test_a_writer_that_fails_ends_no_window(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def wrong(place):
        raise ValueError("no such light")

    assert save_all("room.toml", {".radsol": wrong}) == "not saved: no such light"


def test_what_an_observer_raises_is_not_forgotten(opened, monkeypatch):
    def broken(solution, place):
        raise ValueError("no reading")

    monkeypatch.setattr(opened.commands, "toggle_help", lambda: 1 / 0)
    press(opened, "h")
    with pytest.raises(ZeroDivisionError):
        opened.tick()
    opened.tick()
    monkeypatch.setattr("radiosity.view.window.picking.read", broken)
    opened.commands.pick(300.5, 160.5)
    with pytest.raises(ValueError, match="no reading"):
        settle(opened)


def test_a_key_that_repeats_itself_walks_no_faster(opened):
    start = np.array(opened.plotter.camera.position)
    for _ in range(5):  # as X does: let go and pressed again, at once
        press(opened, "w")
        opened.commands.halt("w")
    once = np.linalg.norm(np.array(opened.plotter.camera.position) - start)
    extent = np.linalg.norm(np.ptp(opened.scene.faces.vertices, axis=(0, 1)))
    assert once == pytest.approx(0.2 * 0.08 * extent)
    time.sleep(0.06)
    opened.tick()
    assert not opened.walk.moving


def test_numbers_lie_on_their_lines_where_these_are_seen(opened, lit):
    press(opened, "f")
    opened._since = 0.0
    opened.tick()
    shown = opened._labels._shown
    assert len(shown) >= 5
    middles, places = opened.display.surfaces.lines()
    at, _ = project(replace(lit.scene.cameras["front"], size=SIZE), SIZE, middles)
    values = np.round(opened.display.scale.luminance(places), 6)
    for name in shown:
        x, y, w, h = opened.hud.place_of(name)
        value = float(opened.hud._sheets[name].key[0])
        near = np.hypot(*(at - [x + w / 2, y + h / 2]).T) < 1.5
        assert value in values[near]
    orbiting = opened.plotter.camera
    orbiting.Azimuth(5)
    opened.plotter.render()
    assert not opened._labels._shown, "they come again at rest"


def test_what_a_solve_finds_is_shown_until_its_answer_is(opengl, lit, monkeypatch):  # noqa: F811
    monkeypatch.setattr(gathering, "REST", 0.02)
    found, answered = threading.Event(), threading.Event()
    early = lit.dimmed({"light": 0.1})

    def work(progress, watch):
        found.wait(5.0)
        watch(early)
        answered.wait(5.0)
        return lit

    solving = Solving(work)
    win = Window(lit.scene, size=SIZE, samples=8, off_screen=True, solving=solving)
    try:
        solving.start()
        shots = [win.screenshot()]
        found.set()
        settle_solve(win, lambda: win.display.solution is early)
        shots.append(win.screenshot())
        win.commands.pick(300.5, 160.5)
        press(win, "1")
        assert win.answer is None and win.pick.place is None and not win.display.lamps.changed
        win.commands.toggle_error()
        assert win.display.look.mode == "picture" and "before the answer" in win._message[0]
        answered.set()
        settle_solve(win, lambda: win.answer is lit)
        shots.append(win.screenshot())
        settle(win, lambda win: win.finished)
    finally:
        win.close()
    for one, two in combinations(shots, 2):
        assert np.mean(np.any(one != two, axis=2)) > 0.1


def settle_solve(win, condition, limit=10.0):
    end = time.monotonic() + limit
    while not condition():
        win.tick()
        assert time.monotonic() < end
        time.sleep(0.01)


def test_what_ends_a_solve_ends_the_loop(opengl, lit):  # noqa: F811
    def work(progress, watch):
        raise ValueError("no light")

    solving = Solving(work)
    win = Window(lit.scene, size=SIZE, off_screen=True, solving=solving)
    try:
        solving.start()
        with pytest.raises(ValueError, match="no light"):
            settle_solve(win, lambda: False)
    finally:
        win.close()
