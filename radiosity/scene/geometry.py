"""Geometry: what one file or one ``[[geometry]]`` block brings into a scene.

That is faces, and where the file has them materials, lights, cameras and pictures. Materials,
lights and cameras are tables as a scene file has them, so that a reader needs to know its own
format only, and everything is checked and coloured in one place.
"""

from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np

from radiosity.mesh.faces import Faces
from radiosity.mesh.given import Given
from radiosity.scene.model import ReadAs

DEFAULT = "default"  # name of the material, group or camera of things that name none
LONGEST = 1e30  # scene units; fourth powers of lengths must stay below the largest double


@dataclass(frozen=True)
class Geometry:
    """Faces with names of their own.

    Attributes
    ----------
    faces : Faces
        ``material`` and ``group`` are indices into the names here.
    material_names, group_names : tuple of str
    materials : dict of str to ReadAs
        What the file itself says of its materials, as tables ``[materials.NAME]``.
    notes : tuple of str
        What was decided on the way that a user may want to know.
    given : Given, optional
        The same faces as parts of the file's; None where pairs of triangles were joined.
    lights, cameras : tuple of dict, dict of str to dict
        Tables ``[[lights]]`` and ``[cameras.NAME]``, lengths and axes as those of the faces.
    pictures : dict of str to (h, w, 1 or 3) array
        By the names that textures in the materials' tables have: coded whole numbers as an image
        file holds them, or reals.
    unit, up : str or None
        Those that the format fixes.
    fixed : frozenset of str
        Names of the groups whose faces are not turned round, see `radiosity.scene.repair`.
    """

    faces: Faces
    material_names: tuple[str, ...]
    group_names: tuple[str, ...]
    materials: dict[str, ReadAs] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    given: Given | None = None
    lights: tuple[dict, ...] = ()
    cameras: dict[str, dict] = field(default_factory=dict)
    pictures: dict[str, np.ndarray] = field(default_factory=dict)
    unit: str | None = None
    up: str | None = None
    fixed: frozenset[str] = frozenset()

    def of_material(self, name: str) -> "Geometry":
        """Return the geometry with all of it made of one material."""
        faces = replace(self.faces, material=np.zeros(len(self.faces), int))
        return replace(self, faces=faces, material_names=(name,), materials={}, given=None)

    def per_metre(self, unit_m: float) -> "Geometry":
        """Return the geometry with absorption in 1/m that was given per length of the file."""
        def told(said):
            values = [x / unit_m for x in said.table["absorption"]]
            return replace(said, table=said.table | {"absorption": values})

        if unit_m == 1.0:
            return self
        return replace(self, materials={
            name: told(said) if "absorption" in said.table else said
            for name, said in self.materials.items()
        })  # fmt: skip

    def placed(self, matrix: np.ndarray) -> "Geometry":
        """Return the geometry moved by a matrix (4, 4) that acts on columns.

        A reflection also turns the winding round, so fronts stay fronts. Normals are moved by the
        inverse transpose. Lights and cameras go along; what they are as bright as stays.
        """
        faces, linear = self.faces, matrix[:3, :3]
        if np.linalg.det(linear) < 0:
            faces = faces.reversed(np.ones(len(faces), bool))
        v, normals = faces.vertices @ linear.T + matrix[:3, 3], faces.corner_normals
        if normals is not None:
            normals = normals @ np.linalg.inv(linear)
            normals /= np.linalg.norm(normals, axis=2, keepdims=True)
        faces = replace(faces, vertices=v, corner_normals=normals)
        lights = tuple(_moved(table, matrix) for table in self.lights)
        cameras = {name: _moved(table, matrix) for name, table in self.cameras.items()}
        return replace(self, faces=faces, given=None, lights=lights, cameras=cameras)


def _moved(table, matrix):
    """Return a table of a light or a camera with its points and directions moved by a matrix."""
    linear, moved = matrix[:3, :3], dict(table)
    for key in {"position", "target"} & set(table):
        moved[key] = (linear @ table[key] + matrix[:3, 3]).tolist()
    for key in {"direction", "up"} & set(table):
        moved[key] = (linear @ table[key]).tolist()
    if "height" in table:
        moved["height"] = float(table["height"] * np.cbrt(abs(np.linalg.det(linear))))
    return moved


def joined(parts: list[Geometry], defined: Collection[str] = ()) -> Geometry:
    """Return one geometry of all parts, in order.

    Materials of one name are one material, unless two parts describe it differently and it is not
    among those that a scene file has ``defined``; groups of different parts stay apart, as do
    cameras: a name that is taken gets a number ("wall", "wall-2"). Faces that repeat one of their
    material are dropped.
    """
    materials, groups, described, notes, faces, fixed = {}, {}, {}, [], [], set()
    lights, cameras, pictures = [], {}, {}
    for part in parts:
        part = _apart(part, described, defined)
        material = [materials.setdefault(n, len(materials)) for n in part.material_names]
        group = [groups.setdefault(free_name(n, groups), len(groups)) for n in part.group_names]
        fixed |= {list(groups)[group[k]] for k, n in enumerate(part.group_names) if n in part.fixed}
        renumbered = replace(
            part.faces,
            material=np.array(material, int)[part.faces.material],
            group=np.array(group, int)[part.faces.group],
        )
        faces.append(renumbered)
        described = part.materials | described
        notes += part.notes
        lights += part.lights
        cameras |= {free_name(name, cameras): table for name, table in part.cameras.items()}
        pictures |= part.pictures
    faces = Faces.concatenate(faces).without_duplicates()
    return Geometry(
        faces, tuple(materials), tuple(groups), described, tuple(notes), lights=tuple(lights),
        cameras=cameras, pictures=pictures, fixed=frozenset(fixed),
    )  # fmt: skip


def _apart(part, described, defined):
    """Return a part with numbers after the names of materials that others describe differently."""
    clash = [
        n for n, said in part.materials.items()
        if n not in defined and n in described and described[n].table != said.table
    ]  # fmt: skip
    if not clash:
        return part
    taken = {*described, *part.material_names, *part.materials, *defined}
    new = {name: free_name(name, taken) for name in clash}
    notes = [
        f'two files describe the material "{name}" differently: the second one is called "{other}"'
        for name, other in new.items()
    ]
    return replace(
        part, material_names=tuple(new.get(n, n) for n in part.material_names),
        materials={new.get(n, n): said for n, said in part.materials.items()},
        notes=(*part.notes, *notes),
    )  # fmt: skip


def rotation(axis: int, degrees: float) -> np.ndarray:
    """Return the matrix (4, 4) that turns counter-clockwise seen from the tip of an axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(4)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def free_name(name: str, taken) -> str:
    """Return a name that is not taken: itself or with the first free number."""
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}-{number}"
    return free
