"""Errors of pictures: estimated honestly, and met by spending passes where they are large."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_gather import FLOOR, LAMP, material, reseeded, scene_of

import radiosity
from radiosity.light.bands import RGB
from radiosity.light.photometry import luminance
from radiosity.view.effort import DARKEST, even_enough, worth_more
from radiosity.view.film import Developed, Film
from radiosity.view.gather import passes, render
from radiosity.view.shading import make_shading

SCENES = Path(__file__).resolve().parent.parent / "scenes"
NAMES = ["cornell_box", "lroom", "point_spot", "cornell_glossy"]
SIZE = (32, 32)


@pytest.fixture(scope="module")
def solved():
    return {n: radiosity.solve(radiosity.load(SCENES / f"{n}.toml"), 0.1) for n in NAMES}


@pytest.fixture(scope="module")
def fine(solved):
    return {n: render(reseeded(s, 9), size=SIZE, samples=2048) for n, s in solved.items()}


def bright(picture):
    return luminance(picture.pixels.astype(float))


@pytest.mark.parametrize("samples", [64, 256, None])  # 8 passes or more: 4 are too few to tell
def test_error_bars_cover_and_are_not_too_long(solved, fine, samples):
    covered = []
    for name, solution in solved.items():
        found, truth = render(solution, size=SIZE, samples=samples), fine[name]
        error, bar = np.abs(bright(found) - bright(truth)), found.error
        covered.append(error <= 2 * np.hypot(bar, truth.error) + 1e-7 * bright(truth))
        # Of lamps' edges, which are far brighter, apart: a few pixels would be all there is.
        plain = truth.lamp[..., 3] == 0 if truth.lamp is not None else np.ones(error.shape, bool)
        if samples is not None:  # else the few errors left are the reference's
            assert np.sqrt(np.mean(bar[plain] ** 2)) <= 5 * np.sqrt(np.mean(error[plain] ** 2))
        assert np.sqrt(np.mean(bar[plain] ** 2)) > 0
    assert np.mean(covered) >= 0.95


def test_noise_is_the_rms_of_the_errors(fine):
    picture = fine["cornell_box"]
    plain = picture.lamp[..., 3] == 0
    error = np.sqrt(np.mean(picture.error[plain] ** 2.0)) / bright(picture)[plain].mean()
    assert picture.noise == pytest.approx(error, rel=1e-6)
    assert 0 < picture.noise < 0.02


def test_edges_of_a_lamp_are_worth_more_passes(solved):
    solution = solved["cornell_box"]
    even, best = render(solution, size=SIZE, samples=64), render(solution, size=SIZE)
    edge = (best.lamp[..., 3] > 0) & (best.lamp[..., 3] < 1)
    assert edge.sum() >= 4
    assert best.error[edge].max() < 0.3 * even.error[edge].max()  # of 256 passes and of 8


def test_pictures_of_uneven_passes_are_unbiased(solved, fine):
    """The mean over seeds is that of the fine picture, though errors choose the passes."""
    for name in ("cornell_box", "cornell_glossy"):
        runs = np.array([bright(render(reseeded(solved[name], k), size=SIZE)) for k in range(12)])
        plain = fine[name].lamp[..., 3] == 0
        means, truth = runs[:, plain].mean(axis=1), bright(fine[name])[plain].mean()
        error = np.hypot(means.std(ddof=1) / np.sqrt(12), 2e-4 * truth)  # and of the reference
        assert abs(means.mean() - truth) < 3 * error


def test_a_finer_solution_makes_a_finer_picture(solved):
    solution = solved["lroom"]
    coarse, finer = (
        render(replace(solution, plan=replace(solution.plan, accuracy=a)), size=SIZE).noise
        for a in (0.1, 0.005)
    )
    assert finer < 0.005 < coarse < 0.1


def test_uneven_pictures_do_not_depend_on_threads(solved, monkeypatch):
    solution = solved["cornell_glossy"]
    two = render(solution, size=SIZE)
    monkeypatch.setenv("RADIOSITY_THREADS", "1")
    one = render(solution, size=SIZE)
    for name in ("pixels", "error", "lamp"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def test_the_last_of_growing_pictures_is_the_rendered_one(solved):
    *_, before, last = passes(solved["cornell_box"], size=SIZE)
    final = render(solved["cornell_box"], size=SIZE)
    np.testing.assert_array_equal(last.pixels, final.pixels)
    assert last.noise < before.noise


def film_and_picture(error):
    """Return a film of one face, 6 x 6, and a picture of luminance 1 with some errors."""
    film = Film.blank(6, 6, RGB)
    film.face[:] = 0
    return film, Developed(np.ones((6, 6, 3)), error, None)


def test_pixels_with_errors_and_their_neighbours_are_worth_more():
    error = np.full((6, 6), 0.01)
    error[2, 2], error[5, 5] = 0.3, 0.2
    film, picture = film_and_picture(error)
    every = np.arange(36)
    near = {6 * y + x for y in (1, 2, 3) for x in (1, 2, 3)}
    found = worth_more(film, every, picture, 0.02, 36)
    assert set(found) == near | {28, 29, 34, 35}
    assert set(worth_more(film, every, picture, 0.02, 9)) == near  # the largest errors first
    assert set(worth_more(film, found[:4], picture, 0.02, 9)) == set(found[:4])
    assert not len(worth_more(film, every, picture, 0.4, 36))


def test_the_dark_need_not_be_known_better_than_a_tenth_of_the_mean():
    film, picture = film_and_picture(np.full((6, 6), 0.001))
    picture.radiance[:3] = 1e-6
    dark = 0.02 * DARKEST * 0.5  # allowed where the mean is 0.5
    picture.error[:] = 0.9 * dark
    assert not len(worth_more(film, np.arange(36), picture, 0.02, 36))
    picture.error[:] = 1.1 * dark
    assert worth_more(film, np.arange(36), picture, 0.02, 36).max() < 24  # with their neighbours


def test_passes_go_on_until_faces_are_even():
    film, picture = film_and_picture(np.full((6, 6), 0.015))
    assert even_enough(film, picture, 0.02) and not even_enough(film, picture, 0.01)
    picture.error[0, 0] = 1.0
    film.face[0] = -1  # an edge: rounds see to it
    assert even_enough(film, picture, 0.02)


def test_one_pass_has_no_error():
    scene = scene_of([FLOOR, LAMP], (material("floor", 0.5), material("lamp", 0, 10)), [0, 1])
    picture = render(radiosity.solve(scene, 0.2), size=(4, 4), samples=8)
    assert picture.error is None and picture.noise is None


def test_plain_scenes_keep_no_lamps():
    solution = radiosity.solve(radiosity.load(SCENES / "point_spot.toml"), 0.3)
    assert not make_shading(solution).emission.any()
    assert render(solution, size=(4, 4), samples=16).lamp is None
