"""Mirrors and clear bodies in pictures, against closed forms."""

import numpy as np
import pytest
from scenes_for_tests import block, box

import radiosity
from radiosity.light.coherent import Constant, FresnelMirror, FresnelPassage
from radiosity.light.fresnel import reflectance
from radiosity.light.refraction import pane_transmittance
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Camera, Material, Scene
from radiosity.transport.paths import OPEN, medium_at
from radiosity.view.methods import make_stage

ONE = np.ones(3)
PERFECT = Constant(ONE)


def surface(name, diffuse=0.0, radiance=0.0, **more):
    rho = np.broadcast_to(np.asarray(diffuse, float), 3).copy()
    emission = np.broadcast_to(np.asarray(radiance, float), 3).copy()
    return Material(name, rho, 1 - rho, emission, **more)


def glass(index=1.5, **more):
    n = np.broadcast_to(np.asarray(index, float), 3).copy()
    return surface("glass", mirror=FresnelMirror(n), transmit=FresnelPassage(n), **more)


def scene_of(parts, position, target, fov=0.001, size=(1, 1), **more):
    """Return the scene of (quads, material) parts, looked at."""
    quads = np.concatenate([np.asarray(q, float) for q, _ in parts])
    index = np.repeat(np.arange(len(parts)), [len(q) for q, _ in parts])
    up = np.array([0.0, 1, 0]) if abs(position[1] - target[1]) < 0.5 else np.array([1.0, 0, 0])
    eye = Camera("eye", np.array(position, float), np.array(target, float), up, fov, size)
    materials = tuple(m for _, m in parts)
    names = tuple(m.name for m in materials)
    return Scene("test", Faces(quads, index, index), materials, names, {"eye": eye}, **more)


def looked_at(scene, **more):
    """Return the pixels (h, w, 3) of the scene's camera; nothing to solve for lamps alone."""
    return radiosity.render(scene, **({"samples": 8, "method": "raytrace"} | more)).pixels


def wall(z, half=5.0, towards=1.0):
    """Return a square at z that looks up, or down."""
    q = np.array([[[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]]])
    return q if towards > 0 else q[:, ::-1]


@pytest.mark.parametrize("degrees", [0, 50, 80])
@pytest.mark.parametrize("index", [np.full(3, 1.5), np.array([0.2 + 3.4j, 0.9 + 2.4j, 1.5 + 2j])])
def test_a_mirror_shows_what_fresnel_reflects_of_a_lamp(degrees, index):
    t = np.radians(degrees)
    way = np.array([np.sin(t), 0, np.cos(t)])
    mirror = surface("mirror", mirror=FresnelMirror(index))
    lamp = surface("lamp", radiance=[1.0, 2, 3])
    scene = scene_of([(wall(0), mirror), (wall(4, 60, -1), lamp)], 2 * way, [0, 0, 0])
    expected = reflectance(np.cos(t), index) * [1.0, 2, 3]
    assert looked_at(scene)[0, 0] == pytest.approx(expected, rel=1e-4)


def slab(thickness, low=-9.0, **more):
    """Return a plate of glass whose upper face lies at z = 0, and its material."""
    return block((low, low, -thickness), (-low, -low, 0.0)), glass(**more)


def lamps_apart(edge, z=-3.0):
    """Return two lamps side by side that meet at x = edge and look up: 1 and 2 W/(m2 sr)."""
    left = [[[-9, -9, z], [edge, -9, z], [edge, 9, z], [-9, 9, z]]]
    right = [[[edge, -9, z], [9, -9, z], [9, 9, z], [edge, 9, z]]]
    return (left, surface("one", radiance=1.0)), (right, surface("two", radiance=2.0))


def slanting(degrees, distance=2.0):
    """Return where a camera stands that looks down at the origin at an angle."""
    t = np.radians(degrees)
    return distance * np.array([-np.sin(t), 0, np.cos(t)])


def f(degrees, index=1.5):
    return reflectance(np.cos(np.radians(degrees)), index)


@pytest.mark.parametrize("degrees", [0, 40, 70])
@pytest.mark.parametrize("absorption", [0.0, 0.8])
def test_a_pane_dims_what_lies_behind_it(degrees, absorption):
    """(1 - F)^2 t/(1 - F^2 t^2) with all reflections inside, t = exp(-a d/cos(theta'))."""
    plate = slab(0.5, absorption=np.full(3, absorption))
    scene = scene_of([plate, *lamps_apart(-8)], slanting(degrees), [0, 0, 0])
    inside = np.sqrt(1 - (np.sin(np.radians(degrees)) / 1.5) ** 2)
    t, r = np.exp(-absorption * 0.5 / inside), f(degrees)
    expected = 2.0 * (1 - r) ** 2 * t / (1 - r**2 * t**2)
    assert looked_at(scene)[0, 0, 0] == pytest.approx(expected, rel=2e-3)  # least share followed
    if degrees == 0 and absorption == 0:
        assert expected == pytest.approx(2.0 * pane_transmittance(1.0, 1.5), rel=1e-12)


@pytest.mark.parametrize("degrees", [20, 60])
def test_a_pane_shifts_what_lies_behind_it(degrees):
    """By d sin(theta) (1 - cos(theta)/(n cos(theta'))) at right angles to the line of sight."""
    t, d = np.radians(degrees), 0.5
    inside = np.sqrt(1 - (np.sin(t) / 1.5) ** 2)
    shift = d * np.sin(t) * (1 - np.cos(t) / (1.5 * inside))
    place = 3.0 * np.tan(t) - shift / np.cos(t)
    for aside, level in ((-1e-3, 2.0), (1e-3, 1.0)):
        parts = [slab(d), *lamps_apart(place + aside)]
        found = looked_at(scene_of(parts, slanting(degrees), [0, 0, 0]))[0, 0, 0]
        once = level * (1 - f(degrees)) ** 2
        assert once <= found < once * (1 + 3 * f(degrees) ** 2)


def test_colours_are_bent_apart():
    """Each band sees the lamp where its own index puts it."""
    index, t, d = np.array([1.3, 1.5, 1.9]), np.radians(60), 1.0
    inside = np.sqrt(1 - (np.sin(t) / index) ** 2)
    places = 3.0 * np.tan(t) - d * np.sin(t) * (1 - np.cos(t) / (index * inside)) / np.cos(t)
    edge = (places[1] + places[2]) / 2  # the strongest bent see the left lamp, the others not
    plate = block((-9, -9, -d), (9, 9, 0)), glass(index)
    found = looked_at(scene_of([plate, *lamps_apart(edge)], slanting(60), [0, 0, 0]))[0, 0]
    once = (1 - reflectance(0.5, index)) ** 2
    assert np.all(found > once * [2, 2, 1] * (1 - 1e-4))
    assert np.all(found < once * [2, 2, 1] * (1 + 4 * reflectance(0.5, index) ** 2))


def in_glass(lamp_inside=False):
    """Return parts of a block of glass with a black floor in it, under a lamp."""
    floor = surface("floor", radiance=3.0 if lamp_inside else 0.0)
    lamp = wall(4, 90, -1), surface("lamp", radiance=2.0)
    return [(block((-40, -40, -4), (40, 40, 0)), glass()), (wall(-3, 30), floor), lamp]


@pytest.mark.parametrize("degrees", [0, 30, 41])
def test_a_camera_in_glass_sees_more_radiance(degrees):
    """L n^2 (1 - F), as L/n^2 is invariant."""
    t = np.radians(degrees)
    way = np.array([np.sin(t), 0, np.cos(t)])
    scene = scene_of(in_glass(), [0, 0, -1], [0, 0, -1] + way)
    expected = 2.0 * 1.5**2 * (1 - f(degrees, 1 / 1.5))
    assert looked_at(scene)[0, 0, 0] == pytest.approx(expected, rel=1e-3)


def test_beyond_the_critical_angle_a_camera_in_glass_sees_what_lies_there():
    t = np.radians(60)
    scene = scene_of(in_glass(True), [0, 0, -1], [np.sin(t), 0, np.cos(t) - 1])
    assert looked_at(scene)[0, 0, 0] == pytest.approx(3.0, rel=1e-5)


def test_the_medium_of_a_point_is_told_by_what_is_seen_around_it():
    space = make_stage(scene_of(in_glass(), [0, 0, 2], [0, 0, 0]), False).space
    assert medium_at(space, np.array([0, 0, -1.0])) == 0
    assert medium_at(space, np.array([0, 0, 1.0])) == OPEN


def test_mirrors_show_the_outside():
    mirror = surface("mirror", mirror=Constant(np.array([0.2, 0.5, 1.0])))
    scene = scene_of([(wall(0), mirror)], [0, 1, 2], [0, 0, 0], ambient=2 * ONE)
    assert looked_at(scene)[0, 0] == pytest.approx([0.4, 1.0, 2.0], rel=1e-6)


def test_a_wall_shows_the_same_radiance_from_near_and_far():
    lamp = wall(0, 3000), surface("lamp", radiance=2.0)
    mirror = wall(400, 3000, -1), surface("mirror", mirror=Constant(0.7 * ONE))
    found = [
        looked_at(scene_of([lamp, mirror], place, target))[0, 0, 0]
        for place, target in (
            ([0, 1, 300], [0, 1, 400]), ([0, 1, 399], [0, 1, 400]),
            ([0, 1, 399], [1, 1, 400 - np.tan(np.pi / 6)]),
        )
    ]  # fmt: skip
    assert found == pytest.approx(3 * found[:1], rel=1e-6)


def furnace(*parts):
    """Return a closed box whose walls emit 1 and reflect half, with more in it: L = 2."""
    room = box((-2, -2, -2), (2, 2, 2)), surface("room", diffuse=0.5, radiance=1.0)
    return scene_of([room, *parts], [1.8, 1.7, 0.3], [0, 0, 0], 60, (12, 12))


@pytest.mark.parametrize("body", [surface("mirror", mirror=PERFECT), glass()])
def test_what_takes_no_light_vanishes_in_a_furnace(body):
    cube = block((-0.7, -0.7, -0.7), (0.7, 0.7, 0.7)), body
    pixels = radiosity.render(radiosity.solve(furnace(cube), 0.1), samples=128).pixels
    # What is still followed, and the noise of 128 rays: 0.8 % a pixel.
    assert pixels.mean() == pytest.approx(2.0, rel=4e-3)
    assert pixels == pytest.approx(np.full(pixels.shape, 2.0), rel=4e-2)


def test_looking_around_goes_on_from_mirrors():
    """A wall that mirrors all hides no sky: E = pi L; others take their share of what they hide."""
    mirror = surface("mirror", mirror=Constant(np.array([1.0, 0.5, 0.0])))
    floor = [[[0, -4, 0], [4, -4, 0], [4, 4, 0], [0, 4, 0]]]
    upright = [[[0, -4, 0], [0, 4, 0], [0, 4, 3], [0, -4, 3]]]
    parts = [(floor, surface("floor", diffuse=0.6)), (upright, mirror)]
    scene = scene_of(parts, [0.5, 0, 2], [0.5, 0, 0], ambient=2 * ONE)
    found = radiosity.render(radiosity.solve(scene, 0.3), samples=64).pixels[0, 0]
    assert found[0] == pytest.approx(0.6 * 2, rel=1e-5)
    assert found[2] < 0.7 * found[0]  # nearly half of the sky is hidden
    assert found[1] == pytest.approx((found[0] + found[2]) / 2, rel=1e-5)


def mirrored(quads):
    return (np.asarray(quads, float) * [-1, 1, 1])[:, ::-1]


def test_a_mirror_wall_shows_and_lights_the_doubled_room():
    lamp, stone = surface("lamp", radiance=10), surface("stone", diffuse=0.7)
    hung = np.array([[[0.8, 0.3, 0.99], [0.8, 0.7, 0.99], [1.2, 0.7, 0.99], [1.2, 0.3, 0.99]]])
    cube = block((1.0, 0.2, 0), (1.4, 0.5, 0.5), bottom=False)
    room, whole = box((0, 0, 0), (2, 1, 1)), box((-2, 0, 0), (2, 1, 1))
    place = dict(position=[1.9, 0.5, 0.5], target=[0, 0.5, 0.45], fov=60, size=(16, 16))
    single = scene_of(
        [(np.delete(room, 2, axis=0), stone), (room[2:3], surface("mirror", mirror=PERFECT)),
         (hung, lamp), (cube, stone)], **place,
    )  # fmt: skip
    double = scene_of(
        [(whole, stone), (hung, lamp), (cube, stone), (mirrored(hung), lamp),
         (mirrored(cube), stone)], **place,
    )  # fmt: skip
    one, two = (
        radiosity.render(radiosity.solve(s, 0.03), samples=256).pixels[..., 0]
        for s in (single, double)
    )
    assert one.mean() == pytest.approx(two.mean(), rel=0.01)
    apart = np.abs(one / two - 1)
    assert np.median(apart) < 0.012 and np.mean(apart > 0.1) < 0.05  # edges are jittered
