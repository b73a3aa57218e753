"""Layers: lobe on mirror on base; the check, the solve and pictures count them alike."""

from dataclasses import replace

import numpy as np
import pytest

import radiosity
from radiosity.light.coat import coated_diffuse
from radiosity.light.sources import Directional
from radiosity.scene.model import SceneError
from radiosity.scene.toml import read_toml
from radiosity.view.gather import _seen, radiance
from radiosity.view.shading import make_shading

FLOOR = """[[geometry]]
material = "m"
polygons = [[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]]
[materials.m]
"""
COAT = 'specular = { model = "torrance-sparrow", roughness = 0.1, ior = 1.5 }'


def read(text):
    return read_toml(FLOOR + text, "layers.toml", None)


LAYERS = {
    "mirror under a coat": "diffuse = 0.4\nmirror = 0.3\n" + COAT,
    "two coats": 'diffuse = 0.8\nmirror = "fresnel"\nior = 1.5\n' + COAT,
    "sheet under a coat": "diffuse = 0.1\ntranslucent = 0.9\n" + COAT,
    "white under a coat": "diffuse = 1.0\n" + COAT,
}


@pytest.mark.parametrize("text", LAYERS.values(), ids=LAYERS)
def test_layers_return_as_much_in_pictures_as_in_the_solve(text):
    """Under an even sky of radiance 1 a sheet shows B/pi and what it sends on, in the mean."""
    scene = read(text)
    solution = radiosity.solve(replace(scene, ambient=np.ones(3)), 0.1)
    c, w = np.polynomial.legendre.leggauss(12)
    c = (c + 1) / 2
    view = np.stack([np.sqrt(1 - c**2), 0 * c, c], axis=1)
    row, points = np.zeros(12, int), np.full((12, 3), [0.5, 0.5, 0.0])
    shading, keys = make_shading(solution), np.arange(12)
    seen = np.mean(
        [_seen(solution, shading, points + view, row, points, -view, keys, k).leaving
         for k in range(64)], axis=0,
    )  # fmt: skip
    mean = w * c @ seen  # 2 int L c dc over half of the weights' interval
    onwards = solution.level.terms.sent_on[0] * solution.irradiance_on[0]
    expected = (solution.radiosity[0] + onwards) / np.pi
    np.testing.assert_allclose(mean, expected, rtol=0.01)  # lobes' rays
    assert seen.max() < 1.01


def test_a_mirror_under_a_coat_is_checked_as_it_is_solved():
    with pytest.raises(SceneError, match=r"diffuse \+ mirror \+ specular = 1.1"):
        read("diffuse = 0.9\nmirror = 0.3\n" + COAT)


def test_base_under_a_coat_in_the_light_of_the_sun():
    """L13 under parallel light: what a coat lets in and out, and no more."""
    scene = read("diffuse = 0.8\n" + COAT)
    light = np.array([0.6, 0.0, 0.8])
    solution = radiosity.solve(replace(scene, lights=(Directional(-light, np.ones(3)),)), 0.1)
    view = np.array([[0.0, -0.6, 0.8]])
    row = np.zeros(1, int)
    found = radiance(
        solution, make_shading(solution), row, np.full((1, 3), [0.5, 0.5, 0]), view, row, 0
    )[0][0]
    coat = scene.materials[0].specular
    lobe = coat.value(light, view[0])
    base = coated_diffuse(0.8, coat.albedo(0.8), coat.albedo(0.8), coat.mean_albedo)
    np.testing.assert_allclose(found, 0.8 * (lobe + base), rtol=1e-6)  # single-precision rays


def test_a_coat_dims_what_comes_through_a_sheet():
    """tau (1 - a_mean) of what arrives, whichever side it comes from."""
    scene = read("diffuse = 0.1\ntranslucent = 0.5\n" + COAT)
    sun = Directional(np.array([0, 0, -1.0]), np.ones(3))
    solution = radiosity.solve(replace(scene, lights=(sun,)), 0.1)
    back = solution.radiosity[~solution.patches.front]
    left = 1.0 - scene.materials[0].specular.mean_albedo
    np.testing.assert_allclose(back, np.broadcast_to(0.5 * left, back.shape), rtol=1e-6)
