"""Boxes that come near to each other, found in a tree of them."""

from collections.abc import Iterator

import numpy as np

CHUNK = 1 << 16  # pairs compared at once


def near_boxes(low, high, touch: float) -> Iterator[tuple]:
    """Yield arrays a, b of the pairs of boxes, in both orders, that are at most a touch apart.

    Every box with itself too. Descends a balanced tree of boxes, depth first by chunks, so that
    memory stays linear.

    Parameters
    ----------
    low, high : (n, 3) float64
        Corners of the boxes.
    touch : float
        Distance along each axis.
    """
    if len(low) == 0:
        return
    place, lows, highs = _tree(low, high)
    stack = [(0, np.zeros((2, 1), int))]
    while stack:
        level, pairs = stack.pop()
        for k in range(CHUNK, pairs.shape[1], CHUNK):
            stack.append((level, pairs[:, k : k + CHUNK]))
        a, b = pairs[:, :CHUNK]
        close = _close(lows[level], highs[level], a, b, 2 * touch)  # either order, as they round
        a, b = a[close], b[close]
        if level + 1 < len(lows):
            below = np.concatenate(
                [(2 * a, 2 * b), (2 * a, 2 * b + 1), (2 * a + 1, 2 * b), (2 * a + 1, 2 * b + 1)],
                axis=1,
            )
            stack.append((level + 1, below[:, below[0] <= below[1]]))
        elif len(a):
            a, b = place[a], place[b]
            a, b = np.concatenate([a, b[a != b]]), np.concatenate([b, a[a != b]])
            close = _close(low.T, high.T, a, b, touch)
            yield a[close], b[close]


def _close(low, high, a, b, touch):
    """Return (p,) bool: which boxes b, with lows and highs (3, n), reach a touch round boxes a."""
    close = np.ones(len(a), bool)
    for x, y in zip(low, high, strict=True):
        close &= (x[b] <= y[a] + touch) & (y[b] >= x[a] - touch)
    return close


def _tree(low, high):
    """Return the boxes' numbers as leaves of a tree halved by median, and each level's boxes."""
    n = len(low)
    depth = int(np.ceil(np.log2(n)))
    place = np.arange(2**depth)
    empty = np.full((2**depth - n, 3), np.inf)
    low, high = np.concatenate([low, empty]), np.concatenate([high, -empty])
    middle = np.concatenate([(low[:n] + high[:n]) / 2, empty])
    for level in range(depth):
        part = place.reshape(2**level, -1)
        real = part < n
        x = middle[part]
        spread = np.max(x, axis=1, where=real[..., None], initial=-np.inf)
        spread = spread - np.min(x, axis=1, where=real[..., None], initial=np.inf)
        axis = spread.argmax(axis=1)
        x = np.take_along_axis(x, axis[:, None, None], axis=2)[..., 0]
        order = x.argsort(axis=1, kind="stable")  # of equal ones the order so far keeps rows
        place = np.take_along_axis(part, order, axis=1).ravel()
    lows, highs = [low[place].T.copy()], [high[place].T.copy()]
    for _ in range(depth):
        lows.insert(0, np.minimum(lows[0][:, ::2], lows[0][:, 1::2]))
        highs.insert(0, np.maximum(highs[0][:, ::2], highs[0][:, 1::2]))
    return place, lows, highs
