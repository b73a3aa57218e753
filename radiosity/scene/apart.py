"""A scene whose light groups have bands of their own, so that one solution tells them apart."""

from dataclasses import replace

import numpy as np

from radiosity.light.bands import Bands
from radiosity.light.texture import Mixed, Texture
from radiosity.scene.groups import AMBIENT, groups_of_lights
from radiosity.scene.model import Material, Scene

PER_BAND = "share", "reflectance", "index"  # of the laws of lobes, mirrors and clear bodies


def apart(scene: Scene, names: tuple[str, ...]) -> Scene:
    """Return a scene that has each light group in bands of its own, in the order of ``names``.

    Its surfaces do to all of these what they do to the scene's: solved once, it tells what each
    group does by itself.
    """
    count, bands = scene.bands.count, scene.bands
    which = np.tile(np.arange(count), len(names))

    def put(values, name):
        found = np.zeros((len(names), count))
        found[names.index(name)] = values
        return found.ravel()

    materials = []
    for m in scene.materials:
        emission = put(m.emission, m.name) if m.name in names else np.zeros(len(which))
        materials.append(replace(_in_bands(m, which, count), emission=emission))
    lights = tuple(
        light.of_strength(put(light.strength, name))
        for light, name in zip(scene.lights, groups_of_lights(scene), strict=True)
    )
    ambient = put(scene.ambient, AMBIENT) if AMBIENT in names else np.zeros(len(which))
    titles = tuple(f"{band} of {name}" for name in names for band in bands.names)
    made = Bands(titles, bands.rgb[:, which], bands.y[which])
    return replace(
        scene, materials=tuple(materials), lights=lights, ambient=ambient, bands=made, truth=None
    )


def _in_bands(m: Material, which, count) -> Material:
    """Return a material of which band k is band ``which[k]`` of one of ``count`` bands."""
    more = {
        name: None if getattr(m, name) is None else getattr(m, name)[which]
        for name in ("diffuse", "absorptance", "translucent", "absorption")
    }
    laws = {
        name: _law_in_bands(getattr(m, name), which, count)
        for name in ("specular", "mirror", "transmit")
    }
    return replace(m, texture=_texture_in_bands(m.texture, which), **more, **laws)


def _law_in_bands(law, which, count):
    if law is None:
        return None
    values = {name: getattr(law, name, None) for name in PER_BAND}
    return replace(law, **{
        name: x[which] for name, x in values.items() if x is not None and np.shape(x) == (count,)
    })  # fmt: skip


def _texture_in_bands(texture, which):
    if texture is None:
        return None
    if isinstance(texture, Mixed):
        return replace(texture, shares=texture.shares[which])
    if texture.bands == 3:  # a picture is not to be kept many times
        return Mixed(texture, np.eye(3)[which])
    return Texture(texture.texels[..., which], texture.repeat)
