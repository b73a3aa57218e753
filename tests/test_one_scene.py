"""One scene in several formats has the same irradiance."""

from pathlib import Path

import numpy as np
import pytest

import radiosity
from radiosity.light.photometry import luminance

ROOT = Path(__file__).resolve().parent.parent
ACCURACY = 0.1
POINTS = np.array([[480.0, 1, 120], [278, 1, 500], [100, 547, 500], [545, 300, 300], [60, 20, 20]])
NORMALS = np.array([[0.0, 1, 0], [0, 1, 0], [0, -1, 0], [-1, 0, 0], [0, 1, 0]])
SCENE = 'unit = "mm"\nup = "{up}"\n[[geometry]]\nfile = "{file}"\n'


@pytest.fixture(scope="module")
def box():
    return radiosity.load(ROOT / "scenes" / "cornell_box.toml")


@pytest.fixture(scope="module")
def expected(box):
    return irradiance(box)


def irradiance(scene):
    found = radiosity.solve(scene, ACCURACY).irradiance(POINTS, NORMALS)[0]
    assert (found > 0.0).all()
    return found


def corners_of(scene):
    """Yield the material's name and the corners of every face."""
    faces = scene.faces
    for v, triangle, material in zip(
        faces.vertices, faces.is_triangle, faces.material, strict=True
    ):
        yield scene.materials[material].name, v[:3] if triangle else v


def as_rad(scene):
    """Return a scene description whose lamp has the same lux at every point."""
    text = ""
    for m in scene.materials:
        if m.emits:
            radiance = m.emission * 683 * luminance(m.emission)
            radiance /= 179 * m.emission @ [0.265, 0.670, 0.065]
            text += f"void light {m.name}\n0\n0\n3 {words(radiance)}\n"
        else:
            text += f"void plastic {m.name}\n0\n0\n5 {words(m.diffuse)} 0 0\n"
    for k, (name, v) in enumerate(corners_of(scene)):
        text += f"{name} polygon f.{k}\n0\n0\n{v.size} {words(v.ravel())}\n"
    return text


def as_obj(scene):
    text, used = "mtllib box.mtl\n", 0
    for name, v in corners_of(scene):
        text += f"usemtl {name}\n" + "".join(f"v {words(p)}\n" for p in v)
        text += f"f {' '.join(str(used + k + 1) for k in range(len(v)))}\n"
        used += len(v)
    return text


def as_mtl(scene):
    return "".join(
        f"newmtl {m.name}\nillum 1\nNs 10\nKd {words(m.diffuse)}\nKe {words(m.emission)}\n"
        for m in scene.materials
    )


def words(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def test_the_cornell_box_as_a_radiance_scene(box, expected, tmp_path):
    (tmp_path / "box.rad").write_text(as_rad(box))
    (tmp_path / "box.toml").write_text(SCENE.format(up="z", file="box.rad"))
    found = radiosity.load(tmp_path / "box.toml")
    assert found.unit_m == 0.001 and len(found.read_as) == 4
    assert np.abs(irradiance(found) / expected - 1.0).max() < ACCURACY / 10  # the same faces


def test_the_cornell_box_as_obj_and_mtl(box, expected, tmp_path):
    (tmp_path / "box.obj").write_text(as_obj(box))
    (tmp_path / "box.mtl").write_text(as_mtl(box))
    (tmp_path / "box.toml").write_text(SCENE.format(up="y", file="box.obj"))
    found = irradiance(radiosity.load(tmp_path / "box.toml"))
    assert np.abs(found / expected - 1.0).max() < ACCURACY / 10
