"""The built-in cases: none is left out, a wrong factor is seen, bodies look the right way."""

import numpy as np
import pytest

from radiosity.analytic import load_cases
from radiosity.mesh.faces import Faces
from radiosity.solve import cases, cie, curved, limits
from radiosity.solve.verification import run_suites

FILES = {
    "elements": "vf_element_polygon", "polygons": "vf_polygon_pairs", "extremes": "extremes",
    "obstructed": "vf_obstructed", "curved": "vf_curved", "cie171": "cie171",
    "reflection": "reflection", "colour": "colour",
}  # fmt: skip
ELSEWHERE = ("furnace",)  # among the rooms


@pytest.mark.parametrize("suite", FILES)
def test_no_case_is_left_out(suite, monkeypatch):
    """Curved ones take long: they are computed where test_readme.py runs ``verify``."""
    monkeypatch.setattr(curved, "timed", lambda suite, case, value, bound, compute: cases.Check(
        suite, case, 1.0, 1.0, 1.0, bound, 0.0))  # fmt: skip
    checks = [c.case for c in run_suites([suite])]
    for case in load_cases(FILES[suite]):
        if case["geometry"]["type"] not in ELSEWHERE:
            assert any(name.startswith(case["id"]) for name in checks), case["id"]


def test_comparison_with_cie_171_is_kept():
    checks = list(run_suites(["cie171"]))
    assert len(checks) >= 22 and all(c.passed for c in checks)
    assert {c.bound for c in checks} == {0.005, 0.01, cie.GRAZED, cie.EXACT, np.inf}
    assert all("printed only" in c.case for c in checks if c.bound == np.inf)


def test_the_limits_are_kept():
    """Reflectances of 1 - 1e-9, lamps 1e12 apart, gaps and slivers of 1e-6, faulty meshes."""
    checks = list(run_suites(["limits"]))
    assert len(checks) >= 24 and all(c.passed for c in checks)
    names = " ".join(c.case for c in checks)
    for said in ("1e-09, differences", "1e+12", "no size", "one patch", "all black", "cross"):
        assert said in names


def test_an_error_at_the_limits_is_seen(monkeypatch):
    """A relative error of 2e-6 in what is expected, and 1 - rho found by subtraction."""
    exact, room = limits.box_of_one_lamp, limits.room_of
    monkeypatch.setattr(limits, "box_of_one_lamp", lambda a: [x * (1 + 2e-6) for x in exact(a)])
    monkeypatch.setattr(limits, "room_of", lambda *a: room(*a[:3]))
    found = {c.case: c for c in run_suites(["limits"])}
    assert not found["lamp 1 - rho = 1e-06"].passed
    assert found["furnace 1 - rho = 1e-09, mesh 1"].error > 1e-9


def test_a_wrong_factor_is_seen(monkeypatch):
    right = cases.exchange_area
    monkeypatch.setattr(cases, "exchange_area", lambda *a: (right(*a)[0] * (1 + 2e-9), 0.0))
    assert not any(c.passed for c in run_suites(["polygons"]))


def test_a_wrong_order_is_seen(monkeypatch):
    shapes = {k: (lambda g, n: 1 + 1e-3 / n, n, b) for k, (_, n, b) in curved.SHAPES.items()}
    monkeypatch.setattr(curved, "SHAPES", shapes)
    monkeypatch.setattr(curved, "load_cases", lambda _: [
        {"id": "flat", "value": 1.0, "geometry": {"type": "coaxial_disks"}}])  # fmt: skip
    fine, order = run_suites(["curved"])
    assert fine.passed and order.found == pytest.approx(1.0) and not order.passed


def test_reflection_is_right_to_its_digits():
    checks = list(run_suites(["reflection"]))
    assert len(checks) > 30 and all(c.passed for c in checks)


def test_fresnel_at_the_wrong_angle_is_seen(monkeypatch):
    """A facet reflects at L.H: F at normal incidence, and the prefactor left out, are caught."""
    from radiosity.light.torrance_sparrow import TorranceSparrow

    right = TorranceSparrow.fresnel
    monkeypatch.setattr(TorranceSparrow, "fresnel", lambda m, c: right(m, np.ones_like(c)))
    found = {c.case: c.passed for c in run_suites(["reflection"])}
    assert not found["blinn_torrance_sparrow_p 70/75"]
    assert found["blinn_torrance_sparrow_p 80/85"]  # F = 1


def test_the_worst_value_is_told():
    check = cases.timed("s", "c", [1.0, 2.0, 0.5], 0.1, lambda: np.array([1.0, 2.1, 0.49]))
    assert (check.expected, check.found) == (2.0, 2.1) and check.passed
    absolute = cases.timed("s", "c", 0.0, 0.0, lambda: 1e-9, relative=False)
    assert absolute.error == 1e-9 and not absolute.passed
    assert not cases.timed("s", "c", [1.0, 1.0], 0.1, lambda: np.array([1.0, np.nan])).passed


def faces(quads):
    index = np.zeros(len(quads), int)
    return Faces(quads, index, index)


@pytest.mark.parametrize("inward", [False, True])
def test_a_sphere_has_its_area_and_looks_its_way(inward):
    errors = []
    for n in (8, 16):
        ball = faces(curved.sphere(2.0, n, inward))
        assert len(ball) == 2 * n * n and ball.is_triangle.sum() == 4 * n
        out = np.einsum("kc,kc->k", ball.normals(), ball.vertices.mean(axis=1))
        assert np.all(out < 0) if inward else np.all(out > 0)
        errors.append(16 * np.pi - ball.areas().sum())
    assert errors[1] / (16 * np.pi) < 0.25 * (np.pi / 16) ** 2  # chords: h^2/24, heights: h^2/8
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.05)


@pytest.mark.parametrize(
    ("quads", "normal", "area"),
    [
        (curved.disk(2.0, 1.0, 64), [0, 0, 1], 4 * np.pi),
        (curved.disk(2.0, 1.0, 64, up=False), [0, 0, -1], 4 * np.pi),
        (curved.revolved([(2, 0), (1, 0)], 64), [0, 0, 1], 3 * np.pi),
    ],
)
def test_disks_and_rings_lie_flat(quads, normal, area):
    flat = faces(quads)
    assert flat.normals() == pytest.approx(np.tile(normal, (64, 1)), abs=1e-14)
    assert flat.areas().sum() == pytest.approx(area, rel=2e-3)  # (2 pi/64)^2/6 is left out


def test_a_cone_closes_without_a_gap():
    cone = np.concatenate([curved.revolved([(0, 1), (1, 0)], 12), curved.disk(1.0, 0, 12)])
    body = faces(cone)
    flux = (body.areas()[:, None] * body.normals()).sum(axis=0)
    assert flux == pytest.approx(np.zeros(3), abs=1e-14)
    assert np.all(body.normals() @ [0, 0, 1] * np.repeat([-1, 1], 12) > 0)  # both look inside


def test_division_keeps_area_and_winding():
    parts = cases.divided(cases.BOX, 3)
    assert parts.shape == (54, 4, 3)
    whole = faces(parts)
    assert whole.areas() == pytest.approx(np.full(54, 1 / 9), rel=1e-14)
    expected = np.repeat(faces(cases.BOX).normals(), 9, axis=0)
    assert whole.normals() == pytest.approx(expected, abs=1e-14)
    assert len(np.unique(parts.mean(axis=1).round(9), axis=0)) == 54
