"""Tabulated cases of colour, and a room whose colours are products of spectra."""

from collections.abc import Iterator

import numpy as np

from radiosity.analytic import load_cases
from radiosity.light.colour import RGB_TO_XYZ, XYZ_TO_RGB, encode
from radiosity.light.palette import Cells
from radiosity.light.photometry import EFFICACY
from radiosity.light.spectrum import Spectrum, daylight, matching, nanometres, tristimulus
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Material, Scene
from radiosity.solve.cases import BOX, Check, timed
from radiosity.solve.solve import solve

# Bounds, relative except for encoded values, one of which is 0: of the digits that a case is given
# with, and of the solver's tolerance.
DIGITS = {14: 1e-13, 13: 1e-12, 9: 1e-9, 7: 1e-7, 6: 1e-6}
ROOM = 1e-6
EQUAL = Spectrum(np.array([400.0, 700.0]), np.ones(2))  # equal energy where the cases have values
LAMP = Spectrum(np.array([400.0, 500.0, 600.0, 700.0]), np.array([0.0, 8.0, 15.6, 18.4]))
WALL = Spectrum(np.array([400.0, 550.0, 700.0]), np.array([0.2, 0.7, 0.4]))


def colours() -> Iterator[Check]:
    """Matrices, curves, observers, white points, measured spectra; a furnace of spectra."""
    find = {
        "srgb_matrix": _matrices, "srgb_encode": _encoded, "cmf_sums": _sums,
        "white_points": _whites, "efficacy": _efficacy, "cornell": _surface,
        "cornell_light": _light,
    }  # fmt: skip
    for case in load_cases("colour"):
        compute = find[case["geometry"]["type"]]
        yield timed(
            "colour", case["id"], _numbers(case["value"]), DIGITS[case["digits"]],
            lambda g=case["geometry"], c=compute: _numbers(c(g)), compute is not _encoded,
        )  # fmt: skip
    truth = _emitted() / (1.0 - Cells(16).share(WALL))
    yield timed("colour", "spectral furnace", truth, ROOM, _furnace)


def _numbers(value) -> np.ndarray:
    """Return all numbers of a value in its order."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, (list, tuple)):
        return np.concatenate([_numbers(v) for v in value])
    return np.ravel(np.asarray(value, float))


def _matrices(g):
    return RGB_TO_XYZ, XYZ_TO_RGB


def _encoded(g):
    return encode(g["linear"])


def _sums(g):
    xyz = matching()
    return xyz[20:421:5].sum(axis=0), xyz[nanometres() == 555.0, 1], xyz[:, 1].sum()


def _whites(g):
    found = []
    for source in (np.ones_like(nanometres()), daylight()):
        xyz = tristimulus(source)
        found += [xyz / xyz[1], xyz[:2] / xyz.sum()]
    return found


def _efficacy(g):
    line = (nanometres() == 555.0) * 1.0
    return [EFFICACY * tristimulus(s)[1] for s in (np.ones_like(line), line)]


def _surface(g):
    rho = Spectrum(np.array(g["nm"]), np.array(g["reflectance"])).share()
    found = []
    for source in (EQUAL.light(), LAMP.light()):
        xyz = tristimulus(rho * source) / tristimulus(source)[1]
        found += [xyz, XYZ_TO_RGB @ xyz, xyz[1], _every_4_nm(rho * source) / _every_4_nm(source)[1]]
    return found


def _every_4_nm(values):
    """Return X, Y, Z by the trapezoidal rule on 400, 404 .. 700 nm, over 4 nm."""
    some = slice(40, 341, 4)
    weight = np.ones(76)
    weight[[0, -1]] = 0.5
    return (weight * values[some]) @ matching()[some]


def _light(g):
    xyz = tristimulus(LAMP.light())
    return xyz / xyz[1], xyz[:2] / xyz.sum(), xyz[1]


def _emitted():
    return np.pi * Cells(16).light(LAMP)


def _furnace() -> np.ndarray:
    """Return the radiosities (bands,) of a closed room that emits and reflects alike everywhere."""
    palette = Cells(16)
    rho = palette.share(WALL)
    material = Material("wall", rho, 1.0 - rho, palette.light(LAMP))
    index = np.zeros(len(BOX), int)
    scene = Scene("room", Faces(BOX, index, index), (material,), ("all",), bands=palette.bands)
    return solve(scene, 0.1).radiosity[0]
