"""What a glTF file says of its materials, in one form whichever extension says it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from radiosity.light.photometry import EFFICACY
from radiosity.scene.gltf.document import Entry
from radiosity.scene.gltf.images import Images, Picture

GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
ABSORBS = 1e6  # most, in 1/m
BRIGHTEST = 1e9  # cd/m2; the sun has 1.6e9 before it meets air
READ = {
    "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_specular",
    "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_diffuse_transmission",
    "KHR_materials_unlit", GLOSSINESS,
}  # fmt: skip
WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Look:
    """A material as glTF describes it, with the means of the textures that are not laid over faces.

    Attributes
    ----------
    origin : str
        What the file says.
    base : (3,) float64
        Base colour, which a picture is multiplied by.
    metallic, roughness, opacity, transmission : float
        In [0, 1].
    f0 : (3,) float64
        Reflectance at normal incidence of what is no metal.
    ior : float
    specular : (3,) float64, optional
        Reflectance of a metal that is given apart from the base colour.
    picture, texture : Picture and Entry, optional
        Of the base colour.
    absorption : (3,) float64, optional
        In 1/m, of a clear body; None where a surface is thin.
    passing : (3,) float64
        Share of light that goes through evenly.
    passed : float
        Share of light that does not reach the diffuse base for it.
    emission : (3,) float64
        Radiance in W/(m2 sr).
    """

    origin: str
    base: np.ndarray
    metallic: float
    roughness: float
    f0: np.ndarray
    ior: float = 1.5
    opacity: float = 1.0
    transmission: float = 0.0
    specular: np.ndarray | None = None
    picture: Picture | None = None
    texture: Entry | None = None
    absorption: np.ndarray | None = None
    passing: np.ndarray | None = None
    passed: float = 0.0
    emission: np.ndarray | None = None

    @property
    def colour(self) -> np.ndarray:
        """Return the mean base colour (3,)."""
        return self.base if self.picture is None else self.base * self.picture.mean

    @property
    def metal(self) -> np.ndarray:
        """Return the reflectance (3,) of the metal part."""
        return self.colour * self.metallic if self.specular is None else self.specular

    def times(self, colour: np.ndarray) -> "Look":
        """Return the look with its base colour multiplied."""
        return replace(self, base=self.base * colour)

    def plain(self) -> "Look":
        """Return the look in its mean colour everywhere."""
        return replace(self, base=self.colour, picture=None, texture=None)


def look_of(entry: Entry, images: Images, note: Callable[[str], None]) -> Look:
    """Return what a material looks like; what is not modelled is noted."""
    for key in ("normalTexture", "occlusionTexture"):
        if entry.has(key):
            note(f"{key}: not modelled")
    for name in entry.child("extensions").value:
        if name not in READ:
            note(f"{name}: not modelled")
    if entry.extended("KHR_materials_unlit"):
        note("KHR_materials_unlit: its colour is read as a diffuse reflectance")
    made = _glossy if entry.extended(GLOSSINESS) else _metallic
    look = _through(entry, images, made(entry, images, note), note)
    emitted = _emission(entry, images)
    if emitted.any():
        look = replace(look, origin=f"{look.origin}, emissive {words(emitted * EFFICACY)} cd/m2")
    look = replace(look, emission=emitted)
    return _with_opacity(entry, look, note)


def _metallic(entry, images, note) -> Look:
    """Return the look of pbrMetallicRoughness."""
    table = entry.child("pbrMetallicRoughness")
    factor = table.numbers("baseColorFactor", (1.0,) * 4, 0.0, 1.0)
    metallic, roughness = (
        table.number(key, 1.0, 0.0, 1.0) for key in ("metallicFactor", "roughnessFactor")
    )
    picture = images.picture(table, "metallicRoughnessTexture")
    if picture is not None:
        _, rough, metal = picture.linear_mean
        metallic, roughness = metallic * float(metal), roughness * float(rough)
        note("metallicRoughnessTexture: its means are taken")
    if entry.extended("KHR_materials_unlit"):
        metallic, roughness = 0.0, 1.0
    ior = entry.extension("KHR_materials_ior").number("ior", 1.5, 0.0, 100.0)
    said = f"glTF: base colour {words(factor[:3])}, metallic {metallic:.3g}, "
    look = Look(
        said + f"roughness {roughness:.3g}", np.array(factor[:3]), metallic, roughness,
        _reflectance(entry, ior, note), max(ior, 1.0) if ior else 100.0, factor[3],
    )  # fmt: skip
    return _textured(look, table, "baseColorTexture", images)


def _reflectance(entry, ior, note) -> np.ndarray:
    """Return what a dielectric reflects at normal incidence, (3,); an index of 0 stands for all.

    min(((n - 1)/(n + 1))^2 colour, 1) times a factor, KHR_materials_specular.
    """
    table = entry.extension("KHR_materials_specular")
    for key in ("specularTexture", "specularColorTexture"):
        if table.has(key):
            note(f"{key} of KHR_materials_specular: not modelled")
    n = max(ior, 1.0)
    f0 = ((n - 1.0) / (n + 1.0)) ** 2 if ior else 1.0
    colour = np.array(table.numbers("specularColorFactor", WHITE, 0.0, 1e6))
    return np.minimum(f0 * colour, 1.0) * table.number("specularFactor", 1.0, 0.0, 1.0)


def _glossy(entry, images, note) -> Look:
    """Return the look of KHR_materials_pbrSpecularGlossiness.

    A specular colour brighter than any dielectric's is a metal's.
    """
    table = entry.extension(GLOSSINESS)
    factor = np.array(table.numbers("diffuseFactor", (1.0,) * 4, 0.0, 1.0))
    shine = np.array(table.numbers("specularFactor", WHITE, 0.0, 1.0))
    gloss = table.number("glossinessFactor", 1.0, 0.0, 1.0)
    picture = images.picture(table, "specularGlossinessTexture")
    if picture is not None:
        shine, gloss = shine * picture.mean, gloss * picture.opacity
        note("specularGlossinessTexture: its means are taken")
    said = f"glTF: diffuse {words(factor[:3])}, specular {words(shine)}, glossiness {gloss:.3g}"
    metal = shine if shine.max() > 0.2 else None
    look = Look(
        said, factor[:3] * (1.0 - shine.max()), 0.0, 1.0 - gloss,
        shine if metal is None else np.zeros(3), 1.5, float(factor[3]), specular=metal,
    )  # fmt: skip
    return _textured(look, table, "diffuseTexture", images)


def _textured(look, table, key, images) -> Look:
    """Return a look with its base colour's texture, whose alpha counts with its mean."""
    picture = images.picture(table, key)
    if picture is None:
        return look
    return replace(
        look, picture=picture, texture=table.child(key), opacity=look.opacity * picture.opacity,
        origin=f"{look.origin}, texture {picture.name}",
    )  # fmt: skip


def _through(entry, images, look, note) -> Look:
    """Return a look with what goes through: straight, refracted or evenly."""
    clear = entry.extension("KHR_materials_transmission")
    share = clear.number("transmissionFactor", 0.0, 0.0, 1.0)
    picture = images.picture(clear, "transmissionTexture")
    if picture is not None:
        share *= float(picture.linear_mean[0])
        note("transmissionTexture: its mean is taken")
    even = entry.extension("KHR_materials_diffuse_transmission")
    passed = even.number("diffuseTransmissionFactor", 0.0, 0.0, 1.0)
    tint = np.array(even.numbers("diffuseTransmissionColorFactor", WHITE, 0.0, 1.0))
    for key in ("diffuseTransmissionTexture", "diffuseTransmissionColorTexture"):
        if even.has(key):
            note(f"{key}: not modelled")
    volume = entry.extension("KHR_materials_volume")
    thick = volume.number("thicknessFactor", 0.0, 0.0) > 0.0 and share > 0.0
    said = f", transmission {share:.3g}" if share else ""
    said += f" of a body of index {look.ior:.4g}" if thick else ""
    said += f", diffuse transmission {passed:.3g}" if passed else ""
    return replace(
        look, transmission=share, passed=passed, passing=passed * tint, origin=look.origin + said,
        absorption=_absorption(volume) if thick else None,
    )  # fmt: skip


def _absorption(volume) -> np.ndarray:
    """Return -ln(c)/d (3,) in 1/m of the colour c that is left of white after a way d."""
    colour = np.array(volume.numbers("attenuationColor", WHITE, 0.0, 1.0))
    if not volume.has("attenuationDistance"):
        return np.zeros(3)
    way = max(volume.number("attenuationDistance", 1.0, 0.0), 1e-9)
    return np.minimum(-np.log(np.maximum(colour, 1e-30)) / way, ABSORBS)


def _emission(entry, images) -> np.ndarray:
    """Return the radiance (3,) in W/(m2 sr): glTF gives cd/m2."""
    strength = entry.extension("KHR_materials_emissive_strength")
    factor = np.array(entry.numbers("emissiveFactor", (0.0,) * 3, 0.0, 1e6))
    factor = factor * strength.number("emissiveStrength", 1.0, 0.0, BRIGHTEST)
    picture = images.picture(entry, "emissiveTexture") if factor.any() else None
    return factor * (1.0 if picture is None else picture.mean) / EFFICACY


def _with_opacity(entry, look, note) -> Look:
    """Return a look with the share of light that its alpha lets through, if it is blended."""
    mode = entry.text("alphaMode", "OPAQUE")
    if mode == "BLEND":
        if look.opacity < 1.0:
            note("alphaMode BLEND: the mean of 1 - alpha is let through straight")
            return replace(look, origin=f"{look.origin}, alpha {look.opacity:.3g}")
        return look
    if mode == "MASK" and look.opacity < 1.0:
        note("alphaMode MASK: holes are not modelled, all of it is there")
    elif mode not in ("OPAQUE", "MASK"):
        entry.fail("alphaMode", 'must be "OPAQUE", "MASK" or "BLEND"')
    return replace(look, opacity=1.0)


def words(values) -> str:
    """Return numbers as text, one where all are alike."""
    values = [f"{v:.4g}" for v in values]
    return values[0] if len(set(values)) == 1 else " ".join(values)
