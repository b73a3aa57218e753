import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from radiosity.scene import files
from radiosity.scene.files import load, read_geometry
from radiosity.scene.model import SceneError

OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
PLY = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 {z}
0 1 0
{face}
"""
STL = (
    b"cube".ljust(80, b" ")
    + struct.pack("<I", 1)
    + struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0)
)
SCENES = Path(__file__).parents[1] / "scenes"


def problems(function, *args):
    with pytest.raises(SceneError) as error:
        function(*args)
    return error.value.problems


def test_geometry_of_three_formats(tmp_path):
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "b.PLY").write_text(PLY.format(faces=2, z=0, face="3 0 1 2\n3 0 2 3"))
    (tmp_path / "c.stl").write_bytes(STL)
    assert read_geometry(tmp_path / "a.obj").faces.areas() == pytest.approx([1])
    ply = read_geometry(tmp_path / "b.PLY")
    assert ply.faces.areas() == pytest.approx([1])  # both triangles, joined
    assert (ply.material_names, ply.group_names) == (("default",), ("b",))
    assert len(read_geometry(tmp_path / "b.PLY", None, False).faces) == 2
    stl = read_geometry(tmp_path / "c.stl").faces
    np.testing.assert_array_equal(stl.vertices[0, :3], [[0, 0, 0], [2, 0, 0], [0, 2, 0]])


def test_bare_geometry_becomes_a_scene_with_notes(tmp_path):
    (tmp_path / "room.obj").write_text(OBJ)
    scene = load(str(tmp_path / "room.obj"))
    assert (scene.name, scene.unit_m, scene.groups) == ("room", 1.0, ("default",))
    np.testing.assert_array_equal(scene.materials[0].diffuse, [0.5] * 3)
    assert any("reflects 0.5 of all light" in note for note in scene.notes)
    assert any("metres" in note for note in scene.notes)
    assert scene.cameras["default"].size == (512, 512)


def test_unit_and_axis_of_bare_geometry_may_be_told(tmp_path):
    (tmp_path / "room.obj").write_text(OBJ)
    scene = load(tmp_path / "room.obj", unit="mm", up="y")
    assert (scene.unit, scene.unit_m, scene.up) == ("mm", 0.001, "y")
    assert not any("metres" in note for note in scene.notes)
    np.testing.assert_array_equal(scene.faces.vertices, load(tmp_path / "room.obj").faces.vertices)
    told_of = (({"unit": "yd"}, 'unit = "yd" must be one of m,'), ({"up": "w"}, "x, y, z"))
    for wrong, told in told_of:
        with pytest.raises(ValueError, match=told):
            load(tmp_path / "room.obj", **wrong)
    (tmp_path / "a.toml").write_text('[[geometry]]\nfile = "room.obj"\n')
    with pytest.raises(ValueError, match="says its unit and up itself"):
        load(tmp_path / "a.toml", up="y")


def test_default_camera_stands_outside_and_sees_every_vertex(tmp_path):
    (tmp_path / "a.stl").write_bytes(STL)
    scene = load(tmp_path / "a.stl")
    camera, points = scene.cameras["default"], scene.faces.vertices.reshape(-1, 3)
    axis = camera.target - camera.position
    axis /= np.linalg.norm(axis)
    right = np.cross(axis, camera.up)
    right /= np.linalg.norm(right)
    rays = points - camera.position
    depth = rays @ axis
    assert (depth > 0).all()
    half = np.tan(np.radians(camera.fov / 2))
    assert (np.abs(rays @ right) < half * depth).all()
    assert (np.abs(rays @ np.cross(right, axis)) < half * depth).all()
    np.testing.assert_allclose(camera.target, (points.min(axis=0) + points.max(axis=0)) / 2)


@pytest.mark.parametrize(
    ("name", "content", "text"),
    [
        ("a.ply", b"", "is not a PLY file that can be read"),
        ("a.ply", b"garbage\n\xff\x00", "is not a PLY file that can be read"),
        (
            "a.ply",
            PLY.format(faces=1, z=0, face="3 0 1 9").encode(),
            "names a vertex that does not",
        ),
        (
            "a.ply",
            PLY.format(faces=1, z=0, face="3 0 1 -1").encode(),
            "names a vertex that does not",
        ),
        ("a.ply", PLY.format(faces=1, z="nan", face="3 0 1 2").encode(), "vertex 2 = "),
        ("a.ply", PLY.format(faces=1, z=0, face="3 0 1 1").encode(), "there is nothing to light"),
        ("a.ply", PLY.split("element face")[0].encode() + b"end_header\n0 0 0\n", "has no faces"),
        ("a.stl", b"garbage", "has no faces"),
        ("a.stl", STL[:100], "1 triangles, which take 134 bytes, and has 100: it was cut off"),
        ("a.stl", STL[:80] + bytes(4), "has no faces: nothing can be lit"),
        ("a.stl", STL[:96] + struct.pack("<f", np.inf) + STL[100:], "must be finite"),
        (
            "a.obj",
            b"v 0 0 0\nf 1 1 1\n",
            "there is nothing to light: none of its 1 faces has an area",
        ),
        ("a.obj", b"\xff\xfe\x00", "has no faces"),
        (
            "a.off",
            b"OFF",
            'has the suffix ".off": scenes are .toml files, geometry is read from .obj, ',
        ),
        ("a", b"OFF", "has no suffix: scenes are .toml"),
        ("a.toml", b"\x89PNG", "line 1 is not UTF-8"),
        ("a.toml", b"name = 1\n\n# \xe9", "line 3 is not UTF-8: save the file in that encoding"),
    ],
)
def test_broken_files_are_named_with_their_fault(tmp_path, name, content, text):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match="a") as error:
        load(tmp_path / name)
    assert error.value.source == str(tmp_path / name)
    assert text in str(error.value)


def test_what_is_no_file(tmp_path):
    (tmp_path / "room.obj").write_text(OBJ)
    (tmp_path / "d.obj").mkdir()
    os.mkfifo(tmp_path / "pipe.obj")
    assert problems(load, tmp_path / "rom.obj") == ["does not exist: did you mean room.obj?"]
    assert problems(load, tmp_path / "moo.obj") == ["does not exist"]
    assert problems(load, tmp_path / "no" / "x.obj") == [
        f"does not exist: there is no folder {tmp_path / 'no'}"
    ]
    assert problems(load, tmp_path / "d.obj") == ["is a folder: name a file in it"]
    assert problems(load, tmp_path / "pipe.obj") == ["is not a regular file"]
    assert "cannot be read" in problems(load, tmp_path / ("x" * 300 + ".obj"))[0]
    assert "does not exist" in problems(load, "a\0.toml")[0] or "null" in str(
        problems(load, "a\0.toml")
    )


def test_too_large_files_are_refused_before_they_are_read(tmp_path):
    path = tmp_path / "big.toml"
    with open(path, "wb") as file:
        file.truncate(files.LARGEST + 1)
    assert problems(load, path) == [
        "has 1073741825 bytes, at most 1073741824 (1 GiB) are read: reduce the mesh"
    ]


@pytest.fixture
def house(tmp_path):
    """A folder with a scene beside a file that the scene must not reach."""
    (tmp_path / "secret.obj").write_text(OBJ)
    (tmp_path / "scene").mkdir()
    return tmp_path / "scene"


@pytest.mark.parametrize(
    "name", ["../secret.obj", "sub/../../secret.obj", "link.obj", "{absolute}"]
)
def test_scene_reads_nothing_outside_its_folder(house, name):
    (house / "sub").mkdir()
    (house / "link.obj").symlink_to(house.parent / "secret.obj")
    name = name.format(absolute=house.parent / "secret.obj")
    (house / "a.toml").write_text(f'[[geometry]]\nfile = "{name}"\n')
    found = problems(load, house / "a.toml")
    assert len(found) == 1
    assert found[0].startswith(f'geometry[0].file = "{name}"'[:60])
    assert f"lies outside the scene's folder {house}" in found[0]
    assert "copy the file there" in found[0]


def test_scene_reads_under_its_folder_and_links_within_it(house):
    (house / "sub").mkdir()
    (house / "sub" / "a.obj").write_text(OBJ)
    (house / "link.obj").symlink_to(house / "sub" / "a.obj")
    text = '[[geometry]]\nfile = "sub/../sub/a.obj"\n[[geometry]]\nfile = "link.obj"\n'
    (house / "a.toml").write_text(text)
    assert load(house / "a.toml").groups == ("default", "default-2")


def test_link_that_names_itself_is_reported(house):
    (house / "loop.obj").symlink_to(house / "loop.obj")
    (house / "a.toml").write_text('[[geometry]]\nfile = "loop.obj"\n')
    assert 'geometry[0].file = "loop.obj"' in problems(load, house / "a.toml")[0]


def test_library_outside_the_folder_is_refused_and_inside_is_read(house):
    (house.parent / "m.mtl").write_text("newmtl a\nKd 0.1 0.1 0.1\n")
    (house / "in.mtl").write_text("newmtl a\nKd 0.2 0.2 0.2\n")
    (house / "x.obj").write_text("mtllib ../m.mtl\nusemtl a\n" + OBJ)
    assert "line 1: mtllib ../m.mtl: lies outside" in problems(load, house / "x.obj")[0]
    (house / "x.obj").write_text("mtllib in.mtl\nusemtl a\n" + OBJ)
    np.testing.assert_array_equal(load(house / "x.obj").materials[0].diffuse, [0.2] * 3)
    (house / "a.toml").write_text(
        '[[geometry]]\nfile = "x.obj"\n[materials.a]\ndiffuse = 0.3\n'  # the scene's own wins
    )
    np.testing.assert_array_equal(load(house / "a.toml").materials[0].diffuse, [0.3] * 3)


def test_geometry_named_by_the_user_may_lie_anywhere(house):
    (house / "link.obj").symlink_to(house.parent / "secret.obj")
    assert len(load(house / "link.obj").faces) == 1
    assert len(read_geometry(house / ".." / "secret.obj").faces) == 1


def test_materials_of_libraries_reach_the_scene_each_with_its_own(house):
    for name, kd in (("x", 0.1), ("y", 0.2)):
        (house / f"{name}.mtl").write_text(
            f"newmtl a\nKd {kd} {kd} {kd}\nnewmtl {name}\nKd 0 0 0\n"
        )
        (house / f"{name}.obj").write_text(
            f"mtllib {name}.mtl\n" + OBJ + f"usemtl a\nf 1 2 3\nusemtl {name}\nf 1 2 3\n"
        )
    (house / "a.toml").write_text('[[geometry]]\nfile = "x.obj"\n[[geometry]]\nfile = "y.obj"\n')
    made = {m.name: m.diffuse[0] for m in load(house / "a.toml").materials}
    assert made == {"default": 0.5, "a": 0.1, "a-2": 0.2, "x": 0, "y": 0}


@pytest.mark.parametrize("end", ["\r", "\r\n"])
def test_line_ends_of_other_systems_are_read(tmp_path, end):
    text = OBJ.replace("f 1 2", "f 1 \\\n 2") + "f 1 2\n"
    (tmp_path / "a.obj").write_bytes(text.replace("\n", end).encode())
    assert problems(load, tmp_path / "a.obj") == [
        "line 7: f 1 2: a face needs at least 3 corners, found 2"
    ]


def test_bom_and_carriage_returns_are_read(tmp_path):
    (tmp_path / "a.obj").write_bytes(b"\xef\xbb\xbf" + OBJ.replace("\n", "\r\n").encode())
    (tmp_path / "a.toml").write_bytes(b'\xef\xbb\xbf[[geometry]]\r\nfile = "a.obj"\r\n')
    assert len(load(tmp_path / "a.toml").faces) == 1


def test_heavy_packages_are_imported_only_where_they_are_used():
    code = (
        "import sys, radiosity.scene.files; "
        "print([m for m in ('trimesh', 'pydantic', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda p: p.stem)
def test_shipped_scenes_load_without_a_note(path):
    scene = load(path)
    assert scene.notes == ()
    assert len(scene.faces) > 0
    assert scene.has_light


@pytest.mark.parametrize("name", ["furnace", "box6", "sphere"])
def test_closed_scenes_with_a_truth_look_inward(name):
    faces = load(SCENES / f"{name}.toml").faces
    inward = faces.vertices.mean(axis=(0, 1)) - faces.vertices.mean(axis=1)
    assert ((inward * faces.normals()).sum(axis=1) > 0).all()
    areas = faces.areas()[:, None] * faces.normals()
    np.testing.assert_allclose(areas.sum(axis=0), 0, atol=1e-12)  # closed: no net vector area


def test_the_cornell_box_is_the_measured_one():
    scene = load(SCENES / "cornell_box.toml")
    names = [m.name for m in scene.materials]
    area = {n: scene.faces.areas()[scene.faces.material == k].sum() for k, n in enumerate(names)}
    assert area["light"] == pytest.approx(130 * 105)
    assert scene.unit_m == 0.001
    light = scene.faces.normals()[scene.faces.material == names.index("light")]
    np.testing.assert_allclose(light, [[0, -1, 0]])
    red = scene.faces.material == names.index("red")
    assert scene.faces.is_triangle[red].all()  # that wall is not planar as measured
    assert not scene.faces.is_triangle[~red].any()


def test_files_beside_are_taken_where_the_named_place_has_none(house):
    """Also where that lies outside of the folder; only such files are refused that are nowhere."""
    (house / "room.mtl").write_text("newmtl a\nKd 0.2 0.2 0.2\nmap_Kd x/wood.png\n")
    face = OBJ + "vt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"
    for place in ("/home/me/room.mtl", "../room.mtl", "lib\\room.mtl", "../room.mtl room.mtl",
                  "room.mtl gone.mtl"):
        (house / "a.obj").write_text(f"mtllib {place}\n" + face)
        made = {m.name: m.diffuse[0] for m in load(house / "a.obj").materials}
        assert made["a"] == 0.2, place
    assert "the material library gone.mtl is not there" in str(load(house / "a.obj").notes)
    long = 300 * "a"
    (house / "room.mtl").write_text(f"newmtl a\nKd 0.2 0.2 0.2\nmap_Kd {long}.png\n")
    (house / "a.obj").write_text(f"mtllib room.mtl {long}.mtl\n" + face)
    assert "Kd stands" in str(load(house / "a.obj").notes)
    (house / "a.rad").write_text(f"!xform {long}.rad\nvoid plastic a 0 0 5 1 1 1 0 0\n"
                                 "a polygon p 0 0 9 0 0 0 1 0 0 1 1 0\n")  # fmt: skip
    assert "is not there" in str(load(house / "a.rad").notes)


def test_pictures_of_a_library_are_named_from_the_scenes_folder(house, monkeypatch):
    import imageio.v3

    (house / "sub").mkdir()
    imageio.v3.imwrite(house / "sub" / "wood.png", np.full((2, 2, 3), 188, np.uint8))
    (house / "sub" / "a.mtl").write_text("newmtl a\nmap_Kd wood.png\n")
    text = "mtllib a.mtl\n" + OBJ + "vt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\n"
    (house / "sub" / "a.obj").write_text(text.replace("f 1 2 3\n", ""))
    (house / "a.toml").write_text('[[geometry]]\nfile = "sub/a.obj"\n')
    for here in (house, house.parent, house / "sub"):
        monkeypatch.chdir(here)
        table = load(house / "a.toml").read_as["a"].table
        assert table["diffuse"]["texture"] == "sub/wood.png"
        assert load(house / "sub" / "a.obj").read_as["a"].table["diffuse"]["texture"] == "wood.png"
