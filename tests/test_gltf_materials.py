"""Materials and textures of glTF files as tables of a scene file."""

import io
import subprocess
import sys
import tomllib
import zlib

import numpy as np
import pytest
from gltf_for_tests import SQUARE, TWO, Gltf, square
from PIL import Image

from radiosity.cli.materials import read_as, toml
from radiosity.light.facets import TrowbridgeReitz
from radiosity.light.shadowing import smith
from radiosity.light.texture import srgb_to_linear
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.scene.files import load
from radiosity.scene.gltf.gltf import read_gltf
from radiosity.scene.gltf.materials import coat_albedo
from radiosity.scene.model import SceneError
from radiosity.scene.toml import read_tables

RED = [0.8, 0.2, 0.1]
UV = [[0, 1], [1, 1], [1, 0], [0, 0]]  # the picture upright, v downwards


def pbr(*colour, metallic=0.0, roughness=1.0, **more):
    """Return a material of a base colour of three numbers, or four with alpha."""
    factor = [*colour, 1.0][:4]
    table = {"baseColorFactor": factor, "metallicFactor": metallic, "roughnessFactor": roughness}
    return {"pbrMetallicRoughness": table | more.pop("pbr", {}), **more}


def extended(material, **extensions):
    return material | {"extensions": {f"KHR_materials_{k}": v for k, v in extensions.items()}}


def geometry(made):
    def nothing(name):
        raise AssertionError(name)

    return read_gltf(made.glb(), "x.glb", nothing)


def scene_of(made):
    return read_tables({"geometry": [{"file": "x.glb"}]}, "x.glb", lambda n, uv: geometry(made))


def table(material):
    """Return the table of a material, after it was read as part of a scene."""
    scene = scene_of(square(material))
    (said,) = scene.read_as.values()
    return said.table


def near(found, expected, rtol=1e-9):
    np.testing.assert_allclose(found, expected, rtol=rtol, atol=1e-9)


def test_matte_is_the_base_colour():
    assert table(pbr(*RED)) == {"diffuse": RED}
    assert table(pbr(*RED, metallic=1)) == {"diffuse": RED}  # glTF's own defaults
    assert table({}) == {"diffuse": [1.0] * 3}
    assert table(extended(pbr(*RED, metallic=1, roughness=0), unlit={})) == {"diffuse": RED}


def test_metals_are_facets_of_their_colour():
    made = table(pbr(*RED, metallic=1, roughness=0.5))
    assert made["diffuse"] == [0, 0, 0]
    assert made["specular"] == {
        "model": "torrance-sparrow", "facets": "trowbridge-reitz", "shadowing": "smith",
        "roughness": 0.25, "reflectance": RED,
    }  # fmt: skip
    assert table(pbr(*RED, metallic=1, roughness=0.05)) == {"diffuse": [0] * 3, "mirror": RED}


def test_roughness_squared_is_the_width_of_ggx():
    # GGX's D = a^2/(pi ((n.h)^2 (a^2 - 1) + 1)^2), a = r^2 (glTF 2.0, appendix B)
    made = table(pbr(*RED, metallic=1, roughness=0.6))["specular"]
    facets, cosine, a = TrowbridgeReitz(made["roughness"]), np.linspace(0.1, 1, 9), 0.6**2
    expected = a**2 / (np.pi * (cosine**2 * (a**2 - 1) + 1) ** 2)
    near(facets.relative(cosine) / facets.norm(), expected)


def test_half_a_metal_is_half_diffuse():
    made = table(pbr(0.8, 0.8, 0.8, metallic=0.25, roughness=0.05))
    near(made["mirror"], [0.2] * 3)
    coat = coat_albedo(np.full(3, 0.04), 0.05)
    near(made["diffuse"], 0.75 * (coat + 0.8 * (1 - coat)))


def test_coats_by_their_roughness():
    glossy = table(pbr(*RED, roughness=0.3))
    assert glossy["specular"]["ior"] == 1.5 and glossy["specular"]["roughness"] == 0.09
    assert glossy["diffuse"] == RED
    assert table(pbr(*RED, roughness=0)) == {"diffuse": RED, "mirror": "fresnel", "ior": 1.5}
    near(table(pbr(0, 0, 0, roughness=0.5))["diffuse"], coat_albedo(np.full(3, 0.04), 0.5))


def test_a_coats_share_is_that_of_our_lobe():
    for roughness in (0.3, 0.4, 0.6, 0.9):
        lobe = TorranceSparrow(TrowbridgeReitz(roughness**2), smith, np.array([1.5]))
        found = coat_albedo(np.full(3, 0.04), roughness)
        np.testing.assert_allclose(found, lobe.mean_albedo, atol=0.003)


def test_index_and_specular_say_how_much_a_coat_reflects():
    smooth = pbr(*RED, roughness=0)
    assert table(extended(smooth, ior={"ior": 1.33}))["ior"] == pytest.approx(1.33)
    half = table(extended(smooth, specular={"specularFactor": 0.5}))["ior"]
    assert ((half - 1) / (half + 1)) ** 2 == pytest.approx(0.02, rel=1e-5)
    tinted = table(extended(smooth, specular={"specularColorFactor": [1, 2, 4]}))["ior"]
    near(((np.array(tinted) - 1) / (np.array(tinted) + 1)) ** 2, [0.04, 0.08, 0.16], 1e-5)
    assert table(extended(smooth, specular={"specularFactor": 0})) == {"diffuse": RED}


def test_light_is_emitted_in_candela_a_square_metre():
    shining = pbr(0, 0, 0, emissiveFactor=[1, 0.5, 0])
    near(table(shining)["emission"]["radiance"], np.array([1, 0.5, 0]) / 683)
    strong = extended(shining, emissive_strength={"emissiveStrength": 683})
    scene = scene_of(square(strong))
    near(scene.materials[0].emission, [1, 0.5, 0])


def test_thin_glass_shares_the_light():
    made = table(extended(pbr(0.5, 1, 1, roughness=0), transmission={"transmissionFactor": 0.75}))
    near(made["mirror"], [0.04] * 3)
    near(made["transmit"], 0.96 * 0.75 * np.array([0.5, 1, 1]))
    near(made["diffuse"], 0.96 * 0.25 * np.array([0.5, 1, 1]))
    assert "ior" not in made  # straight through
    frosted = table(extended(pbr(1, 1, 1, roughness=0.6), transmission={"transmissionFactor": 1}))
    near(frosted["translucent"], [0.96] * 3)
    near(frosted["mirror"], [0.04] * 3)
    assert "transmit" not in frosted


def test_bodies_refract_and_absorb():
    volume = {"thicknessFactor": 1, "attenuationColor": [1, 0.5, 0.25], "attenuationDistance": 0.1}
    clear = {"transmission": {"transmissionFactor": 1}, "ior": {"ior": 1.6}, "volume": volume}
    made = table(extended(pbr(1, 1, 1, roughness=0), **clear))
    assert (made["mirror"], made["transmit"], made["ior"]) == ("fresnel", "fresnel", 1.6)
    near(np.exp(-np.array(made["absorption"]) * 0.1), [1, 0.5, 0.25])
    tinted = table(extended(pbr(0.5, 1, 1, roughness=0), **clear))
    near(tinted["transmit"], (1 - (0.6 / 2.6) ** 2) * np.array([0.5, 1, 1]))


def test_diffuse_transmission_is_translucence():
    even = {"diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [1, 0.5, 0]}
    made = table(extended(pbr(*RED), diffuse_transmission=even))
    near(made["translucent"], [0.25, 0.125, 0])
    near(made["diffuse"], 0.75 * np.array(RED))


def test_alpha_lets_light_straight_through_where_it_is_blended():
    made = table(pbr(*RED, 0.25, alphaMode="BLEND"))
    near(made["transmit"], [0.75] * 3)
    near(made["diffuse"], 0.25 * np.array(RED))
    assert table(pbr(*RED, 0.25)) == {"diffuse": RED}
    masked = geometry(square(pbr(*RED, 0.25, alphaMode="MASK")))
    words = "holes are not modelled, all of it is there (1 materials"
    assert any(words in note for note in masked.notes)


def test_specular_and_glossiness():
    def old(**values):
        return table(extended({}, pbrSpecularGlossiness=values))

    made = old(diffuseFactor=[*RED, 1], specularFactor=[0.04] * 3, glossinessFactor=1)
    near(made["diffuse"], 0.96 * np.array(RED))
    assert (made["mirror"], made["ior"]) == ("fresnel", pytest.approx(1.5))
    metal = old(diffuseFactor=[0, 0, 0, 1], specularFactor=RED, glossinessFactor=0.5)
    near(metal["specular"]["reflectance"], RED)


def test_no_material_returns_more_than_it_receives():
    """Whatever a file says becomes a table that the scene file's own checks let through."""
    rng = np.random.default_rng(11)

    def one(*usual):
        return float(rng.choice([0.0, 1.0, *usual, rng.random()]))

    for _ in range(80):
        made = extended(
            pbr(one(), one(), one(), one(), metallic=one(), roughness=one(0.05, 0.3, 0.85),
                alphaMode=str(rng.choice(["OPAQUE", "BLEND", "MASK"]))),
            transmission={"transmissionFactor": one(0.0, 0.0)}, ior={"ior": one(1.2, 3.0, 99)
            if rng.random() < 0.5 else 1.5},
            specular={"specularFactor": one(), "specularColorFactor": [one(), one(5.0), 1.0]},
            volume={"thicknessFactor": one()},
            diffuse_transmission={"diffuseTransmissionFactor": one(0.0, 0.0)},
        )  # fmt: skip
        if made["extensions"]["KHR_materials_ior"]["ior"] == 1.0:
            made["extensions"]["KHR_materials_ior"]["ior"] = 0.0  # reflects all
        picture = textured(made, np.full((1, 1, 3), rng.integers(0, 256, 3), np.uint8))
        for file in (square(made), picture):
            scene_of(file)  # raises if the sum exceeds 1 at any angle


def test_what_is_not_modelled_is_noted_once_with_its_materials():
    made = square(extended(pbr(*RED), clearcoat={"clearcoatFactor": 1}))
    for k in range(4):
        made.add("materials", **pbr(*RED, name=f"m{k}", normalTexture={"index": 0}))
        made.node(mesh=made.mesh(made.primitive(SQUARE, TWO, k + 1)))
    notes = geometry(made).notes
    assert "KHR_materials_clearcoat: not modelled (1 materials: material-1)" in notes
    assert "normalTexture: not modelled (4 materials: m0, m1, m2, ...)" in notes


def textured(material, pixels, uv=UV, kind="png", info=None, **sampler):
    """Return a square with a picture, pixels (h, w, bands), as its base colour."""
    made = Gltf()
    data = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8)).save(data, kind)
    image = made.add("images", bufferView=made.view(data.getvalue()), mimeType=f"image/{kind}")
    place = made.add("samplers", **sampler)
    number = made.add("textures", source=image, sampler=place)
    base = material["pbrMetallicRoughness"]
    base = base | {"baseColorTexture": {"index": number, **(info or {})}}
    made.add("materials", **material | {"pbrMetallicRoughness": base})
    attributes = {} if uv is None else {"TEXCOORD_0": made.accessor(uv)}
    made.node(mesh=made.mesh(made.primitive(SQUARE, TWO, 0, **attributes)))
    return made


PIXELS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [128, 128, 128]]])


def colour_at(scene, uv):
    return scene.materials[0].texture.at(np.array([uv], float))[0]


def test_pictures_lie_as_the_file_has_them():
    scene = scene_of(textured(pbr(1, 0.5, 1), PIXELS))
    at = dict(zip(map(tuple, scene.faces.vertices[0]), scene.faces.uv[0], strict=True))
    near(at[0, 1, 0], [0, 1])  # upper left
    near(at[2, 0, 0], [1, 0])
    near(colour_at(scene, [0.25, 0.75]), [1, 0, 0], 1e-6)
    near(colour_at(scene, [0.75, 0.75]), [0, 0.5, 0], 1e-6)
    near(colour_at(scene, [0.75, 0.25]), np.array([1, 0.5, 1]) * srgb_to_linear(128 / 255), 1e-6)


def test_texture_transforms_move_coordinates():
    turned = {"KHR_texture_transform": {
        "offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}}  # fmt: skip
    scene = scene_of(textured(pbr(1, 1, 1), PIXELS, info={"extensions": turned}))
    # the extension's own example: the lower left quadrant of the picture
    assert scene.faces.uv[0].min(axis=0) == pytest.approx([0, 0])
    assert scene.faces.uv[0].max(axis=0) == pytest.approx([0.5, 0.5])
    at = dict(zip(map(tuple, scene.faces.vertices[0]), scene.faces.uv[0], strict=True))
    near(at[0, 1, 0], [0, 0])  # (0, 0) with v downwards becomes (0, 1)
    near(at[2, 1, 0], [0, 0.5])  # (1, 0) becomes (0, 0.5): turned counter-clockwise


def test_a_scene_files_own_texture_lies_on_the_faces_of_a_gltf_file(tmp_path):
    made = square(pbr(*RED, name="wall"), TEXCOORD_0=UV)
    (tmp_path / "a.glb").write_bytes(made.glb())
    Image.fromarray(PIXELS.astype(np.uint8)).save(tmp_path / "p.png")
    text = '[[geometry]]\nfile = "a.glb"\n[materials.wall]\ndiffuse = { texture = "p.png" }\n'
    (tmp_path / "a.toml").write_text(text)
    scene = load(tmp_path / "a.toml")
    near(scene.faces.uv[0], [[0, 0], [1, 0], [1, 1], [0, 1]])
    near(colour_at(scene, [0.25, 0.75]), [1, 0, 0], 1e-6)
    assert load(tmp_path / "a.glb").faces.uv is None


def test_a_matte_file_loads_nothing_of_gloss_and_textures(tmp_path):
    (tmp_path / "a.glb").write_bytes(square(pbr(*RED)).glb())
    code = "import sys; from radiosity.scene.files import load; load(sys.argv[1]); "
    code += "print([m for m in sys.modules if m.startswith('radiosity.')])"
    ran = [sys.executable, "-c", code, str(tmp_path / "a.glb")]
    loaded = subprocess.run(ran, capture_output=True, text=True, check=True).stdout
    assert "radiosity.scene.gltf.materials" in loaded
    for module in ("light.fresnel", "light.texture", "scene.textures", "scene.optics"):
        assert f"'radiosity.{module}'" not in loaded


def test_samplers_repeat_or_clamp():
    clamped = scene_of(textured(pbr(1, 1, 1), PIXELS, wrapS=33071, wrapT=33071))
    assert not clamped.materials[0].texture.repeat
    mirrored = scene_of(textured(pbr(1, 1, 1), PIXELS, wrapS=33648))
    assert mirrored.materials[0].texture.repeat
    assert any("mirrored" in note for note in mirrored.notes)


def test_without_coordinates_a_picture_is_its_mean():
    scene = scene_of(textured(pbr(1, 0.5, 1), PIXELS, uv=None))
    grey = srgb_to_linear(128 / 255)
    near(scene.materials[0].diffuse, np.array([1, 0.5, 1]) * (1 + grey) / 4)
    assert any("without texture coordinates" in note for note in scene.notes)


def test_one_material_is_two_where_its_vertices_have_colours():
    made = textured(pbr(1, 1, 1), PIXELS)
    colours = made.accessor([[255, 128, 0, 255]] * 4, "u1", normalized=True)
    tinted = made.primitive(SQUARE + [0, 0, 1], TWO, 0, COLOR_0=colours)
    made.json["meshes"][0]["primitives"].append(tinted)
    scene = scene_of(made)
    assert [m.name for m in scene.materials] == ["material-1", "material-1-2"]
    mean = scene.materials[0].texture.mean
    near(scene.materials[1].diffuse, mean * [1, 0.502, 0], 1e-5)


def test_a_rough_coat_raises_the_mean_of_a_picture():
    scene = scene_of(textured(pbr(1, 1, 1, roughness=0.5), np.full((2, 2, 3), 100)))
    rho, coat = srgb_to_linear(100 / 255), coat_albedo(np.full(3, 0.04), 0.5)
    near(scene.materials[0].diffuse, coat + rho * (1 - coat), 1e-6)


def test_bright_texels_stay_within_what_arrives():
    spotted = np.array([[[255] * 3, [0] * 3], [[0] * 3, [0] * 3]])
    scene = scene_of(textured(pbr(1, 1, 1, roughness=0.5), spotted))  # a coat would raise 1 too
    near(scene.materials[0].texture.highest, [1] * 3, 5e-6)
    half = extended(pbr(1, 1, 1, metallic=0.4, roughness=0.3), specular={"specularFactor": 0})
    scene = scene_of(textured(half, np.full((2, 2, 3), 255)))  # 0.6 rounds up in single precision
    near(scene.materials[0].diffuse, [0.6] * 3, 5e-6)


def test_other_textures_count_with_their_means():
    """Green is roughness and blue metallic, red transmission: linear; what is emitted is sRGB."""
    image = {"index": 0}
    mixed = pbr(1, 1, 1, metallic=0.5, roughness=1, pbr={"metallicRoughnessTexture": image})
    made = table_of_file(textured(mixed, PIXELS))
    assert made["specular"]["roughness"] == pytest.approx(((255 + 128) / 1020) ** 2)
    near(made["specular"]["reflectance"][0] / made["specular"]["reflectance"][1], 1)
    mean = (1 + srgb_to_linear(128 / 255)) / 4  # of the base colour, in linear light
    near(made["specular"]["reflectance"], [0.5 * (255 + 128) / 1020 * mean] * 3, 1e-8)
    clear = {"transmissionFactor": 1, "transmissionTexture": image}
    glass = table_of_file(textured(extended(pbr(1, 1, 1, roughness=0), transmission=clear), PIXELS))
    near(glass["transmit"], [0.96 * (255 + 128) / 1020 * mean] * 3, 1e-8)
    lamp = pbr(0, 0, 0, emissiveFactor=[1, 1, 1], emissiveTexture=image)
    near(table_of_file(textured(lamp, PIXELS))["emission"]["radiance"], [mean / 683] * 3)


def test_alpha_of_pictures_is_ignored_unless_it_is_blended():
    pixels = np.full((2, 2, 4), 255)
    pixels[0, 0, 3] = 0
    assert table_of_file(textured(pbr(*RED), pixels)).get("transmit") is None
    near(table_of_file(textured(pbr(*RED, alphaMode="BLEND"), pixels))["transmit"], [0.25] * 3)


def table_of_file(made):
    (said,) = scene_of(made).read_as.values()
    return said.table


def test_other_pictures_than_png_and_jpeg_are_noted():
    found = scene_of(textured(pbr(*RED), PIXELS, kind="webp"))
    near(found.materials[0].diffuse, RED)
    assert any("images of image/webp: not read" in note for note in found.notes)
    jpeg = textured(pbr(1, 1, 1), np.full((8, 8, 3), 99), kind="jpeg")
    near(scene_of(jpeg).materials[0].diffuse, [srgb_to_linear(99 / 255)] * 3, 0.01)


def test_broken_and_large_pictures_are_refused_before_they_are_decoded():
    made = textured(pbr(*RED), PIXELS)
    head = made.data.index(b"IHDR")
    for size, words in ((0, "images[0] is not a picture"), (5000, "images[0] has 5000 x 5000")):
        data = bytearray(made.data)
        data[head + 4 : head + 12] = 2 * size.to_bytes(4, "big")
        data[head + 17 : head + 21] = zlib.crc32(data[head : head + 17]).to_bytes(4, "big")
        made.data = bytes(data)
        with pytest.raises(SceneError) as caught:
            geometry(made)
        assert words in caught.value.problems[0]


def test_tables_that_are_printed_can_stand_in_a_scene_file(tmp_path):
    material = pbr(*RED, roughness=0.3, name='a "b"', emissiveFactor=[1, 1, 1])
    (tmp_path / "a.glb").write_bytes(square(material, name="wall").glb())
    found = read_as(load(tmp_path / "a.glb"))
    assert found['a "b"']["origin"].startswith("glTF: base colour 0.8 0.2 0.1, metallic 0")
    text = toml('a "b"', found['a "b"'])
    assert tomllib.loads(text)["materials"] == {'a "b"': found['a "b"']["table"]}
    scene = '[[geometry]]\nfile = "a.glb"\n[materials.spare]\ndiffuse = 0.3\n' + text + "\n"
    (tmp_path / "a.toml").write_text(scene)
    own = read_as(load(tmp_path / "a.toml"))
    assert own['a "b"']["table"] == found['a "b"']["table"]
    assert own["spare"] == {"origin": "as the scene file has it", "table": {"diffuse": 0.3}}
    odd = toml("a\x7f", {"table": {"diffuse": {"texture": "\x7f.png"}}})
    assert tomllib.loads(odd)["materials"] == {"a\x7f": {"diffuse": {"texture": "\x7f.png"}}}
    bare = square()
    (tmp_path / "b.glb").write_bytes(bare.glb())
    default = read_as(load(tmp_path / "b.glb"))["default"]
    assert default["origin"] == "defined nowhere, taken by default"


def test_what_lets_hardly_any_light_through_is_opaque():
    """5 % at most; glass of 6 % is glass."""
    whole = table(pbr(*RED))
    made = square(pbr(*RED, 0.999, alphaMode="BLEND"))
    scene = scene_of(made)
    (said,) = scene.read_as.values()
    assert said.table == whole
    assert "up to 0.05 of light through a surface counts as diffuse (1 mat" in " ".join(scene.notes)
    assert table(extended(pbr(*RED), transmission={"transmissionFactor": 0.05})) == whole
    clear = {"transmission": {"transmissionFactor": 0.05}, "volume": {"thicknessFactor": 1}}
    assert table(extended(pbr(*RED), **clear)) == whole
    near(table(pbr(*RED, 0.94, alphaMode="BLEND"))["transmit"], [0.06] * 3)
