"""Closed-form cases of curved bodies, meshed at two sizes: the error and its order."""

from collections.abc import Iterator

import numpy as np

from radiosity.analytic import load_cases
from radiosity.solve.cases import Check, element_factor, faces_of, timed
from radiosity.solve.matrix import form_factors

ACCURACY = 1e-3  # asked of the factors; met with a margin, so that the error is the mesh's
ORDER, SLACK = 2.0, 0.25  # chords differ from arcs by O(1/n^2); two meshes tell the order so well


def curved() -> Iterator[Check]:
    """Disks, spheres, cylinders and cones: the error of the finer of two meshes, and its order.

    A second line tells the order between both; more than expected is no error.
    """
    for case in load_cases("vf_curved"):
        compute, n, bound = SHAPES[case["geometry"]["type"]]
        coarse = _meshed(case, compute, n, bound)
        fine = _meshed(case, compute, 2 * n, bound)
        yield fine
        order = float(np.log2(coarse.error / fine.error)) if fine.error > 0 else np.inf
        yield Check(
            "curved", f"{case['id']} order", ORDER, order, max(0.0, ORDER - order), SLACK,
            coarse.seconds, relative=False,
        )  # fmt: skip


def _meshed(case, compute, n, bound) -> Check:
    return timed(
        "curved", f"{case['id']} n = {n}", case["value"], bound,
        lambda: compute(case["geometry"], n),
    )  # fmt: skip


def revolved(profile, n: int) -> np.ndarray:
    """Return the surface of revolution of a profile about z as flat faces.

    Parameters
    ----------
    profile : (k, 2) float
        Radius and height of the points of a polyline; the front lies to the right of its way
        (walking up a wall: away from the axis).
    n : int
        Faces around. Their corners lie on the surface, so areas fall short by 1 - O(1/n^2).

    Returns
    -------
    ((k - 1) n, 4, 3) float64
        Counter-clockwise seen from the front; a triangle repeats its last vertex.
    """
    radius, height = np.asarray(profile, float).T
    angle = 2 * np.pi * np.arange(n + 1) / n
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ring[-1] = ring[0]
    flat = radius[:, None, None] * ring
    x = np.concatenate([flat, np.broadcast_to(height[:, None, None], (*flat.shape[:2], 1))], axis=2)
    faces = np.stack([x[:-1, :-1], x[:-1, 1:], x[1:, 1:], x[1:, :-1]], axis=2)
    faces[radius[1:] == 0] = faces[radius[1:] == 0][:, :, [0, 1, 2, 2]]
    faces[radius[:-1] == 0] = faces[radius[:-1] == 0][:, :, [0, 2, 3, 3]]
    return faces.reshape(-1, 4, 3)


def disk(radius: float, height: float, n: int, up: bool = True) -> np.ndarray:
    """Return a disk of n triangles about the axis z that faces up or down."""
    profile = [(radius, height), (0, height)]
    return revolved(profile if up else profile[::-1], n)


def sphere(radius: float, n: int, inward: bool = False, height: float = 0.0) -> np.ndarray:
    """Return a sphere of n bands and 2 n faces around each."""
    polar = np.linspace(-np.pi / 2, np.pi / 2, n + 1)
    r, z = radius * np.cos(polar), height + radius * np.sin(polar)
    r[[0, -1]] = 0.0
    profile = np.stack([r, z], axis=1)
    return revolved(profile[::-1] if inward else profile, 2 * n)


def between(*parts, obstructions=None) -> np.ndarray:
    """Return the factors between surfaces, each given as its faces (k, 4, 3)."""
    blocking = None if obstructions is None else faces_of(obstructions)
    faces = faces_of(*parts)
    factors = form_factors(faces, ACCURACY, obstructions=blocking, repair=False)
    return factors.grouped(faces.group, len(parts)).toarray()


def _coaxial_disks(g, n):
    return between(disk(g["r1"], 0, n), disk(g["r2"], g["h"], n, up=False))[0, 1]


def _element_disk_parallel(g, n):
    return element_factor([g["a"], 0, 0], [0, 0, 1], disk(g["r"], g["h"], n, up=False))


def _element_disk_perp(g, n):
    return element_factor([g["a"], 0, 0], [-1, 0, 0], disk(g["r"], g["h"], n, up=False))


def _element_sphere(g, n):
    tilt = np.radians(g["theta_deg"])
    point = np.array([-g["d"], 0, 0])
    faces = sphere(g["r"], n)
    outward = faces_of(faces).normals()
    seen = np.einsum("kc,kc->k", outward, point - faces[:, 0]) > 0
    return element_factor(point, [np.cos(tilt), 0, np.sin(tilt)], faces[seen])


def _sphere_disk(g, n):
    return between(sphere(0.5 * g["h"], n), disk(g["r"], g["h"], 2 * n, up=False))[0, 1]


def _sphere_rect(g, n):
    a, b, h = g["a"], g["b"], g["h"]
    rectangle = np.array([[[0, 0, h], [0, b, h], [a, b, h], [a, 0, h]]], float)
    return between(sphere(0.5 * h, n), rectangle)[0, 1]


def _cylinder_interior(g, n):
    r, h = g["r"], g["h"]
    f = between(revolved([(r, h), (r, 0)], n), disk(r, 0, n), disk(r, h, n, up=False))
    return np.array([f[0, 0], f[1, 0], f[1, 2]])


def _concentric_cylinders(g, n):
    r, s, h = g["r_inner"], g["r_outer"], g["h"]
    inner, outer = revolved([(r, 0), (r, h)], n), revolved([(s, h), (s, 0)], n)
    floor, ceiling = revolved([(s, 0), (r, 0)], n), revolved([(r, h), (s, h)], n)
    f = between(inner, outer, floor, ceiling)
    return np.array([f[1, 0], f[1, 1], f[0, 1], f[1, 2], f[0, 2]])


def _cone_interior(g, n):
    return between(revolved([(0, g["h"]), (g["r"], 0)], n), disk(g["r"], 0, n))[0]


def _frustum_interior(g, n):
    r, s, h = g["r1"], g["r2"], g["h"]
    f = between(revolved([(s, h), (r, 0)], n), disk(r, 0, n), disk(s, h, n, up=False))
    return np.array([f[0, 0], f[1, 0], f[2, 0], f[1, 2]])


def _hemisphere(g, n):
    upper = sphere(g["r"], n, inward=True).reshape(n, -1, 4, 3)[: n // 2].reshape(-1, 4, 3)
    f = between(upper, disk(g["r"], 0, 2 * n))
    return np.array([f[0, 0], f[0, 1], f[1, 0]])


def _concentric_spheres(g, n):
    f = between(sphere(g["r1"], n), sphere(g["r2"], 4 * n // 3, inward=True))
    return np.array([f[0, 1], f[1, 0], f[1, 1]])


def _disk_ring(g, n):
    ring = revolved([(g["ri"], g["h"]), (g["ro"], g["h"])], n)
    return between(disk(g["r1"], 0, n), ring)[0, 1]


def _disk_blocker(g, n):
    rows = disk(g["R"], 0, n), disk(g["R"], g["d"], n, up=False)
    return between(*rows, obstructions=disk(g["b"], 0.5 * g["d"], n))[0, 1]


# How many faces the coarser mesh has around (spheres: bands), and the bound of the relative error
# of the finer one, which has twice as many.
SHAPES = {
    "coaxial_disks": (_coaxial_disks, 32, 1e-3),
    "element_disk_parallel": (_element_disk_parallel, 32, 3e-3),
    "element_disk_perp": (_element_disk_perp, 32, 3e-3),
    "sphere_disk": (_sphere_disk, 8, 1e-2),
    "sphere_rect": (_sphere_rect, 8, 1e-3),
    "element_sphere": (_element_sphere, 32, 3e-3),
    "cylinder_interior": (_cylinder_interior, 32, 3e-3),
    "concentric_cylinders": (_concentric_cylinders, 12, 3e-2),
    "cone_interior": (_cone_interior, 32, 3e-3),
    "frustum_interior": (_frustum_interior, 32, 3e-3),
    "hemisphere": (_hemisphere, 8, 1e-2),
    "concentric_spheres": (_concentric_spheres, 3, 3e-2),
    "disk_ring": (_disk_ring, 32, 1e-5),
    "disk_blocker": (_disk_blocker, 8, 3e-2),
}
