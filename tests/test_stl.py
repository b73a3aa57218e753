"""STL files: binary and text give the same triangles; broken ones are named."""

import struct

import numpy as np
import pytest

from radiosity.scene.meshes.stl import read_stl
from radiosity.scene.model import SceneError

CORNERS = np.array([[[0, 0, 0], [2, 0, 0], [0, 2, 0]], [[0, 0, 1], [0, 2, 1], [2, 0, 1]]], float)


def binary(triangles, attribute=0, head=b"made here"):
    data = head.ljust(80) + struct.pack("<I", len(triangles))
    for t in triangles:
        data += struct.pack("<12fH", 0, 0, 0, *t.ravel(), attribute)
    return data


def solid(name, triangles):
    text = f"solid {name}\n"
    for t in triangles:
        text += "  facet normal 0 0 1\n    outer loop\n"
        text += "".join("      vertex {} {} {}\n".format(*p) for p in t)
        text += "    endloop\n  endfacet\n"
    return (text + f"endsolid {name}\n").encode()


def problems(data):
    with pytest.raises(SceneError) as error:
        read_stl(data, "a.stl", "a")
    return error.value.problems


def test_binary_and_text_are_the_same():
    one, two = read_stl(binary(CORNERS), "a.stl", "a"), read_stl(solid("", CORNERS), "a.stl", "a")
    np.testing.assert_array_equal(one.faces.vertices[:, :3], CORNERS)
    np.testing.assert_array_equal(two.faces.vertices, one.faces.vertices)
    assert one.group_names == two.group_names == ("a",)
    assert one.notes == two.notes == ()


def test_solids_of_a_text_are_groups():
    data = solid("floor", CORNERS[:1]) + solid("the lid", CORNERS[1:]) + solid("floor", CORNERS[1:])
    geometry = read_stl(data.replace(b"\n", b"\r\n"), "a.stl", "a")
    assert geometry.group_names == ("floor", "the lid")
    assert geometry.faces.group.tolist() == [0, 1, 0]


def test_binary_that_begins_with_solid_is_binary():
    geometry = read_stl(binary(CORNERS, head=b"solid facet x"), "a.stl", "a")
    assert len(geometry.faces) == 2


def test_what_a_binary_file_has_beside_is_said():
    geometry = read_stl(binary(CORNERS, attribute=3) + b"tail", "a.stl", "a")
    assert geometry.notes == (
        "not read: the attributes (colours) of 2 triangles",
        "4 bytes after the last triangle were left out",
    )


def test_rows_of_a_matrix_are_the_triangles():
    flat = np.concatenate([CORNERS[:1] * 0, CORNERS])
    given = read_stl(binary(flat), "a.stl", "a", merge=False).given
    assert (given.owner.tolist(), given.count) == ([1, 2], 3)


TEXT = solid("a", CORNERS)


@pytest.mark.parametrize(
    ("data", "found"),
    [
        (b"", "has no faces in its 0 bytes"),
        (binary(CORNERS)[:-1], "2 triangles, which take 184 bytes, and has 183: it was cut off"),
        (b"x" * 80 + b"\xff" * 4 + bytes(50), "4294967295 triangles"),
        (binary([]), "has no faces: nothing can be lit"),
        (b"solid a\nendsolid a\n", "has no faces: nothing can be lit"),
        (binary(CORNERS * np.nan), "vertex 0 = [nan, nan, nan] must be finite"),
        (TEXT[:-60], "has 5 vertices in 1 facets"),
        (TEXT.replace(b"vertex 2.0 0.0 0.0", b"vertex 2.0 zero 0.0"), "line 5: vertex 2.0 zero"),
        (TEXT.replace(b"vertex 2.0 0.0 0.0", b"vortex 2.0 0.0 0.0"), "has 5 vertices in 2 facets"),
        (TEXT.replace(b"2.0", b"1" * 2_000_000, 1), "has 5 vertices in 2 facets"),
        (TEXT.replace(b"2.0", b"1e99"), "must be finite and at most 1e+30"),
    ],
)  # fmt: skip
def test_broken_files_are_named_with_their_fault(data, found):
    (said,) = problems(data)
    assert found in said
