"""RAD: Radiance scene descriptions as geometry, with the files that they move into place.

No command is ever run: ``xform`` and ``genbox`` are followed here, others are named in a note.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import PurePosixPath

import numpy as np

from radiosity.mesh.curves import curved
from radiosity.mesh.faces import Faces, has_area
from radiosity.mesh.given import Given
from radiosity.mesh.triangulate import NoArea, convex_quads
from radiosity.scene.geometry import DEFAULT, LONGEST, Geometry
from radiosity.scene.model import SceneError
from radiosity.scene.radiance.library import Library
from radiosity.scene.radiance.moves import MoveError, Moves, read_moves
from radiosity.scene.radiance.shapes import TURNED, ShapeError, box, count_of, facets
from radiosity.scene.radiance.sky import Distant, lights_of
from radiosity.scene.radiance.text import Command, Primitive, RadError, parsed
from radiosity.scene.radiance.views import read_views

MOST_FACETS = 1_000_000
MOST_FILES = 2_000
MOST_SUNS = 10_000
DEEPEST = 16  # files within files
MOST = 50  # problems listed of one file; the rest is counted
NO_NORMALS = np.full((1, 4, 3), np.nan)
SMALL = {3: [0, 1, 2, 2], 4: [0, 1, 2, 3]}  # corners of small polygons as those of faces
LEFT_OUT = "instance", "mesh"


@dataclass(frozen=True)
class Piece:
    """A surface: facets (k, 4, 3), normals at their corners, its material and its group."""

    material: str
    group: str
    quads: np.ndarray
    normals: np.ndarray


@dataclass
class Parts:
    """What a file, or a command in it, adds to a scene."""

    pieces: list[Piece] = field(default_factory=list)
    distant: list[Distant] = field(default_factory=list)

    def add(self, more: "Parts") -> None:
        """Append what another file adds."""
        self.pieces += more.pieces
        self.distant += more.distant


class _Reader:
    """Reads a file and those that it names; what is wrong or left out is collected."""

    def __init__(self, read_file):
        self.read_file, self.library = read_file, Library()
        self.problems, self.commands, self.notes = [], {}, []
        self.facets = self.files = self.round = self.flat = 0
        self.open, self.parsed, self.made = [], {}, {}

    def text(self, text: str, where: str) -> Parts:
        """Return what a text adds; ``where`` comes before its line numbers."""
        parts, quads = Parts(), []
        try:
            if text not in self.parsed:
                self.parsed[text] = parsed(text)
        except RadError as error:
            self.problems.append(f"{where}{error}")
            return parts
        for said in self.parsed[text]:
            if len(self.problems) > MOST or self.facets > MOST_FACETS:
                break
            if isinstance(said, Command):
                parts.add(self._command(said, where))
            elif not self.library.defines(said):
                self._surface(said, parts, quads, where)
        self._check(quads, parts, where)
        return parts

    def _surface(self, said: Primitive, parts, quads, where):
        if said.kind in LEFT_OUT:
            self.library.note(f"{said.kind}: is left out", said.name)
            return
        material = self.library.material_of(said, where, self.problems)
        if material is None:
            return
        known = count_of(said.kind)
        if not self._room(known, 1, where, said.line):
            return
        if said.kind == "source":
            self._source(said, material, parts, where)
            return
        self.round += said.kind != "polygon"
        if said.kind == "polygon" and len(said.reals) in (9, 12):
            corners = np.array(said.reals).reshape(-1, 3)
            if len(corners) == 4:
                quads.append((len(parts.pieces), said))
            corners = corners[SMALL[len(corners)]][None]
            parts.pieces.append(Piece(material, _group(said.name), corners, NO_NORMALS))
            return
        made = self._facets(said, self.library.emits(material), where)
        if made is not None and self._room(max(len(made[0]) - known, 0), 1, where, said.line):
            parts.pieces.append(Piece(material, _group(said.name), *made))

    def _facets(self, said, emits, where):
        """Return facets and normals of a surface, None where it has no area or is wrong."""
        key = id(said), emits  # texts that are met again stand as they were parsed
        try:
            if key not in self.made:
                self.made[key] = facets(said.kind, said.reals, emits)
            return self.made[key]
        except NoArea:
            self.flat += 1
        except ShapeError as error:
            self.problems.append(f"{where}line {said.line}: {said.kind} {said.name} {error}")
        return None

    def _check(self, quads, parts, where):
        """Divide quadrilaterals that are not convex; all are looked at together, as most are."""
        if not quads:
            return
        corners = np.concatenate([parts.pieces[k].quads for k, _ in quads])
        for bad in np.flatnonzero(~convex_quads(corners)):
            k, said = quads[bad]
            made = self._facets(said, False, where)
            found = made or (np.empty((0, 4, 3)), np.empty((0, 4, 3)))
            parts.pieces[k] = replace(parts.pieces[k], quads=found[0], normals=found[1])

    def _source(self, said, material, parts, where):
        if len(said.reals) != 4 or not np.any(said.reals[:3]):
            text = f"line {said.line}: source {said.name} needs a direction and an angle"
            self.problems.append(where + text)
            return
        way, radiance = np.array(said.reals[:3]), self.library.radiance(material)
        way = way / np.abs(way).max()
        parts.distant.append(Distant(way / np.linalg.norm(way), abs(said.reals[3]), radiance))

    def _room(self, count, copies, where, line):
        """Whether there is room for more facets, before they are made."""
        self.facets += count * copies
        if self.facets > MOST_FACETS:
            text = f"line {line}: makes more than {MOST_FACETS} facets: split the scene"
            self.problems.append(where + text)
        return self.facets <= MOST_FACETS

    def _command(self, said, where) -> Parts:
        """Return what a command would write if it were run."""
        parts = Parts()
        known = said.pipes and said.pipes[0][0] in ("xform", "genbox")
        if not known or any(words[0] != "xform" for words in said.pipes[1:]):
            name = said.text.split()[0] if said.text.split() else "!"
            self.commands[name] = self.commands.get(name, 0) + 1
            return parts
        try:
            for words in said.pipes:
                if words[0] == "genbox":
                    parts = self._box(words[1:], where, said.line)
                    continue
                moves = read_moves(words[1:])
                if words is said.pipes[0]:
                    for file in moves.rest:
                        parts.add(self._file(file, where, said.line))
                parts = self._moved(parts, moves, where, said.line)
        except MoveError as error:
            self.notes.append(f"{where}line {said.line}: !{words[0]} is left out: {error}")
        return parts

    def _box(self, words, where, line):
        """Return a box of ``genbox material name x y z``, its edges sharp."""
        try:
            sizes = tuple(float(w) for w in words[2:5])
        except ValueError:
            sizes = ()
        if len(sizes) != 3 or not all(0.0 < x <= LONGEST for x in sizes):
            raise MoveError("a box needs a material, a name and three sizes above 0")
        if any(option in words[5:] for option in ("-r", "-b")):
            self.library.note("genbox: its rounded edges are sharp here", words[1])
        parts, said = Parts(), Primitive(line, words[0], "polygon", words[1])
        material = self.library.material_of(said, where, self.problems)
        if material is not None and self._room(6, 1, where, line):
            quads = box(sizes, "-i" in words[5:])
            flat = np.full(quads.shape, np.nan)
            parts.pieces.append(Piece(material, _group(words[1]), quads, flat))
        return parts

    def _file(self, name, where, line) -> Parts:
        """Return what another file adds."""
        self.files += 1
        if name in self.open or len(self.open) >= DEEPEST or self.files > MOST_FILES:
            why = "names itself" if name in self.open else "too many files in files"
            self.problems.append(f"{where}line {line}: {name}: {why}")
            return Parts()
        try:
            text = self.read_file(name)
        except SceneError as error:
            self.problems += [f"{where}line {line}: {name} {p}" for p in error.problems]
            return Parts()
        if text is None:
            self.notes.append(f"{where}line {line}: the file {name} is not there: it is left out")
            return Parts()
        self.open.append(name)
        parts = self.text(text, f"{name} ")
        self.open.pop()
        return parts

    def _moved(self, parts, moves: Moves, where, line) -> Parts:
        """Return the copies that ``xform`` makes of parts."""
        count = sum(len(p.quads) for p in parts.pieces) + len(parts.distant)
        if not self._room(count, max(len(moves.matrices) - 1, 0), where, line):
            return Parts()
        if moves.modifier is not None:
            said = Primitive(line, moves.modifier, "polygon", "")
            name = self.library.material_of(said, where, self.problems)
            parts.pieces = [replace(p, material=name) for p in parts.pieces if name is not None]
        pieces = [_placed(piece, moves) for piece in parts.pieces if len(moves.matrices)]
        distant = [s.turned(m[:3, :3]) for m in moves.matrices for s in parts.distant]
        return Parts(pieces, distant)

    def all_notes(self) -> list[str]:
        """Return what was decided and left out."""
        found = self.notes + self.library.notes()
        if self.commands:
            told = ", ".join(f"{name} ({n})" for name, n in sorted(self.commands.items()))
            found.append(
                f"commands are never run, and what they make is missing: {told}; Radiance's own "
                "xform writes a file with all of it: xform scene.rad > all.rad"
            )
        if self.round:
            found.append(f"{self.round} round surfaces have 24 flat sides round each circle")
        if self.flat:
            found.append(f"{self.flat} polygons with all corners on one line were left out")
        return found


def read_rad(
    text: str, source: str, read_file: Callable[[str], str | None], merge: bool = True
) -> Geometry:
    """Return the geometry, materials, distant lights and views of a Radiance scene description.

    Parameters
    ----------
    text : str
        The file's content.
    source : str
        Its name, for messages.
    read_file : callable
        Returns the text of a file beside it that ``!xform`` names, None if there is none; raises
        SceneError for one that must not be read.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.

    Raises
    ------
    SceneError
        Text that is no scene description, surfaces that are none, too many facets, no surfaces.
    """
    reader = _Reader(read_file)
    parts = reader.text(text, "")
    if not reader.problems:
        reader.problems += _useless(parts, reader)
    if reader.problems:
        more = len(reader.problems) - MOST
        raise SceneError(source, reader.problems[:MOST] + [f"and {more} more"] * (more > 0))
    lights, more = lights_of(parts.distant)
    cameras, unread = read_views(read_file(PurePosixPath(source).stem + ".vf") or "")
    notes = "Radiance has no unit: lengths are those of the scene", *reader.all_notes()
    return replace(
        _geometry(parts.pieces, merge), materials=reader.library.read_as(), lights=tuple(lights),
        cameras=cameras, notes=(*notes, *more, *unread), up="z",
    )  # fmt: skip


def _useless(parts, reader):
    """Yield why nothing can be made of the surfaces."""
    if not any(len(piece.quads) for piece in parts.pieces):
        hint = f": {'; '.join(reader.all_notes())}" if reader.all_notes() else ""
        yield f"has no surfaces{hint}"
    if len(parts.distant) > MOST_SUNS:
        yield f"makes {len(parts.distant)} suns, at most {MOST_SUNS} are read: join them"
    for piece in parts.pieces:
        farthest = np.abs(piece.quads).max(initial=0.0)
        if not farthest <= LONGEST:
            yield f"{piece.group} lies {farthest:.3g} from the origin, at most {LONGEST:g} is read"
            return


def _geometry(pieces, merge):
    """Return the faces of all surfaces."""
    materials, groups = {}, {}
    sizes = [len(p.quads) for p in pieces]
    material = [materials.setdefault(p.material, len(materials)) for p in pieces]
    group = [groups.setdefault(p.group, len(groups)) for p in pieces]
    quads = np.concatenate([p.quads for p in pieces])
    normals = np.concatenate([p.normals for p in pieces])
    faces = Faces.from_polygons(
        quads, np.repeat(material, sizes), np.repeat(group, sizes), merge,
        corner_normals=normals if np.isfinite(normals).any() else None,
    )  # fmt: skip
    if faces.corner_normals is not None:
        faces = replace(faces, corner_normals=curved(faces))
    owner = np.repeat(np.arange(len(pieces)), sizes)[has_area(quads)]
    given = None if merge else Given(faces, owner, len(pieces))
    return Geometry(faces, tuple(materials), tuple(groups), given=given)


def _placed(piece, moves):
    """Return all copies of a surface as one."""
    linear, shift = moves.matrices[:, None, None, :3, :3], moves.matrices[:, None, None, :3, 3]
    quads = np.einsum("...ij,...j->...i", linear, piece.quads[None]) + shift
    normals = np.einsum("...ij,...j->...i", linear, piece.normals[None])
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    normals = normals / np.where(length > 0.0, length, 1.0)
    turned = np.linalg.det(moves.matrices[:, :3, :3]) < 0
    quads[turned], normals[turned] = quads[turned][:, :, TURNED], normals[turned][:, :, TURNED]
    if moves.inverted:
        quads, normals = quads[:, :, TURNED], -normals[:, :, TURNED]
    return replace(piece, quads=quads.reshape(-1, 4, 3), normals=normals.reshape(-1, 4, 3))


def _group(name):
    """Return a surface's name without the number that generators put behind it."""
    stem, _, number = name.rpartition(".")
    return stem if stem and number.isdecimal() else name or DEFAULT
