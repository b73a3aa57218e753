"""Optics of a material in a scene file: its lobe, mirror and transmission, and what is wrong."""

import numpy as np

from radiosity.light import coherent
from radiosity.light.blinn import Blinn
from radiosity.light.facets import DISTRIBUTIONS, Beckmann
from radiosity.light.metals import band_weights, metal_bands, metal_index, metal_range
from radiosity.light.palette import NEUTRAL, Palette, Rgb
from radiosity.light.phong import Phong
from radiosity.light.reflection import shown
from radiosity.light.seed_forms import SeedForm
from radiosity.light.shadowing import SHADOWING
from radiosity.light.torrance_sparrow import TorranceSparrow
from radiosity.scene.checks import SpectrumFile, TextureKey, value_of
from radiosity.scene.energy import excess
from radiosity.scene.schema import (
    ABSORPTANCE,
    REFLECTANCE,
    MaterialTable,
    SpecularTable,
    at,
    checked,
    dotted,
    values_of,
)

RGB_AS_GIVEN = Rgb()
OF_LOBES = {"phong": Phong, "blinn": Blinn}
OF_FACETS = ("facets", "roughness", "half_angle", "shadowing", "ior", "metal")
MISSING = {
    "reflectance": "a number or [r, g, b] in [0, 1]",
    "exponent": "0 is as wide as diffuse reflection, 1000 nearly a mirror",
}


def optics_of(table: MaterialTable, palette: Palette = RGB_AS_GIVEN) -> tuple:
    """Return lobe, mirror, transmission and what goes through evenly, None each if not there.

    Of a material that is right, in the bands of a palette.
    """
    lobe = table.specular and _lobe(table.specular, palette)
    index = _index(table.ior, table.metal, palette)
    mirror = _law(table.mirror, coherent.FresnelMirror, index, None, palette)
    passage = _law(table.transmit, coherent.FresnelPassage, index, index, palette)
    through = None if table.translucent is None else palette.share(table.translucent)
    return lobe, mirror, passage, through


def optics_problems(table: dict, path: tuple) -> list[str]:
    """Return what is wrong between the optical keys of a material, and where they add up to more.

    Keys that are wrong by themselves are left to the schema.
    """
    problems = _specular_problems(table.get("specular"), (*path, "specular"))
    problems += _coherent_problems(table, path) + _sheet_problems(table, path)
    too_much = excess(*_parts(table, problems))
    return problems + ([f"{dotted(path)}: {too_much}"] if too_much else [])


def _specular_problems(table, path):
    model = table.get("model") if isinstance(table, dict) else None
    if model not in (*OF_LOBES, "torrance-sparrow"):
        return []
    if model in OF_LOBES:
        own = [f"{dotted((*path, k))} is missing: {v}" for k, v in MISSING.items()
               if k not in table]  # fmt: skip
        return own + _foreign(table, path, OF_FACETS, "torrance-sparrow")
    return (
        _foreign(table, path, ("exponent",), "phong or blinn")
        + _one_of(table, path, ("roughness", "half_angle"), needed=True)
        + _one_of(table, path, ("ior", "metal"))
        + _beckmann_problems(table, path)
        + _shininess_problems(table, path)
    )


def _foreign(table, path, keys, model):
    return [
        f"{dotted((*path, key))} belongs to model {model}: leave it out, or change the model"
        for key in keys if key in table
    ]  # fmt: skip


def _one_of(table, path, keys, needed=False):
    found = [key for key in keys if key in table]
    if len(found) == 1 or (not found and not needed):
        return []
    gives = " and ".join(found) or f"neither {keys[0]} nor {keys[1]}"
    return [f"{dotted(path)} gives {gives}: give one of them"]


def _beckmann_problems(table, path):
    beta = table.get("half_angle")
    if table.get("facets") != "beckmann" or not isinstance(beta, (int, float)) or not 0 < beta < 90:
        return []
    try:
        Beckmann.of_half_angle(beta)
    except ValueError as error:
        return [at((*path, "half_angle"), beta, str(error).split(" degrees ", 1)[1])]
    return []


def _shininess_problems(table, path):
    facets = table.get("facets", "trowbridge-reitz")
    if not isinstance(table.get("roughness"), dict):
        return []
    if table.get("convention") == "seed":
        text = "has one roughness only: leave it out, or the texture"
        return [at((*path, "convention"), "seed", text)]
    if facets == "trowbridge-reitz":
        return []
    text = "cannot have their roughness from a texture: use trowbridge-reitz, whose c3 it is"
    return [at((*path, "facets"), facets, text)]


def _coherent_problems(table, path):
    """Return what is wrong between mirror, transmit and the index that they use."""
    by_fresnel = [key for key in ("mirror", "transmit") if table.get(key) == "fresnel"]
    problems = _one_of(table, path, ("ior", "metal"))
    if by_fresnel and not ("ior" in table or "metal" in table):
        problems.append(
            f'{dotted((*path, by_fresnel[0]))} = "fresnel" needs ior = .. or metal = ".." beside '
            "it: how much is reflected follows from the index of refraction"
        )
    if "metal" in table and "transmit" in table:
        problems.append(f"{dotted(path)} gives metal and transmit: metals let nothing through")
    if table.get("absorption") and not ("transmit" in table and "ior" in table):
        problems.append(
            f"{dotted((*path, 'absorption'))} is not used: it belongs to the inside of a clear "
            "body, with transmit and ior"
        )
    for key in ("ior", "metal"):
        used = isinstance(table.get("mirror"), str) or (key == "ior" and "transmit" in table)
        if key in table and not used:
            problems.append(
                f'{dotted((*path, key))} is not used: it belongs to mirror = "fresnel"'
                f"{' or transmit' if key == 'ior' else ''}, or into specular"
            )
    return problems


def _sheet_problems(table, path):
    if not table.get("translucent") or table.get("two_sided") is not False:
        return []
    return [
        f"{dotted(path)} is translucent and not two_sided: a sheet that light goes through has two "
        "sides alike; leave out two_sided"
    ]


def _parts(table, problems):
    """Return base, lobe, mirror, transmission and what goes through, but what is wrong.

    Lobes of Phong and Blinn return most at normal incidence, whatever their exponent.
    """
    base = _base(table)
    rest = {key: table[key] for key in ("mirror", "transmit", "ior", "metal") if key in table}
    made = None if problems else checked(MaterialTable, rest, (), [])
    told = made and not any(values_of(made, SpectrumFile))
    mirror, transmit = optics_of(made)[1:3] if told else (None, None)
    specular = table.get("specular")
    right = checked(SpecularTable, specular, (), []) if not problems and specular else None
    told = right and not any(values_of(right, SpectrumFile))
    lobe = _lobe(right, RGB_AS_GIVEN) if told else _lobe_of_any_exponent(specular)
    return base, lobe, mirror, transmit, _share(table, "translucent")


def _lobe_of_any_exponent(table):
    """Return a lobe for a wrong table whose model and reflectance are right, None if not."""
    if not isinstance(table, dict) or table.get("model") not in tuple(OF_LOBES):
        return None
    share = _share(table, "reflectance")
    return None if share is None else Phong(share, 0.0)


def _base(table):
    kept = _share(table, "absorptance", ABSORPTANCE)
    diffuse = _share(table, "diffuse")
    if diffuse is not None:
        return diffuse
    return np.zeros(3) if kept is None else 1.0 - kept


def _share(table, key, check=REFLECTANCE):
    found = value_of(table, key, check)
    return np.array(found) if isinstance(found, tuple) else None


def _lobe(table: SpecularTable, palette):
    """Return the reflection model of a table without mistakes."""
    if table.model in OF_LOBES:
        lobe = OF_LOBES[table.model](palette.share(table.reflectance), table.exponent)
    else:
        kind = DISTRIBUTIONS[table.facets]
        facets = _facets(kind, table)
        scale = palette.share(table.reflectance or NEUTRAL)
        index, shadowing = _index(table.ior, table.metal, palette), SHADOWING[table.shadowing]
        words = table.metal or (f"index {shown(index)}" if table.ior else "")
        lobe = TorranceSparrow(facets, shadowing, index, scale, words)
    return SeedForm(lobe) if table.convention == "seed" else lobe


def _facets(kind, table):
    """Return the facets of a table; of a texture the shiniest, see `textures.Details`."""
    if table.roughness is None:
        return kind.of_half_angle(table.half_angle)
    textured = isinstance(table.roughness, TextureKey)
    return kind(table.roughness.minimum if textured else table.roughness)


def _index(ior, metal, palette):
    """Return an index by band, one where all bands have the same; None where none is given."""
    nm = palette.bands.wavelengths
    if metal and nm is not None:
        return metal_index(metal, np.clip(nm, *metal_range()))
    if metal:
        return _by_band(metal_bands(metal), palette)
    if ior is None:
        return None
    if isinstance(ior, tuple):
        return np.array(ior[:1]) if len(set(ior)) == 1 else _by_band(np.array(ior), palette)
    if nm is not None:
        return np.interp(nm, ior.nm, ior.values)
    known, weights = band_weights()
    values = np.interp(known, ior.nm, ior.values)
    return _by_band(np.clip(weights @ values, values.min(), values.max()), palette)


def _by_band(rgb, palette):
    """Return what is given for red, green and blue (3,) in the bands of a palette."""
    if palette.shares is None:
        return rgb
    return rgb @ palette.shares.T


def _law(given, by_fresnel, index, bent, palette):
    if given == "fresnel":
        return by_fresnel(index)
    if given is None or not np.any(given):
        return None
    return coherent.Constant(palette.share(given), bent)
