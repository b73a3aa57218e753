"""Contact: where faces touch, cross or lie on each other, found geometrically before any ray."""

from dataclasses import dataclass, field

import numpy as np

from radiosity.mesh.faces import Faces

TOUCH = 1e-6  # distance that counts as contact, as a share of the scene's size


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


def find_contacts(faces: Faces, emits: np.ndarray) -> Contacts:
    """Find every face that another one touches, crosses or covers.

    Parameters
    ----------
    faces : Faces
    emits : (f,) bool
        Of coplanar faces on the same side the emitter wins, then the one read first.

    Returns
    -------
    Contacts
        Of two faces that look at each other in contact both fronts are covered; of two that look
        the same way the loser's. Where one of the first kind emits and is no part of a body, they
        stand back to back (a lamp on a ceiling turned inside out), and both backs are hidden.
    """
    v = faces.vertices
    low, high = v.min(axis=1), v.max(axis=1)
    touch = TOUCH * np.linalg.norm(high.max(axis=0) - low.min(axis=0))
    normals = faces.normals()
    found = {}
    for f in range(len(faces)):
        near = np.all(low <= high[f] + touch, axis=1) & np.all(high >= low[f] - touch, axis=1)
        height = (v[near] - v[f, 0]) @ normals[f]
        meets = (height.min(axis=1) <= touch) & (height.max(axis=1) >= -touch)
        others = np.flatnonzero(near)[meets]
        contact = _contact(f, others, height[meets], faces, normals, emits, touch)
        if contact is not None:
            found[f] = contact
    return Contacts(found)


def _contact(f, others, height, faces, normals, emits, touch):
    """Return the contact of face f with the others, None where nothing meets its inside."""
    polygon = _corners(faces.vertices[f])
    segments, covers, hides = [], [], []
    for g, h in zip(others, height, strict=True):
        if g == f:
            continue
        other = faces.vertices[g]
        segments += _clipped(_segments(other, h, touch), polygon, normals[f], touch)
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
    distance = np.linalg.norm(faces.vertices[:, :, None] - faces.vertices[f], axis=3)
    shared = np.sum(distance.min(axis=2) <= touch, axis=1)
    return not np.any((shared >= 2) & (np.abs(normals @ normals[f]) < 1 - 1e-6))


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


def _clipped(segments, polygon, normal, touch):
    """Keep the parts of segments that run through the inside of a convex polygon."""
    kept = []
    for a, b in segments:
        lo, hi, length = 0.0, 1.0, np.linalg.norm(b - a)
        for k in range(len(polygon)):
            inward = np.cross(normal, polygon[(k + 1) % len(polygon)] - polygon[k])
            inward /= np.linalg.norm(inward)
            ha, hb = (a - polygon[k]) @ inward, (b - polygon[k]) @ inward
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
        turn = np.sign(_turn(polygon) @ normal)
        for k in range(len(polygon)):
            inward = turn * np.cross(normal, polygon[(k + 1) % len(polygon)] - polygon[k])
            inward /= np.linalg.norm(inward)
            if ((other - polygon[k]) @ inward).max() <= touch:
                return False
    return True


def _inside(points, polygon, normal):
    """Whether points lie inside a convex polygon of the same plane, either way round."""
    turn = np.sign(_turn(polygon) @ normal)
    inside = np.ones(len(points), bool)
    for k in range(len(polygon)):
        inward = turn * np.cross(normal, polygon[(k + 1) % len(polygon)] - polygon[k])
        inside &= (points - polygon[k]) @ inward > 0
    return inside


def _turn(polygon):
    r = polygon - polygon[0]
    return np.cross(r[1:-1], r[2:]).sum(axis=0)


def _corners(quad):
    return quad[:3] if np.array_equal(quad[2], quad[3]) else quad
