"""How much of one polygon is seen from another: shadow rays between pairs, compiled."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from radiosity.mesh.patches import Patches
from radiosity.transport.borrow import borrowed
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
    digits, here, there = sobol_digits(first, count), np.empty((4, 4)), np.empty((4, 4))
    for m in range(len(pairs)):
        i, j = pairs[m, 0], pairs[m, 1]
        to, of = hashed(keys[i], j, seed), hashed(keys[i], j + OTHER, seed)
        _bilinear_map(p[i], np_[i], centre, scale, lift, here)
        _bilinear_map(q[j], nq[j], centre, scale, lift, there)
        for k in range(count):
            r = m * count + k
            s, t = shifted(digits[k, 0], to), shifted(digits[k, 1], to >> np.uint64(32))
            u, v = shifted(digits[k, 2], of), shifted(digits[k, 3], of >> np.uint64(32))
            ci = cj = d2 = 0.0
            for c in range(3):
                x, y = _at(there[c], s, t), _at(here[c], u, v)
                start[r, c], span[r, c] = y, x - y
                ci += (x - y) * np_[i, c]
                cj += (y - x) * nq[j, c]
                d2 += (x - y) * (x - y)
            a, b = abs(_at(there[3], s, t)), abs(_at(here[3], u, v))
            stretch = a * b if b > 0.0 else a
            weight[r] = stretch * ci * cj / (d2 * d2) if ci > 0.0 and cj > 0.0 else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _bilinear_map(polygon, normal, centre, scale, lift, terms):
    """Write how points of a quadrilateral depend on their place on the unit square.

    Rows of ``terms`` (4, 4): their coordinates, scaled and lifted off it; the stretch of area,
    negative where it turns clockwise about ``normal``, its own. Columns: what multiplies 1, s, t
    and s t.
    """
    for c in range(3):
        v0, v1, v2, v3 = polygon[0, c], polygon[1, c], polygon[2, c], polygon[3, c]
        terms[c, 0] = (v0 - centre[c]) * scale + lift * normal[c]
        terms[c, 1], terms[c, 2], terms[c, 3] = v1 - v0, v3 - v0, v0 - v1 + v2 - v3
    terms[3] = 0.0
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        n = normal[a]
        terms[3, 0] += n * (terms[b, 1] * terms[c, 2] - terms[c, 1] * terms[b, 2])
        terms[3, 1] += n * (terms[b, 1] * terms[c, 3] - terms[c, 1] * terms[b, 3])
        terms[3, 2] += n * (terms[b, 3] * terms[c, 2] - terms[c, 3] * terms[b, 2])
    terms[:3, 1:] *= scale


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _at(row, s, t):
    return row[0] + s * row[1] + t * row[2] + s * t * row[3]


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
        Planar, with their own unit normals. A point is a polygon whose vertices are all the same.
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
