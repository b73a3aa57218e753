"""Facet distributions and shadowing against Blinn's coefficients, norms and projected areas."""

import numpy as np
import pytest

from radiosity.analytic import load_cases
from radiosity.light.facets import Beckmann, CosinePower, Gaussian, TrowbridgeReitz
from radiosity.light.shadowing import smith, v_groove

CASES = {c["id"]: c for c in load_cases("reflection")}
KINDS = [CosinePower, Gaussian, TrowbridgeReitz, Beckmann]
X, W = np.polynomial.legendre.leggauss(2000)
ALPHA, ARC = (X + 1) * np.pi / 4, W * np.pi / 4


def parameter(facets):
    return float(next(iter(vars(facets).values())))


def several(kind):
    values = [0.0, 1.0, 20.0, 1e4] if kind is CosinePower else [0.01, 0.1, 0.3, 0.7, 1.0]
    return [kind(v) for v in values]


@pytest.mark.parametrize("name", ["blinn_D_beta15", "blinn_D_beta5"])
def test_blinn_s_three_distributions(name):
    case = CASES[name]
    g, value = case["geometry"], case["value"]
    cosine = np.cos(np.radians(g["alpha_deg"]))
    for k, kind in enumerate(KINDS[:3]):
        facets = kind.of_half_angle(g["beta_deg"])
        c = 1 / parameter(facets) if kind is Gaussian else parameter(facets)
        assert c == pytest.approx(value["c"][k], rel=1e-12)
        # 1e-11: alpha from its cosine, times the slope of ln D
        assert facets.relative(cosine) == pytest.approx(value[f"D{k + 1}"], rel=1e-11)


def test_norms_are_the_tabulated_ones():
    expected = CASES["blinn_D_norm_beta15"]["value"]
    found = [kind.of_half_angle(15).norm() for kind in KINDS[:3]]
    assert found == pytest.approx(expected, rel=1e-13)


def test_beckmann_is_the_tabulated_one():
    case = CASES["beckmann_m0.3"]
    facets = Beckmann(case["geometry"]["m"])
    cosine = np.cos(np.radians(case["geometry"]["alpha_deg"]))
    assert facets.relative(cosine) / facets.norm() == pytest.approx(case["value"][0], rel=1e-12)


@pytest.mark.parametrize("facets", [f for kind in KINDS for f in several(kind)], ids=str)
def test_facets_cover_their_surface_once(facets):
    """Normalised, int D cos dw = 1; what is chosen by sampling is a density too."""
    cosine, ring = np.cos(ALPHA), 2 * np.pi * np.sin(ALPHA) * ARC
    assert (facets.relative(cosine) * cosine * ring).sum() == pytest.approx(facets.norm(), rel=1e-9)
    assert (facets.chosen(cosine) * ring).sum() == pytest.approx(1, rel=1e-9)


@pytest.mark.parametrize("facets", [f for kind in KINDS for f in several(kind)], ids=str)
def test_shares_and_cosines_are_inverse_and_belong_to_the_density(facets):
    share = np.linspace(0.001, 0.999, 41)
    cosine = facets.cosine_of(share)
    assert facets.share_of(cosine) == pytest.approx(share, abs=1e-9)
    lean = np.arccos(cosine[20])
    alpha = (X + 1) * lean / 2
    below = (facets.chosen(np.cos(alpha)) * 2 * np.pi * np.sin(alpha) * W * lean / 2).sum()
    assert below == pytest.approx(share[20], rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("degrees", [1, 15, 40])
def test_half_angles(kind, degrees):
    facets = kind.of_half_angle(degrees)
    assert facets.relative(1.0) == pytest.approx(1, abs=1e-15)
    assert facets.relative(np.cos(np.radians(degrees))) == pytest.approx(0.5, rel=1e-10)


@pytest.mark.parametrize("kind", KINDS)
def test_backs_are_the_projected_area_of_what_looks_away(kind):
    """A plain sum over the hemisphere of D max(0, -V.H)."""
    facets = kind(12.0) if kind is CosinePower else kind(0.4)
    phi = (np.arange(2000) + 0.5) * np.pi / 2000
    density = facets.relative(np.cos(ALPHA)) / facets.norm() * np.sin(ALPHA) * ARC
    for degrees in (20, 60, 80, 90):
        s, c = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
        facing = c * np.cos(ALPHA)[:, None] + s * np.sin(ALPHA)[:, None] * np.cos(phi)
        seen = 2 * np.pi / 2000 * np.maximum(-facing, 0).sum(axis=1) @ density
        assert facets.hidden(c) == pytest.approx(seen, rel=1e-4, abs=1e-9)  # kinks
    table = facets.hidden(np.linspace(0, 1, 1000))
    alone = np.array([facets.hidden(c) for c in np.linspace(0, 1, 1000)[::50]])
    assert table[::50] == pytest.approx(alone, abs=1e-9)


def random_facets(seed):
    rng = np.random.default_rng(seed)
    light, view = rng.normal(size=(2, 400, 3))
    light[:, 2], view[:, 2] = np.abs(light[:, 2]), np.abs(view[:, 2])
    light, view = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (light, view))
    half = light + view
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    return light[:, 2], view[:, 2], (view * half).sum(axis=1), half[:, 2]


def test_the_groove_is_blinn_s_minimum():
    light, view, across, half = random_facets(5)
    g = v_groove(None, light, view, across, half) * light * view
    least = np.minimum(2 * half * view / across, 2 * half * light / across)
    assert g == pytest.approx(np.minimum(1, least), rel=1e-12)
    assert (least < 1).sum() > 50


@pytest.mark.parametrize("facets", [k(0.3) for k in KINDS[1:]], ids=str)
def test_smith_hides_more_when_light_and_eye_differ_and_nothing_from_above(facets):
    light, view, across, half = random_facets(6)
    g = smith(facets, light, view, across, half) * light * view
    alone = [c / (c + facets.hidden(c)) for c in (light, view)]
    assert np.all(g <= np.minimum(*alone) + 1e-12) and np.all(g >= alone[0] * alone[1] - 1e-12)
    above = smith(facets, np.ones(1), np.ones(1), np.ones(1), np.ones(1))
    assert above == pytest.approx(1, abs=1e-9)


def test_impossible_half_angles_are_refused():
    with pytest.raises(ValueError, match="half_angle = 0 degrees must lie between 0 and 90"):
        Gaussian.of_half_angle(0)
    with pytest.raises(ValueError, match="at most 46.07 for Beckmann facets"):
        Beckmann.of_half_angle(47)
    assert parameter(Beckmann.of_half_angle(46.07)) < np.sqrt(0.5)
