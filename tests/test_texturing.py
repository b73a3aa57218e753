"""Textured scenes, solved: reflectances of patches, power, and what a scene without them pays."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, faces_of, rotation, scene

import radiosity
from radiosity.light.texture import Texture
from radiosity.mesh.contact import find_contacts
from radiosity.mesh.division import Division
from radiosity.mesh.faces import Faces
from radiosity.mesh.patches import make_patches
from radiosity.scene.model import SceneError
from radiosity.solve import texturing
from radiosity.solve.system import make_terms
from radiosity.transport.lookup import coordinates_at, make_table

CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
SCENES = Path(__file__).resolve().parent.parent / "scenes"


def checkers(squares=2, texels=32, low=0.2, high=0.8):
    """Return a board of squares x squares, each of so many texels; dark in the lower left."""
    k = np.arange(squares * texels) // texels
    board = np.where((k[:, None] + k + squares) % 2 == 1, low, high)
    return Texture(np.repeat(board[..., None], 3, axis=2))


def with_texture(room, face, texture, uv=CORNERS):
    """Return a room one of whose faces, each of its own material, has a texture."""
    every = np.full((len(room.faces), 4, 2), np.nan)
    every[face] = uv
    mean = texture.mean
    changed = replace(room.materials[face], texture=texture, diffuse=mean, absorptance=1 - mean)
    materials = (*room.materials[:face], changed, *room.materials[face + 1 :])
    return replace(room, faces=replace(room.faces, uv=every), materials=materials)


def lit_room(rho=0.5):
    return scene(box((0, 0, 0), (1, 1, 1)), rho, [0, 10, 0, 0, 0, 0])


def patches_of(faces, shape):
    none = np.zeros(len(faces), bool)
    return make_patches(faces, Division(np.array(shape)), find_contacts(faces, none))


def test_places_on_faces_are_found_again():
    quads = np.array([SQUARE, [[0, 0, 0], [3, 0.2, 0], [2, 1, 0], [0.5, 1.5, 0]]])
    faces = faces_of(
        np.concatenate([quads, [SQUARE[[0, 1, 2, 2]]]]) @ rotation(np.random.default_rng(0))
    )
    table = make_table(faces, patches_of(faces, [[1, 1], [1, 1], [1, 0]]))
    st = np.random.default_rng(1).uniform(0, 0.5, (3, 2))
    (s, t), v = st.T[..., None], faces.vertices
    x = (
        (1 - s) * (1 - t) * v[:, 0]
        + s * (1 - t) * v[:, 1]
        + s * t * v[:, 2]
        + (1 - s) * t * v[:, 3]
    )
    x[2] = v[2, 0] + st[2, 0] * (v[2, 1] - v[2, 0]) + st[2, 1] * (v[2, 2] - v[2, 0])
    np.testing.assert_allclose(coordinates_at(table, np.arange(3), x), st, atol=1e-12)


def test_patches_reflect_the_mean_of_their_texels():
    """Four cells of a board of 2 x 2: inside the squares, half a texel at each edge is mixed."""
    texels = 32
    room = with_texture(lit_room(), 0, checkers(texels=texels))
    patches = patches_of(room.faces, [[2, 2]] * 6)
    terms = make_terms(room, patches, np.ones(len(patches), bool))
    floor = patches.face == 0
    # An edge's half texel runs from the square's value to the mean, 0.5: a mean of 1/4 the way.
    inner = 1 - 0.5 / texels  # share of a length with the square's own value, as seen in one axis
    own = 0.3 * inner**2
    expected = 0.5 + own * np.array([-1, 1, 1, -1])
    np.testing.assert_allclose(terms.reflectance[floor][:, 0], expected, atol=1e-7)
    np.testing.assert_allclose(terms.absorptance[floor], 1 - terms.reflectance[floor])
    assert (terms.reflectance[~floor] == 0.5).all()


def test_means_do_not_depend_on_where_and_how_large_a_face_is():
    texture = Texture(np.random.default_rng(2).random((9, 13, 3)))
    uv = np.array([[0.1, 0.2], [1.9, 0.4], [1.7, 1.4], [-0.1, 1.2]])  # affine on a parallelogram
    expected = None
    for seed, size in ((0, 1e-6), (1, 1.0), (2, 1e6)):
        rng = np.random.default_rng(seed)
        quad = size * (SQUARE * [2, 1, 0] + [5, 5, 5]) @ rotation(rng)
        faces = Faces.from_polygons([quad], 0, 0, uv=[uv])
        patches = patches_of(faces, [[3, 2]])
        table = make_table(faces, patches)
        args = faces, table, patches.face, patches.vertices
        found = texturing.mean_over(texture, *args)
        expected = found if expected is None else expected
        np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_means_over_unevenly_laid_textures_converge_with_the_parts(monkeypatch):
    """Over a trapezoid x = u (1 + y), v = y, the mean of v^2 is int y^2 (1 + y) dy / 1.5."""
    trapezoid = np.array([[0, 0, 0], [1, 0, 0], [2, 1, 0], [0, 1, 0]], float)
    squares = np.linspace(1, 0, 2001)[:, None, None] ** 2 * np.ones(3)
    faces = Faces.from_polygons([trapezoid], 0, 0, uv=[CORNERS])
    patches = patches_of(faces, [[1, 1]])
    args = faces, make_table(faces, patches), patches.face, patches.vertices
    errors = []
    for parts in (2, 4, 8):
        monkeypatch.setattr(texturing, "PARTS", parts)
        mean = texturing.mean_over(Texture(squares, repeat=False), *args)
        errors.append(abs(mean[0, 0] - 7 / 18))
    rates = np.log2(errors[:-1]) - np.log2(errors[1:])
    assert (rates > 1.8).all() and errors[-1] < 2e-3


def test_a_textured_room_conserves_its_power_and_probes():
    room = with_texture(lit_room(), 0, checkers())
    solution = radiosity.solve(room, 0.05)
    assert radiosity.solve(lit_room(), 0.05).balance.defect < 1e-4
    assert solution.balance.defect < 1e-4  # far factors' rule; plain rooms have it too
    E, error = solution.irradiance([[0.25, 0.25, 0], [0.75, 0.25, 0]], [[0, 0, 1]] * 2)
    assert (error < 0.1 * E).all()
    dark = radiosity.solve(with_texture(lit_room(), 0, checkers(high=0.2)), 0.05)
    grey = radiosity.solve(lit_room([0.2, 0.5, 0.5, 0.5, 0.5, 0.5]), 0.05)
    np.testing.assert_allclose(dark.radiosity, grey.radiosity, rtol=1e-6)  # float32 texels


def test_light_straight_from_lamps_leaves_the_texels_it_meets():
    """What rays meet on the fine cells of a floor lit evenly left and right."""
    halves = Texture(np.repeat([[[0.2] * 3] * 32 + [[0.8] * 3] * 32], 64, axis=0))
    solution = radiosity.solve(with_texture(lit_room(), 0, halves), mesh="1", order=0)
    direct = solution.surroundings.field.direct[0, :16, 0].reshape(4, 4)  # of the floor, by rows
    edge = 0.3 * (0.5 / 64) / 0.25 / 2  # half a texel that goes over to the mean
    np.testing.assert_allclose(direct[:, 0] / direct[:, 3], (0.2 + edge) / (0.8 - edge), rtol=0.02)
    np.testing.assert_allclose(direct[:, 1] / direct[:, 2], (0.2 + edge) / (0.8 - edge), rtol=0.02)


def test_a_finer_mesh_finds_the_same_light():
    """A pattern too fine for the patches lights the room as its mean does."""
    fine = radiosity.solve(with_texture(lit_room(), 0, checkers(32, 2)), mesh="4", order=0)
    mean = radiosity.solve(lit_room(), mesh="4", order=0)
    up = [[0.3, 0.4, 0.9]], [[0, 0, -1]]
    assert fine.irradiance(*up)[0] == pytest.approx(mean.irradiance(*up)[0], rel=1e-6)


def test_textures_of_backs_and_of_triangles():
    texture = checkers(1, 4, low=0.3, high=0.3)
    sheet = np.array([[[0.2, 0.2, 0.5], [0.8, 0.2, 0.5], [0.2, 0.8, 0.5], [0.2, 0.8, 0.5]]])
    both = scene(np.concatenate([box((0, 0, 0), (1, 1, 1)), sheet]), 0.5, [0, 10] + [0] * 5)
    room = with_texture(both, 6, texture, CORNERS[[0, 1, 3, 3]])
    solution = radiosity.solve(room, mesh="3")
    mine = (solution.patches.face == 6) & solution.live
    assert len(np.unique(solution.patches.front[mine])) == 2
    np.testing.assert_allclose(solution.reflectance[mine], 0.3, rtol=1e-6)
    one_sided = replace(room.materials[6], two_sided=False)
    room = replace(room, materials=(*room.materials[:6], one_sided))
    solution = radiosity.solve(room, mesh="3")
    back = (solution.patches.face == 6) & ~solution.patches.front
    assert (solution.reflectance[back] == 0).all()


def test_many_faces_are_clustered_whatever_their_texels():
    n = 8
    cells = np.stack(np.meshgrid(np.arange(n), np.arange(n)), axis=-1).reshape(-1, 1, 2) / n
    floor = np.concatenate([cells + CORNERS / n, np.zeros((n * n, 4, 1))], axis=2)
    polygons = np.concatenate([floor, box((0, 0, 0), (1, 1, 1))[1:]])
    plain = scene(polygons, 0.5, [0] * n * n + [10, 0, 0, 0, 0])
    faces = replace(plain.faces, material=np.r_[np.zeros(n * n, int), np.arange(1, 6)])
    few = replace(plain, faces=faces, materials=(plain.materials[0], *plain.materials[n * n :]))
    texture = Texture(np.random.default_rng(3).random((32, 32, 3)) * 0.8)
    uv = np.full((len(faces), 4, 2), np.nan)
    uv[: n * n] = floor[..., :2]
    mean = texture.mean
    textured = replace(few.materials[0], texture=texture, diffuse=mean, absorptance=1 - mean)
    room = replace(few, faces=replace(faces, uv=uv), materials=(textured, *few.materials[1:]))
    from radiosity.solve.clustered import solve_clusters
    from radiosity.solve.plan import make_plan
    from radiosity.solve.reach import find_reach

    plan = make_plan(room, 0.05, "4", order=0)
    reach = find_reach(room, plan.division, 0)
    recipe = replace(plan.recipe, counted=1 << 20)
    level = solve_clusters(room, reach, recipe, 60)
    assert level.labels.max() < 80
    solution = radiosity.solve(room, mesh="2", order=0)
    area = reach.patches.area
    B = area @ level.on_patches(level.coefficients) / area.sum()
    other = solution.patches.area @ solution.radiosity / solution.patches.area.sum()
    assert B == pytest.approx(other, rel=0.01)  # noise of 2^20 rays


def test_scenes_made_in_code_are_checked():
    bright = checkers(high=1.2)
    room = with_texture(lit_room(), 0, bright)
    with pytest.raises(SceneError, match=r"m0.texture\[3\] = 1.2 must be in \[0, 1\]"):
        radiosity.solve(room)
    bare = replace(room, faces=replace(room.faces, uv=None))
    with pytest.raises(SceneError, match="1 of its 1 faces have no texture coordinates, face 0"):
        radiosity.solve(bare)


def test_a_scene_without_textures_imports_nothing_for_them(tmp_path):
    code = (
        "import sys, radiosity\n"
        f"scene = radiosity.load({str(SCENES / 'cornell_box.toml')!r})\n"
        "solution = radiosity.solve(scene, 0.5)\n"
        "solution.irradiance([[100, 0, 100]], [[0, 1, 0]])\n"
        "radiosity.render(solution, size=(4, 4), samples=8)\n"
        "print([m for m in sys.modules if m.startswith('radiosity')\n"
        " and m.rpartition('.')[2] in ('texture', 'textures', 'texturing', 'bump', 'corners',\n"
        " 'detail')])\n"
    )
    root = SCENES.parent
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=root)
    assert ran.stdout == "[]\n", ran.stderr
