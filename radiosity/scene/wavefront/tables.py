"""Materials of MTL libraries as tables of a scene file; docs/files.md gives the reasons."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import PurePath

import numpy as np

from radiosity.scene.model import ReadAs, SceneError
from radiosity.scene.wavefront.mtl import Map, Statements
from radiosity.scene.weak import WEAK

DULL = 10.0  # exponent (Ns) below which a highlight is so wide that it counts as diffuse
SHARPEST = 0.01  # roughness below which metal is a mirror
CLEAR = 0.9  # transmission from which on a body has no colour of its own
OF_BLENDER = 0.08  # its Ks 0.5 stands for the 4 % of light that glass reflects


@dataclass(frozen=True)
class Made:
    """A material's table, what was decided, and the picture it is textured with.

    ``pictures`` are by the names in the table; ``texture`` tells how they lie.
    """

    said: ReadAs
    notes: tuple[str, ...] = ()
    pictures: dict[str, np.ndarray] = field(default_factory=dict)
    texture: Map | None = None


def make(
    said: Statements, picture: Callable[[str], np.ndarray], named: Callable[[str], str],
    covered: bool, is_body: Callable[[], bool],
) -> Made:  # fmt: skip
    r"""Return what a material of an MTL library becomes.

    Parameters
    ----------
    said : Statements
    picture : callable
        Returns the pixels of a picture beside the library; raises SceneError.
    named : callable
        Returns the name that a texture gets in the table.
    covered : bool
        Whether all of its faces have texture coordinates.
    is_body : callable
        Whether its faces close one or several bodies and look outward.

    Examples
    --------
    >>> from radiosity.scene.wavefront.mtl import read_mtl
    >>> said, _ = read_mtl("newmtl a\nKd 0.5 0.4 0.3\nKs 0.2\nNs 60")
    >>> make(said["a"], None, str, False, lambda: False).said.table["specular"]
    {'model': 'blinn', 'reflectance': [0.2, 0.2, 0.2], 'exponent': 60.0}
    """
    notes = [f"{key} is not read" for key in said.others]
    base = _Base(said, picture, named, covered, notes)
    through, cover, refracts = _through(said, notes)
    if refracts and is_body():
        table = _body(through, said.numbers["Ni"])
    else:
        if refracts:
            notes.append("illum 6 or 7 of an open surface is taken as a thin pane")
        base.colour = base.colour * cover if cover < 1.0 else base.colour
        table = _surface(said, base, through, notes)
    emission = _emission(said, picture, notes)
    if emission.any():
        table["emission"] = {"radiance": emission.tolist()}
    origin = ", ".join(said.lines) or "nothing: Kd is 0.5"
    textured = base.pixels is not None and isinstance(table["diffuse"], dict)
    kept = {base.name: base.pixels} if textured else {}
    return Made(ReadAs(origin, table), tuple(notes), kept, base.map if textured else None)


class _Base:
    """The diffuse reflectance: a colour, times a picture where there is one."""

    def __init__(self, said, picture, named, covered, notes):
        self.colour, self.map, self.pixels = said.colour("Kd", 0.5), said.maps.get("map_Kd"), None
        self.highest = self.mean = np.ones(3)
        if self.map is None:
            return
        self.name = named(self.map.name)
        light = _light_of(self.map, picture, "map_Kd", "Kd stands", notes)
        if light is None:
            return
        if not self.colour.any():
            notes.append("Kd 0 beside map_Kd is taken as 1")
            self.colour = np.ones(3)
        self.highest, self.mean = (
            np.broadcast_to(x, 3) for x in (light.max(axis=(0, 1)), light.mean(axis=(0, 1)))
        )
        if covered:
            self.pixels = picture(self.map.name)
            return
        notes.append("map_Kd counts by its mean: some faces have no texture coordinates (vt)")
        self.colour, self.highest = self.colour * self.mean, np.ones(3)

    @property
    def brightest(self):
        return self.colour * self.highest

    def table(self):
        """Return the value of the key ``diffuse``."""
        if self.pixels is None:
            return self.colour.tolist()
        return {
            "texture": self.name, "scale": self.colour.tolist(), "repeat": not self.map.clamp,
        }  # fmt: skip


def _light_of(named, picture, key, instead, notes):
    """Return the linear light (h, w, bands) of a picture, None where it cannot be read."""
    from radiosity.light.texture import srgb_to_linear  # others need none of it
    from radiosity.scene.textures import CODED

    notes += [f"{key}: {option} is not read" for option in named.ignored]
    try:
        pixels = picture(named.name)
    except SceneError as error:
        notes.append(f"{key} {named.name} {error.problems[0]}: {instead}")
        return None
    light = pixels / (np.iinfo(pixels.dtype).max if pixels.dtype.kind in "iu" else 1.0)
    if not ((light >= 0.0) & (light <= 1.0)).all():  # false for nan
        notes.append(f"{key} {named.name} holds values outside [0, 1]: {instead}")
        return None
    return srgb_to_linear(light) if PurePath(named.name).suffix.lower() in CODED else light


def _through(said, notes):
    """Return what light goes through (3,), the share that is covered, and whether it is bent."""
    numbers = said.numbers
    opaque = numbers.get("d", 1.0 - numbers.get("Tr", 0.0))
    refracts = numbers.get("illum") in (6.0, 7.0) and numbers.get("Ni", 1.0) > 1.0
    tint = np.minimum(said.colour("Tf", 1.0), 1.0)
    through = tint if refracts and opaque == 1.0 else (1.0 - opaque) * tint
    if through.max() <= WEAK:
        if opaque < 1.0:
            notes.append(f"up to {WEAK:g} of light through a surface is left out")
        return np.zeros(3), 1.0, False
    return through, opaque if opaque < 1.0 else 1.0 - float(through.max()), refracts


def _body(through, index):
    """Return the table of a clear body; colour is what both of its surfaces leave together."""
    if through.min() >= CLEAR:
        return {"diffuse": 0.0, "mirror": "fresnel", "transmit": "fresnel", "ior": index}
    share = np.sqrt(through)
    mirror = np.minimum(((index - 1.0) / (index + 1.0)) ** 2, 1.0 - share)
    return {
        "diffuse": 0.0, "mirror": mirror.tolist(), "transmit": share.tolist(), "ior": index,
    }  # fmt: skip


def _surface(said, base, through, notes):
    """Return the table of a surface or a pane: base, highlight or mirror, what goes through."""
    metal = said.numbers.get("Pm", 0.0)
    model = said.numbers.get("illum", 2.0)
    if said.blender and model == 3.0:
        metal = 1.0
    optics = _metal(said, base, metal) if metal else _gloss(said, base, through, model, notes)
    table = {"diffuse": base.table()}
    if through.any():
        table["transmit"] = through.tolist()
    return table | optics


def _metal(said, base, metal):
    """Return what a metal reflects, and leave the rest of its colour to the base."""
    share = base.colour * base.mean * metal if base.pixels is not None else base.colour * metal
    base.colour = base.colour * (1.0 - metal)
    roughness = _roughness(said)
    if share.max() <= WEAK:
        return {}
    if roughness < SHARPEST:
        return {"mirror": share.tolist()}
    return {
        "specular": {
            "model": "torrance-sparrow", "reflectance": share.tolist(), "roughness": roughness,
        }  # fmt: skip
    }


def _roughness(said):
    """Return the roughness of facets, c3: Pr^2, or of Blinn's lobe cos^Ns as wide."""
    numbers = said.numbers
    if "Pr" in numbers:
        return min(max(numbers["Pr"], 0.0) ** 2, 1.0)
    if said.blender and "Ns" in numbers:  # it writes 1000 (1 - roughness)^2
        return float((1.0 - np.sqrt(min(numbers["Ns"] / 1000.0, 1.0))) ** 2)
    return float(np.sqrt(2.0 / (numbers.get("Ns", 0.0) + 2.0)))


def _exponent(said):
    """Return the exponent of Blinn's lobe, None where nothing tells it."""
    if "Pr" in said.numbers:
        return min(max(2.0 / max(_roughness(said), 1e-4) ** 2 - 2.0, 0.0), 1e9)
    return min(said.numbers["Ns"], 1e9) if "Ns" in said.numbers else None


def _gloss(said, base, through, model, notes):
    """Return the highlight or mirror of a surface whose diffuse base may have to make room."""
    share = np.minimum(said.colour("Ks"), 1.0) * (OF_BLENDER if said.blender else 1.0)
    if not share.any() or model in (0.0, 1.0):
        return {}
    sharp = model in (3.0, 5.0, 8.0) or (through.any() and model in (4.0, 6.0, 7.0, 9.0))
    sharp = sharp or ("Pr" in said.numbers and _roughness(said) < SHARPEST)
    exponent = _exponent(said)
    if not sharp and not exponent:
        notes.append("Ks without Ns, or with Ns 0, has no highlight")
        return {}
    left = np.maximum(1.0 - base.brightest - through, 0.0)
    fits = through.any() or share.max() <= WEAK
    share = np.minimum(share, left) if fits else _in_balance(share, base, notes)
    dull = not sharp and exponent < DULL
    if share.max() <= WEAK or dull:
        why = f"with Ns below {DULL:g}" if dull else f"up to {WEAK:g}"
        notes.append(f"Ks {why} counts as diffuse")
        if base.pixels is None:
            base.colour = base.colour + (share if sharp else _mean(share, exponent))
        return {}
    share = share.tolist()
    if sharp:
        return {"mirror": share}
    return {"specular": {"model": "blinn", "reflectance": share, "exponent": exponent}}


def _mean(share, exponent):
    """Return what a lobe that is too weak to be modelled reflects of diffuse light."""
    from radiosity.light.blinn import Blinn  # most materials need none of it

    return Blinn(share, exponent).mean_albedo


def _in_balance(share, base, notes):
    """Return the highlight, after both it and the base were scaled to reflect at most all light."""
    most = float((base.brightest + share).max())
    if most <= 1.0:
        return share
    notes.append("Kd + Ks reflect more than arrives: both are scaled down")
    most *= 1.0 + (1e-12 if base.pixels is None else 1e-6)  # texels have single precision
    base.colour = base.colour / most
    return share / most


def _emission(said, picture, notes):
    """Return the radiance (3,): Ke, times the mean of map_Ke."""
    emission, named = said.colour("Ke"), said.maps.get("map_Ke")
    if named is None:
        return emission
    light = _light_of(named, picture, "map_Ke", "Ke stands", notes)
    if light is None:
        return emission
    notes.append("map_Ke counts by its mean")
    mean = np.broadcast_to(light.mean(axis=(0, 1)), 3)
    return mean * (emission if emission.any() else 1.0)
