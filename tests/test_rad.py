"""Radiance scene descriptions: what is read, what it becomes, what is left out and said."""

import numpy as np
import pytest

from radiosity.light.photometry import illuminance
from radiosity.scene.files import load
from radiosity.scene.model import SceneError
from radiosity.scene.radiance.materials import radiance_of, table_of
from radiosity.scene.radiance.moves import MoveError, read_moves
from radiosity.scene.radiance.rad import read_rad
from radiosity.scene.radiance.text import Primitive, parsed
from radiosity.scene.radiance.views import read_views

WALL = "void plastic wall\n0\n0\n5 .5 .4 .3 0 0\n"
SQUARE = "wall polygon floor\n0\n0\n12 0 0 0 1 0 0 1 1 0 0 1 0\n"
ABOVE = "wall polygon above\n0\n0\n12 0 0 1 1 0 1 1 1 1 0 1 1\n"


def read(text, **files):
    return read_rad(text, "x.rad", lambda name: files.get(name.removesuffix(".rad")))


def problems(text, **files):
    with pytest.raises(SceneError) as error:
        read(text, **files)
    return error.value.problems


def table(kind, *reals, strings=()):
    return table_of(Primitive(1, "void", kind, "m", strings, tuple(map(float, reals))))[0]


def test_a_polygon_of_plastic():
    found = read(WALL + SQUARE)
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    np.testing.assert_array_equal(found.faces.vertices, [corners])
    assert found.material_names == ("wall",) and found.group_names == ("floor",)
    assert found.materials["wall"].table == {"diffuse": [0.5, 0.4, 0.3]}
    assert found.materials["wall"].origin == "plastic 0.5 0.4 0.3 0 0"
    assert (found.unit, found.up) == (None, "z")


def test_comments_line_breaks_and_integers_are_taken():
    text = "# void x y\nvoid plastic\nwall 0 0 5 # no .9\n.5 .4\n.3 0 0 "
    text += SQUARE.replace("0\n0", "0 2 7 8", 1)
    assert read(text).materials["wall"].table == {"diffuse": [0.5, 0.4, 0.3]}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("void plastic wall\n0\n0\n5 .5 .4 .3", "plastic wall should have 5 numbers, 3 words"),
        ("void plastic wall\n0\n0\n3 .5 .4 .3\n" + SQUARE, "plastic wall needs at least 5 numbers"),
        ("void plastik wall\n0\n0\n0", "plastik is no type of Radiance: did you mean plastic"),
        ("void plastic wall\n0\n0\n5 .5 x .3 0 0", "plastic wall: x must be a finite number"),
        ("void plastic wall\n0\n0\n5 .5 1e40 .3 0 0", "1e40 must be a finite number"),
        ("void plastic wall\nzero", "line 2: plastic wall: zero must be a whole number"),
        ("void plastic wall\n999999999", "should have 999999999 strings, 0 words are left"),
        ("void", "the file ends where a type should follow"),
        (WALL + "wall polygon p 0 0 8 0 0 0 1 0 0 1 1", "polygon p needs three numbers for each"),
        (WALL + "wall polygon p 0 0 15 0 0 0 2 2 0 2 0 0 0 2 0 1 3 0", "polygon p crosses itself"),
        (WALL + "wall sphere s 0 0 3 0 0 0", "sphere s needs 4 numbers, found 3"),
        (WALL + "wall sphere s 0 0 4 0 0 0 0", "sphere s has the radius 0"),
        (WALL + "wall cylinder c 0 0 7 1 1 1 1 1 1 1", "cylinder c has no length"),
        (WALL + "wall ring r 0 0 8 0 0 0 0 0 0 1 2", "ring r looks in the direction 0 0 0"),
        (WALL + "wall ring r 0 0 8 0 0 0 0 0 1 1 1", "ring r needs two different radii"),
        ("a alias a a " + SQUARE.replace("wall", "a"), "line 1: a stands for itself"),
        ("void dielectric wall 0 0 5 1 1 1 .5 0\n" + SQUARE, "refraction 0.5, it must lie"),
        (WALL, "has no surfaces"),
        (WALL + "wall source s 0 0 4 0 0 0 1", "source s needs a direction and an angle"),
    ],
)  # fmt: skip
def test_wrong_text_is_named(text, told):
    found = problems(text)
    assert len(found) == 1 and told in found[0]


def test_the_last_definition_before_a_surface_counts():
    dark = "void plastic wall 0 0 5 .1 .1 .1 0 0\n"
    found = read(WALL + SQUARE + dark + SQUARE + WALL + ABOVE)
    assert found.material_names == ("wall", "wall-2")
    assert found.faces.material.tolist() == [0, 1, 0]
    assert found.materials["wall-2"].table == {"diffuse": [0.1] * 3}


def test_patterns_and_aliases_lead_to_the_material_below():
    text = "void brightfunc dirt 2 dirt dirt.cal 0 1 .5\ndirt plastic wall 0 0 5 .5 .4 .3 0 0\n"
    text += "wall texfunc bumps 4 x y z b.cal 0 0\nvoid alias paint bumps\n"
    found = read(text + SQUARE.replace("wall", "paint"))
    assert found.materials["wall"].table == {"diffuse": [0.5, 0.4, 0.3]}
    assert "patterns and textures are left out (2, bumps for one)" in found.notes


def test_a_material_that_is_not_there_is_left_to_the_scene_file():
    found = read(SQUARE.replace("wall", "brick") + SQUARE.replace("wall", "void"))
    assert found.material_names == ("brick", "default") and not found.materials


def test_plastic_and_metal():
    rough = {"model": "torrance-sparrow", "facets": "beckmann", "roughness": 0.1}
    found = table("plastic", 0.5, 0.4, 0.3, 0.2, 0.1)
    np.testing.assert_allclose(found["diffuse"], [0.4, 0.32, 0.24])
    assert found["specular"] == rough | {"reflectance": [0.2] * 3}
    found = table("metal", 0.5, 0.4, 0.3, 0.8, 0.1)
    np.testing.assert_allclose(found["specular"]["reflectance"], [0.4, 0.32, 0.24])
    found = table("metal", 0.5, 0.4, 0.3, 0.9, 0.0)
    np.testing.assert_allclose(found["mirror"], [0.45, 0.36, 0.27])
    found = table("metal2", 0.5, 0.4, 0.3, 0.8, 0.4, 0.1, strings=("0", "0", "1", "."))
    assert found["specular"]["roughness"] == pytest.approx(0.2)
    assert table("plastic", 0.5, 0.5, 0.5, 0.02, 0.1) == {"diffuse": [pytest.approx(0.51)] * 3}


def test_trans_shares_light_out():
    found = table("trans", 0.8, 0.8, 0.4, 0.1, 0.0, 0.5, 0.25)
    np.testing.assert_allclose(found["mirror"], 0.1)
    np.testing.assert_allclose(found["diffuse"], np.array([0.8, 0.8, 0.4]) * 0.9 * 0.5)
    np.testing.assert_allclose(found["translucent"], np.array([0.8, 0.8, 0.4]) * 0.9 * 0.375)
    np.testing.assert_allclose(found["transmit"], np.array([0.8, 0.8, 0.4]) * 0.9 * 0.125)


def test_glass_lets_through_what_its_transmissivity_says():
    """A transmittance of 88 % is a transmissivity of 0.96 (Radiance's manual, of n = 1.52)."""
    found = table("glass", 0.96, 0.96, 0.96)
    np.testing.assert_allclose(found["transmit"], 0.88, atol=0.002)
    clear = table("glass", 1.0, 1.0, 1.0)  # nothing is absorbed, T = (1 - r)/(1 + r)
    r = (0.52 / 2.52) ** 2
    np.testing.assert_allclose(clear["transmit"], (1 - r) / (1 + r), rtol=1e-12)
    np.testing.assert_allclose(np.add(clear["transmit"], clear["mirror"]), 1.0, rtol=1e-12)
    assert table("glass", 0.96, 0.96, 0.96, 1.0) == {"diffuse": 0.0, "transmit": [0.96] * 3}


def test_dielectric_absorbs_along_its_inside():
    found = table("dielectric", 0.5, 1, 1, 1.5, 0)
    assert (found["ior"], found["mirror"], found["transmit"]) == (1.5, "fresnel", "fresnel")
    np.testing.assert_allclose(np.exp(-np.array(found["absorption"])), [0.5, 1, 1])


def test_lamps_have_radiances_of_the_same_lux():
    white = radiance_of([100.0, 100.0, 100.0])
    np.testing.assert_allclose(white, 100.0 * 179.0 / 683.0, rtol=1e-12)
    rgb = np.array([17.0, 12.0, 4.0])
    lux = 179.0 * np.pi * rgb @ [0.265, 0.670, 0.065]  # under a sky of that radiance
    assert illuminance(np.pi * radiance_of(rgb)) == pytest.approx(lux, rel=1e-12)
    assert table("glow", 1, 1, 1, 0)["emission"] == {"radiance": [pytest.approx(179 / 683)] * 3}
    narrow = table("spotlight", 1, 1, 1, 60, 0, 0, -1)["emission"]["radiance"][0]
    assert narrow == pytest.approx(179 / 683 * 2 * (1 - np.cos(np.pi / 6)))  # the same flux


ROUND = {
    "sphere": ("4 1 2 3 .5", np.pi), "bubble": ("4 1 2 3 .5", np.pi),
    "cylinder": ("7 0 0 0 0 0 2 .5", 2 * np.pi), "tube": ("7 0 0 0 0 0 2 .5", 2 * np.pi),
    "cone": ("8 0 0 0 0 0 4 3 0", 15 * np.pi), "cup": ("8 0 0 0 0 0 4 0 3", 15 * np.pi),
    "ring": ("8 1 1 1 0 0 -2 2 1", 3 * np.pi),
}  # fmt: skip
LAMP = "void light lamp 0 0 3 1 1 1\n"


@pytest.mark.parametrize("kind", ROUND)
def test_round_surfaces_are_facets_that_look_the_right_way(kind):
    reals, area = ROUND[kind]
    faces = read(f"{WALL}wall {kind} s 0 0 {reals}\n").faces
    assert area * 0.98 < faces.areas().sum() < area
    centre = np.array([1.0, 2, 3]) if kind in ("sphere", "bubble") else np.array([0, 0, 1.3])
    outward = np.einsum("fc,fc->f", faces.normals(), faces.vertices.mean(axis=1) - centre)
    if kind == "ring":
        assert (faces.normals()[:, 2] < -1 + 1e-12).all()
        assert faces.corner_normals is None
    else:
        assert ((outward > 0) == (kind in ("sphere", "cylinder", "cone"))).all()
        assert faces.is_curved.all()
    lamp = read(f"{LAMP}lamp {kind} s 0 0 {reals}\n").faces  # whose flux is right
    assert lamp.areas().sum() == pytest.approx(area, rel=1e-9)


def test_a_wall_with_a_hole():
    text = "wall polygon w 0 0 30 0 0 0 4 0 0 4 4 0 0 4 0 1e-9 0 0 1 1 0 1 3 0 3 3 0 3 1 0 1 1 0\n"
    faces = read(WALL + text).faces
    assert faces.areas().sum() == pytest.approx(12)
    np.testing.assert_allclose(faces.normals(), np.broadcast_to([0, 0, 1], (len(faces), 3)))


def test_xform_moves_a_file_and_repeats_it():
    found = read("!xform -s 2 -rz 90 -t 10 0 0 -a 3 -t 0 0 1 part.rad\n", part=WALL + SQUARE)
    assert len(found.faces) == 3
    np.testing.assert_allclose(found.faces.vertices[2, 1], [10, 2, 2], atol=1e-12)
    np.testing.assert_allclose(found.faces.vertices[0, 2], [8, 2, 0], atol=1e-12)


def test_xform_mirrors_without_turning_fronts_to_backs():
    ball = WALL + "wall sphere s 0 0 4 3 0 0 1\n"
    faces = read("!xform -mx ball.rad", ball=ball).faces
    away = faces.vertices.mean(axis=1) - [-3, 0, 0]
    assert (np.einsum("fc,fc->f", faces.normals(), away) > 0).all()
    own = np.einsum("fvc,fc->fv", faces.corner_normals, faces.normals())
    assert own.min() > 0.9
    turned = read("!xform -I ball.rad", ball=ball).faces
    away = turned.vertices.mean(axis=1) - [3, 0, 0]
    assert (np.einsum("fc,fc->f", turned.normals(), away) < 0).all()


def test_options_of_xform_in_order():
    def point(*words):
        return (read_moves(words).matrices @ [1, 2, 3, 1])[:, :3].tolist()

    assert point("-t", "1", "0", "0", "-mx") == [[-2, 2, 3]]
    assert point("-i", "3", "-t", "1", "0", "0", "-i", "1", "-s", "2") == [[8, 4, 6]]
    rows = point("-a", "2", "-t", "1", "0", "0", "-a", "2", "-t", "0", "1", "0")
    assert sorted(rows) == [[1, 2, 3], [1, 3, 3], [2, 2, 3], [2, 3, 3]]
    np.testing.assert_allclose(point("-rx", "90"), [[1, -3, 2]])
    np.testing.assert_allclose(point("-ry", "90"), [[3, 2, -1]])
    assert read_moves(("-m", "gold", "-n", "x", "a.rad", "b.rad")).rest == ("a.rad", "b.rad")


@pytest.mark.parametrize(
    "words",
    ["-t 1 2", "-s 0", "-a 20000", "-a 200 -a 200", "-q 3", "-rx x", "-i -1", "-i 9999 -s 9"],
)
def test_options_that_cannot_be_followed(words):
    with pytest.raises(MoveError):
        read_moves(tuple(words.split()))


def test_materials_of_a_file_that_is_moved_are_known_after_it():
    gold = "void metal gold 0 0 5 1 .8 .3 0 0\n"
    found = read("!xform gold.rad part.rad\n!xform -m gold part.rad\n" + ABOVE, gold=gold,
                 part=WALL + SQUARE)  # fmt: skip
    assert found.material_names == ("wall", "gold") and found.faces.material.tolist() == [0, 1, 0]


def test_genbox_is_followed_and_other_commands_are_named_and_never_run(tmp_path):
    text = (
        f"{WALL}!genbox wall box 1 2 3 | xform -t 5 0 0\n!genprism wall p 3 0 0 1 0 1 1 -l 0 0 1\n"
        f"!touch {tmp_path}/a\n!xform x.rad > {tmp_path}/b\n!genbox wall b 1 1 1 \\\n -i\n"
    )
    found = read(text, x=WALL + SQUARE)
    assert len(found.faces) == 12 and not list(tmp_path.iterdir())
    outside, inside = found.faces.areas()[:6].sum(), found.faces.areas()[6:].sum()
    assert (outside, inside) == (pytest.approx(22), pytest.approx(6))
    middle = np.repeat([[5.5, 1, 1.5], [0.5, 0.5, 0.5]], 6, axis=0)
    away = found.faces.vertices.mean(axis=1) - middle
    looks = np.einsum("fc,fc->f", found.faces.normals(), away)
    assert (looks[:6] > 0).all() and (looks[6:] < 0).all()
    note = next(n for n in found.notes if n.startswith("commands are never run"))
    assert "genprism (1), touch (1), xform (1)" in note


def test_files_within_files_end():
    assert problems("!xform x.rad", x="!xform y.rad", y="!xform x.rad") == [
        "y.rad line 1: x.rad: names itself"
    ]
    twice = {f"f{k}": f"!xform f{k + 1}.rad\n" * 2 for k in range(17)}
    assert "too many files in files" in problems("!xform f0.rad", **twice)[0]
    wide = {f"f{k}": f"!xform f{k + 1}.rad\n" * 9 for k in range(9)} | {"f9": WALL}
    assert "too many files in files" in problems("!xform f0.rad", **wide)[0]
    gone = read(WALL + SQUARE + "!xform gone.rad")
    assert "line 9: the file gone.rad is not there: it is left out" in gone.notes


def test_too_many_facets_are_refused_before_they_are_made():
    ball = WALL + "wall sphere s 0 0 4 0 0 0 1"
    found = problems("!xform -a 9999 -t 0 1 0 row.rad", row="!xform -a 9 -t 1 0 0 b.rad", b=ball)
    assert found == ["line 1: makes more than 1000000 facets: split the scene"]


def test_suns_and_skies():
    sun = "void light sun 0 0 3 1e6 1e6 1e6\nsun source s 0 0 4 0 0 5 .533\n"
    sky = "void glow sky 0 0 4 2 2 2 0\nsky source s 0 0 4 0 0 1 180\n"
    ground = "void glow ground 0 0 4 1 1 1 0\nground source g 0 0 4 0 0 -1 180\n"
    found = read(WALL + SQUARE + ground + sky + "!xform -rx 90 sun.rad", sun=sun)
    ambient, directional = sorted(found.lights, key=lambda table: table["type"])
    assert ambient["radiance"] == [pytest.approx(2 * 179 / 683)] * 3
    expected = np.pi * np.sin(np.radians(0.2665)) ** 2 * 1e6 * 179 / 683
    np.testing.assert_allclose(directional["irradiance"], expected)
    np.testing.assert_allclose(directional["direction"], [0, 1, 0], atol=1e-12)  # it travels so
    assert any("1 darker half spaces are left out" in n for n in found.notes)


def test_views():
    cameras, notes = read_views(
        "rvu -vtv -vp 1 2 3 -vd 0 1 0 -vu 0 0 1 -vh 90 -vv 53.13010235415598 -vs 0\n"
        "VIEW= -vtl -vp 0 0 9 -vd 0 0 -1 -vu 0 1 0 -vh 8 -vv 4\nrvu -vth -vp 0 0 0 -vd 1 0 0\n"
    )
    assert list(cameras) == ["view", "view-2"] and len(notes) == 1
    assert cameras["view"]["size"] == [512, 256] and cameras["view"]["target"] == [1, 3, 3]
    plan = {"projection": "orthographic", "height": 4.0, "size": [512, 256]}
    assert cameras["view-2"] == cameras["view-2"] | plan


def test_views_that_are_shifted_or_too_many_are_told():
    view = "rvu -vtv -vp 1 2 3 -vd 0 1 0 -vu 0 0 1 -vs 0.5\n"
    cameras, notes = read_views(101 * view)
    assert len(cameras) == 100 and notes == [
        "of 101 views of the .vf file 100 are read",
        "100 views of the .vf file are shifted or lifted (-vs, -vl): not read",
    ]
    assert read_views(view.replace("-vs 0.5", "-vs 0 -vo 0 -va 2"))[1] == [
        "1 views of the .vf file are clipped in front or behind (-vo, -va): not read"
    ]


@pytest.mark.parametrize(("unit", "metre"), [("m", 1.0), ("mm", 0.001)])
def test_dielectrics_absorb_per_length_of_the_file(tmp_path, unit, metre):
    text = "void dielectric wall 0 0 5 .5 .25 1 1.5 0\n" + SQUARE
    (tmp_path / "a.rad").write_text(text)
    (tmp_path / "a.toml").write_text(f'unit = "{unit}"\n[[geometry]]\nfile = "a.rad"\n')
    expected = -np.log([0.5, 0.25, 1.0]) / metre
    for scene in (load(tmp_path / "a.toml"), load(tmp_path / "a.rad", unit=unit)):
        np.testing.assert_allclose(scene.materials[0].absorption, expected)
    (tmp_path / "b.toml").write_text(
        f'unit = "ft"\n[[geometry]]\nfile = "a.rad"\nunit = "{unit}"\nscale = 7\n'
    )
    np.testing.assert_allclose(load(tmp_path / "b.toml").materials[0].absorption, expected)


def test_weak_reflection_of_glass_counts_as_scattered():
    found = table("glass", 0.35, 0.35, 0.35)
    r = (0.52 / 2.52) ** 2
    through = 0.35 * (1 - r) ** 2 / (1 - (0.35 * r) ** 2)
    assert found["diffuse"] == pytest.approx([r + r * 0.35 * through] * 3) and "mirror" not in found
    assert found["transmit"] == pytest.approx([through] * 3)
    assert table("glass", 0.05, 0.05, 0.05)["translucent"][0] < 0.05


@pytest.mark.parametrize("part", ["sun source s 0 0 4 0 0 1 1\n", SQUARE])
def test_suns_and_polygons_are_counted_before_they_are_made(monkeypatch, part):
    monkeypatch.setattr("radiosity.scene.radiance.rad.MOST_FACETS", 1000)
    lamp = "void light sun 0 0 3 1 1 1\n"
    many = "!xform -a 30 x.rad\n"
    told = problems(f"!xform -a 40 y.rad\n{WALL}{SQUARE}", x=WALL + lamp + part, y=many)
    assert told == ["line 1: makes more than 1000 facets: split the scene"]
    again = "".join("!xform x.rad\n" for _ in range(1001))
    assert "makes more than 1000 facets" in problems(again + WALL + SQUARE, x=WALL + lamp + part)[0]


def test_many_suns_corners_and_copies_of_none_are_counted(monkeypatch):
    lamp = "void light sun 0 0 3 1 1 1\nsun source s 0 0 4 0 0 1 1\n"
    told = problems("!xform -a 200 x.rad\n!xform -a 60 y.rad\n" + WALL + SQUARE,
                    x="!xform -a 60 y.rad\n", y=lamp)  # fmt: skip
    assert told == ["makes 12060 suns, at most 10000 are read: join them"]
    monkeypatch.setattr("radiosity.scene.radiance.rad.MOST_FACETS", 1000)
    turn = 2 * np.pi * np.arange(200) / 200
    star = (1 + np.arange(200) % 2)[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    corners = " ".join(f"{x} {y} 0" for x, y in star)
    star = f"wall polygon star 0 0 600 {corners}\n"
    assert "more than 1000 facets" in problems(WALL + "!xform x.rad\n" * 20, x=star)[0]
    none = WALL + "!xform -a 0 x.rad\n" * 3 + SQUARE
    assert "more than 1000 facets" in problems(none, x=SQUARE * 500)[0]


def test_a_file_and_its_views_on_disk(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "floor.rad").write_text(WALL + SQUARE)
    lamp = "lamp sphere s 0 0 4 0 0 2 .1\n"
    (tmp_path / "room.rad").write_text(f"{LAMP}!xform parts/floor.rad\n{lamp}")
    (tmp_path / "room.vf").write_text("rvu -vp 0 -5 1 -vd 0 1 0 -vu 0 0 1 -vh 40 -vv 40\n")
    scene = load(tmp_path / "room.rad")
    assert [m.name for m in scene.materials] == ["wall", "lamp"] and list(scene.cameras) == ["view"]
    (tmp_path / "room.rad").write_text("!xform ../secret.rad\n")
    (tmp_path.parent / "secret.rad").write_text(WALL + SQUARE)
    with pytest.raises(SceneError, match="lies outside the scene's folder"):
        load(tmp_path / "room.rad")


def test_words_and_lines_of_primitives():
    found = parsed('void colorpict "a b" 7 r g b pic.hdr cal u v 0 1 1\n!xform a.rad\n')
    assert found[0].name == "a b" and found[0].strings[3] == "pic.hdr" and found[1].line == 2
