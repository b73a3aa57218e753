"""What the window draws: the patches' corners, and values at them."""

import numpy as np

from radiosity.mesh.interpolation import corner_matrix, find_neighbours
from radiosity.scene.model import Scene
from radiosity.solve.solution import Solution
from radiosity.view.camera import basis
from radiosity.view.polydata import cells_of, shown_patches

DIM, BRIGHT = 0.35, 0.65  # of a face's reflectance: not lit, and more where lit from the front
LAMP = np.array([0.35, -0.55, 1.0])  # shines to the right, up and forward of the camera


class Corners:
    """The corners of the patches that can be seen, cell by cell, none of them shared.

    Attributes
    ----------
    shown : (c,) int
        Patch of each cell.
    points : (p, 3) float64
        Scene units.
    cells : (..) int
        As pyvista takes them: the number of a cell's points, then these.
    """

    def __init__(self, solution: Solution):
        """Find which patches meet at each corner, once for all values."""
        patches = solution.patches
        kind = solution.scene.faces.material[patches.face]
        around = find_neighbours(patches, solution.live, kind)
        self.shown = shown_patches(solution)
        vertices = patches.vertices[self.shown]
        self._used, self.cells = cells_of(vertices)
        self.points = vertices[self._used]
        corners = (4 * self.shown[:, None] + np.arange(4))[self._used]
        self._matrix = corner_matrix(patches, around)[corners]

    def smooth(self, values: np.ndarray) -> np.ndarray:
        """Return (p, bands) of values (n, bands) of the patches, smooth across cells.

        Linear in the values; at corners near the dark some may be a little below 0.
        """
        return self._matrix @ values

    def flat(self, values: np.ndarray) -> np.ndarray:
        """Return (p,) of values (n,) of the patches, the same at all corners of one."""
        return np.broadcast_to(values[self.shown, None], self._used.shape)[self._used]


def bare_faces(scene: Scene, camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a scene's faces before anything is solved, in the colours of their materials.

    As if lit from above the camera's left shoulder, so that one sees their shapes.

    Returns
    -------
    points : (p, 3) float64
    cells : (..) int
    rgb : (p, 3) float64
        Between 0 and 1.
    """
    used, cells = cells_of(scene.faces.vertices)
    to_rgb = scene.bands.to_rgb
    colour = np.array([np.ones(3) if m.emits else to_rgb(m.diffuse) for m in scene.materials])
    shining = LAMP / np.linalg.norm(LAMP) @ basis(camera)
    facing = np.maximum(-scene.faces.normals() @ shining, 0.0)
    shade = (DIM + BRIGHT * facing)[:, None] * np.clip(colour[scene.faces.material], 0.0, 1.0)
    return scene.faces.vertices[used], cells, np.repeat(shade, used.sum(axis=1), axis=0)
