"""Polygons with seams: outlines that run to a hole and back, as convex faces."""

import numpy as np

from radiosity.mesh.faces import welded
from radiosity.mesh.triangulate import NoArea

SAME = 1e-7  # share of a polygon's size below which two heights are one


def has_seams(polygon: np.ndarray) -> bool:
    """Whether an outline (n, 3) comes back to a point where it has been."""
    return len(np.unique(_points(polygon))) < len(polygon)


def _points(polygon):
    """Return (n,) the first vertex that lies where each one does."""
    _, first, number = np.unique(welded(polygon), return_index=True, return_inverse=True)
    return first[number.ravel()]


def seamed_parts(polygon: np.ndarray) -> np.ndarray:
    """Return an outline whose edges may run back along themselves as convex faces (k, 4, 3).

    What it winds round is filled, in strips between its vertices: horizontal ones where the
    longest edge is. A triangle repeats its last vertex. Edges must not cross, which is not tested.

    Raises
    ------
    NoArea
        A ValueError: it winds round nothing.

    Examples
    --------
    >>> square = [[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0], [0, 0, 0]]  # round a hole:
    >>> hole = [[1, 1, 0], [1, 2, 0], [2, 2, 0], [2, 1, 0], [1, 1, 0]]
    >>> len(seamed_parts(np.array(square + hole, float)))
    4
    """
    polygon = polygon[_points(polygon)]
    origin = polygon[0]
    axes = _axes(polygon - origin)
    flat = (polygon - origin) @ axes[:2].T
    flat[:, 1] = _levelled(flat[:, 1], SAME * np.ptp(flat, axis=0).max())
    strips = _strips(flat)
    if not strips:
        raise NoArea("has no area: it winds round nothing")
    return origin + np.array([_quad(*strip) for strip in strips]) @ axes[:2]


def _axes(points):
    """Return axes (3, 3): along the longest edge, across it, and the normal."""
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    edges = np.roll(points, -1, axis=0) - points
    along = edges[np.argmax(np.linalg.norm(edges, axis=1))]
    across = np.cross(normal, along)
    if not np.any(across):
        raise NoArea("has no area: it winds round nothing")
    across = across / np.linalg.norm(across)
    normal = normal / np.linalg.norm(normal)
    return np.array([np.cross(across, normal), across, normal])


def _levelled(heights, near):
    """Return heights of which those that differ by less than ``near`` are one."""
    order = np.argsort(heights)
    level = np.cumsum(np.concatenate([[0], np.diff(heights[order]) > near]))
    first = heights[order][np.searchsorted(level, level)]
    found = np.empty_like(heights)
    found[order] = first
    return found


def _strips(flat):
    """Return (low, high, left, right) of the trapezoids, left and right as lines (a, b)."""
    start, end = flat, np.roll(flat, -1, axis=0)
    sloped = start[:, 1] != end[:, 1]
    start, end = start[sloped], end[sloped]
    bottom, top = np.minimum(start, end)[:, 1], np.maximum(start, end)[:, 1]
    turn = np.where(start[:, 1] > end[:, 1], 1, -1)
    levels, open_, done = np.unique(flat[:, 1]), {}, []
    near = SAME * np.ptp(flat, axis=0).max()
    for low, high in zip(levels[:-1], levels[1:], strict=True):
        inside = np.flatnonzero((bottom <= low) & (top >= high))
        sides = _sides(start[inside], end[inside], turn[inside], (low + high) / 2, near)
        pairs = {(int(inside[a]), int(inside[b])) for a, b in sides}
        done += [(*v, *k) for k, v in open_.items() if k not in pairs]
        open_ = {k: (open_.get(k, (low,))[0], high) for k in sorted(pairs)}
    done += [(*v, *k) for k, v in open_.items()]
    lines = np.stack([start, end], axis=1)
    return [(low, high, lines[a], lines[b]) for low, high, a, b in done]


def _sides(start, end, turn, height, near):
    """Yield the left and the right edge of every part of a strip that the outline winds round."""
    x = start[:, 0] + (end - start)[:, 0] * (height - start[:, 1]) / (end - start)[:, 1]
    order, winding, left = np.argsort(x, kind="stable"), 0, None
    for k, here in enumerate(order):
        winding += turn[here]
        seam = k + 1 < len(order) and x[order[k + 1]] - x[here] <= near
        if seam:
            continue  # edges in one place count together
        if left is None and winding:
            left = here
        elif left is not None and not winding:
            yield left, here
            left = None


def _quad(low, high, left, right):
    """Return the corners (4, 2) of a trapezoid, counter-clockwise."""
    corners = [
        [_at(left, low), low], [_at(right, low), low], [_at(right, high), high],
        [_at(left, high), high],
    ]  # fmt: skip
    quad = np.array(corners)
    near = SAME * np.ptp(quad, axis=0).max()
    if quad[1, 0] - quad[0, 0] <= near:
        return quad[[0, 2, 3, 3]]
    return quad[[0, 1, 2, 2]] if quad[2, 0] - quad[3, 0] <= near else quad


def _at(line, height):
    """Return where a line (2, 2) has a height; its ends as they are."""
    (x0, y0), (x1, y1) = line
    if height in (y0, y1):
        return x0 if height == y0 else x1
    return x0 + (x1 - x0) * (height - y0) / (y1 - y0)
