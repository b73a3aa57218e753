"""Glossy reflection at a point: highlights of the area lights, and the surroundings in the lobe.

A light is found in two ways, by points on it and by directions in the lobe. Points are good for
small lights in wide lobes, directions for large lights in narrow ones; the balance heuristic of
Veach & Guibas (1995, "Optimally combining sampling techniques for Monte Carlo rendering") gives
each sample the share p/(p_1 + p_2) of its own density p per steradian.
"""

import math
from dataclasses import replace

import numpy as np
from numba import njit

from radiosity.light.frames import frame, to_local, to_scene
from radiosity.transport.highlights import area_of_polygon, blocked, evenly_on
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
    sampled = around.even is None and hasattr(lobe, "sample")
    if sampled:
        leaving = reflected_surroundings(around, lobe, *args)
    else:
        leaving = _evenly(around, lobe, view)
    for light in range(len(around.lights.polygons)):
        leaving += highlight(around, lobe, light, *args, shared=sampled)
    for lamp in around.lights.lamps:
        leaving += glint(around, lobe, lamp, points, normals, frames, view)
    for image in around.tracer.images if around.tracer is not None else ():
        seen = replace(around, visibility=image.senders.visibility, lights=image.lights)
        share = image.sees(points)[:, None] * image.share
        for lamp in image.lights.lamps:
            leaving += share * glint(seen, lobe, lamp, points, normals, frames, view)
    return leaving


def _evenly(around, lobe, view):
    """Return (k, bands) radiance of ambient light in a lobe; the seeds' raw forms reflect none."""
    if around.even is None or not hasattr(lobe, "albedo"):
        return np.zeros((len(view), around.lights.exitance.shape[1]))
    return lobe.albedo(np.clip(view[:, 0, 2], 0.0, 1.0)[:, None])[:, 0] * around.even


def glint(around, lobe, lamp, points, normals, frames, view):
    """Return (k, bands) radiance of an abstract light source in the lobe, f(L, V) E (E18)."""
    here = reaching(around.visibility, lamp, points, normals, around.lights.unit_m)
    return lobe.value(to_local(frames, here.to_light[:, None]), view)[:, 0] * here.irradiance


def dimming(coats: tuple, normals, to_view):
    """Return (k, bands) share 1 - a(theta_o) of a base's light that its coats let out to a viewer.

    Of light from everywhere they let 1 - a_mean in, which the equation of coated bases divides by
    again (`coat.coated_diffuse`): for that light it is all that is needed.
    """
    return _let_through(coats, np.einsum("pkc,pc->pk", to_view[:, None], normals))[:, 0]


def entering(around, coats: tuple, points, normals, keys, samples: range, seed: int):
    """Return (k, bands) irradiance by lights in W/m2 as a base under coats receives it.

    Of each polygon (1 - a(theta_i))/(1 - a_mean), the mean over points on it, weighted by what they
    would send without obstacles.
    """
    total, lights = np.zeros((len(points), around.lights.exitance.shape[1])), around.lights
    let = math.prod(1.0 - coat.mean_albedo for coat in coats)
    let = let.reshape(-1, let.shape[-1])  # one for all points, or one each
    for lamp in lights.lamps:
        here = reaching(around.visibility, lamp, points, normals, lights.unit_m)
        let_in = _let_through(coats, np.einsum("pkc,pc->pk", here.to_light[:, None], normals))
        total += here.irradiance * let_in[:, 0] / let
    for k in range(len(lights.polygons)):
        one = lights.only(k)
        direct = direct_irradiance(around.visibility, one, points, normals, keys, samples, seed)
        _, to_light, weight = _from_light(around, k, points, normals, keys, samples, seed)
        let_in = _let_through(coats, np.einsum("pkc,pc->pk", to_light, normals))
        whole = weight.sum(axis=1)
        share = np.einsum("pk,pkb->pb", weight, let_in) / np.where(whole > 0, whole, 1.0)[:, None]
        total += direct * np.where(whole[:, None] > 0, share / let, 1.0)
    return total


def _let_through(coats, cosine):
    """Return (..., bands) what coats let through to their base, one after the other."""
    return math.prod(1.0 - coat.albedo(np.clip(cosine, 0.0, 1.0)) for coat in coats)


def highlight(
    around, lobe, light, points, normals, frames, view, keys, samples, seed, shared=True
):
    """Return (k, bands) radiance of one area light in the lobe, by points on the light (E9).

    Mean over points of f(L, V) L_e cos(theta) cos(theta_l) A / r^2, where visible. ``shared`` with
    directions in the lobe that meet the light, see `reflected_surroundings`.
    """
    there, to_light, weight = _from_light(around, light, points, normals, keys, samples, seed)
    local = to_local(frames, to_light)
    value = lobe.value(local, view)
    if shared:
        cosine = np.where(weight > 0, local[..., 2], 1.0)
        weight = weight * (1.0 - _share(lobe.density(view, local) * weight / cosine))
    facing = around.lights.normals[light]
    weight *= ~_blocked(around, points, normals, there, facing, (weight > 0) & value.any(axis=2))
    return (value * weight[..., None]).mean(axis=1) * around.lights.exitance[light] / np.pi


def _from_light(around, light, points, normals, keys, samples, seed):
    """Return points on a light (k, n, 3), the directions to them and cos cos' A / r^2 (k, n).

    cos' A / r^2 is one over the density per steradian of these directions.
    """
    polygon, facing = around.lights.polygons[light], around.lights.normals[light]
    u = _squares(keys, 1000 + light, samples, seed)
    there = evenly_on(polygon, u)
    d = there - points[:, None]
    r2 = np.einsum("pkc,pkc->pk", d, d)
    to_light = d / np.sqrt(np.maximum(r2, 1e-300))[..., None]
    cosine = np.einsum("pkc,pc->pk", to_light, normals)
    cosine_light = -(to_light @ facing)
    useful = (cosine > 0) & (cosine_light > 0)
    spread = cosine * cosine_light * area_of_polygon(polygon) / np.maximum(r2, 1e-300)
    return there, to_light, np.where(useful, spread, 0.0)


def reflected_surroundings(
    around, lobe, points, normals, frames, view, keys, samples, seed, lights=True
):
    """Return (k, bands) radiance of the patches in the lobe, by directions in it (E9).

    Mean over the lobe's own directions of f L cos(theta)/density. With ``lights``, they add their
    share of the lights that they meet, see `highlight`.
    """
    light = lobe.sample(view, _squares(keys, 999, samples, seed))
    density, cosine = lobe.density(view, light), light[..., 2]
    useful = (cosine > 0) & (density > 0)
    share = np.where(useful, cosine / np.where(useful, density, 1.0), 0.0)
    weight = lobe.value(light, view) * share[..., None]
    visibility = around.visibility
    lifted = (points - visibility.centre) * visibility.scale + LIFT * normals
    origins = np.repeat(lifted, len(samples), axis=0).astype(np.float32)
    directions = to_scene(frames, light).reshape(-1, 3)
    ways = directions.astype(np.float32)
    sides, hits, exitance = sent_along(around, origins, ways, keys, samples, seed)
    if lights and len(around.lights.polygons):
        from_points = np.repeat(points, len(samples), axis=0)
        met = _met_lights(around, from_points, directions, sides, hits, density.ravel())
        exitance += met
    return (exitance.reshape(*cosine.shape, -1) * weight).mean(axis=1) / np.pi


def _met_lights(around, points, directions, sides, hits, density):
    """Return (k, bands) exitance of the lights that directions in a lobe meet, as they share it."""
    lights, table, visibility = around.lights, around.table, around.visibility
    number = np.full(len(table.face_normal), -1)
    number[lights.face] = np.arange(len(lights.face))
    light = np.where((sides >= 0) & (sides % 2 == 0), number[table.face[sides // 2]], -1)
    found = np.zeros((len(sides), lights.exitance.shape[1]))
    k = np.flatnonzero(light >= 0)
    d = visibility.centre + hits[k] / visibility.scale - points[k]
    area = np.array([area_of_polygon(polygon) for polygon in lights.polygons])[light[k]]
    cosine = -np.einsum("kc,kc->k", directions[k], lights.normals[light[k]])
    spread = np.maximum(cosine, 0.0) * area / np.maximum(np.einsum("kc,kc->k", d, d), 1e-300)
    by_lobe = density[k] * spread  # the density of directions over that of points
    found[k] = lights.exitance[light[k]] * _share(by_lobe)[:, None]
    return found


def _share(ratio):
    """Return the share of a sample whose density is ``ratio`` times that of the other way."""
    return ratio / (1.0 + ratio)


def _blocked(around, points, normals, there, facing, wanted):
    """Return (p, k) bool: whether the way to each point on the light is blocked."""
    found, (p, k) = np.zeros(wanted.shape, bool), np.nonzero(wanted)
    found[p, k] = blocked(around.visibility, points[p], normals[p], there[p, k], facing)
    return found
