"""Light that lobes send on straight from lights, by points on these: highlights (E9).

Rays that a lobe chose may meet a light as well. Both are told by the balance heuristic: an answer
found with the density p counts p/(p + q), q that of the other way to find it (Veach & Guibas 1995).
"""

import numpy as np

from radiosity.light.frames import frame, to_local
from radiosity.transport.irradiance import Lights
from radiosity.transport.lamps import reaching
from radiosity.transport.paths import Bundle, Space, squares
from radiosity.transport.visibility import LIFT


def in_lobes(
    space: Space, lights: Lights, ends: Bundle, keys: np.ndarray, index: np.ndarray, bounce: int,
    seed: int,
) -> np.ndarray:  # fmt: skip
    """Return (k, bands) the radiance of highlights that rays see where they end, W/(m2 sr).

    Abstract sources exactly, of each polygon one point, counted by the balance heuristic.

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
        here = space, lights, side.lobe, points[mine], normals[mine], frames, view
        which = k[mine]
        for lamp in lights.lamps:
            found[which] += _of_lamp(*here, lamp)
        for light in range(len(lights.polygons)):
            u = squares(keys[which], index[which], bounce, seed, 1 + light)
            found[which] += _of_polygon(*here, light, u)
    return found


def _of_lamp(space, lights, lobe, points, normals, frames, view, lamp):
    here = reaching(space.visibility, lamp, points, normals, lights.unit_m)
    return lobe.value(to_local(frames, here.to_light), view) * here.irradiance


def _of_polygon(space, lights, lobe, points, normals, frames, view, light, u):
    """Return f L_e cos cos' A/r^2, where visible, times the share that counts of it."""
    there, stretch, whole = on_polygon(lights.polygons[light], u)
    d = there - points
    r2 = np.maximum(np.einsum("kc,kc->k", d, d), 1e-300)
    to_light = d / np.sqrt(r2)[:, None]
    cosine = np.einsum("kc,kc->k", to_light, normals)
    cosine_there = -(to_light @ lights.normals[light])
    local = to_local(frames, to_light)
    value = lobe.value(local, view)
    found = np.zeros_like(value)
    k = np.flatnonzero((cosine > 0) & (cosine_there > 0) & value.any(axis=1))
    k = k[_seen(space.visibility, points[k], normals[k], there[k], lights.normals[light])]
    if len(k):
        by_light = r2[k] / (cosine_there[k] * whole)
        share = by_light / (by_light + lobe.density(view[k], local[k]))
        weight = cosine[k] * cosine_there[k] * stretch[k] / r2[k] * share
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


def on_polygon(v: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return points (k, 3) at (s, t) of a bilinear polygon, the stretch there, and its area."""
    s, t = u[..., :1], u[..., 1:]
    x = (1 - s) * (1 - t) * v[0] + s * (1 - t) * v[1] + s * t * v[2] + (1 - s) * t * v[3]
    ds = (1 - t) * (v[1] - v[0]) + t * (v[2] - v[3])
    dt = (1 - s) * (v[3] - v[0]) + s * (v[2] - v[1])
    whole = 0.5 * np.linalg.norm(np.cross(v[2] - v[0], v[3] - v[1]))
    return x, np.linalg.norm(np.cross(ds, dt), axis=-1), whole


def _seen(visibility, points, normals, there, facing):
    """Return (k,) bool: whether nothing lies between points and points of a light."""
    if not len(points):
        return np.zeros(0, bool)
    start = (points - visibility.centre) * visibility.scale + LIFT * normals
    end = (there - visibility.centre) * visibility.scale + LIFT * facing
    return ~visibility.blocked(start.astype(np.float32), (end - start).astype(np.float32))
