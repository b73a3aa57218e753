"""Walking: a window's camera moves as one who walks, its eyes kept at their height."""

import time
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pyvista

PACE = 0.2  # of the scene's diagonal in a second
STEP = 0.08  # seconds that the press of a key walks at least
AGAIN = 0.05  # seconds within which a key that is let go and pressed again was only repeated
TURN = 90.0  # degrees that looking turns by, over the height of the window
STEEPEST = 85.0  # degrees up or down that one can look
WIDE = 60.0  # degrees of vertical view, of one who looked without perspective before
WAYS = {
    "w": (1, 0, 0), "Up": (1, 0, 0), "s": (-1, 0, 0), "Down": (-1, 0, 0),
    "d": (0, 1, 0), "Right": (0, 1, 0), "a": (0, -1, 0), "Left": (0, -1, 0),
    "Prior": (0, 0, 1), "Next": (0, 0, -1), "Page_Up": (0, 0, 1), "Page_Down": (0, 0, -1),
}  # fmt: skip
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class Walk:
    """Keys that are held, and the steps that they make.

    Attributes
    ----------
    on : bool
        Whether dragging looks around instead of turning the scene.
    """

    def __init__(self, plotter: "pyvista.Plotter", up: str, extent: float):
        """Walk on the plane across the axis ``up``, through a scene of a diagonal's length."""
        self._plotter, self._up, self._extent = plotter, np.array(AXES[up]), extent
        self.on, self._held = False, {}  # keys, and when they were let go

    @property
    def moving(self) -> bool:
        """Return whether a key is held."""
        return bool(self._held)

    def press(self, key: str) -> None:
        """Start to walk: a step at once, more while the key is held."""
        if not self.on:
            self._stand_up()
        if key not in self._held:
            self._go([key], STEP)
        self._held[key] = None

    def release(self, key: str) -> None:
        """Stop to walk in a key's direction."""
        if key in self._held:
            self._held[key] = time.monotonic()

    def stop(self) -> None:
        """Turn the scene again by dragging."""
        self.on, self._held = False, {}

    def advance(self, seconds: float) -> None:
        """Walk for a time, in the direction of the keys that are held."""
        now = time.monotonic()
        self._held = {k: at for k, at in self._held.items() if at is None or now - at < AGAIN}
        self._go([key for key, at in self._held.items() if at is None], seconds)

    def _go(self, keys, seconds):
        camera = self._plotter.renderer.GetActiveCamera()
        ahead, aside = self._heading(camera)
        ways = np.sum([WAYS[key] for key in keys] or [(0, 0, 0)], axis=0)
        move = ways[0] * ahead + ways[1] * aside + ways[2] * self._up
        length = np.linalg.norm(move)
        if length == 0.0:
            return
        move *= PACE * self._extent * seconds / length
        camera.SetPosition(camera.GetPosition() + move)
        camera.SetFocalPoint(camera.GetFocalPoint() + move)
        self._plotter.renderer.ResetCameraClippingRange()

    def look(self, dx: float, dy: float) -> None:
        """Look around, by parts of the window's height that the mouse went right and up."""
        camera = self._plotter.renderer.GetActiveCamera()
        position = np.array(camera.GetPosition())
        sight = np.array(camera.GetFocalPoint()) - position
        distance = np.linalg.norm(sight)
        ahead, aside = self._heading(camera)
        rise = np.degrees(np.arcsin(np.clip(sight @ self._up / distance, -1.0, 1.0)))
        rise = np.radians(np.clip(rise + TURN * dy, -STEEPEST, STEEPEST))
        turn = np.radians(TURN * dx)
        flat = np.cos(turn) * ahead + np.sin(turn) * aside
        camera.SetViewUp(self._up)
        camera.SetFocalPoint(
            position + distance * (np.cos(rise) * flat + np.sin(rise) * self._up)
        )
        self._plotter.renderer.ResetCameraClippingRange()

    def _stand_up(self):
        camera = self._plotter.renderer.GetActiveCamera()
        self.on = True
        if camera.GetParallelProjection():
            camera.ParallelProjectionOff()
            camera.SetViewAngle(WIDE)

    def _heading(self, camera):
        """Return the horizontal directions ahead and to the right."""
        sight = np.array(camera.GetFocalPoint()) - camera.GetPosition()
        flat = sight - (sight @ self._up) * self._up
        if np.linalg.norm(flat) < 1e-6 * np.linalg.norm(sight):  # straight up or down
            above = np.array(camera.GetViewUp()) * -np.sign(sight @ self._up)
            flat = above - (above @ self._up) * self._up
        ahead = flat / np.linalg.norm(flat)
        return ahead, np.cross(ahead, self._up)
