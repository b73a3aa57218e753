"""Units of length, axes that point up, and the question whether a scene's size is plausible."""

import numpy as np

from radiosity.mesh.faces import Faces

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
LEAST, MOST = 0.01, 1000.0  # m; what is shorter or longer is questioned
USUAL = 0.1, 100.0  # m; objects, rooms and buildings


def extent_notes(faces: Faces, unit: str) -> list[str]:
    """Return the question about a scene shorter than 1 cm or longer than 1 km, if it is.

    Examples
    --------
    >>> room = np.array([[[0, 0, 0], [5000, 0, 0], [5000, 4000, 0], [0, 4000, 0]]])
    >>> extent_notes(Faces.from_polygons(room, 0, 0), "m")
    ['the scene is 5000 m long: is its unit cm or mm? Then it would be 50 m or 5 m']
    """
    extent = float(np.ptp(faces.vertices, axis=(0, 1)).max())
    long = extent * UNITS[unit]
    if LEAST <= long <= MOST:
        return []
    likely = [u for u, metres in UNITS.items() if USUAL[0] <= extent * metres <= USUAL[1]]
    if not likely:
        units = ", ".join(UNITS)
        return [f"the scene is {_text(long)} m long: is {unit} its unit ({units})?"]
    lengths = " or ".join(f"{_text(extent * UNITS[u])} m" for u in likely)
    return [f"the scene is {_text(long)} m long: is its unit {' or '.join(likely)}? Then it would "
            f"be {lengths}"]  # fmt: skip


def turn_between(old: str, new: str) -> np.ndarray:
    """Return the rotation (3, 3) that takes one axis that points up to another, the short way.

    The third axis stays: from z to y the old y becomes -z, (x, y, z) -> (x, z, -y).

    Examples
    --------
    >>> (turn_between("x", "y") @ [1, 2, 3]).tolist()
    [-2.0, 1.0, 3.0]
    """
    turn, a, b = np.eye(3), "xyz".index(old), "xyz".index(new)
    if a != b:
        turn[a, a] = turn[b, b] = 0.0
        turn[b, a], turn[a, b] = 1.0, -1.0
    return turn


def _text(value):
    return f"{value:.3g}" if value < 100 else f"{value:.0f}" if value < 1e6 else f"{value:.3g}"
