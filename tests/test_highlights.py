"""Highlights of area lights: points on lights and directions in lobes, combined."""

import numpy as np
import pytest
from test_gather import FLOOR, material, scene_of

import radiosity
from radiosity.light.blinn import Blinn
from radiosity.light.facets import Beckmann, Gaussian, TrowbridgeReitz
from radiosity.light.frames import frame, to_local
from radiosity.light.phong import Phong
from radiosity.light.shadowing import smith, v_groove
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.view import gloss

ONE, COUNT = np.ones(3), 2000
SMALL = [[-0.05, -0.05, 2], [-0.05, 0.05, 2], [0.05, 0.05, 2], [0.05, -0.05, 2]]
LARGE = [[-2, -2, 1], [-2, 2, 1], [2, 2, 1], [2, -2, 1]]
FACETS = [(f, s) for f in (Gaussian, Beckmann, TrowbridgeReitz) for s in (v_groove, smith)]
WIDE = {"phong": Phong(ONE / 2, 3), "blinn": Blinn(ONE / 2, 5)}
NARROW = {"phong": Phong(ONE / 2, 300), "blinn": Blinn(ONE / 2, 500)}
for facets, shadowing in FACETS:
    name = f"{facets.__name__} {shadowing.__name__}"
    WIDE[name] = TorranceSparrow(facets(0.4), shadowing, None, ONE)
    NARROW[name] = TorranceSparrow(facets(0.05), shadowing, None, ONE)


def ways(lobe, lamp, monkeypatch):
    """Return luminances by points alone, by directions alone and by both, (COUNT,) each."""
    scene = scene_of(
        [FLOOR, lamp], (material("floor", 0, specular=lobe), material("lamp", 0, 10)), [0, 1]
    )
    around = radiosity.solve(scene, 0.3).surroundings
    normals = np.tile([0, 0, 1.0], (COUNT, 1))
    frames = frame(normals)[:, None]
    view = to_local(frames, np.tile([-0.6, 0, 0.8], (COUNT, 1))[:, None])
    at = np.tile([-1.5, 0, 0.0], (COUNT, 1)), normals, frames, view, np.arange(COUNT), range(4), 0
    points = gloss.highlight(around, lobe, 0, *at, shared=False)[:, 0]
    both = gloss.highlight(around, lobe, 0, *at)[:, 0]
    both += gloss.reflected_surroundings(around, lobe, *at)[:, 0]
    with monkeypatch.context() as patch:  # no points: directions need not share
        patch.setattr(gloss, "_share", lambda by_lobe: np.ones_like(by_lobe))
        directions = gloss.reflected_surroundings(around, lobe, *at)[:, 0]
    return points, directions, both


def agree(one, two):
    error = np.hypot(one.std(), two.std()) / np.sqrt(COUNT)
    return abs(one.mean() - two.mean()) < 4 * error + 1e-9


@pytest.mark.parametrize("name", NARROW)
def test_a_large_light_in_a_narrow_lobe(name, monkeypatch):
    points, directions, both = ways(NARROW[name], LARGE, monkeypatch)
    assert agree(both, directions) and agree(both, points)
    assert both.std() < 0.1 * points.std()  # points hardly ever lie in the lobe


@pytest.mark.parametrize("name", WIDE)
def test_a_small_light_in_a_wide_lobe(name, monkeypatch):
    points, directions, both = ways(WIDE[name], SMALL, monkeypatch)
    assert agree(both, points) and agree(both, directions)
    assert both.std() < 0.1 * directions.std()  # directions hardly ever meet the light


@pytest.mark.parametrize("name", ["phong", "Beckmann smith"])
def test_neither_way_would_do_for_both(name, monkeypatch):
    for lobes, lamp in ((NARROW, LARGE), (WIDE, SMALL)):
        points, directions, both = ways(lobes[name], lamp, monkeypatch)
        assert both.var() < points.var() + directions.var()
        assert both.var() < 0.02 * max(points.var(), directions.var())
