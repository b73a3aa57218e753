"""The JSON of a glTF file: values with their place, so that what is wrong can say where."""

import json
import math
import re
import struct
from functools import cached_property

from radiosity.scene.model import SceneError
from radiosity.scene.schema import at, dotted

MOST_VALUES = 1 << 22  # in the JSON, each of which takes some hundred bytes of memory
MAGIC, JSON_CHUNK, BIN_CHUNK = b"glTF", 0x4E4F534A, 0x004E4942
LARGEST_INDEX = 1 << 53
CALLED = 100  # characters of a name that are kept


class Entry:
    """A table of the JSON, its place and the file's name.

    Every method raises SceneError where a value is not of its kind or outside its bounds.
    """

    def __init__(self, value: dict, path: tuple, source: str):
        self.value, self.path, self.source = value, path, source

    def has(self, key: str) -> bool:
        """Whether the table gives a key."""
        return key in self.value

    def fail(self, key: str, text: str):
        """Raise SceneError with the place and the value of a key."""
        if key in self.value:
            value = self.value[key]
            if isinstance(value, dict) or (isinstance(value, list) and not _flat(value)):
                value = {} if isinstance(value, dict) else []
            raise SceneError(self.source, [at((*self.path, key), value, text)])
        raise SceneError(self.source, [f"{dotted((*self.path, key))} is missing: it {text}"])

    def child(self, key: str) -> "Entry":
        """Return a table in the table; an empty one if it is not there."""
        value = self.value.get(key, {})
        if not isinstance(value, dict):
            self.fail(key, "must be an object { ... }")
        return Entry(value, (*self.path, key), self.source)

    def extension(self, name: str) -> "Entry":
        """Return the table of an extension; an empty one if it is not there."""
        return self.child("extensions").child(name)

    def extended(self, name: str) -> bool:
        """Whether the table has an extension."""
        return self.child("extensions").has(name)

    def tables(self, key: str) -> "list[Entry]":
        """Return the tables of a list; none if it is not there."""
        listed = self.value.get(key, [])
        if not isinstance(listed, list) or not all(isinstance(v, dict) for v in listed):
            self.fail(key, "must be a list of objects [{ ... }, ...]")
        return [Entry(v, (*self.path, key, k), self.source) for k, v in enumerate(listed)]

    def whole(self, key: str, default: int | None = None, low=0, high=LARGEST_INDEX) -> int:
        """Return a whole number within bounds; it must be there unless there is a default."""
        value = self.value.get(key, default)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            self.fail(key, f"must be a whole number from {low} to {high}")
        return value

    def wholes(self, key: str) -> list[int]:
        """Return a list of whole numbers from 0; none if it is not there."""
        listed = self.value.get(key, [])
        if not isinstance(listed, list):
            self.fail(key, "must be a list of whole numbers")
        return [Entry({str(k): v}, (*self.path, key), self.source).whole(str(k))
                for k, v in enumerate(listed)]  # fmt: skip

    def number(self, key: str, default: float, low=-math.inf, high=math.inf) -> float:
        """Return a finite number within bounds."""
        value = self.value.get(key, default)
        if not _finite(value) or not low <= value <= high:
            self.fail(key, f"must be a number{_within(low, high)}")
        return float(value)

    def numbers(self, key: str, default: tuple, low=-math.inf, high=math.inf) -> tuple:
        """Return as many finite numbers within bounds as the default has."""
        value = self.value.get(key, default)
        good = isinstance(value, (list, tuple)) and len(value) == len(default)
        if not good or not all(_finite(v) and low <= v <= high for v in value):
            self.fail(key, f"must be a list of {len(default)} numbers{_within(low, high)}")
        return tuple(float(v) for v in value)

    def weights(self, key: str) -> list[float] | None:
        """Return a list of any number of finite numbers, None if it is not there."""
        value = self.value.get(key)
        if value is None:
            return None
        if not isinstance(value, list) or not all(map(_finite, value)):
            self.fail(key, "must be a list of numbers")
        return [float(v) for v in value]

    def text(self, key: str, default: str = "") -> str:
        """Return a text."""
        value = self.value.get(key, default)
        if not isinstance(value, str):
            self.fail(key, "must be text in quotes")
        return value

    def name(self, default: str) -> str:
        """Return what the table is called, fit to print, or a default."""
        text = self.text("name").encode("utf-8", "replace").decode()
        return re.sub(r"[\x00-\x1f\x7f-\x9f]+", " ", text).strip()[:CALLED] or default

    def flag(self, key: str) -> bool:
        """Return true or false, which is the default."""
        value = self.value.get(key, False)
        if not isinstance(value, bool):
            self.fail(key, "must be true or false")
        return value


class Names:
    """Names that are taken, of which thousands may be alike."""

    def __init__(self):
        self._taken, self._counts = set(), {}

    def free(self, name: str) -> str:
        """Return a name that is not taken, itself or with a number, and take it."""
        found = name
        while found in self._taken:
            self._counts[name] = self._counts.get(name, 1) + 1
            found = f"{name}-{self._counts[name]}"
        self._taken.add(found)
        return found


class Document:
    """The JSON of a glTF file and the binary chunk that a GLB file has beside it.

    Attributes
    ----------
    source : str
    top : Entry
    binary : bytes or None
    """

    def __init__(self, data: bytes, source: str):
        self.source = source
        text, self.binary = _chunks(data, source)
        self.top = Entry(_parsed(text, source), (), source)
        self._lists = {}
        self._check_version()

    def listed(self, kind: str) -> list[Entry]:
        """Return the tables of a list at the top."""
        if kind not in self._lists:
            self._lists[kind] = self.top.tables(kind)
        return self._lists[kind]

    def referred(self, entry: Entry, key: str, kind: str) -> Entry | None:
        """Return the table that a key names by its number; None if the key is not there."""
        if not entry.has(key):
            return None
        return self.numbered(entry, key, entry.whole(key), kind)

    def numbered(self, entry: Entry, key: str, number: int, kind: str) -> Entry:
        """Return a table of a list at the top; ``key`` is where it was named."""
        known = self.listed(kind)
        if number >= len(known):
            entry.fail(key, f"names {kind}[{number}], there are {len(known)}, counted from 0")
        return known[number]

    @cached_property
    def used(self) -> list[str]:
        """Return the names of the extensions that the file says it uses."""
        return self._names("extensionsUsed")

    @cached_property
    def required(self) -> list[str]:
        """Return the names of the extensions without which the file cannot be read."""
        return self._names("extensionsRequired")

    def _names(self, key):
        listed = self.top.value.get(key, [])
        if not isinstance(listed, list) or not all(isinstance(v, str) for v in listed):
            self.top.fail(key, "must be a list of names")
        return list(dict.fromkeys(listed))

    def _check_version(self):
        asset = self.top.child("asset")
        if not asset.has("version"):
            asset.fail("version", "tells that this is glTF, 2.0")
        version = asset.text("version")
        if version != "2.0" and not re.fullmatch(r"2\.\d+", version):
            asset.fail("version", "is not read, glTF 2.0 is: export the scene again as 2.0")


def _chunks(data, source):
    """Return the JSON text and the binary chunk (None if there is none) of a file."""
    if data[:4] != MAGIC:
        return data, None
    if len(data) < 20:
        raise SceneError(source, [f"has {len(data)} bytes, a GLB file has 20 or more: it is cut"])
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise SceneError(source, [f"is GLB of version {version}, 2 is read: export it again"])
    if length > len(data):
        text = f"says that it has {length} bytes, but has {len(data)}: it was cut, get it again"
        raise SceneError(source, [text])
    found, place = {}, 12
    while place + 8 <= length:
        size, kind = struct.unpack_from("<II", data, place)
        place += 8
        if size > length - place:
            text = f"byte {place - 8}: a chunk of {size} bytes, {length - place} are left: it is "
            raise SceneError(source, [text + "broken, get it again"])
        found.setdefault(kind, data[place : place + size])
        place += size
    if JSON_CHUNK not in found:
        raise SceneError(source, ["has no JSON chunk: it is not a GLB file that can be read"])
    return found[JSON_CHUNK], found.get(BIN_CHUNK)


def _parsed(text, source):
    """Return the JSON as a dict."""
    values = sum(text.count(mark) for mark in (b",", b"[", b"{"))
    if values > MOST_VALUES:
        problem = f"has about {values} values in its JSON, at most {MOST_VALUES} are read: split it"
        raise SceneError(source, [problem])
    try:
        tree = json.loads(text.decode("utf-8-sig").rstrip("\x00"))
    except UnicodeDecodeError as error:
        problem = f"byte {error.start} of its JSON is not UTF-8: it is no glTF file, or broken"
    except json.JSONDecodeError as error:
        problem = f"line {error.lineno}, column {error.colno}: {error.msg} (this is not valid JSON)"
    except RecursionError:
        problem = "has lists or objects nested too deeply in its JSON"
    except ValueError as error:  # a whole number of thousands of digits
        problem = f"a number cannot be read: {error}"
    else:
        if isinstance(tree, dict):
            return tree
        problem = "is not a glTF file: its JSON must be an object { ... }"
    raise SceneError(source, [problem])


def _finite(value):
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) < 1e300


def _flat(listed):
    """Whether there are no lists in a list: those may be nested too deeply to be shown."""
    return not any(isinstance(value, (list, dict)) for value in listed)


def _within(low, high):
    if math.isinf(low) and math.isinf(high):
        return ""
    return f" of at least {low:g}" if math.isinf(high) else f" in [{low:g}, {high:g}]"
