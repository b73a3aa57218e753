"""Illuminance within patches: the fine mesh, made in a thread once it is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from radiosity.solve.solution import Solution
from radiosity.transport.threads import Progress, silent
from radiosity.view.fine.finemesh import MOST, gathered_mesh
from radiosity.view.polydata import shown_patches
from radiosity.view.window.solving import Solving


@dataclass(frozen=True)
class Fine:
    """Triangles as the window draws them, with the illuminance at their corners.

    Attributes
    ----------
    points : (p, 3) float64
        Scene units.
    cells : (4 t,) int
        As pyvista takes them.
    spread : tuple of (t,) float64
        Mean illuminances of the triangles that light reaches, in the scene's own light, and areas.
    groups : (g,) tuple of str
        Of light.
    lux : (p, g) float64
        Illuminance by each group.
    """

    points: np.ndarray
    cells: np.ndarray
    spread: tuple[np.ndarray, np.ndarray]
    groups: tuple[str, ...]
    lux: np.ndarray

    def illuminance(self, factors: Mapping[str, float]) -> np.ndarray:
        """Return (p,) lx, with groups of light scaled, others as they are."""
        return self.lux @ np.array([factors.get(name, 1.0) for name in self.groups])


def fine_of(solution: Solution, progress: Progress = silent) -> Fine:
    """Return a solution's `Fine` mesh."""
    mesh = gathered_mesh(solution, progress)
    triangles = mesh.triangles
    a, b, c = np.moveaxis(mesh.points[triangles], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    live = solution.live[mesh.patch[triangles[:, 0]]]
    mean = mesh.lux.sum(axis=1)[triangles].mean(axis=1)
    cells = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    return Fine(mesh.points, cells, (mean[live], area[live]), mesh.groups, mesh.lux)


def can_refine(solution) -> bool:
    """Return whether patches can be divided: some were solved for, and are fewer than points."""
    return isinstance(solution, Solution) and len(shown_patches(solution)) <= MOST


class Refining:
    """The fine mesh, once it is there.

    Attributes
    ----------
    mesh : Fine or None
    """

    def __init__(self):
        """Refine nothing as yet."""
        self._work, self._begun, self.mesh = None, False, None

    @property
    def share(self) -> float | None:
        """Return how much is done, 0 to 1, None where nothing is waited for."""
        if self._work is None or self._work.ready:
            return None
        return 0.0 if self._work.stage is None else self._work.stage.share

    def start(self, solution: Solution) -> None:
        """Begin, in a thread, where it was not begun and `can_refine` says so."""
        if self._begun:
            return
        self._begun = True
        if can_refine(solution):
            self._work = Solving(lambda progress, _: fine_of(solution, progress))
            self._work.start()

    def hear(self) -> bool:
        """Take the mesh once it is there; return whether that was now.

        Raises
        ------
        Exception
            What ended the work.
        """
        if self.mesh is not None or self._work is None or not self._work.ready:
            return False
        if self._work.error is not None:
            raise self._work.error
        self.mesh = self._work.newest
        return True

    def stop(self, patience: float) -> None:
        """Let the work end at its next report, and wait for that for some seconds."""
        if self._work is not None:
            self._work.stop(patience)
