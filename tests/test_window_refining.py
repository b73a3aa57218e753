"""Illuminance in the window, on the fine mesh that a thread makes."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_window import opengl, press  # noqa: F401

from radiosity.light.photometry import illuminance
from radiosity.scene.files import load
from radiosity.solve.solve import solve
from radiosity.view.fine import finemesh
from radiosity.view.methods import make_stage
from radiosity.view.scales import illuminance_scale, spread_scale
from radiosity.view.window import Window, refining
from radiosity.view.window.geometry import Corners
from radiosity.view.window.refining import Refining, fine_of
from radiosity.view.window.surfaces import contours, triangles_of

ROOT = Path(__file__).resolve().parent.parent
SIZE, POINTS = (320, 320), 12_000


@pytest.fixture(scope="module")
def lit():
    """Return a solution of two groups of light, the lamp and ambient light."""
    scene = load(ROOT / "scenes/cornell_box.toml")
    return solve(replace(scene, ambient=np.full(3, 0.3)), accuracy=0.1)


@pytest.fixture(scope="module")
def shown(opengl, lit):  # noqa: F811
    """Return a window in false colours on its fine mesh, and the notes that it showed before."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(finemesh, "MOST", POINTS)
        win = Window(lit, size=SIZE, off_screen=True)
        press(win, "f")
        win.notes = wait(win)
    yield win
    win.close()


def wait(win, limit=30.0):
    """Let time pass until the mesh is there; return which notes were on the screen, and lines."""
    end, seen = time.monotonic() + limit, []
    while win.display.refining.mesh is None:
        win.tick()
        share = win.display.refining.share
        if share is not None:
            seen.append((share, win.hud.place_of("notes") is not None, win.display.levels))
        assert time.monotonic() < end
        time.sleep(0.005)
    return seen


def misses(solution, lines, scale, count=200):
    """Return (k,) by how much of itself illuminance is another at points of lines, than told."""
    ends, normals, places = lines
    long = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    some = np.random.default_rng(7).choice(len(ends), count, p=long / long.sum())
    normals = normals[some] / np.linalg.norm(normals[some], axis=1, keepdims=True)
    e, _ = solution.irradiance(ends[some].mean(axis=1), normals)
    return np.abs(illuminance(e, solution.scene.bands) / scale.luminance(places[some]) - 1.0)


def drawn(win):
    """Return the lines that are drawn, as `contours` returns them."""
    ends, normals, _ = win.display.surfaces._segments
    return ends, normals, win.display.surfaces._places


def test_lines_lie_where_the_solution_has_their_illuminance(shown, lit):
    display, corners = shown.display, Corners(lit)
    assert len(drawn(shown)[0]) > 1000 and len(display.levels) > 4
    off = misses(lit, drawn(shown), display.scale)
    assert np.quantile(off, 0.95) < 0.01  # what is left between vertices: see docs/page.md
    lux = np.maximum(illuminance(corners.smooth(lit.irradiance_on), lit.scene.bands), 0.0)
    scale, levels = display.scale, display.scale.place(display.levels)
    coarse = contours(corners.points, triangles_of(corners.cells), scale.place(lux), levels)
    assert np.mean(misses(lit, coarse, scale) < 0.01) < 0.5, "the patches' lines do not"


def test_patches_and_a_bar_are_shown_until_the_mesh_is_there(shown):
    shares = [share for share, _, _ in shown.notes]
    assert len(shares) > 10 and shares[0] < 0.1 and max(shares) > 0.5
    assert np.all(np.diff(shares) >= 0.0), "one bar for all of the work"
    _, noted, levels = shown.notes[-1]
    assert noted and len(levels) > 4
    shown.plotter.render()
    assert shown.hud.place_of("notes") is None


def test_a_lamps_factor_acts_at_once_and_exactly(shown, lit):
    shown.dim("light", 0.4)
    try:
        dimmed = lit.dimmed({"light": 0.4})
        off = misses(dimmed, drawn(shown), shown.display.scale)
        assert np.quantile(off, 0.95) < 0.01
        shown.dim("light", 0.0)
        shown.dim("ambient", 0.0)
        assert shown.display.surfaces._segments is None
        assert not shown.display.surfaces.actor.mapper.dataset.point_data["place"].any()
    finally:
        shown.dim("light", 1.0)
        shown.dim("ambient", 1.0)


def test_edges_are_those_of_the_patches(shown, lit):
    def cells():
        shown.tick()
        return shown.display.surfaces.actor.mapper.dataset.n_cells

    fine = cells()
    press(shown, "e")
    assert cells() == len(Corners(lit).shown) < fine
    press(shown, "e")
    assert cells() == fine
    press(shown, "f")  # luminance
    assert cells() == len(Corners(lit).shown)
    press(shown, "f")
    press(shown, "f")
    assert cells() == fine


def test_the_scale_is_the_fine_meshs_unless_it_was_changed(shown, lit):
    display = shown.display
    mesh, suited = display.refining.mesh, illuminance_scale(lit)
    assert display.scale == spread_scale(*mesh.spread)
    area = lit.patches.area[lit.live].sum()
    assert mesh.spread[1].sum() == pytest.approx(area, rel=1e-9)
    lux = np.average(mesh.spread[0], weights=mesh.spread[1])
    whole = np.average(lit.illuminance[lit.live], weights=lit.patches.area[lit.live])
    assert lux == pytest.approx(whole, rel=0.02)
    look = display.look
    look.ends = {("illuminance", False): suited, ("luminance", False): suited}
    look.forget_suited(lit)
    assert list(look.ends) == [("luminance", False)]
    changed = replace(suited, maximum=2 * suited.maximum)
    look.ends["illuminance", False] = changed
    look.forget_suited(lit)
    assert look.ends["illuminance", False] == changed
    look.ends.clear()


def test_closing_while_it_refines_ends_the_thread(opengl, lit):  # noqa: F811
    win = Window(lit, size=SIZE, off_screen=True)
    press(win, "f")
    end = time.monotonic() + 30.0
    while not win.display.refining.share:
        win.tick()
        assert time.monotonic() < end
    thread = win.display.refining._work.thread
    assert thread.is_alive()
    win.close()
    thread.join(5.0)
    assert not thread.is_alive() and win.display.refining._work.newest is None, "it was given up"


def test_what_ends_the_refining_is_raised(opengl, lit, monkeypatch):  # noqa: F811
    def full(*args):
        raise MemoryError("no room for the mesh")

    monkeypatch.setattr(refining, "gathered_mesh", full)
    win = Window(lit, size=SIZE, off_screen=True)
    try:
        press(win, "f")
        with pytest.raises(MemoryError, match="no room"):
            wait(win)
    finally:
        win.close()


@pytest.mark.parametrize("kept", [0.0, 1.0])
def test_rooms_without_light_and_with_groups_not_told_apart(kept, monkeypatch):
    monkeypatch.setattr(finemesh, "MOST", 400)
    scene = load(ROOT / "scenes/box6.toml")
    lamps = tuple(replace(m, emission=kept * m.emission) for m in scene.materials)
    monkeypatch.setattr("radiosity.solve.relight.MOST_GROUPS", 0)
    solution = solve(replace(scene, materials=lamps), accuracy=0.1)
    assert solution.can_dim == (kept == 0.0), "without light there are no groups"
    mesh = fine_of(solution)
    lux, area = mesh.spread
    assert mesh.groups == (finemesh.ALL,) and lux.any() == bool(kept)
    lit, bright = solution.live, solution.patches.area * solution.illuminance
    assert lux @ area == pytest.approx(bright[lit].sum(), rel=0.02)
    assert mesh.illuminance({}).any() == bool(kept)


def test_what_is_fine_or_not_solved_stays_as_it_is(lit, monkeypatch):
    monkeypatch.setattr(refining, "MOST", 10)
    stage = make_stage(lit.scene, local=True, accuracy=0.1)
    for of in (lit, stage):
        work = Refining()
        work.start(of)
        assert work.share is None and not work.hear() and work.mesh is None
        work.stop(0.0)
