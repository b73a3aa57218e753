"""MTL libraries: what highlights, mirrors, panes, clear bodies, metals and pictures become."""

import numpy as np
import pytest

from radiosity.light.blinn import Blinn
from radiosity.light.texture import srgb_to_linear
from radiosity.scene.model import SceneError
from radiosity.scene.toml import read_tables
from radiosity.scene.wavefront.mtl import Map, read_mtl
from radiosity.scene.wavefront.obj import read_obj
from radiosity.scene.wavefront.tables import DULL, make
from radiosity.scene.weak import WEAK

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
UV = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
PICTURE = np.array([[[51, 102, 255], [51, 204, 0]]], np.uint8)


def no_picture(name):
    raise SceneError(name, ["does not exist"])


def made(statements, picture=no_picture, covered=True, body=False, head=""):
    said, problems = read_mtl(f"{head}newmtl a\n{statements}")
    assert not problems
    found = make(said["a"], picture, lambda name: f"x/{name}", covered, lambda: body)
    read_scene(found)  # whatever it is, it is a material
    return found


def read_scene(found):
    square = [[[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]]
    block = {"polygons": square, "material": "a"}
    table = found.said.table
    if isinstance(table["diffuse"], dict):
        block["uv"] = [[[0, 0], [1, 0], [1, 1], [0, 1]]]
    return read_tables(
        {"geometry": [block], "materials": {"a": table}}, "a", None, read_picture=found.pictures.get
    )


def table(statements, **more):
    return made(statements, **more).said.table


def test_ks_and_ns_are_a_lobe_about_the_halfway_vector():
    lobe = {"model": "blinn", "reflectance": [0.2, 0.3, 0.1], "exponent": 60.0}
    found = table("Kd 0.5 0.4 0.3\nKs 0.2 0.3 0.1\nNs 60")
    assert found == {"diffuse": [0.5, 0.4, 0.3], "specular": lobe}
    assert table("Kd 0.5\nKs 0.2\nNs 60\nillum 1") == {"diffuse": [0.5] * 3}  # no highlights
    assert table("Ks 0\nNs 60") == {"diffuse": [0.5] * 3}


def test_what_is_too_weak_or_too_wide_is_no_lobe():
    found = made(f"Kd 0.5\nKs {WEAK}\nNs 60")
    mean = Blinn(np.full(3, WEAK), 60.0).mean_albedo
    assert 0.5 < mean[0] / WEAK < 0.53
    np.testing.assert_allclose(found.said.table["diffuse"], 0.5 + mean)
    assert "counts as diffuse" in found.notes[0]
    assert "specular" in table(f"Kd 0.5\nKs {WEAK + 0.01}\nNs 60")
    found = made(f"Kd 0.5\nKs 0.4\nNs {DULL - 1}")
    mean = Blinn(np.full(3, 0.4), DULL - 1).mean_albedo
    np.testing.assert_allclose(found.said.table["diffuse"], 0.5 + mean)
    assert "counts as diffuse" in found.notes[0]
    assert table("Kd 0.5\nKs 1\nNs 0") == {"diffuse": [0.5] * 3}  # written where none is meant
    assert "specular" in table(f"Kd 0.5\nKs 0.4\nNs {DULL}")
    assert table("Kd 0.98\nKs 0.05\nNs 500\nillum 3")["diffuse"] == [pytest.approx(1.0)] * 3


def test_kd_and_ks_that_reflect_too_much_are_scaled_alike():
    found = made("Kd 0.6 0.3 0.3\nKs 0.9\nNs 40")
    np.testing.assert_allclose(found.said.table["diffuse"], [0.4, 0.2, 0.2])
    np.testing.assert_allclose(found.said.table["specular"]["reflectance"], [0.6] * 3)
    assert "both are scaled down" in found.notes[0]


def test_illum_3_is_a_mirror():
    found = table("Kd 0.1\nKs 0.8 0.7 0.6\nNs 500\nillum 3")
    assert found == {"diffuse": [0.1] * 3, "mirror": [0.8, 0.7, 0.6]}
    assert "mirror" in table("Kd 0.1\nKs 0.8\nillum 5")


def test_d_makes_a_pane_of_which_a_share_is_covered():
    found = table("Kd 0.5\nd 0.4\nTf 1 0.5 0.25")
    np.testing.assert_allclose(found["transmit"], [0.6, 0.3, 0.15])
    np.testing.assert_allclose(found["diffuse"], [0.2] * 3)
    assert table("Kd 0.5\nTr 0.6") == table("Kd 0.5\nd 0.4")
    assert "transmit" not in table("Kd 0.5\nd 0.4\nTr 0.6\nTf 0")
    assert table("Kd 0.5\nd 0.75\nTr 0.5")["transmit"] == [0.25] * 3  # d counts
    found = table("Kd 0.5\nd 0.5\nKs 1\nNs 90\nillum 4")  # the mirror takes what is left
    np.testing.assert_allclose(found["mirror"], [0.25] * 3)
    found = made("d 0.97")
    assert found.said.table == {"diffuse": [0.5] * 3} and "left out" in found.notes[0]


def test_tf_without_d_is_not_transparent_but_of_glass():
    """Maya writes illum 4, Tf 1 1 1 and Ni 1 for whatever is opaque."""
    assert table("Kd 0.5\nillum 4\nTf 1 1 1\nNi 1") == {"diffuse": [0.5] * 3}
    assert table("Kd 0.5\nillum 2\nTf 1 1 1\nNi 1.5") == {"diffuse": [0.5] * 3}
    assert table("illum 7\nTf 1 1 1\nNi 1.5", body=True)["transmit"] == "fresnel"


def test_glass_is_a_body_where_it_is_closed():
    clear = {"diffuse": 0.0, "mirror": "fresnel", "transmit": "fresnel", "ior": 1.5}
    assert table("Kd 0\nillum 7\nNi 1.5", body=True) == clear
    found = table("illum 6\nNi 1.5\nTf 0.81 0.49 0.25", body=True)
    np.testing.assert_allclose(found["transmit"], [0.9, 0.7, 0.5])  # once in, once out
    np.testing.assert_allclose(found["mirror"], [0.04] * 3)
    found = made("illum 7\nNi 1.5\nTf 0.9\nKd 0.5")
    np.testing.assert_allclose(found.said.table["transmit"], [0.9] * 3)
    assert "ior" not in found.said.table and "thin pane" in found.notes[0]


CUBE = (
    "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
)


def glass(faces):
    text = "mtllib m.mtl\nusemtl a\n" + faces
    found = read_obj(text, "x.obj", lambda name: "newmtl a\nillum 7\nNi 1.5")
    return found.materials["a"].table


def test_whether_glass_is_closed_is_measured():
    assert glass(CUBE)["ior"] == 1.5
    assert "ior" not in glass(CUBE.replace("f 2 6 8 4\n", ""))  # open
    inside_out = "".join(
        f"f {' '.join(line.split()[:0:-1])}\n" if line[0] == "f" else line + "\n"
        for line in CUBE.splitlines()
    )
    assert "ior" not in glass(inside_out)


def test_metals_have_the_colour_of_kd():
    found = table("Kd 0.9 0.6 0.3\nPm 1\nPr 0.5")
    lobe = {"model": "torrance-sparrow", "reflectance": [0.9, 0.6, 0.3], "roughness": 0.25}
    assert found == {"diffuse": [0.0] * 3, "specular": lobe}
    assert table("Kd 0.9\nPm 1\nPr 0") == {"diffuse": [0.0] * 3, "mirror": [0.9] * 3}
    half = table("Kd 0.8\nPm 0.5\nPr 0.5")
    assert half["diffuse"] == [0.4] * 3 and half["specular"]["reflectance"] == [0.4] * 3


def test_blender_writes_ks_a_half_for_the_4_percent_of_glass():
    head = "# Blender 3.6.0 MTL File: 'None'\n"
    usual = "Kd 0.8\nKs 0.5\nNs 250\nNi 1.45\nd 1\nillum 2"
    assert table(usual, head=head) == {"diffuse": [pytest.approx(0.82, abs=5e-4)] * 3}
    assert "specular" in table(usual)
    metal = table("Kd 0.8\nKs 0.5\nNs 250\nillum 3", head=head)
    assert metal["specular"]["roughness"] == pytest.approx(0.25)  # Ns = 1000 (1 - r)^2, c3 = r^2


def test_a_picture_is_the_reflectance_times_kd():
    found = made("Kd 0.5\nmap_Kd -o 0.25 0 -s 2 3 1 -clamp on wood grain.png", lambda name: PICTURE)
    key = {"texture": "x/wood grain.png", "scale": [0.5] * 3, "repeat": False}
    assert found.said.table == {"diffuse": key}
    assert found.texture == Map("wood grain.png", (0.25, 0.0), (2.0, 3.0), True)
    mean = srgb_to_linear(PICTURE / 255.0).mean(axis=(0, 1)) / 2
    np.testing.assert_allclose(read_scene(found).materials[0].diffuse, mean, rtol=1e-6)
    assert made("Kd 0\nmap_Kd a.png", lambda n: PICTURE).said.table["diffuse"]["scale"] == [1.0] * 3
    lobe = made("Kd 1\nKs 0.5\nNs 50\nmap_Kd a.png", lambda name: PICTURE)  # some blue texel is 1
    np.testing.assert_allclose(lobe.said.table["diffuse"]["scale"], [2 / 3] * 3, rtol=1e-5)


def test_a_picture_that_is_not_there_leaves_kd():
    found = made("Kd 0.5\nmap_Kd C:\\pics\\gone.png")
    assert found.said.table == {"diffuse": [0.5] * 3}
    assert found.notes == ("map_Kd C:/pics/gone.png does not exist: Kd stands",)
    bad = made("Kd 0.5\nmap_Kd a.npy", lambda name: PICTURE / 100.0)
    assert bad.said.table == {"diffuse": [0.5] * 3} and "outside [0, 1]" in bad.notes[0]
    found = made("Kd 0.5\nmap_Kd a.png", lambda name: PICTURE, covered=False)
    mean = srgb_to_linear(PICTURE / 255.0).mean(axis=(0, 1)) / 2
    np.testing.assert_allclose(found.said.table["diffuse"], mean)
    assert "no texture coordinates" in found.notes[0] and not found.pictures


def test_emission_counts_by_its_mean():
    mean = srgb_to_linear(PICTURE / 255.0).mean(axis=(0, 1))
    found = made("Kd 0\nKe 10\nmap_Ke a.png", lambda name: PICTURE)
    np.testing.assert_allclose(found.said.table["emission"]["radiance"], 10 * mean)
    alone = made("Kd 0\nmap_Ke a.png", lambda name: PICTURE)
    np.testing.assert_allclose(alone.said.table["emission"]["radiance"], mean)


def test_what_is_not_read_is_named_once():
    library = "newmtl a\nKd 0.1\nmap_Bump x.png\nKa 1\nnewmtl b\nKd 0.1\nmap_Bump y.png\nrefl z\n"
    text = f"mtllib m.mtl\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nl 1 2\nl 2 3\np 1\n"
    notes = read_obj(text, "x.obj", lambda name: library).notes
    assert "materials a, b (2): map_Bump is not read" in notes
    assert "materials b (1): refl is not read" in notes
    assert "2 lines l are not read" in notes and "1 lines p are not read" in notes
    assert not any("Ka" in note for note in notes)


def test_texture_coordinates_are_read_where_a_library_needs_them():
    text = f"mtllib m.mtl\n{SQUARE}{UV}usemtl a\nf 1/1 2/2 3/3 4/4\n"
    plain = read_obj(text, "x.obj", lambda name: "newmtl a\nKd 0.5")
    assert plain.faces.uv is None
    library = "newmtl a\nKd 0.5\nmap_Kd -o 1 2 -s 3 4 a.png\n"
    found = read_obj(
        text, "x.obj", lambda name: library, read_picture=lambda name: PICTURE, called="d/x.obj"
    )
    np.testing.assert_array_equal(found.faces.uv[0], [[1, 2], [4, 2], [4, 6], [1, 6]])
    assert list(found.pictures) == ["d/a.png"]
    raw = {"geometry": [{"file": "d/x.obj"}]}
    assert read_tables(raw, "x", lambda name, uv: found).materials[0].texture is not None


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("Ns -1", "Ns -1 must be at least 0: it is the exponent"),
        ("Ns", "Ns must be a finite number"),
        ("d 1.5", "d 1.5 must lie in [0, 1]: 1 is opaque"),
        ("Ni inf", "Ni inf must be a finite number"),
        ("Ks 1 nan 1", "Ks 1 nan 1 must be one or three finite numbers"),
        ("illum 99", "illum 99 must lie in [0, 10]"),
        ("map_Kd -s x a.png", "map_Kd -s x a.png: -s x must be one to three numbers"),
        ("map_Kd -clamp on", "map_Kd -clamp on names no picture"),
    ],
)
def test_wrong_statements_are_named(line, text):
    _, problems = read_mtl(f"newmtl a\n{line}")
    assert len(problems) == 1 and problems[0].startswith(f"line 2: {text}")


def test_a_halo_is_not_opaque():
    found = made("d -halo 0.2")
    assert found.said.table == {"diffuse": [0.5] * 3} and found.notes == ("d is not read",)
