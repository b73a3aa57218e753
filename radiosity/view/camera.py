"""Cameras: where from and which way a pixel looks, and where on the picture a point appears.

Pixel coordinates are continuous: x to the right, y down, (0, 0) the picture's upper left corner,
pixel (i, j) has its centre at (i + 0.5, j + 0.5). Pixels are square and ``fov`` is vertical, so
another width shows more or less at the sides and nothing else.
"""

import numpy as np

from radiosity.scene.model import Camera

_PARALLEL = 1e-9  # sine of the angle below which rounding decides which way is up


def basis(camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the picture's axes: right, up and forward, (3,) orthonormal vectors.

    forward = (target - position)/|..|, right = forward x up/|..|, up' = right x forward.

    Raises
    ------
    ValueError
        Where the camera looks at its own position, or along its ``up``.
    """
    forward = _unit(
        np.asarray(camera.target, dtype=np.float64) - np.asarray(camera.position, dtype=np.float64),
        f"cameras.{camera.name}.target = {_text(camera.target)} must differ from position: "
        "a camera cannot look at where it stands",
    )
    above = _unit(
        np.asarray(camera.up, dtype=np.float64),
        f"cameras.{camera.name}.up = {_text(camera.up)} must have a length: give e.g. [0, 0, 1]",
    )
    right = _unit(
        np.cross(forward, above),
        f"cameras.{camera.name}.up = {_text(camera.up)} must not point along the view direction "
        f"{_text(forward)}: the picture would have no top; take another axis",
        least=_PARALLEL,
    )
    return right, np.cross(right, forward), forward


def rays(
    camera: Camera, size: tuple[int, int], pixel_xy: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return where sight lines through points of the picture begin, and their directions.

    With a = s (x - w/2), b = s (h/2 - y): a pinhole camera looks from its position along
    forward + a right + b up, normalised, s = 2 tan(fov/2)/h; an orthographic one from
    position + a right + b up along forward, s = height/h.

    Parameters
    ----------
    size : (w, h)
        Of the picture in pixels; need not be the camera's own.
    pixel_xy : (k, 2) float64
        Continuous pixel coordinates.

    Returns
    -------
    origins : (k, 3) float64
        Scene units.
    directions : (k, 3) float64
        Unit vectors.

    Raises
    ------
    ValueError
        Where the camera, its fov or height, or the size is impossible.
    """
    right, up, forward = basis(camera)
    width, height = size
    x, y = np.moveaxis(np.asarray(pixel_xy, dtype=np.float64), -1, 0)
    scale = _pixel_size(camera, size)
    across, above = scale * (x - 0.5 * width), scale * (0.5 * height - y)
    aside = across[..., None] * right + above[..., None] * up
    position = np.asarray(camera.position, dtype=np.float64)
    if camera.orthographic:
        return position + aside, np.broadcast_to(forward, aside.shape).copy()
    direction = forward + aside
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    return np.broadcast_to(position, direction.shape).copy(), direction


def project(
    camera: Camera, size: tuple[int, int], points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return where points appear on the picture: the inverse of `rays`.

    With v = point - position, depth = v.forward and s as in `rays`, x = w/2 + v.right/(s d),
    y = h/2 - v.up/(s d), where d = depth of pinhole cameras and 1 of orthographic ones.

    Parameters
    ----------
    size : (w, h)
        Of the picture in pixels; need not be the camera's own.
    points : (k, 3) float64
        Scene units.

    Returns
    -------
    pixel_xy : (k, 2) float64
        Continuous pixel coordinates, outside the picture too; NaN for points not in front.
    depth : (k,) float64
        Distance along the view direction in scene units, negative behind the camera.
    """
    right, up, forward = basis(camera)
    width, height = size
    offset = np.asarray(points, dtype=np.float64) - np.asarray(camera.position, dtype=np.float64)
    depth = offset @ forward
    shrinks = np.ones_like(depth) if camera.orthographic else depth
    plane = _pixel_size(camera, size) * np.where(depth > 0, shrinks, np.nan)
    x = 0.5 * width + (offset @ right) / plane
    y = 0.5 * height - (offset @ up) / plane
    return np.stack([x, y], axis=-1), depth


def fitting(camera: Camera, longest: int) -> tuple[int, int]:
    """Return a camera's (w, h) in pixels, in proportion at most so many."""
    share = min(1.0, longest / max(camera.size))
    width, height = (max(1, round(share * n)) for n in camera.size)
    return width, height


def _pixel_size(camera, size):
    """Return s, the side of a pixel: on the picture plane at distance 1, or anywhere."""
    width, height = size
    if width < 1 or height < 1:
        raise ValueError(f"picture size = {width} x {height} must be at least 1 x 1 pixels")
    if camera.orthographic:
        if not 0.0 < camera.height < np.inf:
            raise ValueError(
                f"cameras.{camera.name}.height = {camera.height} must be positive and finite: "
                "it is the vertical extent shown, in scene units"
            )
        return camera.height / height
    if not 0.0 < camera.fov < 180.0:
        raise ValueError(
            f"cameras.{camera.name}.fov = {camera.fov} must lie between 0 and 180 degrees: "
            "a flat picture cannot show half a space"
        )
    return 2.0 * np.tan(np.radians(camera.fov) / 2.0) / height


def _unit(vector, complaint, least=0.0):
    length = np.linalg.norm(vector)
    if not length > least:
        raise ValueError(complaint)
    return vector / length


def _text(vector):
    return "[" + ", ".join(f"{v:g}" for v in np.asarray(vector, dtype=np.float64)) + "]"
