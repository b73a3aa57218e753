"""Looking out from points over the hemisphere: which side of which patch is met."""

import numpy as np
from numba import njit

from radiosity.transport.borrow import borrowed
from radiosity.transport.lookup import CUT, Table, cut_side, whole_side
from radiosity.transport.sampling import cosine_direction, hashed, sobol
from radiosity.transport.visibility import LIFT, Visibility

MISS = -1


@njit(cache=True, nogil=True)
def _aim(points, normals, keys, first, count, seed, centre, scale, lift, origins, directions):
    d, normals = np.empty(3), borrowed(normals)
    for p in range(len(points)):
        for k in range(count):
            shift = hashed(keys[p], 0, seed)
            u = sobol(first + k, 0, shift)
            v = sobol(first + k, 1, shift >> np.uint64(32))
            cosine_direction(u, v, normals[p], d)
            for c in range(3):
                lifted = (points[p, c] - centre[c]) * scale + lift * normals[p, c]
                origins[p * count + k, c] = lifted
                directions[p * count + k, c] = d[c]


@njit(cache=True, nogil=True)
def _sides(table, face, distance, origins, directions, centre, scale, sides):
    x, table = np.empty(3), borrowed(table)
    for r in range(len(face)):
        sides[r] = MISS
        if face[r] >= 0:
            for c in range(3):
                x[c] = centre[c] + (origins[r, c] + distance[r] * directions[r, c]) / scale
            dx, dy, dz = directions[r, 0], directions[r, 1], directions[r, 2]
            sides[r] = whole_side(table, face[r], x, dx, dy, dz)
    for r in range(len(face)):
        if sides[r] == CUT:
            for c in range(3):
                x[c] = centre[c] + (origins[r, c] + distance[r] * directions[r, c]) / scale
            sides[r] = cut_side(table, face[r], x, directions[r])


def look_out(
    visibility: Visibility,
    table: Table,
    points: np.ndarray,
    normals: np.ndarray,
    keys: np.ndarray,
    samples: range,
    seed: int,
):
    """Trace cosine-distributed rays from points and find what they meet.

    Parameters
    ----------
    points, normals : (k, 3) float64
        Scene units; unit normals on the side that looks out.
    keys : (k,) int
        What the sample pattern of a point is hashed from.
    samples : range
        Which points of the sequence to use, so that passes can be added up.

    Returns
    -------
    sides : (k, len(samples)) int
        2 * front (+ 1 for its back) of the patch met, -1 for none.
    hits : (k, len(samples), 3) float32
        Where, in ray coordinates.
    """
    count = len(samples)
    rays = rays_from(visibility, points, normals, keys, samples, seed)
    sides, hits = meet(visibility, table, *rays)
    return sides.reshape(-1, count), hits.reshape(-1, count, 3)


def rays_from(
    visibility: Visibility, points: np.ndarray, normals: np.ndarray, keys: np.ndarray,
    samples: range, seed: int,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return origins and directions of `look_out`'s rays (k len(samples), 3), ray coordinates."""
    origins = np.empty((len(points) * len(samples), 3), np.float32)
    directions = np.empty_like(origins)
    _aim(
        points, normals, keys, samples.start, len(samples), seed,
        visibility.centre, visibility.scale, LIFT, origins, directions,
    )  # fmt: skip
    return origins, directions


def meet(visibility: Visibility, table: Table, origins: np.ndarray, directions: np.ndarray):
    """Find the side of the patch that each ray meets first.

    Parameters
    ----------
    origins, directions : (k, 3) float32
        In ray coordinates; origins are overwritten by where the rays end.

    Returns
    -------
    sides : (k,) int
        2 * front (+ 1 for its back) of the patch met, -1 for none.
    hits : (k, 3) float32
        Where, in ray coordinates; the origin where nothing is met.
    """
    face, distance = visibility.first_hits(origins, directions)
    sides = np.empty(len(face), np.int64)
    _sides(
        table, face, distance, origins, directions, visibility.centre, visibility.scale, sides
    )
    distance[face < 0] = 0
    origins += distance[:, None] * directions
    return sides, origins
