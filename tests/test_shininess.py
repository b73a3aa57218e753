"""Shininess from a texture, against Blinn's formula in exact fractions and its integral."""

from fractions import Fraction

import numpy as np
import pytest

import radiosity
from radiosity.light.fresnel import reflectance
from radiosity.light.shininess import facets, spread
from radiosity.scene.model import SceneError
from radiosity.view.gather import radiance
from radiosity.view.shading import make_shading

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


def plate(tmp_path, keys="", facets="trowbridge-reitz"):
    """Return a plate whose facets a picture tells, from shiny to dull, under a lamp."""
    np.save(tmp_path / "t.npy", np.linspace(0, 1, 5)[None, :])
    text = f"""[[geometry]]
material = "m"
polygons = [[[0, 0, 0], [5, 0, 0], [5, 5, 0], [0, 5, 0]]]
uv = [[[0, 0], [1, 0], [1, 1], [0, 1]]]
[materials.m]
diffuse = 0.0
specular = {{ model = "torrance-sparrow", facets = "{facets}", ior = 1.5, roughness = \
{{ texture = "t.npy", minimum = 0.2{keys} }} }}
[[lights]]
type = "point"
position = [2, 1, 3]
intensity = [1, 2, 3]
"""
    (tmp_path / "plate.toml").write_text(text)
    return radiosity.load(tmp_path / "plate.toml")


def test_pictures_have_blinns_highlight_at_every_point(tmp_path):
    """L = D3/(pi c_min^2) F G/(4 N.L N.V) E of the lamp; nothing else is there to be reflected."""
    scene = plate(tmp_path)
    solution = radiosity.solve(scene, 0.1)
    points = np.array([[x, 2.5, 0.0] for x in (0.5, 1.5, 2.0, 2.5, 3.5, 4.5)])  # 2.0 is between
    eye = np.array([3.0, 4.0, 2.5]) - points
    view = eye / np.linalg.norm(eye, axis=1, keepdims=True)
    args = solution, make_shading(solution), np.zeros(6, int), points, view, np.arange(6), 0
    found = radiance(*args)[0]
    away = np.array([2.0, 1.0, 3.0]) - points
    d = np.linalg.norm(away, axis=1)
    light = away / d[:, None]
    half = (light + view) / np.linalg.norm(light + view, axis=1, keepdims=True)
    across = np.sum(light * half, axis=1)
    t = np.array([0, 0.25, 0.375, 0.5, 0.75, 1.0])
    lean = facets(half[:, 2], 0.2, t) / (np.pi * 0.2**2)
    up, down = light[:, 2], view[:, 2]
    groove = np.minimum(1, 2 * half[:, 2] * np.minimum(up, down) / across)
    f = lean * groove * reflectance(across, 1.5) / (4 * up * down)
    expected = (f * up / d**2)[:, None] * [1, 2, 3]
    np.testing.assert_allclose(found, expected, rtol=1e-6)  # texels are single precision


def test_the_solve_takes_the_mean(tmp_path):
    lobe = plate(tmp_path).materials[0].specular
    assert lobe.facets.roughness == pytest.approx(0.2 + 0.8 * 0.5)


@pytest.mark.parametrize(
    ("keys", "facets", "told"),
    [
        (", minimum = 0", "trowbridge-reitz", None),
        (", scale = 2", "trowbridge-reitz", "roughness.scale = 2 is not a known key here"),
        ("", "beckmann", 'specular.facets = "beckmann" cannot have their roughness from a texture'),
    ],
)
def test_mistakes_in_scene_files_are_told(tmp_path, keys, facets, told):
    with pytest.raises(SceneError) as error:
        plate(tmp_path, keys, facets)
    assert len(error.value.problems) == 1
    assert told is None or told in error.value.problems[0]


def test_texels_out_of_bounds_are_told(tmp_path):
    plate(tmp_path)
    np.save(tmp_path / "t.npy", np.array([[0.0, 1.5]]))
    with pytest.raises(SceneError, match=r"row 0, column 1: 1.5 must lie in \[0, 1\]: 0 is shiny"):
        radiosity.load(tmp_path / "plate.toml")


def test_a_raw_form_has_no_texture(tmp_path):
    with pytest.raises(SceneError) as error:
        plate(tmp_path, facets='trowbridge-reitz", convention = "seed')
    (problem,) = error.value.problems
    assert 'specular.convention = "seed" has one roughness only' in problem
