"""Bodies whose fronts matter are turned where it is beyond doubt; sizes are questioned."""

import json

import numpy as np
import pytest
from scenes_for_tests import block, box, uv_sphere

from radiosity.cli.info import describe
from radiosity.mesh.patches import reversed_winding
from radiosity.scene.files import load
from radiosity.scene.model import SceneError
from radiosity.scene.toml import read_toml

ROOM = box((0, 0, 0), (4, 4, 3))
LAMP = block((1, 1, 1), (2, 2, 2))
GLASS = '[materials.m]\ndiffuse = 0\nmirror = "fresnel"\ntransmit = "fresnel"\nior = 1.5\n'
SHINES = "[materials.m]\ndiffuse = 0\nemission = { radiant_flux = 6 }\n"
PLANE = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 1), (1, 2, 4), (2, 3, 5), (3, 4, 1),
         (4, 5, 2), (5, 1, 3)]  # fmt: skip


def scene(material, *bodies, keys=""):
    """Return a scene of a white room and bodies of one material, one block each."""
    text = f'[[geometry]]\nmaterial = "white"\npolygons = {ROOM.tolist()}\n'
    for body in bodies:
        polygons = [p[:3] if p[2] == p[3] else p for p in np.asarray(body).tolist()]
        text += f'[[geometry]]\nmaterial = "m"\npolygons = {json.dumps(polygons)}\n{keys}'
    return read_toml(text + "[materials.white]\ndiffuse = 0.5\n" + material, "r.toml", None)


def mixed(body, *odd):
    body = np.array(body)
    body[list(odd)] = body[list(odd)][:, ::-1]
    return body


def volume(scene, name="m"):
    """Return the volume inside the faces of a material, above 0 if all of a box look out."""
    mine = [m.name for m in scene.materials].index(name) == scene.faces.material
    v = scene.faces.vertices[mine] - scene.faces.vertices[mine].mean(axis=(0, 1))
    fans = np.cross(v[:, 1], v[:, 2]) + np.cross(v[:, 2], v[:, 3])
    return np.einsum("fc,fc->", v[:, 0], fans) / 6


def notes(found):
    return [n for n in found.notes if "no camera" not in n]


def test_a_lamp_with_two_faces_the_wrong_way_round_shines_outwards():
    found = scene(SHINES, mixed(LAMP, 1, 4))
    assert volume(found) == pytest.approx(1)
    assert notes(found) == [
        "2 faces of 1 closed bodies looked the other way than the rest and were turned, face 7 for "
        "one; repair = false keeps them"
    ]
    sound = scene(SHINES, LAMP)
    assert notes(sound) == []
    turned = found.faces.normals()[[7, 10]]
    np.testing.assert_allclose(turned, sound.faces.normals()[[7, 10]])


def test_what_cannot_be_told_or_does_not_matter_stays():
    half = scene(SHINES, mixed(LAMP, 0, 2, 4))
    assert volume(half) == pytest.approx(0)
    assert notes(half) == [
        "1 closed bodies look in and out about as much, one with face 6: which way they should "
        "cannot be told, and only fronts emit"
    ]
    white = scene("[materials.m]\ndiffuse = 0.5\n", mixed(LAMP, 1, 4))
    assert volume(white) == pytest.approx(1 / 3) and notes(white) == []
    kept = scene(SHINES, mixed(LAMP, 1, 4), keys="repair = false\n")
    assert volume(kept) == pytest.approx(1 / 3) and notes(kept) == []


def test_faces_with_a_black_back_are_turned_too():
    found = scene("[materials.m]\ndiffuse = 0.5\ntwo_sided = false\n", mixed(LAMP, 3))
    assert volume(found) == pytest.approx(1) and len(notes(found)) == 1


def test_a_lamp_inside_out_is_said_and_kept():
    found = scene(SHINES, LAMP[:, ::-1])
    assert volume(found) == pytest.approx(-1)
    assert notes(found) == [
        "1 closed bodies emit inwards, one of m at [1.5, 1.5, 1]: only fronts emit; if their light "
        "is to come out, turn their faces round"
    ]
    assert notes(scene(SHINES, LAMP[:, ::-1], keys="repair = false\n")) == []  # it is meant so


@pytest.mark.parametrize("odd", [(), (2,), (0, 1, 2, 3, 4), range(6)])
def test_clear_bodies_look_out(odd):
    found = scene(GLASS, mixed(LAMP, *odd))
    assert volume(found) == pytest.approx(1)
    said = [f"{len(odd)} faces of 1 clear bodies looked in and were turned, as their fronts are "
            "the outside; repair = false keeps them"]  # fmt: skip
    assert notes(found) == (said if len(odd) else [])
    if len(odd):
        kept = scene(GLASS, mixed(LAMP, *odd), keys="repair = false\n")
        assert volume(kept) == pytest.approx(1 - len(odd) / 3) and notes(kept) == []


def test_a_bubble_in_a_clear_body_looks_in():
    bubble = block((1.3, 1.3, 1.3), (1.7, 1.7, 1.7))[:, ::-1]
    found = scene(GLASS, LAMP, bubble)
    assert notes(found) == []
    assert volume(found) == pytest.approx(1 - 0.4**3)


def test_clear_bodies_beside_each_other_are_judged_one_by_one():
    ball = uv_sphere(4) * 0.4
    found = scene(GLASS, ball + [1, 1, 1], ball[:, ::-1] + [3, 3, 1], LAMP + [1, -0.9, 0])
    assert notes(found)[0].startswith(f"{len(ball)} faces of 1 clear bodies looked in")


def test_an_open_clear_body_is_said():
    (note,) = notes(scene(GLASS, LAMP[1:]))
    assert note.startswith("1 clear bodies are open or branched, one of m at [")
    assert "close the body, or leave out ior for a thin pane" in note
    pane = "[materials.m]\ndiffuse = 0\ntransmit = 0.9\n"
    assert notes(scene(pane, LAMP[1:])) == []


def test_a_clear_body_without_an_inside_is_refused():
    points = np.random.default_rng(2).random((6, 3)) + 1
    body = points[np.array(PLANE)][:, [0, 1, 2, 2]]
    with pytest.raises(SceneError, match="clear body of m at .* so it has no inside: mend it"):
        scene(GLASS, body)
    assert notes(scene("[materials.m]\ndiffuse = 0.5\n", body)) == []


def test_faces_that_are_there_twice_do_not_share_the_flux():
    """Half of it would be lost in what is covered."""
    once, twice, again = (scene(SHINES, *b) for b in ([LAMP], [[*LAMP, *LAMP]], [LAMP, LAMP]))
    assert notes(twice) == notes(again) == ["6 faces that repeat another one were left out"]
    for found in (twice, again):
        np.testing.assert_array_equal(found.faces.vertices, once.faces.vertices)
        np.testing.assert_allclose(found.materials[1].emission, once.materials[1].emission)
    np.testing.assert_allclose(once.materials[1].emission, 6 / np.pi / 6)


SQUARE = "polygons = [[[0, 0, 0], [{0}, 0, 0], [{0}, {0}, 0], [0, {0}, 0]]]\n"


@pytest.mark.parametrize(
    ("size", "unit", "question"),
    [
        (5, "m", None),
        (1000, "m", None),
        (5000, "mm", None),
        (20000, "m", "the scene is 20000 m long: is its unit mm? Then it would be 20 m"),
        (3, "mm",
         "the scene is 0.003 m long: is its unit m or ft? Then it would be 3 m or 0.914 m"),
        (1e9, "m", "the scene is 1e+09 m long: is m its unit (m, cm, mm, in, ft)?"),
    ],
)  # fmt: skip
def test_sizes_that_nothing_has_are_questioned(size, unit, question, tmp_path):
    text = f'unit = "{unit}"\n[[geometry]]\n' + SQUARE.format(size)
    asked = [n for n in read_toml(text, "s.toml", None).notes if "long" in n]
    assert asked == ([question] if question else [])
    if unit == "m":
        obj = f"v 0 0 0\nv {size} 0 0\nv {size} {size} 0\nf 1 2 3\n"
        (tmp_path / "a.obj").write_text(obj)
        assert [n for n in load(tmp_path / "a.obj").notes if " m long" in n] == asked


def test_info_prints_the_findings_with_places(tmp_path, capsys):
    from radiosity.cli.main import app

    text = "g floor\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
    text += "g wall\nv 0.5 .2 -1\nv 0.5 .8 -1\nv 0.5 .5 1\nf 5 6 7\n"
    (tmp_path / "a.obj").write_text(text)
    printed = describe(load(tmp_path / "a.obj"))
    assert "mesh: 0 closed pieces (0 look out, 0 in), 2 open\n" in printed
    assert (
        "found: 1 pairs of faces cut through each other: their patches are cut along the line; "
        "face 0 (floor) at 0.5 0.5 0\n"
    ) in printed
    app(["info", str(tmp_path / "a.obj"), "--json"], standalone_mode=False)
    found = json.loads(capsys.readouterr().out)
    assert found["open"] == 2 and found["high"] == [1, 1, 1] and len(found["notes"]) == 3
    (crossing,) = found["findings"]
    assert (crossing["kind"], crossing["groups"], crossing["count"]) == ("crossing", ["floor"], 1)


@pytest.mark.parametrize("material", [GLASS, SHINES])
@pytest.mark.parametrize("odd", [(), range(0, 128, 6)])
def test_smooth_normals_do_not_depend_on_faces_that_are_turned(material, odd):
    """Of a sphere they are its radii, as near as the mesh is fine, on the turned faces too."""
    inside = uv_sphere(8) + [2, 2, 1.5]
    ball = reversed_winding(inside)
    ball[list(odd)] = inside[list(odd)]
    found = scene(material, ball, keys="smooth = 60\n")
    assert volume(found) > 0
    mine = found.faces.is_curved
    radii = found.faces.vertices[mine] - [2, 2, 1.5]
    cosine = np.einsum("fvc,fvc->fv", found.faces.corner_normals[mine], radii)
    assert mine.sum() == 128 and np.degrees(np.arccos(cosine.min())) < 1.5
