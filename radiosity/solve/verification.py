"""The built-in closed-form cases, computed by the same code that solves scenes."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from radiosity.analytic import box_radiosity, load_cases, sphere_cavity
from radiosity.mesh.faces import Faces
from radiosity.mesh.triangulate import triangulate
from radiosity.scene.model import Material, Scene
from radiosity.solve.solve import solve
from radiosity.transport.polygon import GAUSS, exchange_area, point_factor

PAIR, EXACT, ROOM, COARSE = 1e-4, 1e-12, 1e-6, 2e-3  # bounds of relative errors: see the suites


@dataclass(frozen=True)
class Check:
    """One case: what was expected and found, their relative error, its bound, and the time."""

    suite: str
    case: str
    expected: float
    found: float
    error: float
    bound: float
    seconds: float


def run_suites(names: list[str]) -> Iterator[Check]:
    """Return the cases of the named suites, each computed when it is asked for.

    Raises
    ------
    ValueError
        An unknown suite.
    """
    for name in names:
        if name not in SUITES:
            raise ValueError(f"suite = {name!r} must be one of {', '.join(SUITES)}")
    return (check for name in names for check in SUITES[name]())


def _timed(suite, case, expected, bound, compute: Callable[[], np.ndarray]) -> Check:
    begun = time.perf_counter()
    found = np.atleast_1d(compute())
    seconds = time.perf_counter() - begun
    wanted = np.broadcast_to(np.asarray(expected, float), found.shape)
    error = np.abs(found - wanted) / np.abs(wanted)
    k = int(np.argmax(error))
    return Check(suite, case, wanted[k], found[k], float(error[k]), bound, seconds)


def elements() -> Iterator[Check]:
    """Point to polygon: Lambert's sum is exact to rounding."""
    for case in load_cases("vf_element_polygon"):
        g = case["geometry"]
        point, normal = np.array(g["point"], float), np.array(g["normal"], float)
        polygon = np.array(g["A2"], float)[[0, 1, 2, -1]]
        facing = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
        if facing @ (polygon[0] - point) > 0:  # two cases wind the polygon the other way
            polygon = polygon[[2, 1, 0, 0]] if len(g["A2"]) == 3 else polygon[::-1].copy()
        yield _timed(
            "elements", case["id"], case["value"], EXACT,
            lambda p=point, n=normal, q=polygon: point_factor(*p, *(n / np.linalg.norm(n)), q),
        )  # fmt: skip


def polygons() -> Iterator[Check]:
    """Polygon to polygon, unoccluded: bound by the slender strips that share an edge."""
    for case in load_cases("vf_polygon_pairs"):
        g = case["geometry"]
        yield _timed(
            "polygons", case["id"], case["value"], PAIR,
            lambda a=g["A1"], b=g["A2"]: _pair_factor(np.array(a, float), np.array(b, float)),
        )  # fmt: skip


def rooms() -> Iterator[Check]:
    """Whole solutions: boxes of one element a face, furnaces, a spherical cavity."""
    for case in load_cases("radiosity"):
        g = case["geometry"]
        if g["type"] == "box6":
            expected = box_radiosity(g["dims"], g["reflectance"], g["emission"])
            scene = _room(g["faces"].values(), g["reflectance"], g["emission"])
            yield _timed(
                "rooms", case["id"], expected, ROOM, lambda s=scene: _face_radiosity(s)
            )
        elif g["type"] == "furnace":
            faces = list(load_cases("radiosity")[1]["geometry"]["faces"].values())
            scene = _room(faces, [g["rho"]] * 6, [g["emission"]] * 6)
            yield _timed(
                "rooms", case["id"], case["value"], ROOM,
                lambda s=scene: solve(s, 0.1).radiosity[:, 0],
            )  # fmt: skip
    expected, _ = sphere_cavity([0.5, 0.5], [1.0, 0.0], [0.5, 0.5])
    yield _timed("rooms", "sphere_cavity_hemi", expected, COARSE, _sphere)


SUITES = {"elements": elements, "polygons": polygons, "rooms": rooms}


def _pair_factor(one, two) -> float:
    """Return F from one planar polygon to another, both of any shape."""
    pieces = [Faces(q, np.zeros(len(q), int), np.zeros(len(q), int)) for q in
              (triangulate(one), triangulate(two))]  # fmt: skip
    total = 0.0
    for p in _parts(pieces[0]):
        for q in _parts(pieces[1]):
            total += exchange_area(*p, *q, GAUSS)
    return total / pieces[0].areas().sum()


def _parts(faces):
    """Return polygon, normal, centre and radius of each face."""
    centre = faces.vertices.mean(axis=1)
    radius = np.linalg.norm(faces.vertices - centre[:, None], axis=2).max(axis=1)
    vertices = np.ascontiguousarray(faces.vertices)
    return list(zip(vertices, faces.normals(), centre, radius, strict=True))


def _room(polygons, reflectance, exitance) -> Scene:
    """Return a scene with one material a face."""
    quads = np.array([np.array(p, float)[[0, 1, 2, -1]] for p in polygons])
    index = np.arange(len(quads))
    materials = tuple(
        Material(str(k), np.full(3, r), np.full(3, 1 - r), np.full(3, m / np.pi))
        for k, (r, m) in enumerate(zip(reflectance, exitance, strict=True))
    )
    return Scene("room", Faces(quads, index, index), materials, tuple(str(k) for k in index))


def _face_radiosity(scene) -> np.ndarray:
    return solve(scene, 0.02, mesh="1").radiosity[:, 0]


def _sphere() -> np.ndarray:
    """Return the mean radiosities of the lower and upper half of a tessellated sphere."""
    bands, around = 16, 32
    polar = np.linspace(np.pi, 0, bands + 1)[:, None]
    azimuth = np.linspace(0, 2 * np.pi, around, endpoint=False)[None, :]
    x = np.stack(
        np.broadcast_arrays(
            np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)
        ), axis=-1,
    )  # fmt: skip
    x[0], x[-1] = [0, 0, -1], [0, 0, 1]
    right = np.roll(x, -1, axis=1)
    quads = np.stack([x[:-1], x[1:], right[1:], right[:-1]], axis=2)  # fronts inward
    quads[-1] = quads[-1][:, [3, 0, 1, 1]]
    quads[0] = quads[0][:, [0, 1, 2, 2]]
    quads = quads.reshape(-1, 4, 3)
    half = (quads.mean(axis=1)[:, 2] > 0).astype(int)
    scene = _room([[[0, 0, 0]] * 4] * 2, [0.5, 0.5], [1.0, 0.0])
    scene = Scene("sphere", Faces(quads, half, half), scene.materials, scene.groups)
    solution = solve(scene, 0.02, mesh="input")
    area = solution.patches.area
    return np.array([area[half == k] @ solution.radiosity[half == k, 0] / area[half == k].sum()
                     for k in (0, 1)])  # fmt: skip
