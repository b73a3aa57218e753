"""Checks: values that turn what TOML holds into what the model holds, or say what is wrong."""

import math
from dataclasses import dataclass
from typing import Any

from radiosity.scene.names import nearest


class Wrong(ValueError):
    """What is wrong inside a value: (path below it, value there, sentence) for each mistake."""

    def __init__(self, *found: tuple[tuple, Any, str]):
        self.found = found
        super().__init__(f"{len(found)} mistakes")


RECEIVES = "a surface cannot reflect more than it receives"
FAR = 1e6  # bound that nobody meets who means what he writes


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
            bound = self._bound(number < self.low)
            raise Wrong(((), value, bound + (f": {self.why}" if self.why else "")))
        return number

    def _bound(self, too_low) -> str:
        if math.isinf(self.high) or (too_low and self.high >= FAR):  # only to avoid overflow
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
            hint = "; a picture is { texture = .. }"
            raise Wrong(((), value, f"must be {what}{hint}"))
        return SpectrumFile(value, self.check)


def photometric_file(value) -> str:
    """Return the name of a photometric file, or raise `Wrong`."""
    if not isinstance(value, str) or not value.lower().endswith((".ies", ".ldt")):
        text = 'must name a photometric file, "NAME.ies" (LM-63) or "NAME.ldt" (EULUMDAT)'
        raise Wrong(((), value, text))
    return value


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


def value_of(table, key, check, default=None):
    """Return what a check makes of a key, None where it finds something wrong."""
    try:
        return check(table[key]) if isinstance(table, dict) and key in table else default
    except Wrong:
        return None


@dataclass(frozen=True)
class TextureKey:
    """A picture laid over a surface: its file, what its values are multiplied by and mean."""

    texture: str
    scale: tuple = (1.0, 1.0, 1.0)
    height: float = 1.0
    minimum: float | None = None
    encoding: str | None = None
    repeat: bool = True


@dataclass(frozen=True)
class Picture:
    """A table that names a texture and may give other keys, each with its own check."""

    checks: dict
    example: str
    needed: str = "texture"

    def __call__(self, value) -> TextureKey:
        """Return what the table says, or raise `Wrong`."""
        if not isinstance(value, dict) or "texture" not in value:
            raise Wrong(((), value, f"must name a texture: {self.example}"))
        if self.needed not in value:
            raise Wrong(((), value, f"must give {self.needed}: {self.example}"))
        found, good = [], {}
        for key, item in value.items():
            if key not in self.checks:
                text = f"is not a known key here: {nearest(key, self.checks)}"
                found.append(((key,), item, text))
                continue
            try:
                good[key] = self.checks[key](item)
            except Wrong as error:
                found += [((key, *path), v, text) for path, v, text in error.found]
        if found:
            raise Wrong(*found)
        return TextureKey(**good)


def text_value(value) -> str:
    """Return a text, or raise `Wrong`."""
    if not isinstance(value, str):
        raise Wrong(((), value, "must be text in quotes"))
    return value


def truth_value(value) -> bool:
    """Return true or false, or raise `Wrong`."""
    if not isinstance(value, bool):
        raise Wrong(((), value, "must be true or false"))
    return value


def encoding(value) -> str:
    """Return what numbers of a picture mean, or raise `Wrong`."""
    if value not in ("sRGB", "linear"):
        raise Wrong(((), value, 'must be "sRGB" or "linear"'))
    return value
