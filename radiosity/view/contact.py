"""Light close to contacts: what nearby surfaces receive, exactly where rays meet them.

Surfaces send out the light that lamps throw on them by a grid of cells. From afar a cell's mean is
enough; from a crease, or where a block stands on a floor, one sees single cells, and a shadow's
edge inside of them would show as a bright or a dark spot.
"""

import numpy as np
from numba import njit

from radiosity.solve.solution import Solution
from radiosity.transport.borrow import borrowed
from radiosity.transport.irradiance import FINER, direct_irradiance
from radiosity.transport.lookup import cell_at

NEAR = 2.0  # sizes of a cell: how far rays may go to be near
RAYS = 2  # to each light, from where a ray ends nearby


def contact_light(
    solution: Solution, points: np.ndarray, sides: np.ndarray, hits: np.ndarray, keys: np.ndarray,
    first: int,
) -> np.ndarray:  # fmt: skip
    """Return by how much irradiance differs where near rays meet single places, not cells (E8).

    The mean over a point's cosine-distributed rays of rho (E_l - E_c) with E_l what lights cause
    where a ray ends and E_c what they cause on its cell; 0 for rays that go far and on textures.

    Parameters
    ----------
    points : (k, 3) float64
        Where rays start, scene units.
    sides, hits : (k, n) int, (k, n, 3) float32
        What they meet, see `hemisphere.look_out`.
    keys : (k,) int
        What the sample patterns of points are hashed from.
    first : int
        Number of the first ray of each point.

    Returns
    -------
    (k, bands) float64
        W/m2.
    """
    around, patches = solution.surroundings, solution.patches
    field, visibility, table = around.field, around.visibility, around.table
    change = np.zeros((len(points), len(field.outside)))
    if not field.direct.shape[1]:
        return change
    size = NEAR / FINER * np.sqrt(patches.area)
    plain = np.array([m.texture is None for m in solution.scene.materials])
    size[~plain[solution.scene.faces.material[patches.face]]] = 0.0
    p, k = _near(points, sides, hits, field.row, size, visibility.centre, visibility.scale)
    if not len(p):
        return change
    row, place = field.row[sides[p, k]], visibility.centre + hits[p, k] / visibility.scale
    own = keys[p].astype(np.int64) * (1 << 20) + first + k
    lit = direct_irradiance(
        visibility, around.lights, place, patches.normal[row], own, range(RAYS), solution.seed
    )
    kept = field.direct[sides[p, k] % 2, _cells(table, table.face[sides[p, k] // 2], place)]
    np.add.at(change, p, (solution.reflectance[row] * lit - kept) / sides.shape[1])
    return change


@njit(cache=True, nogil=True)
def _near(points, sides, hits, row, size, centre, scale):
    """Return which rays (points, numbers) end on a lit side nearer than its ``size``."""
    found = np.empty((2, sides.size), np.int64)
    n = 0
    for p in range(len(sides)):
        for k in range(sides.shape[1]):
            r = row[sides[p, k]] if sides[p, k] >= 0 else -1
            if r < 0:
                continue
            d2 = 0.0
            for c in range(3):
                d = centre[c] + hits[p, k, c] / scale - points[p, c]
                d2 += d * d
            if d2 < size[r] ** 2:
                found[0, n], found[1, n] = p, k
                n += 1
    return found[0, :n], found[1, :n]


@njit(cache=True, nogil=True)
def _cells(table, face, points):
    """Return (k,) the fine cells that hold points (k, 3) of faces (k,)."""
    table = borrowed(table)
    found = np.empty(len(face), np.int64)
    for k in range(len(face)):
        found[k] = cell_at(table, face[k], points[k], FINER)
    return found
