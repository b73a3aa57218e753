"""Reflection models against closed forms, tabulated albedos, reciprocity and rotations."""

import numpy as np
import pytest

from radiosity.analytic import load_cases
from radiosity.light.phong import phong, phong_albedo
from radiosity.light.reflection import lambert

Z = np.array([0.0, 0.0, 1.0])


def unit_vectors(rng, k):
    v = rng.normal(size=(k, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def hemisphere(n_theta=400, n_phi=800):
    """Midpoint directions about Z, with the weights cos(theta) dw; sums to pi."""
    theta = (np.arange(n_theta) + 0.5) * np.pi / 2 / n_theta
    phi = (np.arange(n_phi) + 0.5) * 2 * np.pi / n_phi
    t, p = (g.ravel() for g in np.meshgrid(theta, phi, indexing="ij"))
    directions = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=1)
    return directions, np.cos(t) * np.sin(t) * (np.pi / 2 / n_theta) * (2 * np.pi / n_phi)


def incident(degrees):
    return np.array([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])


def test_lambert_reflects_its_reflectance():
    _, weight = hemisphere()
    assert lambert([0.2, 0.5, 1.0]) * weight.sum() == pytest.approx([0.2, 0.5, 1.0], rel=1e-5)
    # 1e-5: midpoint rule, (pi/800)^2/6 in theta


def test_phong_peaks_at_the_mirror_direction():
    light, mirror = incident(40), incident(-40)
    peak = phong([0.3, 0.6], 50, Z, light, mirror)
    assert peak == pytest.approx(np.array([0.3, 0.6]) * 52 / (2 * np.pi), rel=1e-13)
    ten_off = phong(1.0, 50, Z, light, incident(-30))
    assert ten_off == pytest.approx(52 / (2 * np.pi) * np.cos(np.radians(10)) ** 50, rel=1e-12)


def test_phong_takes_the_mirror_direction_outside_the_plane_of_incidence():
    view = np.array([np.sin(np.pi / 3) * np.cos(np.radians(150)), np.sin(np.pi / 3) * 0.5, 0.5])
    cos_alpha = phong(1.0, 1.0, Z, incident(60), view)[0] / (3 / (2 * np.pi))
    assert cos_alpha == pytest.approx(0.25 + 0.75 * np.cos(np.radians(30)), rel=1e-12)


@pytest.mark.parametrize(
    "light, view",
    [(100, -40), (40, -100), (60, 60), (100, -100)],
    ids=["light behind", "view behind", "far from the mirror direction", "both behind"],
)
def test_phong_is_dark(light, view):
    assert phong(1.0, 0.0, Z, incident(light), incident(view)) == 0
    assert phong(1.0, 2.0, Z, incident(light), incident(view)) == 0


@pytest.mark.parametrize("exponent", [0.0, 1.0, 7.5, 200.0])
def test_phong_is_reciprocal_and_turns_with_the_scene(exponent):
    rng = np.random.default_rng(1)
    normal, light, view = (unit_vectors(rng, 2000) for _ in range(3))
    f = phong(0.7, exponent, normal, light, view)
    assert f.shape == (2000, 1) and (f > 0).sum() > 50
    tolerance = 1e-13 * (exponent + 2)  # rounding of cos(alpha), times n by the power
    assert phong(0.7, exponent, normal, view, light) == pytest.approx(f, rel=0, abs=tolerance)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turned = phong(0.7, exponent, normal @ turn, light @ turn, view @ turn)
    assert turned == pytest.approx(f, rel=0, abs=tolerance * (exponent + 2))


def test_phong_bands_and_exponents_differ_by_point():
    rng = np.random.default_rng(2)
    light = incident(50) + 0.2 * rng.random((5, 3))
    light /= np.linalg.norm(light, axis=1, keepdims=True)
    view = np.broadcast_to(incident(-45), (5, 3))
    rho, n = rng.random((5, 3)), np.array([0.0, 1.0, 5.0, 20.0, 100.0])
    together = phong(rho, n, Z, light, view)
    assert np.all(together > 0)
    for i in range(5):
        alone = phong(rho[i], n[i], Z, light[i], view[i])
        assert together[i] == pytest.approx(alone, rel=1e-13)


PHONG = [c for c in load_cases("reflection") if c["geometry"]["type"] == "phong_albedo"]


@pytest.mark.parametrize("case", PHONG, ids=lambda c: c["id"])
def test_phong_albedo_is_the_tabulated_one(case):
    n, angles = case["geometry"]["n"], np.radians(case["geometry"]["angles"])
    expected = np.array(case["value"]) * (n + 2) / (2 * np.pi)
    found = phong_albedo(n, np.maximum(np.cos(angles), 0.0))
    assert found == pytest.approx(expected, rel=10.0 ** (1 - case["digits"]))


@pytest.mark.parametrize("exponent", [0.0, 0.5, 3.0, 40.0])
@pytest.mark.parametrize("degrees", [0, 35, 80])
def test_phong_albedo_is_what_the_lobe_sends_out(exponent, degrees):
    view, weight = hemisphere()
    sent = (phong(1.0, exponent, Z, incident(degrees), view)[:, 0] * weight).sum()
    found = phong_albedo(exponent, np.cos(np.radians(degrees)))
    assert found == pytest.approx(sent, rel=2e-3)  # midpoint rule, first order at the lobe's edge


@pytest.mark.parametrize("exponent", [0.0, 0.3, 1.0, 33.3, 1e3, 1e5])
def test_phong_albedo_never_exceeds_normal_incidence(exponent):
    albedo = phong_albedo(exponent, np.linspace(0, 1, 101))
    assert albedo[-1] == pytest.approx(1.0, rel=1e-12)
    assert np.all(np.diff(albedo) > -1e-9) and np.all(albedo > 0)  # 1e-9: the promised accuracy


@pytest.mark.parametrize("exponent", [0.1, 2.5, 60.0, 5e4])
def test_phong_albedo_at_grazing_is_a_beta_function(exponent):
    """Half the lobe is cut off: (n + 2)/pi int cos^n(z) sin^2(z) dz, a ratio of gammas."""
    from scipy.special import beta

    expected = (exponent + 2) / np.pi * beta((exponent + 1) / 2, 1.5) / 2
    assert phong_albedo(exponent, 0.0) == pytest.approx(expected, abs=1e-8)


def test_impossible_lobes_are_refused():
    with pytest.raises(ValueError, match=r"exponent = -1 must be finite and at least 0"):
        phong(0.5, -1, Z, Z, Z)
    for cosine in (1.5, -0.5):
        with pytest.raises(ValueError, match=rf"cos_theta = {cosine} must lie in \[0, 1\]"):
            phong_albedo(10, cosine)
