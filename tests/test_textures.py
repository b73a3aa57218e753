"""Textures in scene files: pictures of all kinds, where they lie, and every mistake in them."""

import subprocess
import sys
from pathlib import Path

import imageio.v3
import numpy as np
import pytest
from PIL import Image as Pillow

import radiosity
from radiosity.light.texture import srgb_to_linear
from radiosity.scene.model import SceneError
from radiosity.scene.schema import MaterialTable
from radiosity.scene.textures import LARGEST, details_of

SCENES = Path(__file__).resolve().parent.parent / "scenes"
SQUARE = "[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]"
UV = "[[0, 0], [1, 0], [1, 1], [0, 1]]"
FLOOR = f'[[geometry]]\nmaterial = "m"\npolygons = [{SQUARE}]\nuv = [{UV}]\n'
BYTES = np.array([[[0, 64, 128], [255, 32, 16]], [[5, 6, 7], [8, 9, 10]]], np.uint8)


@pytest.fixture
def folder(tmp_path):
    imageio.v3.imwrite(tmp_path / "a.png", BYTES)
    np.save(tmp_path / "a.npy", BYTES / 512)
    return tmp_path


def load(folder, text, geometry=FLOOR):
    (folder / "s.toml").write_text(geometry + "[materials.m]\n" + text)
    return radiosity.load(folder / "s.toml")


def problems(folder, text, geometry=FLOOR):
    with pytest.raises(SceneError) as error:
        load(folder, text, geometry)
    return error.value.problems


def texels(folder, text):
    return load(folder, text).materials[0].texture.texels


def test_bytes_are_srgb_and_arrays_are_linear(folder):
    linear = srgb_to_linear(BYTES / 255)
    found = load(folder, 'diffuse = { texture = "a.png" }').materials[0]
    np.testing.assert_allclose(found.texture.texels, linear, rtol=1e-6)  # float32
    np.testing.assert_allclose(found.diffuse, linear.mean(axis=(0, 1)), rtol=1e-6)
    np.testing.assert_allclose(found.absorptance, 1 - found.diffuse)
    assert found.texture.repeat
    raw = texels(folder, 'diffuse = { texture = "a.png", encoding = "linear", repeat = false }')
    np.testing.assert_allclose(raw, BYTES / 255, rtol=1e-6)
    np.testing.assert_allclose(texels(folder, 'diffuse = { texture = "a.npy" }'), BYTES / 512)
    coded = texels(folder, 'diffuse = { texture = "a.npy", encoding = "sRGB" }')
    np.testing.assert_allclose(coded, srgb_to_linear(BYTES / 512), rtol=1e-6)


def test_scales_multiply_the_linear_values(folder):
    linear = srgb_to_linear(BYTES / 255)
    found = texels(folder, 'diffuse = { texture = "a.png", scale = 0.5 }')
    np.testing.assert_allclose(found, 0.5 * linear, rtol=1e-6)
    found = texels(folder, 'diffuse = { texture = "a.png", scale = [0.1, 0.2, 1] }')
    np.testing.assert_allclose(found, linear * [0.1, 0.2, 1], rtol=1e-6)


@pytest.mark.parametrize("mode", ["L", "1", "P", "RGBA", "LA", "I;16"])
def test_pictures_of_every_mode_are_read(folder, mode):
    grey = Pillow.new("L", (4, 3), 128)
    if mode == "I;16":
        Pillow.fromarray(np.full((3, 4), 32896, np.uint16)).save(folder / "b.png")  # 128 * 257
    else:
        colour = grey.convert("RGB")
        (colour.quantize(4) if mode == "P" else colour.convert(mode)).save(folder / "b.png")
    found = texels(folder, 'diffuse = { texture = "b.png" }')
    assert found.shape == (3, 4, 3)
    if mode != "1":  # which Pillow dithers
        assert found == pytest.approx(float(srgb_to_linear(128 / 255)), rel=1e-6)
    assert np.ptp(found, axis=2).max() == 0


def test_jpeg_and_exr_are_read(folder):
    imageio.v3.imwrite(folder / "b.jpg", np.full((8, 8, 3), 200, np.uint8))
    found = texels(folder, 'diffuse = { texture = "b.jpg" }')
    assert found == pytest.approx(float(srgb_to_linear(200 / 255)), abs=0.01)  # JPEG rounds
    pixels = np.random.default_rng(0).random((5, 3, 3)).astype(np.float32)
    radiosity.write(radiosity.Image(pixels), folder / "b.exr")
    np.testing.assert_array_equal(texels(folder, 'diffuse = { texture = "b.exr" }'), pixels)


def test_bumps_are_heights(folder):
    text = 'diffuse = 0.5\nbump = { texture = "a.png", height = -0.02, repeat = false }'
    bump = load(folder, text).materials[0].bump
    np.testing.assert_allclose(bump.texture.texels, BYTES[..., :1] / 255, rtol=1e-6)  # not decoded
    assert (bump.height, bump.texture.repeat) == (-0.02, False)
    assert load(folder, "diffuse = 0.5").materials[0].bump is None


def test_polygons_get_their_coordinates_and_files_theirs(folder):
    text = 'diffuse = { texture = "a.png" }'
    np.testing.assert_array_equal(load(folder, text).faces.uv, [[[0, 0], [1, 0], [1, 1], [0, 1]]])
    assert load(folder, "diffuse = 0.5").faces.uv is None  # nothing there needs them
    obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 3 0\nvt 3 3\nusemtl m\nf 1/1 2/2 3/3\n"
    (folder / "a.obj").write_text(obj)
    found = load(folder, text, '[[geometry]]\nfile = "a.obj"\nscale = 2\n')
    np.testing.assert_array_equal(found.faces.uv, [[[0, 0], [3, 0], [3, 3], [3, 3]]])
    (folder / "b.obj").write_text("v 0 0 1\nv 1 0 1\nv 1 1 1\nusemtl m\nf 1 2 3\n")
    both = '[[geometry]]\nfile = "a.obj"\n[[geometry]]\nfile = "b.obj"\n'
    assert problems(folder, text, both) == [
        "materials.m names a texture, but 1 of its 2 faces have no texture coordinates, face 1 "
        "for one: give vt in the OBJ file or uv beside the polygons"
    ]


def test_a_texel_that_reflects_too_much_is_refused_with_its_place(folder):
    found = problems(folder, 'diffuse = { texture = "a.png", scale = [1.2, 1, 1] }')
    assert found == [
        'materials.m.diffuse.texture = "a.png" row 0, column 1: 1.2 in band r must lie in [0, 1]: '
        "a surface cannot reflect more than it receives; 1 texels do not: lower its scale"
    ]
    np.save(folder / "b.npy", np.array([[0.5, -0.25]]))
    assert "row 0, column 1: -0.25 in band r" in problems(
        folder, 'diffuse = { texture = "b.npy" }'
    )[0]  # fmt: skip
    np.save(folder / "b.npy", np.array([[0.5, np.nan]]))
    found = problems(folder, 'diffuse = { texture = "b.npy" }')
    told = 'materials.m.diffuse.texture = "b.npy" row 0, column 1 must be finite, and below 1e+30'
    assert found == [told]
    gloss = 'specular = { model = "phong", reflectance = 0.5, exponent = 9 }\n'
    found = problems(folder, gloss + 'diffuse = { texture = "a.png" }')
    assert "where it is brightest diffuse + specular = 1.5 at 0 degrees in band r" in found[0]
    found = problems(folder, 'translucent = 0.1\ndiffuse = { texture = "a.png" }')
    assert "where it is brightest diffuse + translucent = 1.1 at 0 degrees in band r" in found[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("diffuse = { textur = 1 }", "materials.m.diffuse = { textur = 1 } must name a texture"),
        ("bump = 3", "materials.m.bump = 3 must name a texture: bump = { texture ="),
        (
            'diffuse = { texture = "a.png", scal = 1 }',
            "materials.m.diffuse.scal = 1 is not a known key here: did you mean scale?",
        ),
        ("diffuse = { texture = 1 }", "materials.m.diffuse.texture = 1 must be text in quotes"),
        ('diffuse = { texture = "a.png", repeat = 1 }', "repeat = 1 must be true or false"),
        ('diffuse = { texture = "a.png", encoding = "x" }', 'must be "sRGB" or "linear"'),
        ('diffuse = { texture = "a.png", scale = -1 }', "scale = -1 must be at least 0"),
        ('bump = { texture = "a.png", height = "x" }', 'bump.height = "x" must be a number'),
        ('diffuse = { texture = "no.png" }', 'no.png" does not exist'),
        ('diffuse = { texture = "../a.png" }', "lies outside the scene's folder"),
        ('diffuse = { texture = "s.toml" }', 'has the suffix ".toml": textures are read from .png'),
        ('diffuse = { texture = "text.png" }', "is not a picture that can be read"),
        ('diffuse = { texture = "text.exr" }', "is not a picture that can be read"),
        ('diffuse = { texture = "object.npy" }', "is not a picture that can be read"),
        ('diffuse = { texture = "deep.npy" }', "has the shape (2, 2, 2, 2)"),
        ('diffuse = { texture = "five.npy" }', "has 5 bands, textures have 1 or 3"),
        ('diffuse = { texture = "glass.png" }', "row 0, column 0 is see-through"),
        ('diffuse = { texture = "large.png" }', "has 5000 x 5000 pixels, at most 16777216"),
        (
            'absorptance = 0.5\ndiffuse = { texture = "a.png" }',
            "gives both diffuse and absorptance",
        ),
    ],
)
def test_mistakes_are_named(folder, text, words):
    (folder / "text.png").write_text("not a picture")
    (folder / "text.exr").write_text("not a picture")
    np.save(folder / "object.npy", np.array([{}]), allow_pickle=True)
    np.save(folder / "deep.npy", np.zeros((2, 2, 2, 2)))
    np.save(folder / "five.npy", np.zeros((2, 2, 5)))
    Pillow.new("RGBA", (2, 2), (9, 9, 9, 100)).save(folder / "glass.png")
    Pillow.new("L", (5000, 5000)).save(folder / "large.png")
    found = problems(folder, text)
    assert len(found) == 1
    assert words in found[0].replace(str(folder) + "/", "")


def test_pictures_far_too_large_are_refused_before_they_are_decoded(folder):
    Pillow.new("1", (20000, 20000)).save(folder / "large.png")
    assert LARGEST < 20000**2
    assert "large.png" in problems(folder, 'diffuse = { texture = "large.png" }')[0]


def test_all_mistakes_are_reported_at_once(folder):
    text = 'diffuse = { texture = "no.png" }\nbump = { texture = "none.png", height = 1 }\n'
    found = problems(folder, text + "[materials.n]\ndiffuse = 2\n")
    assert len(found) == 3


@pytest.mark.parametrize(
    ("geometry", "words"),
    [
        (FLOOR.replace(UV, f"{UV}, {UV}"), "uv lists the corners of 2 polygons, there are 1"),
        (
            FLOOR.replace("[0, 1]]]", "[0, 1], [2, 2]]]"),
            "uv[0] has 5 pairs [u, v], its polygon has 4",
        ),
        (
            FLOOR.replace("[0, 1]]]", "[0, 1, 2]]]"),
            "uv[0][3] = [0, 1, 2] must be two numbers [u, v]",
        ),
        (FLOOR + "smooth = true\n", "smooth = true needs a file with normals"),
        (FLOOR + "smooth = 200\n", "smooth = 200 must lie in [0, 180]: degrees, or true or false"),
    ],
)
def test_wrong_coordinates_of_polygons_are_named(folder, geometry, words):
    found = problems(folder, 'diffuse = { texture = "a.png" }', geometry)
    assert len(found) == 1 and words in found[0]


def test_files_bring_their_own_coordinates(folder):
    (folder / "b.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    found = problems(folder, "diffuse = 0.5", f'[[geometry]]\nfile = "b.obj"\nuv = [{UV}]\n')
    assert "geometry[0] gives uv without polygons" in found[0]


def test_smooth_takes_computes_and_drops_normals(folder):
    cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvn 1 0 2\n"
    cube += "f 4 3 2 1\nf 5//1 6//1 7//1 8//1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
    (folder / "c.obj").write_text(cube)
    block = '[[geometry]]\nfile = "c.obj"\nmaterial = "m"\n'
    given = load(folder, "diffuse = 0.5", block).faces
    assert np.isnan(given.corner_normals).any(axis=(1, 2)).tolist() == [True, False] + [True] * 4
    np.testing.assert_allclose(given.corner_normals[1], np.array([[1, 0, 2]] * 4) / np.sqrt(5))
    assert load(folder, "diffuse = 0.5", block + "smooth = false\n").faces.corner_normals is None
    assert load(folder, "diffuse = 0.5", block + "smooth = 60\n").faces.corner_normals is None
    # Angles are those of the placed geometry: here all normals meet at right angles.
    round_ = load(folder, "diffuse = 0.5", block + "smooth = 100\nscale = [2, 2, 4]\n").faces
    np.testing.assert_allclose(
        round_.corner_normals, (round_.vertices - [1, 1, 2]) / [1, 1, 2] / np.sqrt(3)
    )


def test_the_textured_room_is_read_and_told_of():
    from radiosity.cli.info import describe

    scene = radiosity.load(SCENES / "textured_room.toml")
    assert scene.materials[0].texture.texels.shape == (192, 192, 3)
    curved = ~np.isnan(scene.faces.corner_normals).any(axis=(1, 2))
    np.testing.assert_array_equal(curved, scene.faces.material == 3)
    # The ball's normals are those of a ball, to the square of its faces' size (22.5 degrees).
    away = scene.faces.vertices[curved] - [1.5, 2.4, 0.701]
    np.testing.assert_allclose(scene.faces.corner_normals[curved], away / 0.7, atol=0.05)
    told = describe(scene)
    assert "texture 192x192, from 0.0512695 0.147027 0.0998987 to 0.693872" in told
    assert "bumps 0.03 high" in told and "normals: 128 faces stand for a curved surface" in told


def test_textured_scenes_go_through_every_verb(folder):
    """A floor of two bands of 0.2 and 0.6 under a lamp: the picture, irradiance and powers.

    The points are what the middles of two pixels look at, (i + 1/2)/16 over 2 * 0.8 tan(25).
    """
    np.save(folder / "b.npy", np.repeat([[0.2, 0.2, 0.6, 0.6]], 2, axis=0))
    lamp = '[[geometry]]\nmaterial = "lamp"\n'
    lamp += "polygons = [[[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]]]\n"
    more = "\n[materials.lamp]\ndiffuse = 0\nemission = { exitance = 10 }\n[cameras.c]\n"
    more += "position = [0.5, 0.5, 0.8]\ntarget = [0.5, 0.5, 0]\nup = [0, 1, 0]\nfov = 50\n"
    load(folder, 'diffuse = { texture = "b.npy" }' + more, FLOOR + lamp)
    (folder / "p.csv").write_text("x,y,z,nx,ny,nz\n0.29016,0.47668,0,0,0,1\n"
                                  "0.70984,0.47668,0,0,0,1\n")

    def verb(*words):
        every = [sys.executable, "-m", "radiosity", *words, "--quiet"]
        ran = subprocess.run(every, capture_output=True, text=True, cwd=SCENES.parent)
        assert ran.returncode == 0, ran.stderr

    path = str(folder / "s.toml")
    verb("probe", path, str(folder / "p.csv"), "-o", str(folder / "E.csv"))
    verb("solve", path, "-o", str(folder / "s.npz"))
    verb("render", path, "-o", str(folder / "i.npy"), "--size", "16x16", "--samples", "128")
    E = np.genfromtxt(folder / "E.csv", delimiter=",", names=True)["E_r"]
    assert E[0] == pytest.approx(E[1], rel=0.01)  # the lamp reflects nothing
    pixels = np.load(folder / "i.npy")[8, :, 0]
    assert pixels[3] == pytest.approx(0.2 * E[0] / np.pi, rel=0.02)
    assert pixels[12] == pytest.approx(0.6 * E[1] / np.pi, rel=0.02)
    saved = np.load(folder / "s.npz")
    floor = saved["face"] == 0
    mean = np.average(saved["reflectance"][floor, 0], weights=saved["area_m2"][floor])
    assert mean == pytest.approx(0.4, rel=1e-6)  # float32 texels


def test_a_picture_that_materials_share_is_read_and_kept_once(tmp_path, monkeypatch):
    pictures = []

    def picture(name):
        pictures.append(name)
        return np.full((40, 50, 3), 100, np.uint8)

    tables = {
        name: MaterialTable.model_validate({"diffuse": {"texture": file}})
        for name, file in (("a", "x.png"), ("b", "x.png"), ("c", "y.png"))
    }
    problems = []
    found = details_of(tables, picture, problems)
    assert pictures == ["x.png", "y.png"] and not problems
    assert found["a"].texture.texels is found["b"].texture.texels
    monkeypatch.setattr("radiosity.scene.textures.MOST", 3999)
    details_of(tables, picture, problems)
    where = 'materials.c.diffuse.texture = "y.png" '
    told = "brings the scene's textures to 4000 texels, at most 3999 are read: reduce them"
    assert problems == [where + told]
