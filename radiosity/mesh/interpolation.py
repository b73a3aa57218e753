"""Smooth fields over patches: a gradient for each, and values at their corners."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from radiosity.mesh.patches import Patches

SMOOTH = np.cos(np.radians(30))  # normals closer than this belong to one smooth surface


@dataclass(frozen=True)
class Neighbours:
    """Which corners of which patches meet at a point of one smooth surface.

    Attributes
    ----------
    corner : (m,) int
        4 * patch + corner.
    patch : (m,) int
        A patch that shares the point with that corner, the corner's own patch included.
    """

    corner: np.ndarray
    patch: np.ndarray


def find_neighbours(patches: Patches, live: np.ndarray, kind: np.ndarray) -> Neighbours:
    """Pair every corner with the patches around it.

    Only ``live`` patches of the same ``kind`` (material) and side whose normals agree within 30
    degrees are neighbours, so nothing is smoothed across creases, contacts or colours.
    """
    points = patches.vertices.reshape(-1, 3)
    extent = np.ptp(points, axis=0).max()
    grid = np.round((points - points.min(axis=0)) / (1e-6 * extent)).astype(np.int64)
    _, point = np.unique(grid, axis=0, return_inverse=True)
    point = point.ravel()
    order = np.argsort(point, kind="stable")
    start = np.searchsorted(point[order], np.arange(point.max() + 2))
    size = np.diff(start)[point]  # corners around each corner's point
    corner = np.repeat(np.arange(len(point)), size)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(size) - size, size)
    other = order[start[point[corner]] + within] // 4
    own = corner // 4
    same = live[own] & live[other] & (kind[own] == kind[other])
    same &= patches.front[own] == patches.front[other]
    same &= np.einsum("kc,kc->k", patches.normal[own], patches.normal[other]) > SMOOTH
    return Neighbours(corner[same], other[same])


def gradients(patches: Patches, around: Neighbours, values: np.ndarray) -> np.ndarray:
    """Return (n, bands, 3): the in-plane gradient of values (n, bands) on every patch.

    Least squares over the neighbours of a patch; 0 where there are none to tell.
    """
    own = around.corner // 4
    d, inverse = _in_plane(patches, around)
    rise = np.zeros((len(patches), values.shape[1], 3))
    np.add.at(rise, own, (values[around.patch] - values[own])[:, :, None] * d[:, None, :])
    return np.einsum("nbc,ncd->nbd", rise, inverse)


def _in_plane(patches, around):
    """Return the ways (m, 3) to neighbours, and the inverses (n, 3, 3) of their sums of squares."""
    own = around.corner // 4
    d = patches.centroid[around.patch] - patches.centroid[own]
    d -= np.einsum("kc,kc->k", d, patches.normal[own])[:, None] * patches.normal[own]
    outer = np.zeros((len(patches), 3, 3))
    np.add.at(outer, own, d[:, :, None] * d[:, None, :])
    return d, np.linalg.pinv(outer, rcond=1e-3, hermitian=True)


def corner_values(
    patches: Patches, around: Neighbours, values: np.ndarray, slope: np.ndarray
) -> np.ndarray:
    """Return (n, 4, bands): values at the corners, averaged over the patches that meet there."""
    n, bands = values.shape
    points = patches.vertices.reshape(-1, 3)
    d = points[around.corner] - patches.centroid[around.patch]
    at = values[around.patch] + np.einsum("kbc,kc->kb", slope[around.patch], d)
    total, count = np.zeros((4 * n, bands)), np.zeros(4 * n)
    np.add.at(total, around.corner, np.maximum(at, 0.0))
    np.add.at(count, around.corner, 1.0)
    alone = count == 0
    total[alone], count[alone] = np.repeat(values, 4, axis=0)[alone], 1.0
    return (total / count[:, None]).reshape(n, 4, bands)


def corner_matrix(patches: Patches, around: Neighbours) -> csr_array:
    """Return (4 n, n): what makes values at corners, patch by patch, of the patches' values.

    Where nothing is negative that is what `corner_values` returns with the `gradients`. Linear, so
    that values of light that adds up add up.
    """
    n, own = len(patches), around.corner // 4
    count = np.bincount(around.corner, minlength=4 * n)
    alone = np.flatnonzero(count == 0)
    share = 1.0 / count[around.corner]
    mean = csr_array((share, (around.corner, around.patch)), (4 * n, n))
    mean += csr_array((np.ones(len(alone)), (alone, alone // 4)), (4 * n, n))
    d, inverse = _in_plane(patches, around)
    steep = np.einsum("kc,kcd->kd", d, inverse[own]).ravel()
    row, there = (3 * own[:, None] + [0, 1, 2]).ravel(), np.repeat(around.patch, 3)
    slope = csr_array((steep, (row, there)), (3 * n, n))
    slope -= csr_array((steep, (row, np.repeat(own, 3))), (3 * n, n))
    away = patches.vertices.reshape(-1, 3)[around.corner] - patches.centroid[around.patch]
    column = (3 * around.patch[:, None] + [0, 1, 2]).ravel()
    across = (share[:, None] * away).ravel()
    return mean + csr_array((across, (np.repeat(around.corner, 3), column)), (4 * n, 3 * n)) @ slope
