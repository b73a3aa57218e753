"""The solved patches as a mesh that pyvista, VTK and ParaView read."""

from typing import TYPE_CHECKING

import numpy as np

from radiosity.light.photometry import illuminance
from radiosity.mesh.interpolation import corner_values, find_neighbours, gradients
from radiosity.mesh.patches import NONE
from radiosity.solve.solution import Solution, refuse_unsolved
from radiosity.transport.lookup import fronts_at

if TYPE_CHECKING:
    import pyvista

SIDES = ("front", "back")  # what the numbers 0 and 1 of ``side`` mean


def shown_patches(solution: Solution) -> np.ndarray:
    """Return the indices of the patches that can be seen: all but fronts in contact.

    Modelled backs are among them, and fronts that no light reaches, which are black.
    """
    covered = np.zeros(len(solution.patches), bool)
    covered[: solution.patches.fronts] = solution.patches.covered
    return np.flatnonzero(~covered)


def cells_of(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how VTK takes quadrilaterals (n, 4, 3), of which triangles repeat their last corner.

    Returns
    -------
    used : (n, 4) bool
        The corners that are points of the mesh: in this order, none of them shared.
    cells : (..) int
        The number of each cell's points, then these.
    """
    corners = np.where(np.all(vertices[:, 3] == vertices[:, 2], axis=1), 3, 4)
    start = np.cumsum(corners) - corners
    return np.arange(4) < corners[:, None], np.insert(np.arange(corners.sum()), start, corners)


def patches_at(solution: Solution, face, back, points) -> np.ndarray:
    """Return (k,) the lit patch at points (k, 3) on faces (k,), `NONE` where none is.

    ``back`` (k,) bool tells which side of the face is meant. What another face covers is not lit.
    """
    patches = solution.patches
    front = fronts_at(solution.surroundings.table, face, points)
    patch = np.where(back, patches.back_of[front], front)
    return np.where((patch >= 0) & solution.live[patch], patch, NONE)


def corner_radiosity(solution: Solution) -> np.ndarray:
    """Return (n, 4, bands) radiosities in W/m2 at the patches' corners, smooth across cells."""
    patches, b = solution.patches, solution.radiosity
    around = find_neighbours(patches, solution.live, solution.scene.faces.material[patches.face])
    return corner_values(patches, around, b, gradients(patches, around, b))


def to_pyvista(solution: Solution) -> "pyvista.PolyData":
    """Return the patches as a mesh in scene units, one cell a patch side.

    Every front is a cell except those in contact with another face, and every back that light
    reaches is one too, in the order of the solution's patches. Cells wind counter-clockwise seen
    from their active side. No two cells share points: the smooth field jumps at creases,
    at changes of material and between the sides of a face, and a shared point has one value.

    Returns
    -------
    pyvista.PolyData
        ``cell_data``: ``radiosity_W_m2``, ``irradiance_W_m2``, ``emission_W_m2``, ``reflectance``
        (a column for each of the ``bands`` that ``field_data`` names),
        ``illuminance_lx``, ``error_lx`` (estimated, of the illuminance), and the integers
        ``patch`` and ``face`` (indices into the solution's patches and the scene's faces),
        ``material``, ``group`` (into the names in ``field_data``) and ``side`` (0 front, 1 back).
        ``point_data``: ``radiosity_W_m2``, interpolated to the corners. ``field_data``: ``scene``,
        ``unit``, ``unit_m`` (metres), ``bands``, ``material_names``, ``group_names``,
        ``side_names``.

    Examples
    --------
    >>> import radiosity
    >>> mesh = radiosity.to_pyvista(radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1))
    >>> mesh.n_cells == len(mesh.cell_data["illuminance_lx"])  # plot(scalars="illuminance_lx")
    True
    """
    import pyvista

    refuse_unsolved(solution)
    scene, patches, shown = solution.scene, solution.patches, shown_patches(solution)
    vertices = patches.vertices[shown]
    used, cells = cells_of(vertices)
    mesh = pyvista.PolyData(vertices[used], faces=cells)
    mesh.point_data["radiosity_W_m2"] = corner_radiosity(solution)[shown][used]
    face = patches.face[shown]
    mesh.cell_data["radiosity_W_m2"] = solution.radiosity[shown]
    mesh.cell_data["irradiance_W_m2"] = solution.irradiance_on[shown]
    mesh.cell_data["emission_W_m2"] = solution.emission[shown]
    mesh.cell_data["illuminance_lx"] = solution.illuminance[shown]
    mesh.cell_data["error_lx"] = illuminance(solution.error[shown], scene.bands)
    mesh.cell_data["reflectance"] = solution.reflectance[shown]
    mesh.cell_data["patch"] = shown
    mesh.cell_data["face"] = face
    mesh.cell_data["material"] = scene.faces.material[face]
    mesh.cell_data["group"] = scene.faces.group[face]
    mesh.cell_data["side"] = (~patches.front[shown]).astype(np.uint8)
    _name(mesh, scene)
    return mesh


def _name(mesh, scene):
    """Attach what the numbers of a mesh mean; VTK keeps names in UTF-8, pyvista ASCII only."""
    from vtkmodules.vtkCommonCore import vtkStringArray

    mesh.field_data["unit_m"] = [scene.unit_m]
    for name, words in {
        "scene": [scene.name],
        "unit": [scene.unit],
        "bands": scene.bands.names,
        "material_names": [m.name for m in scene.materials],
        "group_names": scene.groups,
        "side_names": SIDES,
    }.items():
        column = vtkStringArray()
        column.SetName(name)
        for word in words:
            column.InsertNextValue(word)
        mesh.GetFieldData().AddArray(column)
