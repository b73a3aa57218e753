"""Facets: the few large convex polygons that the coplanar faces of a fine mesh add up to."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from radiosity.mesh.faces import PLANAR, WELD, Faces, meeting_edges, ranges, welded

MOST_CORNERS = 8
ROUGHEST = 1e-3  # rounding of a normal above which a sliver could be in any plane


@dataclass(frozen=True)
class Facets:
    """Convex planar polygons that faces of one plane and orientation add up to.

    Attributes
    ----------
    vertices : (m, 8, 3) float64
        Vertices of the faces, counter-clockwise seen from the front, the last one repeated. Of
        vertices that coincide within the weld distance all facets have the same one.
    count : (m,) int
        Distinct corners, 3 to 8.
    normal : (m, 3) float64
        Unit normals on the front side.
    facet : (f,) int
        The facet that each face is a part of; facets are in the order of their first faces.
    """

    vertices: np.ndarray
    count: np.ndarray
    normal: np.ndarray
    facet: np.ndarray

    def unevenness(self, faces: Faces) -> np.ndarray:
        """Return (m,) how far, at most, a vertex of its faces lies off the plane of each facet."""
        plane, normal = self.vertices[self.facet, 0], self.normal[self.facet]
        height = np.einsum("fvc,fc->fv", faces.vertices - plane[:, None], normal)
        found = np.zeros(len(self.count))
        np.maximum.at(found, self.facet, np.abs(height).max(axis=1, initial=0.0))
        return found


@dataclass(frozen=True)
class _Mesh:
    """Faces with welded corners; half-edge 4 f + k runs from corner k of face f to the next.

    ``points`` (p, 3) holds an input vertex for each weld number, ``start`` and ``end`` (4 f,)
    weld numbers, ``real`` (4 f,) what is no repeated vertex, ``twins`` (t, 2) half-edges of
    coplanar faces that meet head to tail, ``normal`` (f, 3), ``gap`` the weld distance.
    """

    vertices: np.ndarray
    points: np.ndarray
    start: np.ndarray
    end: np.ndarray
    real: np.ndarray
    twins: np.ndarray
    normal: np.ndarray
    gap: float


def merge_facets(faces: Faces) -> Facets:
    """Return the convex polygons of at most 8 corners that the faces add up to.

    Faces of one plane that hang together by edges are one facet where their union is convex. A
    union that is not is cut along straight mesh lines that go on from its reflex corners. Faces
    whose union stays something else (holes between them, overlaps, more corners) stay alone.

    Parameters
    ----------
    faces : Faces
        (f, 4, 3) planar faces; material and group do not matter.

    Returns
    -------
    Facets
        (m,) polygons, m <= f. Faces lie within the weld distance (1e-7 of the mesh's size, or
        the rounding of its coordinates where that is larger) of their facet.
    """
    mesh = _mesh(faces)
    area = faces.areas()
    label = _sound(mesh, area, _components(mesh, np.ones(len(mesh.twins), bool)))
    normal = _normals(mesh, area, label)
    whole, corners, count = _convex(mesh, label, normal)
    rest = np.where(np.isin(label, whole), -1, label)
    if np.any(rest >= 0):
        parts = _components(mesh, ~_cut(mesh, rest, normal) & (rest[mesh.twins[:, 0] // 4] >= 0))
        more, more_corners, more_count = _convex(mesh, parts, _normals(mesh, area, parts))
        taken = np.isin(parts, more)
        label = np.where(taken, len(faces) + parts, np.where(rest >= 0, -1, label))
        whole = np.concatenate([whole, len(faces) + more])
        corners = np.concatenate([corners, more_corners])
        count = np.concatenate([count, more_count])
    return _assembled(mesh, area, np.where(np.isin(label, whole), label, -1), corners, count)


def _mesh(faces):
    v = faces.vertices
    flat = v.reshape(-1, 3)
    start = welded(flat)
    corner = start.reshape(-1, 4)
    end = np.roll(corner, -1, axis=1).ravel()
    size = np.linalg.norm(np.ptp(flat, axis=0)) if len(flat) else 0.0
    rounding = np.finfo(float).eps * np.abs(flat).max(initial=0)
    gap = max(WELD * size, 8 * rounding)
    real = start != end
    sides = real.reshape(-1, 4).sum(axis=1)
    distinct = 1 + np.count_nonzero(np.diff(np.sort(corner, axis=1), axis=1), axis=1)
    usable = (sides == distinct) & (sides == np.where(faces.is_triangle, 3, 4))
    real &= np.repeat(usable, 4)
    points = _one_of_each(flat, start)
    snapped = np.where(usable[:, None, None], points[corner], v)
    normal = faces.normals()
    longest = np.linalg.norm(np.roll(v, -1, axis=1) - v, axis=2).max(axis=1, initial=0)
    blur = 4 * rounding * longest / np.maximum(faces.areas(), 1e-300)
    pairs = meeting_edges(start, end, real & np.repeat(blur < ROUGHEST, 4))
    f, g = pairs.T // 4
    bend = np.linalg.norm(normal[f] - normal[g], axis=1)
    twins = pairs[bend <= 2 * WELD + blur[f] + blur[g]]
    return _Mesh(snapped, points, start, end, real, twins, normal, gap)


def _one_of_each(flat, number):
    """Return (p, 3): of the points with one weld number the smallest by x, then y, then z."""
    points = np.empty((number.max(initial=-1) + 1, 3))
    points[number] = flat
    odd = np.unique(number[np.any(points[number] != flat, axis=1)])
    several = np.flatnonzero(np.isin(number, odd))
    order = several[np.lexsort((*flat[several].T[::-1], number[several]))]
    first = np.unique(number[order], return_index=True)[1]
    points[odd] = flat[order[first]]
    return points


def _components(mesh, linked):
    """Return (f,) numbers of the faces that hang together by the linked twins, -1 if alone."""
    n = len(mesh.normal)
    one, two = mesh.twins[linked].T // 4
    graph = coo_array((np.ones(len(one), bool), (one, two)), shape=(n, n))
    label = connected_components(graph, directed=False)[1]
    return np.where(np.bincount(label, minlength=n)[label] > 1, label, -1)


def _sound(mesh, area, label):
    """Return the labels without components that bend or whose faces share an edge twice."""
    shared = np.bincount(mesh.twins.ravel(), minlength=4 * len(label)).reshape(-1, 4)
    wrong = label[(label >= 0) & np.any(shared > 1, axis=1)]
    face = np.flatnonzero(label >= 0)
    owner = label[face]
    origin = np.zeros((len(label), 3))
    origin[owner] = mesh.vertices[face, 0]
    normal = _normals(mesh, area, label)[owner]
    height = np.einsum("fkx,fx->fk", mesh.vertices[face] - origin[owner][:, None], normal)
    bent = owner[np.abs(height).max(axis=1, initial=0) > 2 * mesh.gap]
    return np.where(np.isin(label, np.concatenate([wrong, bent])), -1, label)


def _normals(mesh, area, label):
    """Return (n, 3) unit normals of the components by their number, 0 where there is none."""
    inside = label >= 0
    total = np.zeros((len(label), 3))
    weight = area[inside] / area.max(initial=1e-300)
    np.add.at(total, label[inside], weight[:, None] * mesh.normal[inside])
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)


def _boundary(mesh, label):
    """Return (4 f,) bool: half-edges of labelled faces without a twin of the same label."""
    owner = np.repeat(label, 4)
    one, two = mesh.twins[owner[mesh.twins[:, 0]] == owner[mesh.twins[:, 1]]].T
    edge = mesh.real & (owner >= 0)
    edge[one] = edge[two] = False
    return edge


def _convex(mesh, label, normal):
    """Return the labels (w,) whose faces form a facet, the corners (w, 8, 3) and their count."""
    n = len(label)
    owner, point, closed = _rings(mesh, label, normal)
    keep = closed[owner]
    owner, p = owner[keep], mesh.points[point[keep]]
    before, after = _cyclic(owner)
    straight = _straight(p - p[before], p[after] - p, normal[owner], mesh.gap)
    count = np.bincount(owner[~straight], minlength=n)
    fit = (count >= 3) & (count <= MOST_CORNERS)
    keep = fit[owner]
    owner, p, straight = owner[keep], p[keep], straight[keep]
    c = np.flatnonzero(~straight)
    before, after = _cyclic(owner[c])
    a, b = p[c] - p[c[before]], p[c[after]] - p[c]
    fit[owner[c][_turn(a, b, normal[owner[c]]) <= 0]] = False
    side = np.cumsum(~straight) - 1  # of the corners, the one that begins this point's side
    first, last = np.searchsorted(owner[c], owner), np.searchsorted(owner[c], owner, "right") - 1
    side = np.where(side < first, last, side)
    along = b[side] / np.linalg.norm(b[side], axis=1, keepdims=True)
    off = np.linalg.norm(np.cross(p - p[c[side]], along), axis=1)
    fit[owner[off > 2 * mesh.gap]] = False
    whole = np.flatnonzero(fit)
    at = np.searchsorted(owner[c], whole)[:, None]
    at = at + np.minimum(np.arange(MOST_CORNERS), count[whole][:, None] - 1)
    return whole, p[c[at]], count[whole]


def _rings(mesh, label, normal):
    """Return labels and points of all outlines, by angle about their middles.

    ``closed`` (n,) bool says for each label whether the outline is one ring that runs once round
    the middle: neighbours by angle are the ends of one edge.
    """
    edge = np.flatnonzero(_boundary(mesh, label))
    owner, n = label[edge // 4], len(label)
    p = mesh.points[mesh.start[edge]]
    origin = np.zeros((n, 3))
    origin[owner] = p
    r = p - origin[owner]  # large coordinates are not summed
    middle = np.stack([np.bincount(owner, x, n) for x in r.T], axis=1)
    r -= (middle / np.maximum(np.bincount(owner, minlength=n), 1)[:, None])[owner]
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin(axis=1)])
    up = np.cross(normal, across)
    angle = np.arctan2(*(np.einsum("ex,ex->e", r, x[owner]) for x in (up, across)))
    order = np.lexsort((angle, owner))
    edge, owner = edge[order], owner[order]
    closed = np.ones(n, bool)
    after = _cyclic(owner)[1]
    closed[owner[mesh.end[edge] != mesh.start[edge[after]]]] = False
    return owner, mesh.start[edge], closed


def _cyclic(owner):
    """Return the places before and after each one in the ring of its (sorted) owner."""
    place = np.arange(len(owner))
    first = np.searchsorted(owner, owner)
    last = np.searchsorted(owner, owner, "right") - 1
    return np.where(place == first, last, place - 1), np.where(place == last, first, place + 1)


def _turn(a, b, normal):
    return np.einsum("ex,ex->e", np.cross(a, b), normal)


def _straight(a, b, normal, gap):
    """Whether paths a, then b (e, 3) pass within the gap of the line between their ends."""
    chord = np.linalg.norm(a + b, axis=1)
    forward = np.einsum("ex,ex->e", a, b) > 0
    return forward & (np.abs(_turn(a, b, normal)) <= gap * chord)


@dataclass(frozen=True)
class _Lines:
    """Edges of labelled faces, ``half`` (h,), then those of the outline backwards (e - h in all).

    ``start``, ``end`` (e,) number a label's points, ``along`` (e, 3) runs from one to the other;
    ``ahead`` (e,) is the inner edge that goes straight on, -1 where none does; ``back`` (h,) is
    the twin of an inner edge, -1 on the outline.
    """

    half: np.ndarray
    start: np.ndarray
    end: np.ndarray
    along: np.ndarray
    ahead: np.ndarray
    back: np.ndarray


def _cut(mesh, label, normal):
    """Return (t,) bool: twins to part, along straight lines from reflex corners to outlines.

    Each reflex corner is cut once, by the shortest line, first where that settles two of them.
    """
    lines = _lines(mesh, label)
    begin = _reflex(mesh, lines, label, normal)
    ahead, end, back = lines.ahead.tolist(), lines.end.tolist(), lines.back.tolist()
    stop = np.zeros(lines.end.max(initial=-1) + 1, bool)
    stop[lines.start[: len(back)][lines.back < 0]] = True
    stop, opening = stop.tolist(), {ahead[e]: end[e] for e in begin}

    def both(path):
        return opening.get(back[path[-1]]) == end[path[-1]]

    def rank(way):
        length = np.linalg.norm(lines.along[way[1]], axis=1).sum()
        return round(length / mesh.gap), *mesh.points[mesh.start[lines.half[way[1][0]]]]

    ways = [(e, _walk(ahead, end, stop, e)) for e in begin]
    ways = [e for e, _ in sorted((way for way in ways if way[1]), key=rank)]
    parted, settled = np.zeros(len(mesh.start), bool), set()
    for e, two in [(e, True) for e in ways] + [(e, False) for e in ways]:
        path = _walk(ahead, end, stop, e)
        if end[e] in settled or two and (not both(path) or end[path[-1]] in settled):
            continue
        parted[lines.half[path]] = True
        settled |= {end[e], end[path[-1]]} if two else {end[e]}
        for x in path:
            stop[end[x]] = True
    return parted[mesh.twins].any(axis=1)


def _walk(ahead, end, stop, e):
    """Return the inner edges straight ahead of e up to a stop, none if the line ends before."""
    path = []
    for _ in range(len(ahead)):
        e = ahead[e]
        if e < 0:
            break
        path.append(e)
        if stop[end[e]]:
            return path
    return []


def _lines(mesh, label):
    owner = np.repeat(label, 4)
    half = np.flatnonzero(mesh.real & (owner >= 0))
    outer = np.flatnonzero(_boundary(mesh, label)[half])
    key = owner[half] * len(mesh.points) + mesh.start[half]
    nodes, start = np.unique(key, return_inverse=True)
    end = np.searchsorted(nodes, owner[half] * len(mesh.points) + mesh.end[half])
    along = mesh.points[mesh.end[half]] - mesh.points[mesh.start[half]]
    twins = np.searchsorted(half, mesh.twins[np.all(owner[mesh.twins] >= 0, axis=1)])
    back = np.full(len(half), -1)
    back[twins], back[twins[:, ::-1]] = twins[:, ::-1], twins
    back[outer] = -1
    start, end = np.concatenate([start, end[outer]]), np.concatenate([end, start[outer]])
    along = np.concatenate([along, -along[outer]])
    return _Lines(half, start, end, along, _ahead(start, end, along, back, mesh.gap), back)


def _ahead(start, end, along, back, gap):
    """Return the inner edge that goes on most nearly straight from each edge, -1 if none does."""
    inner = np.flatnonzero(back >= 0)
    inner = inner[np.argsort(start[inner], kind="stable")]
    low = np.searchsorted(start[inner], end, "left")
    at, e = ranges(low, np.searchsorted(start[inner], end, "right") - low)
    at = inner[at]
    length = np.linalg.norm(along, axis=1)
    a, b = along[e] / length[e, None], along[at] / length[at, None]
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    blur = PLANAR + 2 * gap / np.minimum(length[e], length[at])
    straight = np.flatnonzero((sine <= blur) & (np.einsum("ex,ex->e", a, b) > 0))
    straight = straight[np.lexsort((-sine[straight], e[straight]))]  # the last one stays
    ahead = np.full(len(end), -1)
    ahead[e[straight]] = at[straight]
    return ahead


def _reflex(mesh, lines, label, normal):
    """Return the edges that lead to reflex corners along the outline, of either side."""
    back, h = lines.back, len(lines.back)
    out = np.flatnonzero(back < 0)
    n = lines.end.max(initial=-1) + 1
    once = np.bincount(lines.start[out], minlength=n) == 1
    arrive, leave = np.zeros(n, int), np.zeros(n, int)
    arrive[lines.end[out]], leave[lines.start[out]] = out, np.arange(len(out))
    node = np.flatnonzero(once)
    a, b = lines.along[arrive[node]], lines.along[out[leave[node]]]
    front = normal[label[lines.half[arrive[node]] // 4]]
    turn, bound = _turn(a, b, front), mesh.gap * np.linalg.norm(b, axis=1)
    folded = (np.einsum("ex,ex->e", a, b) < 0) & (turn <= bound)
    node = node[~_straight(a, b, front, mesh.gap) & ((turn < 0) | folded)]
    return np.concatenate([arrive[node], h + leave[node]]).tolist()


def _assembled(mesh, area, label, corners, count):
    """Return the facets: labelled ones in the order of corners (w, 8, 3), all others alone."""
    n = len(label)
    group = np.where(label >= 0, n + label, np.arange(n))
    _, first, facet = np.unique(group, return_index=True, return_inverse=True)
    place = np.empty(len(first), int)
    place[np.argsort(first)] = np.arange(len(first))
    facet, first = place[facet], np.sort(first)
    vertices = mesh.vertices[first][:, np.minimum(np.arange(MOST_CORNERS), 3)]
    triangle = np.all(vertices[:, 3] == vertices[:, 2], axis=1)
    number = np.where(triangle, 3, 4)
    merged = np.flatnonzero(label[first] >= 0)
    rank = np.unique(label[first[merged]], return_inverse=True)[1]
    vertices[merged], number[merged] = corners[rank], count[rank]
    return Facets(vertices, number, _normals(mesh, area, facet)[: len(first)], facet)
