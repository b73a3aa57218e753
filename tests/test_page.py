"""The page: one whole file without a network, and what it does in a real browser to real clicks."""

import base64
import hashlib
import io
import json
import re
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
from scenes_for_tests import box, faces_of, material

import radiosity
from radiosity.light.coherent import Constant
from radiosity.light.photometry import illuminance
from radiosity.light.sources import Point
from radiosity.light.texture import srgb_to_linear
from radiosity.scene.model import Camera, Scene
from radiosity.solve.solve import solve
from radiosity.view.fine.finemesh import gathered_mesh
from radiosity.view.methods import render
from radiosity.view.page.page import page_of, write_page
from radiosity.view.shading import auto_exposure

SCENES = Path(__file__).resolve().parent.parent / "scenes"
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
FLAGS = (
    "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--hide-scrollbars",
)  # fmt: skip
NASTY = "</script><script>document.title='broken'</script><b>\u2028"


class Elements(HTMLParser):
    """The scripts of a page and what else it holds."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.scripts, self.open, self.policy = [], [], False, ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        attrs = dict(attrs)
        if tag == "meta" and "http-equiv" in attrs:
            self.policy = attrs["content"]
        if tag == "script":
            self.scripts.append([attrs.get("type"), ""])
        self.open = tag == "script"

    def handle_endtag(self, tag):
        self.open = False

    def handle_data(self, data):
        if self.open:
            self.scripts[-1][1] += data


@pytest.fixture(scope="module")
def cornell():
    return solve(radiosity.load(SCENES / "cornell_box.toml"), 0.1)


@pytest.fixture(scope="module")
def two_lamps():
    """A room of walls with a nasty name, two lamps, and a camera."""
    lamps = (
        Point(np.array([0.6, 1.0, 1.7]), np.array([3.0, 2.0, 1.0]), group="left"),
        Point(np.array([2.6, 0.4, 1.2]), np.array([0.5, 1.0, 2.0]), group=NASTY),
    )
    camera = Camera("front", np.array([1.5, 0.1, 1.0]), np.array([1.5, 2.0, 0.9]),
                    np.array([0.0, 0, 1]), 60.0, (64, 48))  # fmt: skip
    faces = faces_of(box([0, 0, 0], [3, 2, 2]))
    made = Scene(NASTY, faces, (material(0.6, name=NASTY),), ("all",), {"front": camera},
                 lights=lamps)  # fmt: skip
    return solve(made, mesh="2")


@pytest.fixture(scope="module")
def pages(tmp_path_factory, cornell, two_lamps):
    """The files of two pages, the second a coarse one."""
    folder = tmp_path_factory.mktemp("pages")
    text = page_of(cornell, gathered_mesh(cornell, with_errors=True))
    (folder / "cornell.html").write_text(text, encoding="utf-8")
    text = page_of(two_lamps, gathered_mesh(two_lamps, most=3000))
    (folder / "lamps.html").write_text(text, encoding="utf-8")
    return folder


def test_a_page_is_one_small_file_that_asks_for_nothing(pages):
    text = (pages / "cornell.html").read_text(encoding="utf-8")
    assert len(text.encode()) < 5e6
    assert not re.search(r"(src|href)=(?!\"data:)|@import|url\(|https?:", text)
    found = Elements(text)
    script = found.scripts[-1][1]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert found.policy.startswith(f"default-src 'none'; script-src 'sha256-{digest}'; ")
    assert "unsafe" not in found.policy and "http" not in found.policy


def test_names_cannot_leave_their_place(pages):
    found = Elements((pages / "lamps.html").read_text(encoding="utf-8"))
    kinds = [kind for kind, _ in found.scripts]
    assert kinds == ["application/json", "application/octet-stream", None]
    assert "b" not in found.tags
    about = json.loads(found.scripts[0][1])
    assert about["name"] == about["materials"][0]["name"] == about["groups"][1] == NASTY


def test_saved_by_its_suffix_whole_or_not_at_all(tmp_path, two_lamps):
    place = tmp_path / "page.html"
    place.write_text("old")

    def stop(stage, done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_page(two_lamps, place, progress=stop)
    assert place.read_text() == "old" and len(list(tmp_path.iterdir())) == 1
    with pytest.raises(OSError, match="does not exist"):
        radiosity.save(two_lamps, tmp_path / "no" / "page.html")
    radiosity.save(two_lamps, place)
    assert place.read_text(encoding="utf-8").startswith("<!doctype html>")


def run(*words, cwd):
    return subprocess.run([sys.executable, "-m", "radiosity", *map(str, words)],
                          capture_output=True, text=True, cwd=cwd, timeout=300)  # fmt: skip


def test_view_writes_a_page(tmp_path, two_lamps):
    done = run("view", SCENES / "furnace.toml", "--accuracy", 0.1, "--html", "out.html",
               "--exposure", "0.25", cwd=tmp_path)  # fmt: skip
    assert done.returncode == 0 and "wrote out.html: 0." in done.stderr
    text = (tmp_path / "out.html").read_text(encoding="utf-8")
    assert json.loads(Elements(text).scripts[0][1])["exposure"] == 0.25
    place = tmp_path / "room.radsol"
    radiosity.save(two_lamps, place)
    assert run("view", place, "--html", "b.html", "--exposure", "auto-1", cwd=tmp_path).stderr
    about = json.loads(Elements((tmp_path / "b.html").read_text("utf-8")).scripts[0][1])
    assert about["exposure"] == pytest.approx(auto_exposure(two_lamps) / 2)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--html", "out.txt"), "must end in .html"),
        (("--html", "no/out.html"), "does not exist"),
        (("--html", "out.html", "--size", "9x9"), "--size does nothing to a page"),
        (("--html", "out.html", "--no-shadows"), "--no-shadows does nothing to a page"),
    ],
)
def test_view_refuses_what_a_page_does_not_take(tmp_path, words, told):
    done = run("view", SCENES / "furnace.toml", *words, cwd=tmp_path)
    assert done.returncode == 2 and told in done.stderr and "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


class Browser:
    """Chromium without a screen; clicks are those of a real mouse."""

    def __init__(self, folder, *flags):
        from selenium import webdriver

        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for flag in (*FLAGS, *flags, f"--user-data-dir={folder}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        service = webdriver.ChromeService(DRIVER)
        self.driver = webdriver.Chrome(options=options, service=service)
        self.resize(1000, 700)

    def resize(self, width, height):
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        time.sleep(0.3)

    def open(self, path):
        """Load a page; return the seconds until its first picture, None where there is none."""
        self.driver.get(path.as_uri())
        for _ in range(400):
            data = self.js("return {...document.documentElement.dataset}")
            if data:
                break
            time.sleep(0.05)
        assert data, "the page never ends loading"
        drawn = self.js("return performance.getEntriesByName('drawn').map(x => x.startTime)[0]")
        return drawn and drawn / 1000

    def js(self, script, *args):
        return self.driver.execute_script(script, *args)

    def click(self, x, y):
        """Press and let go at a place of the canvas."""
        from selenium.webdriver import ActionChains

        canvas = self.driver.find_element("id", "view")
        size = canvas.size
        aside = round(x - size["width"] / 2), round(y - size["height"] / 2)
        ActionChains(self.driver, duration=0).move_to_element_with_offset(canvas, *aside).click(
        ).perform()  # fmt: skip
        return self.picked()

    def picked(self):
        """Return what the panel tells of a point, as text."""
        return self.js("return {...document.getElementById('point').dataset}")

    def ticks(self):
        """Return the words at the scale of false colours."""
        script = "return [...document.getElementById('ticks').children].map(x => x.innerText)"
        return self.js(script)

    def press(self, keys):
        self.driver.find_element("id", "view").send_keys(keys)

    def set_lamp(self, k, percent):
        script = ("const s = document.querySelectorAll('#lamps input')[arguments[0]];"
                  "s.value = arguments[1]; s.dispatchEvent(new Event('input'));")  # fmt: skip
        self.js(script, k, percent)

    def pixels(self):
        """Return (h, w, 3) what is on the screen, once it is drawn."""
        self.driver.execute_async_script(
            "const done = arguments[0];"
            "requestAnimationFrame(() => requestAnimationFrame(() => done()));"
        )
        return iio.imread(io.BytesIO(self.driver.get_screenshot_as_png()))[..., :3].astype(float)

    def requests(self):
        """Return the addresses that were asked for since this was asked last."""
        found = []
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                found.append(message["params"]["request"]["url"])
        return found


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    pytest.importorskip("selenium", reason="selenium drives the browser")
    if CHROMIUM is None or DRIVER is None:
        pytest.skip("no chromium or chromedriver on this machine (Debian: apt install chromium "
                    "chromium-driver)")  # fmt: skip
    found = Browser(tmp_path_factory.mktemp("profile"))
    yield found
    found.driver.quit()


def test_it_draws_soon_and_quietly(browser, pages):
    page = pages / "cornell.html"
    browser.requests(), browser.driver.get_log("browser")  # those of its own first tab
    seconds = min(browser.open(page) for _ in range(3))  # others may be at work
    assert seconds < 2.0
    asked = [url for url in browser.requests() if not url.startswith("data:")]
    assert asked == [page.as_uri()] * 3
    assert browser.driver.get_log("browser") == []


def test_picks_agree_with_probe(browser, pages, cornell):
    browser.open(pages / "cornell.html")
    size = browser.js("const c = document.getElementById('view'); "
                      "return [c.clientWidth, c.clientHeight]")  # fmt: skip
    shares = [(across, down) for across in (0.15, 0.4, 0.6, 0.85) for down in (0.2, 0.5, 0.85)]
    picks = [browser.click(across * size[0], down * size[1]) for across, down in shares]
    points, normals = (np.array([[float(p[k]) for k in keys] for p in picks])
                       for keys in (("x", "y", "z"), ("nx", "ny", "nz")))  # fmt: skip
    found = np.array([float(p["lux"]) for p in picks])
    expected = illuminance(cornell.irradiance(points, normals)[0])
    live = cornell.live
    mean = np.average(cornell.illuminance[live], weights=cornell.patches.area[live])
    off = np.abs(found - expected) / np.maximum(expected, 0.1 * mean)
    assert off.max() < 0.01, off
    assert len({p["material"] for p in picks}) == 3  # both walls and white
    bars = illuminance(cornell.irradiance(points, normals)[1])
    assert np.array([float(p["error"]) for p in picks]) == pytest.approx(bars, rel=0.3)
    text = browser.js("return document.getElementById('point').innerText")
    assert " lx" in text and "\u00b1" in text and " cd/m" in text


def test_the_picture_is_ours(browser, pages, two_lamps):
    """Pixel by pixel as the gathered picture of the same camera, off edges."""
    browser.resize(240, 180)
    browser.open(pages / "lamps.html")
    browser.press("p")  # the panel away
    browser.js("document.getElementById('open').hidden = true")
    image = render(two_lamps, "front", size=(240, 180), samples=64).shown().astype(float)
    off = np.abs(browser.pixels() - image).max(axis=2)
    browser.resize(1000, 700)
    assert np.median(off) <= 2.0 and np.percentile(off, 90) <= 5.0  # of 255; noise of 64 rays


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A page of a table in a room, from below its top, from elsewhere, and through a pane."""
    above = np.array([[0.8, 0.4, 0.7], [2.2, 0.4, 0.7], [2.2, 1.6, 0.7], [0.8, 1.6, 0.7]])
    pane = np.array([[2.5, 0.1, 0.1], [2.5, 0.9, 0.1], [2.5, 0.9, 0.6], [2.5, 0.1, 0.6]])
    polygons = np.concatenate([box([0, 0, 0], [3, 2, 2]), [above, pane]])
    faces = faces_of(polygons, [0] * 7 + [1])
    glass = replace(material(0.0, name="glass"), transmit=Constant(np.full(3, 0.9)))
    lamp = Point(np.array([1.4, 1.1, 1.9]), np.full(3, 2.0))
    places = {"low": [0.2, 0.3, 0.4], "high": [1.5, 1.0, 1.9], "cellar": [1.2, 1.0, -3.0],
              "through": [2.8, 0.3, 0.4]}  # fmt: skip
    cameras = {
        name: Camera(name, np.array(place), np.array([1.5, 1.0, 0.0]), np.array([0.0, 1, 1]), 60.0,
                     (64, 48))
        for name, place in places.items()
    }  # fmt: skip
    made = Scene("table", faces, (material(0.5), glass), ("all",), cameras, lights=(lamp,))
    solution = solve(made, 0.3, mesh="1")
    page = tmp_path_factory.mktemp("table") / "table.html"
    page.write_text(page_of(solution, gathered_mesh(solution, most=1000)), encoding="utf-8")
    return page


def test_a_mark_tells_what_hides_its_point(browser, table):
    browser.open(table)
    size = browser.js("const c = document.getElementById('view'); "
                      "return [c.clientWidth, c.clientHeight]")  # fmt: skip
    picked = browser.click(size[0] / 2, size[1] / 2)  # what all cameras look at
    assert [float(picked[k]) for k in "xyz"] == pytest.approx([1.5, 1.0, 0.0], abs=0.01)
    told = {}
    for key in "12341":
        browser.press(key)
        time.sleep(0.8)
        told[key] = browser.js("return document.getElementById('marker').innerText")
        behind = browser.js("return document.getElementById('marker').className")
        assert behind == ("behind" if key in "23" else "")
    plain = f"{float(picked['lux']):.3g} lx"
    dim = f"{plain} \u00b7 hidden"  # by the table, by the floor that is seen from its back
    assert told == {"1": plain, "2": dim, "3": dim, "4": plain}
    # Without errors at its vertices a page does not make any up.
    assert "not estimated" in browser.js("return document.getElementById('point').innerText")


def test_lamps_dim_the_picture_by_the_right_amount(browser, pages, two_lamps):
    browser.open(pages / "lamps.html")
    browser.click(300, 400)
    whole = float(browser.picked()["lux"])
    before = browser.pixels()[380:420, 200:280]
    for k in (0, 1):
        browser.set_lamp(k, 50)
    half = float(browser.picked()["lux"])
    assert half == pytest.approx(whole / 2, rel=1e-6)
    after = browser.pixels()[380:420, 200:280]
    fine = np.all((before > 30) & (before < 250), axis=2)
    assert fine.sum() > 400
    ratio = srgb_to_linear(after[fine] / 255.0) / srgb_to_linear(before[fine] / 255.0)
    assert np.median(ratio) == pytest.approx(0.5, abs=0.01)
    browser.driver.find_element("css selector", "#lamps button").click()  # the left one off
    browser.set_lamp(1, 100)
    picked = browser.picked()
    where = [[float(picked[k]) for k in keys] for keys in ("xyz", ("nx", "ny", "nz"))]
    alone = two_lamps.dimmed({"left": 0.0}).irradiance([where[0]], [where[1]])[0]
    assert float(picked["lux"]) == pytest.approx(illuminance(alone)[0], rel=0.01)
    assert browser.js("return document.querySelectorAll('#lamps button')[1].textContent") == NASTY


def test_false_colours_by_key_with_their_scale(browser, pages):
    browser.open(pages / "cornell.html")
    picture = browser.pixels()
    browser.press("f")
    shown = browser.pixels()
    assert np.abs(shown - picture)[100:600, 100:600].mean() > 20
    told = browser.ticks()
    assert told[0] == "0" and told[1].startswith("\u2265 ") and len(told) > 5
    browser.press("i")
    without = browser.pixels()
    changed = np.abs(shown - without).max(axis=2) > 30
    assert 0.001 < changed.mean() < 0.1  # thin lines
    browser.press("l")
    assert browser.js("return document.getElementById('log').checked")
    assert browser.ticks()[0].startswith("\u2264 ")


def test_dragging_turns_and_keys_walk(browser, pages):
    from selenium.webdriver import ActionChains

    browser.open(pages / "lamps.html")
    before = browser.pixels()
    canvas = browser.driver.find_element("id", "view")
    ActionChains(browser.driver).click_and_hold(canvas).move_by_offset(120, 30).release().perform()
    turned = browser.pixels()
    assert np.abs(turned - before).mean() > 2
    assert browser.js("return document.getElementById('point').childElementCount") == 0  # no pick
    browser.js("window.dispatchEvent(new KeyboardEvent('keydown', {code: 'KeyW', key: 'w'}))")
    time.sleep(0.3)
    browser.js("window.dispatchEvent(new KeyboardEvent('keyup', {code: 'KeyW', key: 'w'}))")
    assert np.abs(browser.pixels() - turned).mean() > 1
    browser.press("1")  # back to the camera
    time.sleep(0.8)
    assert np.abs(browser.pixels() - before).mean() < 0.5


def test_it_fits_a_phone(browser, pages):
    browser.resize(400, 700)
    browser.open(pages / "cornell.html")
    wide, seen, panel = browser.js(
        "return [document.documentElement.scrollWidth,"
        "document.getElementById('view').clientHeight,"
        "document.getElementById('panel').getBoundingClientRect().top]"
    )
    assert wide <= 400 and 250 < seen <= panel + 1
    assert browser.click(200, 200)["lux"]
    browser.resize(1000, 700)


def test_without_webgl_it_says_so(pages, tmp_path, browser):
    other = Browser(tmp_path / "profile", "--disable-3d-apis")
    try:
        assert other.open(pages / "lamps.html") is None
        told = other.js("return document.getElementById('message').textContent")
    finally:
        other.driver.quit()
    assert "WebGL 2" in told and "hardware acceleration" in told
