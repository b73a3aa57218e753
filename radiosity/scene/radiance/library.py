"""What a Radiance scene defines: materials, patterns and aliases, by the names that stand last."""

from dataclasses import dataclass

import numpy as np

from radiosity.scene.geometry import DEFAULT, free_name
from radiosity.scene.model import ReadAs
from radiosity.scene.radiance.materials import EMITTERS, NOTHING, MaterialError, table_of
from radiosity.scene.radiance.text import MATERIALS, MODIFIERS, SURFACES, Primitive

LONGEST_CHAIN = 64  # of names that stand for each other


@dataclass(frozen=True)
class _Used:
    """A material that a surface has: how it was defined and what it became."""

    said: Primitive
    read_as: ReadAs


class Library:
    """Definitions read so far, and the materials that surfaces have made use of."""

    def __init__(self):
        self._defined, self._used, self._names, self._told = {}, {}, {}, {}

    def defines(self, said: Primitive) -> bool:
        """Take a definition; false for a surface."""
        if said.kind in SURFACES:
            return False
        self._defined[said.name] = said
        return True

    def note(self, text: str, name: str) -> None:
        """Remember something to say of things of a kind, with one that it was said of."""
        count, first = self._told.get(text, (0, name))
        self._told[text] = count + 1, first

    def notes(self) -> list[str]:
        """Return all notes, once a kind."""
        return [f"{text} ({count}, {first} for one)" for text, (count, first) in self._told.items()]

    def material_of(self, surface: Primitive, where: str, problems: list[str]) -> str | None:
        """Return the name of a surface's material, None where it is none or wrong."""
        said = self._resolved(surface, where, problems)
        if said is None or isinstance(said, str):
            return said
        if said.kind in NOTHING:
            self.note(f"{said.kind}: its surfaces are left out", said.name)
            return None
        same = said.name, said.kind, said.strings, said.reals
        if same in self._names:
            return self._names[same]
        try:
            table, notes = table_of(said)
        except MaterialError as error:
            problems.append(f"{where}line {surface.line}: {said.kind} {said.name} {error}")
            return None
        self._note_all(said, notes)
        name = free_name(said.name, self._used)
        numbers = " ".join(f"{x:g}" for x in said.reals[:12])
        self._names[same] = name
        self._used[name] = _Used(said, ReadAs(f"{said.kind} {numbers}".strip(), table))
        return name

    def _note_all(self, said, notes):
        pattern = self._defined.get(said.modifier)
        if pattern is not None and pattern.kind in MODIFIERS:
            notes = [*notes, "patterns and textures are left out"]
        for note in notes:
            self.note(note, said.name)

    def _resolved(self, surface, where, problems):
        """Return the definition of a surface's material, or the name of one that has none."""
        name = surface.modifier
        for _ in range(LONGEST_CHAIN):
            if name == "void":
                return DEFAULT
            said = self._defined.get(name)
            if said is None:
                return name
            if said.kind in MATERIALS:
                return said
            if said.kind == "alias":
                name = said.strings[0]
                continue
            self.note("patterns and textures are left out", said.name)
            name = _below(said)
        problems.append(f"{where}line {surface.line}: {surface.modifier} stands for itself")
        return None

    def emits(self, name: str) -> bool:
        """Whether a material is a lamp's."""
        return name in self._used and self._used[name].said.kind in EMITTERS

    def radiance(self, name: str) -> np.ndarray:
        """Return the radiance (3,) of a material, 0 where it emits nothing."""
        table = self._used[name].read_as.table if name in self._used else {}
        return np.array(table.get("emission", {}).get("radiance", [0.0] * 3))

    def read_as(self) -> dict[str, ReadAs]:
        """Return what the materials of surfaces became, by name."""
        return {name: used.read_as for name, used in self._used.items()}


def _below(said):
    """Return what a pattern lies on: of a mixture its foreground, else its background."""
    if said.kind.startswith("mix") and len(said.strings) > 1:
        return said.strings[0] if said.strings[0] != "void" else said.strings[1]
    return said.modifier
