"""Gaps: open edges whose vertices nearly meet others, or lie within other open edges."""

import numpy as np
from scipy.spatial import cKDTree

from radiosity.mesh.boxes import near_boxes
from radiosity.mesh.faces import Faces
from radiosity.mesh.seams import OPEN, Seams

NEAR = 1e-5  # share of the mesh's size below which what does not meet was meant to


def reach_of(faces: Faces) -> float:
    """Return the distance, in scene units, below which vertices of a mesh were meant to meet."""
    return NEAR * float(np.linalg.norm(np.ptp(faces.vertices, axis=(0, 1))))


def open_vertices(faces: Faces, seams: Seams) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the numbers (n,) of the corners on open edges, their places (n, 3), and a face each."""
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

    Long edges are looked at in pieces, so that their boxes hold little else.
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
    ends = [
        start[edge] + ((k + j) / pieces[edge])[:, None] * along[edge] for j in (0, 1)
    ]  # fmt: skip
    low, high = np.minimum(*ends), np.maximum(*ends)
    reach, found = reach_of(faces), []
    for a, b in near_boxes(np.concatenate([low, points]), np.concatenate([high, points]), reach):
        keep = (a < len(edge)) & (b >= len(edge))
        a, b = edge[a[keep]], b[keep] - len(edge)
        way = points[b] - start[a]
        along_it = np.einsum("pc,pc->p", way, along[a]) / length[a]
        off = np.linalg.norm(way - (along_it / length[a])[:, None] * along[a], axis=1)
        inside = (along_it > reach) & (along_it < length[a] - reach)
        found.append(b[inside & (off <= reach)])
    found = np.unique(np.concatenate(found)) if found else np.empty(0, int)
    found = found[np.argsort(face[found], kind="stable")]
    return face[found], points[found]
