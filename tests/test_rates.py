"""Observed orders of convergence, each with its norm, its class of scene and the reason for it.

Norm: L2 over the surfaces, relative. ``stored`` is the irradiance as the elements hold it, anywhere
on a patch; ``gathered`` is computed anew at each point from the stored radiosities. Truth: linear
elements on a much finer mesh, gathered.
"""

from functools import cache

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, faces_of, meshed, scene

import radiosity
from radiosity.analytic import box_form_factors, load_cases
from radiosity.mesh.division import Division
from radiosity.solve.equations import System
from radiosity.solve.level import solve_level
from radiosity.solve.methods import gauss_seidel, jacobi
from radiosity.solve.plan import Recipe
from radiosity.solve.reach import find_reach
from radiosity.transport.counting import count_rays, counted_factors
from radiosity.transport.operator import FormFactors

HALVINGS = (1, 2, 4, 8, 16)
WITHIN = 0.15
EXACT = {"factors": 1e-6, "rule": 0.0, "tolerance": 1e-12, "solver": "gauss-seidel"}

# Two squares apart, aside of each other: no shared edge, no shadow; all is smooth.
SMOOTH = scene([SQUARE, SQUARE[::-1] + [0.3, 0.2, 1]], [0.8, 0.6], [1, 0.0])
# Two squares that share an edge: at its ends E depends on the direction from the corner only.
EDGE = scene([SQUARE, [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]]], [0.8, 0.8], [1, 0.3])
# Floor and ceiling with a lamp and a sheet between them: E on the floor has kinks.
WIDE = SQUARE * [1, 2, 1] - [0, 0.5, 0]
LAMP = np.array([[0.31, -0.5, 0.9], [0.31, 1.5, 0.9], [0.62, 1.5, 0.9], [0.62, -0.5, 0.9]])
SHEET = np.array([[0.37, -0.5, 0.4], [0.83, -0.5, 0.4], [0.83, 1.5, 0.4], [0.37, 1.5, 0.4]])
SHADOWS = [
    scene(
        [WIDE, WIDE[::-1] + [0, 0, 1], LAMP + [a, 0, 0], SHEET - [b, 0, 0]],
        [0.8, 0.8, 0, 0], [0, 0, 3.0, 0],
    ) for a, b in ((0, 0), (0.017, 0.023), (0.041, 0.012))
]  # fmt: skip
SCENES = {"smooth": [SMOOTH], "edge": [EDGE], "shadow": SHADOWS}


def level(room, n, order):
    shape = np.full((len(room.faces), 2), 1)
    shape[:2] = n
    return solve_level(room, find_reach(room, Division(shape), 0), Recipe(order=order, **EXACT))


def rule(points):
    """Return shares of corners (m^2, 4) and weights of Gauss' rule over the unit square."""
    x, w = np.polynomial.legendre.leggauss(points)
    x, w = (x + 1) / 2, w / 2
    s, t = (a.ravel() for a in np.meshgrid(x, x, indexing="ij"))
    return np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1), np.outer(w, w)


@cache
def errors(name, order):
    """Return (2, levels): the errors of what is stored and of what is gathered, on faces 0 and 1.

    By 3 x 3 Gauss points a patch: at 2 x 2 linear elements are better than elsewhere. The root of
    the mean square of all scenes of a class: where a kink falls in a cell is chance.
    """
    squares = [errors_of(name, k, order) ** 2 for k in range(len(SCENES[name]))]
    return np.sqrt(np.mean(squares, axis=0))


@cache
def truth_of(name, k):
    return level(SCENES[name][k], 26, 1)


def errors_of(name, k, order):
    found, room, truth = [], SCENES[name][k], truth_of(name, k)
    for n in HALVINGS:
        solved = level(room, n, order)
        elements, rows = solved.senders.elements, solved.rows
        mine = np.flatnonzero(solved.reach.patches.face[rows] < 2)
        mine = mine[solved.reach.patches.front[rows[mine]]]
        shares, weight = rule(3)
        points, own = (shares @ elements.vertices[mine]).reshape(-1, 3), np.repeat(mine, 9)
        weight = np.outer(solved.reach.patches.area[rows[mine]], weight.ravel()).ravel()
        where = points, elements.normal[own]
        e = truth.gathered(*where).total[:, 0]
        stored = elements.at(points, own, solved.arriving)[:, 0]
        gathered = solved.gathered(*where).total[:, 0]
        scale = weight @ e**2
        found.append([np.sqrt(weight @ (x - e) ** 2 / scale) for x in (stored, gathered)])
    return np.array(found).T


def order_of(off):
    """Return the slope of log2(error) against the number of halvings."""
    return -np.polyfit(np.arange(len(off)), np.log2(off), 1)[0]


@pytest.mark.parametrize(
    "name, order, which, expected, constant",
    [
        # Taylor: what constants leave of a smooth function is of order 1, what lines leave of 2
        ("smooth", 0, "stored", 1.0, 0.30),
        ("smooth", 1, "stored", 2.0, 0.12),
        # the kernel is smooth too, and errors on a patch are orthogonal to what elements can be:
        # twice the order; Gauss points keep it for linear elements
        ("smooth", 0, "gathered", 2.0, 0.010),
        ("smooth", 1, "gathered", 4.0, 0.002),
        # E is not continuous in the corners: O(1) on an area h^2, so order 1, gathered or not
        ("edge", 1, "stored", 1.0, 0.22),
        ("edge", 1, "gathered", 1.0, 0.035),
        # kinks: O(h) on a share h of the cells, h^1.5; their integrals by Gauss points err by h^2
        ("shadow", 1, "stored", 1.5, 0.95),
        ("shadow", 1, "gathered", 2.0, 0.1),
    ],
)
def test_order(name, order, which, expected, constant):
    off = errors(name, order)[("stored", "gathered").index(which)]
    assert order_of(off) == pytest.approx(expected, abs=WITHIN)
    h = 1.0 / np.array(HALVINGS)
    assert np.all(off <= 1.3 * constant * h**expected)  # reached: the constant to 30 %
    assert off[-1] >= constant * h[-1] ** expected / 4.0


def test_order_of_form_factors_in_the_mesh():
    """Disks as polygons of n corners: their area errs by h^2, and so does F of two of them."""
    case = next(c for c in load_cases("vf_curved") if c["geometry"]["type"] == "coaxial_disks")
    g, off = case["geometry"], []
    for n in (8, 16, 32, 64, 128):
        off.append(abs(disks(n, g) / case["value"] - 1))
    assert order_of(off) == pytest.approx(2.0, abs=WITHIN)
    assert off[0] < 0.2 and off[-1] < 1e-3


def disks(n, g):
    """Return F between two disks as fans of n triangles."""
    angle = 2 * np.pi * np.arange(n + 1) / n
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    fan = np.stack([0 * ring[:-1], ring[:-1], ring[1:], ring[1:]], axis=1)
    r1, r2, d = g["r1"], g["r2"], g["h"]
    lower, upper = fan * r1, fan[:, [0, 2, 1, 1]] * r2 + [0, 0, d]
    corners = np.concatenate([lower, upper])[:, :3].reshape(-1, 3)
    mesh = corners, np.arange(len(corners)).reshape(-1, 3)
    factors = radiosity.form_factors(mesh, 1e-4, repair=False)
    return factors.grouped(np.repeat([0, 1], n)).toarray()[0, 1]


def test_order_in_the_number_of_rays():
    """Even points in d dimensions on either side of an edge: N^(-(d + 1)/(2 d)), d = 4: 0.625."""
    exact = box_form_factors((1, 1, 1))
    visibility, table, patches = meshed(faces_of(box((0, 0, 0), (1, 1, 1))), 2)
    area, off = np.bincount(patches.face, patches.area), []
    for rays in (256, 1024, 4096, 16384, 65536):
        found = [
            counted_factors(
                count_rays(patches, np.arange(24), patches.face, visibility, table, range(rays),
                           seed), area, rays
            ).toarray() for seed in range(16)
        ]  # fmt: skip
        off.append(np.sqrt(np.mean((np.array(found) - exact) ** 2)))
    assert order_of(off) / 2.0 == pytest.approx(0.625, abs=WITHIN)
    assert off[-1] < 6e-4


# ---------------------------------------------------------------------- solvers


def rate_of(history):
    """Return by what factor an iteration shrinks its error, from its later half."""
    h = np.array(history)
    k = len(h) // 2
    return (h[-1] / h[k]) ** (1.0 / (len(h) - 1 - k))


def box_system(rho):
    """The box of 4 x 3 x 2.5, six patches a face, one face emits."""
    _, _, patches = meshed(faces_of(box((0, 0, 0), (4, 3, 2.5))), 2)
    corners = patches.vertices.reshape(-1, 3)
    factors = radiosity.form_factors((corners, np.arange(len(corners)).reshape(-1, 4)), 1e-6)
    rho = np.broadcast_to(np.asarray(rho, float), 6)[patches.face][:, None]
    source = (patches.face == 1)[:, None].astype(float)
    return System(factors, rho, 1.0 - rho, source)


def eigenvalues(system):
    """Return the spectral radii of the iterations of Jacobi and of Gauss-Seidel."""
    a = system.reflectance * system.factors.toarray()
    below, above = np.tril(a), np.triu(a, 1)
    one = np.abs(np.linalg.eigvals(a)).max()
    two = np.abs(np.linalg.eigvals(np.linalg.solve(np.eye(len(a)) - below, above))).max()
    return one, two


RHO = [0.2, 0.7, 0.5, 0.3, 0.6, 0.9]


@pytest.mark.parametrize("rho", [0.5, 0.9, RHO], ids=["half", "bright", "mixed"])
def test_jacobi_shrinks_errors_by_its_eigenvalue(rho):
    """At most max rho, and just that where all walls of a closed room reflect alike."""
    system = box_system(rho)
    expected, _ = eigenvalues(system)
    _, history = jacobi(system, 1e-12)
    assert rate_of(history) == pytest.approx(expected, rel=1e-2)
    assert expected <= np.max(rho) + 1e-12
    if np.ndim(rho) == 0:
        assert expected == pytest.approx(rho, rel=1e-12)


@pytest.mark.parametrize("rho", [0.5, 0.9, RHO], ids=["half", "bright", "mixed"])
def test_gauss_seidel_shrinks_errors_by_about_the_square(rho):
    system = box_system(rho)
    one, expected = eigenvalues(system)
    _, history = gauss_seidel(system, 1e-12)
    assert rate_of(history) == pytest.approx(expected, rel=0.05)  # complex pairs: it swings
    assert 1.5 < np.log(expected) / np.log(one) < 2.6  # 2 where the patches fall into two groups


def test_gauss_seidel_of_two_groups_is_exactly_the_square():
    """Two plates that see each other and nothing else: the rate of a sweep is rho^2."""
    factors = FormFactors(np.array([[0.0, 1.0], [1.0, 0.0]]), np.ones(2))
    rho = np.full((2, 1), 0.8)
    system = System(factors, rho, 1.0 - rho, np.array([[1.0], [0.0]]))
    _, history = gauss_seidel(system, 1e-12)
    assert rate_of(history) == pytest.approx(0.64, rel=1e-4)  # bounds are relative to B so far
