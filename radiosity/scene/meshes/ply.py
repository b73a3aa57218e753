"""PLY: polygon files, text and binary (G. Turk, The PLY Polygon File Format, Stanford 1994).

Read are the vertices' ``x``, ``y``, ``z``, their normals and texture coordinates, and the faces'
corners, as many as they have. Other properties and elements are named in a note.
"""

import re
import warnings
from dataclasses import replace

import numpy as np

from radiosity.mesh.outlines import split_outlines
from radiosity.scene.geometry import DEFAULT, Geometry
from radiosity.scene.meshes.ply_rows import Binary, Broken, Element, Property, Text, columns_of
from radiosity.scene.meshes.polygons import faces_of, flat_notes, vertex_problems
from radiosity.scene.model import SceneError

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
LONGEST_HEADER = 1 << 16  # bytes; headers name a few dozen properties
MOST = 64  # elements, and properties of one
PLACE = ("x", "y", "z")
NORMAL = ("nx", "ny", "nz")
COORDINATES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
SCALARS = {*PLACE, *NORMAL, *sum(COORDINATES, ())}
INDICES = ("vertex_indices", "vertex_index")
LISTS = {*INDICES, "texcoord"}
COLOURS = ("red", "green", "blue", "alpha")


def read_ply(data: bytes, source: str, name: str, merge: bool = True, uv: bool = False) -> Geometry:
    """Return the geometry of a PLY file: one material and one group.

    Parameters
    ----------
    data : bytes
        The file's content.
    source, name : str
        The file, for messages, and the group's name.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    uv : bool
        Read texture coordinates, of vertices (s, t) or of faces' corners (``texcoord``).

    Raises
    ------
    SceneError
        No PLY file, shorter than its header says, vertices that do not exist or are not finite,
        no faces, triangle strips, polygons that cross themselves.
    """
    try:
        elements, start, order, notes = _header(data)
        _check_elements(elements)
        body = _body(data, start, order, elements)
        columns = columns_of(elements, body)
        return _geometry(columns, elements, name, merge, uv, notes)
    except Broken as error:
        raise SceneError(source, [f"is not a PLY file that can be read: it {error}"]) from None
    except _Wrong as error:
        raise SceneError(source, error.problems) from None


class _Wrong(ValueError):
    """What is wrong with the mesh, as full sentences."""

    def __init__(self, problems):
        super().__init__(problems)
        self.problems = problems


def _header(data):
    """Return the elements, where the body starts, the order of bytes ("" of text) and notes."""
    first = re.match(rb"ply[ \t]*(\r\n|\r|\n)", data)
    if first is None:
        raise Broken(f'begins with {data[:8]!r}, must begin with a line "ply"')
    line = rb"\r" if first[1] == b"\r" else rb"\r?\n"  # bytes after a bare \r may look like \n
    last = re.search(line + rb"end_header[ \t]*" + line, data[:LONGEST_HEADER])
    if last is None:
        raise Broken(f"has no line end_header in its first {LONGEST_HEADER} bytes")
    elements, order, notes = [], None, []
    lines = re.split(r"\r\n|\r|\n", data[: last.start()].decode("latin-1"))[1:]
    for number, line in enumerate(lines, 2):
        words = line.split()
        kind = words[0] if words else "comment"
        where = f"line {number}: {line.strip()[:60]}"
        if kind == "format":
            order = ORDERS.get(words[1] if len(words) > 1 else "")
            if order is None:
                raise Broken(f"says in {where}: must be one of {', '.join(ORDERS)}")
        elif kind == "element":
            elements.append([*_element(words, where), []])
        elif kind == "property":
            if not elements:
                raise Broken(f"says in {where}, before the first element")
            elements[-1][2].append(_property(words, where))
        elif kind == "comment" and words[1:2] == ["TextureFile"]:
            notes.append(f"{where}: not read; a material's texture names a picture")
        elif kind not in ("comment", "obj_info"):
            notes.append(f"{where}: not read; it is no format, element, property or comment")
    if order is None:
        raise Broken("has no line format: ascii or binary")
    made = [Element(n, count, tuple(listed)) for n, count, listed in elements]
    return made, last.end(), order, notes


def _element(words, where):
    count = words[2] if len(words) == 3 else ""
    if not (count.isascii() and count.isdecimal() and len(count) < 16):
        raise Broken(f"says in {where}: must be a name and how many there are")
    return words[1], int(count)


def _property(words, where):
    kinds, name = words[1:-1], words[-1]
    is_list = kinds[:1] == ["list"]
    types = [TYPES.get(k) for k in kinds[is_list:]]
    if len(types) != 1 + is_list or None in types:
        raise Broken(
            f"says in {where}: must be a type and a name, or list, two types and a name; "
            f"types are {', '.join(TYPES)}"
        )
    if is_list and types[0][0] == "f":
        raise Broken(f"says in {where}: lists are counted in whole numbers")
    return Property(name, types[-1], types[0] if is_list else None)


def _check_elements(elements):
    """Raise where the header lists no mesh of polygons, or what cannot be told apart."""
    names = [e.name for e in elements]
    if len(names) > MOST or any(len(e.properties) > MOST for e in elements):
        raise Broken(f"lists more than {MOST} elements, or properties of one")
    for listed in (names, *([p.name for p in e.properties] for e in elements)):
        twice = next((n for n in listed if listed.count(n) > 1), None)
        if twice is not None:
            raise Broken(f'lists "{twice}" twice: which one is meant cannot be told')
    if "tristrips" in names:
        raise _Wrong([
            "holds triangle strips (element tristrips), which are not read: save it with faces "
            "(element face)"
        ])  # fmt: skip
    counts = {e.name: e.count for e in elements}
    if not counts.get("face"):
        raise _Wrong(["has no faces: nothing can be lit"])
    if not counts.get("vertex"):
        raise _Wrong([f"has {counts['face']} faces and no vertices"])
    vertex = next(e for e in elements if e.name == "vertex")
    scalars = [p.name for p in vertex.properties if p.counted is None]
    if not set(PLACE) <= set(scalars):
        raise Broken(f"has vertices with {', '.join(scalars) or 'nothing'}: x, y and z are needed")
    listed = [p.name for p in vertex.properties if p.counted and p.name in SCALARS]
    if listed:
        raise Broken(f"lists {', '.join(listed)} of vertices, where each must be one number")
    face = next(e for e in elements if e.name == "face")
    single = [p.name for p in face.properties if not p.counted and p.name in LISTS]
    if single:
        raise Broken(f"has one number {', '.join(single)} of faces, where a list must stand")
    if not any(p.counted and p.name in INDICES for p in face.properties):
        found = ", ".join(p.name for p in face.properties) or "nothing"
        raise Broken(f"has faces with {found}: a list {' or '.join(INDICES)} is needed")


def _body(data, start, order, elements):
    """Return what follows the header, once it is known to be long enough for the counts."""
    long = len(data) - start
    for e in elements:
        kinds = [p.counted or p.type for p in e.properties]
        least = sum(int(k[1]) for k in kinds) if order else 2 * len(kinds)  # a digit and a space
        if e.count * least > long + (not order):  # the last word may end with the file
            raise Broken(
                f"says that it has {e.count} {e.name}, which take at least {e.count * least} "
                f"bytes, and {long} follow the header: it was cut off"
            )
    if order:
        return Binary(memoryview(data)[start:], order)
    text = data[start:].decode("latin-1")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return Text(np.fromstring(text, float, sep=" "))
        except (ValueError, DeprecationWarning):
            raise Broken(_no_number(text, data[:start].count(b"\n") + 1)) from None


def _no_number(text, line):
    """Return which word of a text is no number; ``line`` is the number of its first line."""
    for number, words in enumerate(text.split("\n"), line):
        for word in words.split():
            try:
                float(word)
            except ValueError:
                return f'says "{word[:40]}" in line {number}, where a number must stand'
    return "holds what is no list of numbers"


def _geometry(columns, elements, name, merge, uv, notes):
    """Return the geometry of the columns that were read."""
    vertex, face = columns["vertex"], columns["face"]
    points = np.stack([vertex[k] for k in PLACE], axis=1)
    listed = next(k for k in INDICES if k in face)
    index, size = face[listed]
    problems = vertex_problems(points) + _index_problems(index, size, len(points))
    if problems:
        raise _Wrong(problems)
    corners = index.astype(np.int64)
    per_corner = face.get("texcoord") if uv else None
    details = _coordinates(vertex, per_corner, corners, size) if uv else None, None
    if set(NORMAL) <= vertex.keys():
        details = details[0], _finite(np.stack([vertex[k] for k in NORMAL], axis=1))[corners]
    short = size < 3
    if short.any():
        kept = np.repeat(~short, size)
        notes.append(f"{short.sum()} faces of fewer than 3 corners were left out")
        corners, details = corners[kept], [None if x is None else x[kept] for x in details]
    found = split_outlines(points, corners, size[~short])
    found = replace(found, origin=np.flatnonzero(~short)[found.origin])
    if found.problems:
        number = np.flatnonzero(~short)
        raise _Wrong([f"face {number[f]} {text}" for f, text in found.problems[:MOST]])
    polygons, zeros = points[corners[found.place]], np.zeros(len(size), int)
    faces, given = faces_of(polygons, found, len(size), zeros, zeros, merge, *details)
    notes += flat_notes(found) + _left_out(elements)
    return Geometry(faces, (DEFAULT,), (name,), notes=tuple(notes), given=given)


def _index_problems(index, size, count):
    """Return what is wrong with the first face that names vertices that do not exist."""
    wrong = np.flatnonzero(~((index >= 0) & (index < count) & (index == np.floor(index))))
    if not len(wrong):
        return []
    f = int(np.searchsorted(np.cumsum(size), wrong[0], "right"))
    mine = index[np.sum(size[:f]) :][: size[f]]
    shown = ", ".join(f"{k:g}" for k in mine[:8])
    return [
        f"face {f} = [{shown}] names a vertex that does not exist: there are {count}, counted "
        "from 0"
    ]


def _finite(values):
    return np.where(np.isfinite(values).all(axis=1, keepdims=True), values, np.nan)


def _coordinates(vertex, per_corner, corners, size):
    """Return the texture coordinates (c, 2) of corners, of the faces or of their vertices."""
    if per_corner is not None and np.array_equal(per_corner[1], 2 * size):
        return _finite(per_corner[0].reshape(-1, 2))
    for names in COORDINATES:
        if set(names) <= vertex.keys():
            return _finite(np.stack([vertex[k] for k in names], axis=1))[corners]
    return None


def _left_out(elements):
    """Return a note of the properties and elements that are not modelled."""
    known = {"vertex": SCALARS, "face": {*INDICES, "texcoord"}}
    named = []
    for e in elements:
        if e.name not in known:
            named.append(f"{e.count} {e.name}")
            continue
        rest = [p.name for p in e.properties if p.name not in known[e.name]]
        colours = [n for n in rest if n.removeprefix("diffuse_") in COLOURS]
        named += ["colours of " + e.name] * bool(colours)
        named += [f"{n} of {e.name}" for n in rest if n not in colours]
    return [f"not read: {', '.join(named)}"] if named else []
