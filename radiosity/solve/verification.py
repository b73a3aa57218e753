"""The built-in closed-form cases, computed by the same code that solves scenes: all suites."""

from collections.abc import Iterator

import numpy as np

from radiosity.analytic import box_radiosity, load_cases, sphere_cavity
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Scene
from radiosity.solve.cases import BOX, Check, elements, extremes, obstructed, polygons, timed
from radiosity.solve.cie import cie171
from radiosity.solve.colours import colours
from radiosity.solve.curved import curved, sphere
from radiosity.solve.limits import limits, room_of
from radiosity.solve.reflecting import reflection
from radiosity.solve.solve import solve

ROOM, COARSE = 1e-6, 2e-3  # bounds of relative errors: of the solver's tolerance, of a coarse mesh


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


def rooms() -> Iterator[Check]:
    """Whole solutions: boxes of one element a face, furnaces, a spherical cavity."""
    for case in load_cases("radiosity") + load_cases("extremes"):
        g = case["geometry"]
        if g["type"] == "box6":
            expected = box_radiosity(g["dims"], g["reflectance"], g["emission"])
            scene = room_of(g["faces"].values(), g["reflectance"], g["emission"])
            yield timed("rooms", case["id"], expected, ROOM, lambda s=scene: _face_radiosity(s))
        elif g["type"] == "furnace":
            scene = room_of(BOX, [g["rho"]] * 6, [g["emission"]] * 6)
            yield timed(
                "rooms", case["id"], case["value"], ROOM,
                lambda s=scene: solve(s, 0.1).radiosity[:, 0],
            )  # fmt: skip
    expected, _ = sphere_cavity([0.5, 0.5], [1.0, 0.0], [0.5, 0.5])
    yield timed("rooms", "sphere_cavity_hemi", expected, COARSE, _sphere)


SUITES = {
    "elements": elements, "polygons": polygons, "extremes": extremes, "obstructed": obstructed,
    "curved": curved, "rooms": rooms, "limits": limits, "cie171": cie171,
    "reflection": reflection, "colour": colours,
}  # fmt: skip


def _face_radiosity(scene) -> np.ndarray:
    return solve(scene, 0.02, mesh="1").radiosity[:, 0]


def _sphere() -> np.ndarray:
    """Return the mean radiosities of the lower and upper half of a tessellated sphere."""
    quads = sphere(1.0, 16, inward=True)
    half = (quads.mean(axis=1)[:, 2] > 0).astype(int)
    scene = room_of(BOX[:2], [0.5, 0.5], [1.0, 0.0])
    scene = Scene("sphere", Faces(quads, half, half), scene.materials, scene.groups)
    solution = solve(scene, 0.02, mesh="input")
    weight = np.stack([half == k for k in (0, 1)]) * solution.patches.area
    return weight @ solution.radiosity[:, 0] / weight.sum(axis=1)
