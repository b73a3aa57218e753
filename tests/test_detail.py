"""Textures, bumps and normals between corners, as pictures show them."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, faces_of, rotation, scene, uv_sphere
from test_texturing import CORNERS, checkers, lit_room, patches_of, with_texture

import radiosity
from radiosity.light.bump import Bump
from radiosity.light.coherent import FresnelMirror
from radiosity.light.facets import TrowbridgeReitz
from radiosity.light.phong import Phong, phong
from radiosity.light.shadowing import smith
from radiosity.light.shininess import Shininess
from radiosity.light.sources import Point
from radiosity.light.texture import Texture
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Camera
from radiosity.transport.lookup import make_table
from radiosity.transport.polygon import point_factor
from radiosity.view.detail import Detail
from radiosity.view.gather import first_rows, radiance, render
from radiosity.view.shading import make_shading
from radiosity.view.smoothing import MIXED

UP = np.array([0.0, 0, 1])


def waves(n, u=1, v=0):
    """Return sin(2 pi (u x + v y)) on n x n texels."""
    x = (np.arange(n) + 0.5) / n
    return Texture(np.sin(2 * np.pi * (u * x + v * x[::-1, None]))[..., None])


def detail_of(faces, bump=None, texture=None):
    made = scene(faces.vertices, 0.5)
    materials = tuple(replace(m, bump=bump, texture=texture) for m in made.materials)
    shape = np.where(faces.is_triangle[:, None], [1, 0], [1, 1])
    made = replace(made, faces=faces, materials=materials)
    return Detail(made, make_table(faces, patches_of(faces, shape)))


LAID = {
    "straight": [[1, 0], [0, 1]],
    "mirrored": [[-1, 0], [0, 1]],
    "turned": [[0, 1], [-1, 0]],
    "sheared": [[1, 0.4], [-0.3, 2]],
}


@pytest.mark.parametrize("corners", [CORNERS, CORNERS[[0, 1, 3, 3]]], ids=["quad", "triangle"])
@pytest.mark.parametrize("laid", LAID)
def test_a_bumped_plane_has_the_normals_of_its_waves(laid, corners):
    """z = h sin(2 pi (u + 2 v)), (u, v) = A (x/X, y/Y): N = (-z_x, -z_y, 1) over its length."""
    sides, height, rng = np.array([2.0, 3.0]), 0.02, np.random.default_rng(0)
    turn, A = rotation(rng), np.array(LAID[laid])
    plane = np.column_stack([corners * sides, np.zeros(4)]) @ turn
    faces = Faces.from_polygons([plane], 0, 0, uv=[corners @ A.T])
    places = rng.uniform(0.01, 0.49, (300, 2))
    slope = height * 2 * np.pi * np.cos(2 * np.pi * (places @ A.T @ [1, 2]))
    exact = np.column_stack([-slope[:, None] * ([1, 2] @ A) / sides, np.ones(300)]) @ turn
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    points, errors = np.column_stack([places * sides, np.zeros(300)]) @ turn, []
    for n in (64, 128, 256):
        detail = detail_of(faces, Bump(waves(n, 1, 2), height))
        found = detail.normals(np.zeros(300, int), points, np.ones(300))
        errors.append(np.abs(found - exact).max())
    rates = np.log2(errors[:-1]) - np.log2(errors[1:])
    assert (rates > 1.85).all() and errors[-1] < 5e-4  # second order in a texel's size


def test_the_back_of_a_bump_is_a_dent():
    faces = Faces.from_polygons([SQUARE], 0, 0, uv=[CORNERS])
    detail = detail_of(faces, Bump(waves(64), 0.05))
    points, face = np.random.default_rng(2).random((9, 3)) * [1, 1, 0], np.zeros(9, int)
    front = detail.normals(face, points, np.ones(9))
    back = detail.normals(face, points, -np.ones(9))
    assert np.ptp(front[:, 0]) > 0.2
    np.testing.assert_array_equal(back, -front)


def test_bumps_that_lie_nowhere_leave_the_normal_alone():
    faces = Faces.from_polygons([SQUARE], 0, 0, uv=[0 * CORNERS])
    detail = detail_of(faces, Bump(waves(64), 0.05))
    found = detail.normals(np.zeros(1, int), np.array([[0.2, 0.2, 0]]), np.ones(1))
    np.testing.assert_array_equal(found, [UP])


def test_normals_between_corners_are_a_spheres():
    """Those of a sphere are its places, so between corners they point along the place itself."""
    sphere = uv_sphere(8)
    faces = replace(faces_of(sphere), corner_normals=-sphere)
    middle = sphere.mean(axis=1) * 0.7 + 0.3 * sphere[:, 0]
    found = detail_of(faces).normals(np.arange(len(faces)), middle, np.ones(len(faces)))
    exact = -middle / np.linalg.norm(middle, axis=1, keepdims=True)
    np.testing.assert_allclose(found, exact, atol=1e-14)


def furnace(extra=()):
    """Return a closed room in which B = 1 / (1 - 0.6) everywhere, solved on few patches."""
    polygons = np.concatenate([box((0, 0, 0), (1, 1, 1)), *extra])
    return scene(polygons, 0.6, 1.0)


@pytest.mark.parametrize("tilted", ["bump", "corners"])
def test_even_light_shows_no_bumps(tilted):
    """E = B for every normal where all that is seen has the radiosity B, the face itself too."""
    room = furnace()
    if tilted == "bump":
        faces = replace(room.faces, uv=np.repeat([CORNERS], 6, axis=0))
        relief = Bump(waves(32, 1, 1), 0.1)  # up to 32 degrees
        room = replace(
            room, faces=faces, materials=tuple(replace(m, bump=relief) for m in room.materials)
        )
    else:
        away = room.faces.vertices - 0.5
        lean = room.faces.normals()[:, None] + away
        room = replace(room, faces=replace(room.faces, corner_normals=lean))
    solution = radiosity.solve(room, mesh="1", order=0)
    shading = make_shading(solution)
    rng, k = np.random.default_rng(3), 400
    points = np.column_stack([rng.uniform(0.2, 0.8, (k, 2)), np.zeros(k)])
    rows, view = np.zeros(k, int), np.repeat([UP], k, axis=0)
    normals = shading.detail.normals(rows, points, np.ones(k))
    assert normals[:, 2].min() < 0.9
    leaving, _, _ = radiance(solution, shading, rows, points, view, np.arange(k), 0)
    # Lamps are exact where seen as a whole; of four shadow rays a lamp that is cut by the face's
    # horizon may lose or gain one.
    assert leaving[:, 0].mean() == pytest.approx(2.5 / np.pi, rel=2e-3)
    assert leaving[:, 0] == pytest.approx(2.5 / np.pi, rel=0.1)


def test_lamps_below_the_face_give_nothing():
    """A lamp under a bumped sheet, however much its bumps lean towards it."""
    sheet = np.array([SQUARE])
    lamp = np.array([SQUARE + [1.2, 0, -0.3]])
    room = scene(np.concatenate([sheet, lamp]), [0.5, 0.0], [0, 10], two_sided=False)
    uv = np.concatenate([[CORNERS], np.full((1, 4, 2), np.nan)])
    relief = replace(room.materials[0], bump=Bump(waves(64), 0.3))
    room = replace(room, faces=replace(room.faces, uv=uv), materials=(relief, room.materials[1]))
    solution = radiosity.solve(room, mesh="1", order=0)
    shading = make_shading(solution)
    x = np.linspace(0.02, 0.98, 49)
    points = np.stack([x, 0 * x + 0.5, 0 * x], axis=1)
    view = np.repeat([UP], 49, axis=0)
    normals = shading.detail.normals(np.zeros(49, int), points, np.ones(49))
    towards = np.array([1.7, 0.5, -0.3]) - points
    assert (np.einsum("kc,kc->k", normals, towards) > 0).any()
    leaving, _, _ = radiance(solution, shading, np.zeros(49, int), points, view, np.arange(49), 0)
    assert (leaving == 0).all()


@pytest.mark.parametrize("front", [True, False])
def test_light_through_a_curved_sheet_starts_on_its_other_side(front):
    """In even light from everywhere L = (rho + tau) L_sky on both sides, but for what a sheet that
    bulges sees of itself."""
    sheet = np.array([SQUARE])
    room = scene(sheet, 0.3, ambient=np.full(3, 2.0))
    lean = np.array([0, 0, 1]) + 0.2 * (SQUARE - [0.5, 0.5, 0])
    lean = lean / np.linalg.norm(lean, axis=1, keepdims=True)
    clear = replace(room.materials[0], translucent=np.full(3, 0.5), absorptance=np.full(3, 0.7))
    faces = replace(room.faces, corner_normals=np.array([lean]))
    solution = radiosity.solve(replace(room, faces=faces, materials=(clear,)), mesh="2", order=0)
    side = solution.patches.front == front
    rows = np.flatnonzero(side)
    points = solution.patches.centroid[rows]
    view = solution.patches.normal[rows]
    args = solution, make_shading(solution), rows, points, view, np.arange(len(rows))
    leaving = np.mean([radiance(*args, k)[0] for k in range(64)], axis=0)
    np.testing.assert_allclose(leaving, 0.8 * 2, rtol=0.02)  # itself is seen in 1 %, at 0.8


def test_highlights_follow_the_bumps():
    """An even slope in one direction: the lobe and the cosine are those of the tilted plane."""
    lamp = np.array([SQUARE - [0.5, 0.5, 0]])[:, ::-1] * 1e-3 + [0.3, 0.1, 2]
    floor = np.array([2 * SQUARE - [1, 1, 0]])
    room = scene(np.concatenate([floor, lamp]), 0.0, [0, 1000])
    gloss = Phong(np.full(3, 0.5), 20.0)
    ramp = Bump(Texture(np.linspace(0, 1, 65)[None, :, None], repeat=False), 0.4)
    materials = replace(room.materials[0], specular=gloss, bump=ramp), room.materials[1]
    uv = np.concatenate([[CORNERS], np.full((1, 4, 2), np.nan)])
    room = replace(room, faces=replace(room.faces, uv=uv), materials=materials)
    solution = radiosity.solve(room, mesh="1", order=0)
    shading, view = make_shading(solution), np.array([[-1.0, 0.2, 1.0]]) / np.sqrt(2.04)
    point = np.zeros((1, 3))
    found, _, _ = radiance(solution, shading, np.zeros(1, int), point, view, np.zeros(1, int), 0)
    slope = 0.4 * 65 / 64 / 2  # 65 texels from 0 to 1, over a length of 2
    normal = np.array([-slope, 0, 1]) / np.hypot(slope, 1)
    away = np.array([0.3, 0.1, 2.0])
    to_light = away / np.linalg.norm(away)
    irradiance = 1000 / np.pi * 1e-6 * (to_light @ normal) * to_light[2] / (away @ away)
    expected = phong(0.5, 20.0, normal, to_light, view[0]) * irradiance
    assert found[0, 0] == pytest.approx(expected[0], rel=2e-3)  # the lamp has a size


def lit_sphere(n, smooth, half=1.0):
    """Return the solution of a unit sphere of 2 n x n faces under a lamp, in black space."""
    sphere = uv_sphere(n)
    outside = sphere[:, ::-1].copy()
    triangle = np.all(sphere[:, 3] == sphere[:, 2], axis=1)
    outside[triangle] = sphere[triangle][:, [2, 1, 0, 0]]
    lamp = np.array([[[-half, -half, 5], [-half, half, 5], [half, half, 5], [half, -half, 5]]])
    polygons = np.concatenate([outside, lamp])
    made = scene(polygons[[0, -1]], [0.8, 0.0], [0, 100], two_sided=False)
    faces = faces_of(polygons, np.r_[np.zeros(len(outside), int), 1])
    normals = np.concatenate([outside, np.full((1, 4, 3), np.nan)])
    faces = replace(faces, corner_normals=normals if smooth else None)
    return radiosity.solve(replace(made, faces=faces), mesh="1", order=0), lamp[0]


def seen_on_sphere(solution, true, eye):
    """Return the mean of 32 passes' radiance of sight lines to points (k, 3) of a unit sphere."""
    to_view = eye - true
    to_view /= np.linalg.norm(to_view, axis=1, keepdims=True)
    rows, points = first_rows(solution, true + 2 * to_view, -to_view)
    args = solution, make_shading(solution), rows, points, to_view, np.arange(len(rows))
    return np.mean([radiance(*args, k)[0] for k in range(32)], axis=0)[:, 0]


def exact_radiance(true, lamp):
    return np.array([0.8 * 100 / np.pi * point_factor(*x, *x, lamp) for x in true])


def sphere_error(n, smooth):
    """Return the rms relative error of the radiance of sight lines to the lit part."""
    solution, lamp = lit_sphere(n, smooth)
    near = np.random.default_rng(4).normal(size=(500, 3)) * [1, 1, 0.3] + [0, 0, 1.3]
    true = near / np.linalg.norm(near, axis=1, keepdims=True)
    true = true[true[:, 2] > 0.5]
    found = seen_on_sphere(solution, true, np.array([0.3, -0.2, 6.0]))
    return np.sqrt(np.mean((found / exact_radiance(true, lamp) - 1) ** 2))


def test_lamps_set_behind_the_curve_and_not_behind_its_faces():
    """Where the whole lamp is just above a sphere's horizon, faces that turn away are lit too."""
    solution, lamp = lit_sphere(12, True, 0.1)
    true = np.random.default_rng(5).normal(size=(9000, 3))
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    height = np.einsum("kc,vc->kv", true, lamp) - 1
    true = true[(height.min(axis=1) > 0.1) & (height.min(axis=1) < 0.4)]
    assert len(true) > 100
    found = seen_on_sphere(solution, true, 3 * true)
    exact = exact_radiance(true, lamp)
    assert np.sqrt(np.mean((found - exact) ** 2)) < 0.03 * exact.mean()  # 33 % off the faces
    assert (found > 0.9 * exact).all()


def test_a_smooth_spheres_radiance_converges_to_the_true_ones():
    """Second order in the size of the faces; flat faces are of first order only."""
    smooth = [sphere_error(n, True) for n in (8, 16, 32)]
    flat = [sphere_error(n, False) for n in (8, 16, 32)]
    assert (np.log2(smooth[:-1]) - np.log2(smooth[1:]) > 1.8).all()
    assert (np.log2(flat[:-1]) - np.log2(flat[1:]) < 1.3).all()
    assert smooth[-1] < 6e-3 < flat[-1]


def floor_camera():
    middle = np.array([0.5, 0.5, 0])
    return Camera("down", np.array([0.5, 0.5, 0.9]), middle, np.array([0.0, 1, 0]), 55.0, (24, 24))


def test_pixels_show_the_texels_and_not_their_mean():
    """Both true reflectances times E / pi, with E as the probe has it."""
    room = with_texture(lit_room(), 0, checkers())
    solution = radiosity.solve(room, 0.02)
    found = render(solution, floor_camera(), samples=256).pixels
    assert make_shading(solution).plane[solution.patches.face == 0].max() >= 0  # smoothed
    width = 2 * 0.9 * np.tan(np.radians(55 / 2))
    for row, column, rho in ((5, 5, 0.8), (5, 18, 0.2), (18, 5, 0.2), (18, 18, 0.8)):
        x = 0.5 + width * ((column + 0.5) / 24 - 0.5)
        y = 0.5 - width * ((row + 0.5) / 24 - 0.5)
        dark = (x < 0.5) == (y < 0.5)
        E, _ = solution.irradiance([[x, y, 0]], [UP])
        rho = 0.2 if dark else 0.8
        assert found[row, column] == pytest.approx(rho * E[0] / np.pi, rel=0.02)  # the accuracy


def test_smoothing_takes_noise_from_irradiance_and_leaves_texels():
    """Away from the edges of the squares; unsmoothed, 8 rays are off by 4 %."""
    room = with_texture(lit_room(), 0, checkers())
    solution = radiosity.solve(room, 0.1)
    rough = render(solution, floor_camera(), samples=8).pixels
    fine = render(solution, floor_camera(), samples=512).pixels
    away = np.r_[3:10, 14:21]
    error = (rough / fine - 1)[np.ix_(away, away)]
    assert np.sqrt(np.mean(error**2)) < 0.02


def test_bumped_faces_are_not_smoothed():
    room = lit_room()
    faces = replace(room.faces, uv=np.repeat([CORNERS], 6, axis=0))
    relief = replace(room.materials[0], bump=Bump(waves(32), 0.01))
    room = replace(room, faces=faces, materials=(relief, *room.materials[1:]))
    solution = radiosity.solve(room, mesh="2", order=0)
    floor = solution.patches.face == 0
    plane = make_shading(solution).plane
    assert (plane[floor] == MIXED).all() and (plane[~floor] >= 0).all()
    assert np.isfinite(render(solution, floor_camera(), samples=8).pixels).all()


def test_black_backs_stay_black():
    room = with_texture(lit_room(), 0, checkers())
    detail = Detail(room, make_table(room.faces, patches_of(room.faces, [[1, 1]] * 6)))
    points = np.array([[0.25, 0.25, 0], [0.75, 0.25, 0]])
    face = np.zeros(2, int)
    found = detail.diffuse(face, points, np.array([[0.5] * 3, [0.0] * 3]))
    np.testing.assert_allclose(found, [[0.2] * 3, [0.0] * 3], rtol=1e-6)


def shiny_room(index=None, spread=None, diffuse=0.0):
    """Return a floor of facets under a lamp and a point light; c3 by a texture, or one number."""
    lamp = np.array([SQUARE])[:, ::-1] + [0, 0, 1]
    room = scene(np.concatenate([[SQUARE], lamp]), [diffuse, 0.0], [0, 10])
    worn = Shininess(Texture(np.linspace(0, 1, 9)[None, :, None], repeat=False), 0.2)
    rough = worn.mean if spread is None else spread
    gloss = TorranceSparrow(TrowbridgeReitz(rough), smith, index)
    floor = replace(room.materials[0], specular=gloss, shininess=None if spread else worn)
    light = Point(np.array([0.3, 0.4, 0.8]), np.full(3, 2.0))
    uv = np.concatenate([[CORNERS], np.full((1, 4, 2), np.nan)])
    faces = replace(room.faces, uv=uv)
    return replace(room, faces=faces, materials=(floor, room.materials[1]), lights=(light,))


@pytest.mark.parametrize("coat", [False, True])
def test_each_point_shines_by_its_own_texel(coat):
    """As a floor whose facets all have the spread that the texture gives the point."""
    index, diffuse = (np.array([1.5]), 0.4) if coat else (None, 0.0)
    worn = radiosity.solve(shiny_room(index, None, diffuse), mesh="1", order=0)
    points = np.array([[x, 0.45, 0.0] for x in (0.1, 0.4, 0.7, 0.95)])
    view = np.repeat([[0.6, 0, 0.8]], 4, axis=0)
    found, _, _ = radiance(
        worn, make_shading(worn), np.zeros(4, int), points, view, np.arange(4), 0
    )
    spreads = worn.scene.materials[0].shininess.at(points[:, :2])
    assert spreads[-1] > 4 * spreads[0]
    for k in range(4):
        even = radiosity.solve(shiny_room(index, float(spreads[k]), diffuse), mesh="1", order=0)
        alone, _, _ = radiance(
            even, make_shading(even), np.zeros(1, int), points[k : k + 1], view[:1],
            np.array([k]), 0,
        )  # fmt: skip
        # Albedos of coats lie between tables (2e-3); what the floor sees of itself is nothing.
        assert found[k] == pytest.approx(alone[0], rel=4e-3 if coat else 1e-9)
    assert found[0, 0] != pytest.approx(found[3, 0], rel=0.2)


def test_texels_lie_under_mirrors_and_coats_as_other_reflectances_do():
    room = with_texture(lit_room(), 0, checkers())
    film = FresnelMirror(np.array([1.5]))
    room = replace(room, materials=(replace(room.materials[0], mirror=film), *room.materials[1:]))
    detail = Detail(room, make_table(room.faces, patches_of(room.faces, [[1, 1]] * 6)))
    point = np.array([[0.25, 0.25, 0]])
    found = detail.diffuse(np.zeros(1, int), point, np.full((1, 3), 0.5))
    expected = 0.2  # what the film does to it is told by angle
    np.testing.assert_allclose(found[0], np.broadcast_to(expected, 3), rtol=1e-6)
