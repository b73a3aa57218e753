"""Closed forms against the tabulated cases, and against each other."""

import numpy as np
import pytest

from radiosity.analytic import (
    box_form_factors,
    box_radiosity,
    furnace,
    load_cases,
    parallel_rectangles,
    perpendicular_rectangles,
    point_to_parallel_rectangle,
    point_to_perpendicular_rectangle,
    sphere_cavity,
)


def cases(name, *starts):
    chosen = [c for c in load_cases(name) if c["id"].startswith(starts)]
    assert chosen, f"no case in {name} starts with {starts}"
    return pytest.mark.parametrize("case", chosen, ids=[c["id"] for c in chosen])


def digits(case):
    """The digits stated, but not beyond double precision of the sums in the closed forms."""
    return max(10.0 ** (1 - case["digits"]), 1e-13)


@cases("vf_polygon_pairs", "C11_", "strip_parallel")
def test_parallel_rectangles(case):
    a, b, _ = case["geometry"]["A1"][2]
    found = parallel_rectangles(a, b, case["geometry"]["A2"][2][2])
    assert found == pytest.approx(case["value"], rel=digits(case))


@cases("vf_polygon_pairs", "C14_", "strip_perp")
def test_perpendicular_rectangles(case):
    width, edge, _ = case["geometry"]["A1"][2]
    found = perpendicular_rectangles(edge, width, height=case["geometry"]["A2"][2][2])
    assert found == pytest.approx(case["value"], rel=digits(case))


@cases("vf_element_polygon", "B3_")
def test_point_to_parallel_rectangle(case):
    a, b, c = case["geometry"]["A2"][1]
    assert point_to_parallel_rectangle(a, b, c) == pytest.approx(case["value"], rel=digits(case))


@cases("vf_element_polygon", "B4_")
def test_point_to_perpendicular_rectangle(case):
    c, b, a = case["geometry"]["A2"][2]
    found = point_to_perpendicular_rectangle(height=a, width=b, distance=c)
    assert found == pytest.approx(case["value"], rel=digits(case))


@cases("vf_element_polygon", "lambert_horizon_cut")
def test_point_to_perpendicular_rectangle_by_halves(case):
    found = 2 * point_to_perpendicular_rectangle(height=2.0, width=1.0, distance=1.0)
    assert found == pytest.approx(case["value"], rel=digits(case))


def test_a_point_sees_half_its_hemisphere_at_most():
    assert point_to_parallel_rectangle(1e9, 1e9, 1.0) == pytest.approx(0.25, abs=1e-9)
    assert point_to_perpendicular_rectangle(1e9, 1e9, 1.0) == pytest.approx(0.25, abs=1e-9)


def test_area_to_area_is_the_mean_of_point_to_area():
    """C-11 and C-14 from B-3 and B-4: both by 40 x 40 Gauss points."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    t, w = 0.5 * (nodes + 1), 0.5 * weights
    u, v = np.meshgrid(t, t)
    weight = np.outer(w, w)
    a, b, c = 2.0, 0.7, 1.3
    quarters = sum(
        point_to_parallel_rectangle(a * x, b * y, c) for x in (u, 1 - u) for y in (v, 1 - v)
    )
    assert (weight * quarters).sum() == pytest.approx(parallel_rectangles(a, b, c), rel=1e-13)
    side = point_to_perpendicular_rectangle(height=c, width=a * u, distance=b * v)
    other = point_to_perpendicular_rectangle(height=c, width=a * (1 - u), distance=b * v)
    expected = perpendicular_rectangles(edge=a, width=b, height=c)
    # 1e-4: the integrand is not smooth in the corners where the point meets the rectangle
    assert (weight * (side + other)).sum() == pytest.approx(expected, rel=1e-4)


def test_perpendicular_rectangles_are_reciprocal():
    there = perpendicular_rectangles(2.0, width=0.3, height=5.0)
    back = perpendicular_rectangles(2.0, width=5.0, height=0.3)
    assert 0.3 * there == pytest.approx(5.0 * back, rel=1e-13)


def test_factors_take_arrays_and_any_unit():
    sizes = np.array([1.0, 2.0, 3.0])
    for form in (
        parallel_rectangles,
        perpendicular_rectangles,
        point_to_parallel_rectangle,
        point_to_perpendicular_rectangle,
    ):
        together = form(sizes, 1.5, 0.7)
        assert together == pytest.approx([form(s, 1.5, 0.7) for s in sizes], rel=1e-15)
        assert form(1000 * sizes, 1500.0, 700.0) == pytest.approx(together, rel=1e-13)


@cases("radiosity", "furnace")
def test_furnace(case):
    g = case["geometry"]
    assert furnace(g["emission"], g["rho"]) == pytest.approx(case["value"], rel=digits(case))


def test_a_box_is_a_furnace():
    assert box_radiosity((4, 3, 2.5), 0.9, 2.0) == pytest.approx(furnace(2.0, 0.9), rel=1e-13)


@cases("radiosity", "sphere_cavity")
def test_sphere_cavity(case):
    parts = case["geometry"]["parts"]
    radiosity, irradiance = sphere_cavity(*([p[k] for p in parts] for k in ("frac", "E", "rho")))
    assert [*radiosity, irradiance] == pytest.approx(case["value"], rel=digits(case))


@cases("radiosity", "spherical_cavity_opening")
def test_sphere_with_an_opening(case):
    g = case["geometry"]
    wall = (1 + np.cos(np.radians(g["phi_deg"]))) / 2
    radiosity, _ = sphere_cavity([wall], [g["eps"]], [1 - g["eps"]])
    assert radiosity == pytest.approx(case["value"][:1], rel=digits(case))


@cases("radiosity", "box6")
def test_box(case):
    g = case["geometry"]
    assert box_form_factors(g["dims"]) == pytest.approx(np.array(g["F"]), rel=1e-13)
    found = box_radiosity(g["dims"], g["reflectance"], g["emission"])
    assert found == pytest.approx(case["value"], rel=digits(case))


def test_box_closes_and_balances():
    dims, rho = (1.0, 20.0, 3.0), np.array([0.9, 0.1, 0.3, 0.6, 0.8, 0.05])
    area = np.array([20.0, 20.0, 60.0, 60.0, 3.0, 3.0])
    factors = box_form_factors(dims)
    exchange = area[:, None] * factors
    assert factors.sum(axis=1) == pytest.approx(1.0, rel=1e-12)
    assert exchange == pytest.approx(exchange.T, rel=1e-11)
    emission = np.array([1.0, 0, 0, 2.0, 0, 0.5])
    irradiance = factors @ box_radiosity(dims, rho, emission)
    assert area @ ((1 - rho) * irradiance) == pytest.approx(area @ emission, rel=1e-12)


def test_cases_carry_what_readers_need():
    for name in ("vf_polygon_pairs", "vf_element_polygon", "radiosity", "reflection"):
        for case in load_cases(name):
            assert {"id", "source", "quantity", "geometry", "value", "digits"} <= case.keys()
    assert len(load_cases("vf_polygon_pairs")) == 35 and len(load_cases("radiosity")) == 25


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: parallel_rectangles(1, -2, 3), "b = -2 must be a positive length"),
        (lambda: perpendicular_rectangles(1, 1, 0), "height = 0 must be a positive length"),
        (lambda: furnace(1.0, 1.0), r"reflectance = 1\.0 must be below 1"),
        (lambda: sphere_cavity([0.6, 0.6], [1, 0], [0, 0]), "must be shares of the sphere"),
        (lambda: sphere_cavity([0.5, 0.5], [1, 0], [1, 1]), "let some part absorb"),
        (lambda: load_cases("nothing"), "no cases named 'nothing'; there are cie171, "),
    ],
)
def test_impossible_input_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
