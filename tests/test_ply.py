"""PLY files: every form of writing one square down gives it; broken ones are named."""

import struct
from itertools import pairwise

import numpy as np
import pytest

from radiosity.scene.meshes.ply import read_ply
from radiosity.scene.model import SceneError

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
STAR = [(np.cos(a) * r, np.sin(a) * r, 0.5) for a, r in
        zip(np.arange(10) * np.pi / 5, [2, 0.8] * 5, strict=True)]  # fmt: skip


def header(form, vertex, face, vertices=4, faces=1, end="\n", extra=()):
    """Return a header with properties, each "type name" or "list type type name"."""
    lines = ["ply", f"format {form} 1.0", "comment made here", *extra]
    lines += [f"element vertex {vertices}", *(f"property {p}" for p in vertex)]
    lines += [f"element face {faces}", *(f"property {p}" for p in face), "end_header", ""]
    return end.join(lines).encode()


XYZ = ("float x", "float y", "float z")
LIST = ("list uchar int vertex_indices",)


def text(vertices, faces, vertex=XYZ, face=LIST, **more):
    rows = [" ".join(map(str, row)) for row in (*vertices, *faces)]
    head = header("ascii", vertex, face, len(vertices), len(faces), **more)
    return head + "\n".join(rows).encode() + b"\n"


def problems(data):
    with pytest.raises(SceneError) as error:
        read_ply(data, "a.ply", "a")
    return error.value.problems


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize(
    ("number", "code"), [("float", "f"), ("double", "d"), ("int8", "b"), ("ushort", "H")]
)
@pytest.mark.parametrize(("count", "of"), [("uchar", "B"), ("int32", "i")])
def test_one_square_in_all_types_and_orders(form, end, number, code, count, of):
    head = header(form, [f"{number} {k}" for k in "xyz"], [f"list {count} uint vertex_index"],
                  end=end)  # fmt: skip
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(form)
    if order is None:
        body = end.join(" ".join(f"{v:g}" for v in row) for row in [*SQUARE, (4, 0, 1, 2, 3)])
        body = body.encode()
    else:
        body = struct.pack(f"{order}12{code}", *(SQUARE.ravel().astype(code)))
        body += struct.pack(f"{order}{of}4I", 4, 0, 1, 2, 3)
    geometry = read_ply(head + body, "a.ply", "a")
    np.testing.assert_array_equal(geometry.faces.vertices, SQUARE[None])
    assert (geometry.group_names, geometry.notes) == (("a",), ())


def test_polygons_of_many_lengths_stay_what_they_are():
    """A quadrilateral stays whole, a star of ten corners keeps its area, rows know their file."""
    points = [*SQUARE.tolist(), *STAR]
    rows = [(3, 0, 1, 2), (2, 0, 1), (10, *range(4, 14)), (4, 0, 1, 2, 3), (3, 0, 1, 1)]
    data = text(points, rows)
    geometry = read_ply(data, "a.ply", "a", merge=False)
    area = geometry.faces.areas()
    owner = geometry.given.owner
    star = 0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in pairwise([*STAR, STAR[0]]))
    totals = [area[owner == k].sum() for k in range(5)]
    assert totals == pytest.approx([0.5, 0, star, 1, 0])
    assert np.sum(owner == 3) == 1 and geometry.given.count == 5
    assert (geometry.faces.normals()[:, 2] > 0.999).all()
    assert geometry.notes == ("1 faces of fewer than 3 corners were left out",)
    assert geometry.faces.degenerate == 1


def test_binary_rows_of_many_lengths_equal_text():
    points = [*SQUARE.tolist(), *STAR]
    rows = [(4, 0, 1, 2, 3), (3, 0, 1, 2), (10, *range(4, 14)), (3, 4, 5, 6)]
    vertex, face = ("double x", "double y", "double z"), ("uchar red", *LIST, "short flags")
    head = header("binary_big_endian", vertex, face, len(points), len(rows))
    body = np.array(points, ">f8").tobytes()
    for n, *index in rows:
        body += struct.pack(f">BB{n}ih", 7, n, *index, 9)
    one = read_ply(head + body, "a.ply", "a", merge=False)
    two = read_ply(text(points, rows), "a.ply", "a", merge=False)
    np.testing.assert_array_equal(one.faces.vertices, two.faces.vertices)
    assert one.notes == ("not read: colours of face, flags of face",)


def test_other_elements_and_colours_are_named_and_skipped():
    extra = ("element camera 1", "property float fx", "property list uchar float k",
             "comment TextureFile wood.png", "obj_info scanned")  # fmt: skip
    vertex = (*XYZ, "uchar red", "uchar green", "uchar blue", "float confidence")
    vertices = [(*p, 255, 0, 0, 0.5) for p in SQUARE]
    data = text(vertices, [(4, 0, 1, 2, 3)], vertex, extra=extra)
    data = data.replace(b"end_header\n", b"end_header\n30 2 1 1\n")
    geometry = read_ply(data, "a.ply", "a")
    np.testing.assert_array_equal(geometry.faces.vertices, SQUARE[None])
    assert geometry.notes == (
        "line 7: comment TextureFile wood.png: not read; a material's texture names a picture",
        "not read: 1 camera, colours of vertex, confidence of vertex",
    )


@pytest.mark.parametrize("names", ["st", "uv", ("texture_u", "texture_v")])
def test_texture_coordinates_of_vertices(names):
    vertex = (*XYZ, *(f"float {n}" for n in names))
    uv = np.array([[0, 0], [2, 0], [2, 3], [0, 3]], float)
    data = text(np.hstack([SQUARE, uv]), [(4, 0, 1, 2, 3)], vertex)
    np.testing.assert_array_equal(read_ply(data, "a.ply", "a", uv=True).faces.uv, uv[None])
    assert read_ply(data, "a.ply", "a").faces.uv is None


def test_texture_coordinates_of_faces_win():
    face = (*LIST, "list uchar float texcoord")
    row = (4, 0, 1, 2, 3, 8, 0, 0, 1, 0, 1, 1, 0, 1)
    found = read_ply(text(SQUARE, [row], face=face), "a.ply", "a", uv=True).faces.uv
    np.testing.assert_array_equal(found[0], SQUARE[:, :2])


def test_normals_of_vertices_round_what_is_curved():
    vertex = (*XYZ, "float nx", "float ny", "float nz")
    up = [(0, 0, 1)] * 4
    flat = np.hstack([SQUARE, up])
    leaning = np.hstack([SQUARE, [(0, 0.6, 0.8), *up[1:]]])
    even, curved = (
        read_ply(text(rows, [(4, 0, 1, 2, 3)], vertex), "a.ply", "a").faces.corner_normals
        for rows in (flat, leaning)
    )
    assert even is None
    np.testing.assert_allclose(curved[0, 0], [0, 0.6, 0.8])


GOOD = text(SQUARE, [(4, 0, 1, 2, 3)])
BINARY = header("binary_little_endian", XYZ, LIST) + SQUARE.astype("<f4").tobytes()


@pytest.mark.parametrize(
    ("data", "found"),
    [
        (GOOD[4:], "must begin with a line \"ply\""),
        (GOOD.replace(b"end_header", b"end"), "has no line end_header in its first 65536 bytes"),
        (GOOD.replace(b"ascii", b"utf8"), "line 2: format utf8 1.0: must be one of binary_little"),
        (GOOD.replace(b"format ascii 1.0\n", b""), "has no line format"),
        (GOOD.replace(b"vertex 4", b"vertex many"), "line 4: element vertex many: must be a name"),
        (GOOD.replace(b"float x", b"half x"), "line 5: property half x: must be a type and a name"),
        (GOOD.replace(b"uchar int", b"float int"), "lists are counted in whole numbers"),
        (GOOD.replace(b"element vertex 4\n", b""), "before the first element"),
        (GOOD.replace(b"float y", b"float x"), 'lists "x" twice'),
        (GOOD.replace(b"float y", b"float why"), "vertices with x, why, z: x, y and z are needed"),
        (GOOD.replace(b"vertex_indices", b"corners"), "faces with corners: a list vertex_indices"),
        (text(SQUARE, [(4, 0, 1, 2, 3)], (*XYZ, "list uchar float nx")), "lists nx of vertices"),
        (text(SQUARE, [(4, 0, 1, 2, 3)], (*XYZ, "list uchar float s")), "lists s of vertices"),
        (text(SQUARE, [(4, 0, 1, 2, 3)], face=(*LIST, "float texcoord")), "one number texcoord"),
        (text(SQUARE, [(4, 0, 1, 2, 3)], face=("list uchar int vertex_index",
                                               "int vertex_indices")), "one number vertex_indices"),
        (GOOD.replace(b"element face", b"element tristrips"), "(element tristrips), which are not"),
        (GOOD.replace(b"face 1", b"face 0"), "has no faces: nothing can be lit"),
        (GOOD.replace(b"vertex 4", b"vertex 0"), "has 1 faces and no vertices"),
        (GOOD.replace(b"vertex 4", b"vertex 4000000000000"),
         "4000000000000 vertex, which take at least 24000000000000 bytes"),
        (GOOD.replace(b"face 1", b"face 3"), "ends"),
        (GOOD.replace(b"4 0 1 2 3", b"4 0 1 2 x"), 'says "x" in line 15, where a number'),
        (GOOD.replace(b"4 0 1 2 3", b"99 0 1 2 3"),
         "list vertex_indices of row 0 the length 99"),
        (GOOD.replace(b"4 0 1 2 3", b"5 0 1 2 3"), "ends within face 0 of 1"),
        (GOOD.replace(b"4 0 1 2 3", b"-4 0 1 2 3"), "list vertex_indices of row 0 the length -4"),
        (GOOD.replace(b"4 0 1 2 3", b"4 0 1 2 4"), "face 0 = [0, 1, 2, 4] names a vertex"),
        (GOOD.replace(b"4 0 1 2 3", b"4 0 1 2 2.5"), "face 0 = [0, 1, 2, 2.5] names a vertex"),
        (GOOD.replace(b"4 0 1 2 3", b"5 0 2 3 1 0").replace(b"0.0 1.0 0.0", b"0.0 1.0 nan"),
         "vertex 3 = [0.0, 1.0, nan] must be finite"),
        (GOOD.replace(b"4 0 1 2 3", b"4 0 2 1 3"), "face 0 crosses itself"),
        (BINARY, "ends before list vertex_indices of row 0: it was cut off"),
        (BINARY + b"\x04" + bytes(12), "ends within face 0 of 1"),
        (BINARY[:-1], "48 bytes, and 47 follow the header"),
    ],
)  # fmt: skip
def test_broken_files_are_named_with_their_fault(data, found):
    (said,) = problems(data)
    assert found in said


def test_headers_as_programs_write_them():
    """Line ends that change within the header, and a comment that runs over a line end."""
    square = BINARY + struct.pack("<B4i", 4, 0, 1, 2, 3)
    odd = square.replace(b"end_header\n", b"end_header \r\n")
    odd = odd.replace(b"made here", b"made\nby a program")
    geometry = read_ply(odd, "a.ply", "a")
    np.testing.assert_array_equal(geometry.faces.vertices, SQUARE[None])
    text = "line 4: by a program: not read; it is no format, element, property or comment"
    assert geometry.notes == (text,)


def test_elements_of_nothing_take_no_memory():
    huge = GOOD.replace(b"element vertex", b"element ghost 900000000000000\nelement vertex")
    assert len(read_ply(huge, "a.ply", "a").faces) == 1


def test_cut_and_changed_bytes_end_in_an_error_or_a_mesh():
    """Nothing else than a SceneError comes out, whatever stands in the file."""
    rng = np.random.default_rng(0)
    whole = BINARY + struct.pack("<B4i", 4, 0, 1, 2, 3)
    for seed in (whole, GOOD):
        for _ in range(150):
            data = bytearray(seed)
            for _ in range(rng.integers(1, 4)):
                data[rng.integers(len(data))] = rng.integers(256)
            data = bytes(data[: rng.integers(len(data) // 2, len(data) + 1)])
            try:
                assert len(read_ply(data, "a.ply", "a", uv=True).faces) >= 0
            except SceneError:
                pass
