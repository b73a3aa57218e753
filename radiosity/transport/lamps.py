"""Irradiance from abstract light sources: at points, and its mean and slopes over patches.

At a point x of normal n a source in the direction L causes E = (n . L) E_0, E_0 what reaches a
plane that faces it, where no face is in the way (E18). Over a patch that is integrated by Gauss's
rule on cells: near the source no cell is larger than a share of its distance, and cells with an
edge of the light in them, a shadow's or a beam's, are halved again and again (E19).
"""

from dataclasses import dataclass

import numpy as np

from radiosity.light.sources import Light
from radiosity.mesh.elements import Elements
from radiosity.transport.threads import over_ranges
from radiosity.transport.visibility import LIFT, Visibility

FAR = 8.0  # a way, in ray coordinates, that leaves the scene
NEAR = 0.6  # size of a cell to its distance from the source
DEEPEST = 48  # halvings of a patch, towards a source
CORNERS = 1.3  # distance of a cell's corners from its middle to that of its nodes
CELLS, MOST_HALVINGS = 1 << 18, 4  # cells about in all, by which edges of light are followed
EDGE = 0.25  # change of what is let through, inside a cell, that is an edge
PATCHES_AT_ONCE = 256, 4096  # where edges are followed, and where they are not
_X, _W = np.polynomial.legendre.leggauss(4)
NODES = np.stack(np.meshgrid((_X + 1) / 2, (_X + 1) / 2), axis=-1).reshape(-1, 2)
QUARTERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
WEIGHTS = np.outer(_W, _W).ravel() / 4


@dataclass(frozen=True)
class Reaching:
    """What of a source reaches k points.

    Attributes
    ----------
    passing : (k,) float64
        1 where no face is in the way, 0 where one is, or where nothing comes this way.
    falling : (k, bands) float64
        Irradiance where nothing is in the way, W/m2.
    to_light : (k, 3) float64
        Unit vectors.
    distance : (k,) float64
        Scene units.
    """

    passing: np.ndarray
    falling: np.ndarray
    to_light: np.ndarray
    distance: np.ndarray

    def some(self, k: np.ndarray) -> "Reaching":
        """Return what reaches some of the points."""
        return Reaching(self.passing[k], self.falling[k], self.to_light[k], self.distance[k])

    @property
    def irradiance(self) -> np.ndarray:
        """Return (k, bands) in W/m2."""
        return self.passing[:, None] * self.falling


def lamp_irradiance(
    visibility: Visibility, lamps: tuple[Light, ...], points: np.ndarray, normals: np.ndarray,
    unit_m: float,
) -> np.ndarray:  # fmt: skip
    """Return the irradiance (k, bands) in W/m2 that lamps cause at points of unit normals."""
    return sum(reaching(visibility, lamp, points, normals, unit_m).irradiance for lamp in lamps)


def reaching(visibility: Visibility, lamp: Light, points, normals, unit_m: float) -> Reaching:
    """Return what of a source reaches points of unit normals (k, 3)."""
    to_light, distance, irradiance = lamp.reaching(points, unit_m)
    cosine = np.maximum(np.einsum("kc,kc->k", to_light, normals), 0.0)
    falling = cosine[:, None] * irradiance
    passing = np.zeros(len(points))
    k = np.flatnonzero(falling.any(axis=1))
    passing[k] = ~_blocked(visibility, points[k], normals[k], to_light[k], distance[k])
    return Reaching(passing, falling, to_light, distance)


def _blocked(visibility, points, normals, to_light, distance):
    """Return (k,) bool: whether a face lies on the way from points to a source.

    A way starts off its surface and ends before a surface that the source may lie on.
    """
    x = (points - visibility.centre) * visibility.scale
    way = np.minimum(distance * visibility.scale, FAR)
    blocked = np.zeros(len(points), bool)
    ask = way > 2.0 * LIFT
    if not visibility.can_block:
        ask &= visibility.outside(x + way[:, None] * to_light) | visibility.outside(x)
    k = np.flatnonzero(ask)
    if len(k):
        start = x[k] + LIFT * normals[k]
        span = x[k] + (way[k] - LIFT)[:, None] * to_light[k] - start
        blocked[k] = visibility.blocked(start.astype(np.float32), span.astype(np.float32))
    return blocked


def lamps_on(
    visibility: Visibility, lamps: tuple[Light, ...], elements: Elements, unit_m: float
) -> np.ndarray:  # fmt: skip
    """Return the coefficients (width n, bands), W/m2, of what one lamp or more cause on elements.

    Nearest in the mean square over each patch.
    """
    n, width, bands = len(elements), elements.width, len(lamps[0].strength)
    found = np.zeros((width, n, bands))
    halvings = int(np.clip(np.log2(CELLS / max(n, 1)) / 2.0, 0, MOST_HALVINGS))

    def work(a, b):
        part = np.arange(a, b)
        moments = np.zeros((b - a, width, bands))
        for lamp in lamps:
            for owner, basis, weight, here in _cells(
                visibility, lamp, elements, part, unit_m, halvings
            ):
                arriving = np.einsum("k,ki,kb->kib", weight, basis, here.irradiance)
                np.add.at(moments, owner - a, arriving)
        _, basis, weight = _at(elements, *_whole(part), 1.0)
        gram = np.einsum("nk,nki,nkj->nij", weight, basis, basis)
        inverse = np.linalg.pinv(gram, hermitian=True)
        found[:, a:b] = np.einsum("nij,njb->inb", inverse, moments)

    over_ranges(work, n, PATCHES_AT_ONCE[int(halvings == 0)])
    return found.reshape(-1, bands)


def _cells(visibility, lamp, elements, part, unit_m, halvings):
    """Yield patch, basis, weight and `Reaching` at the nodes of cells that are small enough.

    Cells with an edge of the light in them are halved so many times beside what their distance asks
    for.
    """
    (owner, corner), size = _whole(part), 1.0
    left = np.full(len(part), halvings)
    for level in range(DEEPEST + 1):
        points, basis, weight = _at(elements, owner, corner, size)
        normals = np.repeat(elements.normal[owner], len(NODES), axis=0)
        here = reaching(visibility, lamp, points.reshape(-1, 3), normals, unit_m)
        near, edge = _too_large(lamp, points, here)
        split = (near | (edge & (left > 0))) & (level < DEEPEST)
        done = np.flatnonzero(np.repeat(~split, len(NODES)))
        yield (
            np.repeat(owner, len(NODES))[done], basis.reshape(-1, basis.shape[2])[done],
            weight.ravel()[done], here.some(done),
        )  # fmt: skip
        if not split.any():
            return
        size /= 2.0
        corner = (corner[split, None] + size * QUARTERS).reshape(-1, 2)
        owner, left = (np.repeat(x[split], 4) for x in (owner, left - ~near))


def _whole(part):
    return part, np.zeros((len(part), 2))


def _too_large(lamp, points, here):
    """Return (c,) bool of cells: larger than their distance allows; with an edge in them."""
    shape = points.shape[:2]
    middle = points.mean(axis=1)
    radius = CORNERS * np.linalg.norm(points - middle[:, None], axis=2).max(axis=1)
    near = radius > NEAR * here.distance.reshape(shape).min(axis=1)
    near &= here.falling.any(axis=1).reshape(shape).any(axis=1)
    to_light, distance, _ = lamp.reaching(middle, 1.0)
    near |= lamp.misses(-to_light, np.arctan2(radius, distance))
    let = (here.passing * lamp.edges(-here.to_light)).reshape(shape)
    return near, np.ptp(let, axis=1) > EDGE * let.max(axis=1)


def _at(elements, owner, corner, size):
    """Return points (c, k, 3), basis (c, k, width) and areas (c, k) of the nodes of cells."""
    s, t = np.moveaxis(corner[:, None] + size * NODES, -1, 0)[..., None]
    v = elements.vertices[owner][:, :, None]
    along = (1 - t) * (v[:, 1] - v[:, 0]) + t * (v[:, 2] - v[:, 3])
    across = (1 - s) * (v[:, 3] - v[:, 0]) + s * (v[:, 2] - v[:, 1])
    points = v[:, 0] + s * (v[:, 1] - v[:, 0]) + t * across
    weight = size**2 * WEIGHTS * np.linalg.norm(np.cross(along, across), axis=2)
    place = points - elements.centroid[owner][:, None]
    basis = np.einsum("cax,ckx->cka", elements.axes[owner], place)[..., : elements.width - 1]
    return points, np.concatenate([np.ones((*weight.shape, 1)), basis], axis=2), weight
