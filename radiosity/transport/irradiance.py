"""Irradiance at points: from lights exactly, from the solved patches by looking around."""

from collections import namedtuple
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from radiosity.light.sources import Light
from radiosity.transport.borrow import borrowed
from radiosity.transport.hemisphere import look_out, meet
from radiosity.transport.lamps import lamp_irradiance
from radiosity.transport.lookup import Table, cell_at
from radiosity.transport.occlusion import seen_share
from radiosity.transport.polygon import point_factor
from radiosity.transport.visibility import Visibility

if TYPE_CHECKING:
    from radiosity.transport.paths import Space
    from radiosity.transport.tracer import Tracer

FINER = 4  # direct light is kept on a grid of FINER x FINER cells for each of a face's own

Field = namedtuple("Field", "row value gradient centroid outside direct")
Field.__doc__ = """What patches send out, as seen by rays.

row (2 * fronts,): patch of a side, -1 where dark; value (n, bands) exitance in W/m2 and gradient
(n, bands, 3) a scene unit about centroid (n, 3); outside (bands,) exitance of the environment;
direct (2, cells, bands) exitance to add on the fine cells of fronts and backs, or of length 0.
"""


@dataclass(frozen=True)
class Lights:
    """Polygons that shine from their front, and abstract light sources, sampled one by one.

    Attributes
    ----------
    polygons : (l, 4, 3) float64
    normals : (l, 3) float64
    exitance : (l, bands) float64
        W/m2.
    lamps : tuple of Light
    unit_m : float
        Metres a scene unit.
    face : (l,) int
        Of the scene, that a polygon is.
    """

    polygons: np.ndarray
    normals: np.ndarray
    exitance: np.ndarray
    lamps: tuple[Light, ...] = ()
    unit_m: float = 1.0
    face: np.ndarray | tuple = ()

    def without_lamps(self) -> "Lights":
        """Return the polygons alone."""
        return replace(self, lamps=())

    def only(self, k: int) -> "Lights":
        """Return one of the polygons alone."""
        one = slice(k, k + 1)
        return Lights(
            self.polygons[one], self.normals[one], self.exitance[one], face=self.face[one]
        )

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(len(self.polygons) or self.lamps)


@dataclass(frozen=True)
class Surroundings:
    """All that is needed to find the light that arrives at a point.

    ``field`` holds what patches send out evenly beside what ``lights`` emits; ``space`` is there
    where some send light on along single directions, and ``tracer`` where it knows what of lights'
    own light they do. ``even`` (bands,), W/(m2 sr), if given, comes from everywhere in place of all
    that rays would meet.
    """

    visibility: Visibility
    table: Table
    field: Field
    lights: Lights
    space: "Space | None" = None
    tracer: "Tracer | None" = None
    even: np.ndarray | None = None


@njit(cache=True, nogil=True)
def _collect(table, sides, hits, field, centre, scale, smooth, flat):
    table, field = borrowed((table, field))
    bands = len(field.outside)
    count = sides.shape[1]
    fine = field.direct.shape[1] > 0
    x = np.empty(3)
    for p in range(len(sides)):
        for k in range(count):
            side = sides[p, k]
            row = field.row[side] if side >= 0 else -1
            if row < 0:
                for b in range(bands if side < 0 else 0):
                    smooth[p, b] += field.outside[b] / count
                    flat[p, b] += field.outside[b] / count
                continue
            for c in range(3):
                x[c] = centre[c] + hits[p, k, c] / scale
            cell = cell_at(table, table.face[side // 2], x, FINER) if fine else 0
            for c in range(3):
                x[c] -= field.centroid[row, c]
            for b in range(bands):
                g = field.gradient[row, b]
                value = field.value[row, b] + g[0] * x[0] + g[1] * x[1] + g[2] * x[2]
                direct = field.direct[side % 2, cell, b] if fine else 0.0
                smooth[p, b] += (max(0.0, value) + direct) / count
                flat[p, b] += (field.value[row, b] + direct) / count


def indirect_irradiance(around: Surroundings, points, normals, keys, samples: range, seed: int):
    """Irradiance that patches cause at points, by cosine-distributed rays (E6).

    Parameters
    ----------
    points, normals : (k, 3) float64
        Scene units, unit vectors.
    keys : (k,) int
        What the sample pattern of a point is hashed from.
    samples : range
        Which points of the sequence to use.

    Returns
    -------
    smooth, flat : (k, bands) float64
        W/m2, with radiosities linear and constant over each patch.
    nearness : (k,) float64
        Mean of 1/distance to what the rays meet, in 1/scene unit.
    """
    met = look_out(around.visibility, around.table, points, normals, keys, samples, seed)
    smooth, flat, nearness = irradiance_by(around, points, *met)
    if around.space is not None:
        from radiosity.transport.onward import irradiance_sent_on

        more = irradiance_sent_on(around, points, normals, *met, keys, samples, seed)
        smooth, flat = smooth + more, flat + more
    return smooth, flat, nearness


def irradiance_by(around: Surroundings, points, sides, hits):
    """Return what `indirect_irradiance` does, by rays (k, n) that were followed before.

    Without what surfaces send on along them.
    """
    visibility = around.visibility
    smooth = np.zeros((len(points), len(around.field.outside)))
    flat, nearness = np.zeros_like(smooth), np.empty(len(points))
    _nearness(points, sides, hits, visibility.centre, visibility.scale, nearness)
    _collect(
        around.table, sides, hits, around.field, visibility.centre, visibility.scale, smooth, flat
    )
    return smooth, flat, nearness


@njit(cache=True, nogil=True)
def _nearness(points, sides, hits, centre, scale, nearness):
    for p in range(len(points)):
        total = 0.0
        for k in range(sides.shape[1]):
            if sides[p, k] >= 0:
                d2 = 0.0
                for c in range(3):
                    d = centre[c] + hits[p, k, c] / scale - points[p, c]
                    d2 += d * d
                total += 1.0 / np.sqrt(max(d2, 1e-300))
        nearness[p] = total / sides.shape[1]


def sent_along(around: Surroundings, origins, directions, keys, samples: range, seed: int):
    """Trace rays and return what they meet and what comes back along them.

    Parameters
    ----------
    origins, directions : (k, 3) float32
        In ray coordinates, those of one point after another; origins are overwritten.
    keys : (p,) int
        Of the points.
    samples : range
        What each of a point's rays stands for in their patterns: k = p len(samples).

    Returns
    -------
    sides, hits : (k,) int, (k, 3) float32
        See `meet`.
    exitance : (k, bands) float64
        W/m2, without what lights emit that a ray meets first.
    """
    begin = origins.copy() if around.space is not None else origins
    sides, hits = meet(around.visibility, around.table, origins, directions)
    found = carried(around, sides, hits)
    if around.space is not None:
        from radiosity.transport.onward import sent_on

        found = found + sent_on(around, begin, directions, sides, hits, keys, samples, seed)
    return sides, hits, found


def carried(around: Surroundings, sides: np.ndarray, hits: np.ndarray) -> np.ndarray:
    """Return (k, bands) exitance in W/m2 that each ray's end sends back, lights apart."""
    visibility = around.visibility
    smooth = np.zeros((len(sides), len(around.field.outside)))
    _collect(
        around.table, sides[:, None], hits[:, None], around.field, visibility.centre,
        visibility.scale, smooth, np.zeros_like(smooth),
    )  # fmt: skip
    return smooth


@njit(cache=True, nogil=True)
def _point_factors(points, normals, polygons, factors):
    points, normals, polygons = borrowed((points, normals, polygons))
    for p in range(len(points)):
        x, n = points[p], normals[p]
        for q in range(len(polygons)):
            factors[p, q] = point_factor(x[0], x[1], x[2], n[0], n[1], n[2], polygons[q])


def direct_irradiance(
    visibility: Visibility, lights: Lights, points, normals, keys, samples: range, seed: int
):
    """Irradiance (k, bands) in W/m2 that lights cause at points (E2, E5, E18).

    The exact factor from the point to each polygon times the share that shadow rays let through.
    """
    factors = np.empty((len(points), len(lights.polygons)))
    _point_factors(points, normals, lights.polygons, factors)
    pairs = np.argwhere(factors)
    here = np.repeat(points[:, None], 4, axis=1), normals
    there = lights.polygons, lights.normals
    share = seen_share(visibility, pairs, here, there, keys, samples, seed)
    factors[pairs[:, 0], pairs[:, 1]] *= share
    found = factors @ lights.exitance
    if lights.lamps:
        found += lamp_irradiance(visibility, lights.lamps, points, normals, lights.unit_m)
    return found
