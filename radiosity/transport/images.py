"""Planar mirrors, exactly: the scene unfolded at them, seen through them as through windows (E23).

What comes from a mirror of the same share k_r at all angles comes, k_r times, from the mirrored
scene behind it. So what arrives by way of mirrors m_1, m_2, .. is computed as what arrives
straight, in a scene of its own: what lies in front of m_1, the image in it of what lies between m_1
and m_2, and so on, parted by screens in the planes of the mirrors with these left open.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from radiosity.light.coat import is_coat
from radiosity.light.coherent import Constant
from radiosity.mesh.elements import Elements
from radiosity.mesh.faces import Faces, turning
from radiosity.mesh.patches import Patches
from radiosity.transport.arrival import Senders, make_senders, weights_of
from radiosity.transport.exchange import make_geometry
from radiosity.transport.irradiance import Lights, direct_irradiance
from radiosity.transport.lamps import lamp_irradiance
from radiosity.transport.optics import Optics
from radiosity.transport.visibility import Visibility

MOST_PLANES, MOST_IMAGES = 12, 6  # of mirrors; of sequences of mirrors followed exactly
LEAST = 5e-3  # share of the light below which a sequence is left to rays
FLAT = 1e-7  # distance to a plane, as a share of the scene's size, that is rounding


@dataclass(frozen=True)
class Plane:
    """The mirrors of one plane that face one way and send on the same share.

    ``level`` is normal . y on it; ``windows`` (k, 4, 3) are the mirrors.
    """

    normal: np.ndarray
    level: float
    windows: np.ndarray
    share: np.ndarray

    def heights(self, points: np.ndarray) -> np.ndarray:
        """Return (...) how far points (..., 3) lie in front."""
        return points @ self.normal - self.level


@dataclass(frozen=True)
class Planes:
    """The mirrors of a scene that are followed exactly.

    Attributes
    ----------
    planes : tuple of Plane
    of_side : (f, 2) int
        Plane of each face's front and back, -1 for none.
    sequences : tuple of tuple of int
        Of planes, in the order in which light that is looked for meets them.
    """

    planes: tuple[Plane, ...]
    of_side: np.ndarray
    sequences: tuple

    @cached_property
    def _table(self) -> np.ndarray:
        """Return the sequence after each one and each plane; the last row and column are -1."""
        known = {seq: k + 1 for k, seq in enumerate(self.sequences)}
        table = np.full((len(self.sequences) + 2, len(self.planes) + 1), -1)
        for k, seq in enumerate(((), *self.sequences)):
            for plane in range(len(self.planes)):
                table[k, plane] = known.get((*seq, plane), -1)
        return table

    def after(self, state: np.ndarray, face: np.ndarray, back: np.ndarray) -> np.ndarray:
        """Return (k,) which sequence rays have gone after a mirror: 0 for none, -1 for others."""
        return self._table[state, self.of_side[face, back]]


def find_planes(
    faces: Faces, patches: Patches, optics: Optics, size: float
) -> Planes | None:
    """Return the mirrors that are followed exactly, None where there are none, or too many.

    Nor where a medium absorbs, which dims the light on its way. Of a mirror that other faces cover
    in part the ``patches`` tell what is left.
    """
    normals = faces.normals()
    of_side, planes, keys = np.full((len(faces), 2), -1), [], {}
    for face in range(len(faces)):
        for back, side in enumerate(optics.sides[optics.material[face]]):
            if side is None or not _is_plain(side) or faces.is_curved[face]:
                continue
            normal = -normals[face] if back else normals[face]
            level = float(normal @ faces.vertices[face].mean(axis=0))
            if (faces.vertices @ normal).max() - level <= FLAT * size:
                continue  # nothing to be seen in it
            about = np.round(np.append(normal, level / size) / (10 * FLAT)).astype(int)
            key = (*about.tolist(), *side.mirror.share.tolist())
            k = keys.setdefault(key, len(keys))
            of_side[face, back] = k
            if k == len(planes):
                planes.append((normal, level, [], side.mirror.share))
            planes[k][2].extend(_uncovered(faces, patches, face, back))
    if not 0 < len(planes) <= MOST_PLANES or optics.absorption.any():
        return None
    made = tuple(
        Plane(n, d, np.array(v).reshape(-1, 4, 3), share) for n, d, v, share in planes
    )
    return Planes(made, of_side, _sequences(made, size))


def _uncovered(faces, patches, face, back):
    """Return the polygons of a face's side that nothing lies on: the face where nothing does."""
    mine = np.flatnonzero(patches.face[: patches.fronts] == face)
    bare = patches.behind[mine, back] < 0
    return [faces.vertices[face]] if bare.all() else list(patches.vertices[mine[bare]])


def _is_plain(side):
    """Whether a side mirrors the same share at all angles."""
    covered = is_coat(side.lobe)
    return isinstance(side.mirror, Constant) and bool(side.mirror.share.any()) and not covered


def _sequences(planes, size):
    """Return the sequences of planes that may be seen one in the other, the strongest first."""
    flat, found, shares = FLAT * size, [], []
    fresh = [((), 1.0)]
    while fresh and len(found) < MOST_IMAGES:
        longer = []
        for seq, share in fresh:
            for k, plane in enumerate(planes):
                part = share * float(plane.share.max())
                unseen = bool(seq) and not _face(planes[seq[-1]], plane, flat)
                if part < LEAST or not len(plane.windows) or unseen:
                    continue
                longer.append(((*seq, k), part))
        longer.sort(key=lambda pair: -pair[1])
        fresh = longer[: MOST_IMAGES - len(found)]
        found += [seq for seq, _ in fresh]
        shares += [part for _, part in fresh]
    return tuple(found)


def _face(one, other, flat):
    there = one.heights(other.windows).max() > flat
    return there and other.heights(one.windows).max() > flat


@dataclass(frozen=True)
class Image:
    """What is seen by way of one sequence of mirrors.

    Attributes
    ----------
    share : (bands,) float64
        Of its light that they leave.
    first : Plane
        The mirror that is looked into.
    senders : Senders
        Parts of elements, mirrored, in the unfolded scene.
    fold : (width parts, width n) csr_array
        From elements to these parts.
    lights : Lights
        Mirrored.
    flat : float
        Height over the plane from which a point sees into the mirror.
    """

    share: np.ndarray
    first: Plane
    senders: Senders
    fold: csr_array
    lights: Lights
    flat: float

    def sees(self, points: np.ndarray) -> np.ndarray:
        """Return (k,) bool: which points lie in front of the mirror that is looked into."""
        return self.first.heights(points) > self.flat

    def weights(self, points, normals, first: int, lift: float, seed: int) -> np.ndarray:
        """Return (k, width n) how irradiance at points depends on elements, for a share of 1."""
        found = np.zeros((len(points), self.fold.shape[1]))
        k = np.flatnonzero(self.sees(points))
        if len(k) and self.fold.shape[0]:
            seen, _ = weights_of(self.senders, points[k], normals[k], first, lift=lift, seed=seed)
            found[k] = seen @ self.fold
        return found

    def lamplight(self, points, normals) -> np.ndarray:
        """Return the irradiance (k, bands) of points by lamps in the mirrors, W/m2."""
        found, lights = np.zeros((len(points), len(self.share))), self.lights
        k = np.flatnonzero(self.sees(points))
        if lights.lamps and len(k):
            found[k] = self.share * lamp_irradiance(
                self.senders.visibility, lights.lamps, points[k], normals[k], lights.unit_m
            )
        return found

    def direct(self, points, normals, keys, samples: range, seed: int) -> np.ndarray:
        """Return the irradiance (k, bands) by all lights in the mirrors, W/m2."""
        found = np.zeros((len(points), len(self.share)))
        k = np.flatnonzero(self.sees(points))
        if self.lights and len(k):
            found[k] = self.share * direct_irradiance(
                self.senders.visibility, self.lights, points[k], normals[k], keys[k], samples, seed
            )
        return found


def make_images(
    faces: Faces, planes: Planes, elements: Elements, lights: Lights, tolerance: np.ndarray
) -> tuple[Image, ...]:
    """Return what elements and lights look like in mirrors; ``tolerance`` (n,) of factors."""
    size = float(np.ptp(faces.vertices, axis=(0, 1)).max())
    return tuple(
        _image([planes.planes[k] for k in seq], faces, elements, lights, tolerance, size)
        for seq in planes.sequences
    )


def _image(chain, faces, elements, lights, tolerance, size):
    flat = FLAT * size
    turn, shift = np.eye(3), np.zeros(3)
    parts = [_in_front(faces.vertices, [chain[0]], flat)[0]]
    for k, plane in enumerate(chain):
        parts.append(_put(_screen(plane, faces.vertices), turn, shift))
        mirror = np.eye(3) - 2.0 * np.outer(plane.normal, plane.normal)
        shift = shift + turn @ (2.0 * plane.level * plane.normal)
        turn = turn @ mirror
        parts.append(_put(_in_front(faces.vertices, chain[k : k + 2], flat)[0], turn, shift))
    scene = Faces.from_polygons(np.concatenate(parts), 0, 0, merge=False)
    visibility = Visibility(scene)
    pieces, owner = _in_front(elements.vertices, [chain[-1]], flat)
    seen = _put(pieces, turn, shift)
    senders, fold = _senders(seen, owner, elements, turn, shift, visibility, tolerance)
    share = np.prod([plane.share for plane in chain], axis=0)
    seen = _lights(lights, chain[-1], turn, shift, flat)
    return Image(share, chain[0], senders, fold, seen, flat)


def _lights(lights, last, turn, shift, flat):
    """Return what of lights is in front of a plane, mirrored."""
    parts, owner = _in_front(lights.polygons, [last], flat)
    lamps = tuple(lamp.moved(turn, shift) for lamp in lights.lamps if _lit_by(last, lamp))
    return Lights(
        _put(parts, turn, shift), lights.normals[owner] @ turn.T, lights.exitance[owner], lamps,
        lights.unit_m, np.asarray(lights.face, int)[owner],
    )  # fmt: skip


def _lit_by(plane, lamp):
    """Whether a lamp shines on the front of a plane."""
    position = getattr(lamp, "position", None)
    if position is None:
        return bool(lamp.direction @ plane.normal < 0.0)
    return bool(plane.heights(position) > 0.0)


def _put(polygons, turn, shift):
    """Return polygons (k, 4, 3) moved, counter-clockwise still from the side that they face."""
    moved = polygons @ turn.T + shift
    return moved if np.linalg.det(turn) > 0 else _turned(moved)


def _turned(polygons):
    """Return polygons wound the other way; triangles repeat their last corner still."""
    return np.take_along_axis(polygons, turning(polygons)[..., None], axis=1)


def _in_front(polygons, planes, flat):
    """Return the parts (k, 4, 3) of polygons in front of planes, and which each comes from."""
    parts, owner = [], []
    for k, polygon in enumerate(polygons):
        part = _corners(polygon)
        for plane in planes:
            part = _cut(part, plane.heights(part), flat)
        for quad in _quads(part):
            parts.append(quad)
            owner.append(k)
    return np.array(parts).reshape(-1, 4, 3), np.array(owner, int)


def _corners(polygon):
    return polygon[:3] if np.array_equal(polygon[3], polygon[2]) else polygon


def _cut(polygon, height, flat):
    """Return the corners of a convex polygon's part where heights are above 0; none if none is."""
    height = np.where(np.abs(height) <= flat, 0.0, height)
    if not len(polygon) or height.max() <= 0.0:
        return polygon[:0]
    kept = []
    for k in range(len(polygon)):
        m = (k + 1) % len(polygon)
        if height[k] >= 0.0:
            kept.append(polygon[k])
        if height[k] * height[m] < 0.0:
            t = height[k] / (height[k] - height[m])
            kept.append(polygon[k] + t * (polygon[m] - polygon[k]))
    return np.array(kept)


def _quads(polygon):
    """Yield a convex polygon as quadrilaterals, at most one of them a triangle."""
    for k in range(1, len(polygon) - 1, 2):
        last = min(k + 2, len(polygon) - 1)
        yield polygon[[0, k, k + 1, last]]


def _screen(plane, vertices):
    """Return the polygons (k, 4, 3) that leave nothing open in a plane but its windows.

    As far as the scene reaches over it: a way from its front to an image of it crosses it there.
    """
    one = np.cross(plane.normal, np.eye(3)[np.argmin(np.abs(plane.normal))])
    one /= np.linalg.norm(one)
    axes = np.stack([one, np.cross(plane.normal, one)])
    flat = vertices.reshape(-1, 3) @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    square = np.array([[low[0], low[1]], [high[0], low[1]], high, [low[0], high[1]]])
    left = [square @ axes + plane.level * plane.normal]
    flat = FLAT * float(np.max(high - low))
    for window in plane.windows:
        left = [part for polygon in left for part in _without(polygon, _corners(window), flat)]
    found = [quad for polygon in left for quad in _quads(polygon)]
    return np.array(found).reshape(-1, 4, 3)


def _without(polygon, window, flat):
    """Yield the convex parts of a polygon outside of a window in its plane."""
    around = np.cross(window[1] - window[0], window[2] - window[0])
    rest = polygon
    for k in range(len(window)):
        edge = window[(k + 1) % len(window)] - window[k]
        outward = np.cross(edge, around)
        outward /= max(np.linalg.norm(outward), 1e-300)
        height = (rest - window[k]) @ outward if len(rest) else np.zeros(0)
        outside = _cut(rest, height, flat)
        if len(outside):
            yield outside
        rest = _cut(rest, -height, flat)


def _senders(polygons, owner, elements, turn, shift, visibility, tolerance):
    """Return mirrored parts of elements as senders, and how their fields follow from elements'."""
    made = Faces(polygons, np.zeros(len(owner), int), np.zeros(len(owner), int))
    area = made.areas() if len(owner) else np.zeros(0)
    good = np.flatnonzero(area > 0.0)
    polygons, owner, area = polygons[good], owner[good], area[good]
    normal = elements.normal[owner] @ turn.T
    centroid = _centroids(polygons)
    axes = elements.axes[owner] @ turn.T
    parts = Elements(elements.order, polygons, normal, centroid, axes)
    centre, scale = visibility.centre, visibility.scale
    geometry = make_geometry(
        (polygons - centre) * scale, normal, (centroid - centre) * scale, area * scale**2
    )
    senders = make_senders(parts, geometry, visibility, tolerance[owner])
    was = elements.centroid[owner] @ turn.T + shift
    return senders, _fold(owner, len(elements), elements.width, axes, centroid - was)


def _fold(owner, n, width, axes, apart):
    """Return (width parts, width n): a part's field about its own centroid from its element's."""
    k, parts = np.arange(len(owner)), len(owner)
    rows, columns, values = [k], [owner], [np.ones(parts)]
    for a in range(width - 1):
        rows += [k, (a + 1) * parts + k]
        columns += [(a + 1) * n + owner] * 2
        values += [np.einsum("kc,kc->k", axes[:, a], apart), np.ones(parts)]
    place = np.concatenate(rows), np.concatenate(columns)
    return csr_array((np.concatenate(values), place), shape=(width * parts, width * n))


def _centroids(polygons):
    """Return (k, 3) the centroids of planar polygons."""
    v = polygons
    one = 0.5 * np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1)[:, None]
    two = 0.5 * np.linalg.norm(np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 0]), axis=1)[:, None]
    first, second = v[:, :3].mean(axis=1), v[:, [0, 2, 3]].mean(axis=1)
    return (one * first + two * second) / np.maximum(one + two, 1e-300)
