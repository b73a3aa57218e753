"""What arrives at points from patches: exact visible factors, and rays where too many block.

At a point x the irradiance is E(x) = sum over j of int_j K(x, y) B_j(y) dA, with the kernel K of E2
and the integral over the part of patch j that is seen past the blockers: Lambert's sum where B_j is
constant, its first moment too where B_j is linear (E11). Free of noise, so that the order in the
mesh size shows, and differences between meshes mean something.
"""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.elements import Elements
from radiosity.transport.exchange import Geometry
from radiosity.transport.occlusion import SPREAD, shadow_rays
from radiosity.transport.runs import RUN, bound_runs
from radiosity.transport.screen import make_columns
from radiosity.transport.sight import Sight, make_space, weigh
from radiosity.transport.threads import Progress, over_ranges, silent
from radiosity.transport.visibility import LIFT, Visibility

PAIRS_AT_ONCE, POINTS_AT_ONCE = 1 << 18, 64
RAYS = 64
ROUNDING = 1e-12
CLOSED = 0.5  # tolerances of far factors by which those of a point may miss 1
SURE = 4.0  # standard errors of what rays told, by which the factors of a point may miss 1
RULED = 0.5  # of their tolerances, what errors of far factors come to

@dataclass(frozen=True)
class Senders:
    """Elements as seen from points.

    Attributes
    ----------
    elements : Elements
    visibility : Visibility
    sight : Sight
    """

    elements: Elements
    visibility: Visibility
    sight: Sight

    @property
    def blur(self) -> float:
        """Return by how much the factors of a point that sees patches only may miss 1."""
        return max(ROUNDING, CLOSED * float(self.sight.tolerance.max(initial=0.0)))


def close(weights: np.ndarray, n: int, doubt: np.ndarray | None, blur: float) -> np.ndarray:
    """Scale the weights (k, width n) of points that see patches only; return what they see (k,).

    That is of points whose factors miss 1 by no more than ``blur`` and, where rays told some of
    them, SURE standard errors of all together.
    """
    seen = weights[:, :n].sum(axis=1)
    if doubt is not None:
        blur = blur + SURE * np.sqrt(np.sum(doubt**2, axis=1))
    near = np.abs(seen - 1.0) <= blur
    weights[near] /= seen[near, None]
    return np.where(near, 1.0, seen)


def make_senders(
    elements: Elements, geometry: Geometry, visibility: Visibility, tolerance: float | np.ndarray
) -> Senders:
    """Return elements whose patches have the ``geometry`` in ray coordinates.

    ``tolerance`` is relative, of the factor to a patch far from a point; 0 for exact sums.
    """
    tolerance = np.full(len(geometry.area), tolerance, float)
    boxes = np.empty((2, -(-len(geometry.area) // RUN), 3))
    bound_runs(geometry.vertices, boxes[0], boxes[1])
    free = np.zeros(int(visibility.blockers.body.max(initial=0)) + 1, bool)
    across = np.ascontiguousarray(elements.axes.transpose(1, 2, 0)) / visibility.scale
    made = geometry, make_columns(geometry), across, boxes
    sight = Sight(*made, visibility.blockers, free, tolerance)
    return Senders(elements, visibility, sight)


def weights_of(
    senders: Senders, points: np.ndarray, normals: np.ndarray, first: int = 0, *,
    lift: float = 0.0, seed: int = 0,
) -> tuple[np.ndarray, np.ndarray | None]:  # fmt: skip
    """Return how irradiance at points depends on the coefficients of the senders' elements.

    Parameters
    ----------
    points, normals : (k, 3) float64
        Scene units, unit vectors.
    first : int
        Number of the first point; sample patterns are hashed from it.
    lift : float
        By how much of the scene's half extent points look past blockers from over their place, off
        the surface that they were meant to lie on.

    Returns
    -------
    weights : (k, width n) float64
        E = weights @ coefficients, ordered as in `Elements`.
    doubt : (k, n) float64 or None
        Standard error of the factors that rays had to tell, None where they all are exact.
    """
    n, visibility = len(senders.elements), senders.visibility
    weights = np.zeros((len(points), senders.elements.width * n))
    left = np.zeros((len(points), n), bool)
    x = (points - visibility.centre) * visibility.scale
    weigh(x, normals, lift, senders.sight, make_space(), weights, left)
    outside = np.flatnonzero(visibility.outside(x))
    if len(outside):
        walled = senders.sight._replace(blockers=visibility.facets)
        found = np.zeros((len(outside), weights.shape[1])), np.zeros_like(left[outside])
        weigh(x[outside], normals[outside], lift, walled, make_space(), *found)
        weights[outside], left[outside] = found
    if not left.any():
        return weights, None
    return weights, _by_rays(senders, points, normals, first, weights, left, seed)


def _by_rays(senders, points, normals, first, weights, left, seed):
    """Multiply what was left to rays by the share that passes; return its standard error."""
    pairs, n = np.argwhere(left), left.shape[1]
    here = np.repeat(points[:, None], 4, axis=1), normals
    there = senders.elements.vertices, senders.elements.normal
    keys = np.arange(first, first + len(points))
    tally = shadow_rays(senders.visibility, pairs, here, there, keys, range(RAYS), seed)
    s, m = tally.share, tally.effective
    doubt = np.zeros(left.shape)
    spread = SPREAD * np.sqrt(np.maximum(s * (1.0 - s), 1.0 / m)) * m**-0.6
    doubt[left] = weights[:, :n][left] * spread
    for a in range(0, weights.shape[1], n):
        weights[:, a : a + n][left] *= s
    return doubt


@dataclass(frozen=True)
class Arrival:
    """What arrives at k points.

    Attributes
    ----------
    total : (k, m) float64
        For each column of coefficients.
    error : (k, m) float64
        Of rules to far patches, and the standard error of what rays had to tell; 0 where all
        factors are exact.
    seen : (k,) float64
        Sum of the visible factors; 1 in a closed scene whose sides are all among the patches.
    """

    total: np.ndarray
    error: np.ndarray
    seen: np.ndarray


def arriving(
    senders: Senders, coefficients: np.ndarray, points: np.ndarray, normals: np.ndarray, *,
    lift: float = LIFT, seed: int = 0, progress: Progress = silent,
) -> Arrival:  # fmt: skip
    """Return what arrives at points, see `weights_of`, for each column (width n, m)."""
    n, k = len(senders.elements), len(points)
    shape = k, coefficients.shape[1]
    found = Arrival(np.zeros(shape), np.zeros(shape), np.zeros(k))
    inexact = senders.sight.tolerance[:, None]

    def work(a, b):
        weights, doubt, found.seen[a:b] = _closed(senders, points, normals, a, b, lift, seed)
        found.total[a:b] = weights @ coefficients
        found.error[a:b] = RULED * (weights[:, :n] @ (inexact * np.abs(coefficients[:n])))
        if doubt is not None:
            found.error[a:b] += np.sqrt(doubt**2 @ coefficients[:n] ** 2)

    over_ranges(work, k, points_at_once(n), "irradiance", progress)
    return found


def all_weights(
    senders: Senders, points: np.ndarray, normals: np.ndarray, seed: int = 0
) -> np.ndarray:
    """Return the weights (k, width n) of points, closed, see `weights_of` and `close`."""
    n = len(senders.elements)
    found = np.empty((len(points), senders.elements.width * n))

    def work(a, b):
        found[a:b] = _closed(senders, points, normals, a, b, LIFT, seed)[0]

    over_ranges(work, len(points), points_at_once(n))
    return found


def _closed(senders, points, normals, a, b, lift, seed):
    """Return the closed weights of points a to b - 1, their doubt, and what each sees."""
    weights, doubt = weights_of(senders, points[a:b], normals[a:b], a, lift=lift, seed=seed)
    return weights, doubt, close(weights, len(senders.elements), doubt, senders.blur)


def points_at_once(patches: int) -> int:
    """Return how many points share one table of weights."""
    return max(1, min(POINTS_AT_ONCE, PAIRS_AT_ONCE // max(1, patches)))
