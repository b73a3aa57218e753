"""What arrives at points: closed forms, brute force, closure, rays where exact sums give up."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, block, box, faces_of, l_room, meshed, ring, rotation

from radiosity.analytic import point_to_parallel_rectangle
from radiosity.mesh.elements import make_elements
from radiosity.transport.arrival import arriving, make_senders, weights_of
from radiosity.transport.factors import patch_geometry
from radiosity.transport.polygon import add_moment, point_factor

UP = np.array([0.0, 0.0, 1.0])


def senders_of(polygons, n=3, order=1, tolerance=0.0):
    visibility, _, patches = meshed(faces_of(np.asarray(polygons, float)), n)
    rows = np.flatnonzero(~patches.covered)
    elements = make_elements(patches, rows, order)
    geometry = patch_geometry(patches, visibility, rows)
    return make_senders(elements, geometry, visibility, tolerance)


def plain_moments(x, n, polygon, facing, count=400):
    """The slow twin: factor and first moment of the kernel about the foot of x, by a rule."""
    g, w = np.polynomial.legendre.leggauss(count)
    g, w = (g + 1) / 2, w / 2
    s, t = np.meshgrid(g, g, indexing="ij")
    a, b, c, d = polygon
    y = (
        ((1 - s) * (1 - t))[..., None] * a + (s * (1 - t))[..., None] * b
        + (s * t)[..., None] * c + ((1 - s) * t)[..., None] * d
    )  # fmt: skip
    ds = (1 - t)[..., None] * (b - a) + t[..., None] * (c - d)
    dt = (1 - s)[..., None] * (d - a) + s[..., None] * (c - b)
    area = np.linalg.norm(np.cross(ds, dt), axis=2) * np.outer(w, w)
    r = y - x
    r2 = np.sum(r * r, axis=2)
    kernel = area * (r @ n) * -(r @ facing) / (np.pi * r2**2)
    along = r - (r @ facing)[..., None] * facing
    return kernel.sum(), np.einsum("st,stc->c", kernel, along)


def test_first_moments_are_exact():
    """Against Gauss rules over polygons at 0.1 to 10 sizes, of points that look any way."""
    rng, worst, tried = np.random.default_rng(0), 0.0, 0
    while tried < 60:
        turn = rotation(rng)
        polygon = np.array([[0, 0, 0], [1, 0, 0], [1.2, 1.1, 0], [-0.1, 1, 0]]) @ turn.T
        facing = turn @ UP
        x = polygon.mean(axis=0) + turn @ [*rng.uniform(-1, 1, 2), 10 ** rng.uniform(-1, 1)]
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        if ((polygon - x) @ n).min() < 1e-3:
            continue
        tried += 1
        moment = np.zeros(3)
        add_moment(x, n, polygon, facing, moment)
        factor, expected = plain_moments(x, n, polygon, facing)
        assert point_factor(*x, *n, polygon) == pytest.approx(factor, rel=1e-9)
        worst = max(worst, np.abs(moment - expected).max() / factor)
    assert worst < 1e-7  # eight points an edge where the polygon is seen under a wide angle


def test_moments_of_touching_edges_and_far_polygons():
    """A point near an edge of the polygon, and a polygon a thousand sizes away."""
    polygon, facing = SQUARE[::-1] + [-0.5, -0.5, 1.0], -UP
    for x, n in (([0.499, 0.0, 0.0], [0.6, 0, 0.8]), ([300.0, 0, -1000], [0, 0, 1.0])):
        x, n, moment = np.array(x), np.array(n), np.zeros(3)
        add_moment(x, n, polygon, facing, moment)
        factor, expected = plain_moments(x, n, polygon, facing)
        assert moment == pytest.approx(expected, abs=1e-6 * np.linalg.norm(expected))


def test_lamps_over_points_are_exact():
    senders = senders_of([SQUARE[::-1] + [0, 0, 1]], order=0)
    found = arriving(senders, np.ones((9, 1)), np.array([[0.0, 0, 0]]), UP[None])
    assert found.total[0, 0] == pytest.approx(point_to_parallel_rectangle(1, 1, 1), rel=1e-12)
    assert found.error[0, 0] == 0.0


def random_points(rng, count, low=(0.05, 0.05, 0.05), high=(0.95, 0.95, 0.95)):
    normals = rng.normal(size=(count, 3))
    return rng.uniform(low, high, (count, 3)), normals / np.linalg.norm(normals, axis=1)[:, None]


@pytest.mark.parametrize(
    "polygons", [box((0, 0, 0), (1, 1, 1)), np.concatenate([
        box((0, 0, 0), (1, 1, 1)), block((0.3, 0.3, 0), (0.5, 0.6, 0.4), False)]), l_room()],
    ids=["box", "block", "L"],
)  # fmt: skip
def test_points_in_closed_rooms_see_factors_of_sum_1(polygons):
    rng = np.random.default_rng(1)
    points, normals = random_points(rng, 60)
    free = ~np.all((points > [0.3, 0.3, 0]) & (points < [0.5, 0.6, 0.4]), axis=1)
    senders = senders_of(polygons)
    seen = arriving(senders, np.zeros((3 * len(senders.elements), 1)), points, normals).seen
    # 3e-5: points look past blockers from 1e-5 of the room over their place
    assert seen[free] == pytest.approx(1.0, abs=3e-5)


def test_linear_fields_over_a_room_against_brute_force():
    """B = 10 + slope . x on all walls of a box with a block, by 200 x 200 directions."""
    slope, rng = np.array([0.7, -1.1, 0.4]), np.random.default_rng(2)
    walls = np.concatenate([
        box((0, 0, 0), (1, 1, 1)), block((0.3, 0.3, 0), (0.5, 0.6, 0.4), False)])  # fmt: skip
    senders = senders_of(walls)
    b = coefficients(senders.elements, slope)
    points, normals = random_points(rng, 12, (0.6, 0.1, 0.1), (0.95, 0.9, 0.9))
    found = arriving(senders, b[:, None], points, normals).total[:, 0]
    assert found == pytest.approx(by_directions(walls, points, normals, slope), rel=2e-3)


def test_walls_hide_a_room_from_points_outside_of_it():
    """Nothing lies behind a room's walls, so that they block nothing: but what looks from there."""
    slope, rng = np.array([0.7, -1.1, 0.4]), np.random.default_rng(4)
    walls = np.delete(box((0, 0, 0), (1, 1, 1)), 3, axis=0)  # open at x = 1
    senders = senders_of(walls)
    b = coefficients(senders.elements, slope)
    points, _ = random_points(rng, 24, (-1.5, -1.5, -1.5), (2.5, 2.5, 2.5))
    points[:4] = [[1.5, 0.5, 0.5], [0.5, 0.5, -1e-3], [-1e-3, 0.2, 0.7], [0.5, 0.5, 0.1]]
    normals = (0.5 - points) / np.linalg.norm(0.5 - points, axis=1)[:, None]
    found = arriving(senders, b[:, None], points, normals).total[:, 0]
    expected = by_directions(walls, points, normals, slope, 300)
    assert found == pytest.approx(expected, rel=5e-3, abs=5e-3)
    assert np.all(found[1:3] == 0.0) and np.sum(found == 0.0) > 5 and np.sum(found > 0.1) > 5


def coefficients(elements, slope):
    """Coefficients of 10 + slope . x: axes have the length 1/radius, so slopes times its square."""
    square = np.sum(elements.axes**2, axis=2)
    parts = [np.einsum("nc,c->n", elements.axes[:, a], slope) / square[:, a] for a in (0, 1)]
    return np.concatenate([10.0 + elements.centroid @ slope, *parts])


def by_directions(walls, points, normals, slope, count=200):
    """The slow twin: what 2 count^2 cosine-distributed directions meet first."""
    u = (np.arange(count) + 0.5) / count
    phi = 2 * np.pi * (np.arange(2 * count) + 0.5) / (2 * count)
    found = []
    for x, n in zip(points, normals, strict=True):
        across = np.cross(n, [0.3, 0.5, 0.8])
        across /= np.linalg.norm(across)
        frame = np.array([across, np.cross(n, across), n])
        r, z = np.sqrt(u)[:, None], np.sqrt(1 - u)[:, None]
        d = np.stack([r * np.cos(phi), r * np.sin(phi), z + 0 * phi], axis=2).reshape(-1, 3) @ frame
        nearest, value = np.full(len(d), np.inf), np.zeros(len(d))
        for w in walls:
            facing = np.cross(w[1] - w[0], w[3] - w[0])
            with np.errstate(divide="ignore", invalid="ignore"):
                t = ((w[0] - x) @ facing) / (d @ facing)
            y = x + t[:, None] * d
            inside = (t > 1e-9) & (t < nearest)
            for k in range(4):
                edge = w[(k + 1) % 4] - w[k]
                inside &= np.cross(edge, y - w[k]) @ facing > -1e-12
            sent = np.where(d @ facing < 0, 10.0 + y @ slope, 0.0)  # backs are dark
            nearest[inside], value[inside] = t[inside], sent[inside]
        found.append(value.mean())
    return np.array(found)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
def test_rules_of_far_patches_keep_their_tolerance(tolerance):
    rng = np.random.default_rng(3)
    walls = np.concatenate([
        box((0, 0, 0), (1, 1, 1)), block((0.3, 0.3, 0), (0.5, 0.6, 0.4), False)])  # fmt: skip
    points, normals = random_points(rng, 40, (0.6, 0.1, 0.1), (0.95, 0.9, 0.9))
    exact, _ = weights_of(senders_of(walls, 6), points, normals)
    fast, _ = weights_of(senders_of(walls, 6, tolerance=tolerance), points, normals)
    n = exact.shape[1] // 3
    off = np.abs(fast - exact).sum(axis=1) / np.abs(exact[:, :n]).sum(axis=1)
    assert 0.0 < off.max() < 2.0 * tolerance  # factors and both moments together
    assert np.array_equal(exact[:, :n] > 0, fast[:, :n] > 0)  # what is hidden stays hidden


def test_many_blockers_are_left_to_rays():
    """Hundreds of small sheets: rays find what exact shadows find with more room for them."""
    rng = np.random.default_rng(4)
    sheets = [
        0.02 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) + [x, y, 0.5]
        for x in np.linspace(0.03, 0.97, 19) for y in np.linspace(0.03, 0.97, 19)
    ]  # fmt: skip
    polygons = np.concatenate([[SQUARE], [SQUARE[::-1] + [0, 0, 1]], sheets])
    senders = senders_of(polygons, 1, 0)
    points = np.column_stack([rng.uniform(0.2, 0.8, (30, 2)), np.zeros(30)])
    weights, doubt = weights_of(senders, points, np.tile(UP, (30, 1)))
    assert doubt is not None
    exact = [visible_lamp(p, polygons[1], sheets) for p in points]
    off = weights[:, 1] - exact
    assert np.sqrt(np.mean(off**2)) < 2.0 * np.sqrt(np.mean(doubt[:, 1] ** 2))
    assert np.sqrt(np.mean(off**2)) < 0.1 * np.mean(exact)  # 64 rays for each lamp


def visible_lamp(x, lamp, sheets, count=100):
    """The slow twin: kernel over count x count points of the lamp, past all sheets."""
    s = (np.arange(count) + 0.5) / count
    y = lamp[0] + s[:, None, None] * (lamp[1] - lamp[0]) + s[None, :, None] * (lamp[3] - lamp[0])
    r = y.reshape(-1, 3) - x
    free = np.ones(len(r), bool)
    for sheet in sheets:
        at = x + r * ((sheet[0, 2] - x[2]) / r[:, 2])[:, None]
        free &= ~np.all((at[:, :2] > sheet[0, :2]) & (at[:, :2] < sheet[2, :2]), axis=1)
    return np.sum(free * r[:, 2] ** 2 / (np.pi * np.sum(r * r, axis=1) ** 2)) / count**2


def test_turning_and_scaling_change_nothing():
    rng = np.random.default_rng(5)
    walls = np.concatenate([box((0, 0, 0), (1, 1, 1)), [ring(rng, 4, 0.2) + 0.5]])
    points, normals = random_points(rng, 20)
    one, _ = weights_of(senders_of(walls), points, normals)
    turn = rotation(rng)
    other, _ = weights_of(senders_of(1e3 * walls @ turn.T), 1e3 * points @ turn.T, normals @ turn.T)
    assert invariants(other) == pytest.approx(invariants(one), abs=1e-11)


def invariants(weights):
    """Factors, and the lengths of moments: their axes run along the longest of equal edges."""
    factor, one, two = np.split(weights, 3, axis=1)
    return np.concatenate([factor, np.hypot(one, two)], axis=1)


def test_what_lies_behind_a_point_or_looks_away_sends_nothing():
    senders = senders_of([SQUARE + [0, 0, 1]], 1, 0)  # looks up, away from the points below
    assert not weights_of(senders, np.array([[0.5, 0.5, 0.0]]), UP[None])[0].any()
    assert not weights_of(senders, np.array([[0.5, 0.5, 2.0]]), UP[None])[0].any()
    assert weights_of(senders, np.array([[0.5, 0.5, 2.0]]), -UP[None])[0][0, 0] > 0
