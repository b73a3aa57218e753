"""Test cases of CIE 171:2006, compared with: whole scenes of luminaires, windows and black rooms.

The values are closed forms; where a published table differs from them it is known to be wrong.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from radiosity.analytic import load_cases
from radiosity.light import refraction
from radiosity.light.sources import Flood, Point
from radiosity.scene.model import Scene
from radiosity.solve.cases import BOX, Check, timed
from radiosity.solve.limits import room_of
from radiosity.solve.solve import solve

ASKED = 0.005  # accuracy
MEAN, POINT = 0.005, 0.01  # bounds of area averages, and at points
EXACT = 1e-12
GRAZED = 1e-5  # absolute, of a point that looks along an edge to the very end of what shines
UP, DOWN, ALONG = np.array([0, 0, 1.0]), np.array([0, 0, -1.0]), np.array([0, 1.0, 0])
ROOM = BOX * [4, 4, 3]


def cie171() -> Iterator[Check]:
    """Points and areas that shine, flux, a sky opening, an obstruction, reflections in a room."""
    kinds = {
        "cie52": _point_source, "isotropic": _isotropic, "cie53": _area_source, "cie54": _flux,
        "glass_poly": _fitted_glass, "slab": _glass, "cie56": _ground, "cie57": _obstructed,
        "cie58": _reflected, "sky_roof": _sky_opening,
    }  # fmt: skip
    for case in load_cases("cie171"):
        yield from kinds[case["geometry"]["type"]](case)


def _illuminance(scene: Scene, points, normal) -> np.ndarray:
    """Return what is asked for at points (k, 3) of one normal: grey W/m2, or lx by lm for W."""
    points = np.array(points, float)
    normals = np.tile(normal, (len(points), 1))
    solution = solve(scene, ASKED, goal=(points, normals))
    return solution.irradiance(points, normals)[0][:, 0]


def _black(polygons, exitance=0.0) -> Scene:
    return room_of(polygons, 0.0, exitance)


def _lit_by(scene, light) -> Scene:
    return replace(scene, lights=(light,))


def _point_source(case):
    """Check a Lambertian point source over a floor."""
    g, names = case["geometry"], list(case["value"])
    light = Flood(np.array(g["source"], float), np.full(3, float(g["I0"])), axis=DOWN)
    points = [[*g["points"][k], 0.0] for k in names]
    scene = _lit_by(_black([BOX[0] * [6, 6, 1] - [3, 3, 0]]), light)
    expected = [case["value"][k] for k in names]
    yield timed("cie171", case["id"], expected, POINT, lambda: _illuminance(scene, points, UP))


def _isotropic(case):
    g = case["geometry"]
    light = Point(np.array([0, 0, g["h"]], float), np.full(3, g["Phi"] / (4 * np.pi)))
    scene = _lit_by(_black([BOX[0] * [12, 12, 1] - [6, 6, 0]]), light)
    points = [[r, 0, 0] for r in g["r"]]
    yield timed("cie171", case["id"], case["value"], POINT, lambda: _illuminance(scene, points, UP))


def _area_source(case):
    g = case["geometry"]
    scene = _black([g["source"], *ROOM], [g["exitance"], *[0] * 6])
    yield from _at_points(case, scene, ("wall", g["points_wall_normal_plus_y"], ALONG),
                          ("floor", g["points_floor"], UP))  # fmt: skip


def _at_points(case, scene, *sets, share=1.0):
    """Check the values of named points on surfaces, times ``share`` as the case counts them."""
    for name, points, normal in sets:
        expected, places = [case["value"][k] for k in points], list(points.values())
        yield timed(
            "cie171", f"{case['id']} {name}", expected, POINT,
            lambda p=places, n=normal: share * _illuminance(scene, p, n),
        )  # fmt: skip


def _flux(case):
    """Check what an isotropic source sends to each face of a room, and in all."""
    g = case["geometry"]
    light = Point(np.array(g["source"]), np.full(3, g["Phi"] / (4 * np.pi)))
    scene = _lit_by(_black(BOX * g["dims"]), light)

    def found():
        solution = solve(scene, ASKED)
        flux = solution.irradiance_on[:, 0] * solution.patches.area
        flux = np.bincount(solution.patches.face, flux)
        return np.append(flux, flux.sum())

    expected = [case["value"][k] for k in ("floor", "ceiling", "x0", "x1", "y0", "y1")]
    yield timed("cie171", f"{case['id']} and sum", [*expected, g["Phi"]], MEAN, found)


def _glass(case):
    """Check a clear pane, with and without reflections between its sides, at angles."""
    g, (every, single) = case["geometry"], case["value"]
    c, n = np.cos(np.radians(g["angles"])), g["n"]
    yield timed("cie171", f"{case['id']} all bounces", every, EXACT,
                lambda: refraction.pane_transmittance(c, n))  # fmt: skip
    yield timed("cie171", f"{case['id']} one pass", single, EXACT,
                lambda: refraction.single_pass_transmittance(c, n))  # fmt: skip


def _fitted_glass(case):
    """Print a fit to measured glass beside a pane of index 1.52, which it need not agree with."""
    g = case["geometry"]
    c = np.cos(np.radians(g["angles"][:-1]))
    fit = refraction.fitted_pane_transmittance(c, g["coeff"])
    for degrees, cosine, value in zip(g["angles"], c, fit, strict=False):
        yield timed("cie171", f"{case['id']} {degrees} deg, printed only", value, np.inf,
                    lambda x=cosine: refraction.pane_transmittance(x, 1.52))  # fmt: skip


def _ground(case):
    """Check a diffuse ground seen from a wall and from above, per cent of its exitance."""
    g = case["geometry"]
    scene = _black([g["source"], *ROOM[1:]], [1.0, *[0] * 5])
    yield from _at_points(
        case, scene, ("wall", g["points_wall_normal_plus_y"], ALONG),
        ("ceiling", g["points_ceiling_normal_minus_z"], DOWN), share=100.0,
    )  # fmt: skip


def _obstructed(case):
    """Check a wall seen past a black box that stands on the floor, per cent of its exitance."""
    g = case["geometry"]
    room = [ROOM[k] for k in (0, 1, 2, 3, 4)]
    polygons = [g["S2"][::-1], *room, *g["blockers"]]
    scene = _black(polygons, [1.0, *[0] * (len(polygons) - 1)])
    x = g["params"]["xp"]
    wall = {k: [x, 0, z] for k, z in g["wall_z"].items()}
    floor = {k: [x, y, 0] for k, y in g["floor_y"].items() if case["value"][k] > 0}
    dark = [[x, y, 0] for k, y in g["floor_y"].items() if case["value"][k] == 0]
    yield from _at_points(case, scene, ("wall", wall, ALONG), ("floor", floor, UP), share=100.0)
    yield timed("cie171", f"{case['id']} behind it", 0.0, GRAZED,
                lambda: _illuminance(scene, dark, UP), False)  # fmt: skip


def _reflected(case):
    """Check the mean of what is reflected in a cube of grey walls, for each reflectance."""
    g = case["geometry"]
    light = Point(np.full(3, 2.0), np.full(3, g["Phi"] / (4 * np.pi)))
    for rho, expected in zip(g["rho"], case["value"], strict=True):
        scene = _lit_by(room_of(BOX * 4.0, rho, 0.0), light)

        def found(scene=scene):
            solution = solve(scene, ASKED)
            e, direct = solution.irradiance_on[:, 0], solution.level.lamplight[:, 0]
            area = solution.patches.area[solution.live]
            return np.average(e[solution.live] - direct[: len(area)], weights=area)

        yield timed("cie171", f"{case['id']} rho = {rho:g}", expected, MEAN, found, rho > 0)


def _sky_opening(case):
    """Check a floor under a hole in the roof, below a uniform sky; per cent of what is outside."""
    g = case["geometry"]
    low, high = g["opening"][:2]
    x, X, h = 0.0, 4.0, g["h"]
    strips = [
        [x, X, x, low], [x, X, high, X], [x, low, low, high], [high, X, low, high],
    ]  # fmt: skip
    roof = [[[a, c, h], [a, d, h], [b, d, h], [b, c, h]] for a, b, c, d in strips]
    walls = [ROOM[k] for k in (0, 2, 3, 4, 5)]
    scene = replace(_black(walls + roof), ambient=np.full(3, 1 / np.pi))
    points = {y: [g["x"], float(y), 0.0] for y in case["value"]}
    yield from _at_points(case, scene, ("floor", points, UP), share=100.0)
