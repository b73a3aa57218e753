"""Cutting convex planar cells along segments, into triangles and quadrilaterals."""

import numpy as np

SMALLEST = 1e-5  # share of a cell's area below which a sliver is not cut off


def cut_cells(
    cells: np.ndarray, segments: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts (k, 4, 3) of convex cells (n, 4, 3) of one plane, and how many a cell (n,).

    See `cut_cell`; ``normal`` is that of the plane, up to its length.
    """
    across = np.cross(normal, segments[:, 1] - segments[:, 0])
    height = np.einsum("nkc,sc->nks", cells, across) - np.sum(across * segments[:, 0], axis=1)
    crossed = np.any((height.max(axis=1) > 0) & (height.min(axis=1) < 0), axis=1)
    parts = [cell[None] for cell in cells]
    for k in np.flatnonzero(crossed):
        parts[k] = cut_cell(cells[k], segments)
    return np.concatenate(parts), np.array([len(part) for part in parts])


def cut_cell(cell: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """Return the parts (k, 4, 3) of a convex cell (4, 3), cut by segments (m, 2, 3) in its plane.

    A segment that passes through the inside cuts the cell along its whole line, so parts stay
    convex. Their areas add up to the cell's.
    """
    polygon = cell[:3] if np.array_equal(cell[2], cell[3]) else cell
    normal = twice_area(polygon)
    smallest = SMALLEST * np.linalg.norm(normal)
    normal = normal / np.linalg.norm(normal)
    parts = [polygon]
    for a, b in segments:
        across = np.cross(normal, b - a)
        across /= np.linalg.norm(across)
        parts = [p for part in parts for p in _split(part, a, b, across, smallest)]
    return np.array([q for part in parts for q in _quads(part)])


def _split(polygon, a, b, across, smallest):
    """Split a convex polygon by the line a-b if the segment itself reaches its inside."""
    h = (polygon - a) @ across
    if not (h.max() > 0 > h.min()) or not _reaches(polygon, a, b, h):
        return [polygon]
    sides = [_half(polygon, h), _half(polygon, -h)]
    if min(np.linalg.norm(twice_area(p)) if len(p) > 2 else 0.0 for p in sides) < smallest:
        return [polygon]
    return sides


def _reaches(polygon, a, b, h):
    """Whether the part of segment a-b inside the polygon has some length."""
    crossings = []
    for k in range(len(polygon)):
        i, j = k, (k + 1) % len(polygon)
        if (h[i] < 0) != (h[j] < 0):
            t = h[i] / (h[i] - h[j])
            crossings.append(polygon[i] + t * (polygon[j] - polygon[i]))
    d = b - a
    along = sorted(float((c - a) @ d / (d @ d)) for c in crossings)
    return min(along[-1], 1.0) - max(along[0], 0.0) > 1e-6 * (along[-1] - along[0])


def common(polygon: np.ndarray, other: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return the part (k, 3) of a convex polygon in another one of its plane, either way round."""
    turn = np.sign(twice_area(other) @ normal)
    for a, b in zip(other, np.roll(other, -1, axis=0), strict=True):
        polygon = _half(polygon, turn * ((polygon - a) @ np.cross(normal, b - a)))
    return polygon


def _half(polygon, h):
    """Return the part of a convex polygon where h >= 0."""
    out = []
    for k in range(len(polygon)):
        i, j = k, (k + 1) % len(polygon)
        if h[i] >= 0:
            out.append(polygon[i])
        if h[i] * h[j] < 0:
            out.append(polygon[i] + h[i] / (h[i] - h[j]) * (polygon[j] - polygon[i]))
    return np.array(out).reshape(-1, 3)


def twice_area(polygon: np.ndarray) -> np.ndarray:
    """Return twice the vector area (3,) of a polygon (k, 3)."""
    r = polygon - polygon[0]
    return np.cross(r[1:-1], r[2:]).sum(axis=0)


def _quads(polygon):
    """Return a convex polygon as quadrilaterals and at most one triangle, fan by fan."""
    while len(polygon) > 4:
        yield polygon[:4]
        polygon = np.concatenate([polygon[:1], polygon[3:]])
    yield polygon if len(polygon) == 4 else polygon[[0, 1, 2, 2]]
