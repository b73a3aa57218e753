"""STL: triangles, binary and text (3D Systems, StereoLithography Interface Specification 1989).

The normals of the file are not read: the order of the corners tells the front.
"""

import re

import numpy as np

from radiosity.mesh.faces import Faces, has_area
from radiosity.mesh.given import Given
from radiosity.scene.geometry import DEFAULT, Geometry
from radiosity.scene.meshes.polygons import vertex_problems
from radiosity.scene.model import SceneError

HEAD, RECORD = 84, 50  # bytes before the triangles of a binary file, and of each
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
SOLID = re.compile(rb"^[ \t]*(end)?solid\b[ \t]*([^\r\n]*)", re.MULTILINE | re.IGNORECASE)
VERTEX = re.compile(rb"\bvertex\s+(\S{1,64})\s+(\S{1,64})\s+(\S{1,64})(?!\S)", re.IGNORECASE)


def read_stl(data: bytes, source: str, name: str, merge: bool = True) -> Geometry:
    """Return the geometry of an STL file: one material, one group a solid.

    Parameters
    ----------
    data : bytes
        The file's content; text if it begins with "solid" and is not as long as a binary file
        with its count of triangles.
    source, name : str
        The file, for messages, and the group's name where a solid has none.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.

    Raises
    ------
    SceneError
        No STL file, of another length than its count says, vertices that are not finite, no faces.
    """
    count = int.from_bytes(data[80:HEAD], "little") if len(data) >= HEAD else -1
    long = HEAD + RECORD * count
    is_text = data[:5].lower() == b"solid" and len(data) != long
    if is_text and SOLID.match(data) and (b"facet" in data[:4096].lower() or b"endsolid" in data):
        triangles, group, groups, notes = _text(data, source, name)
    elif count < 0 or long > len(data):
        raise SceneError(source, [_length_problem(data, count)])
    else:
        triangles, notes = _binary(data, count)
        group, groups = 0, (name,)
    if not len(triangles):
        raise SceneError(source, ["has no faces: nothing can be lit"])
    problems = vertex_problems(triangles.reshape(-1, 3))
    if problems:
        raise SceneError(source, problems)
    faces = Faces.from_triangles(triangles, 0, group, merge)
    owner = np.flatnonzero(has_area(triangles[:, [0, 1, 2, 2]]))
    given = None if merge else Given(faces, owner, len(triangles))
    return Geometry(faces, (DEFAULT,), groups, notes=tuple(notes), given=given)


def _length_problem(data, count):
    """Return why a file can be neither text nor binary."""
    if count < 0:
        return (
            f"is not an STL file that can be read: it has no faces in its {len(data)} bytes; a "
            f'text file begins with "solid", a binary one has {HEAD} bytes before its triangles'
        )
    return (
        f"says that it has {count} triangles, which take {HEAD + RECORD * count} bytes, and has "
        f'{len(data)}: it was cut off, or it is text that does not begin with "solid"'
    )


def _binary(data, count):
    """Return the triangles (t, 3, 3) of a binary file and notes."""
    read = np.frombuffer(data, TRIANGLE, count, HEAD)
    notes, rest = [], len(data) - HEAD - RECORD * count
    coloured = np.count_nonzero(read["attribute"])
    if coloured:
        notes.append(f"not read: the attributes (colours) of {coloured} triangles")
    if rest:
        notes.append(f"{rest} bytes after the last triangle were left out")
    return read["corners"].astype(float), notes


def _text(data, source, name):
    """Return the triangles (t, 3, 3) of a text file, the group of each, the names and notes."""
    opened = [m for m in SOLID.finditer(data) if not m[1]]
    starts, names = np.array([m.start() for m in opened]), {}
    number = [names.setdefault(_solid_name(m[2], name), len(names)) for m in opened]
    found = list(VERTEX.finditer(data))
    facets = len(re.findall(rb"\bendfacet\b", data, re.IGNORECASE))
    problems = []
    if len(found) != 3 * facets:
        problems.append(
            f"has {len(found)} vertices in {facets} facets, each must have 3 and an endfacet: it "
            "was cut off, or a line is wrong"
        )
    try:
        corners = np.array([m.groups() for m in found], dtype=bytes).astype(float)
    except ValueError:
        problems += _no_number(data, found)
    if problems:
        raise SceneError(source, problems)
    first = np.array([m.start() for m in found[::3]], int)
    group = np.array(number)[np.searchsorted(starts, first, "right") - 1]
    return corners.reshape(-1, 3, 3), group, tuple(names), []


def _solid_name(words, name):
    return words.decode("utf-8", "replace").strip()[:80] or name


def _no_number(data, found):
    """Return where a vertex is not three numbers."""
    for m in found:
        try:
            [float(word) for word in m.groups()]
        except ValueError:
            line, text = data.count(b"\n", 0, m.start()) + 1, m[0].decode("latin-1")[:60]
            return [f"line {line}: {text}: a vertex is three numbers x y z"]
    return []
