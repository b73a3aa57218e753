"""Closed-form cases of form factors between polygons, free and obstructed, and what a check is."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from radiosity.analytic import box_form_factors, load_cases
from radiosity.mesh.faces import Faces
from radiosity.mesh.triangulate import triangulate
from radiosity.solve.matrix import form_factors
from radiosity.transport.exchange import exchange_area, make_geometry, make_room
from radiosity.transport.polygon import point_factor

# Bounds, relative unless a suite says otherwise: point to polygon is exact to rounding; polygon to
# polygon is computed to FINE; 1 - F cannot be better than the rounding of F.
EXACT, PAIR, COMPLEMENT, CLOSED = 1e-12, 1e-9, 1e-12, 1e-12
FINE = 1e-12
ASKED = 1e-5  # accuracy of the obstructed cases and, absolute, their bound
COARSE = 1e-3
BOX = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
                [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]],
                [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]],
                [[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]],
                [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]],
                [[0, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]]], float)  # fmt: skip


@dataclass(frozen=True)
class Check:
    """One case: what was expected and found, their error, its bound, and the time.

    ``relative`` tells whether error and bound are shares of what was expected.
    """

    suite: str
    case: str
    expected: float
    found: float
    error: float
    bound: float
    seconds: float
    relative: bool = True

    @property
    def passed(self) -> bool:
        """Whether the error is within its bound; an error that is no number is not."""
        return self.error <= self.bound


def timed(suite, case, expected, bound, compute: Callable[[], np.ndarray], relative=True) -> Check:
    """Return the check of the worst of the values that ``compute`` returns."""
    begun = time.perf_counter()
    found = np.atleast_1d(compute())
    seconds = time.perf_counter() - begun
    wanted = np.broadcast_to(np.asarray(expected, float), found.shape)
    error = np.abs(found - wanted) / (np.abs(wanted) if relative else 1.0)
    k = np.unravel_index(np.argmax(error), error.shape)
    values = float(wanted[k]), float(found[k]), float(error[k])
    return Check(suite, case, *values, bound, seconds, relative)


def elements() -> Iterator[Check]:
    """Point to polygon: Lambert's sum is exact to rounding."""
    for case in load_cases("vf_element_polygon"):
        g = case["geometry"]
        yield timed(
            "elements", case["id"], case["value"], EXACT,
            lambda p=g["point"], n=g["normal"], q=g["A2"]: element_factor(p, n, _convex(p, q)),
        )  # fmt: skip


def polygons() -> Iterator[Check]:
    """Polygon to polygon, unoccluded."""
    for case in load_cases("vf_polygon_pairs"):
        g = case["geometry"]
        yield timed(
            "polygons", case["id"], case["value"], PAIR,
            lambda a=g["A1"], b=g["A2"]: pair_factors(a, b)[0],
        )  # fmt: skip


def extremes() -> Iterator[Check]:
    """Slivers, gaps, scales, shared edges and corners, contact: what breaks float arithmetic."""
    checks = {
        "polygon_pair": _extreme_pair, "polygon_pair_zero": _unseen, "scale": _scaled,
        "translate": _moved, "cube_rowsum": _closed_cubes, "touch": _touching,
        "two_rooms": _two_rooms,
    }  # fmt: skip
    for case in load_cases("extremes"):
        kind = case["geometry"]["type"]
        if kind in checks:  # the furnace is a whole solution, see `rooms`
            yield from checks[kind](case)


def obstructed() -> Iterator[Check]:
    """Polygons with others in between, at accuracy 1e-5; errors are absolute."""
    special = {"cube_in_cube": _cube_in_cube, "L_room": _l_room}
    for case in load_cases("vf_obstructed"):
        g, expected = case["geometry"], case["value"]
        compute = special.get(g["type"], _behind_blockers)
        if isinstance(expected, dict):
            expected = list(expected.values())
        yield timed("obstructed", case["id"], expected, ASKED, lambda c=compute, g=g: c(g), False)


def element_factor(point, normal, polygons) -> float:
    """Return F from a surface element to polygons (k, 4, 3) that face it."""
    point, normal = np.array(point, float), np.array(normal, float)
    normal /= np.linalg.norm(normal)
    return sum(point_factor(*point, *normal, np.ascontiguousarray(q)) for q in polygons)


def _convex(point, polygon):
    """Return the pieces of a polygon, wound so that they face the point."""
    pieces = triangulate(polygon)
    facing = np.cross(pieces[0, 1] - pieces[0, 0], pieces[0, 2] - pieces[0, 0])
    if facing @ (pieces[0, 0] - np.array(point, float)) > 0:  # two cases wind the other way
        pieces = triangulate(polygon[::-1])
    return pieces


def pair_factors(one, two) -> np.ndarray:
    """Return F from one planar polygon to another and back, both of any shape."""
    pieces = [triangulate(one), triangulate(two)]
    vertices = np.concatenate(pieces)
    centre = vertices.mean(axis=(0, 1))
    vertices = (vertices - centre) / np.abs(vertices - centre).max()
    index = np.zeros(len(vertices), int)
    faces = Faces(vertices, index, index)
    area = faces.areas()
    geometry = make_geometry(vertices, faces.normals(), vertices.mean(axis=1), area)
    room, first = make_room(), len(pieces[0])
    total = sum(
        exchange_area(geometry, i, j, FINE, room)[0]
        for i in range(first) for j in range(first, len(area))
    )  # fmt: skip
    return total / np.array([area[:first].sum(), area[first:].sum()])


def _extreme_pair(case):
    g, expected = case["geometry"], np.atleast_1d(case["value"])
    if case["id"].startswith("gap"):
        yield from _gap(case["id"], g, *expected)
        return
    yield timed(
        "extremes", case["id"], expected, PAIR,
        lambda: pair_factors(g["A1"], g["A2"])[: len(expected)],
    )  # fmt: skip


def _gap(name, g, factor, complement):
    """Check F near 1, and what is left to 1."""

    def found():
        return pair_factors(g["A1"], g["A2"])[0]

    yield timed("extremes", name, factor, PAIR, found)
    yield timed("extremes", f"{name} 1 - F", complement, COMPLEMENT, lambda: 1.0 - found(), False)


def _unseen(case):
    g = case["geometry"]
    yield timed("extremes", case["id"], 0.0, 0.0, lambda: pair_factors(g["A1"], g["A2"]), False)


def _cube_pairs(vertices):
    """Return F from the floor of a cube to the wall x0 and to the ceiling, by the whole program."""
    factors = form_factors(faces_of(vertices), COARSE, repair=False).toarray()
    return factors[0, [2, 1]]


def _scaled(case):
    vertices = BOX * case["geometry"]["k"]
    yield timed("extremes", case["id"], case["value"], PAIR, lambda: _cube_pairs(vertices))


def _moved(case):
    vertices = BOX + np.array(case["geometry"]["offset"])
    yield timed("extremes", case["id"], case["value"], PAIR, lambda: _cube_pairs(vertices)[1])


def _closed_cubes(case):
    for n in case["geometry"]["n"]:
        yield timed(
            "extremes", f"{case['id']} n = {n}", 1.0, CLOSED,
            lambda n=n: form_factors(faces_of(divided(BOX, n)), COARSE).row_sums(), False,
        )  # fmt: skip


def _touching(case):
    """Check that the bottom of a box that stands on the floor and the floor below see nothing."""
    box = 0.25 + 0.5 * BOX - [0, 0, 0.25]
    box = box[:, ::-1]

    def bottom():
        return form_factors(faces_of(BOX, box), COARSE).toarray()[:, 6]

    yield timed("extremes", case["id"], 0.0, 0.0, bottom, False)
    below = form_factors(faces_of(BOX, box), COARSE).area[:1]
    yield timed("extremes", f"{case['id']} floor", 0.75, PAIR, lambda: below)


def _two_rooms(case):
    """Check a wall without thickness: nothing passes, and each room is the closed cube."""
    walls = faces_of(BOX, (BOX + [1, 0, 0])[[0, 1, 3, 4, 5]])
    fronts, backs = np.arange(11), 11 + np.arange(11)
    left, right = fronts[:6], np.append(fronts[6:], backs[3])

    def matrix():
        return form_factors(walls, COARSE, two_sided=True).toarray()

    yield timed("extremes", case["id"], 0.0, 0.0, lambda: matrix()[np.ix_(left, right)], False)
    yield timed(
        "extremes", f"{case['id']} cube", box_form_factors((1, 1, 1)), PAIR,
        lambda: matrix()[np.ix_(left, left)], False,
    )  # fmt: skip


def _behind_blockers(g):
    """Return F from one polygon to another past others that are no rows."""
    rows, blockers = polygon_mesh([g["A1"], g["A2"]]), polygon_mesh(g["blockers"])
    return form_factors(rows, ASKED, obstructions=blockers, repair=False).toarray()[0, 1]


def _cube_in_cube(g):
    """Return the distinct factors in the order of the case's value."""
    inner = 0.5 + g["a"] * (BOX[:, ::-1] - 0.5)
    f = form_factors(faces_of(BOX, inner), ASKED).toarray()
    outer_sides, inner_sides = [2, 3, 4, 5], [8, 9, 10, 11]
    return np.array([
        f[0, 6:].sum(), f[0, 1], f[0, outer_sides].mean(), f[6, 0], f[6, outer_sides].mean(),
        f[0, 6], f[0, inner_sides].mean(), f[0, 7],
    ])  # fmt: skip


def _l_room(g):
    return form_factors(polygon_mesh(list(g["faces"].values())), ASKED).toarray()


def polygon_mesh(polygons):
    """Return (vertices, faces) of polygons that share no vertices."""
    ends = np.cumsum([len(p) for p in polygons])
    faces = [np.arange(end - len(p), end) for p, end in zip(polygons, ends, strict=True)]
    return np.concatenate([np.array(p, float) for p in polygons]), faces


def divided(quads, n):
    """Return each parallelogram (k, 4, 3) as n x n of them."""
    t = np.arange(n) / n
    s, t = (x.ravel()[None, :, None] for x in np.meshgrid(t, t))
    along, across = ((quads[:, k] - quads[:, 0])[:, None] / n for k in (1, 3))
    corner = quads[:, None, 0] + n * (s * along + t * across)
    cells = np.stack([corner, corner + along, corner + along + across, corner + across], axis=2)
    return cells.reshape(-1, 4, 3)


def faces_of(*parts):
    """Return faces of quadrilaterals (k, 4, 3), each part a group."""
    group = np.repeat(np.arange(len(parts)), [len(p) for p in parts])
    return Faces(np.concatenate(parts), np.zeros(len(group), int), group)
