"""What a scene requires: decisions as written by hand, and nothing skipped that matters."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, scene, uv_sphere

from radiosity.light.bump import Bump
from radiosity.light.phong import Phong
from radiosity.light.texture import Texture
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Scene
from radiosity.solve.plan import MOST_LINEAR, make_plan
from radiosity.solve.requirements import _ahead, _rounds_of_clusters, foresee
from radiosity.solve.solve import solve
from radiosity.transport.visibility import Visibility

ROOM = box((0, 0, 0), (4, 3, 2.5))
OPEN = ROOM[[0, 2, 3, 4, 5]]
STOOD = block((1, 1, 0), (2, 2, 1), False)
SHEET = [SQUARE + [1.5, 1.0, 1.2]]
LAMP = np.array([0, 1.0, 0, 0, 0, 0])
RED = np.array([[0.8, 0.2, 0.2]] + [[0.5] * 3] * 5)


def glossy():
    made = scene(ROOM, 0.5, LAMP)
    first = made.materials[0]
    shiny = type(first)(first.name, first.diffuse * 0.5, 1 - first.diffuse * 0.5, first.emission,
                        Phong(np.full(3, 0.3), 20.0))  # fmt: skip
    return Scene("glossy", made.faces, (shiny, *made.materials[1:]), made.groups)


def detailed():
    ball = uv_sphere(16)
    ball = np.concatenate([ROOM, 0.4 * ball[:, ::-1] + [2, 1.5, 1]])
    kind = np.minimum(np.arange(len(ball)), 6)
    made = scene(np.concatenate([ROOM, SHEET]), 0.5, [*LAMP, 0])
    return Scene("ball", Faces.from_polygons(ball, kind, 0, merge=False), made.materials, ("all",))


# name: scene, and bands, visibility, backs, environment, highlights, area lights, abstract lights,
# elements, solver
TABLE = {
    "grey box": (lambda: scene(ROOM, 0.5, LAMP),
                 "1|nothing|nothing|nothing|nothing|1|nothing|linear|gauss-seidel"),
    "red box": (lambda: scene(ROOM, RED, LAMP),
                "3|nothing|nothing|nothing|nothing|1|nothing|linear|gauss-seidel"),
    "open box": (lambda: scene(OPEN, 0.5, [1.0, 0, 0, 0, 0]),
                 "1|nothing|nothing|black|nothing|1|nothing|linear|gauss-seidel"),
    "box under a sky": (lambda: scene(OPEN, 0.5, ambient=np.ones(3)),
                        "1|nothing|of 5 patches|emits|nothing|nothing|nothing|linear|gauss-seidel"),
    "block in a box": (lambda: scene(np.concatenate([ROOM, STOOD]), 0.5, [*LAMP, *[0] * 5]),
                       "1|exact shadows|nothing|nothing|nothing|1|nothing|linear|gauss-seidel"),
    "sheet in a box": (lambda: scene(np.concatenate([ROOM, SHEET]), 0.5, [*LAMP, 0]),
                   "1|exact shadows|of 1 patches|nothing|nothing|1|nothing|linear|gauss-seidel"),
    "glossy box": (glossy, "1|nothing|nothing|nothing|lobes|1|nothing|linear|gmres"),
    "white box": (lambda: scene(ROOM, 0.999, LAMP),
                  "1|nothing|nothing|nothing|nothing|1|nothing|linear|direct"),
    "ball in a box": (detailed,
                      "1|rays|nothing|measured|nothing|1|nothing|600 clusters|gauss-seidel"),
}  # fmt: skip


def models(forecast):
    found = [r.model for r in forecast.requirements]
    return "|".join("of 1 patches" if m.startswith("of ") and m != "of 5 patches" else m
                    for m in found)  # fmt: skip


@pytest.mark.parametrize("name", TABLE)
def test_the_plan_is_what_the_table_says(name):
    make, expected = TABLE[name]
    made = make()
    forecast = foresee(made, make_plan(made, 0.1))
    found, expected = models(forecast).split("|"), [*expected.split("|"), "nothing"]  # no detail
    found[2], expected[2] = (x.split()[0] for x in (found[2], expected[2]))  # how many depends
    assert found == expected
    assert all(r.reason for r in forecast.requirements)
    assert forecast.patches > 0 and forecast.seconds > 0 and forecast.memory > 1e8


def test_the_plan_tells_of_textures_bumps_and_smooth_normals():
    made = scene(ROOM, 0.5, LAMP)
    corners = np.repeat([[[0, 0], [1, 0], [1, 1], [0, 1.0]]], 6, axis=0)
    coloured = Texture([[[0.2, 0.3, 0.4], [0.4, 0.3, 0.2]]])
    wood = replace(made.materials[0], texture=coloured, diffuse=coloured.mean)
    tiles = replace(made.materials[1], bump=Bump(Texture(np.ones((2, 2, 1))), 0.1))
    faces = replace(made.faces, uv=corners, corner_normals=made.faces.vertices - 9.0)
    made = replace(made, faces=faces, materials=(wood, tiles, *made.materials[2:]))
    found = foresee(made, make_plan(made, 0.1)).requirements
    assert (found[0].model, found[-1].model) == ("3", "in pictures")
    assert found[-1].reason == (
        "textures of m0, on patches their means; bumps of m1; faces that stand for a curved surface"
    )


@pytest.mark.parametrize("name", [n for n in TABLE if n != "ball in a box"])
def test_what_is_skipped_changes_less_than_the_accuracy(name):
    made = TABLE[name][0]()
    spared, forced = solve(made, 0.05), solve(made, 0.05, force=True)
    points, normals = (
        np.array([[0.9, 0.7, 0.0], [3.9, 2.5, 0.0], [0, 1, 1.0]]),
        np.array([[0, 0, 1.0], [0, 0, 1], [1, 0, 0]]),
    )
    one, other = (s.irradiance(points, normals)[0] for s in (spared, forced))
    assert one == pytest.approx(other, rel=0.05, abs=0.05 * spared.estimate.scale)
    # far less: only rays that are not needed and tolerances differ
    assert one == pytest.approx(other, rel=2e-3, abs=1e-3 * spared.estimate.scale)


@pytest.mark.parametrize("order", [0, 1])
def test_a_convex_room_casts_no_rays(order, monkeypatch):
    for name in ("first_hits", "blocked", "first_hits_of"):
        monkeypatch.setattr(Visibility, name, None)
    for polygons, lamp in ((ROOM, LAMP), (OPEN, LAMP[[1, 0, 0, 0, 0]])):
        solution = solve(scene(polygons, 0.5, lamp), 0.1, mesh="3", order=order)
        e, error = solution.irradiance([[1, 1, 0]], [[0, 0, 1]])
        assert 0 < e[0, 0] < 1 and 0 < error[0, 0] < e[0, 0]
    assert solve(scene(ROOM, 0.5, LAMP), 0.1).balance.defect < 1e-2


def test_grey_scenes_solve_one_band(monkeypatch):
    from radiosity.solve import methods

    seen, original = [], methods.SOLVERS["gauss-seidel"]

    def counted(system, *rest):
        seen.append(system.source.shape[1])
        return original(system, *rest)

    monkeypatch.setitem(methods.SOLVERS, "gauss-seidel", counted)
    coloured = LAMP[:, None] * [3.0, 2.0, 1.0]
    one = solve(scene(ROOM, 0.5, coloured), 0.1, mesh="2")
    assert seen == [1]
    all_three = solve(scene(ROOM, 0.5, coloured), 0.1, mesh="2", force=True)
    assert seen == [1, 3]
    assert one.radiosity == pytest.approx(all_three.radiosity, rel=1e-6)
    solve(scene(ROOM, RED, coloured), 0.1, mesh="2")
    assert seen == [1, 3, 2]  # green and blue reflect alike; their lights differ by a factor


def test_the_forecast_grows_with_the_accuracy():
    made = TABLE["block in a box"][0]()
    costs = [foresee(made, make_plan(made, a)) for a in (0.1, 0.003, 0.001)]
    patches, memory = np.array([[f.patches, f.memory] for f in costs]).T
    assert patches[1] > 2 * patches[0] and np.all(np.diff(patches) >= 0)
    assert memory[1] > memory[0] and np.all(np.diff(memory) >= 0)
    assert costs[2].seconds > 2 * costs[0].seconds


def test_rounds_ahead_are_as_likely_as_the_accuracy_is_far():
    patches, chance = _ahead(0.011, 100, 0.01, 5)
    assert patches[0] == 100 and chance[0] == 1.0 and 0.0 < chance[1] < 0.2
    patches, chance = _ahead(0.5, 100, 0.001, 5)
    assert len(chance) == 4 and np.all(chance > 0.9)  # a fifth would have hardly more patches
    assert np.all(np.diff(patches) > 0) and 2500 < patches[-1] <= MOST_LINEAR


def rounds_of(mesh, kernel):
    estimate = SimpleNamespace(mesh=mesh, kernel=kernel)
    return tuple(x.tolist() for x in _rounds_of_clusters(make_plan(detailed(), 0.1), estimate))


def test_clusters_double_while_the_error_is_too_large():
    """The trial is between a quarter as many clusters; they start as 600, and 6000 are the most."""
    assert rounds_of(0.18, 0.0) == ([1], [1])
    assert rounds_of(0.6, 0.0) == ([1, 2, 4], [1, 1, 1])
    assert rounds_of(20.0, 0.0) == ([1, 2, 4, 8], [1, 1, 1, 1])  # 16 were too many


def test_rays_that_look_around_quadruple_while_their_noise_is_too_large():
    assert rounds_of(0.1, 0.09) == ([1], [1, 4])
    assert rounds_of(0.3, 0.2) == ([1, 2], [1, 4, 4, 16])


def test_predicted_patches_are_about_those_that_are_solved():
    """The rest follows from them: memory as their square, time as their power PAIRS."""
    made = TABLE["block in a box"][0]()
    for accuracy in (0.1, 0.02, 0.003):
        forecast = foresee(made, make_plan(made, accuracy))
        assert len(solve(made, accuracy).level.rows) == pytest.approx(forecast.patches, rel=0.5)


def test_a_scene_without_light_has_a_forecast():
    dark = scene(ROOM, 0.5)
    found = foresee(dark, make_plan(dark, 0.05))
    assert found.patches == 0
    assert "no light that could leave" in [r.reason for r in found.requirements][3]


def test_sheets_are_solved_by_what_knows_them():
    made = scene(np.concatenate([ROOM, SHEET]), 0.5, [*LAMP, 0])
    last = replace(made.materials[-1], translucent=np.full(3, 0.3))
    made = replace(made, materials=(*made.materials[:-1], last))
    found = {r.name: r for r in foresee(made, make_plan(made, 0.1)).requirements}
    assert found["solver"].model == "gmres" and "sheets" in found["solver"].reason
    assert found["backs"].model != "nothing"
    assert solve(made, 0.1).solver == "gmres"


def test_sheets_that_keep_nothing_are_solved_directly_as_planned():
    made = scene(np.concatenate([ROOM, SHEET]), 0.5, [*LAMP, 0])
    last = replace(made.materials[-1], translucent=np.full(3, 0.5))
    made = replace(made, materials=(*made.materials[:-1], last))
    found = {r.name: r for r in foresee(made, make_plan(made, 0.1)).requirements}
    assert found["solver"].model == solve(made, 0.1).solver == "direct"
