"""Translucent sheets: two rooms, a milky globe and a leaf against closed forms; scene files.

Closed forms (B radiosity, E irradiance, tau what goes through, rho what is reflected):

- Two rooms with one sheet between them, B_1 and B_2 everywhere in each: walls emit (1 - rho) B; the
  sheet's dark side keeps B_2 = rho B_2 + tau B_1 and its other side emits (1 - rho) B_1 - tau B_2.
- A globe of radius r about a lamp of flux P, in a sphere of radius R: by symmetry all is even, and
  inside B_i = E_i = P/(4 pi r^2) + B_i off the lamp, so B_i = rho (B_i + E_L) + tau B_w,
  B_o = rho B_w + tau (B_i + E_L), B_w = rho_w ((r/R)^2 B_o + (1 - (r/R)^2) B_w).
- A leaf in the open under parallel light E on its face: B = rho E in front and tau E behind.
"""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, scene, uv_sphere

import radiosity
from radiosity.light.sources import Directional, Point
from radiosity.mesh.elements import from_other_side, make_elements
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Camera, Material, Scene, SceneError
from radiosity.scene.toml import read_toml
from radiosity.solve.plan import make_plan

ROOMS = np.concatenate([
    box((0, 0, 0), (2, 1, 1))[[0, 1, 2, 4, 5]], box((2, 0, 0), (3, 1, 1))[[0, 1, 3, 4, 5]],
    box((0, 0, 0), (2, 1, 1))[3:4],
])  # fmt: skip
RHO, TAU = np.array([0.5, 0.4, 0.2]), np.array([0.3, 0.1, 0.7])


def with_sheet(made, tau, which=-1):
    materials = list(made.materials)
    materials[which] = replace(materials[which], translucent=np.broadcast_to(tau, 3).copy())
    return replace(made, materials=tuple(materials))


def two_even_rooms():
    dark = np.array([1.0, 2.0, 3.0])
    bright = (1 - RHO) / TAU * dark
    walls = [[0.6] * 3] * 5 + [[0.3, 0.5, 0.7]] * 5
    level = [bright] * 5 + [dark] * 5
    emitted = [*((1 - np.array(walls)) * level), (1 - RHO) * bright - TAU * dark]
    return with_sheet(scene(ROOMS, [*walls, RHO], emitted), TAU), bright, dark


@pytest.mark.parametrize(
    "options", [{}, {"order": 0}, {"solver": "jacobi"}, {"solver": "direct"}, {"force": True}]
)
def test_two_even_rooms(options):
    made, bright, dark = two_even_rooms()
    solution = radiosity.solve(made, 0.05, **options)
    assert solution.solver == options.get("solver", "gmres")
    patches = solution.patches
    light = (patches.face < 5) | ((patches.face == 10) & patches.front)
    exact = np.where(light[:, None], bright, dark) * solution.live[:, None]
    np.testing.assert_allclose(solution.radiosity, exact, rtol=1e-6)  # the solver's tolerance
    assert solution.balance.defect < 1e-6


def lit_rooms():
    """A lamp off the middle shines on one side of the sheet only."""
    made = with_sheet(scene(ROOMS, 0.5), 0.4)
    return replace(made, lights=(Point(np.array([1.6, 0.2, 0.3]), np.array([1.0, 2.0, 3.0])),))


def test_what_comes_through_is_brightest_behind_the_brightest():
    """Points behind the sheet: linear elements, constant ones and sides exchanged agree."""
    points = np.array([[2.9, 0.15, 0.3], [2.9, 0.85, 0.3], [2.2, 0.2, 0.0], [2.2, 0.8, 0.0]])
    normals = np.array([[-1.0, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, 1]])
    made = lit_rooms()
    one = radiosity.solve(made, 0.01).irradiance(points, normals)[0]
    constant = radiosity.solve(made, 0.02, order=0).irradiance(points, normals)[0]
    np.testing.assert_allclose(constant, one, rtol=0.02)  # the accuracy asked
    assert one[2, 0] > 1.3 * one[3, 0]  # seen to fail with a slope of the wrong sign
    flipped = ROOMS.copy()
    flipped[-1] = flipped[-1, ::-1]
    turned = replace(with_sheet(scene(flipped, 0.5), 0.4), lights=made.lights)
    other = radiosity.solve(turned, 0.01).irradiance(points, normals)[0]
    np.testing.assert_allclose(other, one, rtol=0.01)


def test_light_is_followed_through_one_sheet_after_the_other():
    """Three rooms in a row: the second sheet is lit by what comes through the first."""
    third = box((3, 0, 0), (4, 1, 1))[[0, 1, 3, 4, 5]]
    middle = box((2, 0, 0), (3, 1, 1))[[0, 1, 4, 5]]
    sheets = np.stack([ROOMS[-1], ROOMS[-1] + [1, 0, 0]])
    made = scene(np.concatenate([ROOMS[:5], middle, third, sheets]), 0.5)
    made = with_sheet(with_sheet(made, 0.3, -1), 0.3, -2)
    made = replace(made, lights=(Point(np.array([0.5, 0.5, 0.5]), np.ones(3)),))
    solution = radiosity.solve(made, 0.05)
    last = (solution.patches.centroid[:, 0] > 3.0) & solution.patches.front
    assert last.any() and solution.radiosity[last].all()
    np.testing.assert_allclose(solution.balance.absorbed, 4 * np.pi, rtol=0.01)  # nothing is lost


def test_other_side_has_the_same_values_at_the_same_places():
    patches = radiosity.solve(lit_rooms(), 0.1).patches
    elements = make_elements(patches, np.arange(len(patches)), 1)
    twin = np.append(patches.back_of, patches.front_of[patches.fronts :])
    b = np.random.default_rng(1).normal(size=(3 * len(patches), 2))
    seen = from_other_side(elements, twin) @ b
    k = np.flatnonzero(patches.back_of >= 0)
    corners = patches.vertices[k, 1]
    here, there = elements.at(corners, k, seen), elements.at(corners, patches.back_of[k], b)
    np.testing.assert_allclose(here, there, atol=1e-12)
    assert not seen[np.flatnonzero(twin < 0)].any()


def globe(n):
    """A milky globe about a lamp inside a grey sphere; materials globe and wall."""
    shell = uv_sphere(n)
    polygons = np.concatenate([shell, 2 * shell])
    kind = np.repeat([0, 1], len(shell))
    milk = Material("globe", np.full(3, 0.45), np.full(3, 0.55), np.zeros(3),
                    translucent=np.full(3, 0.5))  # fmt: skip
    wall = Material("wall", np.full(3, 0.6), np.full(3, 0.4), np.zeros(3))
    faces = Faces.from_polygons(polygons, kind, 0, merge=False)
    lamp = Point(np.zeros(3), np.full(3, 1.0))
    return Scene("globe", faces, (milk, wall), ("all",), lights=(lamp,))


def even_globe(area):
    """Return B inside the globe, outside it and on the wall, r = 1, R = 2; ``area`` of its facets.

    Facets have less of it than the sphere, and get all of the light.
    """
    rho, tau, wall, share, lamp = 0.45, 0.5, 0.6, 0.25, 4 * np.pi / area
    # unknowns B_i, B_o, B_w
    left = [[1 - rho, 0, -tau], [-tau, 1, -rho], [0, -wall * share, 1 - wall * (1 - share)]]
    return np.linalg.solve(left, [rho * lamp, tau * lamp, 0])


@pytest.mark.parametrize(("n", "accuracy", "bound"), [(5, 0.05, 0.02), (12, 0.1, 0.01)])
def test_milky_globe(n, accuracy, bound):
    """Solved between patches, and by clusters; what is not even on facets is left."""
    made = globe(n)
    assert bool(make_plan(made, accuracy).clusters) == (n == 12)
    solution = radiosity.solve(made, accuracy)
    patches, b = solution.patches, solution.radiosity[:, 0]
    kind = made.faces.material[patches.face]
    inside, outside, wall = (
        np.average(b[k], weights=patches.area[k])
        for k in ((kind == 0) & patches.front, (kind == 0) & ~patches.front,
                  (kind == 1) & patches.front)
    )  # fmt: skip
    area = made.faces.areas()[made.faces.material == 0].sum()
    np.testing.assert_allclose([inside, outside, wall], even_globe(area), rtol=bound)


def test_leaf_under_the_sun():
    sun = Directional(np.array([0, 0.6, -0.8]), np.array([10.0, 20, 30]))
    made = replace(with_sheet(scene(SQUARE[None], RHO[None]), TAU), lights=(sun,))
    solution = radiosity.solve(made, 0.05)
    arriving = 0.8 * sun.irradiance
    exact = np.where(solution.patches.front[:, None], RHO * arriving, TAU * arriving)
    np.testing.assert_allclose(solution.radiosity, exact)
    np.testing.assert_allclose(solution.balance.absorbed, (1 - RHO - TAU) * arriving)
    np.testing.assert_allclose(solution.balance.escaped, (RHO + TAU) * arriving)


def test_leaf_under_a_sky():
    made = with_sheet(scene(SQUARE[None], RHO[None], ambient=np.full(3, 2.0)), TAU)
    solution = radiosity.solve(made, 0.05)
    exact = np.tile((RHO + TAU) * 2 * np.pi, (len(solution.patches), 1))
    np.testing.assert_allclose(solution.radiosity, exact)


def test_picture_of_a_leaf_shows_what_comes_through():
    sun = Directional(np.array([0, 0, -1.0]), np.array([10.0, 20, 30]))
    made = replace(with_sheet(scene(SQUARE[None], RHO[None]), TAU), lights=(sun,))
    solution = radiosity.solve(made, 0.05)
    for z, share in ((3.0, RHO), (-3.0, TAU)):
        camera = Camera("c", np.array([0.5, 0.5, z]), np.array([0.5, 0.5, 0]),
                        np.array([0, 1.0, 0]), 10.0, (5, 5))  # fmt: skip
        pixels = radiosity.render(solution, camera).pixels
        np.testing.assert_allclose(pixels[2, 2], share * sun.irradiance / np.pi, rtol=1e-6)


def test_sheet_that_lies_on_a_floor_lets_nothing_through():
    """Where its other side is in contact what would come through is absorbed."""
    room = box((0, 0, 0), (2, 2, 2))
    sheet = SQUARE[None] + [0.5, 0.5, 0]
    made = with_sheet(scene(np.concatenate([room, sheet]), 0.5, [0, 1, 0, 0, 0, 0, 0]), 0.4)
    solution = radiosity.solve(made, 0.05)
    plain = radiosity.solve(
        scene(np.concatenate([room, sheet]), 0.5, [0, 1, 0, 0, 0, 0, 0]), 0.05
    )
    assert solution.balance.defect < 0.01
    np.testing.assert_allclose(solution.balance.absorbed, plain.balance.absorbed, rtol=1e-6)


def material(text):
    floor = '[[geometry]]\nmaterial = "m"\npolygons = [[[0,0,0],[2,0,0],[2,1,0],[0,1,0]]]\n'
    return read_toml(floor + f"[materials.m]\n{text}\n", "x.toml", lambda name: None, "x")


def test_scene_file_gives_translucent_materials():
    (sheet,) = material("diffuse = [0.2, 0.3, 0.4]\ntranslucent = [0.1, 0.2, 0.3]").materials
    assert sheet.translucent.tolist() == [0.1, 0.2, 0.3]
    assert material("translucent = 0.5").materials[0].diffuse.tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("diffuse = 0.7\ntranslucent = [0.1, 0.4, 0.2]",
         "diffuse + translucent = 1.1 at 0 degrees in band g"),
        ("translucent = 1.5", "materials.m.translucent = 1.5 must lie in"),
        ("translucent = 0.5\ntwo_sided = false", "materials.m is translucent and not two_sided"),
    ],  # fmt: skip
)
def test_sheets_that_cannot_be_are_refused(text, told):
    with pytest.raises(SceneError) as error:
        material(text)
    assert len(error.value.problems) == 1 and told in error.value.problems[0]
