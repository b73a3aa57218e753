"""Repair: bodies whose fronts matter are turned the right way round, where that is beyond doubt.

Fronts matter where they emit, bound a clear body or have a black back. Nothing else is touched:
rays meet gaps and T-junctions as they are, and contact settles what overlaps.
"""

import numpy as np

from radiosity.mesh.faces import Faces
from radiosity.scene.model import Material, SceneError

SURE = 2 / 3  # share of a body's area that must agree for the rest to be turned


def repaired(
    faces: Faces, materials: tuple[Material, ...], fixed: np.ndarray, source: str
) -> tuple[Faces, list[str]]:
    """Return the faces, some of them turned round, and a note of each kind of repair.

    Closed bodies of which at least two thirds by area look one way have the rest turned, if it
    holds a face whose front matters. Closed clear bodies (``transmit`` with an index) look out,
    unless another clear body is about them: a bubble.

    Parameters
    ----------
    faces : Faces
    materials : tuple of Material
    fixed : (f,) bool
        Faces that stay as they are.
    source : str
        The file, for messages.

    Raises
    ------
    SceneError
        A closed clear body that has no inside, as its faces cannot be made to agree.
    """
    clear, shows = _fronts(materials, faces.material)
    if not (clear | shows).any():
        return faces, []
    from radiosity.mesh.seams import find_seams
    from radiosity.mesh.winding import find_shells, turned

    which, notes, problems = np.zeros(len(faces), bool), [], []
    if shows.any():
        shells = find_shells(faces, find_seams(faces))
        which, notes = _agreeing(shells, shows, fixed)
        notes += _inward_notes(faces, shells, fixed, materials)
    if clear.any():
        place, body = np.flatnonzero(clear), _subset(faces, clear)
        seams = find_seams(body)
        shells = find_shells(body, seams)
        which[place], more = _looking_out(body, shells, fixed[place])
        notes += more + _unclosed(body, seams, shells, materials)
        problems = [
            f"clear body {_where(body, first, materials)}: its faces cannot be turned so that "
            "neighbours agree, so it has no inside: mend it, or leave out ior (a thin pane)"
            for first in _firsts(shells, shells.closed & ~shells.orientable)
        ]
    if problems:
        raise SceneError(source, problems)
    return turned(faces, which) if which.any() else faces, notes


def _fronts(materials, material):
    """Return which faces (f,) bound clear bodies, and which others have a front that matters."""
    clear = np.array([getattr(m.transmit, "index", None) is not None for m in materials], bool)
    shows = np.array([m.emits or not m.two_sided for m in materials], bool)
    return clear[material], shows[material]


def _subset(faces, which):
    return Faces(faces.vertices[which], faces.material[which], faces.group[which])


def _agreeing(shells, matters, fixed):
    """Return which faces to turn so that those of a body agree, and notes."""
    held, wrong, kept = (_any_of(shells, x) for x in (matters, shells.odd, fixed))
    mixed = shells.closed & held & wrong & ~kept
    sure = mixed & (shells.share >= SURE)
    which, notes = shells.odd & sure[shells.of_face], []
    if sure.any():
        notes.append(
            f"{which.sum()} faces of {sure.sum()} closed bodies looked the other way than the "
            f"rest and were turned, face {np.flatnonzero(which)[0]} for one; repair = false "
            "keeps them"
        )
    if (mixed & ~sure).any():
        first = np.argmax((mixed & ~sure)[shells.of_face])
        notes.append(
            f"{(mixed & ~sure).sum()} closed bodies look in and out about as much, one with face "
            f"{first}: which way they should cannot be told, and only fronts emit"
        )
    return which, notes


def _any_of(shells, which):
    """Return (s,) bool: pieces with a face of some (f,)."""
    return np.bincount(shells.of_face, which, len(shells.closed)) > 0


def _looking_out(body, shells, fixed):
    """Return which faces of clear bodies to turn so that all look out, and a note."""
    low, high = shells.boxes(body)
    whole = shells.closed & shells.orientable & ~_any_of(shells, fixed)
    inward = whole & (shells.volume < 0)
    for s in np.flatnonzero(inward):
        about = np.all((low <= low[s]) & (high >= high[s]), axis=1) & shells.closed
        inward[s] = about.sum() == 1  # itself
    which = (shells.odd & whole[shells.of_face]) != inward[shells.of_face]
    if not which.any():
        return which, []
    return which, [
        f"{which.sum()} faces of {len(np.unique(shells.of_face[which]))} clear bodies looked in "
        "and were turned, as their fronts are the outside; repair = false keeps them"
    ]


def _unclosed(body, seams, shells, materials):
    """Return the note that clear bodies are open, where nothing closes them."""
    from radiosity.mesh.seams import CLOSED

    side = np.flatnonzero(seams.kinds()[seams.edge] != CLOSED)
    if not len(side):
        return []
    count = int(np.count_nonzero(~shells.closed))
    return [
        f"{count} clear bodies are open or branched, one "
        f"{_where(body, seams.face[side[0]], materials)}: light that enters there leaves only "
        "where it meets a back; close the body, or leave out ior for a thin pane"
    ]


def _firsts(shells, which):
    return [int(np.argmax(shells.of_face == s)) for s in np.flatnonzero(which)]


def _where(body, face, materials):
    point = ", ".join(f"{x:g}" for x in body.vertices[face].mean(axis=0))
    return f"of {materials[body.material[face]].name} at [{point}]"


def _inward_notes(faces, shells, fixed, materials):
    """Return the note that lamps turned inside out keep their light, which may be meant."""
    from radiosity.mesh.winding import inside_out

    emits = np.array([m.emits for m in materials], bool)[faces.material]
    bodies = inside_out(faces, shells) & (shells.share >= SURE)
    lamp = bodies & _any_of(shells, emits) & ~_any_of(shells, fixed)
    if not lamp.any():
        return []
    first = int(np.argmax(lamp[shells.of_face] & emits))
    return [
        f"{lamp.sum()} closed bodies emit inwards, one {_where(faces, first, materials)}: only "
        "fronts emit; if their light is to come out, turn their faces round"
    ]
