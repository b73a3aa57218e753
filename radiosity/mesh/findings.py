"""Findings: what is odd about a mesh, how often, where, and what it means for light."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.contact import Contacts
from radiosity.mesh.crossing import crossing_faces
from radiosity.mesh.faces import Faces
from radiosity.mesh.gaps import near_vertices, t_junctions
from radiosity.mesh.seams import BRANCHED, find_seams
from radiosity.mesh.winding import find_shells, inside_out

MEANS = {
    "degenerate": "faces without area: left out",
    "duplicate": "faces that repeat another one: left out",
    "overlapping": "faces lie in the plane of others and look the same way: the first one is taken",
    "crossing": "pairs of faces cut through each other: their patches are cut along the line",
    "near": "pairs of vertices nearly meet: light through such a gap is negligible, but edges "
    "there are not rounded and the body counts as open; weld them",
    "T-junction": "vertices lie within the edge of a neighbour: no light passes, but the body "
    "counts as open",
    "branched": "edges join faces of which no two are a pair: what is inside cannot be told",
    "winding": "faces lie the other way round than their neighbours: that matters where they emit, "
    "are clear or have a black back",
    "inside out": "closed bodies look inward with nothing in them: what they emit stays inside",
}
SHOWN = 3  # places named of each kind


@dataclass(frozen=True)
class Finding:
    """One kind of oddity.

    Attributes
    ----------
    kind : str
        A key of `MEANS`.
    count : int
        How many there are, of what `MEANS` says.
    faces : tuple of int
        The first faces that have it, at most `SHOWN`; none where they were left out.
    points : tuple of (x, y, z)
        A place for each, in scene units.
    """

    kind: str
    count: int
    faces: tuple[int, ...] = ()
    points: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True)
class Findings:
    """All that was found, and how many closed and open pieces the mesh has.

    Attributes
    ----------
    found : tuple of Finding
    outward, inward : int
        Closed pieces whose fronts look out, such as furniture, and in, such as rooms.
    open : int
        Pieces with an edge that no other face has, or a branched one.
    """

    found: tuple[Finding, ...]
    outward: int
    inward: int
    open: int


def find_flaws(faces: Faces, emits: np.ndarray, contacts: Contacts) -> Findings:
    """Return what is odd about a mesh. Work grows as n log n with the faces.

    Parameters
    ----------
    faces : Faces
    emits : (f,) bool
        Lamps that lie in the plane of another face win there, which is no flaw.
    contacts : Contacts
        Of the same faces.

    Examples
    --------
    >>> from radiosity.mesh.contact import find_contacts
    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    >>> two = np.array([corners, corners[:, [2, 1, 0]] + [0.5, 0, -0.5]])  # one stands across
    >>> dark, faces = np.zeros(2, bool), Faces.from_polygons(two, 0, 0)
    >>> found = find_flaws(faces, dark, find_contacts(faces, dark))
    >>> [(f.kind, f.count, f.faces) for f in found.found], found.open
    ([('crossing', 1, (0,))], 2)
    """
    seams = find_seams(faces)
    shells = find_shells(faces, seams)
    pairs, points = crossing_faces(faces)
    overlapping, winding = _overlapping(faces, emits, contacts), np.flatnonzero(shells.odd)
    side = np.flatnonzero(seams.kinds()[seams.edge] == BRANCHED)
    branched = side[np.unique(seams.edge[side], return_index=True)[1]]
    middle = sum(_corners(faces, seams, n, branched) for n in (seams.start, seams.end)) / 2.0
    flipped = _first_faces(shells, np.flatnonzero(inside_out(faces, shells)))
    found = [
        Finding("degenerate", faces.degenerate),
        Finding("duplicate", faces.duplicates),
        _placed("overlapping", overlapping, _middles(faces, overlapping)),
        _placed("crossing", pairs[:, 0], points),
        _placed("near", *near_vertices(faces, seams)),
        _placed("T-junction", *t_junctions(faces, seams)),
        _placed("branched", seams.face[branched], middle),
        _placed("winding", winding, _middles(faces, winding)),
        _placed("inside out", flipped, _middles(faces, flipped)),
    ]
    closed = shells.closed & shells.orientable
    inward = int(np.count_nonzero(closed & (shells.volume < 0)))
    outward = int(np.count_nonzero(closed)) - inward
    return Findings(
        tuple(f for f in found if f.count), outward, inward, int(np.count_nonzero(~closed))
    )


def _overlapping(faces, emits, contacts):
    """Return the faces of which others in their plane, that look the same way, cover a part."""
    normals, found = faces.normals(), []
    for f, contact in contacts.faces.items():
        others = [g for g, _ in contact.covers if emits[f] == emits[g]]
        if any(normals[f] @ normals[g] > 0 for g in others):
            found.append(f)
    return np.array(sorted(found), int)


def _corners(faces, seams, number, sides):
    """Return the places (k, 3) of the corners with a number, at sides of faces."""
    face = seams.face[sides]
    return faces.vertices[face, np.argmax(seams.corner[face] == number[sides, None], axis=1)]


def _first_faces(shells, pieces):
    return np.array([np.argmax(shells.of_face == s) for s in pieces], int)


def _middles(faces, which):
    return faces.vertices[which[:SHOWN]].mean(axis=1)


def _placed(kind, faces, points):
    """Return a finding with its first places."""
    places = tuple(tuple(float(x) for x in p) for p in points[:SHOWN])
    return Finding(kind, len(faces), tuple(int(f) for f in faces[:SHOWN]), places)
