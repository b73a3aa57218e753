"""Deliberate faults: a wrong cosine, pi, area, visibility or reflectance must not pass unseen.

``suite`` compares whole solutions with closed forms; each fault is put into one place of the
program, and the suite has to exceed its tolerance. (Faults inside compiled kernels are caught by
the tests of those kernels.)
"""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, faces_of, mean_of, meshed, scene

import radiosity
from radiosity.analytic import box_radiosity, load_cases, point_to_parallel_rectangle
from radiosity.mesh.patches import Patches
from radiosity.scene.model import Camera
from radiosity.solve.methods import NotConverged
from radiosity.solve.solve import solve
from radiosity.transport.closure import NotClosable
from radiosity.transport.irradiance import Lights
from radiosity.transport.operator import FormFactors, Openness

DIMS, RHO, LAMP = (4, 3, 2.5), [0.2, 0.7, 0.5, 0.3, 0.6, 0.4], [0, 1.0, 0, 0, 0, 0.3]
SCREEN = np.array([[0.25, 0.25, 0.75], [0.75, 0.25, 0.75], [0.75, 0.75, 0.75], [0.25, 0.75, 0.75]])
SCREENED = 0.11562060213241498  # Walton & Shapiro, verification/vf_obstructed.json


def box_of_six():
    solution = solve(scene(box((0, 0, 0), DIMS), RHO, LAMP), 0.01, mesh="1")
    return np.abs(solution.radiosity[:6, 0] / box_radiosity(DIMS, RHO, LAMP) - 1).max()


def furnace_of_unequal_patches():
    room = scene(box((0, 0, 0), DIMS), 0.8, 1.0)
    solution = solve(room, 0.01, mesh="2")
    points = [[1, 1, 0], [4, 2, 1], [2, 1, 1]]
    gathered, _ = solution.irradiance(points, [[0, 0, 1], [-1, 0, 0], [1, 1, 1]])
    return max(np.abs(solution.radiosity / 5 - 1).max(), np.abs(gathered / 5 - 1).max())


def balance():
    return solve(scene(box((0, 0, 0), DIMS), RHO, LAMP), 0.01, mesh="2").balance.defect


def squares_with_a_screen():
    polygons = np.array([SQUARE, SQUARE[::-1] + [0, 0, 1], SCREEN])
    solution = solve(scene(polygons, 0.0, [1.0, 0, 0]), 0.01, mesh="6")
    e = mean_of(solution.irradiance_on[:, 0], solution.patches, 1)
    return abs(e / SCREENED - 1)


def raw_rows():
    """Rows of a room and of one that a wall divides in part, before they are closed."""
    wall = [[[2, 0, 0], [2, 1.5, 0], [2, 1.5, 2.5], [2, 0, 2.5]]]
    whole = box((0, 0, 0), DIMS)
    worst = 0.0
    for polygons in (whole, np.concatenate([whole, wall, np.array(wall)[:, ::-1]])):
        _, _, patches = meshed(faces_of(polygons), 4)
        corners = patches.vertices[~patches.covered].reshape(-1, 3)
        factors = radiosity.form_factors((corners, np.arange(len(corners)).reshape(-1, 4)), 1e-4)
        worst = max(worst, np.abs(factors.raw_closure).max())
    return worst


def a_lamp_over_points():
    polygons = np.array([2 * SQUARE, SQUARE[::-1] + [0, 0, 1]])
    solution = solve(scene(polygons, 0.0, [0, 1.0]), 0.05, mesh="1")
    found, _ = solution.irradiance([[0, 0, 0], [0.5, 0.5, 0]], [[0, 0, 1]] * 2)
    exact = [point_to_parallel_rectangle(1, 1, 1), 4 * point_to_parallel_rectangle(0.5, 0.5, 1)]
    return np.abs(found[:, 0] / exact - 1).max()


def linear_elements_of_a_cube():
    cases = load_cases("radiosity")
    case = next(c for c in cases if c["id"].startswith("cube_full_nonuniform_0.2"))
    g = case["geometry"]
    room = scene(list(g["faces"].values()), g["reflectance"], g["emission"])
    solution = solve(room, 0.01, mesh="6", order=1)
    found = [mean_of(solution.radiosity[:, 0], solution.patches, f) for f in range(6)]
    return np.abs(np.array(found) - case["value"]).max()


def picture_of_a_furnace():
    camera = Camera("eye", np.array([1, 1, 1.0]), np.array([3, 2, 1.5]), np.eye(3)[2], 60.0, (8, 8))
    room = scene(box((0, 0, 0), DIMS), 0.8, 1.0, cameras={"eye": camera})
    return np.abs(radiosity.render(solve(room, 0.1), samples=8).pixels * np.pi / 5 - 1).max()


SUITE = {
    box_of_six: 1e-6,  # factors to 1e-8, the solver to 1e-7
    furnace_of_unequal_patches: 1e-6,  # rows are closed: the solver to 1e-7
    balance: 1e-6,  # the same
    squares_with_a_screen: 1e-2,  # the accuracy asked
    raw_rows: 1e-4,  # the accuracy asked
    a_lamp_over_points: 1e-12,  # Lambert's sum is exact
    linear_elements_of_a_cube: 5e-4,  # reached 2e-4 on 6 x 6 patches a face
    picture_of_a_furnace: 1e-4,  # sight lines end in single precision
}


def caught():
    """Names of the checks whose error exceeds their tolerance, or that end without an answer."""
    return {check.__name__ for check, limit in SUITE.items() if not error_of(check) <= limit}


def error_of(check):
    try:
        return check()
    except (NotConverged, NotClosable):
        return np.nan


def fault_in_reflectance(patch):
    from radiosity.solve import system

    original = system.reflectance_of
    patch(system, "reflectance_of", lambda material: 0.95 * original(material))


def fault_in_pi_of_emission(patch):
    from radiosity.solve import level

    original = level.make_terms

    def without_pi(*args):
        terms = original(*args)
        return replace(terms, emission=terms.emission / np.pi)

    patch(level, "make_terms", without_pi)


def fault_in_pi_of_lamps(patch):
    from radiosity.solve import level

    original = level.lights_of

    def without_pi(scene):
        lights = original(scene)
        return Lights(lights.polygons, lights.normals, lights.exitance / np.pi)

    patch(level, "lights_of", without_pi)


def fault_in_area(patch):
    """Rows divided by the mean area: wrong only where patches differ."""
    from radiosity.transport import factors

    def averaged(exchange, area, *rest, **more):
        return FormFactors(exchange, 0 * area + area.mean(), *rest, **more)

    patch(factors, "FormFactors", averaged)


def fault_in_visibility(patch):
    """Blockers forgotten."""
    from radiosity.transport import visibility

    original = visibility.make_blockers

    def forgotten(*arrays, **options):
        return original(*(array[:0] for array in arrays), **options)

    patch(visibility, "make_blockers", forgotten)


def fault_in_convexity(patch):
    """Every face taken for one on the hull of the scene, which cannot block."""
    from radiosity.transport import blockers

    patch(blockers, "on_the_hull", lambda corners, *rest: np.ones(len(corners), bool))


def fault_in_openness(patch):
    """An open scene taken for a closed one, so that its rows are filled up to 1."""
    from radiosity.transport import factors

    patch(factors, "measure_openness", lambda patches, *rest: Openness.closed(len(patches)))


def fault_in_cosine(patch):
    """One cosine of every pair of patches left out."""
    from radiosity.transport import factors

    original = factors.fill_rows

    def without(first, stop, live, geometry, *rest):
        original(first, stop, live, geometry, *rest)
        exchange, c = rest[-2], geometry.centroid
        for i in range(first, stop):
            d = c - c[i]
            cosine = d @ geometry.normal[i] / np.maximum(np.linalg.norm(d, axis=1), 1e-300)
            exchange[i] /= np.where(exchange[i] > 0, np.maximum(cosine, 0.05), 1.0)

    patch(factors, "fill_rows", without)


def fault_in_cosine_at_points(patch):
    from radiosity.transport import irradiance

    original = irradiance._point_factors

    def without(points, normals, polygons, factors):
        original(points, normals, polygons, factors)
        d = polygons.mean(axis=1)[None] - points[:, None]
        cosine = np.einsum("plc,pc->pl", d, normals) / np.linalg.norm(d, axis=2)
        factors /= np.maximum(cosine, 0.05)

    patch(irradiance, "_point_factors", without)


def fault_in_factors_at_points(patch):
    from radiosity.transport import arrival

    original = arrival.weigh

    def heavier(*args):
        original(*args)
        args[-2][:] *= 1.001  # the weights

    patch(arrival, "weigh", heavier)


def fault_in_moments(patch):
    """Slopes of the senders forgotten."""
    from radiosity.transport import arrival

    original = arrival.weigh

    def without(*args):
        original(*args)
        args[-2][:, args[-1].shape[1] :] = 0.0

    patch(arrival, "weigh", without)


def fault_in_normals(patch):
    """Patches that look the wrong way."""
    from radiosity.solve import reach

    original = reach.make_patches

    def flipped(*args):
        made = original(*args)
        return Patches(**{**vars(made), "normal": -made.normal})

    patch(reach, "make_patches", flipped)


def fault_in_quadrature(patch):
    """Gauss weights that do not add up to 1."""
    from radiosity.transport import factors

    original = factors.make_geometry

    def heavier(*args):
        made = original(*args)
        return made._replace(weights=1.001 * made.weights)

    patch(factors, "make_geometry", heavier)


FAULTS = {
    fault_in_reflectance: {"box_of_six", "furnace_of_unequal_patches"},
    fault_in_pi_of_emission: {"box_of_six", "furnace_of_unequal_patches", "squares_with_a_screen"},
    fault_in_pi_of_lamps: {"picture_of_a_furnace"},
    fault_in_area: {"box_of_six"},
    fault_in_visibility: {"squares_with_a_screen"},
    fault_in_convexity: {"squares_with_a_screen"},
    fault_in_openness: {"squares_with_a_screen"},
    fault_in_cosine: {"box_of_six", "squares_with_a_screen", "raw_rows"},
    fault_in_cosine_at_points: {"picture_of_a_furnace"},
    fault_in_factors_at_points: {"a_lamp_over_points"},
    fault_in_moments: {"linear_elements_of_a_cube"},
    fault_in_normals: {"box_of_six", "furnace_of_unequal_patches"},
    fault_in_quadrature: {"raw_rows"},
}


def test_without_faults_the_suite_is_content():
    assert caught() == set()


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: f.__name__)
def test_faults_are_caught(fault, monkeypatch):
    fault(monkeypatch.setattr)
    found = caught()
    assert found >= FAULTS[fault]
