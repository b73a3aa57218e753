"""Glossy reflection at a point: highlights of the area lights, and the surroundings in the lobe."""

import numpy as np
from numba import njit

from radiosity.light.reflection import phong
from radiosity.scene.model import Phong
from radiosity.transport.hemisphere import meet
from radiosity.transport.irradiance import Surroundings, carried
from radiosity.transport.sampling import hashed, sobol
from radiosity.transport.visibility import LIFT


@njit(cache=True, nogil=True)
def _pattern(keys, salt, first, count, seed, u):
    for p in range(len(keys)):
        shift = hashed(keys[p], salt, seed)
        for k in range(count):
            u[p, k, 0] = sobol(first + k, 0, shift)
            u[p, k, 1] = sobol(first + k, 1, shift >> np.uint64(32))


def _squares(keys, salt, samples, seed):
    u = np.empty((len(keys), len(samples), 2))
    _pattern(keys, salt, samples.start, len(samples), seed, u)
    return u


def glossy_radiance(
    around: Surroundings, lobe: Phong, points, normals, to_view, keys, samples: range, seed: int
):
    """Return (k, bands) radiance that a lobe reflects towards the viewer, W/(m2 sr).

    Parameters
    ----------
    points, normals, to_view : (k, 3) float64
        Scene units and unit vectors.
    samples : range
        Which points of each light's and of the lobe's sequence to use.
    """
    args = points, normals, to_view, keys, samples, seed
    leaving = reflected_surroundings(around, lobe, *args)
    for light in range(len(around.lights.polygons)):
        leaving += highlight(around, lobe, light, *args)
    return leaving


def highlight(around, lobe, light, points, normals, to_view, keys, samples, seed):
    """Return (k, bands) radiance of one area light in the lobe, by points on the light (E9).

    Mean over points of f(L, V) L_e cos(theta) cos(theta_l) A / r^2, where visible.
    """
    polygon, facing = around.lights.polygons[light], around.lights.normals[light]
    u = _squares(keys, 1000 + light, samples, seed)
    there, stretch = _on_polygon(polygon, u)
    d = there - points[:, None]
    r2 = np.einsum("pkc,pkc->pk", d, d)
    to_light = d / np.sqrt(r2)[..., None]
    cosine = np.einsum("pkc,pc->pk", to_light, normals)
    cosine_light = -(to_light @ facing)
    useful = (cosine > 0) & (cosine_light > 0)
    value = phong(lobe.reflectance, lobe.exponent, normals[:, None], to_light, to_view[:, None])
    weight = np.where(useful, cosine * cosine_light * stretch / np.maximum(r2, 1e-300), 0.0)
    weight *= ~_blocked(around, points, normals, there, facing, useful & value.any(axis=2))
    return (value * weight[..., None]).mean(axis=1) * around.lights.exitance[light] / np.pi


def reflected_surroundings(around, lobe, points, normals, to_view, keys, samples, seed):
    """Return (k, bands) radiance of the patches in the lobe, by directions in it (E9).

    Directions have the density (n + 1)/(2 pi) cos^n about the mirror direction of the view.
    """
    n = lobe.exponent
    u = _squares(keys, 999, samples, seed)
    cos_alpha = u[..., 0] ** (1.0 / (n + 1.0))
    mirror = 2 * np.einsum("pc,pc->p", normals, to_view)[:, None] * normals - to_view
    d = _about(mirror, cos_alpha, 2 * np.pi * u[..., 1])
    cosine = np.maximum(np.einsum("pkc,pc->pk", d, normals), 0.0)
    visibility = around.visibility
    lifted = (points - visibility.centre) * visibility.scale + LIFT * normals
    origins = np.repeat(lifted, len(samples), axis=0).astype(np.float32)
    sides, hits = meet(
        visibility, around.table, origins, d.reshape(-1, 3).astype(np.float32)
    )
    exitance = carried(around, sides, hits).reshape(*cosine.shape, -1)
    mean = (exitance * cosine[..., None]).mean(axis=1) / np.pi
    return lobe.reflectance * (n + 2.0) / (n + 1.0) * mean


def _on_polygon(v, u):
    """Return points at (s, t) of a bilinear polygon and the area stretch there."""
    s, t = u[..., :1], u[..., 1:]
    x = (1 - s) * (1 - t) * v[0] + s * (1 - t) * v[1] + s * t * v[2] + (1 - s) * t * v[3]
    ds = (1 - t) * (v[1] - v[0]) + t * (v[2] - v[3])
    dt = (1 - s) * (v[3] - v[0]) + s * (v[2] - v[1])
    return x, np.linalg.norm(np.cross(ds, dt), axis=-1)


def _about(axis, cos_alpha, phi):
    """Return unit vectors at an angle alpha and azimuth phi (p, k) about axes (p, 3)."""
    sign = np.copysign(1.0, axis[:, 2])
    a = -1.0 / (sign + axis[:, 2])
    b = axis[:, 0] * axis[:, 1] * a
    one = np.stack([1 + sign * axis[:, 0] ** 2 * a, sign * b, -sign * axis[:, 0]], axis=1)
    two = np.stack([b, sign + axis[:, 1] ** 2 * a, -axis[:, 1]], axis=1)
    sine = np.sqrt(np.maximum(0.0, 1 - cos_alpha**2))
    parts = (sine * np.cos(phi), one), (sine * np.sin(phi), two), (cos_alpha, axis)
    return sum(w[..., None] * v[:, None] for w, v in parts)


def _blocked(around, points, normals, there, facing, wanted):
    """Return (p, k) bool: whether the way to each point on the light is blocked."""
    visibility = around.visibility
    blocked = np.zeros(wanted.shape, bool)
    p, k = np.nonzero(wanted)
    if not len(p):
        return blocked
    start = (points[p] - visibility.centre) * visibility.scale + LIFT * normals[p]
    end = (there[p, k] - visibility.centre) * visibility.scale + LIFT * facing
    blocked[p, k] = visibility.blocked(start.astype(np.float32), (end - start).astype(np.float32))
    return blocked
