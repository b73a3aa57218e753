"""Direct light on a grid finer than the patches, where shadow edges stay sharp."""

import numpy as np

from radiosity.mesh.faces import Faces
from radiosity.mesh.patches import Patches, centroids
from radiosity.transport.irradiance import FINER, Lights, direct_irradiance
from radiosity.transport.lookup import Table, cell_at, margin_in
from radiosity.transport.threads import over_ranges
from radiosity.transport.visibility import Visibility

RAYS = 16  # to each light from the middle of a fine cell
STEPS = 16  # by which a middle that light cannot reach is moved towards one that it can


def shine(
    faces: Faces,
    patches: Patches,
    live: np.ndarray,
    visibility: Visibility,
    table: Table,
    lights: Lights,
    seed: int,
):
    """Compute direct irradiance in the middle of every fine cell.

    Parameters
    ----------
    live : (n,) bool
        Patches that light reaches.

    Returns
    -------
    irradiance : (2, cells, bands) float64
        W/m2 on fronts and backs; `FINER` x `FINER` cells for each of a face's own.
    face : (cells,) int
    """
    division = patches.grid.division.divided(FINER)
    cells, face = division.cells(faces), division.face
    points, normals = centroids(cells), faces.normals()[face]
    _leave_the_dark(points, face, patches, live, table)
    irradiance = np.zeros((2, len(cells), lights.exitance.shape[1]))
    sides = range(2 if len(patches) > patches.fronts else 1)

    def work(a, b):
        keys = np.arange(a, b)
        for side in sides:
            irradiance[side, a:b] = direct_irradiance(
                visibility, lights, points[a:b], normals[a:b] * (1 - 2 * side), keys,
                range(RAYS), seed,
            )  # fmt: skip

    over_ranges(work, len(cells), 1024)
    return irradiance, face


def _leave_the_dark(points, face, patches, live, table) -> None:
    """Move middles that lie under a contact to the lit part of their patches' cell."""
    start = patches.grid.start
    cut = np.flatnonzero(np.diff(start) > 1)
    lit_here = {
        int(c): k for c in cut if len(k := start[c] + np.flatnonzero(live[start[c] : start[c + 1]]))
    }
    on_cut_face = np.isin(face, patches.face[start[cut]]) if len(cut) else np.zeros(len(face), bool)
    for p in np.flatnonzero(on_cut_face):
        parts = lit_here.get(int(cell_at(table, face[p], points[p], 1)))
        if parts is not None:
            points[p] = _nearest_inside(points[p], parts, patches)


def _nearest_inside(point, parts, patches):
    """Return the nearest of the points where the ways to the patches' centres enter them."""
    entries = np.array([_entry(point, k, patches) for k in parts])
    return entries[np.argmin(np.linalg.norm(entries - point, axis=1))]


def _entry(point, k, patches):
    """Return the first of some points on the way to the centre of patch k that lies inside it."""
    target = patches.centroid[k]
    for t in np.linspace(0.0, 1.0, STEPS + 1):
        x = point + t * (target - point)
        if margin_in(patches.vertices[k], patches.normal[k], x) > 0:
            return x
    return target
