import numpy as np
import pytest

from radiosity.scene.model import SceneError
from radiosity.scene.wavefront.mtl import read_mtl
from radiosity.scene.wavefront.obj import read_obj

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)


def read(text, **libraries):
    return read_obj(text, "x.obj", lambda name: libraries.get(name.removesuffix(".mtl")))


def problems(text, **libraries):
    with pytest.raises(SceneError) as error:
        read(text, **libraries)
    return error.value.problems


@pytest.mark.parametrize(
    "face",
    [
        "f 1 2 3 4",
        "f 1/1 2/2 3/3 4/4",
        "f 1/1/1 2/2/1 3/3/1 4/4/1",
        "f 1//1 2//1 3//1 4//1",
        "f -4 -3 -2 -1",
        "f 1 2 3\nf 1 3 4",
        "  f\t1 2  3 4  # the floor",
        "f 1 2 \\\n3 4",
    ],
)
def test_one_square_in_every_form(face):
    np.testing.assert_array_equal(read(SQUARE + face + "\n").faces.vertices, [CORNERS])


def test_negative_indices_count_back_from_their_own_line():
    text = SQUARE + "f -4 -3 -2\n" + "v 5 0 0\nv 6 0 0\nv 6 1 0\n" + "f -3 -2 -1\n"
    vertices = read(text).faces.vertices
    np.testing.assert_array_equal(vertices[0, :3], CORNERS[:3])
    np.testing.assert_array_equal(vertices[1, :3, 0], [5, 6, 6])


def test_groups_and_materials_by_name_in_order_of_use():
    text = SQUARE + (
        "f 1 2 3\ng one two\nusemtl my red\nf 1 2 3\no none\ng lamp\nusemtl unused\nusemtl light\n"
        "f 1 2 3\ng one two\nf 1 2 3\n"
    )
    found = read(text)
    assert found.group_names == ("default", "one two", "lamp")
    assert found.material_names == ("default", "my red", "light")
    assert found.faces.group.tolist() == [0, 1, 2, 1]
    assert found.faces.material.tolist() == [0, 1, 2, 2]


def test_faces_of_all_sizes_keep_the_order_of_the_file():
    """A concave pentagon between a triangle and a square, and one bent quadrilateral."""
    text = (
        SQUARE + "v 9 0 0\nv 11 0 0\nv 11 2 0\nv 10 0.5 0\nv 9 2 0\nv 0 1 0.5\n"
        "g a\nf 1 2 3\ng b\nf 5 6 7 8 9\ng c\nf 1 2 3 4\ng d\nf 1 2 3 10\n"
    )
    found = read_obj(text, "x.obj", None, merge=False).faces
    assert found.group.tolist() == [0, 1, 1, 1, 2, 3, 3]
    assert found.areas()[1:4].sum() == pytest.approx(2.5)
    assert (found.normals()[:5, 2] == 1).all()


def test_faces_without_area_are_left_out_and_said():
    found = read(SQUARE + "f 1 2 3 4\nf 1 1 2\nf 1 1 2 2\n")
    assert len(found.faces) == 1
    assert found.faces.degenerate == 1
    assert "1 faces with all corners on one line were left out" in found.notes


def test_colours_behind_a_vertex_and_unknown_words_are_ignored():
    text = "# x\nvt 0 0\nvn 0 0 1\ns off\nl 1 2\n" + SQUARE.replace("0\n", "0 0.5 0.5 0.5\n")
    assert len(read(text + "f 1 2 3 4\nweird words\n").faces) == 1


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("v 1 2", "line 5: v 1 2: a vertex is three finite numbers x y z"),
        ("v 1 2 x", "line 5: v 1 2 x: a vertex is three finite numbers"),
        ("v 1 nan 3", "line 5: v 1 nan 3: a vertex is three finite numbers"),
        ("v 1 2 1e400", "line 5: v 1 2 1e400: a vertex is three finite numbers"),
        (
            "v 1 2 -1e31",
            "line 5: v 1 2 -1e31: a vertex is three finite numbers x y z, at most 1e+30",
        ),
        ("f 1 2", "line 5: f 1 2: a face needs at least 3 corners, found 2"),
        ("f 1 2 5", "line 5: f ... 5: vertex 5 does not exist, the file has 4"),
        ("f 1 2 0", "line 5: f ... 0: vertices are counted from 1"),
        ("f 1 2 -5", "line 5: f ... -5: vertex -5 does not exist, 4 were given so far"),
        ("f 1 2 3.5", "line 5: f ... 3.5: a corner is v, v/vt, v//vn or v/vt/vn"),
        ("f 1 2 99999999999999999999", "vertex 99999999999999999999 does not exist"),
        ("f 1 3 2 4", "line 5: the face crosses itself: edge 0"),
    ],
)
def test_wrong_lines_are_named(line, text):
    found = problems(SQUARE + line + "\nf 1 2 3\n")
    assert len(found) == 1
    assert text in found[0]


def test_counting_back_beyond_what_was_given_is_named_although_more_follows():
    assert problems("v 0 0 0\nv 1 0 0\nf -1 -2 -3\nv 1 1 0\n") == [
        "line 3: f ... -3: vertex -3 does not exist, 2 were given so far"
    ]


def test_all_wrong_lines_are_listed():
    found = problems(SQUARE + "v a b c\nf 1 2\nf 1 2 77\nf 1 2 3\nmtllib m.mtl\n", m="Kd 1 1 1")
    assert [p.split(":")[0] for p in found] == ["line 5", "line 6", "line 7", "line 9"]
    many = problems("v x\n" * 70)
    assert len(many) == 51
    assert many[-1] == "and 20 more problems like these"


@pytest.mark.parametrize("text", ["", SQUARE, SQUARE + "vn 0 0 1\n", "nothing of the kind\n"])
def test_no_faces_is_said(text):
    assert problems(text) == ["has no faces: an OBJ file lists them as lines such as f 1 2 3"]


def test_library_gives_reflectance_and_radiance():
    library = "newmtl my wall\nKd 0.1 0.2 0.3\nKs 1 1 1\n\nnewmtl lamp\nKd 0\nKe 17 12 4\n"
    found = read("mtllib m.mtl\n" + SQUARE + "usemtl my wall\nf 1 2 3\n", m=library)
    assert found.materials["my wall"].table == {"diffuse": [0.1, 0.2, 0.3]}
    lamp = {"diffuse": [0, 0, 0], "emission": {"radiance": [17, 12, 4]}}
    assert found.materials["lamp"].table == lamp
    assert "m.mtl: Kd is read as diffuse reflectance" in found.notes[0]


def test_library_that_is_missing_is_only_noted():
    found = read("mtllib gone.mtl\n" + SQUARE + "f 1 2 3 4\n")
    assert "line 1: the material library gone.mtl is not there" in found.notes[0]


def test_several_libraries_on_one_line():
    found = read(
        "mtllib a.mtl b.mtl\n" + SQUARE + "f 1 2 3\n",
        a="newmtl a\nKd 1 0 0",
        b="newmtl b\nKd 0 1 0",
    )
    assert set(found.materials) == {"a", "b"}


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("Kd 1.2 0 0", "line 2: Kd 1.2 0 0 must lie in [0, 1]: a surface cannot reflect more"),
        ("Kd -0.1 0 0", "line 2: Kd -0.1 0 0 must not be negative"),
        ("Ke nan 0 0", "line 2: Ke nan 0 0 must be one or three finite numbers"),
        ("Kd 0.5 0.5", "line 2: Kd 0.5 0.5 must be one or three finite numbers"),
        ("Kd spectral x.rfl", "(spectral and xyz forms are not read)"),
    ],
)
def test_wrong_lines_of_a_library_are_named(line, text):
    materials, found = read_mtl("newmtl a\n" + line)
    assert len(found) == 1
    assert text in found[0]
    assert read_mtl("Kd 1 1 1")[1] == [
        "line 1: Kd 1 1 1 comes before the first newmtl: name the material it belongs to"
    ]


TWO_UV = "vt 0 0\nvt 2 0\nvt 2 3\nvt 0 3 0\n"
DOME = "vn 0 0 2\nvn 1 0 1\nvn 0 1 1\nvn 0 0 1\n"


def detailed(text, merge=True):
    return read_obj(text, "x.obj", None, merge, uv=True).faces


@pytest.mark.parametrize(
    "face",
    [
        "f 1/1 2/2 3/3 4/4",
        "f 1/-4/1 2/-3/2 3/-2/3 4/-1/4",
        "f 1/1 2/2 3/3\nf 1/1 3/3 4/4",  # joined
    ],
)
def test_corners_keep_their_texture_coordinates(face):
    faces = detailed(SQUARE + TWO_UV + DOME + face + "\n")
    np.testing.assert_array_equal(faces.vertices, [CORNERS])
    np.testing.assert_array_equal(faces.uv, [[[0, 0], [2, 0], [2, 3], [0, 3]]])


def test_corners_keep_their_normals_as_unit_vectors():
    faces = detailed(SQUARE + DOME + "f 1//1 2//2 3//-2 4//-1\n")
    half = np.sqrt(0.5)
    expected = [[[0, 0, 1], [half, 0, half], [0, half, half], [0, 0, 1]]]
    np.testing.assert_allclose(faces.corner_normals, expected, atol=1e-15)
    assert faces.uv is None
    # Normals of a file whose winding is turned round point to the fronts all the same.
    turned = detailed(SQUARE + DOME + "f 4//4 3//3 2//2 1//1\n").corner_normals
    np.testing.assert_allclose(turned, -np.array(expected)[:, ::-1], atol=1e-15)


def test_normals_of_flat_faces_are_as_good_as_none():
    assert detailed(SQUARE + "vn 0 0 3\nf 1//1 2//1 3//1 4//1\n").corner_normals is None
    assert detailed(SQUARE + "vn 0 0 0\nf 1//1 2//1 3//1 4//1\n").corner_normals is None
    both = SQUARE + DOME + "v 5 -1 0\nf 1//1 2//2 3//3 4//4\nf 1//1 5//1 2//1\n"
    assert np.isnan(detailed(both).corner_normals).all(axis=(1, 2)).tolist() == [False, True]


def test_faces_that_name_nothing_have_nothing():
    text = SQUARE + TWO_UV + "f 1/1 2/2 3/3 4/4\nv 5 -1 0\nf 1 2 5\nf 1/1 3 5/2\n"
    uv = detailed(text, merge=False).uv
    assert np.isnan(uv).all(axis=(1, 2)).tolist() == [False, True, True]
    assert read(SQUARE + TWO_UV + "f 1/1 2/2 3/3 4/4\n").faces.uv is None  # nobody asks for them


def test_pairs_are_joined_where_the_picture_goes_on_across_them():
    bent = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 2\n"
    assert len(detailed(SQUARE + bent + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")) == 2
    seam = TWO_UV + "vt 7 7\n"
    assert len(detailed(SQUARE + seam + "f 1/1 2/2 3/3\nf 1/1 3/5 4/4\n")) == 2
    assert len(detailed(SQUARE + TWO_UV + "f 1/1 2/2 3/3\nf 1 3 4\n")) == 2
    assert len(read(SQUARE + bent + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n").faces) == 1
    crease = "f 1//1 2//2 3//3\nf 1//1 3//2 4//4\n"
    assert len(detailed(SQUARE + DOME + crease)) == 2
    assert len(detailed(SQUARE + DOME + crease.replace("3//2", "3//3"))) == 1


def test_a_concave_face_keeps_what_its_corners_have():
    text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\n"
    text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 0.25\nvt 0 1\nf 1/1 2/2 3/3 4/4 5/5\n"
    faces = detailed(text, merge=False)
    assert len(faces) == 3
    np.testing.assert_allclose(faces.uv, faces.vertices[..., :2] / 2)


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("vt 1", "line 13: vt 1: texture coordinates are two finite numbers u v"),
        ("vn 1 2 nan", "line 13: vn 1 2 nan: a normal is three finite numbers x y z"),
        ("f 1/5 2/1 3/1", "f ... 1/5: vt 5 does not exist, the file has 4, 4 of them so far"),
        ("f 1//1 2//-5 3//1", "f ... 2//-5: vn -5 does not exist, the file has 4"),
        ("f 1/x 2/1 3/1", "line 13: f ... 1/x: vt x does not exist"),
        ("f 1/1.5 2/1 3/1", "line 13: f ... 1/1.5: vt 1.5 does not exist"),
    ],
)
def test_wrong_texture_coordinates_and_normals_are_named(line, text):
    with pytest.raises(SceneError) as error:
        detailed(SQUARE + TWO_UV + DOME + line + "\nf 1 2 3\n")
    assert len(error.value.problems) == 1
    assert text in error.value.problems[0]


def test_points_with_normals_and_no_faces_are_refused():
    with pytest.raises(SceneError, match="has no faces"):
        read_obj("v 0 0 0\nvn 0 0 1\n", "a.obj", None)


def test_colours_of_vertices_are_told():
    found = read(SQUARE.replace("v 0 0 0\n", "v 0 0 0 1 0 0\n", 1) + "f 1 2 3 4\n")
    assert found.notes == ("colours of 1 vertices are not read",)
    told = read(SQUARE.replace("v 0 0 0\n", "v 0 0 0 # lower left x\n", 1) + "f 1 2 3 4\n").notes
    assert told == ()
