"""Triangles without cracks: each cell is a fan about its centre through all points on its edges."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.faces import WELD, welded
from radiosity.mesh.patches import Patches
from radiosity.view.fine.cells import Cells, moved_in, patch_of, points_of
from radiosity.view.fine.refine import Light, Look, Seen

ON_EDGE = 2.0 * WELD  # of the scene's size, the distance within which a point lies on an edge


@dataclass(frozen=True)
class Fans:
    """Triangles of cells.

    Attributes
    ----------
    points : (k, 3) float64
        Vertices in scene units; those in one place have the same coordinates.
    patch : (k,) int
        Of each vertex: no two patches share one.
    light : Light
        At the vertices.
    triangles : (t, 3) int
        Into the vertices, counter-clockwise.
    """

    points: np.ndarray
    patch: np.ndarray
    light: Light
    triangles: np.ndarray


def fans_of(patches: Patches, cells: Cells, seen: Seen, look: Look, progress) -> Fans:
    """Return cells as triangles that leave no gap between them, nor to those of other faces.

    A point of one cell on the edge of another becomes a vertex of that one too, where its own side
    sees light by itself.
    """
    at = seen.at(cells)
    used, at = np.unique(at, return_inverse=True)
    at, numbers = at.reshape(len(cells), -1), seen.numbers[used]
    points = points_of(patches, numbers)[0]
    patch, place = patch_of(numbers), welded(points)
    first = np.unique(place, return_index=True)[1]
    rim = at[:, :-1]
    start, stop = rim.ravel(), np.roll(rim, -1, axis=1).ravel()
    edge, between = _on_edges(points[first], place[start], place[stop])
    owner = patch[start[edge]]
    between, more = _own(between, owner, place, patch, len(points))
    light = seen.light.some(used)
    if len(more[0]):
        light = light.joined(look(more[1], moved_in(patches, more[1], points[first][more[0]]),
                                  progress))  # fmt: skip
    points = points[first][np.concatenate([place, more[0]])]
    triangles = _fanned(points, start, stop, np.repeat(at[:, -1], rim.shape[1]), edge, between)
    return Fans(points, np.concatenate([patch, more[1]]), light, triangles)


def _on_edges(points, start, stop):
    """Return the edges (m,) of those from ``start`` to ``stop`` (e,) inside which points lie."""
    from scipy.spatial import cKDTree

    a, span = points[start], points[stop] - points[start]
    length = np.linalg.norm(span, axis=1)
    slack = ON_EDGE * float(np.ptp(points, axis=0).max(initial=0.0))
    near = cKDTree(points).query_ball_point(a + 0.5 * span, 0.5 * length + slack)
    count = np.fromiter(map(len, near), int, len(near))
    edge = np.repeat(np.arange(len(start)), count)
    point = np.fromiter((p for some in near for p in some), int, count.sum())
    inner = (point != start[edge]) & (point != stop[edge]) & (length[edge] > 0.0)
    edge, point = edge[inner], point[inner]
    off = np.cross(points[point] - a[edge], span[edge]) / length[edge, None]
    on = np.linalg.norm(off, axis=1) <= slack
    return edge[on], point[on]


def _own(point, owner, place, patch, count):
    """Return the vertices (m,) of patches ``owner`` in places ``point``, and where new ones are.

    The latter as places and patches (l,); they are numbered from ``count`` on.
    """
    many = place.max(initial=0) + 1
    known, wanted = patch * many + place, owner * many + point
    order = np.argsort(known)
    found = order[np.minimum(np.searchsorted(known[order], wanted), count - 1)]
    new = known[found] != wanted
    lacking, which = np.unique(wanted[new], return_inverse=True)
    found[new] = count + which
    return found, (lacking % many, lacking // many)


def _fanned(points, start, stop, centre, edge, between):
    """Return the triangles (t, 3) of edges with vertices ``between`` on some of them."""
    all_edges = np.concatenate([np.arange(len(start)), edge])
    vertex = np.concatenate([start, between])
    along = np.linalg.norm(points[vertex] - points[start[all_edges]], axis=1)
    order = np.lexsort((along, all_edges))
    all_edges, vertex = all_edges[order], vertex[order]
    last = np.append(all_edges[1:] != all_edges[:-1], True)
    after = np.where(last, stop[all_edges], np.roll(vertex, -1))
    made = np.stack([centre[all_edges], vertex, after], axis=1)
    return made[vertex != after]
