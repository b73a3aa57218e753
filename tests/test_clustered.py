"""Scenes of many small faces: furnaces, the same answer as linear elements, honest errors."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import box, scene, uv_sphere

from radiosity.analytic import box_form_factors, furnace
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Material, Scene
from radiosity.solve import plan
from radiosity.solve.adapt import refined_clusters
from radiosity.solve.clustered import solve_clusters, solved
from radiosity.solve.limits import DIMS, box_of_one_lamp, face_means, room_of
from radiosity.solve.plan import make_plan, plan_of_clusters
from radiosity.solve.reach import find_reach
from radiosity.solve.solve import solve
from radiosity.solve.system import lights_of, make_terms
from radiosity.transport.operator import FormFactors

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LAMP = np.array([[1, 1, 2.49], [1, 2, 2.49], [2, 2, 2.49], [2, 1, 2.49]], float)


def material(name, rho, radiance=0.0):
    return Material(name, np.full(3, rho), np.full(3, 1 - rho), np.full(3, radiance))


def room_with_balls(n, walls=0.7):
    """A room with a lamp and three balls of about 4 n^2 faces each."""
    ball = uv_sphere(n)[:, ::-1]
    ball[np.all(ball[:, 0] == ball[:, 1], axis=1)] = np.roll(
        ball[np.all(ball[:, 0] == ball[:, 1], axis=1)], -1, axis=1
    )
    balls = [0.4 * ball + c for c in ([1, 2, 0.6], [2.7, 1.4, 0.8], [2, 2.2, 1.4])]
    parts = [box((0, 0, 0), (4, 3, 2.5)), LAMP[None], *balls]
    kind = np.repeat([0, 1, 2, 2, 2], [len(p) for p in parts])
    faces = Faces.from_polygons(np.concatenate(parts), kind, 0, merge=False)
    materials = material("wall", walls), material("lamp", 0.0, 10.0), material("ball", 0.5)
    return Scene("balls", faces, materials, ("all",))


@pytest.fixture(scope="module")
def balls():
    return room_with_balls(12)


def test_many_faces_are_gathered_into_clusters(balls):
    planned = make_plan(balls, 0.1)
    assert len(balls.faces) > 800 and planned.clusters > 0
    assert make_plan(scene(box((0, 0, 0), (1, 1, 1))), 0.1).clusters == 0
    solution = solve(balls, 0.1)
    assert len(solution.level.factors.area) <= planned.clusters < len(solution.level.rows)
    assert solution.closed and solution.balance.defect < 0.02


def test_names_of_materials_do_not_matter(balls):
    """As many materials as faces, alike: the same clusters, where walls were once one each."""
    own = tuple(balls.materials[k] for k in balls.faces.material)
    faces = replace(balls.faces, material=np.arange(len(balls.faces)))
    one, many = (solve(s, 0.2) for s in (balls, replace(balls, faces=faces, materials=own)))
    assert np.array_equal(one.radiosity, many.radiosity)
    assert one.estimate.reached == many.estimate.reached


def test_what_rays_cannot_tell_takes_more_rays_not_more_clusters(balls):
    planned = make_plan(balls, 0.04)
    few = replace(planned, recipe=replace(planned.recipe, rays=32))
    level, _, estimate = refined_clusters(balls, few, None)
    assert estimate.reached <= 0.04 and level.recipe.rays > 32
    assert level.recipe.counted == few.recipe.counted


def room_near_one(left, emitted):
    """A box that absorbs so little; its clusters, and the mean of values on each of its faces."""
    room = room_of(box((0, 0, 0), DIMS), 1.0 - left, emitted, left)
    made = plan_of_clusters(room, 0.1)
    reach = find_reach(room, made.division, 0)
    patches = reach.patches

    def means(values):
        return np.bincount(patches.face, patches.area * values[:, 0]) / room.faces.areas()

    return room, reach, made, means


@pytest.mark.parametrize(("left", "bound"), [(1e-6, 1e-6), (1e-9, 1e-3)])
def test_a_furnace_of_clusters_near_reflectance_1(left, bound):
    room, reach, made, _ = room_near_one(left, 1.0)
    level = solve_clusters(room, reach, made.recipe, made.clusters)
    assert level.coefficients * left == pytest.approx(1.0, rel=bound)


@pytest.mark.parametrize(("left", "bound"), [(1e-6, 1e-6), (1e-9, 1e-3)])
def test_clusters_keep_means_and_differences_near_reflectance_1(left, bound):
    """A box with one lamp, a cluster a face of exact factors, against exact fractions."""
    room, reach, made, means = room_near_one(left, [0, 1, 0, 0, 0, 0])
    patches, areas = reach.patches, room.faces.areas()
    f = np.array(box_form_factors(DIMS))
    factors = FormFactors((areas[:, None] * f + areas * f.T) / 2, areas)
    straight = np.repeat(f[:, 1], np.bincount(patches.face))[:, None] * np.ones(3)
    terms, lights = make_terms(room, patches, reach.live), lights_of(room)
    level = solved(room, reach, made.recipe, terms, lights, patches.face, factors, straight,
                       0 * straight)  # fmt: skip
    exact = box_of_one_lamp(left)
    found = means(level.coefficients)
    assert found == pytest.approx([float(x) for x in exact], rel=bound)
    apart = [float(x - exact[0]) for x in exact[1:]]
    assert found[1:] - found[0] == pytest.approx(apart, rel=bound)


@pytest.mark.parametrize("left", [1e-6, 1e-9])
def test_counted_factors_keep_the_mean_near_reflectance_1(left):
    """Power in over power absorbed; faces differ as they do with linear elements."""
    room, reach, made, means = room_near_one(left, [0, 1, 0, 0, 0, 0])
    level = solve_clusters(room, reach, made.recipe, made.clusters)
    areas, found = room.faces.areas(), means(level.coefficients)
    assert found @ areas * left == pytest.approx(areas[1], rel=1e-6)
    exact = face_means(room, 0.01)
    apart = (found - found[0]) - (exact - exact[0])
    assert np.abs(apart).max() < 2e-3 * np.ptp(exact)  # the noise of 1.5e6 rays


@pytest.mark.parametrize("rho", [0.5, 0.99])
def test_a_furnace_of_many_faces(rho):
    """Rows are closed, so B = M/(1 - rho) exactly, also after a hundred reflections."""
    sphere = uv_sphere(24)
    faces = Faces.from_polygons(sphere, 0, 0, merge=False)
    furnaces = Scene("furnace", faces, (material("wall", rho, 1 / np.pi),), ("all",))
    solution = solve(furnaces, 0.1)
    assert solution.plan.clusters > 0
    assert solution.radiosity == pytest.approx(furnace(1.0, rho), rel=1e-6)  # the solver's


def points_of(solution, count):
    rng = np.random.default_rng(0)
    area = solution.patches.area * solution.live
    rows = rng.choice(len(area), count, p=area / area.sum())
    corners = solution.patches.vertices[rows][:, :3]
    weights = rng.dirichlet([1, 1, 1], count)
    return np.einsum("kv,kvc->kc", weights, corners), solution.patches.normal[rows]


def test_the_answer_is_that_of_linear_elements(monkeypatch):
    """Balls of few faces, for which both can be had; errors as asked and as estimated."""
    few = room_with_balls(6)
    exact = solve(few, 0.02, order=1)
    points, normals = points_of(exact, 300)
    e, rest = exact.irradiance(points, normals)
    monkeypatch.setattr(plan, "MOST_FACES", 10)
    clustered = solve(few, 0.05)
    assert clustered.plan.clusters > 0 and exact.plan.clusters == 0
    found, error = clustered.irradiance(points, normals)
    y, truth = found @ LUMINANCE, e @ LUMINANCE
    off = np.abs(y - truth) / np.maximum(truth, 0.1 * exact.estimate.scale)
    assert np.percentile(off, 95) < 0.05
    assert np.mean(np.abs(y - truth) <= (error + rest) @ LUMINANCE) >= 0.95
    assert clustered.estimate.reached < 0.05


def test_patch_values_are_those_at_their_middles(balls):
    solution = solve(balls, 0.1)
    area = solution.patches.area[solution.live]
    rows = np.flatnonzero(solution.live)[np.argsort(area)[-200:]]
    found, _ = solution.irradiance(solution.patches.centroid[rows], solution.patches.normal[rows])
    y, mean = found @ LUMINANCE, solution.irradiance_on[rows] @ LUMINANCE
    assert np.median(np.abs(mean / y - 1)) < 0.03
    assert np.percentile(np.abs(mean / y - 1), 90) < 0.15


def test_sky_light_enters_between_clusters():
    """Walls without a lid under a sky, with balls in it, in equilibrium: B = E = pi L."""
    few = room_with_balls(12, 0.3)
    keep = np.ones(len(few.faces), bool)
    keep[[1, 6]] = False
    emitted = [material("wall", 0.3, 0.7), material("lamp", 0.0), material("ball", 0.5, 0.5)]
    faces = Faces(few.faces.vertices[keep], few.faces.material[keep], few.faces.group[keep])
    open_room = Scene("open", faces, tuple(emitted), ("all",), ambient=np.ones(3))
    solution = solve(open_room, 0.1)
    assert solution.plan.clusters > 0 and not solution.closed
    inside = (
        solution.live
        & solution.patches.front
        & np.all(
            (solution.patches.centroid > 0.01) & (solution.patches.centroid < [3.99, 2.99, 2.4]),
            axis=1,
        )
    )
    assert solution.radiosity[inside] / np.pi == pytest.approx(1.0, abs=0.05)
    assert np.average(
        solution.radiosity[inside, 0], weights=solution.patches.area[inside]
    ) == pytest.approx(np.pi, rel=5e-3)
