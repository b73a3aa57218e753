"""What geometry files say beside their faces joins the tables of a scene, placed with them."""

import numpy as np
import pytest

from radiosity.mesh.faces import Faces
from radiosity.scene.geometry import Geometry
from radiosity.scene.model import ReadAs
from radiosity.scene.toml import read_tables

SQUARE = np.array([[[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]])
SPOT = {
    "type": "spot", "position": [1.0, 2.0, 3.0], "target": [1.0, 2.0, 0.0], "beam_angle": 10,
    "cutoff_angle": 20, "luminous_intensity": 683.0,
}  # fmt: skip
EYE = {"position": [0.0, 0, 5], "target": [0.0, 0, 0], "up": [0.0, 1, 0], "fov": 30}
COAT = {"diffuse": [0.1, 0.2, 0.3], "ior": 1.5, "mirror": "fresnel"}


def brought(unit=None, up=None, **more):
    faces = Faces.from_polygons(SQUARE, 0, 0)
    parts = {
        "materials": {"coat": ReadAs("Kd 0.1 0.2 0.3", COAT)}, "lights": (SPOT,),
        "cameras": {"eye": EYE}, "unit": unit, "up": up,
    }  # fmt: skip
    return Geometry(faces, ("coat",), ("square",), **(parts | more))


def scene(geometry, block=None, file="a.obj", **tables):
    raw = {"geometry": [{"file": file, **(block or {})}], **tables}
    return read_tables(raw, "x.toml", lambda name, uv: geometry)


def test_a_files_materials_lights_and_cameras_are_the_scenes():
    found = scene(brought())
    coat = found.materials[0]
    np.testing.assert_array_equal(coat.diffuse, COAT["diffuse"])
    assert coat.mirror is not None
    np.testing.assert_array_equal(found.lights[0].position, [1, 2, 3])
    np.testing.assert_allclose(found.lights[0].intensity, 1.0)  # 683 cd
    assert found.cameras["eye"].fov == 30
    assert found.read_as == {"coat": ReadAs("Kd 0.1 0.2 0.3", COAT)}
    assert not any("camera" in note or "not defined" in note for note in found.notes)


def test_the_scene_files_own_definitions_win():
    own = {"coat": {"diffuse": 0.7}}
    camera = {"eye": {"position": [9, 0, 0], "target": [0, 0, 0]}}
    light = {"type": "point", "position": [5, 5, 5], "intensity": 2}
    found = scene(brought(), materials=own, cameras=camera, lights=[light])
    np.testing.assert_array_equal(found.materials[0].diffuse, [0.7] * 3)
    assert found.read_as == {"coat": ReadAs("as the scene file has it", {"diffuse": 0.7})}
    assert list(found.cameras) == ["eye", "eye-2"]
    assert found.cameras["eye"].position[0] == 9
    assert [type(s).__name__ for s in found.lights] == ["Point", "Spot"]


def test_files_that_describe_a_material_differently_keep_their_own():
    other = brought(materials={"coat": ReadAs("b", {"diffuse": 0.7})})
    files = {"a.obj": brought(), "b.obj": other}
    raw = {"geometry": [{"file": "a.obj"}, {"file": "b.obj", "translate": [0, 0, 1]}]}
    found = read_tables(raw, "x.toml", lambda name, uv: files[name])
    assert [m.name for m in found.materials] == ["coat", "coat-2"]
    np.testing.assert_array_equal(found.materials[1].diffuse, [0.7] * 3)
    assert found.faces.material.tolist() == [0, 1]
    told = 'two files describe the material "coat" differently: the second one is called "coat-2"'
    assert found.notes == (told,)
    own = read_tables(raw | {"materials": {"coat": {"diffuse": 0.1}}}, "x", lambda n, uv: files[n])
    assert [m.name for m in own.materials] == ["coat"] and own.notes == ()


def test_unused_materials_of_a_file_are_left_out_without_a_note():
    materials = {"coat": ReadAs("a", COAT), "spare": ReadAs("b", {"diffuse": 0.5})}
    found = scene(brought(materials=materials))
    assert [m.name for m in found.materials] == ["coat"]
    assert found.notes == ()


def test_lights_and_cameras_are_placed_with_their_faces():
    block = {"rotate": [0, 0, 90], "scale": 2, "translate": [10, 0, 0]}
    found = scene(brought(), block)
    np.testing.assert_allclose(found.faces.vertices[0, 1], [10, 4, 0], atol=1e-12)
    np.testing.assert_allclose(found.lights[0].position, [6, 2, 6], atol=1e-12)
    np.testing.assert_allclose(found.lights[0].axis, [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(found.cameras["eye"].up, [-2, 0, 0], atol=1e-12)
    plan = {key: value for key, value in EYE.items() if key != "fov"} | {
        "projection": "orthographic", "height": 3.0,
    }  # fmt: skip
    assert scene(brought(cameras={"eye": plan}), block).cameras["eye"].height == pytest.approx(6)


@pytest.mark.parametrize(
    ("of_file", "of_scene", "point"),
    [
        ("y", "z", [1, -3, 2]), ("z", "y", [1, 3, -2]), ("x", "z", [-3, 2, 1]),
        ("z", "x", [3, 2, -1]), ("x", "y", [-2, 1, 3]), ("y", "x", [2, -1, 3]),
        ("z", "z", [1, 2, 3]),
    ],
)  # fmt: skip
def test_axes_turn_the_short_way(of_file, of_scene, point):
    found = scene(brought(), {"up": of_file}, up=of_scene)
    np.testing.assert_allclose(found.lights[0].position, point, atol=1e-15)
    area = found.faces.areas()  # and faces go along
    np.testing.assert_allclose(area, 2.0)
    front = found.faces.normals()[0]
    moved = {"z": [0, 0, 1], "y": [0, 1, 0], "x": [1, 0, 0]}[of_scene]
    if of_file == "z":
        np.testing.assert_allclose(front, moved, atol=1e-15)


def test_a_blocks_unit_and_axis_are_its_own():
    found = scene(brought(), {"unit": "cm"}, unit="mm")
    np.testing.assert_allclose(found.faces.vertices[0, 2], [20, 10, 0])
    assert (found.unit, found.unit_m) == ("mm", 0.001)
    np.testing.assert_allclose(found.lights[0].position, [10, 20, 30])


def test_a_format_that_fixes_unit_and_axis_is_converted():
    found = scene(brought("m", "y"), unit="cm", up="z")
    np.testing.assert_allclose(found.faces.vertices[0, 2], [200, 0, 100], atol=1e-12)
    assert found.up == "z"
    override = scene(brought("m", "y"), {"unit": "cm", "up": "z"}, unit="cm", up="z")
    np.testing.assert_array_equal(override.faces.vertices, SQUARE)


def test_up_is_y_where_all_geometry_is_gltf():
    assert scene(brought("m", "y"), file="a.GLB").up == "y"
    assert scene(brought()).up == "z"
    square = {"polygons": SQUARE.tolist(), "material": "coat"}
    raw = {"geometry": [{"file": "a.glb"}, square]}
    assert read_tables(raw, "x.toml", lambda name, uv: brought("m", "y")).up == "z"


def test_pictures_that_a_file_brings_are_its_textures():
    uv = np.array([[[0.0, 0], [1, 0], [1, 1], [0, 1]]])
    faces = Faces.from_polygons(SQUARE, 0, 0, uv=uv)
    texture = {"diffuse": {"texture": "a.glb/0.png", "encoding": "linear"}}
    geometry = Geometry(
        faces, ("wood",), ("square",), {"wood": ReadAs("image 0", texture)},
        pictures={"a.glb/0.png": np.array([[[51], [153]]], np.uint8)},
    )  # fmt: skip
    found = scene(geometry)
    np.testing.assert_allclose(found.materials[0].diffuse, 0.4, rtol=1e-6)  # (51 + 153)/2/255
