"""Models with baked colours: what they hold is the solution, as glTF wants it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from glb_for_tests import Glb, validated
from scenes_for_tests import block, box, faces_of, rotation, scene

from radiosity.light.colour import RGB_TO_XYZ
from radiosity.light.photometry import photometric
from radiosity.scene.files import load
from radiosity.scene.model import Camera
from radiosity.solve.solve import solve
from radiosity.view.camera import project
from radiosity.view.export import save
from radiosity.view.gltf import Document, to_gltf
from radiosity.view.polydata import corner_radiosity, shown_patches
from radiosity.view.shading import auto_exposure

SCENES = Path(__file__).resolve().parent.parent / "scenes"
EYE, AT, UP = np.array([0.5, 0.7, 1.0]), np.array([3.0, 3.5, 1.2]), np.array([0.0, 0, 1])
CAMERAS = {
    "eye": Camera("eye", EYE, AT, UP, 60.0, (90, 60)),
    "plan": Camera("plan", np.array([2.0, 2, 2.9]), np.array([2.0, 2, 0]), np.array([0.0, 1, 0]),
                   None, (40, 40), height=4.5),
}  # fmt: skip


def room(**more):
    """A room in centimetres with a block, two groups and two materials."""
    polygons = np.concatenate([box((0, 0, 0), (4, 4, 3)), block((1, 1, 0), (2, 2, 1))])
    exitance = np.zeros((len(polygons), 3))
    exitance[1] = [3.0, 2.0, 1.0]
    made = scene(polygons, 0.5, exitance, unit="cm", unit_m=0.01, cameras=CAMERAS, **more)
    faces = faces_of(polygons, (np.arange(len(polygons)) == 1).astype(int))
    faces = replace(faces, group=(np.arange(len(polygons)) > 5).astype(int))
    return replace(made, faces=faces, materials=made.materials[:2], groups=("room", "block"))


@pytest.fixture(scope="module")
def solution():
    return solve(room(), accuracy=0.1)


@pytest.fixture(scope="module")
def path(solution, tmp_path_factory):
    place = tmp_path_factory.mktemp("glb") / "room.glb"
    save(solution, place)
    return place


def test_the_validator_finds_nothing(path):
    assert validated(path) == (0, 0)


def test_meshes_are_groups_and_materials_those_of_the_scene(path):
    tree = Glb(path).tree
    assert [m["name"] for m in tree["meshes"]] == ["room", "block"]
    assert [n["name"] for n in tree["nodes"]] == ["room", "block", "eye", "plan"]
    assert [m["name"] for m in tree["materials"]] == ["m0", "m1"]
    assert all("KHR_materials_unlit" in m["extensions"] for m in tree["materials"])
    used = [[p["material"] for p in m["primitives"]] for m in tree["meshes"]]
    assert used == [[0, 1], [0]]


def test_areas_normals_and_units_survive(solution, path):
    p = Glb(path).triangles("POSITION")
    cross = 0.5 * np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    area = np.linalg.norm(cross, axis=1)
    assert area.sum() == pytest.approx(1e-4 * (2 * 16 + 4 * 12 - 1 + 5), rel=1e-5)  # m2
    low, high = p.min(axis=(0, 1)), p.max(axis=(0, 1))
    assert (*low, *high) == pytest.approx((0, 0, -0.04, 0.04, 0.03, 0), abs=1e-8)  # y is up
    patches = solution.patches
    at = to_gltf(solution.scene, patches.centroid)
    mine = np.argmin(np.linalg.norm(p.mean(axis=1)[:, None] - at, axis=2), axis=1)
    expected = to_gltf(solution.scene, patches.normal[mine]) / solution.scene.unit_m
    assert np.einsum("tc,tc->t", cross / area[:, None], expected).min() > 0.999


def test_colours_are_linear_radiance_times_the_exposure(solution, path):
    glb, shown = Glb(path), shown_patches(solution)
    exposure = glb.tree["scenes"][0]["extras"]["exposure"]
    assert exposure == auto_exposure(solution)
    corners = to_gltf(solution.scene, solution.patches.vertices[shown]).reshape(-1, 3)
    expected = exposure * corner_radiosity(solution)[shown].reshape(-1, 3) / np.pi
    expected = np.hstack([corners, np.minimum(expected, 1.0)])
    found = np.concatenate([glb.triangles(w) for w in ("POSITION", "COLOR_0")], axis=2)
    found = found.reshape(-1, 6)
    for one, other in ((found, expected), (expected, found)):
        gap = [np.abs(one - row).max(axis=1).min() for row in other]
        assert max(gap) < 1e-6  # float32
    assert found[:, 3:].max() == 1.0 and (found[:, 3:] < 0.9).any()


def test_equal_corners_are_one_vertex(path):
    glb = Glb(path)
    for mesh in glb.tree["meshes"]:
        for part in mesh["primitives"]:
            rows = np.hstack([glb.array(n) for n in part["attributes"].values()])
            assert len(np.unique(rows, axis=0)) == len(rows)
            assert set(glb.array(part["indices"]).ravel()) == set(range(len(rows)))


def test_trimesh_reads_the_same(path):
    trimesh = pytest.importorskip("trimesh")
    read = trimesh.load(path)
    assert set(read.geometry) >= {"block"} and read.area == pytest.approx(84e-4, rel=1e-5)
    assert read.extents == pytest.approx([0.04, 0.03, 0.04])


@pytest.mark.parametrize("name", CAMERAS)
def test_cameras_see_the_same(path, name):
    """Points are projected as the specification says: node, then lens."""
    tree, camera = Glb(path).tree, CAMERAS[name]
    node = next(n for n in tree["nodes"] if n["name"] == name)
    lens = tree["cameras"][node["camera"]]
    points = np.random.default_rng(0).uniform([1, 1, 0], [3.5, 3.5, 2.5], (20, 3))
    inverse = np.linalg.inv(np.reshape(node["matrix"], (4, 4)).T)
    x, y, z = (to_gltf(room(), points) @ inverse[:3, :3].T + inverse[:3, 3]).T
    if name == "eye":
        seen = lens["perspective"]
        scale = 1 / np.tan(seen["yfov"] / 2) / -z
        across, up = x * scale / seen["aspectRatio"], y * scale
    else:
        seen = lens["orthographic"]
        across, up = x / seen["xmag"], y / seen["ymag"]
    assert np.all((-z > seen["znear"]) & (-z < seen["zfar"]))
    w, h = camera.size
    expected, _ = project(camera, camera.size, points)
    found = np.column_stack([w * (1 + across) / 2, h * (1 - up) / 2])
    assert found == pytest.approx(expected, abs=1e-6)  # pixels


@pytest.mark.parametrize("up", "xyz")
def test_up_becomes_y_without_a_mirror(up):
    made = replace(room(), up=up)
    axes = to_gltf(made, np.eye(3)) / made.unit_m
    assert axes["xyz".index(up)].tolist() == [0, 1, 0]
    assert np.linalg.det(axes) == pytest.approx(1.0) and np.array_equal(axes @ axes.T, np.eye(3))


def test_a_triangle_is_one_triangle(tmp_path):
    polygons = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0]]], float)
    save(solve(scene(polygons, 0.5, 1.0), accuracy=0.3, mesh="1"), tmp_path / "one.glb")
    assert Glb(tmp_path / "one.glb").triangles("POSITION").shape == (1, 3, 3)


def test_many_vertices_take_longer_indices():
    document = Document()
    for n in (65535, 65536):
        document.indices(np.arange(n))
    assert [a["componentType"] for a in document.tree["accessors"]] == [5123, 5125]


def test_wavelengths_become_colours(tmp_path):
    made = load(SCENES / "cornell_box_spectral.toml", bands="8")
    solution = solve(made, accuracy=0.3)
    save(solution, tmp_path / "box.glb")
    glb = Glb(tmp_path / "box.glb")
    shown = shown_patches(solution)
    lux = photometric(corner_radiosity(solution)[shown], made.bands).reshape(-1, 1) / np.pi
    corners = to_gltf(made, solution.patches.vertices[shown]).reshape(-1, 3)
    expected = np.hstack([corners, auto_exposure(solution) * lux / 683])
    colour = glb.triangles("COLOR_0").reshape(-1, 3)
    found = np.column_stack([glb.triangles("POSITION").reshape(-1, 3), colour @ RGB_TO_XYZ[1]])
    found = found[(colour < 1.0).all(axis=1)]  # nothing is clipped there; greying keeps luminance
    assert len(found) > 200 and np.ptp(colour, axis=1).max() > 0.3  # there are colours
    assert max(np.abs(expected - row).max(axis=1).min() for row in found) < 2e-6


def test_nothing_lit_is_black_and_valid(tmp_path):
    polygons = box((0, 0, 0), (1, 1, 1)) @ rotation(np.random.default_rng(1)).T
    save(solve(scene(polygons), accuracy=0.3), tmp_path / "dark.glb")
    assert not Glb(tmp_path / "dark.glb").triangles("COLOR_0").any()
    assert validated(tmp_path / "dark.glb") == (0, 0)


@pytest.mark.parametrize("up", "xyz")
def test_a_model_read_back_into_a_scene_of_the_same_axis_lies_as_it_did(up, tmp_path):
    turn = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[up]
    polygons = box((0, 0, 0), (4, 5, 3))[..., turn]
    exitance = np.full((len(polygons), 3), 1.0)
    save(solve(scene(polygons, 0.5, exitance, up=up), accuracy=0.3), tmp_path / "out.glb")
    (tmp_path / "s.toml").write_text(f'up = "{up}"\n[[geometry]]\nfile = "out.glb"\n')
    v = load(tmp_path / "s.toml").faces.vertices
    low, high = v.min(axis=(0, 1)), v.max(axis=(0, 1))
    assert low == pytest.approx(np.zeros(3), abs=1e-6)
    assert high == pytest.approx(np.array([4, 5, 3])[turn], abs=1e-6)
