"""Notebooks: a real one is run, and what it shows are pictures and tables of what was computed."""

import base64
import re
from dataclasses import replace
from pathlib import Path

import imageio.v3
import numpy as np
import pytest
from scenes_for_tests import box, scene

import radiosity
from radiosity.light.photometry import photometric
from radiosity.scene.markup import Markup, cell, swatch, table
from radiosity.view.falsecolour import Scale
from radiosity.view.notebook import in_notebook
from radiosity.view.window import display_available

SCENES = Path(__file__).resolve().parent.parent / "scenes"
CELLS = """import radiosity
scene = radiosity.load("box6.toml"); scene
---
radiosity.plan(scene, 0.1)
---
solution = radiosity.solve(scene, 0.1); solution
---
radiosity.plot(solution, size=(16, 12), samples=8)
---
radiosity.plot(solution, size=(16, 12), samples=8, false_colour=5)
---
radiosity.render(solution, size=(8, 6), samples=8)
---
solution.plan"""


@pytest.fixture(scope="module")
def solution():
    return radiosity.solve(radiosity.load(SCENES / "box6.toml"), 0.1)


def picture(data):
    return imageio.v3.imread(data, extension=".png")


def test_a_real_notebook_shows_pictures_and_tables(solution):
    nbclient, nbformat = (pytest.importorskip(n) for n in ("nbclient", "nbformat"))
    pytest.importorskip("ipykernel")
    book = nbformat.v4.new_notebook()
    book.cells = [nbformat.v4.new_code_cell(text) for text in CELLS.split("---\n")]
    where = {"metadata": {"path": str(SCENES)}}
    nbclient.NotebookClient(book, timeout=120, kernel_name="python3", resources=where).execute()
    shown = [c.outputs[-1].data for c in book.cells]
    assert ["text/html" in d for d in shown] == [True, True, True, False, False, False, True]
    assert ["image/png" in d for d in shown] == [False, False, False, True, True, True, False]
    plain, coloured, _ = (base64.b64decode(shown[k]["image/png"]) for k in (3, 4, 5))
    image = radiosity.render(solution, size=(16, 12), samples=8)
    assert np.array_equal(picture(plain), image.shown())
    scale = Scale(5.0)
    assert np.array_equal(picture(coloured)[:12, :16], scale.colours(image.luminance))
    for words, found in zip(("4 x 3 x 2.5 m", "gauss-seidel", "luminous, lm"), shown, strict=False):
        assert words in found["text/html"]
    assert "<camera inside, 16 x 12" in shown[3]["text/plain"]


def test_outside_of_notebooks_there_is_none(solution, monkeypatch):
    assert not in_notebook()
    shown = radiosity.plot(solution, size=(8, 6), samples=16, exposure=0.5, inline=True)
    assert shown.image.exposure == 0.5 and shown.image.pixels.shape == (6, 8, 3)
    assert "noise" in repr(shown)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    display_available.cache_clear()
    with pytest.raises(RuntimeError, match="no window can be opened"):
        radiosity.plot(solution)
    with pytest.raises(ValueError, match="no camera is called 'moon'"):
        radiosity.plot(solution, "moon", inline=True)
    with pytest.raises(ValueError, match="must be positive and finite"):
        radiosity.plot(solution, false_colour=-1, inline=True)


def test_a_size_that_is_not_given_keeps_the_camera_in_proportion(solution):
    home = solution.scene.cameras["inside"]
    for size, expected in {(1280, 320): (640, 160), (20, 30): (20, 30)}.items():
        shown = radiosity.plot(solution, replace(home, size=size), samples=8, inline=True)
        assert shown.image.pixels.shape[1::-1] == expected


def test_a_solution_tells_light_and_power():
    solution = radiosity.solve(radiosity.load(SCENES / "lroom.toml"), 0.1)
    text = solution._repr_html_()
    names = [m.name for m in solution.scene.materials]
    mine = solution.scene.faces.material[solution.patches.face] == names.index("white")
    mean = np.average(solution.illuminance[mine], weights=solution.patches.area[mine])
    assert f">white</td><td class=\"number\" style=\"text-align:right\">{mean:.4g}<" in text
    for power in (solution.balance.emitted, solution.balance.absorbed):
        assert f">{power[0]:.4g}<" in text and f">{photometric(power):.4g}<" in text
    assert "asked 10 %" in text and "closed" in text and "light groups: black" in text


def test_names_are_text():
    made = scene(box((0, 0, 0), (1, 1, 1)), 0.5, 1.0)
    evil = "<img src=x onerror=alert(1)> &"
    named = tuple(replace(m, name=evil) for m in made.materials)
    made = replace(made, name=evil, materials=named, notes=(evil,))
    for text in (made._repr_html_(), radiosity.solve(made, mesh="1")._repr_html_()):
        assert "<img" not in text and "&lt;img src=x onerror=alert(1)&gt; &amp;" in text


def test_long_tables_are_cut():
    made = scene(np.concatenate([box((k, 0, 0), (k + 1, 1, 1)) for k in range(6)]), 0.5)
    assert "and 6 more" in made._repr_html_()


def test_markup_escapes_all_but_markup():
    assert cell('<a "b">') == "&lt;a &quot;b&quot;&gt;" and cell(Markup("<b>")) == "<b>"
    made = table(["<h>"], [["<c>"]])
    assert "&lt;h&gt;" in made and "&lt;c&gt;" in made and isinstance(made, Markup)
    assert "#bc00ff" in swatch([0.5, -1, 7])  # sRGB of 0.5 is 188


def test_printed_in_a_line_without_arrays(solution):
    assert repr(solution.scene) == "<Scene 'Room of six faces': 6 faces, 6 materials, lengths in m>"
    assert re.fullmatch(r"<Solution of 'Room of six faces': \d+ patches, [\w-]+>", repr(solution))
    image = radiosity.render(solution, size=(4, 3), samples=4)
    assert repr(image) == "<Image of 4 x 3 pixels>"
    told = str(radiosity.plan(solution.scene, 0.1))
    assert "visibility       nothing" in told and "patches          about" in told
