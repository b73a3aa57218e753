"""Three levels of light in pictures: ray tracing and local shading, against closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import block, box
from test_coherent import (
    ONE,
    PERFECT,
    furnace,
    glass,
    in_glass,
    lamps_apart,
    scene_of,
    slab,
    slanting,
    surface,
    wall,
)

import radiosity
from radiosity.light.coherent import Constant
from radiosity.light.phong import Phong, phong
from radiosity.light.seed_forms import SeedForm
from radiosity.light.sources import Directional, Point
from radiosity.scene.model import SceneError
from radiosity.view.methods import METHODS, make_stage, view_of
from radiosity.view.window import show

SCENES = Path(__file__).resolve().parent.parent / "scenes"


def picture(scene, method, **more):
    return radiosity.render(scene, method=method, **({"samples": 8} | more)).pixels


def lamp_lit_floor(**more):
    """Return a diffuse floor 2 m below a point of 8 W/sr, looked at from above."""
    lamp = Point(np.array([0.5, 0, 2.0]), 8.0 * ONE)
    parts = [(wall(0), surface("floor", diffuse=0.6))]
    return scene_of(parts, [0, 0, 1.5], [0.5, 0, 0], lights=(lamp,), **more)


@pytest.mark.parametrize("method", METHODS)
def test_a_floor_under_a_lamp_is_the_same_at_all_levels(method):
    """rho I/(pi d^2): nothing is coupled, and all that is reflected leaves."""
    assert picture(lamp_lit_floor(), method)[0, 0] == pytest.approx(0.6 * 8 / 4 / np.pi * ONE, 1e-5)


def test_local_light_in_a_furnace_is_balanced():
    """L = M/(pi (1 - rho)): what is reflected more than once is spread evenly."""
    scene = furnace()
    assert picture(scene, "local") == pytest.approx(np.full((12, 12, 3), 2.0), rel=1e-2)
    assert picture(scene, "raytrace") == pytest.approx(np.full((12, 12, 3), 1.5), rel=1e-2)


def test_an_ambient_key_takes_the_place_of_the_balance():
    scene = lamp_lit_floor(ambient=3.0 * ONE)
    expected = 0.6 * 8 / 4 / np.pi + 0.6 * 3
    assert picture(scene, "local")[0, 0] == pytest.approx(expected * ONE, rel=1e-5)
    roof = surface("roof", diffuse=0.0)
    under = scene_of(
        [(wall(0), surface("floor", diffuse=0.6)), (wall(1.8, 500, -1), roof)],
        [0, 0, 1.5], [0.5, 0, 0], ambient=3.0 * ONE,
    )  # fmt: skip
    assert picture(under, "local")[0, 0] == pytest.approx(0.6 * 3 * ONE, rel=1e-5)
    assert picture(under, "raytrace", samples=64)[0, 0, 0] < 0.1  # from outside only


def test_light_that_would_never_end_is_refused():
    white = box((-1, -1, -1), (1, 1, 1)), surface("white", diffuse=1.0, radiance=1.0)
    with pytest.raises(SceneError, match="let something absorb"):
        picture(scene_of([white], [0, 0, 0], [1, 0, 0]), "local")


def shaded():
    """Return a floor, a small roof between it and a lamp, seen from below the roof."""
    lamp = Directional(np.array([0, 0, -1.0]), 5.0 * ONE)
    parts = [(wall(0), surface("floor", diffuse=0.5)), (wall(1, 0.5), surface("roof"))]
    return scene_of(parts, [0.3, 0, 0.9], [0, 0, 0], lights=(lamp,))


@pytest.mark.parametrize("method", ["raytrace", "local"])
def test_shadows_are_black_and_may_be_left_out(method):
    dark, full = picture(shaded(), method)[0, 0, 0], 0.5 * 5 / np.pi
    if method == "raytrace":
        assert dark == 0
    else:  # but for a little ambient light
        assert 0 < dark < 0.02 * full
        lit = picture(shaded(), method, shadows=False)[0, 0, 0]
        assert lit - dark == pytest.approx(full, rel=1e-5)


def test_what_is_no_method_or_option_of_one_is_refused():
    with pytest.raises(ValueError, match="gather, raytrace, local"):
        radiosity.render(lamp_lit_floor(), method="trace")
    with pytest.raises(ValueError, match='is for method = "local": "raytrace" always'):
        radiosity.render(lamp_lit_floor(), method="raytrace", shadows=False)


def test_ray_tracing_mirrors_and_local_shading_does_not():
    mirror = surface("mirror", mirror=Constant(0.5 * ONE))
    scene = scene_of([(wall(0), mirror), (wall(4, 60, -1), surface("lamp", radiance=2.0))],
                     [0, 1, 2], [0, 0, 0])  # fmt: skip
    assert picture(scene, "raytrace")[0, 0, 0] == pytest.approx(1.0, rel=1e-6)
    assert picture(scene, "local")[0, 0, 0] == 0.0


def test_local_shading_sees_straight_through_clear_bodies():
    t = np.radians(60)
    parts = [slab(0.5), *lamps_apart(3.0 * np.tan(t) - 0.05)]
    scene = scene_of(parts, slanting(60), [0, 0, 0])
    through = picture(scene, "local")[0, 0, 0]
    assert through == pytest.approx(2.0 * glass().transmit.albedo(0.5)[0] ** 2, rel=1e-5)
    assert picture(scene, "raytrace")[0, 0, 0] < 0.6 * through  # bent on to the darker lamp


def test_the_lobe_reflects_lamps_and_ambient_light():
    lobe = Phong(0.3 * ONE, 20.0)
    normal, way = np.array([0, 0, 1.0]), np.array([0.6, 0, 0.8])
    lamp = Directional(np.array([0.6, 0, -0.8]), 5.0 * ONE)
    scene = scene_of([(wall(0), surface("gloss", specular=lobe))], 2 * way, [0, 0, 0],
                     lights=(lamp,), ambient=0.7 * ONE)  # fmt: skip
    light = np.array([-0.6, 0, 0.8])
    expected = phong(0.3, 20.0, normal, light, way)[0] * 5 * 0.8 + 0.7 * lobe.albedo(0.8)[0]
    assert picture(scene, "local")[0, 0, 0] == pytest.approx(expected, rel=1e-4)


def test_the_raw_forms_of_the_seed_shade_locally():
    """k s E_0, without the cosine, and no ambient light in the lobe."""
    raw = SeedForm(Phong(0.4 * ONE, 10.0))
    lamp = Directional(np.array([0.6, 0, -0.8]), 5.0 * ONE)
    way = np.array([np.sin(0.2), 0, np.cos(0.2)])
    scene = scene_of([(wall(0), surface("raw", specular=raw))], 2 * way, [0, 0, 0], lights=(lamp,),
                     ambient=ONE)  # fmt: skip
    psi = 0.2 - np.arcsin(0.6)
    expected = 0.4 * np.cos(psi) ** 10 * 5
    assert picture(scene, "local")[0, 0, 0] == pytest.approx(expected, rel=1e-4)
    for method in ("gather", "raytrace"):
        with pytest.raises(SceneError, match="has no albedo"):
            radiosity.render(scene, method=method)


def test_a_camera_in_glass_sees_by_ray_tracing_what_it_does_by_radiosity():
    scene = scene_of(in_glass(), [0, 0, -1], [0, 0, 0])
    expected = 2.0 * 1.5**2 * 0.96
    assert picture(scene, "raytrace")[0, 0, 0] == pytest.approx(expected, rel=1e-3)


def test_pictures_are_the_same_for_any_number_of_threads(monkeypatch):
    parts = [(block((-0.7, -0.7, -0.7), (0.7, 0.7, 0.7)), glass()),
             ([[[-1, -1, 1.5], [1, -1, 1.5], [1, 1, 1.5], [-1, 1, 1.5]]],
              surface("mirror", mirror=PERFECT))]  # fmt: skip
    stage = make_stage(furnace(*parts), False)
    one = picture_of(stage)
    monkeypatch.setenv("RADIOSITY_THREADS", "1")
    np.testing.assert_array_equal(picture_of(stage), one)


def picture_of(stage):
    from radiosity.view.gather import render

    return render(stage, size=(40, 40), samples=16).pixels


def test_a_solution_is_pictured_by_all_methods():
    solution = radiosity.solve(radiosity.load(SCENES / "box6.toml"), 0.3)
    assert view_of(solution, "gather") is solution
    pixels = radiosity.render(solution, size=(8, 6), samples=8, method="local").pixels
    again = radiosity.render(solution.scene, size=(8, 6), samples=8, method="local").pixels
    np.testing.assert_array_equal(pixels, again)


def test_the_window_shows_what_was_not_solved():
    stage = make_stage(radiosity.load(SCENES / "box6.toml"), True)
    shown = show(stage, size=(32, 24), off_screen=True)
    assert shown.max() > 50
    dark = replace(stage, irradiance_on=np.zeros_like(stage.irradiance_on))
    assert show(dark, size=(32, 24), off_screen=True).mean() < shown.mean()


@pytest.mark.parametrize("method", ["raytrace", "local"])
def test_highlights_of_area_lights_are_whole_without_rays_of_lobes(method):
    """As in the gather, where rays that lobes choose have their share of them."""
    lobe = Phong(0.5 * ONE, 20.0)
    lamp = [[[1, -0.5, 2], [1, 0.5, 2], [2, 0.5, 2], [2, -0.5, 2]]]
    parts = [(wall(0), surface("gloss", specular=lobe)), (lamp, surface("lamp", radiance=8.0))]
    scene = scene_of(parts, [-1.5, 0, 2], [0, 0, 0], 30, (12, 12))
    expected = radiosity.render(radiosity.solve(scene, 0.3), samples=512).pixels
    found = picture(scene, method, samples=512)
    assert found.mean() == pytest.approx(expected.mean(), rel=0.01)
