"""Radiance's surfaces as convex facets: polygons, and round things cut into 24 sides."""

from collections.abc import Callable

import numpy as np

from radiosity.mesh.keyholes import has_seams, seamed_parts
from radiosity.mesh.triangulate import NoArea, convex_parts

SIDES = 24  # of a circle; a sphere has half as many rows
STEP = 2.0 * np.pi / SIDES


class ShapeError(ValueError):
    """Arguments that make no surface."""


def facets(kind: str, reals: tuple[float, ...], emits: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the facets (k, 4, 3) of a surface and normals at their corners, nan where it is flat.

    Parameters
    ----------
    kind : str
        polygon, sphere, bubble, cone, cup, cylinder, tube or ring.
    reals : tuple of float
        Its arguments.
    emits : bool
        Round things that emit are made as much larger as their facets lack in area, so that the
        flux is right; others have their corners where the surface is.

    Raises
    ------
    ShapeError
    NoArea
        All corners of a polygon lie on one line.
    """
    if kind == "polygon":
        return _polygon(reals)
    maker, count = MAKERS[kind]
    if len(reals) != count:
        raise ShapeError(f"needs {count} numbers, found {len(reals)}")
    quads, normals = maker(np.array(reals), emits)
    if kind in ("bubble", "cup", "tube"):
        return quads[:, TURNED], -normals[:, TURNED]
    return quads, normals


TURNED = [1, 0, 3, 2]  # the other way round, and triangles still repeat their last corner


def count_of(kind: str) -> int:
    """Return how many facets a surface has at most; polygons and suns count as one."""
    ball = SIDES * SIDES // 2
    return {"polygon": 1, "source": 1, "sphere": ball, "bubble": ball}.get(kind, SIDES)


def _flat(quads):
    return quads, np.full(quads.shape, np.nan)


def _polygon(reals):
    if len(reals) < 9 or len(reals) % 3:
        raise ShapeError(f"needs three numbers for each of at least 3 corners, found {len(reals)}")
    polygon = np.array(reals).reshape(-1, 3)
    if len(polygon) > 4 and has_seams(polygon):
        return _flat(seamed_parts(polygon))
    try:
        return _flat(polygon[convex_parts(polygon, flatness=np.inf)])
    except NoArea:
        raise
    except ValueError as error:
        raise ShapeError(str(error)) from None


def _sphere(reals, emits):
    """Latitudes and longitudes; the poles are on the z axis."""
    centre, radius = reals[:3], reals[3]
    if radius == 0.0:
        raise ShapeError("has the radius 0")
    polar, about = np.linspace(0.0, np.pi, SIDES // 2 + 1)[:, None], STEP * np.arange(SIDES + 1)
    up = np.broadcast_to(np.cos(polar), (len(polar), len(about)))
    out = np.stack([np.sin(polar) * np.cos(about), np.sin(polar) * np.sin(about), up], axis=2)
    out[:, -1], out[0], out[-1] = out[:, 0], [0, 0, 1], [0, 0, -1]
    a, b, c, d = out[:-1, :-1], out[1:, :-1], out[1:, 1:], out[:-1, 1:]
    unit = np.stack([a, b, c, d], axis=2)
    unit[0] = np.stack([b[0], c[0], a[0], a[0]], axis=1)
    unit[-1] = np.stack([a[-1], b[-1], d[-1], d[-1]], axis=1)
    unit = unit.reshape(-1, 4, 3)
    size = np.sqrt(4.0 * np.pi / _area(unit)) if emits else 1.0
    quads = centre + abs(radius) * size * unit
    return (quads, unit) if radius > 0 else (quads[:, TURNED], -unit[:, TURNED])


def _area(quads):
    return 0.5 * np.linalg.norm(
        np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]), axis=1
    ).sum()  # fmt: skip


def _cone(reals, emits):
    """Return a cone without its ends, whose radii follow its two end points."""
    start, end, radii = reals[:3], reals[3:6], reals[6:]
    axis = end - start
    length = np.linalg.norm(axis)
    if length == 0.0:
        raise ShapeError("has no length: its two ends are one point")
    if (radii < 0).any() or not radii.any():
        raise ShapeError("needs radii of at least 0, one of them more")
    radial = _circle(axis / length)
    size = _girth(radii, length) if emits else 1.0
    low, high = start + size * radii[0] * radial, end + size * radii[1] * radial
    normal = radial * length + (axis / length) * (radii[0] - radii[1])
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    here, there = slice(None, -1), slice(1, None)
    quads = np.stack([low[here], low[there], high[there], high[here]], axis=1)
    normals = np.stack([normal[k] for k in (here, there, there, here)], axis=1)
    if radii[1] == 0.0:
        quads, normals = quads[:, [0, 1, 2, 2]], normals[:, [0, 1, 2, 2]]
    elif radii[0] == 0.0:
        quads, normals = quads[:, [2, 3, 0, 0]], normals[:, [2, 3, 0, 0]]
    return quads, normals


def _girth(radii, length):
    """Return by how much radii must grow for the facets to have the area of the cone."""
    sine, difference = 2.0 * np.sin(STEP / 2.0), abs(radii[0] - radii[1])
    true, size = np.pi * np.hypot(length, difference), 1.0
    for _ in range(30):  # the mean of two steps, as single ones go to and fro where it is flat
        slant = np.hypot(length, size * difference * np.cos(STEP / 2.0))
        size = np.sqrt(size * true / (SIDES * sine / 2.0 * slant))
    return size


def _circle(axis):
    """Return unit vectors (SIDES + 1, 3) across an axis, the last one the first."""
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    one = np.cross(axis, helper)
    one /= np.linalg.norm(one)
    two = np.cross(axis, one)
    angle = STEP * np.append(np.arange(SIDES), 0)[:, None]
    return np.cos(angle) * one + np.sin(angle) * two


def _cylinder(reals, emits):
    return _cone(np.append(reals, reals[6]), emits)


def _ring(reals, emits):
    """Return a ring about a centre that looks along a direction."""
    centre, normal, radii = reals[:3], reals[3:6], np.sort(reals[6:])
    length = np.linalg.norm(normal)
    if length == 0.0:
        raise ShapeError("looks in the direction 0 0 0")
    if radii[0] < 0 or radii[0] == radii[1]:
        raise ShapeError("needs two different radii of at least 0")
    size = np.sqrt(STEP / np.sin(STEP)) if emits else 1.0
    radial = size * _circle(normal / length)
    outer = centre + radii[1] * radial
    if radii[0] == 0.0:
        middle = np.broadcast_to(centre, (SIDES // 2, 3))
        return _flat(np.stack([middle, outer[:-1:2], outer[1::2], outer[2::2]], axis=1))
    inner = centre + radii[0] * radial
    return _flat(np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1))


MAKERS: dict[str, tuple[Callable, int]] = {
    "sphere": (_sphere, 4), "bubble": (_sphere, 4), "cone": (_cone, 8), "cup": (_cone, 8),
    "cylinder": (_cylinder, 7), "tube": (_cylinder, 7), "ring": (_ring, 8),
}  # fmt: skip


def box(sizes: tuple[float, float, float], inward: bool) -> np.ndarray:
    """Return the faces (6, 4, 3) of a box from the origin to its sizes, as ``genbox`` has it."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * sizes
    order = [
        [0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3],
    ]  # fmt: skip
    quads = corners[np.array(order)]
    return quads[:, TURNED] if inward else quads
