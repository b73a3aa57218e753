"""Whole solutions where float arithmetic and geometry are at their limits, with exact answers."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from radiosity.analytic import box_form_factors, box_radiosity, load_cases
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Material, Scene
from radiosity.solve.cases import BOX, Check, timed
from radiosity.solve.solve import solve

DIMS, RHO = (4.0, 3.0, 2.5), [0.2, 0.7, 0.5, 0.3, 0.6, 0.4]
SOLVER = 1e-6  # factors of six patches are exact, the solver goes to 1e-7
NEAR, NEARER = 1e-6, 1e-3  # bounds where 1 - rho is 1e-6 and 1e-9
COARSE = 0.1
ROOM = BOX * DIMS


def limits() -> Iterator[Check]:
    """Reflectances near 1, lights 1e12 apart, scales, slivers, gaps, edges and faulty meshes."""
    for make in (_near_one, _lights, _scales, _thin, _faults):
        yield from make()


def room_of(polygons, reflectance, exitance, absorptance=None) -> Scene:
    """Return a scene with one material a face; absorptances where 1 - rho loses digits."""
    quads = np.array([np.array(p, float)[[0, 1, 2, -1]] for p in polygons])
    n = len(quads)
    rho, emitted = (np.broadcast_to(np.asarray(x, float), n) for x in (reflectance, exitance))
    left = 1.0 - rho if absorptance is None else np.broadcast_to(absorptance, n)
    materials = tuple(
        Material(str(k), np.full(3, rho[k]), np.full(3, left[k]), np.full(3, emitted[k] / np.pi))
        for k in range(n)
    )
    index = np.arange(n)
    return Scene("room", Faces(quads, index, index), materials, tuple(str(k) for k in index))


def face_means(scene: Scene, accuracy: float = COARSE, **options) -> np.ndarray:
    """Return the mean radiosity of the front of each face."""
    solution = solve(scene, accuracy, **options)
    front = solution.patches.front
    face, area = solution.patches.face[front], solution.patches.area[front]
    total = np.bincount(face, area * solution.radiosity[front, 0], len(scene.faces))
    return total / np.bincount(face, area, len(scene.faces))


def box_of_one_lamp(absorptance: float) -> np.ndarray:
    """Return the exact B of a box whose six faces absorb alike and whose ceiling emits 1.

    In fractions, from the closed forms of F as rounded, the rows closed by their largest entry.
    """
    f = [[Fraction(x) for x in row] for row in box_form_factors(DIMS)]
    for row in f:
        row[row.index(max(row))] += 1 - sum(row)
    a = Fraction(absorptance)
    system = [[Fraction(i == j) - (1 - a) * f[i][j] for j in range(6)] for i in range(6)]
    return _solved(system, [Fraction(i == 1) for i in range(6)])


def _solved(a, b) -> list[Fraction]:
    """Return x with a x = b by elimination."""
    n = len(b)
    for k in range(n):
        for i in range(k + 1, n):
            share = a[i][k] / a[k][k]
            a[i] = [x - share * y for x, y in zip(a[i], a[k], strict=True)]
            b[i] -= share * b[k]
    for k in reversed(range(n)):
        b[k] = (b[k] - sum(a[k][j] * b[j] for j in range(k + 1, n))) / a[k][k]
    return b


def _near_one():
    """Furnaces and boxes of one lamp: means, and differences between faces."""
    for left, bound in ((1e-6, NEAR), (1e-9, NEARER)):
        furnace = room_of(ROOM, 1.0 - left, 1.0, left)
        for mesh in ("1", "3", "auto"):
            yield timed(
                "limits", f"furnace 1 - rho = {left:g}, mesh {mesh}", 1.0 / left, bound,
                lambda s=furnace, m=mesh: face_means(s, mesh=m),
            )  # fmt: skip
        lamp = room_of(ROOM, 1.0 - left, [0, 1, 0, 0, 0, 0], left)
        exact = box_of_one_lamp(left)
        apart = [float(x - exact[0]) for x in exact[1:]]
        means = [float(x) for x in exact]
        yield timed("limits", f"lamp 1 - rho = {left:g}", means, bound,
                    lambda s=lamp: face_means(s, 0.001, mesh="1"))  # fmt: skip
        yield timed("limits", f"lamp 1 - rho = {left:g}, differences", apart, bound,
                    lambda s=lamp: _differences(s))  # fmt: skip


def _differences(scene):
    b = face_means(scene, 0.001, mesh="1")
    return b[1:] - b[0]


def _lights():
    """No light, light of no size, one patch, black walls, lamps 1e12 times brighter than others."""
    yield timed("limits", "nothing emits", 0.0, 0.0, lambda: face_means(room_of(ROOM, RHO, 0.0)),
                False)  # fmt: skip
    point = np.repeat([[1.0, 1.0, 1.0]], 4, axis=0)[None]
    faces = Faces.from_polygons(np.concatenate([ROOM, point]), np.arange(7), 0, merge=False)
    whole = room_of(np.concatenate([ROOM, ROOM[:1]]), [*RHO, 0.0], [0] * 6 + [1.0])
    dark = Scene("point", faces, whole.materials, ("all",))
    yield timed("limits", "lamp of no size", 0.0, 0.0, lambda: face_means(dark), False)
    alone = room_of(ROOM[:1], 0.9, 2.0)
    yield timed("limits", "one patch", 2.0, 1e-15, lambda: face_means(alone, mesh="1"))
    emitted = np.array([0, 1.0, 0, 0, 0, 0.3])
    black = box_radiosity(DIMS, 0.0, emitted)
    yield timed("limits", "all black", black, 0.0,
                lambda: face_means(room_of(ROOM, 0.0, emitted), mesh="1"), False)  # fmt: skip
    for dim, bright in ((1.0, 1e12), (1e-12, 1.0)):
        emitted = np.array([0, bright, 0, 0, 0, dim])
        yield timed(
            "limits", f"lamps of {dim:g} and {bright:g}", box_radiosity(DIMS, RHO, emitted), SOLVER,
            lambda e=emitted: face_means(room_of(ROOM, RHO, e), 0.01, mesh="1"),
        )  # fmt: skip


def _scales():
    emitted = [0, 1.0, 0, 0, 0, 0.3]
    exact = box_radiosity(DIMS, RHO, emitted)
    for k in (1e-9, 1e9):
        yield timed("limits", f"lengths times {k:g}", exact, SOLVER,
                    lambda k=k: face_means(room_of(k * ROOM, RHO, emitted), 0.01, mesh="1")
                    )  # fmt: skip


def _thin():
    """Plates 1e-6 apart, open and closed: the walls of the closed one are slivers of 1e6."""
    gap = {c["id"]: c for c in load_cases("extremes")}["gap_1e-6"]
    f, rho = gap["value"][0], 0.9
    plates = [gap["geometry"]["A1"], gap["geometry"]["A2"]]
    b = 1.0 / (1.0 - (rho * f) ** 2)
    yield timed("limits", "plates 1e-6 apart", [b, rho * f * b], SOLVER,
                lambda: face_means(room_of(plates, rho, [1.0, 0.0]), 0.01, mesh="1"))  # fmt: skip
    # by symmetry three kinds of face: F from a wall to a plate is F from it to the wall / 1e-6
    side = gap["value"][1] / 4.0
    up = side / 1e-6
    kinds = np.array([[0, f, 4 * side], [f, 0, 4 * side], [up, up, 1.0 - 2.0 * up]])
    exact = np.linalg.solve(np.eye(3) - 0.5 * kinds, [1.0, 0.0, 0.0])[[0, 1, 2, 2, 2, 2]]
    flat = BOX * [1, 1, 1e-6]
    # 1e-5: 1 - F, the share of the walls, is known to 1e-12 of 2e-6
    yield timed("limits", "box of height 1e-6", exact, 1e-5, lambda: face_means(
        room_of(flat, 0.5, [1, 0, 0, 0, 0, 0]), 0.01, mesh="1"))  # fmt: skip


def _faults():
    """Faulty meshes, which a furnace or a box must not notice."""
    fin = np.array([[[1, 1, 0], [2, 1, 0], [2, 1, 1], [1, 1, 1]]], float)
    crossing = np.array([[[1.5, 0.5, 0.5], [1.5, 1.5, 0.5], [1.5, 1.5, 1.5], [1.5, 0.5, 1.5]],
                         [[1, 1, 0.7], [2, 1, 0.7], [2, 1, 1.2], [1, 1, 1.2]]])  # fmt: skip
    parts = {
        "a fin that three faces meet at": fin, "faces that cross": crossing,
        "a face given twice": [ROOM[0]], "a face over half of another": [ROOM[0] * [0.5, 1, 1]],
    }  # fmt: skip
    for name, more in parts.items():
        walls = np.concatenate([ROOM, np.array(more, float)])
        # what stands inside is white: it absorbs and emits nothing, so that the rest is a furnace
        rho, emitted = [0.5] * 6 + [1.0] * len(more), [1.0] * 6 + [0.0] * len(more)
        yield timed("limits", f"furnace with {name}", 2.0, SOLVER,
                    lambda w=walls, r=rho, e=emitted: _lit(room_of(w, r, e)))  # fmt: skip
    emitted = [0, 1.0, 0, 0, 0, 0.3]
    exact = box_radiosity(DIMS, RHO, emitted)
    twice = np.concatenate([ROOM, ROOM[2:3]])
    yield timed("limits", "box with a wall given twice", exact, SOLVER, lambda: face_means(
        room_of(twice, [*RHO, 0.9], [*emitted, 0.0]), 0.01, mesh="1")[:6])  # fmt: skip


def _lit(scene):
    """Return the radiosities of all that is lit."""
    solution = solve(scene, 0.01, mesh="2")
    return solution.radiosity[solution.live, 0]
