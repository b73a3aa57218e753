"""How much of one polygon is seen from another: shadow rays between pairs, compiled."""

import numpy as np
from numba import njit

from radiosity.transport.polygon import bilinear
from radiosity.transport.sampling import hashed, sobol
from radiosity.transport.visibility import LIFT, Visibility

RAYS_AT_ONCE = 1 << 16
OTHER = 1 << 40  # tells the pattern on a source from the one on its target


@njit(cache=True, nogil=True)
def _aim(pairs, p, np_, q, nq, keys, first, count, seed, centre, scale, lift, start, span, weight):
    x, y = np.empty(3), np.empty(3)
    for m in range(len(pairs)):
        i, j = pairs[m, 0], pairs[m, 1]
        one, two = hashed(keys[i], j, seed), hashed(keys[i], j + OTHER, seed)
        for k in range(count):
            r = m * count + k
            s, t = sobol(first + k, 0, one), sobol(first + k, 1, one >> np.uint64(32))
            a = bilinear(q[j], s, t, x)
            s, t = sobol(first + k, 2, two), sobol(first + k, 3, two >> np.uint64(32))
            b = bilinear(p[i], s, t, y)
            stretch = a * b if b > 0.0 else a
            ci = cj = d2 = 0.0
            for c in range(3):
                lifted = (y[c] - centre[c]) * scale + lift * np_[i, c]
                end = (x[c] - centre[c]) * scale + lift * nq[j, c]
                d = end - lifted
                start[r, c], span[r, c] = lifted, d
                ci += d * np_[i, c]
                cj -= d * nq[j, c]
                d2 += d * d
            weight[r] = stretch * ci * cj / (d2 * d2) if ci > 0.0 and cj > 0.0 else 0.0


@njit(cache=True, nogil=True)
def _shares(blocked, weight, count, share):
    for m in range(len(share)):
        seen = total = free = 0.0
        for r in range(m * count, (m + 1) * count):
            total += weight[r]
            if not blocked[r]:
                seen += weight[r]
                free += 1.0
        share[m] = seen / total if total > 0.0 else free / count


def seen_share(
    visibility: Visibility,
    pairs: np.ndarray,
    sources,
    targets,
    keys: np.ndarray,
    samples: range,
    seed: int,
) -> np.ndarray:
    """Return (m,) how much of a pair's unoccluded exchange passes, from 0 to 1.

    The share is sum(w V)/sum(w) over pairs of points with w = cos cos'/r^2, so that the exact
    factor times the share is what arrives (E5).

    Parameters
    ----------
    pairs : (m, 2) int
        Source and target of each.
    sources, targets : (polygons (k, 4, 3), normals (k, 3))
        A point is a polygon whose vertices are all the same.
    keys : (k,) int
        What the sample pattern of a source is hashed from.
    """
    share = np.empty(len(pairs))
    count = len(samples)
    step = max(1, RAYS_AT_ONCE // count)
    start = np.empty((step * count, 3), np.float32)
    span, weight = np.empty_like(start), np.empty(step * count)
    for a in range(0, len(pairs), step):
        block = pairs[a : a + step]
        rays = len(block) * count
        _aim(
            block, *sources, *targets, keys, samples.start, count, seed,
            visibility.centre, visibility.scale, LIFT, start, span, weight,
        )  # fmt: skip
        blocked = visibility.blocked(start[:rays], span[:rays])
        _shares(blocked, weight, count, share[a : a + step])
    return share
