"""Factors made before, in a scene: refused where they are not its own."""

import numpy as np
import pytest
from test_cli import BOX

import radiosity
from radiosity.solve.assembly import scene_factors


@pytest.mark.parametrize(
    ("shift", "fits"),
    [([1e-9, 0, 0], True), ([3e-6, 0, 0], True), ([5e-6, 0, 0], False), ([0, 0, -20], False)],
)
def test_factors_of_rows_that_lie_elsewhere_are_refused(shift, fits):
    """Equal areas do not make a mesh the same; rounding does not make it another: 4 m, to 1e-6."""
    scene = radiosity.load(BOX)
    good = scene_factors(scene, 0.1, mesh="2").factors
    moved = good.centroid + np.outer(np.arange(len(good.area)) == 5, shift)
    other = good.replaced(centroid=moved)
    if fits:
        radiosity.solve(scene, 0.1, mesh="2", factors=other)
        return
    with pytest.raises(ValueError, match=r"do not fit .* row 5, the front of a cell of .*, lies a"):
        radiosity.solve(scene, 0.1, mesh="2", factors=other)


def test_factors_that_make_light_are_refused():
    scene = radiosity.load(BOX)
    good = scene_factors(scene, 0.1, mesh="1").factors
    tripled = good.replaced(exchange=3 * good.exchange)
    with pytest.raises(ValueError, match=r"do not fit the scene: row \d+ and .* sum to 3, not"):
        radiosity.solve(scene, 0.1, mesh="1", factors=tripled)
