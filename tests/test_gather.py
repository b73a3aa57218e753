"""The final gather: pictures with closed forms, determinism, progress and smoothing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import radiosity
from radiosity.analytic import point_to_parallel_rectangle
from radiosity.light.phong import Phong, phong_albedo
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Camera, Material, Scene
from radiosity.view.gather import LIGHT_RAYS, passes, radiance, render
from radiosity.view.shading import make_shading
from radiosity.view.smoothing import MIXED, smoothed

SCENES = Path(__file__).resolve().parent.parent / "scenes"


def material(name, diffuse, radiance=0.0, specular=None):
    rho = np.full(3, float(diffuse))
    return Material(name, rho, 1 - rho, np.full(3, float(radiance)), specular)


def scene_of(quads, materials, index, **more):
    index = np.array(index)
    faces = Faces(np.array(quads, float), index, index)
    place = (np.array(v, float) for v in ([0, 0, 1], [0, 0, 0], [0, 1, 0]))
    cameras = {"eye": Camera("eye", *place, 60, (8, 8))}
    return Scene("test", faces, materials, tuple(m.name for m in materials), cameras, **more)


FLOOR = [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]
LAMP = [[-0.5, -0.5, 2], [-0.5, 0.5, 2], [0.5, 0.5, 2], [0.5, -0.5, 2]]  # looks down


COUNT = 400  # points whose sample patterns differ


def reseeded(solution, seed):
    """Return the same solution with other sample patterns."""
    plan = replace(solution.plan, recipe=replace(solution.plan.recipe, seed=seed))
    return replace(solution, plan=plan)


@pytest.fixture(scope="module")
def lamp_over_floor():
    scene = scene_of([FLOOR, LAMP], (material("floor", 0.5), material("lamp", 0, 10)), [0, 1])
    return radiosity.solve(scene, 0.1)


def test_furnace_picture_is_the_same_everywhere():
    solution = radiosity.solve(radiosity.load(SCENES / "furnace.toml"), 0.1)
    pixels = render(solution, size=(20, 12), samples=16).pixels
    expected = np.array([1.25, 4.0, 2.5]) / np.pi
    np.testing.assert_allclose(pixels, np.broadcast_to(expected, pixels.shape), rtol=2e-6)


def test_direct_light_is_lambert_s_sum(lamp_over_floor):
    picture = render(lamp_over_floor, size=(1, 1), samples=8)
    # Straight below the lamp's middle, the eye's tiny field of view: four quarters of it.
    camera = replace(lamp_over_floor.scene.cameras["eye"], fov=0.01)
    picture = render(lamp_over_floor, camera, size=(1, 1), samples=8)
    irradiance = 4 * point_to_parallel_rectangle(0.5, 0.5, 2.0) * np.pi * 10
    np.testing.assert_allclose(picture.pixels[0, 0], 0.5 * irradiance / np.pi, rtol=1e-4)


def test_the_lamp_shows_its_radiance_and_its_back_is_passed_through(lamp_over_floor):
    up = replace(lamp_over_floor.scene.cameras["eye"], target=np.array([0, 0, 2.0]))
    assert render(lamp_over_floor, up, size=(1, 1), samples=8).pixels[0, 0, 0] == pytest.approx(10)
    above = replace(lamp_over_floor.scene.cameras["eye"], position=np.array([0, 0, 5.0]), fov=0.01)
    through = render(lamp_over_floor, above, size=(1, 1), samples=8).pixels[0, 0, 0]
    irradiance = 4 * point_to_parallel_rectangle(0.5, 0.5, 2.0) * np.pi * 10
    assert through == pytest.approx(0.5 * irradiance / np.pi, rel=1e-4)


def test_sight_lines_that_leave_show_the_ambient_light():
    scene = scene_of([FLOOR], (material("floor", 0.5),), [0], ambient=np.full(3, 2.0))
    solution = radiosity.solve(scene, 0.2)
    up = replace(scene.cameras["eye"], target=np.array([0, 0, 2.0]))
    np.testing.assert_allclose(render(solution, up, size=(4, 4), samples=8).pixels, 2.0, rtol=1e-6)
    down = render(solution, size=(4, 4), samples=8).pixels  # E = pi L: the floor sees only sky
    np.testing.assert_allclose(down, 0.5 * 2.0, rtol=1e-6)


@pytest.mark.parametrize("exponent", [1, 20])
def test_glossy_floor_under_uniform_light_returns_the_lobe_s_albedo(exponent):
    lobe = Phong(np.full(3, 0.4), exponent)
    scene = scene_of(
        [FLOOR], (material("gloss", 0.0, specular=lobe),), [0], ambient=np.full(3, 2.0)
    )
    solution = radiosity.solve(scene, 0.2)
    count = 2000
    for cosine in (1.0, 0.5):
        view = np.tile([np.sqrt(1 - cosine**2), 0, cosine], (count, 1))
        leaving, _, _ = radiance(
            solution, make_shading(solution), np.zeros(count, int), np.zeros((count, 3)), view,
            np.arange(count), 0,
        )  # fmt: skip
        expected = 0.4 * phong_albedo(exponent, cosine) * 2.0
        found = leaving[:, 0]
        error = found.std() / np.sqrt(count)  # of the mean of independent points
        assert abs(found.mean() - expected) < 4 * error + 1e-6 * expected


def test_a_small_lamp_s_highlight_is_the_lobe_times_its_irradiance():
    tiny = (np.array(LAMP) - [0, 0, 2]) * 0.01 + [1, 0, 2]
    lobe = Phong(np.full(3, 0.5), 30)
    scene = scene_of(
        [FLOOR, tiny], (material("floor", 0, specular=lobe), material("lamp", 0, 1000)), [0, 1]
    )
    solution = radiosity.solve(scene, 0.2)
    shading, view = make_shading(solution), np.tile([-1, 0, 2.0], (COUNT, 1)) / np.sqrt(5)
    row = np.full(COUNT, np.flatnonzero(solution.patches.face == 0)[0])
    at = np.zeros((COUNT, 3)), view, np.arange(COUNT), 0
    leaving, _, _ = radiance(solution, shading, row, *at)
    # Seen in the mirror direction: f = 0.5 (n + 2)/(2 pi), E = L A cos cos' / r^2.
    expected = 0.5 * 32 / (2 * np.pi) * 1000 * 1e-4 * (4 / 5) / 5
    noise = leaving[:, 0].std() / np.sqrt(COUNT)  # 1e-3: the lamp is 1/200 of its distance
    assert abs(leaving[:, 0].mean() - expected) < 4 * noise + 1e-3 * expected
    assert noise < 2e-3 * expected
    at = at[0], at[1] * [-1, 1, 1], *at[2:]
    off, _, _ = radiance(solution, shading, row, *at)
    assert off[:, 0].mean() < 1e-3 * expected


def test_pictures_are_repeatable_and_do_not_depend_on_threads(lamp_over_floor, monkeypatch):
    one = render(lamp_over_floor, size=(16, 16), samples=16).pixels
    monkeypatch.setenv("RADIOSITY_THREADS", "1")
    np.testing.assert_array_equal(render(lamp_over_floor, size=(16, 16), samples=16).pixels, one)
    other = reseeded(lamp_over_floor, 5)
    assert not np.array_equal(render(other, size=(16, 16), samples=16).pixels, one)


def test_passes_grow_into_the_rendered_picture(lamp_over_floor):
    grown = list(passes(lamp_over_floor, size=(16, 16), samples=24))
    final = render(lamp_over_floor, size=(16, 16), samples=24)
    assert len(grown) == 3
    np.testing.assert_array_equal(grown[-1].pixels, final.pixels)
    errors = [np.abs(p.pixels - final.pixels).mean() for p in grown]
    assert errors[0] > errors[1] > errors[2] == 0


def test_more_rays_bring_less_noise():
    solution = radiosity.solve(radiosity.load(SCENES / "cornell_box.toml"), 0.2)
    camera = replace(solution.scene.cameras["front"], target=np.array([278, 540, 300.0]), fov=5.0)
    fine = render(solution, camera, size=(12, 12), samples=4096).pixels
    other = reseeded(solution, 3)
    few, many = (
        np.abs(render(other, camera, size=(12, 12), samples=n).pixels - fine).mean()
        for n in (16, 256)
    )
    assert many < few / 2.5  # 16 times the rays: 4 times less, were it independent noise


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"camera": "nobody"}, "scene has 'eye'"),
        ({"size": (0, 4)}, "0x4"),
        ({"size": (4, 20000)}, "16384"),
        ({"samples": 0}, "samples = 0"),
    ],
)
def test_wrong_arguments_are_named(lamp_over_floor, options, words):
    with pytest.raises(ValueError, match=words):
        render(lamp_over_floor, **options)


def test_a_picture_beyond_the_memory_is_refused(lamp_over_floor, monkeypatch):
    monkeypatch.setattr("radiosity.solve.plan.free_memory", lambda: 1e9)
    with pytest.raises(radiosity.Refused, match="16384 x 16384 pixels need about 123.5 GB"):
        render(lamp_over_floor, size=(16384, 16384))


def pixels_on_a_plane(size=40):
    y, x = np.mgrid[:size, :size] * 1.0
    position = np.stack([x, y, np.zeros_like(x)], axis=-1)
    return position, np.zeros((size, size), int), np.array([[[1.0, 0, 0], [0, 1, 0]]])


def smooth(field, position, nearness, face, axes, spread=0.0, count=None):
    """Return `smoothed` of a field of one band whose pixels took 4 passes, and its errors."""
    count = np.full(face.shape, 4) if count is None else count
    spread = np.full(face.shape, spread)
    return smoothed(field, field[..., 0], spread, count, position, nearness, face, axes)


def test_smoothing_keeps_a_linear_field_exactly():
    position, face, axes = pixels_on_a_plane()
    field = (3 + 0.1 * position[..., 0] - 0.05 * position[..., 1])[..., None]
    near = np.full(face.shape, 0.05)
    found, error = smooth(field, position, near, face, axes)
    np.testing.assert_allclose(found, field, rtol=1e-10)
    assert np.all(error < 1e-6)  # nothing scatters about a plane


def test_smoothing_lowers_noise_within_the_reach_only():
    position, face, axes = pixels_on_a_plane()
    noise = 1 + 0.1 * np.random.default_rng(0).normal(size=(*face.shape, 1))
    wide, _ = smooth(noise, position, np.full(face.shape, 0.2 / 6), face, axes)
    assert wide[8:-8, 8:-8].std() < 0.1 / 5  # about 60 pixels are averaged
    narrow, _ = smooth(noise, position, np.full(face.shape, 1.0), face, axes)
    np.testing.assert_allclose(narrow, noise)  # nothing else lies within a fifth of a unit


def test_smoothing_stops_at_edges():
    position, face, axes = pixels_on_a_plane()
    face[:, 20:] = 1
    face[:, 30:] = MIXED
    field = np.where(face == 0, 1.0, 5.0)[..., None]
    field[:, 30:] = np.random.default_rng(1).random((40, 10, 1))
    out, _ = smooth(field, position, np.full(face.shape, 0.02), face, np.repeat(axes, 2, axis=0))
    np.testing.assert_allclose(out, field, rtol=1e-12)


def test_light_rays_of_a_pass_are_a_whole_net():
    assert LIGHT_RAYS & (LIGHT_RAYS - 1) == 0  # Sobol points are even in powers of two only


def test_passes_end_early_when_told_to(lamp_over_floor):
    seen = []
    for picture in passes(lamp_over_floor, size=(8, 8), samples=800, stop=lambda: len(seen) >= 2):
        seen.append(picture)
    assert len(seen) == 2


def test_faces_of_one_plane_and_material_are_smoothed_as_one():
    """The ceiling of the Cornell box is four faces round the lamp; walls stay apart."""
    solution = radiosity.solve(radiosity.load(SCENES / "cornell_box.toml"), 0.5)
    plane = make_shading(solution).plane
    scene = solution.scene
    group = np.array(scene.groups)[scene.faces.group[solution.patches.face]]
    assert len(np.unique(plane[group == "ceiling"])) == 1
    assert not set(plane[group == "light"]) & set(plane[group == "ceiling"])
    assert len(np.unique(plane[group == "tall_block"])) == 5


@pytest.mark.parametrize("uneven", [False, True])
def test_the_error_of_smoothed_light_is_its_scatter(uneven):
    """Pixels of n passes scatter by sigma^2/n; the bar is what the fit's values scatter by."""
    rng = np.random.default_rng(2)
    position, face, axes = pixels_on_a_plane()
    count = rng.choice([4, 64], face.shape) if uneven else np.full(face.shape, 4)
    near = np.full(face.shape, 0.2 / 6)
    found, bars = [], []
    for _ in range(40):
        noise = 1 + rng.normal(size=(*face.shape, 1)) / np.sqrt(count[..., None])
        value, error = smooth(noise, position, near, face, axes, 1.0, count)
        found.append(value[..., 0])
        bars.append(error)
    inside = np.s_[:, 8:-8, 8:-8]
    true = np.sqrt(np.mean((np.array(found)[inside] - 1) ** 2))
    assert np.sqrt(np.mean(np.array(bars)[inside] ** 2)) == pytest.approx(true, rel=0.05)


def test_passes_that_scatter_more_than_pixels_lengthen_the_bars_a_little():
    position, face, axes = pixels_on_a_plane()
    even, near = np.ones((*face.shape, 1)), np.full(face.shape, 0.2 / 6)
    assert np.all(smooth(even, position, near, face, axes)[1] == 0)
    error = smooth(even, position, near, face, axes, spread=1.0)[1][20, 20]
    alone = smooth(even, position, np.ones(face.shape), face, axes, spread=1.0)[1][20, 20]
    assert alone == pytest.approx(0.5)  # 4 passes of variance 1, and no neighbours
    assert 0 < error < 0.5 / 5
