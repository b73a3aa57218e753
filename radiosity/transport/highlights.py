"""Light that lobes send on straight from lights, by points on these: highlights (E9).

Rays that a lobe chose may meet a light as well. Both are told by the balance heuristic: an answer
found with the density p counts p/(p + q), q that of the other way to find it (Veach & Guibas 1995).
"""

import numpy as np
from numba import njit

from radiosity.light.frames import frame, to_local
from radiosity.transport.borrow import borrowed
from radiosity.transport.images import Image
from radiosity.transport.irradiance import Lights
from radiosity.transport.lamps import reaching
from radiosity.transport.paths import Bundle, Space, squares
from radiosity.transport.polygon import first_half, place_evenly
from radiosity.transport.visibility import LIFT, Visibility


def in_lobes(
    space: Space, lights: Lights, ends: Bundle, keys: np.ndarray, index: np.ndarray, bounce: int,
    seed: int, images: tuple[Image, ...] = (),
) -> np.ndarray:  # fmt: skip
    """Return (k, bands) the radiance of highlights that rays see where they end, W/(m2 sr).

    Abstract sources exactly, also in planar mirrors, of which there are ``images``; of each polygon
    one point, counted by the balance heuristic.

    Parameters
    ----------
    keys, index, bounce : (k,), (k,), int
        Of the rays, see `squares`.
    """
    found = np.zeros_like(ends.share)
    k = np.flatnonzero(space.sends_on(ends.sides))
    if not len(k) or not lights:
        return found
    face, back = space.faces(ends.sides[k]), ends.sides[k] % 2
    points = space.points(ends.hits[k].astype(np.float64))
    normals = space.optics.facing(face, back == 1, points)
    for side, _, _, mine in space.optics.groups(face, back):
        if side.lobe is None:
            continue
        frames = frame(normals[mine])
        view = to_local(frames, -ends.directions[k[mine]].astype(np.float64))
        here = side.lobe, points[mine], normals[mine], frames, view
        which = k[mine]
        for lamp in lights.lamps:
            found[which] += _of_lamp(space.visibility, lights, *here, lamp)
        for image in images:
            for lamp in image.lights.lamps:
                seen = _of_lamp(image.senders.visibility, image.lights, *here, lamp)
                found[which] += image.sees(points[mine])[:, None] * image.share * seen
        for light in range(len(lights.polygons)):
            u = squares(keys[which], index[which], bounce, seed, 1 + light)
            found[which] += _of_polygon(space, lights, *here, light, u)
    return found


def _of_lamp(visibility, lights, lobe, points, normals, frames, view, lamp):
    here = reaching(visibility, lamp, points, normals, lights.unit_m)
    return lobe.value(to_local(frames, here.to_light), view) * here.irradiance


def _of_polygon(space, lights, lobe, points, normals, frames, view, light, u):
    """Return f L_e cos cos' A/r^2, where visible, times the share that counts of it."""
    polygon = lights.polygons[light]
    there, whole = evenly_on(polygon, u), area_of_polygon(polygon)
    d = there - points
    r2 = np.maximum(np.einsum("kc,kc->k", d, d), 1e-300)
    to_light = d / np.sqrt(r2)[:, None]
    cosine = np.einsum("kc,kc->k", to_light, normals)
    cosine_there = -(to_light @ lights.normals[light])
    local = to_local(frames, to_light)
    value = lobe.value(local, view)
    found = np.zeros_like(value)
    k = np.flatnonzero((cosine > 0) & (cosine_there > 0) & value.any(axis=1))
    facing = lights.normals[light]
    k = k[~blocked(space.visibility, points[k], normals[k], there[k], facing)]
    if len(k):
        by_light = r2[k] / (cosine_there[k] * whole)
        share = by_light / (by_light + lobe.density(view[k], local[k]))
        weight = cosine[k] * cosine_there[k] * whole / r2[k] * share
        found[k] = value[k] * weight[:, None] * (lights.exitance[light] / np.pi)
    return found


def counted(space: Space, ends: Bundle, areas: np.ndarray) -> np.ndarray:
    """Return (k,) the share that counts of lights of areas (f,) that rays met which lobes chose.

    1 where nothing looks for a light by itself, as beyond mirrors.
    """
    share = np.ones(len(ends.sides))
    k = np.flatnonzero((ends.sides >= 0) & np.isfinite(ends.density))
    face = space.faces(ends.sides[k])
    k, face = k[areas[face] > 0], face[areas[face] > 0]
    cosine = np.abs(np.einsum("kc,kc->k", ends.directions[k], space.optics.normal[face]))
    r2 = (ends.way[k] / space.visibility.scale) ** 2
    by_light = r2 / np.maximum(cosine * areas[face], 1e-300)
    share[k] = ends.density[k] / (ends.density[k] + by_light)
    return share


def evenly_on(polygon: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return points (..., 3) even over a polygon (4, 3), of points u (..., 2) of a square."""
    u = np.ascontiguousarray(u)
    found = np.empty((u.size // 2, 3))
    _place(polygon, u.reshape(-1, 2), found)
    return found.reshape(*u.shape[:-1], 3)


@njit(cache=True, nogil=True)
def _place(polygon, u, x):
    polygon = borrowed(polygon)
    half = first_half(polygon)
    for k in range(len(u)):
        place_evenly(polygon, half, u[k, 0], u[k, 1], x[k])


def area_of_polygon(v: np.ndarray) -> float:
    """Return the area of a convex quadrilateral (4, 3)."""
    return float(np.linalg.norm(np.cross(v[2] - v[0], v[3] - v[1])) / 2.0)


def blocked(visibility: Visibility, points, normals, there, facing) -> np.ndarray:
    """Return (k,) bool: whether anything lies between points and points of a light (k, 3)."""
    if not len(points):
        return np.zeros(0, bool)
    start = (points - visibility.centre) * visibility.scale + LIFT * normals
    end = (there - visibility.centre) * visibility.scale + LIFT * facing
    return visibility.blocked(start.astype(np.float32), (end - start).astype(np.float32))
