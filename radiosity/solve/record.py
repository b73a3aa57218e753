"""Frozen values as a JSON tree and arrays, and back: of known classes only, nothing is run.

A dataclass is ``{"class": name, "fields": {..}}``, a dict ``{"items": [[key, value], ..]}``, a list
``{"list": [..]}``, a tuple a JSON array, a float that JSON cannot name ``{"float": "inf"}``, a
known constant or function ``{"known": name}``. Small arrays stand in the tree with every digit,
``{"type", "shape", "values"}``, the others beside it, ``{"array": name}``.
"""

import types
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from importlib import import_module
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

SMALL = 64  # numbers of an array that stand in the tree
HOMES = {
    "radiosity.light.bands": ("Bands",),
    "radiosity.light.blinn": ("Blinn",),
    "radiosity.light.bump": ("Bump",),
    "radiosity.light.coherent": ("Constant", "FresnelMirror", "FresnelPassage"),
    "radiosity.light.facets": ("Beckmann", "CosinePower", "Gaussian", "TrowbridgeReitz"),
    "radiosity.light.luminaire": ("Distribution", "Luminaire"),
    "radiosity.light.phong": ("Phong",),
    "radiosity.light.seed_forms": ("SeedForm",),
    "radiosity.light.shininess": ("Shininess",),
    "radiosity.light.sources": ("Directional", "Falloff", "Flood", "Point", "Spot"),
    "radiosity.light.texture": ("Mixed", "Texture"),
    "radiosity.light.torrance_sparrow": ("TorranceSparrow",),
    "radiosity.mesh.contact": ("Contacts", "FaceContact"),
    "radiosity.mesh.division": ("Division",),
    "radiosity.mesh.faces": ("Faces",),
    "radiosity.scene.model": ("Camera", "Material", "ReadAs", "Scene", "Truth"),
    "radiosity.solve.container": ("Saved", "SavedLevel", "SavedMesh"),
    "radiosity.solve.estimate": ("Estimate",),
    "radiosity.solve.plan": ("Plan", "Recipe"),
    "radiosity.solve.relight": ("Share",),
}
CLASSES = {name: home for home, names in HOMES.items() for name in names}
KNOWN = {
    "RGB": "radiosity.light.bands", "GREY": "radiosity.light.bands",
    "v_groove": "radiosity.light.shadowing", "smith": "radiosity.light.shadowing",
}  # fmt: skip
TYPES = ("<f8", "<f4", "<c16", "<i8", "|b1", "|u1")


class Unreadable(ValueError):
    """A tree that stands for no value: says where, and what is wrong there."""


def recorded(value: Any, name: str, arrays: dict[str, np.ndarray]) -> Any:
    """Return a value as JSON can hold it; larger arrays are put into ``arrays``, by names.

    Raises
    ------
    TypeError
        A value of an unknown kind.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if np.isfinite(value) else {"float": str(value)}
    if isinstance(value, np.ndarray):
        return _recorded_array(value, name, arrays)
    if isinstance(value, tuple):
        return [recorded(x, f"{name}/{k}", arrays) for k, x in enumerate(value)]
    if isinstance(value, list):
        return {"list": [recorded(x, f"{name}/{k}", arrays) for k, x in enumerate(value)]}
    if isinstance(value, dict):
        pairs = enumerate(value.items())
        return {"items": [[key, recorded(x, f"{name}/{k}", arrays)] for k, (key, x) in pairs]}
    known = [key for key, home in KNOWN.items() if value is getattr(import_module(home), key)]
    if known:
        return {"known": known[0]}
    kind = type(value)
    if not is_dataclass(value) or CLASSES.get(kind.__name__) != kind.__module__:
        raise TypeError(f"{name}: a {kind.__module__}.{kind.__name__} cannot be stored in a file")
    parts = {
        f.name: recorded(getattr(value, f.name), f"{name}/{f.name}", arrays) for f in fields(value)
    }
    return {"class": kind.__name__, "fields": parts}


def _recorded_array(value, name, arrays):
    kind = "<i8" if value.dtype.kind == "i" else value.dtype.newbyteorder("<").str
    if kind not in TYPES:
        raise TypeError(f"{name}: an array of {value.dtype} cannot be stored in a file")
    value = value.astype(kind, copy=False)
    if value.size > SMALL:
        arrays[name] = value
        return {"array": name}
    flat = np.ascontiguousarray(value).ravel()
    flat = flat.view("<f8") if kind == "<c16" else flat
    values = [x if np.isfinite(x) else str(x) for x in flat.tolist()]
    return {"type": kind, "shape": list(value.shape), "values": values}


def rebuilt(tree: Any, arrays: dict[str, np.ndarray], where: str = "content") -> Any:
    """Return the value that a tree stands for.

    Raises
    ------
    Unreadable
        Where it stands for none, or for one whose parts are not of the kind that they must be.
    """
    if tree is None or isinstance(tree, bool | int | float | str):
        return tree
    if isinstance(tree, list):
        return tuple(rebuilt(x, arrays, f"{where}[{k}]") for k, x in enumerate(tree))
    if not isinstance(tree, dict):
        raise Unreadable(f"{where} is a {type(tree).__name__}")
    for key, read in _READERS.items():
        if key in tree:
            return read(tree, arrays, where)
    raise Unreadable(f"{where} has the keys {', '.join(map(str, tree))[:80]}, which mean nothing")


def _list(tree, arrays, where):
    return list(rebuilt(_part(tree, "list", list, where), arrays, where))


def _items(tree, arrays, where):
    pairs = _part(tree, "items", list, where)
    if not all(isinstance(p, list) and len(p) == 2 and isinstance(p[0], str | int) for p in pairs):
        raise Unreadable(f"{where} must hold pairs of a key and a value")
    return {key: rebuilt(x, arrays, f"{where}.{key}") for key, x in pairs}


def _float(tree, arrays, where):
    if tree["float"] not in ("inf", "-inf", "nan"):
        raise Unreadable(f"{where} = {tree['float']!r} must be inf, -inf or nan")
    return float(tree["float"])


def _known(tree, arrays, where):
    name = _part(tree, "known", str, where)
    if name not in KNOWN:
        raise Unreadable(f"{where} = {name[:80]!r} is not known: a newer release may have made it")
    return getattr(import_module(KNOWN[name]), name)


def _array(tree, arrays, where):
    name = _part(tree, "array", str, where)
    if name not in arrays:
        raise Unreadable(f"{where}: the array {name[:80]!r} is missing")
    return arrays[name]


def _small(tree, arrays, where):
    shape, values = _part(tree, "shape", list, where), _part(tree, "values", list, where)
    kind = _part(tree, "type", str, where)
    whole = all(isinstance(n, int) and 0 <= n for n in shape) and len(shape) <= 8
    plain = all(isinstance(x, int | float) or x in ("inf", "-inf", "nan") for x in values)
    if kind in ("<i8", "|u1"):
        plain = all(type(x) is int and abs(x) < 1 << 63 for x in values)
    if kind not in TYPES or not whole or not plain or len(values) > 2 * SMALL:
        raise Unreadable(f"{where} is no array of numbers")
    flat = np.array(list(map(float, values)) if kind[1] in "fc" else values)
    flat = flat.view("<c16") if kind == "<c16" and len(values) % 2 == 0 else flat.astype(kind)
    if flat.size != np.prod(shape, dtype=float):
        raise Unreadable(f"{where} has {flat.size} numbers and the shape {tuple(shape)}")
    return flat.reshape(shape)


def _made(tree, arrays, where):
    """Return an instance of a known class; what was added to it since has its default."""
    name, parts = _part(tree, "class", str, where), _part(tree, "fields", dict, where)
    if name not in CLASSES:
        raise Unreadable(f"{where} is a {name[:80]!r}, which is not known: a newer release may "
                         "have made it")  # fmt: skip
    hints, kind = _hints(name)
    inside = f"{where}.{name}"
    strange = [key for key in parts if key not in hints]
    if strange:
        raise Unreadable(f"{inside} has the part {strange[0][:80]!r}, which is not known")
    values = {key: rebuilt(x, arrays, f"{inside}.{key}") for key, x in parts.items()}
    for f in fields(kind):
        optional = f.default is not MISSING or f.default_factory is not MISSING
        if f.name not in values and not optional:
            raise Unreadable(f"{inside}.{f.name} is missing")
        if f.name in values and not _is_a(values[f.name], hints[f.name], f.default is None):
            found = type(values[f.name]).__name__
            raise Unreadable(f"{inside}.{f.name} is a {found}, must be {hints[f.name]}")
    return kind(**values)


_READERS: dict[str, Callable] = {
    "list": _list, "items": _items, "float": _float, "known": _known, "array": _array,
    "values": _small, "class": _made,
}  # fmt: skip


def _part(tree, key, kind, where):
    if not isinstance(tree.get(key), kind):
        raise Unreadable(f"{where}.{key} must be a {kind.__name__}")
    return tree[key]


@cache
def _hints(name):
    """Return what the fields of a known class hold, and the class."""
    kind = getattr(import_module(CLASSES[name]), name)
    named = {key: getattr(import_module(home), key) for key, home in CLASSES.items()}
    hints = get_type_hints(kind, localns=named)
    return {f.name: hints[f.name] for f in fields(kind)}, kind


def _is_a(value, hint, or_none=False) -> bool:
    """Whether a value is of the kind that an annotation names."""
    if hint in (Any, object) or (or_none and value is None):
        return True
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        return any(_is_a(value, part) for part in parts)
    if origin is tuple and isinstance(value, tuple):
        if parts[1:] == (...,):
            return all(_is_a(x, parts[0]) for x in value)
        return len(value) == len(parts) and all(map(_is_a, value, parts))
    if origin is dict and isinstance(value, dict):
        return all(_is_a(k, parts[0]) and _is_a(x, parts[1]) for k, x in value.items())
    if origin is list and isinstance(value, list):
        return all(_is_a(x, parts[0]) for x in value)
    if origin is not None:
        return origin is Callable and callable(value)
    if isinstance(value, bool):
        return hint is bool
    return isinstance(value, (float, int) if hint is float else hint)
