"""The formats that are read: for each a right file, its suffix, and what reads and solves it."""

import base64
import io
import json
import struct
import zipfile

import numpy as np

import radiosity

BOX = """v 0 0 0
v 2 0 0
v 2 2 0
v 0 2 0
v 0 0 2
v 2 0 2
v 2 2 2
v 0 2 2
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
g floor
usemtl white
f 1/1/1 2/2/1 3/3/1 4/4/1
g ceiling
usemtl lamp
f 8 7 6 5
g walls
usemtl white
f 1 5 6 2
f 2 6 7 3
f 3 7 8
f 8 4 3
"""
LIBRARY = """newmtl white
Kd 0.7 0.6 0.5
Ks 0.1 0.1 0.1
Ns 20
d 1
illum 2
newmtl lamp
Kd 0 0 0
Ke 3 4 5
"""
SCENE = """name = "box"
unit = "m"
[[geometry]]
file = "box.obj"
translate = [0.5, 0, 0]
[[geometry]]
material = "lamp"
polygons = [[[1, 1, 1.5], [1, 1.5, 1.5], [1.5, 1.5, 1.5], [1.5, 1, 1.5]]]
[materials.white]
diffuse = [0.7, 0.6, 0.5]
[materials.lamp]
diffuse = 0.0
emission = { luminous_flux = 800 }
[[lights]]
type = "spot"
position = [1, 1, 1.2]
target = [1, 1, 0]
luminous_intensity = 900
beam_angle = 20
cutoff_angle = 30
[cameras.front]
position = [1, 0.1, 1]
target = [1, 2, 1]
fov = 40
size = [64, 48]
"""

RADIANCE = """void plastic white 0 0 5 .7 .6 .5 0 0
void light lamp 0 0 3 30 40 50
void glass pane 0 0 3 .9 .9 .9
white polygon floor 0 0 12 0 0 0 2 0 0 2 2 0 0 2 0
white polygon wall 0 0 12 0 2 0 2 2 0 2 2 2 0 2 2
lamp polygon shine 0 0 12 .5 .5 1.9 .5 1 1.9 1 1 1.9 1 .5 1.9
white sphere ball 0 0 4 .5 .5 .3 .3
pane ring hole 0 0 8 1 1.9 1 0 -1 0 .1 .3
!genbox white box .3 .4 .5 | xform -rz 20 -t 1 1 0
"""
IES = """IESNA:LM-63-2002
[TEST] 1
[MANUFAC] Nobody
TILT=NONE
1 800 1 5 3 1 2 0.1 0.1 0
1 1 10
0 22.5 45 67.5 90
0 45 90
300 280 200 90 0
300 270 190 80 0
300 260 180 70 0
"""
EULUMDAT = "\n".join((
    "Nobody;x", "1", "1", "1", "0", "5", "22.5", "1", "luminaire", "1", "x.ldt", "today",
    *("100", "0", "50", "100", "0", "0", "0", "0", "0", "100", "90", "1", "0", "1", "1", "LED"),
    *("800", "4000", "80", "10", *("0.5",) * 10, "0"),
    *("0", "22.5", "45", "67.5", "90", "300", "280", "200", "90", "0"),
)) + "\n"  # fmt: skip
LIT = """[[geometry]]
polygons = [[[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]]
uv = [[[0, 0], [1, 0], [1, 1], [0, 1]]]
material = "m"
[materials.m]
diffuse = {diffuse}
[[lights]]
position = [0, 0, 1]
{light}
"""
BULB = 'type = "point"\nluminous_flux = 800'


def text(words: str):
    """Return what makes a file of a text."""
    return lambda folder: words.encode()


def solved(scene) -> str:
    """Return "right" where a scene has a finite solution, "dark" where nothing shines in it."""
    assert len(scene.faces), "no faces, and nobody said so"
    solution = radiosity.solve(scene, 0.5, mesh="1", order=0)
    assert np.isfinite(solution.irradiance_on).all(), "not finite"
    return "right" if scene.has_light or not solution.irradiance_on.any() else "dark"


def scene_file(path) -> str:
    return solved(radiosity.load(path))


def box_scene(folder) -> bytes:
    (folder / "box.obj").write_text(BOX)
    return SCENE.encode()


def library(path) -> str:
    """Read the box with a material library."""
    (path.parent / "box.obj").write_text(f"mtllib {path.name}\n{BOX}")
    return scene_file(path.parent / "box.obj")


def made(**how):
    """Return what makes a file of the box by trimesh."""

    def original(folder) -> bytes:
        import trimesh

        found = trimesh.creation.box((2, 2, 2)).export(**how)
        return found.encode() if isinstance(found, str) else found

    return original


def model(binary: bool):
    """Return what makes a glTF file: a lit floor with a picture, a lamp, a light, a camera."""

    def original(folder) -> bytes:
        corners = np.array([[0, 0, 0], [2, 0, 0], [2, 0, -2], [0, 0, -2]], "<f4")
        parts = [
            corners.tobytes(), np.array([0, 1, 2, 0, 2, 3], "<u2").tobytes(),
            np.array([[0, 0], [1, 0], [1, 1], [0, 1]], "<f4").tobytes(), picture(".png")(folder),
        ]  # fmt: skip
        data, views = b"", []
        for part in parts:
            data += b"\0" * (-len(data) % 4)
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
            data += part
        tree = _tree(views, len(data))
        if binary:
            return _glb(tree, data + b"\0" * (-len(data) % 4))
        uri = base64.b64encode(data).decode()
        tree["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{uri}"
        return json.dumps(tree, indent=1).encode()

    return original


def _tree(views, size) -> dict:
    def accessor(view, kind, count, component, **more):
        return {"bufferView": view, "componentType": component, "count": count, "type": kind} | more

    attributes = {"POSITION": 0, "TEXCOORD_0": 2}
    meshes = [
        {"primitives": [{"attributes": attributes, "indices": 1, "material": k}]} for k in range(2)
    ]
    light = {"type": "spot", "intensity": 500, "color": [1, 0.9, 0.8], "spot": {}}
    extensions = ["KHR_lights_punctual", "KHR_materials_emissive_strength"]
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 1000}}
    return {
        "asset": {"version": "2.0"}, "extensionsUsed": extensions, "scene": 0,
        "buffers": [{"byteLength": size}], "bufferViews": views,
        "accessors": [
            accessor(0, "VEC3", 4, 5126, min=[0, 0, -2], max=[2, 0, 0]),
            accessor(1, "SCALAR", 6, 5123), accessor(2, "VEC2", 4, 5126),
        ],
        "images": [{"bufferView": 3, "mimeType": "image/png"}], "textures": [{"source": 0}],
        "materials": [
            {"name": "floor", "pbrMetallicRoughness": {
                "baseColorTexture": {"index": 0}, "roughnessFactor": 0.9, "metallicFactor": 0}},
            {"name": "lamp", "emissiveFactor": [1, 0.9, 0.7], "extensions": strength},
        ],
        "meshes": meshes, "cameras": [{"type": "perspective", "perspective": {
            "yfov": 0.7, "znear": 0.1}}],
        "nodes": [
            {"mesh": 0, "name": "floor"},
            {"mesh": 1, "translation": [0.8, 1.5, -0.8], "rotation": [1, 0, 0, 0],
             "scale": [0.2, 1, 0.2], "children": [3]},
            {"camera": 0, "translation": [1, 1, 3]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}},
             "rotation": [0.7071068, 0, 0, -0.7071068]},
        ],
        "scenes": [{"nodes": [0, 1, 2]}],
        "extensions": {"KHR_lights_punctual": {"lights": [light]}},
    }  # fmt: skip


def _glb(tree, data) -> bytes:
    words = json.dumps(tree).encode()
    words += b" " * (-len(words) % 4)
    chunks = [struct.pack("<II", len(x), kind) + x for x, kind in ((words, 0x4E4F534A),
                                                                   (data, 0x004E4942))]  # fmt: skip
    return struct.pack("<III", 0x46546C67, 2, 12 + sum(map(len, chunks))) + b"".join(chunks)


def picture(suffix: str):
    """Return what makes a picture of reflectances."""

    def original(folder) -> bytes:
        import imageio.v3

        pixels = np.linspace(20, 200, 4 * 5 * 3).reshape(4, 5, 3)
        if suffix in (".png", ".jpg"):
            return imageio.v3.imwrite("<bytes>", pixels.astype(np.uint8), extension=suffix)
        if suffix == ".npy":
            file = io.BytesIO()
            np.save(file, pixels / 255.0)
            return file.getvalue()
        radiosity.write(radiosity.Image(pixels / 255.0), folder / "whole.exr")
        return (folder / "whole.exr").read_bytes()

    return original


def lit(diffuse: str = "0.5", light: str = BULB):
    """Return what reads a file that a scene of one lit square names."""

    def read(path) -> str:
        names = {"diffuse": diffuse.format(path.name), "light": light.format(path.name)}
        (path.parent / "lit.toml").write_text(LIT.format(**names))
        return scene_file(path.parent / "lit.toml")

    return read


def spectrum(folder) -> bytes:
    return "".join(f"{nm},{0.2 + nm / 2000}\n" for nm in range(380, 780, 20)).encode()


def points(folder) -> bytes:
    rows = np.random.default_rng(0).uniform(0.1, 1.9, (9, 3)).round(3)
    return ("x,y,z,nx,ny,nz\n" + "".join(f"{x},{y},{z},0,0,1\n" for x, y, z in rows)).encode()


def points_file(path) -> str:
    from radiosity.cli.probe import read_points

    found = read_points(str(path))
    assert len(found) and np.isfinite(found).all(), "no points"
    return "right"


def container(folder) -> bytes:
    (folder / "box.obj").write_text(BOX)
    (folder / "box.toml").write_text(SCENE)
    solution = radiosity.solve(radiosity.load(folder / "box.toml"), 0.5, mesh="1", order=0)
    radiosity.save(solution, folder / "box.radsol")
    return (folder / "box.radsol").read_bytes()


def container_file(path) -> str:
    """Read a solution and ask it: numbers, a picture, other light."""
    solution = radiosity.load(path)
    E, error = solution.irradiance([[1.0, 1.0, 0.5]], [[0.0, 0.0, 1.0]])
    image = radiosity.render(solution, size=(4, 3), samples=4)
    half = solution.dimmed({solution.groups[0]: 0.5}) if solution.can_dim else solution
    for found in (E, error, image.pixels, half.irradiance_on):
        assert np.isfinite(found).all(), "not finite"
    return "right"


def manifest(folder) -> bytes:
    container(folder)
    with zipfile.ZipFile(folder / "box.radsol") as file:
        return file.read("manifest.json")


def manifest_file(path) -> str:
    """Read a solution with a manifest of its own, whose arrays are whole."""
    place = path.parent / "mutated.radsol"
    with zipfile.ZipFile(path.parent / "box.radsol") as old, zipfile.ZipFile(place, "w") as new:
        for info in old.infolist():
            whole = info.filename != "manifest.json"
            new.writestr(info, old.read(info) if whole else path.read_bytes())
    return container_file(place)


def factors(folder) -> bytes:
    (folder / "box.obj").write_text(BOX)
    radiosity.form_factors(str(folder / "box.obj"), 0.1).save(folder / "f.npz")
    return (folder / "f.npz").read_bytes()


def factors_file(path) -> str:
    found = radiosity.FormFactors.load(path).toarray()
    assert np.isfinite(found).all(), "not finite"
    return "right"


FORMATS = {
    "toml": (box_scene, ".toml", scene_file),
    "obj": (text(BOX), ".obj", scene_file),
    "mtl": (text(LIBRARY), ".mtl", library),
    "ply": (made(file_type="ply"), ".ply", scene_file),
    "ply ascii": (made(file_type="ply", encoding="ascii"), ".ply", scene_file),
    "stl": (made(file_type="stl"), ".stl", scene_file),
    "stl ascii": (made(file_type="stl_ascii"), ".stl", scene_file),
    "glb": (model(True), ".glb", scene_file),
    "gltf": (model(False), ".gltf", scene_file),
    "rad": (text(RADIANCE), ".rad", scene_file),
    "ies": (text(IES), ".ies", lit(light='type = "ies"\ntarget = [0, 0, 0]\nfile = "{}"')),
    "ldt": (text(EULUMDAT), ".ldt", lit(light='type = "ies"\ntarget = [0, 0, 0]\nfile = "{}"')),
    "spectrum": (spectrum, ".csv", lit('"{}"')),
    "png": (picture(".png"), ".png", lit('{{ texture = "{}" }}')),
    "jpg": (picture(".jpg"), ".jpg", lit('{{ texture = "{}" }}')),
    "exr": (picture(".exr"), ".exr", lit('{{ texture = "{}" }}')),
    "npy": (picture(".npy"), ".npy", lit('{{ texture = "{}" }}')),
    "radsol": (container, ".radsol", container_file),
    "radsol inside": (manifest, ".json", manifest_file),
    "points": (points, ".csv", points_file),
    "factors": (factors, ".npz", factors_file),
}
