"""OBJ: Wavefront geometry and its MTL material libraries.

Read are ``v``, ``vn``, ``f``, ``g``, ``o``, ``usemtl`` and ``mtllib``, and ``vt`` where the scene
or the libraries have textures; what libraries say is in `radiosity.scene.wavefront.mtl`. Lines,
points and free-form surfaces are counted; everything else is ignored.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from radiosity.mesh.outlines import split_outlines
from radiosity.scene.geometry import DEFAULT, LONGEST, Geometry
from radiosity.scene.meshes.polygons import faces_of, flat_notes
from radiosity.scene.model import SceneError
from radiosity.scene.wavefront.libraries import read_libraries, with_materials
from radiosity.scene.wavefront.mtl import finite

WHOLE = re.compile(r"[+-]?\d{1,18}")
WITH_NORMALS = re.compile(r"(?:[+-]?\d{1,18}/(?:[+-]?\d{1,18})?/[+-]?\d{1,18} )+", re.ASCII)
WITHOUT = re.compile(r"(?:[+-]?\d{1,18}/[+-]?\d{1,18} )+", re.ASCII)
NOT_READ = "l", "p", "curv", "curv2", "surf"  # what is drawn but no face
MOST = 50  # problems listed of one file; the rest is counted


@dataclass
class _Statements:
    """What the lines of a file say, before anything is converted; one entry a statement."""

    vertex: list = field(default_factory=list)
    vertex_line: list = field(default_factory=list)
    coloured: int = 0
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
    skipped: dict = field(default_factory=dict)


def read_obj(
    text: str, source: str, read_library: Callable[[str], str | None], merge: bool = True,
    uv: bool = False, read_picture: Callable[[str], np.ndarray] | None = None, called: str = "",
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
        Read texture coordinates; they are read anyway where a library names textures.
    read_picture : callable, optional
        Returns the pixels of a picture given its place beside the OBJ file; raises SceneError.
    called : str
        The file's name within the scene's folder, beside which names of pictures are.

    Raises
    ------
    SceneError
        Lists all lines that are wrong: no numbers, no finite numbers, vertices that do not
        exist, no faces at all; and what is wrong in the libraries.
    """
    said = _statements(text, uv)
    libraries = read_libraries(said.libraries, read_library)
    if not uv and libraries.textured(said.material_names):
        again = _statements(text, True)
        said.uv, said.uv_line, said.before = again.uv, again.uv_line, again.before
    points = _points(said)
    corners = _corners(said, len(points))
    details = [_detail(said, *kind) for kind in DETAILS]
    said.problems += libraries.problems
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
    more = [f"{n} lines {word} are not read" for word, n in said.skipped.items()]
    more += [f"colours of {said.coloured} vertices are not read"] if said.coloured else []
    notes = *libraries.notes, *flat_notes(found), *more
    geometry = Geometry(faces, *names, notes=notes, given=given)
    return with_materials(geometry, libraries, read_picture or _no_picture, called)


def _no_picture(name):
    """Refuse a picture."""
    raise SceneError(name, ["is not read here"])


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
            said.coloured += len(words) > 6 and len(line.partition("#")[0].split()) > 6
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
        elif word in NOT_READ:
            said.skipped[word] = said.skipped.get(word, 0) + 1
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
        numbers = finite(words, count)
        if numbers is None or max(map(abs, numbers)) > LONGEST:
            said.problems.append(f"line {number}: {text.format(' '.join(words))}")
    return np.zeros((len(rows), count))


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




def _shortened(problems):
    more = len(problems) - MOST
    return problems[:MOST] + ([f"and {more} more problems like these"] if more > 0 else [])
