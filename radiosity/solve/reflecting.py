"""Tabulated cases of reflection: Fresnel, facets, Torrance-Sparrow, albedos of lobes."""

from collections.abc import Iterator

import numpy as np

from radiosity.analytic import load_cases
from radiosity.light import fresnel
from radiosity.light.blinn import blinn_albedo
from radiosity.light.facets import Beckmann, CosinePower, Gaussian, TrowbridgeReitz
from radiosity.light.frames import polar
from radiosity.light.phong import phong_albedo
from radiosity.light.shadowing import v_groove
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.solve.cases import Check, timed

KINDS = CosinePower, Gaussian, TrowbridgeReitz  # Blinn's D1, D2, D3
EXACT, PEAK = 1e-12, 1e-6  # closed forms to rounding; peaks as well as they are tabulated


def reflection() -> Iterator[Check]:
    """Reflection at a point: every tabulated value, to its digits."""
    for case in load_cases("reflection"):
        yield from SHAPES[case["geometry"]["type"]](case, case["geometry"])


def _check(case, what, expected, compute, bound=EXACT):
    return timed("reflection", f"{case['id']} {what}".strip(), expected, bound, compute)


def _cosines(degrees):
    return np.maximum(np.cos(np.radians(np.asarray(degrees, float))), 0.0)


def _dielectric(case, g):
    expected = np.array([case["value"][str(a)] for a in g["angles"]])
    yield _check(case, "", expected, lambda: _polarised(g["angles"], g["n"]))


def _conductor(case, g):
    for nm, n, k in g["nk"]:
        expected = np.array([case["value"][f"{nm}nm_{a}"] for a in g["angles"]])
        index = n + 1j * k
        yield _check(case, f"{nm} nm", expected, lambda i=index: _polarised(g["angles"], i))


def _polarised(angles, index):
    c = _cosines(angles)
    return np.stack([*fresnel.polarised_reflectance(c, index), fresnel.reflectance(c, index)], 1)


def _inside(case, g):
    c = _cosines(g["angles"])
    yield _check(case, "", case["value"]["R"], lambda: fresnel.reflectance(c, g["n_rel"]))
    yield _check(
        case, "angle", case["value"]["critical_deg"], lambda: np.degrees(np.arcsin(g["n_rel"]))
    )


def _distributions(case, g):
    cosine = np.cos(np.radians(g["alpha_deg"]))
    for k, kind in enumerate(KINDS):
        facets = kind.of_half_angle(g["beta_deg"])
        yield _check(case, f"c{k + 1}", case["value"]["c"][k], lambda f=facets: _coefficient(f))
        expected = case["value"][f"D{k + 1}"]
        yield _check(
            case, f"D{k + 1}", expected, lambda f=facets: f.relative(cosine), EXACT
        )  # alpha comes from its cosine


def _coefficient(facets):
    (value,) = vars(facets).values()
    return 1.0 / value if isinstance(facets, Gaussian) else value


def _norms(case, g):
    facets = [kind.of_half_angle(g["beta_deg"]) for kind in KINDS]
    yield _check(case, "", case["value"], lambda: np.array([f.norm() for f in facets]))


def _beckmann(case, g):
    facets, cosine = Beckmann(g["m"]), np.cos(np.radians(g["alpha_deg"]))
    yield _check(case, "", case["value"][0], lambda: facets.relative(cosine) / facets.norm())
    yield _check(case, "integral", case["value"][1], lambda: _covered(facets))


def _covered(facets):
    """Return int D cos(alpha) dw over the hemisphere by Gauss's rule in alpha."""
    x, w = np.polynomial.legendre.leggauss(400)
    alpha = np.pi / 4.0 * (x + 1.0)
    seen = 2.0 * np.pi * np.sin(alpha) * np.cos(alpha) * facets.relative(np.cos(alpha))
    return np.pi / 4.0 * np.sum(w * seen) / facets.norm()


def _rows(case, g):
    for row in case["value"]:
        name = f"{row['theta_L']}/{row['theta_E']}"
        light = polar(np.cos(np.radians(row["theta_L"])), 0.0)
        view = polar(np.cos(np.radians(row["theta_E"])), np.radians(row["phi"]))
        expected = [row[f"s_D{k}"] for k in (1, 2, 3)]
        models = [_groove(kind, row["beta"], row["n"]) for kind in KINDS]
        yield _check(
            case, name, expected,
            lambda m=models, a=light, b=view: np.concatenate([one.shape(a, b) for one in m]),
            EXACT,
        )  # fmt: skip


def _groove(kind, beta, n=None):
    index = None if n is None else np.array([float(n)])
    return TorranceSparrow(kind.of_half_angle(beta), v_groove, index, np.ones(1))


def _peak(case, g):
    """Find the peak of s in the plane of incidence; at grazing where it rises until there."""
    angle, height = case["value"]
    model = _groove(Gaussian, g["beta_deg"])
    light = polar(np.cos(np.radians(g["theta_L"])), 0.0)

    def found():
        from scipy.optimize import minimize_scalar

        return minimize_scalar(
            lambda t: -model.shape(light, polar(np.cos(np.radians(t)), np.pi))[0],
            bounds=(g["theta_L"], 90.0 - 1e-9), method="bounded", options={"xatol": 1e-9},
        )  # fmt: skip

    yield _check(case, "degrees", angle, lambda: found().x, PEAK)
    yield _check(case, "height", height, lambda: -found().fun, PEAK)


def _phong(case, g):
    n, c = g["n"], _cosines(g["angles"])
    yield _check(
        case, "", case["value"], lambda: phong_albedo(n, c) * 2.0 * np.pi / (n + 2.0),
        10.0 ** (1 - case["digits"]),
    )  # fmt: skip


def _blinn(case, g):
    n, c = g["n"], _cosines(g["angles"])
    bound = 10.0 ** (1 - case["digits"])
    yield _check(case, "", case["value"], lambda: blinn_albedo(n, c), bound)


SHAPES = {
    "fresnel_dielectric": _dielectric, "fresnel_conductor": _conductor, "fresnel_tir": _inside,
    "blinn_D": _distributions, "blinn_D_norm": _norms,
    "beckmann": _beckmann, "blinn_ts": _rows, "ts_peak": _peak, "phong_albedo": _phong,
    "blinnphong_albedo": _blinn,
}  # fmt: skip
