"""Schema: which keys a scene file has, which values they take, and what is said of wrong ones.

Every value has a check, see `radiosity.scene.checks`; pydantic walks the tables.
"""

import json
import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from radiosity.scene.checks import (
    RECEIVES,
    Bands,
    Colour,
    Number,
    Picture,
    Sequence,
    SpectrumFile,
    Table,
    TextureKey,
    Wrong,
    encoding,
    text_value,
    truth_value,
)
from radiosity.scene.geometry import LONGEST
from radiosity.scene.names import nearest
from radiosity.scene.units import UNITS

LARGEST_PICTURE = 16384


def _diffuse(value) -> tuple | SpectrumFile | TextureKey:
    return TEXTURE(value) if isinstance(value, dict) else REFLECTANCE(value)


def _picture_size(value) -> tuple[int, int]:
    what = f"must be [width, height], two whole numbers from 1 to {LARGEST_PICTURE}"
    whole = isinstance(value, list) and all(type(v) is int for v in value)
    if not whole or len(value) != 2 or not all(1 <= v <= LARGEST_PICTURE for v in value):
        raise Wrong(((), value, what))
    return tuple(value)


def _mesh(value) -> str:
    if value in ("auto", "input") or (type(value) is int and value >= 1):
        return str(value)
    raise Wrong(((), value, 'must be "auto", "input" or a whole number of cells from 1'))


def _smooth(value) -> bool | float:
    """Return true, false or an angle in degrees, or raise `Wrong`."""
    return value if isinstance(value, bool) else Number(0, 180, "degrees, or true or false")(value)


def _truth_radiosity(value) -> dict:
    bands = Bands(Number(0), "a number, [r, g, b] or a table of them by material or group")
    return Table(bands)(value) if isinstance(value, dict) else {"": bands(value)}


def _coherent(value) -> tuple | str:
    """Return a share of light by band, or "fresnel"."""
    if value == "fresnel":
        return value
    if isinstance(value, str):
        raise Wrong(((), value, 'must be a number, [r, g, b] or "fresnel"'))
    return REFLECTANCE(value)


def _roughness(value) -> float | TextureKey:
    """Return a spread of facets, or a texture of it."""
    if not isinstance(value, dict):
        return SPREAD(value)
    return SHININESS(value)


def _metal(value) -> str:
    from radiosity.light.metals import metal_names

    if value not in metal_names():
        raise Wrong(((), value, f"must be one of {', '.join(metal_names())}"))
    return value


REFLECTANCE = Colour(Number(0, 1, RECEIVES))
ABSORPTANCE = Colour(Number(0, 1, "it is 1 - reflectance"))
PICTURE = {"texture": text_value, "encoding": encoding, "repeat": truth_value}
TEXTURE = Picture(
    PICTURE | {"scale": Bands(Number(0, why="it multiplies reflectances"))},
    'diffuse = { texture = "wood.png" }',
)
INDEX = Colour(Number(1, 100, "vacuum has 1, water 1.33, glass 1.5"))
ABSORPTION = Bands(Number(0, 1e6, "in 1/m: exp(-absorption d) is left after a way d"))
BRIGHTEST = 1e30  # in any unit of light
POWER = Number(0, BRIGHTEST, "light cannot be taken away, and brighter overflows")
BANDS = Colour(POWER)
LENGTH = Number(-LONGEST, LONGEST, "powers of longer lengths cannot be computed")
EXTENT = Number(0, LONGEST, "the vertical extent shown, in scene units", inclusive=False)
POINT = Sequence(LENGTH, 3, "three numbers [x, y, z]")
SPREAD = Number(1e-4, 1, "from a mirror, which the key mirror gives, to 1")
SHININESS = Picture(
    PICTURE | {"minimum": SPREAD}, 'roughness = { texture = "t.png", minimum = 0.1 }', "minimum"
)
BUMP = Picture(
    PICTURE | {"height": LENGTH}, 'bump = { texture = "b.png", height = 0.01 }', "height"
)
SCALE = Bands(LENGTH, "a number or [x, y, z]")
POLYGON = Sequence(POINT, None, "a list of points [x, y, z]")
POLYGONS = Sequence(POLYGON, None, "a list of polygons [[[x, y, z], ...")
COORDINATE = Number(-1e9, 1e9, "a picture cannot be repeated more often")
UV = Sequence(Sequence(COORDINATE, 2, "two numbers [u, v]"), None, "a list of pairs [u, v]")
UVS = Sequence(UV, None, "a list of lists [[[u, v], ...], as polygons has")
MATRIX = Sequence(Sequence(LENGTH, 4, "four numbers"), 4, "four rows of four numbers")


def taken_by(check: Any) -> Any:
    """Return the type of a key whose value a check turns into what the model holds."""
    return Annotated[Any, BeforeValidator(check)]


OPTICAL = (  # keys of materials
    "specular", "mirror", "transmit", "ior", "metal", "translucent", "absorption",
)  # fmt: skip


class StrictTable(BaseModel):
    """A table of known keys only."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class SpecularTable(StrictTable):
    """The key ``specular`` of a material; `radiosity.scene.optics` knows which model has which."""

    model: Literal["phong", "blinn", "torrance-sparrow"] = Field(
        description='one of "phong", "blinn" and "torrance-sparrow"'
    )
    reflectance: taken_by(REFLECTANCE) = None
    exponent: taken_by(Number(0, 1e9, "the lobe is cos^exponent")) = None
    facets: Literal["gaussian", "beckmann", "trowbridge-reitz"] = "trowbridge-reitz"
    roughness: taken_by(_roughness) = None
    half_angle: taken_by(Number(0.01, 89.99, "in degrees")) = None
    shadowing: Literal["v-groove", "smith"] = "v-groove"
    ior: taken_by(INDEX) = None
    metal: taken_by(_metal) = None
    convention: Literal["normalised", "seed"] = "normalised"


class EmissionTable(StrictTable):
    """The key ``emission`` of a material: one of five quantities."""

    radiance: taken_by(BANDS) = None
    exitance: taken_by(BANDS) = None
    luminance: taken_by(POWER) = None
    radiant_flux: taken_by(BANDS) = None
    luminous_flux: taken_by(POWER) = None


class MaterialTable(StrictTable):
    """One ``[materials.NAME]``."""

    diffuse: taken_by(_diffuse) = None
    absorptance: taken_by(ABSORPTANCE) = None
    bump: taken_by(BUMP) = None
    two_sided: bool = True
    translucent: taken_by(REFLECTANCE) = None
    specular: SpecularTable | None = None
    mirror: taken_by(_coherent) = None
    transmit: taken_by(_coherent) = None
    ior: taken_by(INDEX) = None
    metal: taken_by(_metal) = None
    absorption: taken_by(ABSORPTION) = None
    emission: EmissionTable | None = None


class GeometryTable(StrictTable):
    """One ``[[geometry]]``."""

    file: str | None = None
    material: str | None = None
    polygons: taken_by(POLYGONS) = None
    uv: taken_by(UVS) = None
    smooth: taken_by(_smooth) = True
    unit: Literal[tuple(UNITS)] | None = None
    up: Literal["x", "y", "z"] | None = None
    repair: bool = True
    transform: taken_by(MATRIX) = None
    translate: taken_by(POINT) = None
    rotate: taken_by(POINT) = None
    scale: taken_by(SCALE) = None


class CameraTable(StrictTable):
    """One ``[cameras.NAME]``."""

    position: taken_by(POINT) = Field(description="the point the camera looks from, [x, y, z]")
    target: taken_by(POINT) = Field(description="the point the camera looks at, [x, y, z]")
    up: taken_by(POINT) = None
    projection: Literal["pinhole", "orthographic"] = "pinhole"
    fov: taken_by(Number(0, 180, "the vertical angle in degrees", inclusive=False)) = 40.0
    height: taken_by(EXTENT) = None
    size: taken_by(_picture_size) = (512, 512)


class TruthTable(StrictTable):
    """The table ``[truth]``."""

    radiosity: taken_by(_truth_radiosity) = Field(description="the known answer in W/m2")
    relative_tolerance: taken_by(Number(0, inclusive=False)) = Field(
        description="how far from it an answer may be"
    )
    mesh: taken_by(_mesh) = "auto"


class SceneTable(StrictTable):
    """The file: its keys at the top; the tables in it are checked one by one."""

    name: str = ""
    unit: Literal[tuple(UNITS)] = "m"
    up: Literal["x", "y", "z"] | None = None
    geometry: list[Any] = ()
    materials: dict[str, Any] = {}
    lights: list[Any] = ()
    cameras: dict[str, Any] = {}
    truth: dict[str, Any] | None = None


SENTENCES = {
    "string_type": "must be text in quotes",
    "bool_type": "must be true or false",
    "list_type": "must be a list of tables: write [[{key}]] above each",
    "dict_type": "must be a table: write [{key}] or {key}.NAME",
    "model_type": "must be a table of keys",
}


def checked(model: type[BaseModel], value, path: tuple, problems: list[str]) -> Any:
    """Return a table as its model, or None after its mistakes were appended to ``problems``."""
    try:
        return model.model_validate(value)
    except ValidationError as error:
        for e in error.errors():
            where = (*path, *e["loc"])
            problems += _sentences(model, where, e, len(path))
        return None


def _sentences(model, where, error, depth):
    """Return what is wrong as sentences with where, value, bound and way out."""
    wrong = error.get("ctx", {}).get("error")
    if isinstance(wrong, Wrong):
        return [at((*where, *path), value, text) for path, value, text in wrong.found]
    if error["type"] == "extra_forbidden":
        known = _model_at(model, where[depth:-1]).model_fields
        return [f"{dotted(where)} is not a known key here: {nearest(str(where[-1]), known)}"]
    if error["type"] == "missing":
        key = _model_at(model, where[depth:-1]).model_fields[where[-1]]
        return [f"{dotted(where)} is missing: {key.description}"]
    if error["type"] == "literal_error":
        return [at(where, error["input"], f"must be one of {error['ctx']['expected']}")]
    text = SENTENCES.get(error["type"], error["msg"])
    return [at(where, error["input"], text.format(key=where[-1] if where else ""))]


def _model_at(model, keys):
    """Return the model of a table inside the table of ``model``."""
    for key in keys:
        kinds = getattr(model.model_fields[key].annotation, "__args__", ())
        model = next(k for k in kinds if isinstance(k, type) and issubclass(k, BaseModel))
    return model


def values_of(table: BaseModel, kind: type) -> Iterator[Any]:
    """Yield the values of a kind in a checked table and in the tables in it."""
    for key in type(table).model_fields:
        value = getattr(table, key)
        if isinstance(value, BaseModel):
            yield from values_of(value, kind)
        elif isinstance(value, kind):
            yield value


def at(path: tuple, value, text: str) -> str:
    """Return one problem: key path, value and what is wrong with it."""
    return f"{dotted(path)} = {shown(value)} {text}"


def dotted(path: tuple) -> str:
    """Return a key path as TOML writes it, ``materials."my wall".diffuse[0]``."""
    text = ""
    for key in path:
        if isinstance(key, int):
            text += f"[{key}]"
        else:
            bare = re.fullmatch(r"[A-Za-z0-9_-]+", key)
            text += ("." if text else "") + (key if bare else quoted(key))
    return text


def quoted(text: str) -> str:
    """Return a text as TOML writes it, in quotes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def shown(value) -> str:
    """Return a value as TOML writes it, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        text = quoted(value)
    elif isinstance(value, int) and abs(value) >= 10**40:
        text = "a whole number of more than 40 digits"
    elif isinstance(value, dict):
        text = "{ " + ", ".join(f"{k} = {shown(v)}" for k, v in list(value.items())[:4]) + " }"
    elif isinstance(value, (list, tuple)):
        text = "[" + ", ".join(shown(v) for v in value[:5]) + "]"
    else:
        text = str(value)
    return text if len(text) <= 60 else text[:57] + "..."
