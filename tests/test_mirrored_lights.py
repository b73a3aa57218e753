"""Pictures of what planar mirrors do with lights: on gloss, and whatever the tiles are."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import block
from test_coherent import ONE, glass, scene_of, surface, wall

import radiosity
from radiosity.light.coherent import Constant
from radiosity.light.phong import Phong
from radiosity.light.sources import Spot
from radiosity.scene.model import Camera
from radiosity.view import gather

MIRROR = surface("mirror", mirror=Constant(0.9 * ONE))
BLACK = surface("black")
VIEW = (1.0, 0.0, 1.5), (-0.5, 0.0, 0.0)
SIDE = [[-2.0, -5, 0], [-2, 5, 0], [-2, 5, 4], [-2, -5, 4]]


def glossy_floor(lights=(), lamp=(), mirrored=True):
    gloss = surface("gloss", specular=Phong(0.5 * ONE, 30.0))
    parts = [(wall(0.0, 1.9), gloss), ([SIDE], MIRROR if mirrored else BLACK)]
    if len(lamp):
        parts.append((lamp, surface("lamp", radiance=10.0)))
    return scene_of(parts, *VIEW, fov=30.0, size=(12, 12), lights=lights)


def test_gloss_shows_a_lamp_in_a_mirror():
    """A spot aimed at the mirror lights the floor as one at its image's place, times k_r."""
    place, axis = np.array([0.5, 0.2, 1.0]), np.array([-1.0, 0, 0])
    spot = Spot(place, 5 * ONE, axis=axis, beam=0.5, cutoff=0.6)
    image = spot.moved(np.diag([-1.0, 1, 1]), np.array([-4.0, 0, 0]))
    seen = radiosity.render(radiosity.solve(glossy_floor((spot,)), 0.2), samples=16).pixels
    bare = glossy_floor((image,), mirrored=False)
    bare = scene_of(
        [(bare.faces.vertices[:1], bare.materials[0])], *VIEW, fov=30.0, size=(12, 12),
        lights=(image,),
    )  # fmt: skip
    there = radiosity.render(radiosity.solve(bare, 0.2), samples=16).pixels
    assert there.max() > 0.01
    np.testing.assert_allclose(seen, 0.9 * there, rtol=0.02, atol=1e-4 * there.max())


def test_gloss_shows_an_area_lamp_in_a_mirror():
    """A lamp that faces away from the floor and to the mirror, with and without exact images."""
    lamp = np.array([[[0.5, -0.4, 1], [0.5, -0.4, 1.6], [0.5, 0.4, 1.6], [0.5, 0.4, 1]]])
    scene = glossy_floor(lamp=lamp)
    solution = radiosity.solve(scene, 0.2)
    assert len(solution.level.tracer.images) >= 1
    exact = radiosity.render(solution, samples=256).pixels.mean()
    tracer = solution.level.tracer
    space = replace(tracer.space, planes=None)
    plain = replace(solution.level, tracer=replace(tracer, space=space, images=()))
    by_rays = radiosity.render(replace(solution, level=plain), samples=256).pixels.mean()
    assert exact == pytest.approx(by_rays, rel=0.05) and exact > 1e-4


@pytest.mark.parametrize("projection", ["pinhole", "orthographic"])
def test_pictures_of_glass_do_not_depend_on_tiles(projection, monkeypatch):
    """A camera whose plane cuts a glass block, half of whose sight lines begin inside."""
    parts = [(block((-1, -1, -0.5), (1, 1, 0.5)), glass()),
             (wall(-2.0), surface("lit", radiance=1.0))]  # fmt: skip
    scene = scene_of(parts, (0.9, 0.0, 0.2), (0.9, 0.0, -2.0), fov=40.0, size=(24, 24))
    if projection == "orthographic":
        eye = scene.cameras["eye"]
        flat = Camera("eye", eye.position, eye.target, eye.up, None, (24, 24), height=1.0)
        scene.cameras["eye"] = flat
    solution = radiosity.solve(scene, 0.3, mesh="1")
    whole = radiosity.render(solution, samples=16).pixels
    monkeypatch.setattr(gather, "PIXELS_AT_ONCE", (32, 32))
    assert np.array_equal(radiosity.render(solution, samples=16).pixels, whole)
