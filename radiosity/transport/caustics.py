"""Caustics of abstract sources: their light followed through mirrors and clear bodies (E24).

No ray from a point ever meets a source without extent, so rays are aimed from the source at what
mirrors or lets light through, and followed to where they end. On an element their power over its
area is the mean irradiance; at a point it is that of the rays that cross a small disc there.
What lobes send on is found from the other end (`highlights`), as are planar mirrors (`images`).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from radiosity.light.sources import Light
from radiosity.transport.aiming import Targets, aimed_rays
from radiosity.transport.borrow import borrowed
from radiosity.transport.hemisphere import meet
from radiosity.transport.paths import DEEP, Bundle, Space, first_rays, follow
from radiosity.transport.sampling import hashed, sobol
from radiosity.transport.threads import over_ranges

FEWEST, MOST = 1 << 16, 1 << 20  # rays from each source
KEY = 1 << 49
DISC = 0.02  # radius of a disc for the fewest rays, to the root of all area
# Of n rays of even patterns in a disc, that many by chance more or less: SPREAD n^(1/4).
SPREAD = 0.5
BEGIN = 4.0  # lengths of the scene that parallel rays start away from it
POINTS_AT_ONCE = 256


@dataclass(frozen=True)
class Caustics:
    """Last parts of the ways of rays from sources, after some mirror or clear surface.

    Attributes
    ----------
    begin, end : (k, 3) float64
        Scene units.
    sides : (k,) int
        2 * front (+ 1 for its back) of the patch where each ends, -1 for none.
    power : (k, bands) float64
        W.
    radius : float
        Of the discs that tell irradiance at points, scene units.
    unit_m : float
        Metres a scene unit.
    """

    begin: np.ndarray
    end: np.ndarray
    sides: np.ndarray
    power: np.ndarray
    radius: float
    unit_m: float

    def on(self, element: np.ndarray, area: np.ndarray) -> np.ndarray:
        """Return (n, bands) the mean irradiance of elements of areas (n,), W/m2.

        ``element`` (2 * fronts,) is that of each side, -1 for none.
        """
        owner = np.where(self.sides >= 0, element[self.sides], -1)
        k = np.flatnonzero(owner >= 0)
        found = np.zeros((len(area), self.power.shape[1]))
        np.add.at(found, owner[k], self.power[k])
        return found / (area * self.unit_m**2)[:, None]

    def at(self, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (k, bands) the irradiance at points of unit normals, W/m2, and its error."""
        found, square = np.zeros((2, len(points), self.power.shape[1]))
        area = math.pi * (self.radius * self.unit_m) ** 2

        def work(a, b):
            _crossing(
                points[a:b], normals[a:b], self.begin, self.end, self.power, self.radius,
                found[a:b], square[a:b],
            )  # fmt: skip

        if len(self.power):
            over_ranges(work, len(points), POINTS_AT_ONCE)
        count = found**2 / np.where(square > 0.0, square, 1.0)
        return found / area, SPREAD * found / area * np.maximum(count, 1.0) ** -0.75

    def near(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Return (k, bands) the irradiance at points of surfaces, W/m2, by the rays that end there.

        *Jensen (1996)*. What `at` does, for very many points.
        """
        found = np.zeros((len(points), self.power.shape[1]))
        if len(self.power):
            _ending(points, normals, *self._cells, self.radius, found)
        return found / (math.pi * (self.radius * self.unit_m) ** 2)

    @cached_property
    def _cells(self):
        """The ends that lie on surfaces, sorted by cells as large as a disc's radius."""
        k = np.flatnonzero(self.sides >= 0)
        low = self.end[k].min(axis=0, initial=np.inf)
        cell = np.floor((self.end[k] - low) / self.radius).astype(np.int64) + 1
        shape = cell.max(axis=0, initial=0) + 2
        number = (cell[:, 0] * shape[1] + cell[:, 1]) * shape[2] + cell[:, 2]
        order = np.argsort(number, kind="stable")
        way = self.end[k] - self.begin[k]
        k = k[order]
        return self.end[k], way[order], self.power[k], number[order], low, shape


@njit(cache=True, nogil=True, error_model="numpy")
def _ending(points, normals, end, way, power, number, low, shape, radius, found):
    """Add the power of rays that end within a radius of points, and come from their fronts."""
    points, normals, end, way = borrowed((points, normals, end, way))
    cell = np.empty(3, np.int64)
    for p in range(len(points)):
        x, n, inside = points[p], normals[p], True
        for c in range(3):
            cell[c] = math.floor((x[c] - low[c]) / radius) + 1
            inside = inside and 1 <= cell[c] + 1 and cell[c] - 1 < shape[c]
        if not inside:
            continue
        for i in range(max(cell[0] - 1, 0), min(cell[0] + 2, shape[0])):
            for j in range(max(cell[1] - 1, 0), min(cell[1] + 2, shape[1])):
                row = (i * shape[1] + j) * shape[2]
                first = np.searchsorted(number, row + max(cell[2] - 1, 0))
                last = np.searchsorted(number, row + min(cell[2] + 1, shape[2] - 1), "right")
                for k in range(first, last):
                    far = height = towards = 0.0
                    for c in range(3):
                        d = end[k, c] - x[c]
                        far += d * d
                        height += d * n[c]
                        towards += way[k, c] * n[c]
                    if far < radius * radius and towards < 0.0 and abs(height) < 0.1 * radius:
                        for b in range(power.shape[1]):
                            found[p, b] += power[k, b]


@njit(cache=True, nogil=True, error_model="numpy")
def _crossing(points, normals, begin, end, power, radius, found, square):
    """Add the power of all rays that cross a disc from its front; they may end just behind it.

    And its square.
    """
    points, normals, begin, end = borrowed((points, normals, begin, end))
    for p in range(len(points)):
        x, n = points[p], normals[p]
        for k in range(len(begin)):
            one = two = 0.0
            for c in range(3):
                one += (begin[k, c] - x[c]) * n[c]
                two += (end[k, c] - x[c]) * n[c]
            two -= 0.1 * radius
            if one <= 0.0 or two >= 0.0:
                continue
            t, far = min(1.0, one / (one - two - 0.1 * radius)), 0.0
            for c in range(3):
                d = begin[k, c] + t * (end[k, c] - begin[k, c]) - x[c]
                far += d * d
            if far < radius * radius:
                for b in range(power.shape[1]):
                    found[p, b] += power[k, b]
                    square[p, b] += power[k, b] ** 2


def find_caustics(
    space: Space, targets: Targets, lamps: tuple[Light, ...], unit_m: float, area: float,
    rays: int, seed: int,
) -> Caustics:  # fmt: skip
    """Return the ways that light of sources takes by mirrors and clear bodies.

    ``targets`` are the sides that mirror or let light through, ``area`` that of all faces, and
    ``rays`` as many as each source sends.
    """
    radius = DISC * math.sqrt(area) * (FEWEST / rays) ** 0.25
    parts = [[np.zeros((0, 3))] * 2 + [np.zeros(0, int), np.zeros((0, space.optics.bands))]]
    for number, lamp in enumerate(lamps):
        ends, power = rays_of(space, targets, lamp, number, unit_m, rays, seed)
        parts += _followed(space, ends, power, seed)
    return Caustics(*map(np.concatenate, zip(*parts, strict=True)), radius, unit_m)


def rays_of(
    space: Space, targets: Targets, lamp: Light, number: int, unit_m: float, count: int,
    seed: int,
) -> tuple[Bundle, np.ndarray]:  # fmt: skip
    """Return the first ends of rays from a source on the targets, and the power of all in W.

    That is (rays, bands), of the first rays that the bundle names.
    """
    rays = _from_point if hasattr(lamp, "position") else _from_afar
    origins, directions, face, spread = rays(space, targets, lamp, number, count, seed)
    start = origins.copy()
    sides, hits = meet(space.visibility, space.table, origins, directions)
    good = (sides >= 0) & (face >= 0)
    good[good] = space.faces(sides[good]) == face[good]
    good = np.flatnonzero(good & (spread > 0.0) & space.sends_on(sides))
    power = np.zeros((len(sides), space.optics.bands))
    ends = first_rays(
        space, sides, hits, start, directions, np.zeros(len(sides), int)
    ).some(good)
    _, distance, irradiance = lamp.reaching(space.points(ends.hits.astype(float)), unit_m)
    if hasattr(lamp, "position"):
        spread = spread[good] * (distance * unit_m) ** 2  # W/sr of a falloff of any law
    else:
        spread = spread[good] * (unit_m / space.visibility.scale) ** 2
    power[good] = irradiance * spread[:, None]
    return ends, power


def _from_point(space, targets, lamp, number, count, seed):
    """Return rays from a point to the targets, and the solid angle that each stands for."""
    here = lamp.position[None], np.zeros((1, 3)), np.array([KEY + number])
    origins, directions, face, factor = aimed_rays(
        space.visibility, targets, *here, range(count), seed
    )
    return origins, directions, face, factor * math.pi / count


def _from_afar(space, targets, lamp, number, count, seed):
    """Return parallel rays to the targets, and the area across them that each stands for."""
    direction, c = lamp.direction, targets.corners
    across = 0.5 * np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) @ direction
    towards = np.einsum("tc,c->t", targets.normal, direction)
    wanted = np.where(towards < 0.0, targets.sides[:, 0], targets.sides[:, 1])
    running = np.cumsum(np.abs(across) * wanted)
    origins, face = np.empty((count, 3), np.float32), np.full(count, -1)
    _places(c, running, hashed(KEY + number, 0, seed), targets.face, origins, face)
    origins -= (BEGIN * direction).astype(np.float32)
    directions = np.tile(direction.astype(np.float32), (count, 1))
    total = running[-1] if len(running) else 0.0
    return origins, directions, face, np.full(count, total / count)


@njit(cache=True, nogil=True, error_model="numpy")
def _places(corners, running, shift, faces, points, face):
    """Write points spread evenly over triangles as their running sum tells."""
    for k in range(len(points)):
        if len(running) == 0 or running[-1] <= 0.0:
            return
        s = sobol(k, 0, shift) * running[-1]
        t = min(np.searchsorted(running, s, "right"), len(running) - 1)
        size = running[t] - (running[t - 1] if t > 0 else 0.0)
        u = math.sqrt(min((s - running[t] + size) / size, 1.0))
        v = sobol(k, 1, shift >> np.uint64(32))
        for c in range(3):
            a, b, d = corners[t, 0, c], corners[t, 1, c], corners[t, 2, c]
            points[k, c] = a + u * ((b - a) * (1.0 - v) + (d - a) * v)
        face[k] = faces[t]


def _followed(space, ends, power, seed):
    """Return begins, ends, sides and powers of what follows, of each bounce."""
    found, keys = [], np.full(len(power), KEY)
    for rays in follow(space, ends, keys, np.arange(len(power)), seed, lobes=False, depth=DEEP):
        k = np.flatnonzero(rays.state <= 0)
        far = rays.way[k, None] / space.visibility.scale
        end = space.points(rays.hits[k].astype(np.float64))
        begin = end - far * rays.directions[k]
        out = rays.sides[k] < 0
        end[out] += BEGIN / space.visibility.scale * rays.directions[k][out]
        found.append([begin, end, rays.sides[k], power[rays.ray[k]] * rays.share[k]])
    return found
