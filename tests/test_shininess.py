"""Shininess from a texture, against Blinn's formula in exact fractions and its integral."""

from fractions import Fraction

import numpy as np
import pytest

from radiosity.light.shininess import facets, spread

MINIMA, VALUES = (0.05, 0.35, 1.0), (0.0, 0.25, 0.5, 1.0)


def blinn(cosine, minimum, t):
    """Return his two lines as they stand, in fractions."""
    cosine, minimum, t = Fraction(cosine), Fraction(minimum), Fraction(t)
    c3 = minimum + (1 - minimum) * t
    return float((minimum * c3 / (cosine**2 * (c3**2 - 1) + 1)) ** 2)


@pytest.mark.parametrize("minimum", MINIMA)
def test_facets_are_blinns(minimum):
    cosines = (0.0, 1e-3, 0.3, 0.9, 0.999999, 1.0)
    expected = [[blinn(c, minimum, t) for t in VALUES] for c in cosines]
    found = facets(np.array(cosines)[:, None], minimum, np.array(VALUES))
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize("minimum", MINIMA)
@pytest.mark.parametrize("t", VALUES)
def test_every_point_has_the_same_area_of_facets(minimum, t):
    """int D3 cos(alpha) dw = pi c_min^2, whatever the texture says; Gauss, in c3 tan(alpha)."""
    x, w = np.polynomial.legendre.leggauss(64)
    c3 = spread(minimum, t)
    tangent = np.tan((x + 1) * np.pi / 4)  # of alpha over c3, from 0 to infinity
    cosine = 1 / np.hypot(1, c3 * tangent)
    weight = w * np.pi / 4 * (1 + tangent**2) * c3**2 * tangent * cosine**4 * 2 * np.pi
    assert weight @ facets(cosine, minimum, t) == pytest.approx(np.pi * minimum**2, rel=1e-10)


def test_peaks_are_one_where_shiniest_and_all_is_even_at_one():
    assert facets(1.0, 0.2, 0.0) == 1.0
    assert facets(1.0, 0.2, 0.5) == pytest.approx((0.2 / 0.6) ** 2)
    with np.errstate(all="raise"):
        np.testing.assert_allclose(facets(np.linspace(0, 1, 9), 0.2, 1.0), 0.2**2, rtol=1e-14)


def test_impossible_textures_are_refused():
    for minimum in (0.0, -1.0, 1.1, np.nan):
        with pytest.raises(ValueError, match="must lie above 0 and be at most 1"):
            spread(minimum, 0.5)
    with pytest.raises(ValueError, match=r"from 0.5 to 1.5 must lie in \[0, 1\]"):
        spread(0.1, [0.5, 1.5])
