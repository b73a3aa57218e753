"""Clusters: groups of small patches that lie together and look the same way."""

import numpy as np

from radiosity.mesh.patches import Patches

FACETS = 2  # cells along each edge of a cube's face, into which directions are sorted
SEARCH = 24  # halvings in the search for the size of cubes


def make_clusters(patches: Patches, rows: np.ndarray, kind: np.ndarray, wanted: int) -> np.ndarray:
    """Sort patches into about ``wanted`` clusters.

    A cluster holds patches of one kind (a material) and side whose centroids lie in one cube of a
    grid and whose normals point into one of 24 cells of directions.

    Parameters
    ----------
    rows : (m,) int
        The patches that are sorted.
    kind : (m,) int

    Returns
    -------
    (m,) int
        Cluster of each, numbered from 0 without gaps.
    """
    if len(rows) <= wanted:
        return np.arange(len(rows))
    fixed = _way(patches.normal[rows]) + 6 * FACETS**2 * (2 * kind + patches.front[rows])
    fixed = np.unique(fixed, return_inverse=True)[1]
    place = patches.centroid[rows] - patches.centroid[rows].min(axis=0)
    extent = float(place.max())
    low, high = 0.0, 2.0 * extent  # too many cubes, too few
    for _ in range(SEARCH):
        size = (low + high) / 2.0
        if _sorted(place, fixed, size).max() + 1 > wanted:
            low = size
        else:
            high = size
    return _sorted(place, fixed, high)


def _sorted(place, fixed, size):
    cell = np.floor(place / size).astype(np.int64)
    count = cell.max(axis=0) + 1
    key = ((fixed * count[0] + cell[:, 0]) * count[1] + cell[:, 1]) * count[2] + cell[:, 2]
    return np.unique(key, return_inverse=True)[1].ravel()


def _way(normal) -> np.ndarray:
    """Return (m,) numbers of the cells of directions: squares on the faces of a cube."""
    axis = np.argmax(np.abs(normal), axis=1)
    k = np.arange(len(normal))
    along = normal[k, axis]
    cell = axis * 2 + (along > 0)
    for turn in (1, 2):
        across = normal[k, (axis + turn) % 3] / np.abs(along)
        part = np.clip(((across + 1.0) * FACETS / 2.0).astype(int), 0, FACETS - 1)
        cell = cell * FACETS + part
    return cell
