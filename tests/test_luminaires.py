"""Luminaires in scenes: read from files, seen at points, in mirrors and rooms, and by info."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_coherent import ONE
from test_mirrored_lights import glossy_floor
from test_photometric import ies

import radiosity
from radiosity.cli.info import describe
from radiosity.light.luminaire import Luminaire, frame_towards, of_values
from radiosity.light.photometry import illuminance
from radiosity.light.sources import Point
from radiosity.scene.model import SceneError
from radiosity.scene.photometric.luminaires import read_photometric

SCENES = Path(__file__).resolve().parent.parent / "scenes"
PLANES = np.array([0.0, 22.5, 45, 67.5, 90])
ANGLES = np.array([0.0, 5, 12, 30, 47, 62, 75, 90, 110, 140, 180])
VALUES = np.random.default_rng(5).uniform(20, 900, (5, 11))
VALUES[:, [0, -1]] = 400.0, 90.0
HEAD = "IESNA:LM-63-1995", "[MANUFAC] Zürich Lights"
TEXT = ies(PLANES, VALUES, ANGLES, HEAD, "2 1500 1.25 11 5 1 1 0.1 0.2 0\n0.95 1 40")
BOX = """
[[geometry]]
material = "black"
polygons = [[[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]]
[materials.black]
diffuse = 0.0
"""
ABOVE = "position = [0.4, -0.3, 2.2]\ntarget = [0.4, -0.3, 0]"


def scene_file(folder, *lights, geometry=BOX, top=""):
    """Write a scene, and the photometric file that it names, in Latin-1 as makers do."""
    (folder / "lamp.ies").write_bytes(TEXT.encode("latin-1"))
    tables = [f'[[lights]]\ntype = "ies"\nfile = "lamp.ies"\n{light}\n' for light in lights]
    (folder / "room.toml").write_text(top + geometry + "".join(tables))
    return folder / "room.toml"


def intensity(direction):
    """Return candela in a direction from a luminaire that hangs, read and interpolated by loops.

    The file's values are multiplied by 1.25 and 0.95; its planes cover a quarter.
    """
    words = TEXT.split("TILT=NONE")[1].split()
    numbers = [float(word) for word in words]
    assert numbers[3:5] == [11, 5] and numbers[2] * numbers[10] == 1.25 * 0.95
    angles, planes, values = numbers[13:24], numbers[24:29], numbers[29:]
    gamma = np.degrees(np.arctan2(np.hypot(direction[0], direction[1]), -direction[2]))
    c = np.degrees(np.arctan2(abs(direction[1]), abs(direction[0])))
    i = max(k for k in range(4) if planes[k] <= c)
    j = max(k for k in range(10) if angles[k] <= gamma)
    s = (c - planes[i]) / (planes[i + 1] - planes[i])
    t = (gamma - angles[j]) / (angles[j + 1] - angles[j])

    def row(k):
        return values[11 * k + j] + t * (values[11 * k + j + 1] - values[11 * k + j])

    return 1.25 * 0.95 * (row(i) + s * (row(i + 1) - row(i)))


def points_about(count, rng):
    """Return points in a slab under the luminaire, and normals that are turned to it."""
    points = rng.uniform([-3, -3, 0], [3, 3, 1.2], (count, 3))
    points[: count // 2, 2] = 0.0
    normals = rng.normal(size=(count, 3)) + [0, 0, 3]
    normals[: count // 2] = 0, 0, 1
    return points, normals / np.linalg.norm(normals, axis=1)[:, None]


def test_probes_find_intensity_times_cosine_over_square_of_distance(tmp_path):
    scene = radiosity.load(scene_file(tmp_path, ABOVE))
    points, normals = points_about(20, np.random.default_rng(2))
    solution = radiosity.solve(scene, 0.2)
    found = illuminance(solution.irradiance(points, normals)[0])
    for k in range(20):
        way = points[k] - [0.4, -0.3, 2.2]
        d = np.linalg.norm(way)
        cosine = max(0.0, -(way / d) @ normals[k])
        assert found[k] == pytest.approx(intensity(way / d) * cosine / d**2, rel=1e-6)


WAYS_UP = [("y", [0, 2, 1], [1, 1, -1]), ("x", [2, 0, 1], 1)]


@pytest.mark.parametrize(("up", "order", "sign"), WAYS_UP)
def test_scenes_of_another_way_up_see_the_same(tmp_path, up, order, sign):
    """Up along y: what lay along y lies along -z. Up along x: x, y and z are y, z and x."""

    def put(x):
        return np.asarray(x, float)[..., order] * sign

    points, normals = points_about(12, np.random.default_rng(3))
    here = radiosity.solve(radiosity.load(scene_file(tmp_path, ABOVE)), 0.2)
    floor = [[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]
    assert str(floor) in BOX
    tall = BOX.replace(str(floor), str(put(floor).tolist()))
    ends = put([0.4, -0.3, 2.2]).tolist(), put([0.4, -0.3, 0]).tolist()
    light = f"position = {ends[0]}\ntarget = {ends[1]}"
    there = radiosity.load(scene_file(tmp_path, light, geometry=tall, top=f'up = "{up}"\n'))
    found = radiosity.solve(there, 0.2).irradiance(put(points), put(normals))[0]
    np.testing.assert_allclose(found, here.irradiance(points, normals)[0], rtol=1e-9)


def test_rolled_by_a_right_angle_x_goes_to_y(tmp_path):
    points, normals = points_about(12, np.random.default_rng(3))
    here = radiosity.solve(radiosity.load(scene_file(tmp_path, ABOVE)), 0.2)
    expected = here.irradiance(points, normals)[0]
    light = "position = [0.3, 0.4, 2.2]\ntarget = [0.3, 0.4, -1]\nroll = 90"
    rolled = radiosity.solve(radiosity.load(scene_file(tmp_path, light)), 0.2)
    found = rolled.irradiance(
        points[:, [1, 0, 2]] * [-1, 1, 1], normals[:, [1, 0, 2]] * [-1, 1, 1]
    )[0]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_mirror_shows_the_luminaire_turned_over(tmp_path):
    """The floor is lit by the luminaire and by its image, k_r times, behind the wall x = 3."""
    wall = """[[geometry]]
material = "mirror"
polygons = [[[3, -9, 0], [3, -9, 9], [3, 9, 9], [3, 9, 0]]]
[materials.mirror]
diffuse = 0
mirror = 0.8
"""
    light = "position = [1.5, 0.2, 2]\ntarget = [2.5, 0.9, 0.4]\nroll = 20"
    mirrored = radiosity.load(scene_file(tmp_path, light, geometry=BOX + wall))
    bare = radiosity.load(scene_file(tmp_path, light))
    points = np.array([[2.0, -1, 0], [0, 0, 0], [2.9, 0.3, 0], [1, 2, 0]])
    up = np.tile([0.0, 0, 1], (4, 1))
    found = radiosity.solve(mirrored, 0.2).irradiance(points, up)[0]
    lamp = bare.lights[0]
    image = lamp.moved(np.diag([-1.0, 1, 1]), np.array([6.0, 0, 0]))
    expected = 0.0
    for one, share in ((lamp, 1.0), (image, 0.8)):
        to_light, _, falling = one.reaching(points, 1.0)
        expected = expected + share * falling * to_light[:, 2:]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert np.all(found > 1.01 * radiosity.solve(bare, 0.2).irradiance(points, up)[0])


def test_an_even_luminaire_is_a_point_to_every_pass(tmp_path):
    """On gloss, in a mirror, and with every method of making pictures, to the bit."""
    even = of_values(np.array([0.0, 360]), np.array([0.0, 180]), np.ones((2, 2)))[0]
    place, frame = np.array([0.5, 0.2, 1.0]), frame_towards(np.array([0.0, 0.6, -0.8]), 0.3)
    lamps = Point(place, ONE), Luminaire(place, ONE, frame=frame, distribution=even)
    one, other = (glossy_floor((lamp,)) for lamp in lamps)
    for method in ("raytrace", "local"):
        a, b = (radiosity.render(s, samples=4, method=method).pixels for s in (one, other))
        assert a.any() and np.array_equal(a, b), method
    a, b = (radiosity.render(radiosity.solve(s, 0.2), samples=4).pixels for s in (one, other))
    assert a.any() and np.array_equal(a, b)


def test_a_closed_room_takes_in_the_flux(tmp_path):
    """What walls of reflectance 0.5 absorb is what the luminaire sends out, its flux / 683 W."""
    room = """[[geometry]]
material = "grey"
polygons = [[[-3,-3,0],[3,-3,0],[3,3,0],[-3,3,0]], [[-3,-3,3],[-3,3,3],[3,3,3],[3,-3,3]],
[[-3,-3,0],[-3,-3,3],[3,-3,3],[3,-3,0]], [[-3,3,0],[3,3,0],[3,3,3],[-3,3,3]],
[[-3,-3,0],[-3,3,0],[-3,3,3],[-3,-3,3]], [[3,-3,0],[3,-3,3],[3,3,3],[3,3,0]]]
[materials.grey]
diffuse = 0.5
"""
    scene = radiosity.load(scene_file(tmp_path, ABOVE, geometry=room))
    solution = radiosity.solve(scene, 0.1, order=0)
    absorbed = 683 * 0.5 * solution.irradiance_on[:, 0] @ solution.patches.area
    flux = read_photometric(TEXT, "lamp.ies").flux
    assert absorbed == pytest.approx(flux, rel=2e-3)
    assert solution.closed


def test_a_flux_asked_for_scales_the_file(tmp_path):
    both = radiosity.load(scene_file(tmp_path, ABOVE, ABOVE + "\nluminous_flux = 5000"))
    one, other = both.lights
    assert other.intensity[0] * other.solid_angle * 683 == pytest.approx(5000, rel=1e-12)
    assert one.distribution is other.distribution
    assert one.intensity[0] * 683 == pytest.approx(VALUES.max() * 1.25 * 0.95, rel=1e-8)
    aimed = ABOVE.replace("0.4, -0.3, 0]", "2, 1, 0]") + '\ngroup = "spots"\nroll = 30'
    (lamp,) = radiosity.load(scene_file(tmp_path, aimed)).lights
    axis = np.array([1.6, 1.3, -2.2]) / np.linalg.norm([1.6, 1.3, -2.2])
    np.testing.assert_allclose(lamp.frame, frame_towards(axis, np.pi / 6), atol=1e-12)
    assert isinstance(lamp, Luminaire) and lamp.group == "spots"


def test_spectral_and_grey_scenes_are_as_bright(tmp_path):
    path = scene_file(tmp_path, ABOVE)
    rgb, grey, spectral = (radiosity.load(path, bands=b) for b in ("rgb", "grey", "spectral"))
    for scene in (rgb, grey, spectral):
        cd = 683 * scene.bands.luminance(scene.lights[0].intensity)
        assert cd == pytest.approx(VALUES.max() * 1.25 * 0.95, rel=1e-6)
    assert grey.bands.count == 1 and spectral.bands.count > 3


def test_info_says_what_was_read(tmp_path):
    text = describe(radiosity.load(scene_file(tmp_path, ABOVE)))
    flux = read_photometric(TEXT, "lamp.ies").flux
    assert "read as lamp.ies, LM-63-1995: Zürich Lights" in text
    assert f"at most {VALUES.max() * 1.25 * 0.95:.6g} cd, {flux:.6g} lm in all" in text


def test_openings_too_wide_for_a_point_and_odd_fluxes_are_noted(tmp_path):
    scene = radiosity.load(scene_file(tmp_path, ABOVE, ABOVE))
    flux, lamps = read_photometric(TEXT, "lamp.ies").flux, 2 * 1500 * 0.95
    (told,) = [n for n in scene.notes if n.startswith("lamp.ies")]  # 0.06 m over 2.2 m: no more
    assert told.startswith(f"lamp.ies: sends out {flux:.6g} lm of the {lamps:.6g} lm")
    low = [f"position = [{x}, 0, 0.2]\ntarget = [{x}, 0, 0]" for x in (1, 2)]
    (told,) = [n for n in radiosity.load(scene_file(tmp_path, *low)).notes if "a point" in n]
    assert "lights surfaces 0.2 m away" in told and "opening is 0.061 m wide" in told
    behind = "position = [1, 0, 0.0]\ntarget = [1, 0, 1]"  # mounted on the floor, lighting up
    down = [n for n in radiosity.load(scene_file(tmp_path, behind)).notes if "a point" in n]
    assert down == []


WRONG = [
    ('file = "lamp.txt"', 'lights[0].file = "lamp.txt" must name a photometric file, "NAME.ies"'),
    ("file = 3", "lights[0].file = 3 must name a photometric file"),
    ('file = "lmap.ies"', 'lights[0].file = "lmap.ies" does not exist: did you mean lamp.ies?'),
    ('file = "../lamp.ies"', 'lights[0].file = "../lamp.ies" lies outside the scene\'s folder'),
    ('file = "bad.ies"', 'lights[0].file = "bad.ies" line 3: the file ends before the lumens'),
    ('file = "lamp.ies"\nroll = 400', "lights[0].roll = 400 must lie in [-360, 360]"),
    ('file = "lamp.ies"\nluminous_flux = -1', "lights[0].luminous_flux = -1 must be at least 0"),
    ('file = "lamp.ies"\nintensity = 1', "lights[0].intensity is not a known key here"),
    ("", "lights[0].file is missing: a photometric file"),
]  # fmt: skip


@pytest.mark.parametrize(("keys", "told"), WRONG, ids=[told[:45] for _, told in WRONG])
def test_wrong_luminaires_are_refused(tmp_path, keys, told):
    path = scene_file(tmp_path)
    (tmp_path / "bad.ies").write_text("IESNA91\nTILT=NONE\n1\n")
    path.write_text(BOX + f'[[lights]]\ntype = "ies"\n{ABOVE}\n{keys}\n')
    with pytest.raises(SceneError) as error:
        radiosity.load(path)
    assert len(error.value.problems) == 1 and error.value.problems[0].startswith(told)


def test_a_target_at_the_luminaire_gives_no_axis(tmp_path):
    path = scene_file(tmp_path, "position = [1, 2, 3]\ntarget = [1, 2, 3]")
    with pytest.raises(SceneError, match=r"lights\[0\].target = \[1, 2, 3\] must differ"):
        radiosity.load(path)


def test_scenes_without_luminaires_load_none_of_it():
    code = (
        "import sys, json, radiosity; radiosity.solve(radiosity.load('scenes/point_spot.toml'), "
        "0.3); print(json.dumps([m for m in sys.modules if m.startswith('radiosity')]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=SCENES.parent
    )
    loaded = set(json.loads(done.stdout))
    assert "radiosity.light.sources" in loaded
    names = "ies", "eulumdat", "photometric", "luminaires"
    readers = {f"radiosity.scene.photometric.{m}" for m in names}
    assert not loaded & {"radiosity.light.luminaire", *readers}


@pytest.mark.parametrize(
    ("name", "stated"), [("erco_iku.ldt", 611.9), ("waldmann_idoo.ldt", 7000)]
)
def test_fluxes_of_makers_files_are_those_they_state(name, stated):
    text = (SCENES / "luminaires" / name).read_text("utf-8-sig")
    found = read_photometric(text, name)
    assert found.stated == pytest.approx(stated) and found.notes == ()
    assert found.flux == pytest.approx(stated, rel=1e-3)  # 5e-5 and 5e-4: tables of few digits


def test_the_office_is_lit_by_its_makers_files():
    """Below a downlight the desk gets I_0/d^2 from it, and from the other I cos^3/h^2 more.

    The value of gamma = 0, and those of 32 and 33 degrees, stand in the file in cd/klm.
    """
    scene = radiosity.load(SCENES / "office.toml")
    assert [light.group for light in scene.lights] == ["desk", "desk", "floor"]
    text = (SCENES / "luminaires" / "erco_iku.ldt").read_text("utf-8-sig").split("\n")
    values = 0.6119 * np.array([float(v) for v in text[42 + 1 + 91 :][:91]])
    h = 2.6 - 0.74
    angle = np.degrees(np.arctan2(1.2, h))
    aside = np.interp(angle, np.arange(91), values) * np.cos(np.radians(angle)) ** 3
    expected = (values[0] + aside) / h**2
    point, found = np.array([[3.4, 2.75, 0.74]]), 0.0
    for lamp in scene.lights[:2]:
        to_light, _, falling = lamp.reaching(point, 1.0)
        found += illuminance(falling)[0] * to_light[0, 2]
    assert found == pytest.approx(expected, rel=1e-6)
