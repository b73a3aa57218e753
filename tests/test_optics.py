"""Optics of materials: keys of the scene file, what is refused, what the solve and pictures do."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import radiosity
from radiosity.cli.info import describe
from radiosity.light import coherent, fresnel
from radiosity.light.blinn import Blinn
from radiosity.light.facets import Beckmann, Gaussian, TrowbridgeReitz
from radiosity.light.metals import metal_bands
from radiosity.light.seed_forms import SeedForm
from radiosity.light.shadowing import smith, v_groove
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.scene.model import Material, Scene, SceneError
from radiosity.scene.toml import read_toml
from radiosity.solve.albedo import reflectance_of, sent_on
from radiosity.solve.plan import make_plan
from radiosity.solve.requirements import foresee
from radiosity.view.gather import radiance
from radiosity.view.shading import make_shading

FLOOR = """[[geometry]]
material = "m"
polygons = [[[-50, -50, 0], [50, -50, 0], [50, 50, 0], [-50, 50, 0]]]
[materials.m]
"""


def read(text):
    return read_toml(FLOOR + text, "optics.toml", None)


def made(text):
    return read(text).materials[0]


def facets(**keys):
    inner = ", ".join(f"{k} = {v}" for k, v in keys.items())
    return f'specular = {{ model = "torrance-sparrow", {inner} }}\n'


def told(text):
    with pytest.raises(SceneError) as caught:
        read(text)
    return caught.value.problems


def test_keys_of_torrance_sparrow():
    lobe = made(facets(roughness=0.2)).specular
    assert isinstance(lobe, TorranceSparrow) and lobe.facets == TrowbridgeReitz(0.2)
    assert lobe.shadowing is v_groove and lobe.index is None and not lobe.dielectric
    assert lobe.reflectance.tolist() == [1, 1, 1]
    lobe = made(facets(facets='"gaussian"', half_angle=15, shadowing='"smith"', ior=1.5,
                       reflectance="[0.5, 1, 1]")).specular  # fmt: skip
    assert lobe.facets == Gaussian.of_half_angle(15) and lobe.shadowing is smith
    assert lobe.index.tolist() == [1.5] and lobe.dielectric
    assert lobe.reflectance.tolist() == [0.5, 1, 1]
    lobe = made(facets(facets='"beckmann"', roughness=1, ior="[1.4, 1.5, 1.6]")).specular
    assert lobe.facets == Beckmann(1.0) and lobe.index.tolist() == [1.4, 1.5, 1.6]
    lobe = made(facets(roughness=0.3, metal='"gold"')).specular
    assert np.array_equal(lobe.index, metal_bands("gold")) and not lobe.dielectric


def test_keys_of_blinn_mirror_and_transmission():
    lobe = made('specular = { model = "blinn", reflectance = 0.4, exponent = 20 }').specular
    assert (
        isinstance(lobe, Blinn) and lobe.exponent == 20 and lobe.reflectance.tolist() == [0.4] * 3
    )
    clear = made('mirror = "fresnel"\ntransmit = "fresnel"\nior = 1.5')
    assert isinstance(clear.mirror, coherent.FresnelMirror)
    assert isinstance(clear.transmit, coherent.FresnelPassage)
    assert clear.diffuse.tolist() == [0, 0, 0] and clear.coats == (clear.mirror,)
    half = made("mirror = [0.5, 0.4, 0.3]\ntransmit = 0.5\nior = 1.3")
    assert half.mirror.share.tolist() == [0.5, 0.4, 0.3] and half.coats == ()
    assert half.transmit.index.tolist() == [1.3]
    silver = made('mirror = "fresnel"\nmetal = "silver"')
    assert np.array_equal(silver.mirror.index, metal_bands("silver"))
    none = made("mirror = 0\ntransmit = 0.0")
    assert none.mirror is None and none.transmit is None and none.specular is None
    assert none.diffuse.tolist() == [0.5, 0.5, 0.5]


def test_the_optics_of_the_manual_are_right():
    text = (Path(__file__).resolve().parent.parent / "docs" / "scene.md").read_text()
    examples = re.findall(r"```toml\n(.*?)```", text, re.S)
    (example,) = (e for e in examples if "[materials.varnished]" in e)
    made = {m.name: m for m in read("diffuse = 0\n" + example).materials}
    assert made["varnished"].coats and made["varnished"].diffuse[0] == 0.4
    assert made["brushed"].specular.material == "aluminium" and not made["brushed"].coats
    assert made["window"].transmit.index.tolist() == [1.5]


def test_absorption_is_that_of_the_inside_of_a_clear_body():
    ink = made('mirror = "fresnel"\ntransmit = "fresnel"\nior = 1.5\nabsorption = [0, 1, 20]')
    assert ink.absorption == pytest.approx([0, 1, 20], abs=1e-12)
    assert made('transmit = "fresnel"\nior = 1.5\nabsorption = 0').absorption is None
    for text in ("transmit = 0.9\nabsorption = 1", "absorption = 1"):
        with pytest.raises(SceneError, match="absorption is not used: it belongs to the inside"):
            read(text)
    with pytest.raises(SceneError, match="absorption = -1 must be at least 0"):
        read('transmit = "fresnel"\nior = 1.5\nabsorption = -1')


PHONG = 'specular = { model = "phong", reflectance = 0.2, exponent = 9'
WRONG = [
    (PHONG + ", roughness = 0.1 }",
     "materials.m.specular.roughness belongs to model torrance-sparrow: leave it out"),
    ('specular = { model = "blinn", exponent = 3 }',
     "materials.m.specular.reflectance is missing: a number or [r, g, b] in [0, 1]"),
    (facets(roughness=0.1, exponent=3), "materials.m.specular.exponent belongs to model phong or"),
    (facets(ior=1.5), "materials.m.specular gives neither roughness nor half_angle: give one"),
    (facets(roughness=0.1, half_angle=3), "materials.m.specular gives roughness and half_angle"),
    (facets(roughness=0.1, ior=1.5, metal='"gold"'), "materials.m.specular gives ior and metal"),
    (facets(roughness=0), "materials.m.specular.roughness = 0 must lie in [0.0001, 1]"),
    (facets(roughness=0.1, ior=0.9),
     "materials.m.specular.ior = 0.9 must lie in [1, 100]: vacuum has 1, water 1.33, glass 1.5"),
    (facets(roughness=0.1, metal='"brass"'),
     'materials.m.specular.metal = "brass" must be one of aluminium, chromium'),
    (facets(roughness=0.1, facet='"gaussian"'),
     "materials.m.specular.facet is not a known key here: did you mean facets?"),
    (facets(roughness=0.1, facets='"ggx"'), "materials.m.specular.facets = \"ggx\" must be one of"),
    (facets(half_angle=50, facets='"beckmann"'),
     "materials.m.specular.half_angle = 50 must be at most 46.07 for Beckmann facets"),
    ("specular = { model = [1], reflectance = 0.5 }",
     "materials.m.specular.model = [1] must be one of"),
    (facets(half_angle=90), "materials.m.specular.half_angle = 90 must lie in [0.01, 89.99]"),
    (PHONG + ', convention = "raw" }', 'materials.m.specular.convention = "raw" must be one of'),
    ('mirror = "fresnel"', 'materials.m.mirror = "fresnel" needs ior = .. or metal = ".." beside'),
    ('mirror = "frenel"\nior = 1.5', 'materials.m.mirror = "frenel" must be a number, [r, g, b]'),
    ("mirror = 1.5", "materials.m.mirror = 1.5 must lie in [0, 1]: a surface cannot reflect"),
    ("ior = 1.5", 'materials.m.ior is not used: it belongs to mirror = "fresnel" or transmit'),
    ('metal = "gold"', 'materials.m.metal is not used: it belongs to mirror = "fresnel"'),
    ('mirror = "fresnel"\nmetal = "gold"\ntransmit = 0.1',
     "materials.m gives metal and transmit: metals let nothing through"),
    ('mirror = "fresnel"\nior = 1.5\nmetal = "gold"', "materials.m gives ior and metal: give one"),
    ("miror = 0.5", "materials.m.miror is not a known key here: did you mean mirror?"),
    # energy, at every angle and in every band
    ("diffuse = [0.3, 0.6, 0.3]\nmirror = 0.5",
     "materials.m: diffuse + mirror = 1.1 at 0 degrees in band g must be at most 1: a surface"),
    ("diffuse = 0.5\n" + facets(roughness=0.1, metal='"silver"'),
     "materials.m: diffuse + specular = 1.49305 at 90 degrees in band r"),
    ('diffuse = 0.4\nmirror = "fresnel"\nmetal = "copper"',
     "materials.m: diffuse + mirror = 1.4 at 90 degrees in band r"),
    ("diffuse = 0.1\nmirror = 0.5\ntransmit = [0.1, 0.1, 0.45]",
     "materials.m: diffuse + mirror + transmit = 1.05 at 0 degrees in band b"),
    ('diffuse = 0.1\nmirror = "fresnel"\ntransmit = "fresnel"\nior = 1.5',
     "materials.m: diffuse + mirror + transmit = 1.096 at 0 degrees in band r must be at most 1"),
    ("transmit = 0.7\n" + facets(roughness=0.05, ior=1.5),
     "materials.m: diffuse + specular + transmit = 1.5006 at 90 degrees in band r"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "start"), WRONG, ids=[start[12:60] for _, start in WRONG])
def test_one_mistake_gives_one_problem(text, start):
    found = told(text)
    assert len(found) == 1 and found[0].startswith(start), found


def test_the_angle_of_too_much_light_is_named():
    """Little is too much at 0 degrees, a rough dielectric is brightest towards grazing."""
    (found,) = told("transmit = 0.7\n" + facets(roughness=0.05, ior=1.5))
    assert " at 90 degrees in band r" in found
    read("transmit = 0.1\n" + facets(roughness=0.05, ior=1.5))


def test_all_mistakes_of_optics_are_reported_at_once():
    found = told('mirror = 2\ntransmit = "x"\nspecular = { model = "phong", ior = 0.5 }')
    keys = ("mirror = 2", 'transmit = "x"', "specular.ior = 0.5", "specular.ior belongs",
            "specular.exponent is missing", "specular.reflectance is missing")  # fmt: skip
    for key in keys:
        assert sum(p.startswith(f"materials.m.{key}") for p in found) == 1, key
    assert len(found) == len(keys)


def test_what_just_sums_up_to_all_is_read():
    read("diffuse = 0.3\nmirror = 0.3\ntransmit = 0.4")
    read("diffuse = 1\n" + facets(roughness=0.1, ior=1.5))  # a coat takes from its base
    read('diffuse = 1\nmirror = "fresnel"\nior = 1.5')
    read(facets(roughness=0.001))
    read("diffuse = 0.5\n" + facets(roughness=0.5, reflectance=0.5))


def test_scenes_made_in_code_are_checked_too():
    lobe = Blinn(np.full(3, 0.6), 5.0)
    scene = read("diffuse = 0.5")
    bright = Material("m", np.full(3, 0.5), np.full(3, 0.5), np.ones(3), lobe)
    scene = Scene("s", scene.faces, (bright,), scene.groups)
    with pytest.raises(SceneError, match=r"materials.m: diffuse \+ specular = 1.1 at 0 degrees"):
        radiosity.solve(scene, 0.3)


def test_seed_forms_are_read_and_not_solved():
    scene = read(PHONG + ', convention = "seed" }\nemission = { radiance = 1 }')
    assert isinstance(scene.materials[0].specular, SeedForm)
    with pytest.raises(SceneError, match=r'specular.convention = "seed" has no albedo'):
        radiosity.solve(scene, 0.3)


def test_mean_reflectances_of_whole_materials():
    """What is scattered evenly, and what is sent on."""
    coat = made("diffuse = 0.6\n" + facets(roughness=0.2, ior=1.5))
    a = coat.specular.mean_albedo
    assert reflectance_of(coat) == pytest.approx(0.6 * (1 - a), rel=1e-14)
    assert sent_on(coat) == pytest.approx(a, rel=1e-14)
    metal = made("diffuse = 0.05\n" + facets(roughness=0.2, metal='"copper"'))
    assert reflectance_of(metal) == pytest.approx(0.05, rel=1e-14)
    assert sent_on(metal) == pytest.approx(metal.specular.mean_albedo, rel=1e-14)
    glass = made('mirror = "fresnel"\ntransmit = "fresnel"\nior = 1.5')
    assert np.all(reflectance_of(glass) == 0)
    assert sent_on(glass) == pytest.approx(1.0, rel=1e-14)
    varnish = made('diffuse = [0.2, 0.5, 1]\nmirror = "fresnel"\nior = 1.5')
    m = fresnel.mean_reflectance(1.5)
    assert reflectance_of(varnish) == pytest.approx(np.array([0.2, 0.5, 1]) * (1 - m))
    assert sent_on(varnish) == pytest.approx(m)
    both = made('mirror = 0.3\n' + facets(roughness=0.2, ior=1.5))
    assert sent_on(both) == pytest.approx(a + 0.3 * (1 - a), rel=1e-14)


def test_a_coated_furnace_has_its_closed_form():
    """In a closed box E = M/(1 - rho), rho that of coat and base together under diffuse light.

    The base sends M + 0.5 (1 - a) E of it evenly, a the albedo of the coat.
    """
    box = ", ".join(str(q) for q in [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]],
        [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], [[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]],
        [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]], [[0, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]],
    ])  # fmt: skip
    scene = read_toml(
        f'[[geometry]]\nmaterial = "m"\npolygons = [{box}]\n[materials.m]\ndiffuse = 0.5\n'
        + facets(roughness=0.3, ior=1.5) + "emission = { exitance = 1 }", "b.toml", None,
    )  # fmt: skip
    a = scene.materials[0].specular.mean_albedo[0]
    solution = radiosity.solve(scene, 0.02)
    area, exact = solution.patches.area, 1 / (1 - a - 0.5 * (1 - a))
    found = area @ solution.irradiance_on[:, 0] / area.sum()
    assert found == pytest.approx(exact, rel=2e-3)
    assert solution.radiosity[:, 0] == pytest.approx(1 + 0.5 * (1 - a) * exact, rel=0.01)


COATED = [
    ("diffuse = 0.6\n", {"roughness": 0.3, "ior": 1.5}),
    ("diffuse = 0\n", {"roughness": 0.3, "metal": '"copper"'}),
    ("diffuse = 1\n",
     {"facets": '"beckmann"', "half_angle": 20, "ior": 1.5, "shadowing": '"smith"'}),
]  # fmt: skip


@pytest.mark.parametrize(("base", "keys"), COATED)
@pytest.mark.parametrize("cosine", [1.0, 0.4])
def test_a_floor_under_uniform_light_shows_its_albedo(base, keys, cosine):
    """a + rho (1 - a) of the angle of view; with rho = 1 all that arrives."""
    scene = read(base + facets(**keys))
    scene = Scene("f", scene.faces, scene.materials, scene.groups, ambient=np.full(3, 2.0))
    solution = radiosity.solve(scene, 0.2)
    count = 2000
    view = np.tile([np.sqrt(1 - cosine**2), 0, cosine], (count, 1))
    leaving, _, _ = radiance(
        solution, make_shading(solution), np.zeros(count, int), np.zeros((count, 3)), view,
        np.arange(count), 0,
    )  # fmt: skip
    material = scene.materials[0]
    a = material.specular.albedo(cosine)
    rho = material.diffuse
    expected = 2.0 * (a + rho * (1 - a) if material.coats else a + rho)
    error = leaving.std(axis=0) / np.sqrt(count)
    assert np.all(np.abs(leaving.mean(axis=0) - expected) < 4 * error + 2e-4)  # of the albedo
    if rho[0] == 1:
        assert expected == pytest.approx(np.full(3, 2.0), rel=1e-12)


@pytest.mark.parametrize("cosine", [1.0, 0.3])
def test_a_film_dims_its_base_by_the_angle_it_is_seen_at(cosine):
    """Under an even sky of radiance 1 the base shows rho (1 - F(theta_o)), beside the mirror."""
    scene = read('diffuse = 0.5\nmirror = "fresnel"\nior = 1.5')
    scene = Scene("f", scene.faces, scene.materials, scene.groups, ambient=np.ones(3))
    solution = radiosity.solve(scene, 0.2)
    view = np.array([[np.sqrt(1 - cosine**2), 0, cosine]])
    point, key = np.array([[0.5, 0.5, 0]]), np.zeros(1, int)
    leaving, _, _ = radiance(solution, make_shading(solution), key, point, view, key, 0)
    expected = 0.5 * (1 - fresnel.reflectance(cosine, 1.5))
    assert leaving[0] == pytest.approx(np.full(3, expected), rel=1e-12)


def test_a_plain_scene_imports_no_optics():
    code = (
        "import sys, radiosity\n"
        "s = radiosity.solve(radiosity.load('scenes/box6.toml'), 0.3)\n"
        "radiosity.render(s, size=(4, 4), samples=8)\n"
        "s.irradiance([[0.1, 0.1, 0.1]], [[0, 0, 1]])\n"
        "light = {m for m in sys.modules if m.startswith('radiosity.light.')}\n"
        "plain = 'bands', 'colour', 'palette', 'photometry', 'reflection', 'sources'\n"
        "assert light == {f'radiosity.light.{name}' for name in plain}, light\n"
        "assert not {'radiosity.scene.optics', 'radiosity.view.gloss'} & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("upward", "share"), [(True, 1.0), (False, 0.0)])
def test_a_glossy_wall_shows_what_lies_in_the_mirror_direction(upward, share):
    """Sky above, a black floor below: the wall, looked at from below, shows the sky."""
    text = (
        '[[geometry]]\nmaterial = "m"\n'
        "polygons = [[[0, -1, 0], [0, 1, 0], [0, 1, 2], [0, -1, 2]]]\n"
        '[[geometry]]\nmaterial = "black"\n'
        "polygons = [[[-900, -900, -1], [900, -900, -1], [900, 900, -1], [-900, 900, -1]]]\n"
        "[materials.black]\ndiffuse = 0\n[materials.m]\n"
    ) + facets(roughness=0.02)
    scene = read_toml(text, "wall.toml", None)
    scene = Scene("w", scene.faces, scene.materials, scene.groups, ambient=np.ones(3))
    solution = radiosity.solve(scene, 0.2)
    count = 100
    view = np.tile([0.8, 0.0, -0.6 if upward else 0.6], (count, 1))
    row = np.flatnonzero(solution.patches.normal[:, 0] > 0.5)[:1]
    leaving, _, _ = radiance(
        solution, make_shading(solution), np.repeat(row, count),
        np.tile([0, 0, 1.0], (count, 1)), view, np.arange(count), 0,
    )  # fmt: skip
    assert leaving.mean() == pytest.approx(share, abs=0.01)  # of the lobe lies beyond the horizon


def test_info_and_plan_say_what_is_done_with_optics():
    scene = read('mirror = 0.1\ntransmit = 0.4\nior = 1.5\n'
                 'specular = { model = "blinn", reflectance = [0, 0.2, 0], exponent = 3 }\n'
                 "emission = { radiance = 1 }")  # fmt: skip
    text = describe(scene)
    assert "Blinn, reflectance 0 0.2 0, exponent 3" in text
    assert "mirror 0.1 0.1 0.1  transmits 0.4 0.4 0.4" in text
    assert "counts as" not in text
    made = {r.name: r for r in foresee(scene, make_plan(scene, 0.3)).requirements}
    assert made["mirrors"].model == "followed" and made["transmission"].model == "followed"
    assert made["highlights"].model == "lobes"
    assert made["bands"].model == "3"  # the lobe has a colour
    plain = read("diffuse = 0.5\nemission = { radiance = 1 }")
    names = [r.name for r in foresee(plain, make_plan(plain, 0.3)).requirements]
    assert "mirrors" not in names and "transmission" not in names
