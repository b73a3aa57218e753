"""Glossy reflection at a point: highlights of the area lights, and the surroundings in the lobe."""

import numpy as np
from numba import njit

from radiosity.light.frames import frame, to_local, to_scene
from radiosity.transport.irradiance import Surroundings, direct_irradiance, sent_along
from radiosity.transport.lamps import reaching
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
    around: Surroundings, lobe, points, normals, to_view, keys, samples: range, seed: int
):
    """Return (k, bands) radiance that a lobe reflects towards the viewer, W/(m2 sr).

    Parameters
    ----------
    lobe : object
        See `radiosity.light.reflection`.
    points, normals, to_view : (k, 3) float64
        Scene units and unit vectors.
    samples : range
        Which points of each light's and of the lobe's sequence to use.
    """
    frames = frame(normals)[:, None]
    view = to_local(frames, to_view[:, None])
    args = points, normals, frames, view, keys, samples, seed
    leaving = reflected_surroundings(around, lobe, *args)
    for light in range(len(around.lights.polygons)):
        leaving += highlight(around, lobe, light, *args)
    for lamp in around.lights.lamps:
        leaving += glint(around, lobe, lamp, points, normals, frames, view)
    return leaving


def glint(around, lobe, lamp, points, normals, frames, view):
    """Return (k, bands) radiance of an abstract light source in the lobe, f(L, V) E (E18)."""
    here = reaching(around.visibility, lamp, points, normals, around.lights.unit_m)
    return lobe.value(to_local(frames, here.to_light[:, None]), view)[:, 0] * here.irradiance


def dimming(coats: tuple, normals, to_view):
    """Return (k, bands) share 1 - a(theta_o) of a base's light that its coats let out to a viewer.

    Of light from everywhere they let 1 - a_mean in, which the equation of coated bases divides by
    again (`coat.coated_diffuse`): for that light it is all that is needed.
    """
    return 1.0 - _albedo(coats, np.einsum("pkc,pc->pk", to_view[:, None], normals))[:, 0]


def entering(around, coats: tuple, points, normals, keys, samples: range, seed: int):
    """Return (k, bands) irradiance by lights in W/m2 as a base under coats receives it.

    Of each polygon (1 - a(theta_i))/(1 - a_mean), the mean over points on it, weighted by what they
    would send without obstacles.
    """
    total, lights = np.zeros((len(points), around.lights.exitance.shape[1])), around.lights
    mean = sum(coat.mean_albedo for coat in coats)
    mean = mean.reshape(-1, mean.shape[-1])  # one for all points, or one each
    for lamp in lights.lamps:
        here = reaching(around.visibility, lamp, points, normals, lights.unit_m)
        let_in = 1.0 - _albedo(coats, np.einsum("pkc,pc->pk", here.to_light[:, None], normals))
        total += here.irradiance * let_in[:, 0] / (1.0 - mean)
    for k in range(len(lights.polygons)):
        one = lights.only(k)
        direct = direct_irradiance(around.visibility, one, points, normals, keys, samples, seed)
        _, to_light, weight = _from_light(around, k, points, normals, keys, samples, seed)
        let_in = 1.0 - _albedo(coats, np.einsum("pkc,pc->pk", to_light, normals))
        whole = weight.sum(axis=1)
        share = np.einsum("pk,pkb->pb", weight, let_in) / np.where(whole > 0, whole, 1.0)[:, None]
        total += direct * np.where(whole[:, None] > 0, share / (1.0 - mean), 1.0)
    return total


def _albedo(coats, cosine):
    return sum(coat.albedo(np.clip(cosine, 0.0, 1.0)) for coat in coats)


def highlight(around, lobe, light, points, normals, frames, view, keys, samples, seed):
    """Return (k, bands) radiance of one area light in the lobe, by points on the light (E9).

    Mean over points of f(L, V) L_e cos(theta) cos(theta_l) A / r^2, where visible.
    """
    there, to_light, weight = _from_light(around, light, points, normals, keys, samples, seed)
    value = lobe.value(to_local(frames, to_light), view)
    facing = around.lights.normals[light]
    weight *= ~_blocked(around, points, normals, there, facing, (weight > 0) & value.any(axis=2))
    return (value * weight[..., None]).mean(axis=1) * around.lights.exitance[light] / np.pi


def _from_light(around, light, points, normals, keys, samples, seed):
    """Return points on a light (k, n, 3), the directions to them and cos cos' A / r^2 (k, n)."""
    polygon, facing = around.lights.polygons[light], around.lights.normals[light]
    there, stretch = _on_polygon(polygon, _squares(keys, 1000 + light, samples, seed))
    d = there - points[:, None]
    r2 = np.einsum("pkc,pkc->pk", d, d)
    to_light = d / np.sqrt(r2)[..., None]
    cosine = np.einsum("pkc,pc->pk", to_light, normals)
    cosine_light = -(to_light @ facing)
    useful = (cosine > 0) & (cosine_light > 0)
    weight = np.where(useful, cosine * cosine_light * stretch / np.maximum(r2, 1e-300), 0.0)
    return there, to_light, weight


def reflected_surroundings(around, lobe, points, normals, frames, view, keys, samples, seed):
    """Return (k, bands) radiance of the patches in the lobe, by directions in it (E9).

    Mean over the lobe's own directions of f L cos(theta)/density.
    """
    if around.even is not None:
        albedo = getattr(lobe, "albedo", None)  # the seeds' raw forms have none
        return albedo(np.clip(view[:, 0, 2:], 0.0, 1.0))[:, 0] * around.even if albedo else 0.0
    light = lobe.sample(view, _squares(keys, 999, samples, seed))
    density, cosine = lobe.density(view, light), light[..., 2]
    useful = (cosine > 0) & (density > 0)
    share = np.where(useful, cosine / np.where(useful, density, 1.0), 0.0)
    weight = lobe.value(light, view) * share[..., None]
    visibility = around.visibility
    lifted = (points - visibility.centre) * visibility.scale + LIFT * normals
    origins = np.repeat(lifted, len(samples), axis=0).astype(np.float32)
    directions = to_scene(frames, light).reshape(-1, 3).astype(np.float32)
    _, exitance = sent_along(around, origins, directions, keys, samples, seed)
    exitance = exitance.reshape(*cosine.shape, -1)
    return (exitance * weight).mean(axis=1) / np.pi


def _on_polygon(v, u):
    """Return points at (s, t) of a bilinear polygon and the area stretch there."""
    s, t = u[..., :1], u[..., 1:]
    x = (1 - s) * (1 - t) * v[0] + s * (1 - t) * v[1] + s * t * v[2] + (1 - s) * t * v[3]
    ds = (1 - t) * (v[1] - v[0]) + t * (v[2] - v[3])
    dt = (1 - s) * (v[3] - v[0]) + s * (v[2] - v[1])
    return x, np.linalg.norm(np.cross(ds, dt), axis=-1)


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
