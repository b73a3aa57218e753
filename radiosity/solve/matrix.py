"""The form factors of any mesh: from what users hold to a `FormFactors`."""

import os
from numbers import Integral, Real

import numpy as np

from radiosity.mesh.contact import find_contacts
from radiosity.mesh.division import Division
from radiosity.mesh.faces import Faces
from radiosity.mesh.facets import Facets, merge_facets
from radiosity.mesh.given import Given, given_mesh
from radiosity.mesh.patches import make_patches
from radiosity.scene.files import read_geometry
from radiosity.solve.plan import check_factors
from radiosity.transport.closure import repaired
from radiosity.transport.facing import settled
from radiosity.transport.factors import form_factors as assemble
from radiosity.transport.operator import FormFactors
from radiosity.transport.threads import Progress, silent
from radiosity.transport.visibility import Visibility

TIGHTEST, LOOSEST = 1e-9, 0.5


def form_factors(
    mesh,
    accuracy: float = 1e-3,
    *,
    obstructions=None,
    two_sided: bool = False,
    repair: bool = True,
    seed: int = 0,
    memory: float | None = None,
    progress: Progress = silent,
) -> FormFactors:
    """Return the form factors between the faces of a mesh (E1).

    Parameters
    ----------
    mesh : trimesh.Trimesh, pyvista.PolyData, (vertices, faces), path, Faces or Given
        Faces are counter-clockwise seen from the side that radiates; row k is face k. Polygons
        of any number of corners, concave ones too; of PLY and STL files the triangles.
    accuracy : float
        Asked bound of the sum over j of |error of F_ij| in every row. What leaves the rows has
        an error of its own, ``openness.error``.
    obstructions : like ``mesh``, optional
        Faces that block but are no rows.
    two_sided : bool
        Backs radiate too: rows n to 2 n - 1 are the backs of rows 0 to n - 1.
    repair : bool
        Close the rows, see `radiosity.transport.closure.repaired`; ``raw_closure`` keeps the
        defects before.
    seed : int
        Of all sample patterns.
    memory : float, optional
        Bytes that may be used; half of what is free by default.
    progress : callable
        Called as ``progress(stage, done, total)``.

    Returns
    -------
    FormFactors
        Areas in squared units of the mesh, without what another face covers in contact; rows
        that are covered or see nothing are 0 and listed in ``sealed``.

    Raises
    ------
    TypeError, ValueError
        The mesh or an option is wrong; the text says where, the bound and the way out.
    Refused
        The matrix would not fit into ``memory``.
    NotClosable
        The rows cannot be closed.

    Examples
    --------
    >>> import radiosity
    >>> import trimesh
    >>> room = trimesh.creation.box()
    >>> _ = room.invert()
    >>> F = radiosity.form_factors(room, accuracy=1e-6)
    >>> F.shape, bool(abs(F.row_sums() - 1).max() < 1e-12)
    ((12, 12), True)
    """
    _check_options(accuracy, seed, memory)
    given = _read(mesh, "mesh")
    if len(given.faces) == 0:
        raise ValueError(f"none of the {given.count} faces of the mesh has an area: nothing to see")
    nothing = Given(Faces.concatenate([]), np.empty(0, int), 0)
    blocking = nothing if obstructions is None else _read(obstructions, "obstructions")
    faces = Faces.concatenate([given.faces, blocking.faces])
    sides = 2 if two_sided else 1
    check_factors(sides * given.size, len(faces), memory)
    facets = merge_facets(faces)
    visibility = Visibility(faces, facets)
    patches = _exposed(faces, given.faces, facets, visibility)
    if two_sided:
        patches = patches.with_backs(np.ones(len(patches), bool))
    count = sides * given.count
    check_factors(max(count, len(patches)), len(faces), memory)
    live = np.concatenate([~patches.covered, patches.behind[patches.back_of >= 0, 1] < 0])
    if not live.any():
        raise ValueError(
            f"all {len(live)} rows are covered by faces that look at them in contact, and see "
            "nothing: turn round or leave out what lies on the mesh"
        )
    raw = assemble(patches, visibility, live, accuracy, seed, progress)
    raw = raw.replaced(area=np.where(live, raw.area, 0.0))
    owner = given.owner[patches.face] + np.where(patches.front, 0, given.count)
    if len(owner) != count or not np.array_equal(owner, np.arange(count)):
        raw = raw.grouped(owner, count)
    return repaired(raw) if repair else raw


def _check_options(accuracy, seed, memory):
    if not isinstance(accuracy, Real):
        raise ValueError(f"accuracy = {accuracy!r} must be a number, such as 0.001")
    if not TIGHTEST <= accuracy <= LOOSEST:
        raise ValueError(f"accuracy = {accuracy:g} must lie in [{TIGHTEST:g}, {LOOSEST:g}]")
    if not (isinstance(seed, Integral) and 0 <= seed < 2**32):
        raise ValueError(f"seed = {seed!r} must be a whole number from 0 to {2**32 - 1}")
    if memory is not None and not (isinstance(memory, Real) and memory > 0):
        raise ValueError(f"memory = {memory!r} must be a number of bytes above 0, such as 4e9")


def _read(mesh, name) -> Given:
    """Return the pieces of a mesh or of a file's mesh."""
    if isinstance(mesh, str | os.PathLike):
        return read_geometry(mesh, merge=False).given
    return given_mesh(mesh, name)


def _exposed(faces: Faces, rows: Faces, facets: Facets, visibility: Visibility):
    """Return a patch for every piece of the rows that contact with any face cuts them into."""
    contacts = find_contacts(faces, np.zeros(len(faces), bool), len(rows), facets)
    contacts = settled(contacts, faces, visibility)
    shape = np.where(rows.is_triangle[:, None], [1, 0], [1, 1])
    return make_patches(rows, Division(shape), contacts)
