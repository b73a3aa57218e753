"""Reports: figures that are known in closed form or that probe tells, and a page for any scene."""

import json
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from scenes_for_tests import block, box, material, scene
from test_cli import BOX, CORNELL, FURNACE, SCENES

import radiosity
from radiosity.cli import main
from radiosity.light.photometry import illuminance
from radiosity.scene.model import Camera
from radiosity.view.report import date_of, report
from radiosity.view.report.chart import draw, levels
from radiosity.view.report.figures import gather
from radiosity.view.report.maps import map_of
from radiosity.view.report.numbers import measured
from radiosity.view.report.zones import default_planes, default_surfaces, zone_of

DAY = "2026-12-31"
FEW = {"size": (12, 9), "samples": 8, "date": DAY}
CEILING = [[0.0] * 3, [1.0] * 3, *[[0.0] * 3] * 4]
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")


class Page(HTMLParser):
    """A page's elements, texts and what it refers to; refuses tags that do not match."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.open, self.text, self.links = [], [], "", []
        self.feed(text)
        assert not self.open, f"not closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [v for k, v in attrs if k in ("src", "href")]
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def glowing(polygons, emitting=1, accuracy=0.2, **more):
    """Solve a room one of whose faces shines."""
    exitance = np.zeros((len(polygons), 3))
    exitance[emitting] = 100.0
    return radiosity.solve(scene(polygons, 0.5, exitance, **more), accuracy=accuracy)


def written(solution, place, **more):
    """Return the figures and the page of a report."""
    told = report(solution, place / "a.html", **{**FEW, **more})
    text = (place / "a.html").read_text(encoding="utf-8")
    return told, Page(text), text


@pytest.fixture(scope="module")
def furnace():
    return radiosity.solve(radiosity.load(FURNACE), 0.1)


@pytest.fixture(scope="module")
def room():
    return radiosity.solve(radiosity.load(BOX), 0.1)


@pytest.fixture(scope="module")
def cornell():
    return radiosity.solve(radiosity.load(CORNELL), 0.1)


@pytest.fixture
def command(capsys, monkeypatch, tmp_path):
    """Return what runs the command line in this process: ``(exit code, stdout, stderr)``."""
    monkeypatch.setattr(main.signal, "signal", lambda *_: None)  # pytest keeps its own
    monkeypatch.chdir(tmp_path)

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["radiosity", *map(str, words)])
        with pytest.raises(SystemExit) as end:
            main.run()
        said = capsys.readouterr()
        return end.value.code or 0, said.out, said.err

    return run


def test_light_in_a_furnace_is_known(furnace):
    """B = M + rho B, so E = B = M/(1 - rho) on every plane and wall."""
    lux = 683 * (0.2126 * 1.25 + 0.7152 * 4.0 + 0.0722 * 2.5)
    told = gather(furnace, DAY)
    assert [z.name for z in told.grids] == ["Work plane, z = 0.75 m", "Floor, z = 0 m"]
    assert [z.name for z in told.surfaces] == ["wall"]
    for zone in (*told.grids, *told.surfaces):
        assert zone.found.mean == pytest.approx(lux, rel=1e-6)  # the solver's tolerance
        assert zone.found.u0 == pytest.approx(1, abs=1e-6)
    area = 2 * (2 * 3 + 2 * 2.5 + 3 * 2.5)
    assert told.materials[0].area_m2 == pytest.approx(area)
    assert told.power.watts["emitted"] == pytest.approx(np.array([1, 2, 0.5]) * area)
    assert told.power.lumens["absorbed"] == pytest.approx(told.power.lumens["emitted"], rel=1e-5)
    emitted = 683 * (0.2126 * 1 + 0.7152 * 2 + 0.0722 * 0.5) * area
    assert told.materials[0].flux_lm == pytest.approx(emitted)
    assert told.error.truth < told.error.stated


def test_report_tells_what_probe_does(command, room):
    """The same numbers to the last digit, of a plane, of a surface, and of the default plane."""
    radiosity.save(room, "room.radsol")
    code, out, _ = command(
        "report", "room.radsol", "--json", "--grid", "0.85", "--grid", "x0", "--spacing", "0.6",
    )  # fmt: skip
    told = json.loads(out)
    assert code == 0 and told["pictures"] == [] and told["command"].endswith("--spacing 0.6")
    plain = json.loads(command("report", "room.radsol", "--json")[1])
    pairs = [(z, ["--spacing", "0.6"]) for z in told["grids"]]
    pairs += [(z, []) for z in (*plain["grids"], *plain["surfaces"])]
    assert [z["grid"] for z, _ in pairs] == [
        "0.85", "x0", "0.75", "0.0", "floor", "ceiling", "x0", "x1", "y0", "y1",
    ]  # fmt: skip
    for zone, more in pairs:
        code, out, _ = command("probe", "room.radsol", "--grid", zone["grid"], "--json", *more)
        found = json.loads(out)
        assert zone["illuminance_lx"] == found["illuminance_lx"], zone["name"]
        for key in ("points", "left_out", "spacing", "margin"):
            assert zone[key] == found["grid"][key]


def test_a_page_is_whole_and_refers_to_nothing(room, tmp_path):
    told, page, text = written(room, tmp_path, samples=16)
    assert text.count("data:image/png;base64,") == 3  # a camera, the work plane and the floor
    assert all(link.startswith("data:image/png;base64,") for link in page.links)
    assert "script" not in page.tags and "http" not in re.sub(r"http-equiv", "", text)
    for title in ("Pictures", "Illuminance", "Lights", "Materials", "What was modelled",
                  "Power balance", "Accuracy", "Settings and versions", "Terms"):  # fmt: skip
        assert title in page.text
    found = told.grids[0].found
    assert f"mean {measured(found.mean, found.mean_error)} lx" in page.text and DAY in page.text
    assert f"noise {100 * told.pictures[0].noise:.2g} %" in page.text
    assert "An error of at most 10 % was asked for" in page.text and ", as asked" in page.text


def test_names_are_text_and_nothing_else(tmp_path):
    evil = '</style><script>alert("1")</script> & "; } body { display: none } \\'
    made = scene(box((0, 0, 0), (3, 3, 3)), 0.5, CEILING)
    named = tuple(replace(m, name=f"{evil} {k}") for k, m in enumerate(made.materials))
    camera = Camera(evil, *np.array([[1.5, 0.5, 1.5], [1.5, 3, 1.5], [0, 0, 1]]), 60.0, (8, 6))
    made = replace(
        made, name=evil, materials=named, groups=(evil,), cameras={evil: camera}, notes=(evil,)
    )
    _, page, text = written(radiosity.solve(made, 0.2), tmp_path)
    assert "script" not in page.tags and "<script" not in text
    assert text.count("</style>") == 1 and page.text.count(evil) > 8
    printed = re.search(r'@top-left \{ content: "(.*?)"; font', text)[1]
    assert re.fullmatch(r"(\w|\\[0-9a-f]+ )+", printed)  # no sign that ends a string or a rule
    assert re.sub(r"\\([0-9a-f]+) ", lambda m: chr(int(m[1], 16)), printed) == evil


def test_a_dark_scene_without_cameras_is_told(tmp_path):
    told, page, _ = written(radiosity.solve(scene(box((0, 0, 0), (3, 3, 3)), 0.5), 0.2), tmp_path)
    assert "There is no picture: the scene has no camera" in page.text
    assert "Nothing in the scene shines" in page.text
    assert [z.found.mean for z in told.grids] == [0, 0] and not told.surfaces
    assert "No light falls on m0, m1" in page.text
    json.dumps(told.as_dict())


def test_an_open_scene_of_one_face(tmp_path):
    square = [[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]]
    made = scene(square, 0.5, ambient=np.ones(3))
    told, page, _ = written(radiosity.solve(made, 0.2), tmp_path)
    assert not told.closed and "open: light leaves it" in page.text
    assert "No work plane at 0.75 m: the scene is 0 m high" in page.text
    assert [z.name for z in told.grids] == ["Floor, z = 0 m"]
    assert told.grids[0].found.mean == pytest.approx(683 * np.pi, rel=1e-3)


def test_what_is_a_room():
    """Of a room 3 m high; not of the same without a ceiling, and not of a model of it."""
    walls = box((0, 0, 0), (3, 4, 3))
    names = [z.name for z in default_planes(glowing(walls))[0]]
    assert names == ["Work plane, z = 0.75 m", "Floor, z = 0 m"]
    found, said = default_planes(glowing(np.delete(walls, 1, axis=0), 1))
    assert [z.name for z in found] == ["Floor, z = 0 m"] and "no room" in said[0]
    found, said = default_planes(glowing(walls / 10))
    assert [z.name for z in found] == ["Floor, z = 0 m"] and "0.3 m high" in said[0]
    found, said = default_planes(glowing(walls + [0, 0, -1.5]))
    assert [z.name for z in found] == ["Work plane, z = -0.75 m", "Floor, z = -1.5 m"]


def test_a_floor_counts_not_where_bodies_stand_that_have_no_bottom():
    room = np.concatenate([box((0, 0, 0), (4, 4, 3)), block((1, 1, 0), (2, 2, 1), bottom=False)])
    zone = zone_of(glowing(room), "0", spacing=0.25, margin=0.0)
    assert zone.points == 256 - 16 and zone.found.minimum > 0


def test_points_that_do_not_count_are_told(cornell, tmp_path):
    told = radiosity.report(cornell, tmp_path / "a.html", grids=["100"], size=(8, 8), samples=4,
                            exposure=0.5)  # fmt: skip
    (zone,), text = told.grids, (tmp_path / "a.html").read_text()
    every = zone.points + zone.left_out
    assert zone.left_out > zone.points
    assert text.count(f"of {zone.points} of {every} points, the others lie in bodies") == 2
    assert [p.exposure for p in told.pictures] == [0.5]


def test_units_and_axes_change_words_only():
    """The same room in feet with y up: the same light, and maps in metres."""
    metres = glowing(box((0, 0, 0), (3, 4, 3)))
    feet = glowing(box((0, 0, 0), (3, 4, 3))[..., [1, 2, 0]] / 0.3048, unit="ft", unit_m=0.3048,
                   up="y")  # fmt: skip
    (one, _), (two, _) = default_planes(metres)[0], default_planes(feet)[0]
    assert two.found.mean == pytest.approx(one.found.mean, rel=0.02)  # the mesh is the same
    assert two.name == "Work plane, y = 2.46063 ft"
    map_1, map_2 = map_of(metres, one), map_of(feet, two)
    assert map_1.axes == ("x in m", "y in m") and not map_1.down
    assert map_2.axes == ("x in m", "z in m") and map_2.down
    for found in (map_1, map_2):
        assert np.ptp(found.outline, axis=(0, 1)).max() == pytest.approx(4)


def test_maps_show_the_light_where_it_is(cornell):
    """Every cell is what is gathered at its middle; blocks and what is outside are left out."""
    zone = zone_of(cornell, "0")
    found = map_of(cornell, zone)
    k = np.flatnonzero(np.isfinite(found.lux))
    some = np.random.default_rng(0).choice(k, 50)
    x, z = 1000 * found.place.reshape(-1, 2)[some].T
    points = np.column_stack([x, np.zeros(50), z])
    up = np.tile([0.0, 1.0, 0.0], (50, 1))
    lux = illuminance(cornell.irradiance(points, up)[0], cornell.scene.bands)
    assert found.lux.ravel()[some] == pytest.approx(lux, rel=1e-9)
    blocks = 1 - np.isfinite(found.lux).mean()
    assert blocks == pytest.approx(2 * 0.167 * 0.165 / (0.556 * 0.5592), abs=0.02)  # and rim
    wall = map_of(cornell, zone_of(cornell, "red"))
    assert wall.axes == ("to the right in m", "y in m") and not wall.down
    height = wall.outline[..., 1]
    assert height.min() == pytest.approx(0)
    assert height.max() == pytest.approx(0.5488, rel=1e-3)  # along the wall, which leans
    assert draw(wall)[1:4] == draw(found)[1:4] == b"PNG"


def test_a_wall_is_seen_from_its_front():
    """A lamp near the wall's left end, as one stands before it, is at the left of the map."""
    lamp = [[[0.1, 2.9, 2.9], [0.1, 2.5, 2.9], [0.5, 2.5, 2.9], [0.5, 2.9, 2.9]]]
    solution = glowing(np.concatenate([box((0, 0, 0), (3, 3, 3)), lamp]), emitting=6)
    found = map_of(solution, zone_of(solution, "m5"))  # y = 3: x to the right
    right, up = found.place.reshape(-1, 2)[np.nanargmax(found.lux)]
    assert right < 0.8 and up > 2
    assert found.axes == ("to the right in m", "z in m")


def test_isolux_lines_are_round():
    assert levels(90, 700).tolist() == [100, 150, 200, 300, 500]
    assert levels(0, 1000).tolist()[-4:] == [50, 100, 200, 500] and len(levels(0, 1000)) <= 9
    assert len(levels(99.99, 100.0)) >= 2 and len(levels(5.0, 5.0)) == 0


def test_surfaces_of_many_faces_are_told_by_their_patches(tmp_path):
    """A floor of 210 strips, the wider ones farther from a bright wall: the mean is by area."""
    x = 3 * np.linspace(0, 1, 211) ** 2
    strips = [[[a, 0, 0], [b, 0, 0], [b, 3, 0], [a, 3, 0]] for a, b in zip(x, x[1:], strict=False)]
    made = scene(np.concatenate([box((0, 0, 0), (3, 3, 3))[1:], strips]), 0.5)
    dull, bright = material(0.5, name="dull"), material(0.5, 1.0, name="bright")
    owner = np.array([0, 2, *[0] * 3, *[1] * 210])
    many = radiosity.solve(
        replace(made, faces=replace(made.faces, material=owner),
                materials=(replace(dull, name="walls"), dull, bright)),
        mesh="1",
    )  # fmt: skip
    zones, _ = default_surfaces(many)
    zone = {z.name: z for z in zones}["dull"]
    assert 1.15 * zone.found.mean < many.illuminance[5:].mean()  # most strips are near the wall
    assert zone.where is None and zone.points == 210
    assert zone.found.mean == pytest.approx(many.illuminance[5:] @ np.diff(x) / 3)
    assert "(p)" in written(many, tmp_path)[1].text


def test_long_tables_are_capped_and_say_so(tmp_path):
    strips = [[[x, 0, 0], [x + 0.1, 0, 0], [x + 0.1, 3, 0], [x, 3, 0]] for x in np.arange(45) / 10]
    made = scene(strips, 0.5, ambient=np.ones(3))
    told, page, _ = written(radiosity.solve(made, 0.2, mesh="1"), tmp_path)
    assert len(told.materials) == len(told.surfaces) == 45
    assert page.text.count("And 5 more") == 2  # surfaces and materials


def test_of_wavelengths_lumens_are_told(tmp_path):
    made = radiosity.load(SCENES / "cornell_box_spectral.toml", bands=8)
    told, page, _ = written(radiosity.solve(made, 0.2, mesh="1"), tmp_path)
    assert told.power.bands == () and told.power.lumens["emitted"] > 0
    assert "8 wavelengths" in page.text and "so no accuracy could be aimed at" in page.text


def test_a_report_can_be_made_again(room, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", str(86400 * 366))
    one, two = (written(room, tmp_path, date=None)[2] for _ in range(2))
    assert one == two and "1971-01-02" in one
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "now")
    with pytest.raises(ValueError, match="SOURCE_DATE_EPOCH = 'now' must be a number of seconds"):
        date_of(None)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "needs a file to write: add -o report.html, or --json"),
        (["-o", "a.pdf"], "supported is .html, which any browser prints to PDF"),
        (["-o", "none/a.html"], "folder"),
        (["-o", "a.html", "--date", "31.12.2026"], "'31.12.2026' must be a day as ISO 8601"),
        (["-o", "a.html", "--grid", "9"], "height 9 must lie within the scene, from z = 0 to 2.5"),
        (["-o", "a.html", "--grid", "0,75"], "write 0.75"),
        (["-o", "a.html", "--grid", "flor"], "no face group or material is called 'flor'"),
        (["-o", "a.html", "--camera", "back"], "no camera is called 'back'"),
        (["-o", "a.html", "--size", "0x9"], "--size '0x9' must be WIDTHxHEIGHT"),
        (["-o", "a.html", "--spacing", "1e-6"], "use a larger spacing"),
    ],
)
def test_what_cannot_be_is_refused(command, tmp_path, words, said):
    code, out, error = command("report", BOX, "--accuracy", "0.1", *words)
    assert code == 2 and said in error and not out and "Traceback" not in error
    assert "solved" not in error  # it is told before any work is done
    assert list(tmp_path.iterdir()) == []


def test_a_report_that_cannot_be_finished_leaves_nothing(room, tmp_path):
    with pytest.raises(ValueError, match="samples = 0"):
        report(room, tmp_path / "a.html", samples=0, date=DAY)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not CHROMIUM or not shutil.which("pdftotext"),
                    reason="needs Chromium and poppler's pdftotext")  # fmt: skip
def test_it_prints_on_a4_with_page_numbers(room, tmp_path):
    written(room, tmp_path)
    pdf = tmp_path / "a.pdf"
    subprocess.run(
        [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic",
         "--no-first-run", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", f"--user-data-dir={tmp_path / 'profile'}", "--no-pdf-header-footer",
         f"--print-to-pdf={pdf}", (tmp_path / "a.html").as_uri()],
        capture_output=True, timeout=60,
    )  # fmt: skip
    read = ["pdftotext", "-layout", pdf, "-"]
    text = subprocess.run(read, capture_output=True, text=True).stdout
    pages = text.split("\f")[:-1]
    assert 2 <= len(pages) <= 6
    for number, page in enumerate(pages, 1):
        assert f"{number}/{len(pages)}" in page.replace(" / ", "/")
        assert DAY in page and "Room of six faces" in page
    size = subprocess.run(["pdfinfo", pdf], capture_output=True, text=True).stdout
    assert "A4" in size
