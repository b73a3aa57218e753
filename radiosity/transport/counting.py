"""Form factors between clusters of patches, counted by rays.

Rays of cosine-distributed directions start all over a cluster, and what they meet is counted. The
cost does not depend on how many patches a cluster has, and that of tracing a ray hardly.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from radiosity.mesh.patches import Patches
from radiosity.transport.borrow import borrowed
from radiosity.transport.hemisphere import MISS, meet
from radiosity.transport.lookup import Table
from radiosity.transport.operator import FormFactors, Openness
from radiosity.transport.polygon import first_half, place_evenly
from radiosity.transport.sampling import cosine_direction, hashed, sobol
from radiosity.transport.threads import Progress, over_ranges, silent
from radiosity.transport.visibility import LIFT, Visibility

PLACE = 1 << 43  # tells its patterns from others
AT_ONCE = 1 << 16  # rays


@njit(cache=True, nogil=True, error_model="numpy")
def _aim(
    first, stop, start, share, vertices, normals, begin, rays, seed, centre, scale, lift, o, d
):  # fmt: skip
    """Write the rays of clusters first to stop - 1, from number ``begin`` on; see `count_rays`."""
    vertices, normals = borrowed((vertices, normals))
    x, way = np.empty(3), np.empty(3)
    for g in range(first, stop):
        place, turn = hashed(g, PLACE, seed), hashed(g, PLACE + 1, seed)
        for k in range(rays):
            r = (g - first) * rays + k
            s, t = sobol(begin + k, 0, place), sobol(begin + k, 1, place >> np.uint64(32))
            j = start[g] + np.searchsorted(share[start[g] : start[g + 1] - 1], s, "right")
            low = share[j - 1] if j > start[g] else 0.0
            s = min(0.999999, (s - low) / max(share[j] - low, 1e-300))
            place_evenly(vertices[j], first_half(vertices[j]), s, t, x)
            u, v = sobol(begin + k, 2, turn), sobol(begin + k, 3, turn >> np.uint64(32))
            cosine_direction(u, v, normals[j], way)
            for c in range(3):
                o[r, c] = (x[c] - centre[c]) * scale + lift * normals[j, c]
                d[r, c] = way[c]


@dataclass(frozen=True)
class Beams:
    """Patches, sorted by clusters, from which rays start.

    start (n + 1,): the first patch of each cluster; share (m,): areas summed up in each, of 1.
    """

    start: np.ndarray
    share: np.ndarray
    vertices: np.ndarray
    normals: np.ndarray

    def rays(self, visibility: Visibility, a: int, b: int, samples: range, seed: int):
        """Return rays (k, 3), (k, 3) float32 from the clusters a to b - 1, ray coordinates."""
        o = np.empty(((b - a) * len(samples), 3), np.float32)
        d = np.empty_like(o)
        _aim(a, b, self.start, self.share, self.vertices, self.normals, samples.start,
             len(samples), seed, visibility.centre, visibility.scale, LIFT, o, d)  # fmt: skip
        return o, d


def make_beams(patches: Patches, rows: np.ndarray, labels: np.ndarray) -> Beams:
    """Return patches ``rows`` (m,) by their clusters ``labels`` (m,)."""
    n = int(labels.max(initial=-1)) + 1
    order = np.argsort(labels, kind="stable")
    area, start = patches.area[rows][order], np.searchsorted(labels[order], np.arange(n + 1))
    whole = np.bincount(labels, patches.area[rows], n)
    share = np.cumsum(area) - np.repeat(np.cumsum(whole) - whole, np.diff(start))
    share /= whole[labels[order]]
    return Beams(start, share, patches.vertices[rows][order], patches.normal[rows][order])


def count_rays(
    patches: Patches, rows: np.ndarray, labels: np.ndarray, visibility: Visibility, table: Table,
    samples: range, seed: int = 0, progress: Progress = silent,
) -> np.ndarray:  # fmt: skip
    """Return (n, n + 2) int32: how many rays from each cluster meet each one.

    The last two columns count those that meet surfaces without a cluster, and the outside.

    Parameters
    ----------
    rows : (m,) int
        Patches that exchange light.
    labels : (m,) int
        The cluster of each.
    samples : range
        Which points of the sequence to use for the rays from every cluster, so that counts can be
        added up.
    """
    rays = len(samples)
    n = int(labels.max(initial=-1)) + 1
    beams = make_beams(patches, rows, labels)
    of_side = _cluster_of_sides(patches, rows, labels)
    met = np.zeros((n, n + 2), np.int32)

    def work(a, b):
        sides, _ = meet(visibility, table, *beams.rays(visibility, a, b, samples, seed))
        where = np.where(sides == MISS, n + 1, of_side[sides])
        own = np.repeat(np.arange(b - a), rays) * (n + 2)
        met[a:b] = np.bincount(own + where, minlength=(b - a) * (n + 2)).reshape(b - a, n + 2)

    over_ranges(work, n, max(1, AT_ONCE // rays), "form factors", progress)
    return met


def _cluster_of_sides(patches, rows, labels):
    """Return (2 * fronts,) the cluster of each side of a patch; one more than the last if none."""
    cluster = np.full(len(patches) + 1, labels.max(initial=-1) + 1)
    cluster[rows] = labels
    sides = np.stack([np.arange(patches.fronts), patches.back_of], axis=1)
    return cluster[sides.ravel()]  # the place -1 of what has no back holds no cluster


def counted_factors(met: np.ndarray, area: np.ndarray, rays: int) -> FormFactors:
    """Return the form factors between clusters of areas (n,), not closed, from what rays met.

    Both ends of a pair count: of rays a from cluster i and b from j that meet the other one, with
    the exposures w = rays / area, A_i F_ij = (a + b)/(w_i + w_j) (E14).

    Parameters
    ----------
    met : (n, n + 2) int
        Of `count_rays`.
    rays : int
        From every cluster.
    """
    n = len(area)
    weight = rays / area
    both = met[:, :n] + met[:, :n].T
    exposure = weight[:, None] + weight
    error = (np.sqrt(both) / exposure).astype(np.float32)
    out, absorbed = met[:, n:].sum(axis=1) / rays, met[:, n] / rays
    openness = Openness(out, np.sqrt(out * (1.0 - out) / rays), absorbed)
    return FormFactors(both / exposure, area, error, openness)
