"""Planar mirrors as windows: screens, parts in front, and what is seen in them, exactly."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import block
from test_chains import ONE, WALLS, scene_of, surface

from radiosity.light.coherent import Constant
from radiosity.light.sources import Directional, Point, Spot
from radiosity.solve.chains import arriving_by_chains
from radiosity.solve.solve import solve
from radiosity.transport.images import Plane, _in_front, _screen


def area(polygons):
    return 0.5 * np.linalg.norm(
        np.cross(polygons[:, 2] - polygons[:, 0], polygons[:, 3] - polygons[:, 1]), axis=1
    )


def test_a_screen_leaves_the_windows_open():
    window = np.array([[[1.0, 0.5, 0], [3, 0.5, 0], [2.5, 2, 0], [1, 2, 0]]])
    plane = Plane(np.array([0, 0, 1.0]), 0.0, window, ONE)
    screen = _screen(plane, WALLS)
    assert area(screen).sum() == pytest.approx(4 * 3 - area(window).sum())
    inside = np.array([2.0, 1.0, 0])
    for quad in screen:  # convex, and none over the window's middle
        across = np.cross(np.roll(quad, -1, axis=0) - quad, inside - quad)[:, 2]
        assert across.min() < 0 < across.max() or not np.any(across)


def test_parts_in_front_of_a_plane():
    plane = Plane(np.array([1.0, 0, 0]), 1.0, WALLS[:1], ONE)
    parts, owner = _in_front(WALLS, [plane], 1e-9)
    assert parts[..., 0].min() == pytest.approx(1.0)
    for k in range(6):  # four sides keep 3/4, that at x = 0 nothing, that at x = 4 all
        whole, kept = area(WALLS[[k]]).sum(), area(parts[owner == k]).sum()
        share = 0.0 if np.all(WALLS[k, :, 0] == 0) else 1.0 if np.all(WALLS[k, :, 0] == 4) else 0.75
        assert kept == pytest.approx(share * whole)


@pytest.mark.parametrize(
    "lamp",
    [Point(np.array([1.0, 2, 3]), ONE),
     Spot(np.array([1.0, 2, 3]), ONE, axis=np.array([0.6, 0, -0.8]), beam=0.3, cutoff=0.5),
     Directional(np.array([0.6, 0, -0.8]), ONE)],
)  # fmt: skip
def test_a_mirrored_lamp_sends_mirrored_light(lamp):
    turn, shift = np.diag([-1.0, 1, 1]), np.array([0.5, 0, 0])
    points = np.random.default_rng(1).uniform(-1, 1, (20, 3))
    here, there = lamp.reaching(points, 1.0), lamp.moved(turn, shift).reaching(
        points @ turn.T + shift, 1.0
    )
    assert there[0] == pytest.approx(here[0] @ turn.T)
    assert there[2] == pytest.approx(here[2])


def mirrored(polygons):
    """The image at x = 0."""
    return (polygons * [-1, 1, 1])[:, [0, 3, 2, 1]]


def rooms(share=1.0, lamps=()):
    """A room with a mirror of a wall, and both rooms without it, with all that is in them."""
    floor, ceiling, left, right, front, back = (WALLS[[k]] for k in range(6))
    table = block((1, 1, 0), (1.8, 1.6, 1.2))
    light = np.array([[[2.5, 1, 2.49], [2.5, 2, 2.49], [3, 2, 2.49], [3, 1, 2.49]]], float)
    parts = [floor, ceiling, right, front, back, table, light]
    materials = [surface(str(k), r) for k, r in enumerate((0.3, 0.8, 0.5, 0.2, 0.7, 0.6))]
    materials.append(surface("light", 0.0, 20.0))
    mirror = surface("mirror", 0.0, mirror=Constant(share * ONE))
    alone = scene_of([*parts, left], [*materials, mirror], lights=lamps)
    both = [np.concatenate([p, mirrored(p)]) for p in parts]
    more = tuple(lamp.moved(np.diag([-1.0, 1, 1]), np.zeros(3)) for lamp in lamps)
    return alone, scene_of(both, materials, lights=(*lamps, *more))


def places(count=24):
    rng = np.random.default_rng(0)
    x = rng.uniform((0.05, 0.05, 0), (3.95, 2.95, 0), (count, 3))
    free = (np.abs(x[:, 0] - 1.4) > 0.45) | (np.abs(x[:, 1] - 1.3) > 0.35)
    wall = rng.uniform((0.05, 0, 0.05), (3.95, 0, 2.45), (count // 2, 3))
    normals = np.repeat([[0, 0, 1.0], [0, 1.0, 0]], [free.sum(), len(wall)], axis=0)
    return np.concatenate([x[free], wall]), normals


@pytest.mark.parametrize("lamps", [(), (Point(np.array([3.0, 0.5, 2]), 10 * ONE),)])
def test_a_mirror_wall_doubles_the_room(lamps):
    alone, both = rooms(lamps=lamps)
    points, normals = places()
    solution = solve(alone, 0.05)
    found, bars = solution.irradiance(points, normals)
    exact, _ = solve(both, 0.01).irradiance(points, normals)
    off = np.abs(found - exact)[:, 0]
    assert np.percentile(off / exact[:, 0], 95) < 0.02
    assert np.mean(off <= bars[:, 0] + 0.005 * exact[:, 0]) > 0.95
    assert solution.balance.defect < 0.01


def level_of(scene):
    return solve(scene, 0.3, mesh="2", order=1).level


def by_rays(level):
    space = replace(level.tracer.space, planes=None)
    return replace(level.tracer, space=space, images=(), targets=None)


@pytest.mark.parametrize("standing", [False, True])
def test_images_bring_what_rays_bring(standing):
    """A mirror that hangs on a wall, or stands in the room, whose plane cuts walls and a block."""
    if standing:
        glass = np.array([[[1.2, 0.5, 0.4], [1.2, 2, 0.4], [1.2, 2, 2], [1.2, 0.5, 2]]])
    else:
        glass = np.array([[[0.1, 0.5, 0.4], [0.1, 2, 0.4], [0.1, 2.5, 2], [0.1, 0.5, 2]]])
    table = block((1.0, 2.2, 0), (1.8, 2.6, 1.2))
    mirror = surface("mirror", 0.0, mirror=Constant(np.array([0.9, 0.5, 0.1])))
    materials = [surface("w", 0.5), surface("floor", 0.2, 1.0), surface("t", 0.3), mirror]
    level = level_of(scene_of([WALLS[1:], WALLS[:1], table, glass], materials))
    points, normals = np.array([[2.5, 1, 0], [3.9, 1.2, 1], [0.5, 1, 2.4], [2, 0.1, 1]]), np.array(
        [[0, 0, 1.0], [-1, 0, 0], [0, 0, -1], [0, 1, 0]]
    )
    b, none = level.coefficients, np.zeros(3)
    here = arriving_by_chains(level.tracer, b, none, points, normals, 4096)
    there = arriving_by_chains(by_rays(level), b, none, points, normals, 1 << 17)
    assert len(level.tracer.images) == 2
    assert np.any(here.total > 0.01)
    off = np.abs(here.total - there.total)
    assert np.all(off <= 4 * np.hypot(here.error, there.error) + 2e-4 * here.total.max())


def test_two_mirrors_show_each_other():
    glass = [np.array([[[x, 0.5, 0.4], [x, 2, 0.4], [x, 2, 2], [x, 0.5, 2]]]) for x in (0.1, 3.9)]
    glass[1] = glass[1][:, ::-1]
    mirror = surface("mirror", 0.0, mirror=Constant(0.7 * ONE))
    materials = [surface("w", 0.5), surface("floor", 0.2, 1.0), mirror]
    level = level_of(scene_of([WALLS[1:], WALLS[:1], np.concatenate(glass)], materials))
    sequences = level.tracer.space.planes.sequences
    one, two = sequences[4:]  # after the four sides, what each front shows of the other
    assert len(sequences) == 6 and one == two[::-1] and len(one) == 2
    points, normals = np.array([[2.0, 1.2, 0.5]]), np.array([[1.0, 0, 0]])
    b, none = level.coefficients, np.zeros(3)
    here = arriving_by_chains(level.tracer, b, none, points, normals, 1 << 14)
    there = arriving_by_chains(by_rays(level), b, none, points, normals, 1 << 18)
    error = np.hypot(here.error, there.error)
    assert np.all(np.abs(here.total - there.total) <= 4 * error + 1e-4 * here.total)
    assert np.all(here.error < 0.3 * there.error * 16**0.75)  # only the depth is left to rays
