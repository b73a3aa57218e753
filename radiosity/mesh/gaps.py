"""Gaps: open edges whose vertices nearly meet others, or lie within other open edges."""

from itertools import chain

import numpy as np
from scipy.spatial import cKDTree

from radiosity.mesh.faces import Faces
from radiosity.mesh.seams import OPEN, Seams

NEAR = 1e-5  # share of the mesh's size below which what does not meet was meant to


def reach_of(faces: Faces) -> float:
    """Return the distance, in scene units, below which vertices of a mesh were meant to meet."""
    return NEAR * float(np.linalg.norm(np.ptp(faces.vertices, axis=(0, 1))))


def open_vertices(faces: Faces, seams: Seams) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the numbers (n,) of corners on open edges, their places (n, 3), and a face each."""
    side = np.flatnonzero(seams.kinds()[seams.edge] == OPEN)
    number = np.concatenate([seams.start[side], seams.end[side]])
    number, first = np.unique(number, return_index=True)
    face = np.tile(seams.face[side], 2)[first]
    corner = np.argmax(seams.corner[face] == number[:, None], axis=1)
    return number, faces.vertices[face, corner], face


def near_vertices(faces: Faces, seams: Seams) -> tuple[np.ndarray, np.ndarray]:
    """Return a face (p,) and the place (p, 3) of each pair of open vertices that nearly meet.

    Ends of one edge do not count, however short it is.
    """
    number, points, face = open_vertices(faces, seams)
    if not len(points):
        return np.empty(0, int), np.empty((0, 3))
    pairs = cKDTree(points).query_pairs(reach_of(faces), output_type="ndarray")
    size = seams.corner.max(initial=0) + 1
    ends = np.minimum(seams.start, seams.end) * size + np.maximum(seams.start, seams.end)
    one, two = np.sort(number[pairs], axis=1).T
    pairs = pairs[~np.isin(one * size + two, ends)]
    pairs = pairs[np.lexsort(np.sort(face[pairs], axis=1).T[::-1])]
    return face[pairs].min(axis=1), points[pairs[:, 0]]


def t_junctions(faces: Faces, seams: Seams) -> tuple[np.ndarray, np.ndarray]:
    """Return the face (p,) and the place (p, 3) of each open vertex within another open edge.

    Long edges are looked at in pieces, so that the balls about those hold little else.
    """
    number, points, face = open_vertices(faces, seams)
    side = np.flatnonzero(seams.kinds()[seams.edge] == OPEN)
    if not len(side):
        return np.empty(0, int), np.empty((0, 3))
    place = np.searchsorted(number, np.stack([seams.start[side], seams.end[side]]))
    start, along = points[place[0]], points[place[1]] - points[place[0]]
    length = np.linalg.norm(along, axis=1)
    pieces = np.ceil(length / length.mean()).astype(int)  # at most twice as many as edges
    edge = np.repeat(np.arange(len(side)), pieces)
    k = np.arange(len(edge)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    middle = start[edge] + ((k + 0.5) / pieces[edge])[:, None] * along[edge]
    reach, tree = reach_of(faces), cKDTree(points)
    near = tree.query_ball_point(middle, length[edge] / pieces[edge] / 2.0 + reach)
    edge = np.repeat(edge, [len(n) for n in near])
    vertex = np.fromiter(chain.from_iterable(near), int, len(edge))
    way = points[vertex] - start[edge]
    up_to = np.einsum("pc,pc->p", way, along[edge]) / length[edge]
    off = np.linalg.norm(way - (up_to / length[edge])[:, None] * along[edge], axis=1)
    within = (up_to > reach) & (up_to < length[edge] - reach) & (off <= reach)
    found = np.unique(vertex[within])
    found = found[np.argsort(face[found], kind="stable")]
    return face[found], points[found]
