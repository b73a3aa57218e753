"""Where shadow rays begin and end, against the plain bilinear map."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, rotation

from radiosity.transport.occlusion import _at, _bilinear_map
from radiosity.transport.polygon import bilinear

SHAPES = {
    "square": SQUARE, "triangle": SQUARE[[0, 1, 2, 2]], "point": SQUARE[[0, 0, 0, 0]],
    "trapezoid": np.array([[0, 0, 0], [3, 0, 0], [1.2, 1, 0], [1, 1, 0.0]]),
}  # fmt: skip


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("far", [0.0, 1e6])
def test_the_map_is_the_bilinear_one(name, side, far):
    rng = np.random.default_rng(0)
    turn, centre, scale, lift = rotation(rng), np.full(3, far), 0.5, 1e-5
    polygon = (SHAPES[name] @ turn.T + far)[::side]
    normal = turn @ [0, 0, 1.0]
    terms, x = np.empty((4, 4)), np.empty(3)
    _bilinear_map(polygon, normal, centre, scale, lift, terms)
    for s, t in rng.random((20, 2)):
        stretch = bilinear(polygon, s, t, x)
        found = np.array([_at(row, s, t) for row in terms])
        expected = (x - centre) * scale + lift * normal
        assert found[:3] == pytest.approx(expected, abs=1e-15 + 1e-15 * far)
        assert found[3] == pytest.approx(side * stretch, abs=1e-14 + 1e-14 * far)
