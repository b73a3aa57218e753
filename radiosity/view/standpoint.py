"""Where a pyvista window looks from: our cameras in VTK's terms, and back."""

from typing import TYPE_CHECKING

import numpy as np

from radiosity.scene.model import Camera
from radiosity.view.camera import basis

if TYPE_CHECKING:
    import pyvista


def current_camera(plotter: "pyvista.Plotter", name: str) -> Camera:
    """Return where a window looks from at this moment, at its size in pixels."""
    seen = plotter.renderer.GetActiveCamera()
    position, target, up = (
        np.array(v) for v in (seen.GetPosition(), seen.GetFocalPoint(), seen.GetViewUp())
    )
    size = tuple(plotter.render_window.GetSize())
    if seen.GetParallelProjection():
        height = 2.0 * seen.GetParallelScale()
        return Camera(name, position, target, up, None, size, height)
    return Camera(name, position, target, up, seen.GetViewAngle(), size)


def look_from(plotter: "pyvista.Plotter", camera: Camera, vertices: np.ndarray) -> None:
    """Let a window look as a camera does, turning about a point within the scene.

    ``vertices`` (f, 4, 3) are the scene's, in its units; the window keeps its size.
    """
    seen = plotter.renderer.GetActiveCamera()
    seen.SetPosition(camera.position)
    seen.SetFocalPoint(_pivot(camera, vertices))
    seen.SetViewUp(camera.up)  # also the axis that dragging turns about
    seen.SetParallelProjection(camera.orthographic)
    if camera.orthographic:
        seen.SetParallelScale(camera.height / 2.0)
    else:
        seen.SetViewAngle(camera.fov)
    plotter.renderer.camera.is_set = True
    plotter.renderer.ResetCameraClippingRange()


def _pivot(camera, vertices):
    """Return the point to turn about: the target, or abreast of the scene's middle if outside.

    It lies on the line of sight, so the picture does not depend on it.
    """
    low, high = vertices.reshape(-1, 3).min(axis=0), vertices.reshape(-1, 3).max(axis=0)
    if np.all((low <= camera.target) & (camera.target <= high)):
        return camera.target
    forward = basis(camera)[2]
    depth = forward @ ((low + high) / 2 - camera.position)
    return camera.position + depth * forward if depth > 0 else camera.target
