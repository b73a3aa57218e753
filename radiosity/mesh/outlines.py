"""Outlines: polygons of any number of corners, as files list them, to convex faces."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.triangulate import NoArea, convex_parts, convex_quads


@dataclass(frozen=True)
class Outlines:
    """The convex parts of polygons, in the polygons' order.

    Attributes
    ----------
    place : (k, 4) int
        Which of the listed corners each part has; a triangle repeats its last one.
    origin : (k,) int
        The polygon each part comes from.
    flat : int
        How many polygons have all corners on one line, and no part.
    problems : list of (int, str)
        Polygons that cannot be split, and why: a sentence without a subject.
    """

    place: np.ndarray
    origin: np.ndarray
    flat: int
    problems: list


def split_outlines(points: np.ndarray, corners: np.ndarray, size: np.ndarray) -> Outlines:
    """Return convex parts of polygons; quadrilaterals that are convex and planar stay whole.

    Corners in files are rounded: a polygon that is not flat is split as it is drawn.

    Parameters
    ----------
    points : (n, 3) float
    corners : (c,) int
        Indices into the points, of one polygon after the other.
    size : (p,) int
        How many corners each polygon has, at least 3.
    """
    first = np.cumsum(size) - size
    three, four = np.flatnonzero(size == 3), np.flatnonzero(size == 4)
    triangles = first[three, None] + [0, 1, 2, 2]
    quads = first[four, None] + np.arange(4)
    whole = convex_quads(points[corners[quads]])
    hard = np.sort(np.concatenate([four[~whole], np.flatnonzero(size > 4)]))
    parts, origin, problems = [triangles, quads[whole]], [three, four[whole]], []
    flat = 0
    for f in hard.tolist():
        try:
            split = convex_parts(points[corners[first[f] : first[f] + size[f]]], flatness=np.inf)
        except NoArea:
            flat += 1
            continue
        except ValueError as error:
            problems.append((f, str(error)))
            continue
        parts.append(first[f] + split)
        origin.append(np.full(len(split), f))
    origin = np.concatenate(origin)
    order = np.argsort(origin, kind="stable")
    return Outlines(np.concatenate(parts)[order], origin[order], flat, problems)
