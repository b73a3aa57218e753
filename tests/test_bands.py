"""Any number of bands, computed as three are: what a band is called changes nothing."""

from dataclasses import replace

import numpy as np
import pytest

import radiosity
from radiosity.cli.probe import table
from radiosity.cli.solve import summary
from radiosity.light.bands import GREY, RGB, Bands
from radiosity.light.sources import Point
from radiosity.solve.adapt import Rounds
from radiosity.solve.plan import make_plan
from radiosity.solve.refinement import blame
from radiosity.solve.tradeoff import _by_clusters, make_reference
from radiosity.view.export import arrays, columns
from radiosity.view.window import show

ORDER = [0, 1, 2, 1, 0]  # bands of a scene, as bands of RGB
SHARE = np.array([0.5, 0.25, 1.0, 0.75, 0.5])  # of the light of that one which they carry
FIVE = Bands(
    ("r", "g", "b", "g2", "r2"), (RGB.rgb[:, ORDER] * SHARE), RGB.y[ORDER] * SHARE
)  # fmt: skip
EQUAL = 1e-12  # sums of the same terms in another order


def in_bands(scene, bands, order):
    def of(m):
        lobe = m.specular and replace(m.specular, reflectance=m.specular.reflectance[order])
        return replace(
            m, diffuse=m.diffuse[order], absorptance=m.absorptance[order],
            emission=m.emission[order], specular=lobe,
        )  # fmt: skip

    made = tuple(of(m) for m in scene.materials)
    lamps = tuple(x.of_intensity(x.strength[order]) for x in scene.lights)
    return replace(
        scene, materials=made, ambient=scene.ambient[order], lights=lamps, bands=bands, truth=None
    )  # fmt: skip


@pytest.fixture(scope="module", params=["box6.toml", "cornell_glossy.toml"])
def pair(request):
    """A scene solved in three bands and in five."""
    scene = radiosity.load(f"scenes/{request.param}")
    middle = scene.faces.vertices.mean(axis=(0, 1))
    lamp = Point(middle, scene.unit_m**-2 * np.array([0.3, 0.1, 0.2]))
    scene = replace(scene, ambient=np.array([0.1, 0.2, 0.3]), lights=(lamp,))
    return [
        radiosity.solve(s, 0.2, mesh="2", order=1) for s in (scene, in_bands(scene, FIVE, ORDER))
    ]


def test_bands_weigh_and_mix():
    assert GREY.luminance([2.0]) == 2.0
    assert GREY.to_rgb(np.array([[2.0]])).tolist() == [[2.0, 2.0, 2.0]]
    values = np.array([0.3, 0.2, 0.1])
    assert RGB.to_rgb(values) is values
    np.testing.assert_allclose(FIVE.to_rgb(values[ORDER]), values, rtol=EQUAL)


def test_five_bands_are_solved_as_three_are(pair):
    three, five = pair
    np.testing.assert_allclose(five.radiosity, three.radiosity[:, ORDER], rtol=EQUAL)
    np.testing.assert_allclose(five.illuminance, three.illuminance, rtol=EQUAL)
    assert five.estimate.reached == pytest.approx(three.estimate.reached, rel=1e-9)  # differences
    np.testing.assert_allclose(five.balance.emitted, three.balance.emitted[ORDER], rtol=EQUAL)


def test_pictures_and_points_are_the_same(pair):
    three, five = (radiosity.render(s, size=(16, 12), samples=16) for s in pair)
    np.testing.assert_allclose(five.pixels, three.pixels, rtol=1e-6)  # float32
    assert five.exposure == pytest.approx(three.exposure, rel=EQUAL)
    here = pair[0].patches.centroid[:5], pair[0].patches.normal[:5]
    rows = [
        table(np.concatenate(here, axis=1), *s.irradiance(*here), s.scene.bands).splitlines()
        for s in pair
    ]
    assert rows[0][0] == rows[1][0]
    three, five = (np.array([[float(x) for x in r.split(",")] for r in t[1:]]) for t in rows)
    np.testing.assert_allclose(five, three, rtol=1e-7, atol=1e-9)  # 8 digits are written


def test_windows_show_the_same(pair):
    three, five = (show(s, size=(32, 24), off_screen=True).astype(int) for s in pair)
    assert np.abs(five - three).max() <= 1  # a rounding of 8 bits


def test_files_name_the_bands(pair, tmp_path):
    five = pair[1]
    assert columns(RGB)[12:15] == ("emission_r_W_m2", "emission_g_W_m2", "emission_b_W_m2")
    radiosity.save(five, tmp_path / "five.csv")
    head = (tmp_path / "five.csv").read_text().splitlines()[0].split(",")
    assert len(head) == 12 + 3 * 5 + 2 and "radiosity_r2_W_m2" in head
    assert arrays(five)["bands"].tolist() == list(FIVE.names)
    assert arrays(five)["radiosity"].shape[1] == 5
    assert radiosity.to_pyvista(five).cell_data["radiosity_W_m2"].shape[1] == 5
    assert len(summary(five).splitlines()[4].split()) == 1 + 5


def test_clusters_and_goals_take_any_bands():
    scene = radiosity.load("scenes/box6.toml")
    lamp = Point(scene.faces.vertices.mean(axis=(0, 1)), np.array([0.3, 0.1, 0.2]))
    scene = replace(scene, lights=(lamp,))
    many = in_bands(scene, FIVE, ORDER)
    three, five = _by_clusters(scene, 0.3), _by_clusters(many, 0.3)
    np.testing.assert_allclose(five.radiosity, three.radiosity[:, ORDER], rtol=EQUAL)
    goal = np.array([[0.5, 0.5, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    (a, _), (b, _) = (radiosity.solve(s, 0.05, goal=goal).irradiance(*goal) for s in (scene, many))
    np.testing.assert_allclose(b, a[:, ORDER], rtol=EQUAL)
    assert make_reference(many, 0.1).error_of(five) == pytest.approx(
        make_reference(scene, 0.1).error_of(three), rel=1e-6  # differences of nearly equal numbers
    )  # fmt: skip


def test_cells_are_blamed_for_what_the_eye_sees():
    scene = radiosity.load("scenes/cornell_box.toml")
    found = []
    for one in (scene, in_bands(scene, FIVE, ORDER)):
        rounds = Rounds(one, make_plan(one, 0.05))
        rounds.advance()
        level, coarse, judged = rounds.level, rounds.check.level, rounds.estimate.judged
        found.append(blame(level, coarse, *judged))
    assert found[0].max() > 0.0
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)  # small differences of solutions


def test_one_band_is_a_column_of_grey():
    scene = in_bands(radiosity.load("scenes/box6.toml"), GREY, [1])
    solution = radiosity.solve(scene, 0.2, mesh="2")
    assert solution.radiosity.shape[1] == 1
    np.testing.assert_allclose(solution.illuminance, 683 * solution.irradiance_on[:, 0], rtol=EQUAL)
    image = radiosity.render(solution, size=(8, 6), samples=8)
    assert np.ptp(image.pixels, axis=2).max() == 0.0
    assert show(solution, size=(32, 24), off_screen=True).shape == (24, 32, 3)


def test_numbers_that_are_not_one_a_band_are_refused():
    scene = replace(radiosity.load("scenes/box6.toml"), bands=FIVE)
    with pytest.raises(
        radiosity.SceneError, match=r"diffuse has the shape \(3,\), must have \(5,\)"
    ):
        scene.check()
    assert radiosity.Scene("s", scene.faces, (), (), bands=FIVE).ambient.shape == (5,)
