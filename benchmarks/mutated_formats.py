"""The formats that are read: for each a right file, its suffix, and what reads and solves it."""

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


FORMATS = {
    "toml": (box_scene, ".toml", scene_file),
    "obj": (text(BOX), ".obj", scene_file),
    "mtl": (text(LIBRARY), ".mtl", library),
    "ply": (made(file_type="ply"), ".ply", scene_file),
    "ply ascii": (made(file_type="ply", encoding="ascii"), ".ply", scene_file),
    "stl": (made(file_type="stl"), ".stl", scene_file),
    "stl ascii": (made(file_type="stl_ascii"), ".stl", scene_file),
}
