"""Triangulation: a planar simple polygon, convex or not, as convex faces."""

import numpy as np

from radiosity.mesh.faces import PLANAR

CROSSES = "crosses itself: give the vertices in order around the outline"
MOST = 4096  # vertices; the work grows as their square
STRAIGHT = 1e-9  # height over the longest edge below which three points lie on one line


class NoArea(ValueError):
    """All vertices of a polygon lie on one line."""


def convex_quads(quads: np.ndarray) -> np.ndarray:
    """Return (q,) bool: which quadrilaterals (q, 4, 3) are planar and strictly convex."""
    edge = np.roll(quads, -1, axis=1) - quads
    length = np.linalg.norm(edge, axis=2, keepdims=True)
    normal = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    height = np.ptp(np.einsum("qkx,qx->qk", quads - quads[:, :1], normal), axis=1)
    turn = np.einsum("qkx,qx->qk", np.cross(np.roll(edge, 1, axis=1), edge), normal)
    size = length.max(axis=(1, 2), initial=0)
    return (turn.min(axis=1) > STRAIGHT * size**2) & (height <= PLANAR * size)


def triangulate(polygon: np.ndarray, flatness: float = PLANAR) -> np.ndarray:
    """Return a simple polygon as convex faces that look the same way.

    Parameters
    ----------
    polygon : (n, 3) float
        Vertices in order; may be concave. Repeated neighbours and vertices in the middle of a
        straight edge are dropped.
    flatness : float
        Largest deviation from the mean plane, as a share of the polygon's size.

    Returns
    -------
    (k, 4, 3) float64
        A convex quadrilateral or a triangle as it is, otherwise triangles by ear clipping
        (G. H. Meisters, Polygons have ears, 1975); triangles repeat their last vertex. A
        quadrilateral that is not planar becomes two triangles.

    Raises
    ------
    NoArea
        A ValueError: all vertices lie on one line.
    ValueError
        Fewer than 3 vertices or more than 4096, not planar or crossing itself; the text says which
        and where.
    """
    polygon = np.asarray(polygon, float)
    return polygon[convex_parts(polygon, flatness)]


def convex_parts(polygon: np.ndarray, flatness: float = PLANAR) -> np.ndarray:
    """Return which vertices (k, 4) the faces of `triangulate` have; it raises what that does."""
    if len(polygon) < 3:
        raise ValueError(f"has {len(polygon)} vertices, a polygon needs at least 3")
    if len(polygon) > MOST:
        raise ValueError(f"has {len(polygon)} vertices, at most {MOST} are split: divide it")
    if len(polygon) == 4 and convex_quads(polygon[None])[0]:
        return np.arange(4)[None]
    centre = polygon.mean(axis=0)
    size = np.linalg.norm(np.ptp(polygon, axis=0))
    rounding = 4 * np.finfo(float).eps * np.abs(polygon).max()
    axes = _plane(polygon - centre, STRAIGHT * size + rounding)
    if len(polygon) > 4:
        _check_planar((polygon - centre) @ axes[2], size, flatness)
    flat = (polygon - centre) @ axes[:2].T
    _check_simple(flat)
    corners = _without_straight(flat, size)
    ears = _ears(flat[corners], size)
    return corners[ears][:, [0, 1, 2, 2]]


def _plane(points, thinnest):
    """Return axes (3, 3) of the mean plane, the third its normal on the front."""
    axes = np.linalg.svd(points, full_matrices=False)[2]
    if np.abs(points @ axes[1]).max() <= thinnest:
        raise NoArea("has no area: all its vertices lie on one line")
    area = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    if area @ axes[2] < 0:
        axes = axes * np.array([[1], [1], [-1]])
    if np.linalg.det(axes) < 0:
        axes = axes[[1, 0, 2]]
    return axes


def _check_planar(height, size, flatness):
    worst = int(np.argmax(np.abs(height)))
    if abs(height[worst]) > flatness * size:
        raise ValueError(
            f"is not planar: vertex {worst} lies {abs(height[worst]):.3g} off the mean plane, "
            f"at most {flatness * size:.3g} ({flatness:g} of its size) passes as rounding; "
            "split it into triangles"
        )


def _check_simple(p):
    """Raise where two edges of a polygon (n, 2) cross each other."""
    q = np.roll(p, -1, axis=0)
    for k in range(len(p) - 2):
        here = slice(k + 2, len(p))
        apart = _side(p[k], q[k], p[here]) * _side(p[k], q[k], q[here]) < 0
        across = _side(p[here], q[here], p[k]) * _side(p[here], q[here], q[k]) < 0
        hit = np.flatnonzero(apart & across)
        if len(hit):
            raise ValueError(
                f"crosses itself: edge {k} (from vertex {k}) meets edge {k + 2 + hit[0]}; "
                "give the vertices in order around the outline"
            )


def _side(a, b, c):
    """Return twice the signed area of the triangles a, b, c (..., 2)."""
    u, v = b - a, c - a
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _without_straight(p, size):
    """Return indices of the vertices at which the outline turns."""
    kept = list(range(len(p)))
    k = 0
    while k < len(kept) and len(kept) > 3:
        a, b, c = p[kept[k - 1]], p[kept[k]], p[kept[(k + 1) % len(kept)]]
        forward = (b - a) @ (c - b) >= 0
        if forward and abs(_side(a, b, c)) <= STRAIGHT * size * np.linalg.norm(c - a):
            del kept[k]
            k = max(k - 1, 0)
        else:
            k += 1
    return np.array(kept)


def _ears(p, size):
    """Return triangles (n - 2, 3) of indices into a counter-clockwise polygon (n, 2)."""
    fan = np.array([[0, 1, 2], [0, 2, 3]])
    if len(p) == 4 and min(_side(*p[f]) for f in fan) > 0:  # the diagonal that most programs take
        return fan
    left, ears = list(range(len(p))), []
    while len(left) > 3:
        k = _next_ear(p[left])
        ears.append((left[k - 1], left[k], left[(k + 1) % len(left)]))
        del left[k]
    ears.append(tuple(left))
    ears = [ear for ear in ears if _side(*p[list(ear)]) > 1e-12 * size**2]
    area = sum(_side(*p[list(ear)]) for ear in ears)
    if not ears or abs(area - _double_area(p)) > STRAIGHT * size**2:
        raise ValueError(CROSSES)
    return np.array(ears)


def _next_ear(points):
    """Return the best shaped corner of a polygon (n, 2) that can be cut off."""
    a, b, c = np.roll(points, 1, axis=0), points, np.roll(points, -1, axis=0)
    longest = np.max([((u - v) ** 2).sum(axis=1) for u, v in ((a, b), (b, c), (c, a))], axis=0)
    shape = _side(a, b, c) / np.maximum(longest, 1e-300)
    for k in np.argsort(-shape, kind="stable"):
        if shape[k] < 0:
            break
        if not _holds(a[k], b[k], c[k], points):
            return int(k)
    raise ValueError(CROSSES)


def _holds(a, b, c, points):
    """Whether a triangle holds a point other than its own corners."""
    inside = (_side(a, b, points) >= 0) & (_side(b, c, points) >= 0) & (_side(c, a, points) >= 0)
    corner = np.all(points == a, 1) | np.all(points == b, 1) | np.all(points == c, 1)
    return bool(np.any(inside & ~corner))


def _double_area(p):
    return float(np.sum(_side(np.zeros(2), p, np.roll(p, -1, axis=0))))
