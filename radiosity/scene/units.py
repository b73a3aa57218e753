"""Units of length, and the question whether a scene of implausible size has the right one."""

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


def _text(value):
    return f"{value:.3g}" if value < 100 else f"{value:.0f}" if value < 1e6 else f"{value:.3g}"
