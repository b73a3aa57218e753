"""Geometry: the faces that one file or one ``[[geometry]]`` block brings into a scene."""

from dataclasses import dataclass, field, replace

import numpy as np

from radiosity.mesh.faces import Faces
from radiosity.mesh.given import Given
from radiosity.scene.model import Material

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
    materials : dict of str to Material
        What the file itself says of its materials (an MTL library).
    notes : tuple of str
        What was decided on the way that a user may want to know.
    given : Given, optional
        The same faces as parts of the file's; None where pairs of triangles were joined.
    fixed : frozenset of str
        Names of the groups whose faces are not turned round, see `radiosity.scene.repair`.
    """

    faces: Faces
    material_names: tuple[str, ...]
    group_names: tuple[str, ...]
    materials: dict[str, Material] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    given: Given | None = None
    fixed: frozenset[str] = frozenset()

    def of_material(self, name: str) -> "Geometry":
        """Return the geometry with all of it made of one material."""
        faces = replace(self.faces, material=np.zeros(len(self.faces), int))
        return replace(self, faces=faces, material_names=(name,), materials={}, given=None)

    def placed(self, matrix: np.ndarray) -> "Geometry":
        """Return the geometry moved by a matrix (4, 4) that acts on columns.

        A reflection also turns the winding round, so fronts stay fronts. Normals are moved by the
        inverse transpose.
        """
        faces, linear = self.faces, matrix[:3, :3]
        v, uv, normals = faces.vertices @ linear.T + matrix[:3, 3], faces.uv, faces.corner_normals
        if normals is not None:
            normals = normals @ np.linalg.inv(linear)
            normals /= np.linalg.norm(normals, axis=2, keepdims=True)
        if np.linalg.det(linear) < 0:
            order = np.where(faces.is_triangle[:, None], [0, 2, 1, 1], [0, 3, 2, 1])[..., None]
            v, uv, normals = (
                None if x is None else np.take_along_axis(x, order, axis=1)
                for x in (v, uv, normals)
            )
        faces = replace(faces, vertices=v, uv=uv, corner_normals=normals)
        return replace(self, faces=faces, given=None)


def joined(parts: list[Geometry]) -> Geometry:
    """Return one geometry of all parts, in order.

    Materials of one name are one material, the first part that describes it wins; groups of
    different parts stay apart: a name that is taken gets a number ("wall", "wall-2"). Faces that
    repeat one of their material are dropped.
    """
    materials, groups, described, notes, faces, fixed = {}, {}, {}, [], [], set()
    for part in parts:
        material = [materials.setdefault(n, len(materials)) for n in part.material_names]
        group = [groups.setdefault(_free(n, groups), len(groups)) for n in part.group_names]
        fixed |= {list(groups)[group[k]] for k, n in enumerate(part.group_names) if n in part.fixed}
        renumbered = replace(
            part.faces,
            material=np.array(material, int)[part.faces.material],
            group=np.array(group, int)[part.faces.group],
        )
        faces.append(renumbered)
        described = part.materials | described
        notes += part.notes
    faces = Faces.concatenate(faces).without_duplicates()
    names = tuple(materials), tuple(groups)
    return Geometry(faces, *names, described, tuple(notes), fixed=frozenset(fixed))


def _free(name, taken):
    """Return a name that is not taken: itself or with the first free number."""
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}-{number}"
    return free
