"""Fresnel, Snell, panes and metals against tabulated values, a second form and conserved power."""

import numpy as np
import pytest

from radiosity.analytic import load_cases
from radiosity.light import fresnel, refraction
from radiosity.light.metals import band_weights, metal_bands, metal_index, metal_names

CASES = {c["id"]: c for c in load_cases("reflection") + load_cases("cie171")}
COSINES = np.concatenate([[0.0, 1e-12, 1e-6, 1e-3], np.linspace(0.01, 1, 100)])
EXACT = 1e-13  # rounding of a few operations


def cosines(degrees):
    return np.maximum(np.cos(np.radians(np.asarray(degrees, float))), 0.0)


def test_dielectrics_reflect_what_is_tabulated():
    case = CASES["fresnel_dielectric_n1.5"]
    g = case["geometry"]
    expected = np.array([case["value"][str(a)] for a in g["angles"]])
    r_s, r_p = fresnel.polarised_reflectance(cosines(g["angles"]), g["n"])
    assert r_s == pytest.approx(expected[:, 0], rel=EXACT)
    assert r_p == pytest.approx(expected[:, 1], rel=10 * EXACT)  # small near Brewster's angle
    assert fresnel.reflectance(cosines(g["angles"]), g["n"]) == pytest.approx(
        expected[:, 2], rel=EXACT
    )
    _, at_brewster = fresnel.polarised_reflectance(cosines(g["brewster_deg"]), g["n"])
    assert at_brewster < 1e-30


def test_light_from_inside_is_totally_reflected_beyond_the_critical_angle():
    case = CASES["fresnel_internal_tir"]
    g, value = case["geometry"], case["value"]
    found = fresnel.reflectance(cosines(g["angles"]), g["n_rel"])
    assert found == pytest.approx(value["R"], rel=1e-12)  # steep near the critical angle
    mean = sum(fresnel.polarised_reflectance(cosines(g["angles"]), g["n_rel"])) / 2
    assert mean == pytest.approx(value["R"], rel=1e-12)
    just = value["critical_deg"] + np.array([-1e-7, 1e-7])
    below, above = fresnel.reflectance(cosines(just), g["n_rel"])
    assert below < 1 and above == 1


@pytest.mark.parametrize("name", ["fresnel_conductor_gold", "fresnel_conductor_aluminium"])
def test_metals_reflect_what_is_tabulated(name):
    case = CASES[name]
    angles = case["geometry"]["angles"]
    for nm, n, k in case["geometry"]["nk"]:
        expected = np.array([case["value"][f"{nm}nm_{a}"] for a in angles])
        r_s, r_p = fresnel.polarised_reflectance(cosines(angles), n + 1j * k)
        found = np.stack([r_s, r_p, fresnel.reflectance(cosines(angles), n + 1j * k)], axis=1)
        assert found == pytest.approx(expected, rel=EXACT)


@pytest.mark.parametrize("index", [1.0, 1.0 + 1e-9, 1.33, 1.52, 2.4, 100.0, 1 / 1.5, 0.05])
def test_the_two_forms_agree_and_nothing_is_lost(index):
    with np.errstate(all="raise"):
        f = fresnel.reflectance(COSINES, index)
        mean = sum(fresnel.polarised_reflectance(COSINES, index)) / 2
        passed = fresnel.transmittance(COSINES, index)
    assert np.all((f >= 0) & (f <= 1)) and f == pytest.approx(mean, abs=1e-12)
    assert f + passed == pytest.approx(np.ones_like(f), abs=1e-12)


def test_a_medium_that_is_no_other_reflects_nothing():
    assert not fresnel.reflectance(COSINES, 1.0).any()
    assert np.all(fresnel.transmittance(COSINES, 1.0) == 1)


@pytest.mark.parametrize("index", [1.5, 2.0, 0.16 + 3.5j])
def test_reflectance_does_not_depend_on_which_way_light_goes(index):
    """From inside at the refracted angle it is the same (Stokes); metals have no way back."""
    c = COSINES[4:]
    f0 = fresnel.normal_reflectance(index)
    assert fresnel.reflectance(1.0, index) == pytest.approx(f0, rel=EXACT)
    if np.iscomplexobj(index):
        return
    assert fresnel.index_of_reflectance(f0) == pytest.approx(index, rel=EXACT)
    inner = np.sqrt(1 - (1 - c**2) / index**2)
    back = fresnel.reflectance(inner, 1 / index)
    assert back == pytest.approx(fresnel.reflectance(c, index), abs=1e-11)  # cancels at grazing


def test_indices_and_angles_broadcast():
    index = np.array([1.3, 1.5, 1.8])
    together = fresnel.reflectance(COSINES[:, None], index)
    assert together.shape == (len(COSINES), 3)
    for k in range(3):
        assert np.array_equal(together[:, k], fresnel.reflectance(COSINES, index[k]))
    fine = np.linspace(0, 1, 200001)
    expected = 2 * np.trapezoid(fresnel.reflectance(fine[:, None], index) * fine[:, None], fine,
                                axis=0)  # fmt: skip
    assert fresnel.mean_reflectance(index) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("bend", [1.0, 1 / 1.5, 1.5, 1 / 2.4])
def test_refraction_follows_snell_in_the_plane_and_back(bend):
    rng = np.random.default_rng(3)
    n, d = rng.normal(size=(2, 500, 3))
    n, d = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (n, d))
    d *= np.sign((n * d).sum(axis=1, keepdims=True))
    t = refraction.refracted(d, n, bend)
    passes = ~np.isnan(t[:, 0])
    sine = np.linalg.norm(np.cross(n, d), axis=1)
    assert np.array_equal(passes, bend * sine <= 1) and (bend <= 1 or not passes.all())
    n, d, t, sine = (v[passes] for v in (n, d, t, sine))
    assert np.linalg.norm(t, axis=1) == pytest.approx(np.ones(len(t)), abs=EXACT)
    assert np.all((n * t).sum(axis=1) <= 0)
    assert np.linalg.norm(np.cross(n, t), axis=1) == pytest.approx(bend * sine, abs=1e-12)
    assert (np.cross(n, d) * t).sum(axis=1) == pytest.approx(np.zeros(len(t)), abs=1e-12)
    assert (np.cross(n, d) * np.cross(n, t)).sum(axis=1).max() <= 0  # on the other side
    inside = bend * sine < 0.999
    back = refraction.refracted(t[inside], -n[inside], 1 / bend)
    assert back == pytest.approx(d[inside], abs=1e-11)


def test_radiance_over_the_square_of_the_index_is_invariant_and_power_goes_on():
    """Directions over a cone are followed through a surface; the power within them is summed."""
    bend = 1 / 1.5
    theta = np.radians(np.linspace(40, 41, 2001))
    d = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    t = refraction.refracted(d, np.array([0, 0, 1.0]), bend)
    inner = np.pi - np.arccos(t[:, 2])
    share = fresnel.transmittance(d[:, 2], 1.5)
    radiance = refraction.radiance_across(3.0, share, bend)
    assert radiance / (share * 3.0) == pytest.approx(np.full(2001, 1.5**2), rel=1e-15)
    arriving = np.trapezoid(3.0 * share * np.cos(theta) * np.sin(theta), theta)
    leaving = np.trapezoid(radiance * np.cos(inner) * np.sin(inner), inner)
    assert leaving == pytest.approx(arriving, rel=1e-6)  # trapezoids, (1 degree/2000)^2
    back = refraction.radiance_across(radiance, 1.0, 1 / bend)
    assert back == pytest.approx(3.0 * share, rel=1e-15)


def test_mirror_direction():
    n, d = np.array([0, 0, 1.0]), np.array([0.6, 0, 0.8])
    assert refraction.mirrored(d, n) == pytest.approx([-0.6, 0, 0.8])


def test_panes_pass_what_is_tabulated():
    case = CASES["slab_n1.52"]
    c, n = cosines(case["geometry"]["angles"]), case["geometry"]["n"]
    all_of_them, single = case["value"]
    assert refraction.pane_transmittance(c, n) == pytest.approx(all_of_them, rel=1e-12)
    assert refraction.single_pass_transmittance(c, n) == pytest.approx(single, rel=1e-12)
    assert refraction.pane_transmittance(0.0, n) == 0


def test_fitted_glass_is_kept_from_falling_below_nothing():
    case = CASES["5.5_glass_mitalas"]
    c = cosines(case["geometry"]["angles"])
    found = refraction.fitted_pane_transmittance(c, case["geometry"]["coeff"])
    assert found[:-1] == pytest.approx(case["value"][:-1], rel=1e-12)
    assert case["value"][-1] < 0 and found[-1] == 0


@pytest.mark.parametrize("name", metal_names())
def test_bands_of_metals_are_the_weighted_reflectances(name):
    nm, weights = band_weights()
    assert weights.sum(axis=1) == pytest.approx(np.ones(3), abs=2e-5)  # given to 6 digits
    c = cosines(np.arange(0, 90, 5))[:, None]
    by_wavelength = fresnel.reflectance(c, metal_index(name, nm))
    expected = np.clip(by_wavelength @ weights.T, by_wavelength.min(axis=1, keepdims=True),
                       by_wavelength.max(axis=1, keepdims=True))  # fmt: skip
    found = fresnel.reflectance(c, metal_bands(name))
    assert found == pytest.approx(expected, abs=4e-3)  # one index cannot follow every angle
    assert np.all(found <= 1)


def test_metals_are_interpolated_and_look_like_themselves():
    assert metal_index("gold", 650.0) == pytest.approx(0.16 + 3.5j, abs=0.4)  # other measurements
    middle = metal_index("copper", [500, 505, 510])
    assert middle[1] == pytest.approx((middle[0] + middle[2]) / 2, rel=1e-14)
    red, green, blue = fresnel.normal_reflectance(metal_bands("gold"))
    assert red > 0.9 > green > 0.6 > blue and red > 2 * blue
    silver = fresnel.normal_reflectance(metal_bands("silver"))
    assert np.all(silver > 0.97) and silver[0] > silver[2]


def test_wrong_values_are_named():
    with pytest.raises(ValueError, match=r"cosine = -0.1 must lie in \[0, 1\]"):
        fresnel.reflectance(-0.1, 1.5)
    with pytest.raises(ValueError, match="index = -1.5 must be positive"):
        fresnel.polarised_reflectance(0.5, -1.5)
    with pytest.raises(ValueError, match="a metal absorbs what it does not reflect"):
        fresnel.transmittance(0.5, 1 + 2j)
    with pytest.raises(ValueError, match=r"must lie in \[0, 1\): no finite index"):
        fresnel.index_of_reflectance(1.0)
    with pytest.raises(ValueError, match="'brass' must be one of aluminium"):
        metal_index("brass", 500)
    with pytest.raises(ValueError, match="between 380 and 780 nm"):
        metal_index("gold", 300)
