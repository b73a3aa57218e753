"""Materials of a glTF file as the tables of a scene file.

What a file says becomes a `Look`, and the look a table, see docs/files.md for how. Tables never
return more light than arrives: what goes through, is mirrored and is scattered share it.
"""

from dataclasses import replace

import numpy as np

from radiosity.scene.gltf.document import Document, Entry, Names
from radiosity.scene.gltf.images import Images
from radiosity.scene.gltf.looks import Look, look_of, words
from radiosity.scene.model import ReadAs
from radiosity.scene.weak import WEAK

MIRROR = 0.1  # roughness below which highlights are mirror images
COATED = 0.4  # from which on a dielectric coat is part of the diffuse reflectance
MATTE = 0.9  # from which on it is left out, as the base colour is what is meant
ROUGH_METAL = 0.8  # from which on a metal is diffuse
LEAST = 0.05  # reflectance of a metal below which it is part of the diffuse reflectance
FAINT = 1e-4  # reflectance at normal incidence of a coat that does not count
BRIGHTEST = 0.96  # the same of the greatest index that is read, 100
DIGITS = 10  # of numbers in tables
MARGIN = 1.0 - 1e-6  # texels are of single precision


class Materials:
    """The materials of a document, by number and by what primitives add to them.

    Attributes
    ----------
    tables : dict of str to ReadAs
    pictures : dict of str to array
        That the tables name.
    notes : dict of str to dict
        What is not modelled, and the names of the materials that have it.
    """

    def __init__(self, document: Document, images: Images):
        self.document, self.images = document, images
        self.tables, self.pictures, self.notes = {}, {}, {}
        self._names, self._looks, self._free = {}, {}, Names()

    def named(self, entry: Entry, colour: np.ndarray | None, sets) -> tuple[str, Entry | None]:
        """Return the name of a material, and the texture that its faces need coordinates of.

        Parameters
        ----------
        entry : Entry
        colour : (3,) float64 or None
            Of the primitive's vertices, by which the base colour is multiplied.
        sets : collection of int
            Texture coordinates that the primitive has: without those of the texture the material
            is of its mean colour.
        """
        look = self._look(entry)
        covered = look.picture is not None and self.images.set_of(look.texture) in sets
        tint = None if colour is None else tuple(np.round(colour, 3).tolist())
        key = entry.path[-1], tint, covered
        if key not in self._names:
            self._names[key] = self._made(entry, look, tint, covered)
        name = self._names[key]
        textured = isinstance(self.tables[name].table["diffuse"], dict)
        return name, look.texture if textured else None

    def _look(self, entry) -> Look:
        number = entry.path[-1]
        if number not in self._looks:
            self._looks[number] = look_of(entry, self.images, lambda text: self._note(text, entry))
        return self._looks[number]

    def _note(self, text, entry):
        self.notes.setdefault(text, {})[_called(entry)] = None

    def _made(self, entry, look, tint, covered) -> str:
        name, origin = self._free.free(_called(entry)), look.origin
        if tint is not None:
            look = look.times(np.array(tint))
            origin += f", times the vertices' mean colour {words(tint)}"
        if look.picture is not None and not covered:
            look = look.plain()
            self._note("textures without texture coordinates: their mean colour is taken", entry)
        if 0.0 < passing_straight(look) <= WEAK:
            look = replace(look, opacity=1.0, transmission=0.0, absorption=None)
            self._note(f"up to {WEAK:g} of light through a surface counts as diffuse", entry)
        table = table_of(look, self._repeats(look))
        if look.picture is not None and isinstance(table["diffuse"], dict):
            self.pictures[look.picture.name] = look.picture.pixels
        elif look.picture is not None:
            self._note("textures of metals and of clear bodies: their mean colour is taken", entry)
        if look.roughness >= COATED and look.absorption is not None:
            self._note("clear bodies that are rough: refract as smooth ones do", entry)
        self.tables[name] = ReadAs(origin, table)
        return name

    def _repeats(self, look):
        return look.texture is None or self.images.repeats(look.texture)


def _called(entry):
    return entry.name(f"material-{entry.path[-1] + 1}")


def passing_straight(look: Look) -> float:
    """Return the largest share of light that a surface lets through, in any band."""
    clear = look.transmission * (1.0 - look.metallic) * look.colour.max()
    return float(1.0 - look.opacity * (1.0 - clear))


def table_of(look: Look, repeat: bool = True) -> dict:
    """Return the table ``[materials.NAME]`` of a look."""
    clear = look.transmission * (1.0 - look.metallic) * look.colour.max()
    if look.absorption is not None and clear > FAINT:
        table, diffuse = _body(look)
    elif look.transmission > 0.0 or look.opacity < 1.0:
        table, diffuse = _sheet(look)
    else:
        table, diffuse = _opaque(look)
    table = {"diffuse": _diffuse(look, diffuse, table, repeat)} | {
        key: value for key, value in table.items() if not _nothing(value)
    }
    if look.emission is not None and look.emission.any():
        table["emission"] = {"radiance": (look.emission * look.opacity).tolist()}
    return table


def _nothing(value):
    return isinstance(value, list) and not any(value)


def _opaque(look):
    """Return the keys of what lets no light straight through, and its diffuse reflectance (3,)."""
    table, kept = _metal(look, 1.0)
    share = 1.0 - look.metallic
    diffuse = look.colour * share * (1.0 - look.passed)
    through = _passing(look) * share
    if look.f0.max() < FAINT or look.roughness >= MATTE:
        pass
    elif kept or look.roughness >= COATED:
        coat = coat_albedo(look.f0, look.roughness)
        diffuse, through = share * coat + diffuse * (1.0 - coat), through * (1.0 - coat)
    else:
        table |= _coat(look)
    diffuse = diffuse + (0.0 if kept else look.metal)
    return table | {"translucent": _listed(through)}, diffuse


def _passing(look):
    return np.zeros(3) if look.passing is None else look.passing


def _metal(look, share):
    """Return the keys of a share of a metal, and whether there are any: others are diffuse."""
    metal = look.metal * share
    if metal.max() < LEAST or look.roughness >= ROUGH_METAL:
        return {}, False
    if look.roughness < MIRROR:
        return {"mirror": _listed(metal)}, True
    return {"specular": _lobe(look.roughness) | {"reflectance": _listed(metal)}}, True


def _lobe(roughness):
    """Return Trowbridge-Reitz facets whose c3 is GGX's alpha, glTF's roughness squared."""
    return {
        "model": "torrance-sparrow", "facets": "trowbridge-reitz", "shadowing": "smith",
        "roughness": round(roughness**2, DIGITS),
    }  # fmt: skip


def _coat(look):
    """Return the keys of a dielectric coat, by the index that reflects as much."""
    index = _index(look.f0)
    if look.roughness < MIRROR:
        return {"mirror": "fresnel", "ior": index}
    return {"specular": _lobe(look.roughness) | {"ior": index}}


def _index(f0):
    from radiosity.light.fresnel import index_of_reflectance  # matte files need it not

    index = index_of_reflectance(np.minimum(f0, BRIGHTEST)).round(6)
    return float(index[0]) if np.ptp(index) == 0.0 else index.tolist()


def coat_albedo(f0: np.ndarray, roughness: float) -> np.ndarray:
    """Return what a dielectric coat reflects of diffuse light, (3,), at glTF's roughness r.

    That of a smooth one times exp(-1.66 r^2): of Torrance-Sparrow's lobe with Smith's shadowing and
    an index of 1.5 it differs by less than 0.003 from r = 0.3 on.
    """
    from radiosity.light.fresnel import index_of_reflectance, mean_reflectance

    smooth = mean_reflectance(index_of_reflectance(np.minimum(f0, BRIGHTEST)))
    return smooth * np.exp(-1.66 * roughness**2)


def _sheet(look):
    """Return the keys of a thin sheet that light crosses, and its diffuse reflectance (3,).

    Of what is there, a share alpha, the surface mirrors f0, a share goes through in the base
    colour, straight or evenly, and the rest is diffuse; 1 - alpha goes straight through.
    """
    alpha, t, even = look.opacity, look.transmission, look.roughness >= COATED
    table, kept = _metal(look, alpha)
    share = alpha * (1.0 - look.metallic)
    f0 = np.zeros(3) if look.roughness >= MATTE else np.minimum(look.f0, 1.0)
    under = share * (1.0 - f0)
    clear = under * t * look.colour
    diffuse = under * (1.0 - t) * (1.0 - look.passed) * look.colour
    diffuse = diffuse + (0.0 if kept else alpha * look.metal)
    if even:
        diffuse = diffuse + share * f0 * (1.0 - t)
        f0 = f0 * t
    through = under * (1.0 - t) * _passing(look) + (clear if even else 0.0)
    straight = 1.0 - alpha + (0.0 if even else clear)
    mirrored = share * f0 + np.array(table.pop("mirror", [0.0] * 3))
    return table | {
        "mirror": _listed(mirrored), "transmit": _listed(straight), "translucent": _listed(through)
    }, diffuse  # fmt: skip


def _body(look):
    """Return the keys of a clear body, and the diffuse reflectance (3,) of its surface."""
    t, share = look.transmission, 1.0 - look.metallic
    table = {"ior": round(look.ior, 6), "absorption": _listed(look.absorption)}
    if look.colour.min() * t * share >= 1.0 - 1e-6:
        return table | {"mirror": "fresnel", "transmit": "fresnel"}, np.zeros(3)
    f0 = np.full(3, min(((look.ior - 1.0) / (look.ior + 1.0)) ** 2, BRIGHTEST))
    under = share * (1.0 - f0) * look.colour
    mirrored = _listed(share * f0 + look.metal)
    return table | {"mirror": mirrored, "transmit": _listed(under * t)}, under * (1.0 - t)


def _diffuse(look, diffuse, table, repeat) -> list | dict:
    """Return the value of ``diffuse``: (3,), or a texture whose mean it is."""
    colour = look.colour
    if look.picture is None or not np.all(colour > 0.0) or diffuse.max() < 1e-3:
        return _listed(diffuse)
    others = sum(np.array(table[key]) for key in ("mirror", "transmit", "translucent")
                 if isinstance(table.get(key), list))  # fmt: skip
    others = others + np.array(table.get("specular", {}).get("reflectance", 0.0))
    room = np.clip(1.0 - others, 0.0, 1.0) * (MARGIN if np.any(others) else 1.0)
    most = room / np.maximum(look.picture.highest, 1e-12)
    scale = look.base * diffuse / colour
    scale = np.where(scale * look.picture.highest > room, most * MARGIN, scale)
    return {
        "texture": look.picture.name, "encoding": "sRGB", "repeat": repeat, "scale": _listed(scale)
    }  # fmt: skip


def _listed(values) -> list[float]:
    return np.round(np.broadcast_to(values, 3), DIGITS).tolist()
