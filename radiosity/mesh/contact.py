"""Contact: where faces touch, cross or lie on each other, found geometrically before any ray."""

from dataclasses import dataclass, field

import numpy as np

from radiosity.mesh.boxes import near_boxes
from radiosity.mesh.cutting import twice_area
from radiosity.mesh.faces import Faces
from radiosity.mesh.facets import Facets, merge_facets

TOUCH = 5e-7  # distance that counts as contact, as a share of the scene's size
CAUTION = 1e-3  # share of that distance by which sums in another order cannot differ
WELDED = 0.5  # the same for facets, which their faces lie off by a fifth of that distance at most


@dataclass(frozen=True)
class FaceContact:
    """What meets one face in its plane.

    Attributes
    ----------
    segments : (m, 2, 3) float64
        Lines in the face's plane along which its patches are cut.
    covers, hides : list of (face index, (3 or 4, 3) polygon)
        Faces that lie on this one's front and cover it; on its back and hide it.
    normal : (3,) float64
    """

    segments: np.ndarray
    covers: list
    hides: list
    normal: np.ndarray

    def behind(self, points: np.ndarray) -> np.ndarray:
        """Return (k, 2): which face lies on front and back of points (k, 3), -1 where none."""
        found = np.full((len(points), 2), -1)
        for side, faces in enumerate((self.covers, self.hides)):
            for index, polygon in faces:
                free = found[:, side] < 0
                found[free & _inside(points, polygon, self.normal), side] = index
        return found


@dataclass(frozen=True)
class Contacts:
    """All contacts of a scene: face index to `FaceContact`; faces without any are absent."""

    faces: dict[int, FaceContact] = field(default_factory=dict)


def find_contacts(
    faces: Faces, emits: np.ndarray, count: int | None = None, facets: Facets | None = None
) -> Contacts:
    """Find every face that another one touches, crosses or covers.

    Parameters
    ----------
    faces : Faces
    emits : (f,) bool
        Of coplanar faces on the same side the emitter wins, then the one read first.
    count : int, optional
        Look for contacts of so many faces only, the first ones, with any.
    facets : Facets, optional
        Those of the faces, where they are known.

    Returns
    -------
    Contacts
        Of two faces that look at each other in contact both fronts are covered; of two that look
        the same way the loser's. Where one of the first kind emits and is no part of a body, they
        stand back to back (a lamp on a ceiling turned inside out), and both backs are hidden.
        Which others stand so, `radiosity.transport.facing.settled` finds.
    """
    v = faces.vertices
    touch = TOUCH * np.linalg.norm(np.ptp(v, axis=(0, 1))) if len(v) else 0.0
    normals = faces.normals()
    count = len(faces) if count is None else count
    facets = merge_facets(faces) if facets is None else facets
    first, second = _candidates(faces, facets, normals, touch, count)
    found = {}
    for f, others in _by_first(first, second):
        height = (v[others] - v[f, 0]) @ normals[f]
        meets = (height.min(axis=1) <= touch) & (height.max(axis=1) >= -touch)
        contact = _contact(f, others[meets], height[meets], faces, normals, emits, touch)
        if contact is not None:
            found[f] = contact
    return Contacts(found)


def _by_first(first, second):
    """Yield each first face with the sorted second faces of its pairs."""
    order = np.lexsort((second, first))
    faces, begin = np.unique(first[order], return_index=True)
    parts = np.split(second[order], begin[1:])  # one, empty, of no pairs
    yield from zip(faces.tolist(), parts, strict=False)


def _candidates(faces, facets, normals, touch, count):
    """Return pairs of faces (f, g), f < count, such that g may leave a mark in f, few without.

    Only of facets that may: faces of one facet, or of two that meet at an edge, leave none. Of all
    where facets are many, or rounding so far from the origin blurs them.
    """
    v, of = faces.vertices, facets.facet
    blur = 8.0 * np.finfo(float).eps * np.abs(v).max(initial=0.0)
    if 2 * len(facets.count) > len(v) or blur > 0.1 * touch:
        return _reaching(v, normals, touch, CAUTION, (_vertices, _marks), lambda f, g: f < count)
    pairs = _reaching(facets.vertices, facets.normal, touch, WELDED, (_vertices,))
    m = len(of)
    code = pairs[0] * m + pairs[1]
    some = np.flatnonzero(np.isin(of, pairs))

    def wanted(f, g):
        f, g = some[f], some[g]
        return (f < count) & np.isin(of[f] * m + of[g], code)

    return some[_reaching(v[some], normals[some], touch, CAUTION, (_vertices, _marks), wanted)]


def _reaching(v, normals, touch, caution, kinds, wanted=None):
    """Return pairs of convex polygons (f, g), if wanted(f, g), such that g may reach inside f.

    By each of the ``kinds`` of points in turn, `_vertices` and `_marks`. Coordinates are the first
    axis and polygons the last one here, so that sums run over long arrays.
    """
    low, high = v.min(axis=1), v.max(axis=1)
    v, normals = (np.ascontiguousarray(x.T) for x in (v, normals))
    inward = np.cross(normals[:, None], np.roll(v, -1, axis=1) - v, axis=0)
    with np.errstate(invalid="ignore"):  # a repeated vertex bounds nothing
        inward /= np.sqrt(_dot(inward, inward))
    level = _dot(inward, v - v[:, :1])
    near, far = (1 - caution) * touch, (1 + caution) * touch
    found = [np.empty((2, 0), int)]
    for f, g in near_boxes(low, high, far):
        keep = f != g
        if wanted is not None:
            keep &= wanted(f, g)
        f, g = f[keep], g[keep]
        for points in kinds:
            at, there = points(v[..., g], v[:, 0, f], normals[:, f], far)
            keep = there.any(axis=0)
            at, there, f, g = at[..., keep], there[..., keep], f[keep], g[keep]
            keep = _reach_inside(at, there, inward[..., f], level[:, f], near)
            f, g = f[keep], g[keep]
        found.append(np.stack([f, g]))
    return np.concatenate(found, axis=1)


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _vertices(v, origin, normal, bound):
    """Return vertices v (3, k, p) seen from origins, there (k, p) if they reach their planes."""
    v = v - origin[:, None]
    height = _dot(v, normal[:, None])
    meets = (height.min(axis=0) <= bound) & (height.max(axis=0) >= -bound)
    return v, np.broadcast_to(meets, height.shape)


def _marks(v, origin, normal, bound):
    """Return where polygons meet planes (3, 2 k, p) seen from origins, there or not (2 k, p)."""
    v = v - origin[:, None]
    height = _dot(v, normal[:, None])
    after = np.roll(height, -1, axis=0)
    across = height * after < 0
    share = np.divide(height, height - after, out=np.zeros_like(height), where=across)
    crossing = v + share * (np.roll(v, -1, axis=1) - v)
    on = np.abs(height) <= bound
    return np.concatenate([v, crossing], axis=1), np.concatenate([on, across])


def _reach_inside(points, there, inward, level, bound):
    """Return (p,) bool: which polygons have no side that all points there are at or beyond."""
    inside = np.ones(len(there.T), bool)
    for side, start in zip(inward.swapaxes(0, 1), level, strict=True):
        depth = np.where(there, _dot(side[:, None], points) - start, -np.inf).max(axis=0)
        inside &= ~(depth <= bound)
    return inside


def _contact(f, others, height, faces, normals, emits, touch):
    """Return the contact of face f with the others, None where nothing meets its inside."""
    polygon = _corners(faces.vertices[f])
    inward = _inward(polygon, normals[f])
    segments, covers, hides = [], [], []
    for g, h in zip(others, height, strict=True):
        other = faces.vertices[g]
        segments += _clipped(_segments(other, h, touch), polygon, inward, touch)
        if np.all(np.abs(h) <= touch) and _overlap(polygon, _corners(other), normals[f], touch):
            opposed = normals[f] @ normals[g] < 0
            lamp = f if emits[f] else g
            if opposed and emits[f] != emits[g] and _stands_alone(lamp, faces, normals, touch):
                hides.append((int(g), _corners(other)))
            elif opposed or _loses(f, g, emits):
                covers.append((int(g), _corners(other)))
    covers.sort(key=lambda cover: (not emits[cover[0]], cover[0]))  # the winner of several
    if not segments and not covers and not hides:
        return None
    return FaceContact(np.array(segments).reshape(-1, 2, 3), covers, hides, normals[f])


def _stands_alone(f, faces, normals, touch):
    """Whether no face of another plane shares two corners with face f, as in a body or a room."""
    v, lamp = faces.vertices, faces.vertices[f]
    low, high = lamp.min(axis=0) - 2 * touch, lamp.max(axis=0) + 2 * touch
    near = np.flatnonzero(np.any(np.all((v >= low) & (v <= high), axis=2), axis=1))
    distance = np.linalg.norm(v[near][:, :, None] - lamp, axis=3)
    shared = np.sum(distance.min(axis=2) <= touch, axis=1)
    return not np.any((shared >= 2) & (np.abs(normals[near] @ normals[f]) < 1 - 1e-6))


def _loses(f, g, emits):
    """Whether face g, in the same plane and looking the same way, covers the front of face f."""
    if emits[f] != emits[g]:
        return bool(emits[g])
    return bool(g < f)


def _segments(polygon, h, touch):
    """Return where a polygon with heights h meets the plane: edges in it, or the crossing."""
    on = np.abs(h) <= touch
    segments, crossings = [], []
    for k in range(4):
        i, j = k, (k + 1) % 4
        if np.array_equal(polygon[i], polygon[j]):
            continue
        if on[i] and on[j]:
            segments.append((polygon[i], polygon[j]))
        elif on[i]:
            crossings.append(polygon[i])
        elif not on[j] and h[i] * h[j] < 0:
            crossings.append(polygon[i] + h[i] / (h[i] - h[j]) * (polygon[j] - polygon[i]))
    if not segments and len(crossings) == 2:
        segments.append(tuple(crossings))
    return segments


def _clipped(segments, polygon, inward, touch):
    """Keep the parts of segments that run through the inside of a convex polygon."""
    kept = []
    for a, b in segments:
        lo, hi, length = 0.0, 1.0, np.linalg.norm(b - a)
        for corner, inside in zip(polygon, inward, strict=True):
            ha, hb = (a - corner) @ inside, (b - corner) @ inside
            if max(ha, hb) <= touch:
                lo, hi = 1.0, 0.0
            elif ha < 0 or hb < 0:
                t = ha / (ha - hb)
                lo, hi = (max(lo, t), hi) if ha < hb else (lo, min(hi, t))
        if (hi - lo) * length > touch:
            kept.append((a + lo * (b - a), a + hi * (b - a)))
    return kept


def _overlap(p, q, normal, touch):
    """Whether two convex polygons of one plane share some area (separating lines)."""
    for polygon, other in ((p, q), (q, p)):
        inward = np.sign(twice_area(polygon) @ normal) * _inward(polygon, normal)
        for corner, inside in zip(polygon, inward, strict=True):
            if ((other - corner) @ inside).max() <= touch:
                return False
    return True


def _inward(polygon, normal):
    """Return unit normals (k, 3) of a polygon's sides in its plane; of a ccw one they point in."""
    inward = np.cross(normal, np.roll(polygon, -1, axis=0) - polygon)
    return inward / np.linalg.norm(inward, axis=1, keepdims=True)


def _inside(points, polygon, normal):
    """Whether points lie inside a convex polygon of the same plane, either way round."""
    turn = np.sign(twice_area(polygon) @ normal)
    inside = np.ones(len(points), bool)
    for k in range(len(polygon)):
        inward = turn * np.cross(normal, polygon[(k + 1) % len(polygon)] - polygon[k])
        inside &= (points - polygon[k]) @ inward > 0
    return inside


def _corners(quad):
    return quad[:3] if np.array_equal(quad[2], quad[3]) else quad
