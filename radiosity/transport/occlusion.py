"""How much of one polygon is seen from another: shadow rays between pairs, compiled."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from radiosity.mesh.patches import Patches
from radiosity.transport.borrow import borrowed
from radiosity.transport.polygon import bilinear
from radiosity.transport.sampling import hashed, shifted, sobol_digits
from radiosity.transport.threads import Progress, over_ranges, silent
from radiosity.transport.visibility import LIFT, Visibility

RAYS_AT_ONCE = 1 << 14
FEWEST_RAYS, MOST_RAYS, PAIRS = 64, 4096, 1024
SPREAD = 1.2  # measured in cluttered rooms, 64 to 1024 rays
OTHER = 1 << 40  # tells the pattern on a source from the one on its target


@njit(cache=True, nogil=True, error_model="numpy")
def _aim(pairs, p, np_, q, nq, keys, first, count, seed, centre, scale, lift, start, span, weight):
    p, np_, q, nq = borrowed((p, np_, q, nq))
    x, y, digits = np.empty(3), np.empty(3), sobol_digits(first, count)
    for m in range(len(pairs)):
        i, j = pairs[m, 0], pairs[m, 1]
        one, two = hashed(keys[i], j, seed), hashed(keys[i], j + OTHER, seed)
        for k in range(count):
            r = m * count + k
            s, t = shifted(digits[k, 0], one), shifted(digits[k, 1], one >> np.uint64(32))
            a = bilinear(q[j], s, t, x)
            s, t = shifted(digits[k, 2], two), shifted(digits[k, 3], two >> np.uint64(32))
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


@njit(cache=True, nogil=True, error_model="numpy")
def _sums(blocked, weight, count, seen, total, squares, free):
    """Add up weights of free and of all rays, their squares, and how many are free, by pairs."""
    for m in range(len(seen)):
        for r in range(m * count, (m + 1) * count):
            total[m] += weight[r]
            squares[m] += weight[r] ** 2
            if not blocked[r]:
                seen[m] += weight[r]
                free[m] += 1.0


@dataclass(frozen=True)
class Tally:
    """What shadow rays found: (m,) sums of w V, w and w^2, and counts of free rays and of all."""

    seen: np.ndarray
    total: np.ndarray
    squares: np.ndarray
    free: np.ndarray
    rays: int

    def __add__(self, other: "Tally") -> "Tally":
        """Return the tally of both."""
        return Tally(
            self.seen + other.seen, self.total + other.total, self.squares + other.squares,
            self.free + other.free, self.rays + other.rays,
        )  # fmt: skip

    def of(self, some: np.ndarray) -> "Tally":
        """Return the tally of some pairs."""
        return Tally(
            self.seen[some], self.total[some], self.squares[some], self.free[some], self.rays
        )

    @property
    def effective(self) -> np.ndarray:
        """Return (m,) how many rays of one weight would do as well (Kish 1965), 1 at least."""
        some = self.squares > 0
        return np.where(some, self.total**2 / np.where(some, self.squares, 1.0), 1.0)

    @property
    def share(self) -> np.ndarray:
        """Return (m,) the share that is seen; of the bare rays where all weights are 0."""
        weighed = self.total > 0
        return np.where(
            weighed, self.seen / np.where(weighed, self.total, 1.0), self.free / max(1, self.rays)
        )


def shadow_rays(
    visibility: Visibility, pairs: np.ndarray, sources, targets, keys: np.ndarray, samples: range,
    seed: int,
) -> Tally:  # fmt: skip
    """Trace rays between pairs of points with the weights w = cos cos'/r^2 (E5).

    Parameters
    ----------
    pairs : (m, 2) int
        Source and target of each.
    sources, targets : (polygons (k, 4, 3), normals (k, 3))
        A point is a polygon whose vertices are all the same.
    keys : (k,) int
        What the sample pattern of a source is hashed from.
    samples : range
        Which points of the sequence to use, so that tallies can be added up.
    """
    sums = np.zeros((4, len(pairs)))
    count = len(samples)
    step = max(1, RAYS_AT_ONCE // count)
    start = np.empty((min(step, len(pairs)) * count, 3), np.float32)
    span, weight = np.empty_like(start), np.empty(len(start))
    for a in range(0, len(pairs), step):
        block = pairs[a : a + step]
        rays = len(block) * count
        _aim(
            block, *sources, *targets, keys, samples.start, count, seed,
            visibility.centre, visibility.scale, LIFT, start, span, weight,
        )  # fmt: skip
        blocked = visibility.blocked(start[:rays], span[:rays])
        _sums(blocked, weight, count, *sums[:, a : a + step])
    return Tally(*sums, count)


def seen_share(visibility, pairs, sources, targets, keys, samples: range, seed: int) -> np.ndarray:
    """Return (m,) how much of a pair's unoccluded exchange passes, see `shadow_rays`.

    The share is sum(w V)/sum(w), so that the exact factor times the share is what arrives (E5).
    """
    return shadow_rays(visibility, pairs, sources, targets, keys, samples, seed).share


def refined_shares(
    visibility: Visibility, pairs: np.ndarray, patches: Patches, tolerance: np.ndarray, seed: int,
    progress: Progress = silent,
):  # fmt: skip
    """Return (m,) visible shares of pairs of patches and their estimated errors.

    Rays are doubled for each pair until its error meets its ``tolerance`` (m,) or MOST_RAYS are
    traced. The standard error of N points of a sequence in four dimensions on either side of a
    shadow edge is taken as SPREAD sqrt(s (1 - s)) N^(-0.6), with at least one ray on each side and
    N no more than what their weights leave effective.
    """
    share, doubt = np.empty((2, len(pairs)))
    sides = patches.vertices, patches.normal
    keys = np.arange(len(patches))

    def work(a, b):
        left = np.arange(a, b)
        tally = shadow_rays(visibility, pairs[left], sides, sides, keys, range(FEWEST_RAYS), seed)
        while True:
            s, n = tally.share, tally.effective
            share[left] = s
            spread = np.sqrt(np.maximum(s * (1 - s), 1.0 / n))
            doubt[left] = np.minimum(1.0, SPREAD * spread * n**-0.6)
            more = doubt[left] > tolerance[left]
            if not more.any() or tally.rays >= MOST_RAYS:
                return
            left = left[more]
            samples = range(tally.rays, 2 * tally.rays)
            tally = tally.of(more) + shadow_rays(
                visibility, pairs[left], sides, sides, keys, samples, seed
            )

    over_ranges(work, len(pairs), PAIRS, "visibility", progress)
    return share, doubt
