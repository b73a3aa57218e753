"""Abstract light sources of scene files: what is read, and one problem for each mistake."""

import numpy as np
import pytest

from radiosity.light.sources import Directional, Falloff, Flood, Spot
from radiosity.scene.model import SceneError
from radiosity.scene.toml import read_toml

FLOOR = """[[geometry]]
material = "m"
polygons = [[[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]]
[materials.m]
diffuse = 0.5
[cameras.c]
position = [0, 0, 5]
target = [0, 1, 0]
"""


def read(*lights):
    text = FLOOR + "".join(f"[[lights]]\n{keys}\n" for keys in lights)
    return read_toml(text, "x.toml", lambda name: None, "x")


def problems(*lights):
    with pytest.raises(SceneError) as error:
        read(*lights)
    return error.value.problems


def placed(kind, *keys):
    return "\n".join([f'type = "{kind}"', "position = [0, 0, 2]", *keys])


TO, BEAM = "target = [0, 3, -2]", "beam_angle = 25\ncutoff_angle = 35"


def test_every_kind_is_read_with_its_keys():
    scene = read(
        placed("point", "intensity = [1, 2, 3]", 'group = "lamps"'),
        placed("spot", "intensity = 4", TO, BEAM),
        placed("flood", "intensity = 5", TO, "exponent = 2.5"),
        'type = "directional"\ndirection = [0, 3, -4]\nirradiance = 6',
        'type = "ambient"\nradiance = [0.1, 0.2, 0.3]',
        'type = "ambient"\nradiance = 1',
    )
    point, spot, flood, sun = scene.lights
    assert point.intensity.tolist() == [1, 2, 3] and point.group == "lamps"
    assert point.position.tolist() == [0, 0, 2] and point.falloff == Falloff(1, 0, 2)
    assert isinstance(spot, Spot) and spot.intensity.tolist() == [4, 4, 4]
    np.testing.assert_allclose(spot.axis, [0, 0.6, -0.8])
    np.testing.assert_allclose([spot.beam, spot.cutoff], np.radians([25, 35]))
    assert isinstance(flood, Flood) and flood.exponent == 2.5
    assert isinstance(sun, Directional) and sun.irradiance.tolist() == [6, 6, 6]
    np.testing.assert_allclose(sun.direction, [0, 0.6, -0.8])
    np.testing.assert_allclose(scene.ambient, [1.1, 1.2, 1.3])
    assert scene.has_light and not read().has_light


@pytest.mark.parametrize(
    ("kind", "keys", "solid_angle"),
    [
        ("point", "", 4 * np.pi),
        ("flood", "exponent = 3", 2 * np.pi / 4),
        ("spot", BEAM, 0.84869102),  # 2 pi (1 - (sin 35 - sin 25)/(10 degrees in radians))
    ],
)
def test_strength_by_each_of_four_quantities(kind, keys, solid_angle):
    """Flux is intensity times solid angle; neutral light of 683 lm has 1 W in every band."""
    keys = [keys, *([TO] if kind != "point" else [])]
    for strength, expected in (
        ("intensity = [1, 2, 3]", [1, 2, 3]),
        ("luminous_intensity = 1366", [2, 2, 2]),
        ("radiant_flux = [1, 2, 3]", np.array([1, 2, 3]) / solid_angle),
        ("luminous_flux = 683", np.ones(3) / solid_angle),
    ):
        (light,) = read(placed(kind, strength, *keys)).lights
        np.testing.assert_allclose(light.intensity, expected, rtol=1e-6)  # digits of the above


def test_falloff_of_the_seed():
    (light,) = read(placed("point", "intensity = 1", "falloff = { a = 0.5, b = 1, m = 1 }")).lights
    assert light.falloff == Falloff(0.5, 1.0, 1.0)


WRONG = [
    ("intensity = 1", "lights[0].type is missing: one of point, spot"),
    ('type = "sopt"', 'lights[0].type = "sopt" is no kind of light: did you mean spot?'),
    ("type = 3", "lights[0].type = 3 must be one of point, spot"),
    (placed("point"), "lights[0] gives no strength: give one of intensity, luminous_intensity"),
    (placed("point", "intensity = 1", "radiant_flux = 2"),
     "lights[0] gives intensity and radiant_flux: give one of"),
    (placed("point", "intensity = -1"),
     "lights[0].intensity = -1 must be at least 0: light cannot be taken away"),
    (placed("point", "intensity = 1", "cutoff = 3"), "lights[0].cutoff is not a known key here"),
    (placed("spot", "intensity = 1", BEAM), "lights[0].target is missing: the point that its axis"),
    (placed("spot", "intensity = 1", "target = [0, 0, 2]", BEAM),
     "lights[0].target = [0, 0, 2] must differ from position: it gives the axis"),
    (placed("spot", "intensity = 1", TO, "beam_angle = 25\ncutoff_angle = 20"),
     "lights[0].cutoff_angle = 20 must be at least the beam_angle 25"),
    (placed("spot", "intensity = 1", TO, "beam_angle = 0\ncutoff_angle = 0"),
     "lights[0].cutoff_angle = 0 must be at least 0.0001: no light leaves"),
    (placed("spot", "intensity = 1", TO, "beam_angle = 25\ncutoff_angle = 200"),
     "lights[0].cutoff_angle = 200 must lie in [0, 180]: a half angle in degrees"),
    (placed("flood", "intensity = 1", TO, "exponent = -1"),
     "lights[0].exponent = -1 must be at least 0: intensity falls as cos^exponent"),
    (placed("point", "radiant_flux = 1", "falloff = { a = 1, m = 1 }"),
     "lights[0] gives radiant_flux and falloff: only light that falls off as 1/d^2 has a flux"),
    (placed("point", "intensity = 1", "falloff = { a = 0 }"),
     "lights[0].falloff has a = 0 and b = 0"),
    ('type = "directional"\ndirection = [0, 0, 0]\nirradiance = 1',
     "lights[0].direction = [0, 0, 0] must not be zero: it is a direction"),
    ('type = "directional"\ndirection = [0, 0, 1]', "lights[0].irradiance is missing"),
    ('type = "ambient"', "lights[0].radiance is missing"),
]  # fmt: skip


@pytest.mark.parametrize(("keys", "told"), WRONG, ids=[told[:60] for _, told in WRONG])
def test_one_mistake_gives_one_problem_with_where_value_and_bound(keys, told):
    found = problems(keys)
    assert len(found) == 1 and found[0].startswith(told), found


def test_mistakes_of_all_lights_are_told_at_once():
    found = problems('type = "sopt"', placed("point"), 'type = "ambient"')
    assert [f[:9] for f in found] == ["lights[0]", "lights[1]", "lights[2]"]


def test_lights_that_are_no_list_of_tables():
    for text in ("lights = 3\n", "lights = [3]\n", "[lights]\na = 1\n"):
        with pytest.raises(SceneError, match="lights"):
            read_toml(text + FLOOR, "x.toml", lambda name: None, "x")


def test_scenes_made_in_code_are_checked():
    scene = read(placed("point", "intensity = [1, 2, 3]"))
    scene.lights[0].intensity[1] = np.nan
    with pytest.raises(SceneError, match=r"lights\[0\]\[1\] = nan must be at least 0 and finite"):
        scene.check()
