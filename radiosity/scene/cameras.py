"""Cameras of a scene file: the tables ``[cameras.NAME]``."""

import numpy as np

from radiosity.scene.assemble import AXES
from radiosity.scene.checks import value_of
from radiosity.scene.model import Camera
from radiosity.scene.schema import POINT, CameraTable, at, dotted


def make_camera(name, table: CameraTable, up: str) -> Camera:
    """Return the camera of a table without mistakes; ``up`` is the scene's axis."""
    view = np.subtract(table.target, table.position)
    axis = np.array(table.up or AXES[up])
    if table.up is None and _parallel(axis, view):
        axis = np.array(AXES["y" if up == "z" else "z"])
    fov = None if table.projection == "orthographic" else table.fov
    place = np.array(table.position), np.array(table.target), axis
    return Camera(name, *place, fov, table.size, table.height)


def camera_problems(table: dict, path: tuple) -> list[str]:
    """Return what is wrong between the keys of a camera."""
    return _projection_problems(table, path) + _direction_problems(table, path)


def _projection_problems(table, path):
    """Return which of the keys of a projection are given with the other one, or missing."""
    projection = table.get("projection", "pinhole")
    if projection == "orthographic":
        if "fov" in table:
            text = "is for pinhole cameras: an orthographic one has height instead"
            return [at((*path, "fov"), table["fov"], text)]
        if "height" not in table and set(table) <= set(CameraTable.model_fields):  # no typing error
            text = "is missing: the vertical extent that an orthographic camera shows"
            return [f"{dotted((*path, 'height'))} {text}"]
    elif projection == "pinhole" and "height" in table:
        text = 'needs projection = "orthographic": a pinhole camera has fov instead'
        return [at((*path, "height"), table["height"], text)]
    return []


def _direction_problems(table, path):
    """Return whether a camera looks at nothing or its picture has no top."""
    position, target = value_of(table, "position", POINT), value_of(table, "target", POINT)
    up = value_of(table, "up", POINT)
    if position is None or target is None:
        return []
    if _nothing(np.subtract(target, position), np.add(np.abs(target), np.abs(position))):
        return [f"{dotted(path)} looks from {list(position)} at the same point: move its target"]
    if up is None:
        return []
    if not np.any(up):
        return [at((*path, "up"), list(up), "must not be zero: it is a direction")]
    if _parallel(up, np.subtract(target, position)):
        text = "must not be parallel to the view from position to target: give any other direction"
        return [at((*path, "up"), list(up), text)]
    return []


def _nothing(step, scale):
    return np.linalg.norm(step) <= 1e-12 * np.linalg.norm(scale)


def _parallel(a, b):
    a, b = (np.asarray(v, float) / np.abs(v).max() for v in (a, b))
    return np.linalg.norm(np.cross(a, b)) <= 1e-6 * np.linalg.norm(a) * np.linalg.norm(b)
