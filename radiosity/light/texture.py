"""Textures: quantities that vary over a surface, as a picture of them laid over it.

Texture coordinates (u, v) run from (0, 0), the picture's lower left corner, to (1, 1), its upper
right one. Values stand in the middles of texels and are bilinear between them.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from radiosity.light.bands import mixed

PIECES = 1024  # of an edge that crosses more texels than this, each taken for smooth
AT_ONCE = 1 << 18  # pieces
THIN = 1e-12  # area of a polygon, as a share of its perimeter's square, below which it is a line
ALONG = (np.arange(16) + 0.5) / 16
GAUSS = 0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)


@dataclass(frozen=True)
class Texture:
    """A picture of a quantity.

    Attributes
    ----------
    texels : (h, w, bands) float
        Rows from the top; kept as float32.
    repeat : bool
        Whether the picture repeats beyond its edges; otherwise what stands there goes on.

    Examples
    --------
    >>> board = Texture([[[0.0], [1.0]], [[1.0], [0.0]]])
    >>> board.at([[0.25, 0.25], [0.5, 0.5]]).tolist()
    [[1.0], [0.5]]
    """

    texels: np.ndarray
    repeat: bool = True

    def __post_init__(self):
        texels = np.ascontiguousarray(self.texels, dtype=np.float32)
        if texels.ndim != 3 or 0 in texels.shape:
            raise ValueError(f"texels of shape {texels.shape} must be (h, w, bands), all above 0")
        object.__setattr__(self, "texels", texels)

    @property
    def bands(self) -> int:
        """Return how many bands there are."""
        return self.texels.shape[2]

    @cached_property
    def mean(self) -> np.ndarray:
        """Return the mean (bands,) over the picture."""
        return self.texels.mean(axis=(0, 1), dtype=float)

    @cached_property
    def lowest(self) -> np.ndarray:
        """Return the least texel (bands,)."""
        return self.texels.min(axis=(0, 1)).astype(float)

    @cached_property
    def highest(self) -> np.ndarray:
        """Return the greatest texel (bands,)."""
        return self.texels.max(axis=(0, 1)).astype(float)

    @cached_property
    def grey(self) -> bool:
        """Whether all bands are the same."""
        return bool(np.all(self.texels == self.texels[..., :1]))

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Return the values (k, bands) at texture coordinates (k, 2)."""
        x, y = self._places(uv)
        (i, k, s), (j, m, t) = self._around(x, 1), self._around(y, 0)
        above = _mix(self.texels[j, i], self.texels[j, k], s)
        return _mix(above, _mix(self.texels[m, i], self.texels[m, k], s), t)

    def slope(self, uv: np.ndarray) -> np.ndarray:
        """Return the derivatives (k, bands, 2) by u and v at texture coordinates (k, 2).

        By differences over two texels: continuous, of second order in a texel's size.
        """
        uv, (h, w, _) = np.asarray(uv, float), self.texels.shape
        steps = np.array([1.0 / w, 0.0]), np.array([0.0, 1.0 / h])
        by = [(self.at(uv + d) - self.at(uv - d)) / (2.0 * d.sum()) for d in steps]
        return np.stack(by, axis=2)

    def mean_over(self, polygons: np.ndarray) -> np.ndarray:
        """Return the mean values (n, bands) over polygons (n, 4, 2) of texture coordinates.

        Exact for the bilinear values t, by Green's theorem: int int t dx dy is the integral of
        T dy along the edges, T(x, y) = int_0^x t dx', a polynomial between two texels. Polygons
        without area are lines, or points.
        """
        corners = np.stack(self._places(np.asarray(polygons, float).reshape(-1, 2)), axis=1)
        start = corners.reshape(-1, 4, 2)
        span = np.roll(start, -1, axis=1) - start
        next_x, next_y = np.moveaxis(start + span, -1, 0)
        area = 0.5 * np.sum(start[..., 0] * next_y - next_x * start[..., 1], axis=1)
        lines = np.abs(area) <= THIN * np.linalg.norm(span, axis=2).sum(axis=1) ** 2
        found = self._integrals(start.reshape(-1, 2), span.reshape(-1, 2))
        mean = found.reshape(len(start), 4, found.shape[1]).sum(axis=1)
        mean = mean / np.where(lines, 1.0, area)[:, None]
        mean[lines] = self._mean_along(start[lines], span[lines])
        return np.clip(mean, self.lowest, self.highest)  # rounding

    def _places(self, uv):
        """Return x and y in texels from the middle of the upper left one."""
        h, w, _ = self.texels.shape
        u, v = np.asarray(uv, float).T
        return u * w - 0.5, (1.0 - v) * h - 0.5

    def _around(self, x, axis):
        """Return the texels before and after places along an axis, and the latter's share."""
        n = self.texels.shape[axis]
        if not self.repeat:
            x = np.clip(x, 0.0, n - 1.0)
        before = np.floor(x)
        first = before.astype(np.int64) % n
        after = (first + 1) % n if self.repeat else np.minimum(first + 1, n - 1)
        return first, after, (x - before)[:, None]

    @cached_property
    def _sums(self):
        """Return T (h, w + 1, bands) in the middles of texels, and of the next period's first."""
        texels = self.texels.astype(float)
        pairs = 0.5 * (texels + np.roll(texels, -1, axis=1))
        return np.concatenate([np.zeros_like(texels[:, :1]), np.cumsum(pairs, axis=1)], axis=1)

    def _sum_to(self, x, y):
        """Return T (k, bands) at places x and y."""
        w, (j, m, t) = self.texels.shape[1], self._around(y, 0)
        i, k, s = self._around(x, 1)
        around = np.floor(x / w) if self.repeat else 0.0 * x
        beyond = 0.0 * x if self.repeat else x - np.clip(x, 0.0, w - 1.0)

        def along(row):
            one, two = self.texels[row, i].astype(float), self.texels[row, k]
            whole = self._sums[row, i] + s * (one + 0.5 * s * (two - one))
            return whole + around[:, None] * self._sums[row, w] + beyond[:, None] * one

        return _mix(along(j), along(m), t)

    def _integrals(self, start, span):
        """Return the integrals (e, bands) of T dy along edges from ``start`` by ``span`` (e, 2)."""
        found = np.zeros((len(start), self.texels.shape[2]))
        rising = np.flatnonzero(span[:, 1])
        count = _crossings(start[rising], span[rising])[1].sum(axis=1)
        block = np.cumsum(np.minimum(count, PIECES) + 1) // AT_ONCE
        for b in np.unique(block):
            edge = rising[block == b]
            t, owner = _breaks(start[edge], span[edge])
            piece = np.flatnonzero(owner[1:] == owner[:-1])
            length, e = t[piece + 1] - t[piece], edge[owner[piece]]
            for g in GAUSS:
                at = start[e] + (t[piece] + g * length)[:, None] * span[e]
                value = self._sum_to(*at.T) * (0.5 * length * span[e, 1])[:, None]
                for band in range(value.shape[1]):
                    found[:, band] += np.bincount(e, value[:, band], len(found))
        return found

    def _mean_along(self, start, span):
        """Return the means (n, bands) along the edges (n, 4, 2)."""
        x, y = np.moveaxis(start[:, :, None] + ALONG[:, None] * span[:, :, None], -1, 0)
        h, w, bands = self.texels.shape
        uv = np.stack([(x.ravel() + 0.5) / w, 1.0 - (y.ravel() + 0.5) / h], axis=1)
        value = self.at(uv).reshape(*x.shape, bands).mean(axis=2)
        length = np.linalg.norm(span, axis=2) + 1e-300
        return np.einsum("nk,nkb->nb", length / length.sum(axis=1, keepdims=True), value)


@dataclass(frozen=True)
class Mixed:
    """A picture of three bands as one of other bands, each mixed of the three.

    Attributes
    ----------
    picture : Texture
    shares : (n, 3) float64
        Of the picture's bands in each of these; they add up to 1, so that grey stays grey.
    """

    picture: Texture
    shares: np.ndarray

    @property
    def texels(self) -> np.ndarray:
        """Return the picture's own texels (h, w, 3)."""
        return self.picture.texels

    @property
    def mean(self) -> np.ndarray:
        """Return the mean (n,) over the picture."""
        return self._values(self.picture.mean)

    @cached_property
    def lowest(self) -> np.ndarray:
        """Return the least value (n,) at a texel."""
        return np.min([self._values(row).min(axis=0) for row in self.texels], axis=0)

    @cached_property
    def highest(self) -> np.ndarray:
        """Return the greatest value (n,) at a texel."""
        return np.max([self._values(row).max(axis=0) for row in self.texels], axis=0)

    @property
    def grey(self) -> bool:
        """Whether all bands are the same."""
        return len(self.shares) == 1 or self.picture.grey

    @property
    def bands(self) -> int:
        """Return n."""
        return len(self.shares)

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Return the values (k, n) at texture coordinates (k, 2)."""
        return self._values(self.picture.at(uv))

    def mean_over(self, polygons: np.ndarray) -> np.ndarray:
        """Return the mean values (k, n) over polygons (k, 4, 2), see `Texture.mean_over`."""
        return self._values(self.picture.mean_over(polygons))

    def _values(self, rgb):
        """Return shares of light (..., n) of RGB, without the rounding that leaves [0, 1]."""
        return np.clip(mixed(rgb, self.shares), 0.0, 1.0)


def _mix(one, two, share):
    return one + share * (two - one)


def _crossings(start, span):
    """Return the first line between texels' middles (e, 2) that edges meet, and how many."""
    low, high = np.minimum(start, start + span), np.maximum(start, start + span)
    first = np.ceil(low)
    count = np.where(span == 0.0, 0, np.floor(high) - first + 1).astype(np.int64)
    return first, np.maximum(count, 0)


def _breaks(start, span):
    """Return where (k,), from 0 to 1, edges (e, 2) begin, pass a line and end; and their edges."""
    first, count = _crossings(start, span)
    many = count.sum(axis=1) > PIECES
    count[many] = 0
    every = np.arange(len(start))
    places, owners = [np.zeros(len(start)), np.ones(len(start))], [every, every]
    for axis in (0, 1):
        owner, k = _counted(count[:, axis])
        places.append((first[owner, axis] + k - start[owner, axis]) / span[owner, axis])
        owners.append(owner)
    owner, k = _counted(np.where(many, PIECES - 1, 0))
    t = np.clip(np.concatenate([*places, (k + 1) / PIECES]), 0.0, 1.0)
    owner = np.concatenate([*owners, owner])
    order = np.lexsort((t, owner))
    return t[order], owner[order]


def _counted(count):
    """Return each number repeated as often as ``count`` (e,) says, and 0, 1, ... of each."""
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) - (np.cumsum(count) - count)[owner]


def srgb_to_linear(value: np.ndarray) -> np.ndarray:
    """Return linear light of sRGB values in [0, 1], in the input's shape (IEC 61966-2-1).

    c = v / 12.92 for v <= 0.04045, otherwise ((v + 0.055) / 1.055)^2.4.
    """
    v = np.asarray(value, float)
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
