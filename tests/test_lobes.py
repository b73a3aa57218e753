"""Reflection models: tabulated values, white furnaces, reciprocity, sampling, extremes, coats."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import chi2, qmc

from radiosity.analytic import load_cases
from radiosity.light import fresnel
from radiosity.light.blinn import Blinn
from radiosity.light.coat import coated_diffuse, layered
from radiosity.light.coherent import Constant, FresnelMirror, FresnelPassage
from radiosity.light.facet_albedo import facet_albedo
from radiosity.light.facets import Beckmann, CosinePower, Gaussian, TrowbridgeReitz
from radiosity.light.frames import frame, polar, to_local, to_scene
from radiosity.light.metals import metal_bands
from radiosity.light.phong import Phong
from radiosity.light.seed_forms import SeedForm
from radiosity.light.shadowing import smith, v_groove
from radiosity.light.torrance_sparrow import TorranceSparrow

CASES = {c["id"]: c for c in load_cases("reflection")}
ONE = np.ones(1)
GLASS = np.array([1.5])
MODELS = [
    Phong(ONE, 0.0), Phong(ONE, 12.0), Phong(ONE, 800.0),
    Blinn(ONE, 0.0), Blinn(ONE, 12.0), Blinn(ONE, 800.0),
    *(TorranceSparrow(kind(m), shadowing, index, ONE)
      for kind in (TrowbridgeReitz, Beckmann, Gaussian) for m in (0.05, 0.3, 1.0)
      for shadowing, index in ((v_groove, None), (smith, GLASS))),
    TorranceSparrow(CosinePower(20.0), smith, np.array([0.16 + 3.5j]), ONE),
]  # fmt: skip


def name(model):
    return model.summary if hasattr(model, "summary") else str(model)


def tilted(degrees, azimuth=0.0):
    return polar(np.cos(np.radians(degrees)), np.radians(azimuth))


def grid(count):
    """Middles of cells of the hemisphere (k, 3) and the weights cos(theta) dw of the cells."""
    theta = (np.arange(count) + 0.5) * np.pi / 2 / count
    phi = (np.arange(count) + 0.5) * 2 * np.pi / count
    t, p = (g.ravel() for g in np.meshgrid(theta, phi, indexing="ij"))
    return polar(np.cos(t), p), np.cos(t) * np.sin(t) * (np.pi / count) ** 2


def test_torrance_sparrow_rows_are_blinn_s():
    """s = D G F/(N.E) with D of peak 1."""
    case = CASES["blinn_torrance_sparrow_p"]
    kinds = {"s_D1": CosinePower, "s_D2": Gaussian, "s_D3": TrowbridgeReitz}
    for row in case["value"]:
        light, view = tilted(row["theta_L"]), tilted(row["theta_E"], row["phi"])
        index = row["n"] and np.array([float(row["n"])])
        half = (light + view) / np.linalg.norm(light + view)
        assert np.degrees(np.arccos(min(half[2], 1))) == pytest.approx(row["alpha_deg"], abs=1e-6)
        for key, kind in kinds.items():
            model = TorranceSparrow(kind.of_half_angle(row["beta"]), v_groove, index, ONE)
            assert model.fresnel(view @ half)[0] == pytest.approx(row["F"], rel=1e-12)
            assert model.shape(light, view)[0] == pytest.approx(row[key], rel=1e-11)
            full = model.shape(light, view) / (4 * light[2] * model.facets.norm())
            assert model.value(light, view) == pytest.approx(full, rel=1e-12)


def peak(theta, stop):
    model = TorranceSparrow(Gaussian.of_half_angle(15), v_groove, None, ONE)
    found = minimize_scalar(
        lambda t: -model.shape(tilted(theta), tilted(t, 180))[0],
        bounds=(theta, stop), method="bounded", options={"xatol": 1e-8},
    )  # fmt: skip
    return found.x, -found.fun


def test_the_peak_lies_beyond_the_mirror_direction():
    angle, value = CASES["offspecular_peak_i30_beta15"]["value"]
    assert peak(30, 60) == (pytest.approx(angle, abs=1e-5), pytest.approx(value, rel=1e-9))
    angle, value = CASES["offspecular_peak_i70_beta15"]["value"]
    found = peak(70, angle)
    assert found[0] > 89.999 and found[1] == pytest.approx(value, rel=1e-5)


def test_blinn_albedo_is_the_tabulated_one():
    case = CASES["blinnphong_albedo_n20"]
    n = case["geometry"]["n"]
    cosine = np.maximum(np.cos(np.radians(case["geometry"]["angles"])), 0)
    largest = 8 * np.pi * (2 ** (-n / 2) + n) / ((n + 2) * (n + 4))
    found = Blinn(ONE, n).albedo(cosine)[:, 0] * largest
    assert found == pytest.approx(case["value"], rel=1e-8)
    assert Blinn(ONE, n).shape(tilted(10), tilted(10, 180))[0] == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_white_furnace(model):
    """In unit radiance from everywhere a surface sends out its albedo, never more than 1."""
    directions, weight = grid(500)
    for degrees in (0.0, 50.0, 80.0):
        view = tilted(degrees, 30)
        f = model.value(directions, view)[:, 0]
        sent = f @ weight
        found = model.albedo(np.cos(np.radians(degrees)))[0]
        assert found == pytest.approx(sent, rel=1e-2)  # cells against lobes 1/30 wide
    albedo = model.albedo(np.linspace(0, 1, 400))[:, 0]
    assert np.all(albedo >= 0) and albedo.max() <= 1 + 1e-12
    fine = np.linspace(0, 1, 20001)
    mean = 2 * np.trapezoid(model.albedo(fine)[:, 0] * fine, fine)
    assert model.mean_albedo[0] == pytest.approx(mean, rel=1e-4)


@pytest.mark.parametrize("kind", [TrowbridgeReitz, Beckmann, Gaussian])
@pytest.mark.parametrize("shadowing", [v_groove, smith])
@pytest.mark.parametrize("roughness", [1e-3, 0.1, 1.0])
def test_tables_of_albedos_are_right_to_1e_4_down_to_grazing(kind, shadowing, roughness):
    model = TorranceSparrow(kind(roughness), shadowing, GLASS, ONE)
    cosine = np.concatenate([[1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.03], np.linspace(0.05, 1, 12)])
    exact = facet_albedo(model.facets, shadowing, GLASS, cosine, 150, 16)
    assert model.albedo(cosine) == pytest.approx(exact, abs=1e-4)


def test_smooth_facets_return_what_a_mirror_does_and_grooves_never_all():
    index = np.array([1.5])
    cosine = np.linspace(0.2, 1, 9)
    smooth = TorranceSparrow(TrowbridgeReitz(1e-4), v_groove, index, ONE).albedo(cosine)
    assert smooth == pytest.approx(fresnel.reflectance(cosine[:, None], index), abs=2e-4)
    losing = TorranceSparrow(Beckmann(0.5), smith, None, ONE).albedo(cosine)
    assert np.all(losing < 0.99) and np.all(losing > 0.8)


@pytest.mark.parametrize("model", [m for m in MODELS], ids=name)
def test_light_and_view_may_change_places(model):
    rng = np.random.default_rng(1)
    light, view = (polar(rng.random(500), 2 * np.pi * rng.random(500)) for _ in range(2))
    f, back = model.value(light, view), model.value(view, light)
    assert model.reciprocal and f.max() > 0
    assert back == pytest.approx(f, rel=1e-8, abs=1e-12)  # 1e-8: n times the rounding of a cosine
    turn, mirror = polar(np.zeros(1), [0.7])[0], np.array([1.0, -1.0, 1.0])
    turned = np.array([[turn[0], -turn[1], 0], [turn[1], turn[0], 0], [0, 0, 1]])
    for change in (turned, np.diag(mirror)):
        moved = model.value(light @ change, view @ change)
        assert moved == pytest.approx(f, rel=1e-7, abs=1e-12)


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_nothing_is_seen_below_the_horizon(model):
    up, down = tilted(40), tilted(100)
    for light, view in ((up, down), (down, up), (down, down)):
        assert model.value(light, view)[0] == 0


@pytest.mark.parametrize("model", MODELS, ids=name)
@pytest.mark.parametrize("degrees", [5, 70])
def test_samples_follow_their_density(model, degrees):
    """Counts in cells of the whole sphere against the density integrated over each (chi square).

    Cells are rings about the mirror direction, which hold some share of the samples each, in
    eight sectors.
    """
    rng, count = np.random.default_rng(7), 40000
    view = tilted(degrees)
    frames = frame(view * [-1, -1, 1])
    drawn = to_local(frames, model.sample(view, rng.random((count, 2))))
    assert np.linalg.norm(drawn, axis=1) == pytest.approx(np.ones(count), abs=1e-12)
    angle = np.arccos(np.clip(drawn[:, 2], -1, 1))
    shares = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.997, 0.9995]
    edges = np.concatenate([[0], np.quantile(angle, shares), [np.pi]])
    cells = cell_probabilities(lambda d: model.density(view, to_scene(frames, d)), edges)
    assert cells.sum() == pytest.approx(1, abs=2e-3)  # middles of small cells
    sector = (np.arctan2(drawn[:, 1], drawn[:, 0]) % (2 * np.pi) * 4 / np.pi).astype(int) % 8
    ring = np.searchsorted(edges[1:-1], angle)
    found = np.bincount(8 * ring + sector, minlength=cells.size)
    expected = cells.ravel() * count
    many = expected > 10
    statistic = ((found - expected)[many] ** 2 / expected[many]).sum()
    assert many.sum() > 60 and chi2.sf(statistic, many.sum() - 1) > 1e-3


def cell_probabilities(density, edges):
    """Return (rings, 8) integrals of a density over rings about z and sectors of them."""
    parts = [np.linspace(a, b, 61)[:-1] for a, b in zip(edges, edges[1:], strict=False)]
    fine = np.concatenate([*parts, [np.pi]])
    phi = (np.arange(256) + 0.5) * 2 * np.pi / 256
    t, p = np.meshgrid((fine[1:] + fine[:-1]) / 2, phi, indexing="ij")
    share = density(polar(np.cos(t), p)) * -np.diff(np.cos(fine))[:, None] * 2 * np.pi / 256
    return share.reshape(len(edges) - 1, 60, 8, 32).sum(axis=(1, 3))


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_sampling_finds_the_albedo_with_bounded_weights(model):
    rng = np.random.default_rng(3)
    view = tilted(60)
    light = model.sample(view, rng.random((20000, 2)))
    density, cosine = model.density(view, light), light[:, 2]
    up = cosine > 0
    weight = np.zeros(20000)
    weight[up] = model.value(light[up], view)[:, 0] * cosine[up] / density[up]
    error = weight.std() / np.sqrt(20000)
    assert weight.mean() == pytest.approx(model.albedo(0.5)[0], abs=4 * error + 1e-4)
    exact = isinstance(model, TorranceSparrow) and (
        model.shadowing is v_groove or isinstance(model.facets, TrowbridgeReitz)
    )
    gaussian = exact and isinstance(model.facets, Gaussian)
    # Visible facets leave nothing over; 1.7 where D has no inverse; 4 N.L of Blinn's exponent 0.
    assert weight.max() < (1.7 if gaussian else 1 + 1e-9 if exact else 4.1)


@pytest.mark.parametrize("degrees", [0.0, 45.0, 89.999, 90.0])
def test_extremes_have_numbers(degrees):
    """Grazing light, needle-thin and flat lobes: finite, and no division by nothing."""
    views = [tilted(degrees, 20), tilted(0), tilted(89.999, 200), tilted(60, 180)]
    models = [kind(ONE, n) for kind in (Phong, Blinn) for n in (0.0, 1e5)]
    models += [TorranceSparrow(kind(m), shadowing, index, ONE)
               for kind in (TrowbridgeReitz, Beckmann, Gaussian) for m in (1e-3, 1.0)
               for shadowing in (v_groove, smith) for index in (None, GLASS)]  # fmt: skip
    u = np.array([[0.0, 0.0], [0.5, 0.25], [1 - 1e-12, 1 - 1e-12]])
    with np.errstate(all="raise", under="ignore"):
        for model in models:
            for view in views:
                f = model.value(tilted(degrees), view)
                drawn = model.sample(view, u)
                density = model.density(view, drawn)
                f_drawn = model.value(drawn, view)
                for found in (f, drawn, density, f_drawn, model.albedo(max(view[2], 0.0))):
                    assert np.all(np.isfinite(found)), model.summary
                assert np.all(f >= 0) and np.all(density >= 0)


def test_exponents_and_roughnesses_may_differ_by_point():
    rng = np.random.default_rng(2)
    light, view = (polar(rng.random(4), 2 * np.pi * rng.random(4)) for _ in range(2))
    u = rng.random((4, 2))
    rough = np.array([0.05, 0.2, 0.21, 0.9])
    facets = TorranceSparrow(TrowbridgeReitz(0.5), v_groove, GLASS, np.array([0.2, 0.5, 1.0]))
    for model, change, values in (
        (facets, "with_roughness", rough),
        (replaced(facets, smith), "with_roughness", rough),
        (Phong(np.ones(3), 1.0), "with_exponent", 20 * rough),
        (Blinn(np.ones(3), 1.0), "with_exponent", 20 * rough),
    ):
        together = getattr(model, change)(values)
        tolerance = 2e-3 if model is facets or change == "with_roughness" else 1e-9
        for k in range(4):
            alone = getattr(model, change)(float(values[k]))
            assert together.value(light, view)[k] == pytest.approx(
                alone.value(light[k], view[k]), rel=1e-12
            )
            drawn = together.sample(view, u)
            assert drawn[k] == pytest.approx(alone.sample(view[k], u[k]), abs=1e-13)
            density = together.density(view, drawn)
            assert density[k] == pytest.approx(alone.density(view[k], drawn[k]), rel=1e-12)
            cosine = np.array([0.02, 0.1, 0.3, 1.0])
            assert together.albedo(cosine)[k] == pytest.approx(
                alone.albedo(cosine[k]), abs=tolerance
            )
            assert together.mean_albedo[k] == pytest.approx(alone.mean_albedo, abs=tolerance)


def replaced(model, shadowing):
    return TorranceSparrow(model.facets, shadowing, model.index, model.reflectance)


def test_bands_have_their_own_index():
    gold = TorranceSparrow(TrowbridgeReitz(0.2), v_groove, metal_bands("gold"), np.ones(3), "gold")
    red, green, blue = gold.value(tilted(30), tilted(30, 180))
    assert red > green > blue > 0 and not gold.dielectric
    expected = fresnel.reflectance(np.cos(np.radians(30)), metal_bands("gold"))
    assert np.array([red, green, blue]) / red == pytest.approx(expected / expected[0], rel=1e-12)
    assert gold.summary == "Torrance-Sparrow, TrowbridgeReitz roughness 0.2, v-groove, gold"


@pytest.mark.parametrize("rho", [0.2, 1.0])
def test_a_coated_base_is_reciprocal_and_keeps_what_arrives(rho):
    """A coat alone has albedo .46 at 85 degrees; what rho adds never takes it past 1."""
    coat = TorranceSparrow(TrowbridgeReitz(0.1), v_groove, GLASS, ONE)
    mean = coat.mean_albedo[0]
    directions, weight = grid(300)
    a_light = coat.albedo(directions[:, 2])[:, 0]
    for degrees in (0, 60, 85, 89):
        out = coat.albedo(np.cos(np.radians(degrees)))[0]
        f = coated_diffuse(rho, a_light, out, mean)
        assert np.array_equal(f, coated_diffuse(rho, out, a_light, mean))
        base = f @ weight
        assert base == pytest.approx(rho * (1 - out), rel=1e-3)  # midpoints of cells
        total = layered(rho * ONE, np.array([out]), True)[0]
        assert total == pytest.approx(out + base, abs=1e-3) and total <= 1 + 1e-12
    sum_without = layered(np.array([0.8]), coat.albedo(np.cos(np.radians(89))), False)
    assert sum_without > 1.2
    assert coated_diffuse(0.5, 1.0, 1.0, 1.0) == 0


def test_a_dielectric_coat_has_the_albedo_of_the_errata():
    for kind in (Beckmann, Gaussian):
        coat = TorranceSparrow(kind(0.1), v_groove, GLASS, ONE)
        albedo = coat.albedo(np.cos(np.radians([85, 88])))[:, 0]
        assert albedo == pytest.approx([0.46, 0.60], abs=5e-3)  # given to two digits


def test_mirrors_and_passages_share_what_arrives():
    cosine = np.linspace(0, 1, 50)
    index = np.array([1.3, 1.5, 1.8])
    mirror, passage = FresnelMirror(index), FresnelPassage(index)
    assert mirror.albedo(cosine) + passage.albedo(cosine) == pytest.approx(
        np.ones((50, 3)), abs=1e-12
    )
    assert mirror.mean_albedo + passage.mean_albedo == pytest.approx(np.ones(3), abs=1e-12)
    assert mirror.dielectric and not FresnelMirror(metal_bands("silver")).dielectric
    assert FresnelMirror(metal_bands("silver")).summary.startswith("Fresnel, index 0.05")
    half = Constant(np.full(3, 0.5))
    assert half.albedo(cosine).shape == (50, 3) and half.mean_albedo.tolist() == [0.5] * 3


def test_seed_forms_are_the_seeds_and_not_reciprocal():
    """k cos^n(alpha)/cos(theta_i); Blinn's aluminium sends out three times what arrives."""
    light, view = tilted(50), tilted(45, 190)
    for model in (Phong(np.full(3, 0.4), 30.0), Blinn(np.full(3, 0.4), 30.0)):
        raw = SeedForm(model)
        assert raw.value(light, view) == pytest.approx(
            0.4 * model.shape(light, view) / light[2] * np.ones(3), rel=1e-14
        )
        assert not raw.reciprocal and not hasattr(raw, "albedo")
        assert raw.value(view, light)[0] != pytest.approx(raw.value(light, view)[0], rel=1e-3)
        assert np.all(raw.value(tilted(95), view) == 0)
    mirror = tilted(50, 180)
    assert Phong(ONE, 7.0).shape(light, mirror)[0] == pytest.approx(1, rel=1e-13)
    aluminium = SeedForm(TorranceSparrow(TrowbridgeReitz(0.5), v_groove, np.array([200.0]),
                                         np.full(1, 0.4)))  # fmt: skip
    directions, weight = grid(200)
    sent = aluminium.value(directions, tilted(0))[:, 0] @ weight
    assert sent + 0.6 * np.pi == pytest.approx(2.75, abs=0.02)  # with k_d = 0.6 beside it


@pytest.mark.parametrize("model", [
    TorranceSparrow(TrowbridgeReitz(0.15), v_groove, None, ONE),
    TorranceSparrow(TrowbridgeReitz(0.5), smith, None, ONE), Blinn(ONE, 20.0), Phong(ONE, 20.0),
], ids=name)  # fmt: skip
def test_even_patterns_bring_less_noise_than_random_ones(model):
    """64 Sobol points a pixel, shifted digit by digit, as the gather uses them; half a lobe."""
    rng, view = np.random.default_rng(0), tilted(60)
    digits = qmc.Sobol(2, scramble=False).random(64) * 2**32
    shift = rng.integers(0, 2**32, (2000, 1, 2), dtype=np.uint64)
    even = (digits.astype(np.uint64) ^ shift) / 2.0**32
    noise = []
    for u in (even, rng.random(even.shape)):
        light = model.sample(view, u)
        density = model.density(view, light)
        up = (light[..., 2] > 0) & (density > 0) & (light[..., 0] < -np.sin(np.radians(60)))
        share = light[..., 2] / np.where(up, density, 1.0)
        weight = np.where(up, model.value(light, view)[..., 0] * share, 0.0)
        noise.append(weight.mean(axis=1).std())
    assert noise[0] < 0.75 * noise[1]
