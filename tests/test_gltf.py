"""glTF files: geometry, nodes, lights and cameras as numpy has them, and what is refused."""

import json
import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import trimesh
from gltf_for_tests import SQUARE, TWO, Gltf, square

import radiosity
from radiosity.light.photometry import luminance
from radiosity.scene.files import load, read_geometry
from radiosity.scene.gltf.document import Names
from radiosity.scene.gltf.gltf import read_gltf
from radiosity.scene.model import SceneError

SCENES = Path(__file__).resolve().parent.parent / "scenes"
TILTED = {"translation": [1, 2, 3], "rotation": [0, 0, 0.6, 0.8], "scale": [2, 3, 4]}
TURN = np.array([[0.28, -0.96, 0], [0.96, 0.28, 0], [0, 0, 1]])  # of the quaternion above


def nothing(name):
    raise SceneError(name, ["does not exist"])


def read(made, read_file=nothing, **more):
    data = made if isinstance(made, bytes) else made.glb()
    return read_gltf(data, "x.glb", read_file, **more)


def corners(geometry):
    return geometry.faces.vertices


def problem(made, read_file=nothing):
    with pytest.raises(SceneError) as caught:
        read(made, read_file)
    assert len(caught.value.problems) == 1
    return caught.value.problems[0]


def test_two_triangles_are_a_rectangle_in_metres_with_y_up():
    found = read(square(name="wall"))
    np.testing.assert_array_equal(corners(found), [SQUARE])
    assert (found.unit, found.up, found.group_names) == ("m", "y", ("wall",))
    assert read(square(), merge=False).given.count == 2


def test_text_and_binary_files_are_the_same(tmp_path):
    made = square(**TILTED)
    inside, beside = read(made.embedded()), read(
        json.dumps(made.tree(uri="a%20b.bin")).encode(), {"a b.bin": made.data}.__getitem__
    )
    for other in (inside, beside):
        np.testing.assert_array_equal(corners(other), corners(read(made)))
    (tmp_path / "a.gltf").write_bytes(made.embedded())
    np.testing.assert_array_equal(corners(read_geometry(tmp_path / "a.gltf")), corners(inside))


@pytest.mark.parametrize(("mode", "index", "expected"), [
    (4, TWO, [[0, 1, 2], [0, 2, 3]]),
    (5, [0, 1, 3, 2], [[0, 1, 3], [1, 2, 3]]),
    (6, [0, 1, 2, 3], [[1, 2, 0], [2, 3, 0]]),
    (6, None, [[1, 2, 0], [2, 3, 0]]),
])  # fmt: skip
def test_lists_strips_and_fans(mode, index, expected):
    made = Gltf()
    made.node(mesh=made.mesh(made.primitive(SQUARE, index, mode=mode)))
    found = read(made, merge=False).faces
    np.testing.assert_array_equal(found.vertices[:, :3], SQUARE[expected])
    np.testing.assert_allclose(found.normals(), [[0, 0, 1]] * 2)


def accessor_of(kind):
    """Return a file whose positions are stored in some way, and what they are."""
    rng, made = np.random.default_rng(5), Gltf()
    real = rng.normal(size=(4, 3)).astype("f4")
    whole = rng.integers(-100, 100, (4, 3))
    if kind == "strided":
        row = np.zeros((4, 5), "<f4")
        row[:, 1:4] = real
        view = made.view(row.tobytes(), byteStride=20)
        place = made.add("accessors", bufferView=view, byteOffset=4, componentType=5126, count=4,
                         type="VEC3")  # fmt: skip
    elif kind == "sparse":
        place = made.accessor(real)
        real[[1, 3]] += 1
        made.json["accessors"][place]["sparse"] = {
            "count": 2,
            "indices": {"bufferView": made.view(np.array([1, 3], "u1")), "componentType": 5121},
            "values": {"bufferView": made.view(real[[1, 3]].tobytes())},
        }
    elif kind == "normalised":
        place, real = made.accessor(whole, "i1", normalized=True), whole / 127
    else:
        place, real = made.accessor(whole, "i2"), whole
    made.node(mesh=made.mesh(made.primitive(place, [0, 1, 2, 0, 2, 3])))
    return made, real


@pytest.mark.parametrize("kind", ["strided", "sparse", "normalised", "whole"])
def test_accessors_agree_with_numpy(kind):
    made, points = accessor_of(kind)
    triangles = np.asarray(points, float)[[0, 1, 2, 0, 2, 3]].reshape(2, 3, 3)
    np.testing.assert_allclose(read(made, merge=False).faces.vertices[:, :3], triangles, rtol=1e-6)


def test_nodes_move_what_is_below_them():
    made = square(**TILTED)
    matrix = np.eye(4)
    matrix[:3, 3] = 10, 20, 30
    made.node(children=[0], matrix=matrix.T.ravel().tolist())
    expected = (SQUARE * [2, 3, 4]) @ TURN.T + [11, 22, 33]
    np.testing.assert_allclose(corners(read(made))[0], expected, atol=1e-12)


def test_reflections_keep_fronts_and_normals():
    bent = np.array([[0.6, 0, 0.8], [0, 0, 1], [0, 0, 1], [0.6, 0, 0.8]])
    made = square(NORMAL=bent, scale=[-1, 1, 1])
    faces = read(made).faces
    np.testing.assert_allclose(faces.normals(), [[0, 0, 1]])
    at = {tuple(v): n for v, n in zip(faces.vertices[0], faces.corner_normals[0], strict=True)}
    np.testing.assert_allclose(at[0, 0, 0], [-0.6, 0, 0.8], atol=1e-7)
    stretched = read(square(NORMAL=bent, scale=[1, 1, 2])).faces.corner_normals[0]
    expected = np.array([1.2, 0, 0.8]) / np.hypot(1.2, 0.8)
    np.testing.assert_allclose(stretched[0], expected, atol=1e-7)


def test_normals_of_flat_faces_are_none():
    assert read(square(NORMAL=[[0, 0, 1]] * 4)).faces.corner_normals is None


def test_one_mesh_stands_where_nodes_and_instances_have_it():
    made = square(name="chair")
    made.node(mesh=0, name="chair", translation=[0, 0, 5])
    places = made.accessor([[0, 0, 7], [0, 0, 9]])
    made.node(mesh=0, name="rows",
              extensions={"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}})
    made.node(mesh=0, extensions={"KHR_node_visibility": {"visible": False}})
    found = read(made)
    assert corners(found)[:, 0, 2].tolist() == [0, 5, 7, 9]
    assert found.group_names == ("chair", "chair-2", "rows")
    assert found.faces.group.tolist() == [0, 1, 2, 2]
    assert any("not visible" in note for note in found.notes)


def test_skins_and_morphs_stand_as_the_file_has_them():
    made = Gltf()
    moved = made.accessor([[0, 0, 4]] * 4)
    joints = made.accessor([[0, 1, 0, 0]] * 4, "u1")
    shares = made.accessor([[0.25, 0.75, 0, 0]] * 4)
    mesh = made.mesh(
        made.primitive(SQUARE, TWO, targets=[{"POSITION": moved}], JOINTS_0=joints,
                       WEIGHTS_0=shares),
        weights=[0.5],
    )  # fmt: skip
    bind = np.tile(np.eye(4).ravel(), (2, 1))
    bind[1, 14] = -1.0  # moved by -1 along z before the joint moves it
    made.node(mesh=mesh, skin=0, translation=[50, 0, 0])  # a skin ignores its node
    made.node(translation=[0, 0, 8])
    made.node(translation=[0, 0, 16])
    made.add("skins", joints=[1, 2], inverseBindMatrices=made.accessor(bind))
    found = read(made)
    expected = SQUARE + [0, 0, 2 + 0.25 * 8 + 0.75 * 15]
    np.testing.assert_allclose(corners(found)[0], expected, atol=1e-12)
    assert sum("pose" in note or "morph" in note for note in found.notes) == 2
    assert not any("joints" in note and "more than 4" in note for note in found.notes)
    made.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_1"] = joints
    told = "skinned meshes of more than 4 joints a vertex: the first 4 count (1)"
    assert told in read(made).notes


def test_only_the_default_scene_counts():
    made = square()
    made.node(mesh=0, translation=[0, 0, 5])
    made.json |= {"scenes": [{"nodes": [0]}, {"nodes": [1]}], "scene": 1}
    found = read(made)
    assert corners(found)[0, 0, 2] == 5
    assert found.notes == ("meshes outside of the scene that is shown: left out (1)",)


def test_points_and_lines_are_noted():
    made = square()
    made.json["meshes"][0]["primitives"].append(made.primitive(SQUARE, mode=1))
    assert any("points or lines" in note and "(1)" in note for note in read(made).notes)


def test_lights_shine_along_minus_z_in_candela_and_lux():
    made = square()
    down = {"rotation": [-0.7071067811865476, 0, 0, 0.7071067811865476], "name": "lamp"}
    made.light({"translation": [0, 3, 0]}, type="point", intensity=683, color=[1, 0.5, 0.25])
    made.light(down, type="directional", intensity=1366, range=3)
    made.light(down | {"translation": [0, 3, 0]}, type="spot", intensity=683,
               spot={"innerConeAngle": 0.1, "outerConeAngle": 0.2})  # fmt: skip
    found = read(made)
    point, sun, spot = found.lights
    assert (point["position"], point["intensity"]) == ([0, 3, 0], [1, 0.5, 0.25])
    np.testing.assert_allclose(sun["direction"], [0, -1, 0], atol=1e-15)
    assert sun["irradiance"] == [2, 2, 2] and sun["group"] == "lamp"
    np.testing.assert_allclose(spot["target"], [0, 2, 0], atol=1e-15)
    np.testing.assert_allclose(np.radians([spot["beam_angle"], spot["cutoff_angle"]]), [0.1, 0.2])
    assert any("1 lights have a range" in note for note in found.notes)


def test_a_point_light_lights_as_its_candela_say(tmp_path):
    made = square({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0}})
    made.light({"translation": [1, 0.5, 2]}, type="point", intensity=100)
    (tmp_path / "a.glb").write_bytes(made.glb())
    solution = radiosity.solve(load(tmp_path / "a.glb"), accuracy=0.1)
    E, _ = solution.irradiance(np.array([[1, 0.5, 0]]), np.array([[0, 0, 1.0]]))
    assert 683 * luminance(E)[0] == pytest.approx(100 / 2**2, rel=1e-6)  # I/d^2 in lx


def test_cameras_are_where_their_nodes_are(tmp_path):
    made = square()
    made.add("cameras", type="perspective", name="eye",
             perspective={"yfov": 0.5, "aspectRatio": 2, "znear": 0.1})  # fmt: skip
    made.add("cameras", type="orthographic",
             orthographic={"xmag": 3, "ymag": 1.5, "znear": 0, "zfar": 9})  # fmt: skip
    made.node(camera=0, rotation=[0, 0.5**0.5, 0, 0.5**0.5], translation=[4, 0, 1])
    made.node(camera=1, name="plan")
    made.node(camera=1, name="flat", scale=[1, 0, 1])
    (tmp_path / "a.glb").write_bytes(made.glb())
    scene = load(tmp_path / "a.glb")
    eye, plan = scene.cameras.values()
    assert "cameras of nodes that are flattened: left out (1)" in scene.notes
    assert (eye.name, eye.size, plan.name, plan.size) == ("eye", (1024, 512), "plan", (1024, 512))
    np.testing.assert_allclose(eye.target - eye.position, [-1, 0, 0], atol=1e-12)
    assert np.radians(eye.fov) == pytest.approx(0.5)
    assert (plan.fov, plan.height) == (None, 3)


def test_units_and_axes_in_a_scene_file(tmp_path):
    (tmp_path / "a.glb").write_bytes(square(name="wall").glb())
    text = 'unit = "cm"\nup = "z"\n[[geometry]]\nfile = "a.glb"\n'
    (tmp_path / "a.toml").write_text(text)
    scene = load(tmp_path / "a.toml")
    np.testing.assert_allclose(scene.faces.vertices[0, 2], [200, 0, 100], atol=1e-9)
    bare = load(tmp_path / "a.glb")
    assert (bare.unit, bare.up, bare.groups) == ("m", "y", ("wall",))


def test_only_files_in_the_scenes_folder_are_opened(tmp_path):
    made, folder = square(), tmp_path / "room"
    folder.mkdir()
    (tmp_path / "out.bin").write_bytes(made.data)
    for uri, words in (
        ("../out.bin", "lies outside"), (str(tmp_path / "out.bin"), "lies outside"),
        ("http://a.example/b.bin", "is not read"), ("lost.bin", "does not exist"),
        ("data:;base64,A", "is not base64"), ("data:", "has no comma"),
    ):  # fmt: skip
        (folder / "a.gltf").write_text(json.dumps(made.tree(uri=uri)))
        with pytest.raises(SceneError, match=words):
            load(folder / "a.gltf")


def changed(kind, number=0, **values):
    made = square()
    made.json["scenes"] = [{"nodes": [0]}]
    entry = made.json[kind][number]
    for key, value in values.items():
        entry[key] = value
    return made


@pytest.mark.parametrize(("made", "words"), [
    (changed("accessors", count=5), "accessors[0].count = 5 needs 60 bytes of a buffer view"),
    (changed("accessors", count=10**9), "must be a whole number from 1 to"),
    (changed("accessors", count="4"), 'accessors[0].count = "4" must be a whole number'),
    (changed("accessors", componentType=5124), "must be one of 5120"),
    (changed("accessors", type="VEC9"), 'type "VEC9", must be VEC3'),
    (changed("accessors", bufferView=7), "names bufferViews[7], there are 2, counted from 0"),
    (changed("accessors", 1, componentType=5122), "numbers that are not whole"),
    (changed("bufferViews", byteLength=1000), "ends at byte 1000 of a buffer that has 60"),
    (changed("bufferViews", byteStride=4), "byteStride of 4, elements have 12 bytes"),
    (changed("bufferViews", byteOffset=-4), "bufferViews[0].byteOffset = -4 must be a whole"),
    (changed("scenes", nodes=[0, 0]), "nodes[0] a second time: nodes must form a tree"),
    (changed("nodes", children=[0]), "nodes[0] a second time: nodes must form a tree"),
    (changed("nodes", matrix=[0.0] * 16), "must keep planes planar"),
    (changed("nodes", matrix=[1] * 15), "must be a list of 16 numbers"),
    (changed("nodes", mesh=None), "nodes[0].mesh = None must be a whole number"),
    (changed("nodes", scale=[1e300, 1, 1]), "must be a list of 3 numbers"),
    (changed("nodes", scale=[1e40, 1, 1]), "farther away than 1e+30"),
])  # fmt: skip
def test_wrong_numbers_are_told_with_place_and_bound(made, words):
    assert words in problem(made)


def test_wrong_containers_are_told():
    good = square().glb()
    size = len(good)
    assert f"says that it has {size} bytes, but has {size - 9}" in problem(good[:-9])
    assert "version 1, 2 is read" in problem(good[:4] + struct.pack("<I", 1) + good[8:])
    assert "has 7 bytes" in problem(good[:7])
    assert "not valid JSON" in problem(b"{nodes")
    assert "nested too deeply" in problem(b"[" * 100_000)
    assert "values in its JSON" in problem(b'{"a":[' + b"1," * (1 << 22) + b"1]}")
    assert "not UTF-8" in problem(b'{"a": "\xff"}')
    old = square()
    old.json["asset"]["version"] = "1.0"
    assert "export the scene again as 2.0" in problem(old)
    assert "no triangles" in problem(Gltf())


@pytest.mark.parametrize(("point", "words"), [
    (np.nan, "must be finite"), (np.inf, "must be finite"), (3e38, "at most 1e+30"),
])  # fmt: skip
def test_points_are_finite(point, words):
    made, points = Gltf(), SQUARE.copy()
    points[2, 1] = point
    made.node(mesh=made.mesh(made.primitive(points, TWO)))
    assert "vertex 2" in problem(made) and words in problem(made)


def test_index_out_of_range():
    made = Gltf()
    made.node(mesh=made.mesh(made.primitive(SQUARE, [0, 1, 4])))
    assert "indices = 1 names vertex 4, there are 4, counted from 0" in problem(made)


def test_more_triangles_than_are_read_are_refused_before_they_are_made():
    made = Gltf()
    many = made.primitive(SQUARE, mode=5)
    many["indices"] = made.add("accessors", componentType=5125, count=1 << 23, type="SCALAR")
    made.node(mesh=made.mesh(many))
    tracemalloc.start()
    assert "8388606 triangles or more" in problem(made)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 200e6  # bytes; their corners alone would take 600 million
    many["indices"] = made.add("accessors", componentType=5125, count=258, type="SCALAR")
    far = made.add("accessors", componentType=5126, count=1 << 15, type="VEC3")
    made.node(mesh=0, extensions={
        "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": far}}
    })  # fmt: skip
    assert "triangles or more, at most 4194304 are read" in problem(made)


def test_extensions_are_refused_noted_or_read():
    made = square()
    made.json |= {"extensionsUsed": ["ACME_a", "KHR_texture_transform"]}
    assert list(read(made).notes) == ["ACME_a: not modelled"]
    made.json["extensionsRequired"] = ["ACME_a"]
    assert "needs ACME_a, which is not read" in problem(made)
    packed = square()
    packed.json["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {}}
    assert read(packed).faces  # it has its points besides
    del packed.json["accessors"][0]["bufferView"]
    assert "compressed (Draco): write it without, npx @gltf-transform/cli" in problem(packed)
    squeezed = changed("bufferViews", extensions={"EXT_meshopt_compression": {}})
    assert "compressed (meshopt)" in problem(squeezed)


def test_thousands_of_equal_names_are_numbered_at_once():
    names = Names()
    found = [names.free("bolt") for _ in range(50_000)]  # counted up from 1 it takes minutes
    assert found[0] == "bolt" and found[-1] == "bolt-50000" and len(set(found)) == 50_000
    assert names.free("bolt-2") == "bolt-2-2"


def test_names_are_fit_to_print():
    assert read(square(name="a\nb\ud800\x1b[1m")).group_names == ("a b? [1m",)
    assert read(square(name="")).group_names == ("node-1",)


def test_a_model_of_others_is_read_as_trimesh_reads_it():
    path = Path(__file__).resolve().parent / "foreign" / "alien.glb"  # see SOURCES.txt there
    found = load(path)
    other = trimesh.load(path, process=False)
    areas = {}
    for mesh in other.dump():
        name = mesh.visual.material.name
        areas[name] = areas.get(name, 0.0) + mesh.area
    mine = found.faces.areas()
    for k, material in enumerate(found.materials):
        here = found.faces.material == k
        assert mine[here].sum() == pytest.approx(areas.pop(material.name), rel=1e-6)
    assert not areas
    corners = found.faces.vertices.reshape(-1, 3)
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], other.bounds, rtol=1e-6)


def cornell(path):
    """Write the Cornell box of the scene file as GLB; return it."""
    scene = load(SCENES / "cornell_box.toml")
    made = Gltf(materials=[
        {
            "name": m.name, "emissiveFactor": (m.emission / 17).tolist(),
            "pbrMetallicRoughness": {"baseColorFactor": [*m.diffuse, 1], "metallicFactor": 0},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 17 * 683}},
        } for m in scene.materials
    ])  # fmt: skip
    for k in range(len(scene.materials)):
        points = scene.faces.vertices[scene.faces.material == k][:, [0, 1, 2, 0, 2, 3]]
        made.node(mesh=made.mesh(made.primitive(points.reshape(-1, 3) / 1000, material=k)))
    path.write_bytes(made.glb())
    return scene, load(path)


def test_the_cornell_box_as_glb_is_as_bright(tmp_path):
    scene, again = cornell(tmp_path / "box.glb")
    assert len(again.faces) == len(scene.faces)  # pairs of triangles were joined
    points = np.array([[278.0, 0.1, 100], [100, 300, 558.9], [0.1, 200, 250], [450, 0.1, 450]])
    normals = np.array([[0.0, 1, 0], [0, 0, -1], [1, 0, 0], [0, 1, 0]])
    one, two = (radiosity.solve(s, accuracy=0.05) for s in (scene, again))
    expected, _ = one.irradiance(points, normals)
    found, _ = two.irradiance(points / 1000, normals)
    np.testing.assert_allclose(found, expected, rtol=0.01)  # the same faces, in single precision


def test_a_model_may_be_named_by_its_whole_path(tmp_path, monkeypatch):
    (tmp_path / "sub").mkdir()
    path = Path(__file__).resolve().parent / "foreign" / "alien.glb"
    (tmp_path / "sub" / "a.glb").write_bytes(path.read_bytes())
    whole = (tmp_path / "sub" / "a.glb").as_posix()
    (tmp_path / "sub" / "a.toml").write_text(f'[[geometry]]\nfile = "{whole}"\n')
    monkeypatch.chdir(tmp_path)
    assert len(load(Path("sub") / "a.toml").faces) == len(load(path).faces)
