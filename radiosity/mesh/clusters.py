"""Clusters: groups of small patches that lie together and look the same way."""

import numpy as np

from radiosity.mesh.patches import Patches

FACETS = 2, 1  # cells along each edge of a cube's face, into which directions are sorted
ROOM = 4  # cubes a group of one kind and direction, on average, that there must be room for
SEARCH = 24  # halvings in the search for the size of cubes


def make_clusters(patches: Patches, rows: np.ndarray, kind: np.ndarray, wanted: int) -> np.ndarray:
    """Sort patches into about ``wanted`` clusters, and no more.

    A cluster holds patches of one kind whose centroids lie in one cube of a grid and whose normals
    point into one of 24 cells of directions. Where these kinds and directions are too many, kinds
    are not told apart, and if that does not do, only 6 directions are.

    Parameters
    ----------
    rows : (m,) int
        The patches that are sorted.
    kind : (m,) int
        What is to be told apart, such as reflectances.

    Returns
    -------
    (m,) int
        Cluster of each, numbered from 0 without gaps.
    """
    if len(rows) <= wanted:
        return np.arange(len(rows))
    ways = [_way(patches.normal[rows], facets) for facets in FACETS]
    for fixed in (ways[0] + 6 * FACETS[0] ** 2 * kind, *ways):
        found, fixed = np.unique(fixed, return_inverse=True)
        if ROOM * len(found) <= wanted:
            break
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


def _way(normal, facets) -> np.ndarray:
    """Return (m,) numbers of the cells of directions: squares on the faces of a cube."""
    axis = np.argmax(np.abs(normal), axis=1)
    k = np.arange(len(normal))
    along = normal[k, axis]
    cell = axis * 2 + (along > 0)
    for turn in (1, 2):
        across = normal[k, (axis + turn) % 3] / np.abs(along)
        part = np.clip(((across + 1.0) * facets / 2.0).astype(int), 0, facets - 1)
        cell = cell * facets + part
    return cell
