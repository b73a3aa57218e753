"""Schema: which keys a scene file has, which values they take, and what is said of wrong ones.

Every check is a value object that turns what TOML holds into what the model holds, or raises
`Wrong` with one sentence for each mistake; pydantic walks the tables.
"""

import difflib
import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from radiosity.scene.geometry import LONGEST

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
LARGEST_PICTURE = 16384
ROUNDING = 1e-9  # by which reflectances may add up to more than 1, as decimals are not exact
RECEIVES = "a surface cannot reflect more than it receives"


class Wrong(ValueError):
    """What is wrong inside a value: (path below it, value there, sentence) for each mistake."""

    def __init__(self, *found: tuple[tuple, Any, str]):
        self.found = found
        super().__init__(f"{len(found)} mistakes")


@dataclass(frozen=True)
class Number:
    """A finite number between bounds; ``why`` is what the bound means."""

    low: float = -math.inf
    high: float = math.inf
    why: str = ""
    inclusive: bool = True

    def __call__(self, value) -> float:
        """Return the number as float, or raise `Wrong`."""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise Wrong(((), value, "must be a number"))
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise Wrong(((), value, "must be a finite number"))
        outside = number < self.low or number > self.high
        if outside or (not self.inclusive and number in (self.low, self.high)):
            raise Wrong(((), value, self._bound() + (f": {self.why}" if self.why else "")))
        return number

    def _bound(self) -> str:
        if math.isinf(self.high):
            return f"must be {'at least' if self.inclusive else 'greater than'} {self.low:g}"
        if self.inclusive:
            return f"must lie in [{self.low:g}, {self.high:g}]"
        return f"must lie between {self.low:g} and {self.high:g}, both excluded"


@dataclass(frozen=True)
class Sequence:
    """A list of ``count`` values (any number if None) that one check each accepts."""

    check: Any
    count: int | None
    what: str

    def __call__(self, value) -> tuple:
        """Return the values as a tuple, or raise `Wrong`."""
        if not isinstance(value, list) or (self.count and len(value) != self.count):
            raise Wrong(((), value, f"must be {self.what}"))
        found, good = [], []
        for k, item in enumerate(value):
            try:
                good.append(self.check(item))
            except Wrong as error:
                found += [((k, *path), v, text) for path, v, text in error.found]
        if found:
            raise Wrong(*found)
        return tuple(good)


@dataclass(frozen=True)
class Bands:
    """A number, which stands for every band, or three of them."""

    check: Number
    what: str = "a number or [r, g, b]"

    def __call__(self, value) -> tuple:
        """Return three floats, or raise `Wrong`."""
        if isinstance(value, list):
            return Sequence(self.check, 3, self.what)(value)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise Wrong(((), value, f"must be {self.what}"))
        return (self.check(value),) * 3


@dataclass(frozen=True)
class SpectrumFile:
    """The name of a spectrum's file, and what its values are checked by."""

    name: str
    check: Number


@dataclass(frozen=True)
class Colour:
    """What `Bands` takes, or the name of a file with a spectrum."""

    check: Number

    def __call__(self, value) -> tuple | SpectrumFile:
        """Return three floats or a file, or raise `Wrong`."""
        what = 'a number or [r, g, b], or a spectrum, "NAME.csv"'
        if not isinstance(value, str):
            return Bands(self.check, what)(value)
        if not value.lower().endswith(".csv"):
            raise Wrong(((), value, f"must be {what}"))
        return SpectrumFile(value, self.check)


@dataclass(frozen=True)
class Table:
    """A table of any names whose values one check accepts."""

    check: Any

    def __call__(self, value) -> dict:
        """Return the table, or raise `Wrong`."""
        found, good = [], {}
        for name, item in value.items():
            try:
                good[name] = self.check(item)
            except Wrong as error:
                found += [((name, *path), v, text) for path, v, text in error.found]
        if not value:
            found.append(((), value, "must name at least one material or group"))
        if found:
            raise Wrong(*found)
        return good


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


def _truth_radiosity(value) -> dict:
    bands = Bands(Number(0), "a number, [r, g, b] or a table of them by material or group")
    return Table(bands)(value) if isinstance(value, dict) else {"": bands(value)}


REFLECTANCE = Colour(Number(0, 1, RECEIVES))
ABSORPTANCE = Colour(Number(0, 1, "it is 1 - reflectance"))
POWER = Number(0, why="light cannot be taken away")
BANDS = Colour(POWER)
LENGTH = Number(-LONGEST, LONGEST, "powers of longer lengths cannot be computed")
POINT = Sequence(LENGTH, 3, "three numbers [x, y, z]")
SCALE = Bands(LENGTH, "a number or [x, y, z]")
POLYGON = Sequence(POINT, None, "a list of points [x, y, z]")
POLYGONS = Sequence(POLYGON, None, "a list of polygons [[[x, y, z], ...")
MATRIX = Sequence(Sequence(LENGTH, 4, "four numbers"), 4, "four rows of four numbers")


def taken_by(check: Any) -> Any:
    """Return the type of a key whose value a check turns into what the model holds."""
    return Annotated[Any, BeforeValidator(check)]


class StrictTable(BaseModel):
    """A table of known keys only."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class SpecularTable(StrictTable):
    """The key ``specular`` of a material."""

    model: Literal["phong"] = Field(description='the only model is "phong"')
    reflectance: taken_by(REFLECTANCE) = Field(description="a colour in [0, 1]")
    exponent: taken_by(Number(0, why="the lobe is cos^exponent")) = Field(
        description="0 is as wide as diffuse reflection, 1000 nearly a mirror"
    )


class EmissionTable(StrictTable):
    """The key ``emission`` of a material: one of five quantities."""

    radiance: taken_by(BANDS) = None
    exitance: taken_by(BANDS) = None
    luminance: taken_by(POWER) = None
    radiant_flux: taken_by(BANDS) = None
    luminous_flux: taken_by(POWER) = None


class MaterialTable(StrictTable):
    """One ``[materials.NAME]``."""

    diffuse: taken_by(REFLECTANCE) = None
    absorptance: taken_by(ABSORPTANCE) = None
    two_sided: bool = True
    specular: SpecularTable | None = None
    emission: EmissionTable | None = None


class GeometryTable(StrictTable):
    """One ``[[geometry]]``."""

    file: str | None = None
    material: str | None = None
    polygons: taken_by(POLYGONS) = None
    transform: taken_by(MATRIX) = None
    translate: taken_by(POINT) = None
    rotate: taken_by(POINT) = None
    scale: taken_by(SCALE) = None


class CameraTable(StrictTable):
    """One ``[cameras.NAME]``."""

    position: taken_by(POINT) = Field(description="the point the camera looks from, [x, y, z]")
    target: taken_by(POINT) = Field(description="the point the camera looks at, [x, y, z]")
    up: taken_by(POINT) = None
    fov: taken_by(Number(0, 180, "the vertical angle in degrees", inclusive=False)) = 40.0
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
    up: Literal["x", "y", "z"] = "z"
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


def nearest(name: str, known) -> str:
    """Return a question with the known name most like this one, or all that are known."""
    like = difflib.get_close_matches(name, list(known), n=1)
    return f"did you mean {like[0]}?" if like else f"known are {', '.join(known) or 'none'}"


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
            text += ("." if text else "") + (key if bare else json.dumps(key, ensure_ascii=False))
    return text


def shown(value) -> str:
    """Return a value as TOML writes it, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        text = json.dumps(value, ensure_ascii=False)
    elif isinstance(value, int) and abs(value) >= 10**40:
        text = "a whole number of more than 40 digits"
    elif isinstance(value, dict):
        text = "{ " + ", ".join(f"{k} = {shown(v)}" for k, v in list(value.items())[:4]) + " }"
    elif isinstance(value, (list, tuple)):
        text = "[" + ", ".join(shown(v) for v in value[:5]) + "]"
    else:
        text = str(value)
    return text if len(text) <= 60 else text[:57] + "..."
