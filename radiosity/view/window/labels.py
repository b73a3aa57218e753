"""Numbers on the lines of equal value, at places where they are seen."""

import numpy as np

from radiosity.scene.model import Camera
from radiosity.view.camera import project
from radiosity.view.sightlines import first_rows
from radiosity.view.window.drawing import tag
from radiosity.view.window.hud import PANELS, Hud, line_height

EACH = 2  # labels of a level at most
TRIED = 24  # places of a level
APART = 7.0  # lines between labels of a level, at least; other levels may be nearer
SAME = 1e-3  # of the scene's extent, that a line of sight may end beside its aim


class Labels:
    """The numbers that are shown.

    Attributes
    ----------
    stale : bool
        Whether the lines have none as yet.
    """

    def __init__(self, hud: Hud):
        """Show none as yet."""
        self._hud, self._shown, self.stale = hud, [], True

    def clear(self) -> None:
        """Take them away."""
        self._hud.hide(self._shown)
        self._shown, self.stale = [], True

    def place(self, solution, camera: Camera, middles: np.ndarray, values: np.ndarray) -> None:
        """Label lines by their values (s,), whose segments have their middles at (s, 3).

        Numbers lie where nothing hides their line, and neither over panels nor over each other.
        """
        self.clear()
        self.stale = False
        size, line, boxes = camera.size, line_height(camera.size), self._hud.places()
        at, depth = project(camera, size, middles)
        inside = (depth > 0) & np.all((at > 2 * line) & (at < np.array(size) - 2 * line), axis=1)
        for value in np.unique(values):
            rows = np.flatnonzero(inside & (values == value))
            rows = rows[:: max(1, len(rows) // TRIED)]
            rows = rows[_visible(solution, camera, middles[rows])] if len(rows) else rows
            own = []
            for x, y in at[rows]:
                if len(own) == EACH or any(np.hypot(x - u, y - v) < APART * line for u, v in own):
                    continue
                if self._put(f"{value:.4g}", x, y, line, size, boxes):
                    own.append((x, y))

    def _put(self, text, x, y, line, size, boxes):
        """Show a label around a pixel, where there is room; return whether there was."""
        name = f"label {len(self._shown)}"
        wide, high = self._hud.draw(name, (text, line), lambda: tag(text, line), PANELS - 1)
        left, top = round(x - wide / 2), round(y - high / 2)
        for u, v, w, h in boxes:
            if left < u + w and u < left + wide and top < v + h and v < top + high:
                return False
        self._hud.put(name, left, top, size[1])
        self._shown.append(name)
        boxes.append((left, top, wide, high))
        return True


def _visible(solution, camera, points):
    """Return (k,) whether the camera sees points on surfaces."""
    if camera.orthographic:
        forward = np.asarray(camera.target, float) - camera.position
        forward /= np.linalg.norm(forward)
        far = (points - camera.position) @ forward
        origins, ahead = points - far[:, None] * forward, np.broadcast_to(forward, points.shape)
    else:
        origins, ahead = np.broadcast_to(camera.position, points.shape), points - camera.position
        ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    _, met = first_rows(solution, np.ascontiguousarray(origins, float), np.ascontiguousarray(ahead))
    extent = np.ptp(solution.scene.faces.vertices, axis=(0, 1)).max()
    return np.linalg.norm(met - points, axis=1) < SAME * extent
