"""The reproductions: every script runs, and its pictures show what they are said to show."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import radiosity

ROOT = Path(__file__).resolve().parent.parent
SCENES, GALLERY = ROOT / "scenes", ROOT / "docs" / "gallery"


def run(script, *words):
    done = subprocess.run(
        [sys.executable, str(SCENES / script), *map(str, words)],
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def script(name, monkeypatch):
    """Return a script as a module, with what lies beside it at hand."""
    monkeypatch.syspath_prepend(str(SCENES))
    spec = importlib.util.spec_from_file_location(name, SCENES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, module)  # where dataclasses look
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def blinn(monkeypatch):
    return script("blinn_1977", monkeypatch)


@pytest.fixture
def compared(monkeypatch):
    return script("compared", monkeypatch)


def figures(text):
    return [float(v) for v in re.findall(r"(?:mean|below) ([0-9.]+)", text)]


def test_spectra_beside_three_bands_and_the_reference(tmp_path):
    out = tmp_path / "spectra.png"
    told = figures(run("cornell_box_spectra.py", "--size", 64, "-o", out))
    (bands, bands_95), (reference, _), (published, _) = zip(told[::2], told[1::2], strict=True)
    assert 0.03 < bands < 0.3 and bands < bands_95 < 1.0  # 0.12 and 0.41: rgb errs little here
    assert published < 0.35 < 2.0 < reference  # other colours of wall and lamp, not an error
    assert out.read_bytes().startswith(b"\x89PNG")


def test_lroom_beside_its_reference(tmp_path):
    out = tmp_path / "lroom.png"
    found = re.search(r"rms error ([0-9.]+)%", run("lroom.py", "--size", 48, "-o", out))
    assert 0.0 < float(found[1]) < 1.5  # per cent; 0.37 at full size
    assert out.read_bytes().startswith(b"\x89PNG")


def test_a_deviation_is_that_of_the_blocks_less_the_references_noise(compared):
    rng = np.random.default_rng(0)
    truth = rng.normal(1.0, 0.4, (256, 256, 1)) * np.ones(3)
    inside = np.ones((32, 32), bool)
    inside[0, 0] = False
    reference = compared.Reference(truth, np.full((256, 256, 3), 0.4), inside)
    off, rms = compared.deviation(np.full((64, 64, 3), 1.05), reference)
    assert rms == pytest.approx(0.05, abs=0.006)  # a block's noise, as much again, is taken out
    assert np.isnan(off[0, 0]) and np.nanmean(off) == pytest.approx(0.05, abs=0.006)


def test_blocks_of_references_hold_neither_edges_nor_lamps(compared):
    truth = compared.reference("cornell_box")
    whole = np.kron(truth.inside, np.ones((8, 8), bool))
    assert 0.5 < truth.inside.mean() < 0.9
    assert truth.pixels[whole].max() < 1.0  # W/(m2 sr); the lamp has 17
    data = np.load(SCENES / "cornell_box_reference" / "image.npz")
    assert data["interior"][whole].all()


def test_blinn_writes_his_figures(tmp_path):
    run("blinn_1977.py", "--size", 48, "-o", tmp_path)
    names = {"blinn_lobes.png", "blinn_materials.png", "blinn_shininess.png"}
    assert {p.name for p in tmp_path.iterdir()} == names
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in tmp_path.iterdir())


def plotted(blinn, degrees):
    """Return the angles of view and both models' intensity in the plane of incidence."""
    angle = np.radians(np.linspace(0.0, 89.9, 900))
    view = blinn.polar(np.cos(angle), np.pi)
    light = np.broadcast_to(blinn.polar(np.cos(np.radians(degrees)), 0.0), view.shape)
    surface = blinn.PLOTTED
    both = [blinn.intensity(surface, m, light, view) for m in (surface.lobe, surface.facets)]
    return np.degrees(angle), *both


def test_figures_5_and_6_are_alike_at_30_degrees_and_not_at_70(blinn):
    angle, phong, facets = plotted(blinn, 30)
    assert facets.max() == pytest.approx(phong.max(), rel=0.15)
    assert angle[facets.argmax()] == pytest.approx(30, abs=4)
    angle, phong, facets = plotted(blinn, 70)
    assert facets.max() > 2.5 * phong.max()
    assert angle[phong.argmax()] == pytest.approx(70, abs=0.5)
    assert angle[facets.argmax()] > 74, "the peak lies off the mirror direction"


def test_both_models_have_the_highlight_of_the_paper_at_normal_incidence(blinn):
    up = np.array([0.0, 0.0, 1.0])
    for surface in (blinn.ALUMINIUM, blinn.CERAMIC):
        expected = surface.p_d + surface.p_s * ((surface.n - 1) / (surface.n + 1)) ** 2
        for model in (surface.lobe, surface.facets):
            assert blinn.intensity(surface, model, up, up) == pytest.approx(expected, rel=1e-12)
        half = np.arccos(0.5 ** (1 / surface.lobe.model.exponent))
        assert TR(surface.c3, np.cos(half)) == pytest.approx(0.5, rel=1e-12)


def test_diffuse_light_falls_with_the_cosine_and_highlights_do_not(blinn):
    oblique, mirrored = blinn.polar(0.5, 0.0), blinn.polar(0.5, np.pi)
    surface = blinn.ALUMINIUM
    found = blinn.intensity(surface, surface.lobe, oblique, mirrored)
    assert found == pytest.approx(0.6 * 0.5 + 0.4 * (199 / 201) ** 2, rel=1e-12)


def TR(c3, cosine):
    """D3 of the paper."""
    return (c3**2 / (cosine**2 * (c3**2 - 1) + 1)) ** 2


@pytest.fixture
def vase(blinn):
    return blinn.Vase(radiosity.load(SCENES / "blinn_vase.toml"), 48)


@pytest.mark.parametrize("name", ["ALUMINIUM", "CERAMIC"])
def test_figure_7_models_differ_where_light_comes_from_the_edge(blinn, vase, name):
    surface = getattr(blinn, name)

    def contrast(light):
        """Return how bright Torrance-Sparrow's picture is over Phong's."""
        models = (blinn.scaled(m, 1 / np.pi) for m in (surface.facets, surface.lobe))
        facets, phong = (vase.shown(surface, m, light).astype(float).mean() for m in models)
        return facets / phong

    assert contrast(blinn.FRONT_ON) == pytest.approx(1.0, abs=0.05)
    assert contrast(blinn.EDGE_ON) > 1.1


def test_figure_7_sees_the_vase_where_it_stands(blinn, vase):
    """Lambert alone, lit from the eye: N.E, so that the middle is bright and the rim dark."""
    vase = blinn.replace(vase, height=96)
    shown = vase.shown(blinn.replace(blinn.ALUMINIUM, p_d=1.0), None, (0.0, 0.0, 1.0))
    row = shown[55, :, 0].astype(float)  # through the belly
    lit = np.flatnonzero(row > 1)
    middle = (lit[0] + lit[-1]) / 2
    assert middle == pytest.approx(35.5, abs=1) and row[36] > 235
    assert row[lit[0] + 1] < 170 and np.all(np.diff(row[lit[1] : 36]) >= -3)  # noise of edges
    width = 2 * 1.0 * 96 / 3.6  # pixels: the belly's radius is 1 and the camera's height 3.6
    assert len(lit) == pytest.approx(width, abs=2.5)


def test_the_vase_is_as_bright_as_the_paper_says(blinn, vase):
    """Lit from the eye, where N points to it: i = p_d + p_s F, in linear display values."""
    surface = blinn.CERAMIC
    lobe = blinn.scaled(surface.facets, 1 / np.pi)
    shown = vase.shown(surface, lobe, (0.0, 0.0, 1.0)).max() / 255
    linear = ((shown + 0.055) / 1.055) ** 2.4
    assert linear == pytest.approx(0.333 + 0.667 * (0.8 / 2.8) ** 2, rel=0.01)  # 8 bits


def test_figure_8_scales_the_peak_of_dull_facets(blinn):
    up = np.array([[0.0, 0.0, 1.0]] * 3)
    c3 = np.array([0.35, 0.7, 1.0])
    model = blinn.textured(blinn.TEXTURED, 0.35).with_roughness(c3)
    peak = 0.8 * (199 / 201) ** 2 * (0.35 / c3) ** 2  # (c_min c3/(c3^2))^2
    assert np.pi * model.value(up, up) == pytest.approx(np.outer(peak, np.ones(3)))


@pytest.mark.parametrize("name", ["museum", "living_room"])
def test_the_furniture_is_what_the_script_makes(name, monkeypatch):
    furnished = script("furnished", monkeypatch)
    made = furnished.obj(getattr(furnished, name)())
    assert (SCENES / f"{name}.obj").read_text() == made


def test_the_room_of_the_how_to_is_the_one_that_ships():
    page = (ROOT / "docs" / "lighting.md").read_text()
    parts = re.findall(r"```toml\n(.*?)```", page, re.S)
    shipped = (SCENES / "meeting_room.toml").read_text()
    assert len(parts) == 4
    for part in parts:
        assert part in shipped, part


def test_the_page_shows_every_picture_and_what_made_it():
    text = (ROOT / "docs" / "gallery.md").read_text()
    others = "".join(p.read_text() for p in (ROOT / "docs").glob("*.md"))
    for picture in sorted(GALLERY.iterdir()):
        assert picture.stat().st_size < 400_000, picture.name
        shown = text if not picture.name.startswith(("light_", "meeting_")) else others
        assert f"gallery/{picture.name}" in shown, picture.name
    for command in re.findall(r"^(?:\.venv/bin/)?python (\S+\.py)", text, re.M):
        assert (ROOT / command).exists(), command
    for scene in re.findall(r"scenes/[\w.]+\.toml", text):
        assert (ROOT / scene).exists(), scene
