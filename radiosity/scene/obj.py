"""OBJ: Wavefront geometry and its MTL material libraries.

Read are ``v``, ``vn``, ``f``, ``g``, ``o``, ``usemtl`` and ``mtllib``, and ``vt`` where the scene
has textures; in a library ``newmtl``, ``Kd`` (diffuse reflectance) and ``Ke`` (emitted radiance).
Everything else is ignored.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from radiosity.mesh.outlines import split_outlines
from radiosity.scene.geometry import DEFAULT, LONGEST, Geometry
from radiosity.scene.model import ReadAs, SceneError
from radiosity.scene.polygons import faces_of, flat_notes

WHOLE = re.compile(r"[+-]?\d{1,18}")
WITH_NORMALS = re.compile(r"(?:[+-]?\d{1,18}/(?:[+-]?\d{1,18})?/[+-]?\d{1,18} )+", re.ASCII)
WITHOUT = re.compile(r"(?:[+-]?\d{1,18}/[+-]?\d{1,18} )+", re.ASCII)
MOST = 50  # problems listed of one file; the rest is counted


@dataclass
class _Statements:
    """What the lines of a file say, before anything is converted; one entry a statement."""

    vertex: list = field(default_factory=list)
    vertex_line: list = field(default_factory=list)
    uv: list = field(default_factory=list)
    uv_line: list = field(default_factory=list)
    normal: list = field(default_factory=list)
    normal_line: list = field(default_factory=list)
    corner: list = field(default_factory=list)
    face_size: list = field(default_factory=list)
    face_line: list = field(default_factory=list)
    before: list = field(default_factory=list)
    material: list = field(default_factory=list)
    group: list = field(default_factory=list)
    material_names: dict = field(default_factory=dict)
    group_names: dict = field(default_factory=dict)
    libraries: list = field(default_factory=list)
    problems: list = field(default_factory=list)


def read_obj(
    text: str, source: str, read_library: Callable[[str], str | None], merge: bool = True,
    uv: bool = False,
) -> Geometry:  # fmt: skip
    """Return the geometry of an OBJ file.

    Parameters
    ----------
    text : str
        The file's content.
    source : str
        Its name, for messages.
    read_library : callable
        Returns the text of an MTL file given its name in the OBJ file, None if there is none.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    uv : bool
        Read texture coordinates.

    Raises
    ------
    SceneError
        Lists all lines that are wrong: no numbers, no finite numbers, vertices that do not
        exist, no faces at all; and what is wrong in the libraries.
    """
    said = _statements(text, uv)
    points = _points(said)
    corners = _corners(said, len(points))
    details = [_detail(said, *kind) for kind in DETAILS]
    materials, notes = _libraries(said, read_library)
    if not said.problems and not said.face_size:
        said.problems.append("has no faces: an OBJ file lists them as lines such as f 1 2 3")
    if said.problems:
        raise SceneError(source, _shortened(said.problems))
    found = split_outlines(points, corners, np.array(said.face_size, int))
    said.problems += [f"line {said.face_line[f]}: the face {text}" for f, text in found.problems]
    if said.problems:
        raise SceneError(source, _shortened(said.problems))
    faces, given = faces_of(
        points[corners[found.place]], found, len(said.face_size), np.array(said.material, int),
        np.array(said.group, int), merge, *details,
    )  # fmt: skip
    names = tuple(said.material_names), tuple(said.group_names)
    return Geometry(faces, *names, materials, tuple(notes + flat_notes(found)), given)


def _statements(text, uv):
    """Sort the words of all lines by what they say."""
    said = _Statements()
    material = group = DEFAULT
    for number, line in _lines(text):
        words = line.split()
        if not words:
            continue
        word = words[0]
        if word == "v":
            said.vertex.append(words[1:4])
            said.vertex_line.append(number)
        elif word == "f":
            words = line.partition("#")[0].split() if "#" in line else words
            said.corner += words[1:]
            said.face_size.append(len(words) - 1)
            said.face_line.append(number)
            said.before.append((len(said.vertex), len(said.uv), len(said.normal)))
            said.material.append(_index(said.material_names, material))
            said.group.append(_index(said.group_names, group))
        elif word == "vn":
            said.normal.append(words[1:4])
            said.normal_line.append(number)
        elif word == "vt" and uv:
            said.uv.append(words[1:3])
            said.uv_line.append(number)
        elif word == "usemtl":
            material = _rest(line) or DEFAULT
        elif word in ("g", "o"):
            group = _rest(line) or DEFAULT
        elif word == "mtllib":
            said.libraries.append((number, _rest(line)))
    return said


def _lines(text):
    """Return (number, line) of all lines; a backslash at the end joins the next one."""
    lines = enumerate(text.split("\n"), 1)
    if "\\" not in text:
        return lines
    whole, start = [], None
    for number, line in lines:
        if start is None:
            start, kept = number, ""
        if line.endswith("\\"):
            kept += line[:-1] + " "
            continue
        whole.append((start, kept + line))
        start = None
    return whole


def _rest(line):
    parts = line.strip().split(None, 1)
    return parts[1] if len(parts) > 1 else ""


def _index(names, name):
    return names.setdefault(name, len(names))


def _points(said):
    """Return vertices (n, 3); wrong lines become problems."""
    what = f"a vertex is three finite numbers x y z, at most {LONGEST:g}"
    return _values(said, said.vertex, said.vertex_line, 3, f"v {{}}: {what}")


def _values(said, rows, lines, count, text):
    """Return the numbers (n, count) of some lines; wrong ones become problems with the text."""
    try:
        values = np.array(rows, float).reshape(-1, count)
        if len(values) == len(rows) and (np.abs(values) <= LONGEST).all():  # false for nan
            return values
    except ValueError:
        pass
    for number, words in zip(lines, rows, strict=True):
        numbers = _numbers(words, count)
        if numbers is None or max(map(abs, numbers)) > LONGEST:
            said.problems.append(f"line {number}: {text.format(' '.join(words))}")
    return np.zeros((len(rows), count))


def _numbers(words, count):
    """Return words as finite floats, None if there are not exactly ``count`` or they are not."""
    try:
        numbers = [float(w) for w in words]
    except ValueError:
        return None
    return numbers if len(numbers) == count and np.isfinite(numbers).all() else None


def _corners(said, n):
    """Return the vertex index of every corner, from 0; wrong lines become problems."""
    size = np.array(said.face_size, int)
    try:
        index = np.array([int(word.partition("/")[0]) for word in said.corner], np.int64)
        before = np.repeat(np.array(said.before, np.int64).reshape(-1, 3)[:, 0], size)
        resolved = np.where(index < 0, index + before, index - 1)
        if (size >= 3).all() and ((resolved >= 0) & (resolved < n) & (index != 0)).all():
            return resolved
    except (ValueError, OverflowError):
        pass
    start = 0
    for number, count, before in zip(said.face_line, said.face_size, said.before, strict=True):
        words = said.corner[start : start + count]
        said.problems += [f"line {number}: {p}" for p in _face_problems(words, before[0], n)]
        start += count
    return np.zeros(0, np.int64)


def _face_problems(words, before, n):
    if len(words) < 3:
        yield f"f {' '.join(words)}: a face needs at least 3 corners, found {len(words)}"
    for word in words:
        try:
            index = int(word.partition("/")[0])
        except ValueError:
            yield f"f ... {word}: a corner is v, v/vt, v//vn or v/vt/vn with whole numbers"
            continue
        if index == 0:
            yield "f ... 0: vertices are counted from 1, or back from -1"
        elif index > n:
            yield f"f ... {word}: vertex {index} does not exist, the file has {n}"
        elif index < -before:
            yield f"f ... {word}: vertex {index} does not exist, {before} were given so far"


# Where a corner v/vt/vn names them, how many numbers they are and what a wrong line is told.
DETAILS = (
    (1, "uv", 2, "vt {}: texture coordinates are two finite numbers u v"),
    (2, "normal", 3, "vn {}: a normal is three finite numbers x y z"),
)


def _detail(said, slot, name, count, text):
    """Return what every corner has of a kind (c, count), nan where nothing; None if none does."""
    rows = getattr(said, name)
    if not rows:
        return None
    values = _values(said, rows, getattr(said, f"{name}_line"), count, text)
    index = _named(said.corner, slot, len(rows) + 1)
    owner = np.repeat(np.arange(len(said.face_size)), said.face_size)
    before = np.array(said.before, int).reshape(-1, 3)[owner, slot]
    index = np.where(index < 0, np.where(-index > before, -1, index + before + 1), index)
    bad = np.flatnonzero((index > len(rows)) | (index < 0))
    said.problems += [
        f"line {said.face_line[owner[c]]}: f ... {said.corner[c]}: {text[:2]} "
        f"{said.corner[c].split('/')[slot]} does not exist, the file has {len(rows)}, "
        f"{before[c]} of them so far"
        for c in bad
    ]
    return None if len(bad) else np.concatenate([np.full((1, count), np.nan), values])[index]


def _named(corners, slot, wrong):
    """Return (c,) what corners v/vt/vn name in a slot: 0 for nothing, ``wrong`` if no number."""
    text = " ".join(corners) + " "
    for slots, form in ((3, WITH_NORMALS), (2, WITHOUT)):
        if slot < slots and form.fullmatch(text):
            numbers = text.replace("//", "/0/").replace("/", " ")
            return np.fromstring(numbers, np.int64, sep=" ").reshape(-1, slots)[:, slot]
    words = [w[slot] if len(w) > slot and w[slot] else "0" for w in (c.split("/") for c in corners)]
    return np.array([int(w) if WHOLE.fullmatch(w) else wrong for w in words], np.int64)


def _libraries(said, read_library):
    """Return the materials of all MTL files and notes; what is wrong becomes a problem."""
    materials, notes = {}, []
    for number, rest in said.libraries:
        text = _library_text(number, rest, read_library, said.problems)
        if text is None:
            notes.append(
                f"line {number}: the material library {rest} is not there: its materials come "
                "from the scene file or reflect 0.5"
            )
            continue
        for name, file_text in text.items():
            found, problems = read_mtl(file_text)
            materials = found | materials
            said.problems += [f"line {number}: {name}: {p}" for p in problems]
            if found:
                notes.append(
                    f"{name}: Kd is read as diffuse reflectance, Ke as emitted radiance "
                    "in W/(m2 sr), everything else is ignored"
                )
    return materials, notes


def _library_text(number, rest, read_library, problems):
    """Return {name: text} of the files a ``mtllib`` line names, None if one is missing."""
    for names in ([rest], rest.split()):
        try:
            texts = {name: read_library(name) for name in names}
        except SceneError as error:
            problems += [f"line {number}: mtllib {rest}: {p}" for p in error.problems]
            return {}
        if texts and None not in texts.values():
            return texts
    return None


def read_mtl(text: str) -> tuple[dict[str, ReadAs], list[str]]:
    """Return the materials of an MTL file by name, and its problems."""
    values, problems, name = {}, [], None
    for number, line in enumerate(text.split("\n"), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        if words[0] == "newmtl":
            name = _rest(line)
            values[name] = {"Kd": np.full(3, 0.5), "Ke": np.zeros(3)}
        elif words[0] in ("Kd", "Ke"):
            rgb = _numbers(words[1:] * (3 if len(words) == 2 else 1), 3)
            problem = _mtl_problem(words, rgb, name)
            if problem:
                problems.append(f"line {number}: {problem}")
            else:
                values[name][words[0]] = np.array(rgb)
    return {name: _read_as(value) for name, value in values.items()}, problems


def _read_as(value):
    """Return the table of a material whose statements are given."""
    table = {"diffuse": value["Kd"].tolist()}
    if value["Ke"].any():
        table["emission"] = {"radiance": value["Ke"].tolist()}
    said = (f"{key} {' '.join(f'{x:g}' for x in rgb)}" for key, rgb in value.items())
    return ReadAs(", ".join(said), table)


def _mtl_problem(words, rgb, name):
    said = " ".join(words)
    if name is None:
        return f"{said} comes before the first newmtl: name the material it belongs to"
    if rgb is None:
        return f"{said} must be one or three finite numbers (spectral and xyz forms are not read)"
    if min(rgb) < 0:
        return f"{said} must not be negative"
    if words[0] == "Kd" and max(rgb) > 1:
        return f"{said} must lie in [0, 1]: a surface cannot reflect more than it receives"
    return None


def _shortened(problems):
    more = len(problems) - MOST
    return problems[:MOST] + ([f"and {more} more problems like these"] if more > 0 else [])
