"""What can come between: sorted pairs and the tree, against plain loops over crossings and rays."""

import numpy as np
import pytest
from scenes_for_tests import (
    SQUARE,
    block,
    box,
    faces_of,
    l_room,
    meshed,
    normal_of,
    ring,
    rotation,
    tetrahedron,
    uv_sphere,
)

from radiosity.mesh.patches import reversed_winding
from radiosity.transport.blockers import (
    AWAY,
    BETWEEN,
    COVERS,
    HIDDEN,
    LEAF,
    MOST,
    TOO_MANY,
    between,
    find_blockers,
    keep_between,
    make_blockers,
    prepare_lines,
)
from radiosity.transport.factors import form_factors, patch_geometry
from radiosity.transport.shaft import shaft_planes
from radiosity.transport.visibility import Visibility

GRAIN = 1e-15  # of coordinates about 1
SLACK = 4 * GRAIN
ROOM = box((0, 0, 0), (2, 1, 1))
FURNISHED = np.concatenate([ROOM, block((0.4, 0.3, 0), (0.8, 0.6, 0.5), False)])


def crossings(polygon, p, q):
    """Return where lines from corners of p to corners of q meet the plane of a polygon (k, 3)."""
    n = normal_of(polygon)
    x, y = (a.reshape(-1, 3) for a in np.broadcast_arrays(p[:, None], q[None]))
    hx, hy = (x - polygon[0]) @ n, (y - polygon[0]) @ n
    return x + (hx / (hx - hy))[:, None] * (y - x)


def plain_between(polygon, p, q):
    """The slow twin: where the corner-to-corner segments cross, and on which side of each edge.

    Also how near any decision was.
    """
    n = normal_of(polygon)
    hp, hq = (p - polygon[0]) @ n, (q - polygon[0]) @ n
    near = np.abs(np.concatenate([hp, hq])).min()
    same = (hp.min() > 0 and hq.min() > 0) or (hp.max() < 0 and hq.max() < 0)
    if same:
        return AWAY, near
    if (hp.min() < 0 < hp.max()) or (hq.min() < 0 < hq.max()):
        return None, near  # no plane cuts every segment once: the sort may be careful
    at, inside = crossings(polygon, p, q), True
    for k in range(len(polygon)):
        edge = polygon[(k + 1) % len(polygon)] - polygon[k]
        side = np.cross(edge, at - polygon[k]) @ n
        near = min(near, np.abs(side).min())
        if np.all(side < 0):
            return AWAY, near
        inside = inside and np.all(side > 0)
    return (COVERS if inside else BETWEEN), near


def random_triple(rng):
    """Return a blocker and two quadrilaterals around it, of all kinds of sizes."""
    polygon = ring(rng, rng.integers(3, 9), rng.choice([0.3, 1.5]))
    p = ring(rng, 4, 0.3) + [0, 0, -1] + rng.uniform(-0.4, 0.4, 3)
    q = ring(rng, 4, 0.3) + [0, 0, 1] + rng.uniform(-0.4, 0.4, 3)
    return polygon, p, q


def segments(rng, p, q, count=200):
    """Return ends of random segments between two convex polygons, corners among them."""
    ends = []
    for polygon in (p, q):
        weight = rng.dirichlet(np.full(len(polygon), 0.5), count)
        weight[: len(polygon)] = np.eye(len(polygon))
        ends.append(rng.permutation(weight @ polygon))
    return ends


def crossed(polygon, x, y):
    """Whether segments x-y (k, 3) cross a convex polygon."""
    n = normal_of(polygon)
    hx, hy = (x - polygon[0]) @ n, (y - polygon[0]) @ n
    at = x + (hx / np.where(hx == hy, 1.0, hx - hy))[:, None] * (y - x)
    found = hx * hy < 0
    for k in range(len(polygon)):
        edge = polygon[(k + 1) % len(polygon)] - polygon[k]
        found &= np.cross(edge, at - polygon[k]) @ n > 0
    return found


# ------------------------------------------------------------------------------- one blocker


def test_blockers_are_sorted_as_by_their_plain_twin():
    rng = np.random.default_rng(0)
    kinds = np.zeros(3, int)
    for _ in range(1500):
        polygon, p, q = random_triple(rng)
        expected, near = plain_between(polygon, p, q)
        if expected is None or near < 1e-9:
            continue
        assert between(polygon, normal_of(polygon), p, q, SLACK) == expected
        kinds[expected] += 1
    assert kinds.min() > 50


def test_segments_confirm_how_blockers_are_sorted():
    """No segment crosses one that is away, every one crosses one that covers; straddling too."""
    rng = np.random.default_rng(1)
    straddling = 0
    for _ in range(600):
        polygon, p, q = random_triple(rng)
        found = between(polygon, normal_of(polygon), p, q, SLACK)
        hit = crossed(polygon, *segments(rng, p, q))
        assert not (found == AWAY and hit.any())
        assert not (found == COVERS and not hit.all())
        straddling += plain_between(polygon, p, q)[0] is None
    assert straddling > 50


def test_ends_winding_and_shape_do_not_matter():
    rng = np.random.default_rng(2)
    for _ in range(300):
        polygon, p, q = random_triple(rng)
        n, turn = normal_of(polygon), rotation(rng)
        found = between(polygon, n, p, q, SLACK)
        straddles = plain_between(polygon, p, q)[0] is None
        assert between(polygon[::-1].copy(), -n, p, q, SLACK) == found
        assert between(polygon @ turn.T, turn @ n, p @ turn.T, q @ turn.T, SLACK) == found
        assert straddles or between(polygon, n, q, p, SLACK) == found


def test_what_touches_is_away():
    """Blockers that share an edge or the plane with one of the ends, rotated."""
    rng = np.random.default_rng(3)
    p, q = SQUARE, SQUARE[::-1] + [0, 0, 1.0]
    wall = np.array([[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1.0]])
    for polygon in (wall, SQUARE + [1.0, 0, 0], q + [0, 1.0, 0], q):
        for _ in range(5):
            turn = rotation(rng)
            args = [x @ turn.T for x in (polygon, p, q)]
            assert between(args[0], normal_of(args[0]), *args[1:], SLACK) == AWAY
    cover = 3 * (SQUARE - [0.5, 0.5, 0]) + [0.5, 0.5, 0.5]
    assert between(cover, normal_of(cover), p, q, SLACK) == COVERS
    exact = SQUARE + [0, 0, 0.5]  # as large as the shaft: its edges touch the outline
    assert between(exact, normal_of(exact), p, q, SLACK) == COVERS


# ------------------------------------------------------------------------------- which can block


def blockers_of(polygons):
    return Visibility(faces_of(polygons)).blockers


@pytest.mark.parametrize(
    "polygons, count",
    [
        (box((0, 0, 0), (1, 2, 3)), 0),
        (block((0, 0, 0), (1, 1, 1)), 0),
        (tetrahedron(), 0),
        (uv_sphere(6), 0),
        (l_room(), 2),  # the walls of the inner corner
        (FURNISHED, 5),
        (np.concatenate([ROOM, ROOM @ np.diag([0.5, 0.5, 0.5]) + 0.2]), 6),
    ],
)
def test_only_what_is_not_on_the_hull_can_block(polygons, count):
    rng = np.random.default_rng(0)
    for size, offset in ((1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e4)):
        turned = size * (polygons @ rotation(rng).T + offset)
        assert len(blockers_of(turned).count) == count


def test_the_tree_holds_every_blocker():
    rng = np.random.default_rng(4)
    for k in (1, 2, 3, 17, 200):
        rings = [ring(rng, 8, 0.1) + rng.uniform(-1, 1, 3) for _ in range(k)]
        normal = np.array([normal_of(r) for r in rings])
        made = make_blockers(np.array(rings), np.full(k, 8), normal, np.arange(k), GRAIN)
        assert len(made.count) <= k and (k < 17 or len(made.count) > 0.9 * k)
        kept = {tuple(c.ravel()) for c in made.corners}
        assert kept <= {tuple(r.ravel()) for r in rings}
        for b, corners in enumerate(made.corners):
            assert np.array_equal(corners, rings[made.body[b]])  # all that belongs to it moved too
            m = made.leaves + b // LEAF
            while m > 0:
                assert np.all(made.low[m] <= corners.min(axis=0))
                assert np.all(made.high[m] >= corners.max(axis=0))
                m //= 2


# ------------------------------------------------------------------------------- searches


def crowd(rng, count):
    """Return a room of sheets of which none touch: its visibility, patches, their geometry."""
    places = rng.permutation(
        np.stack(np.meshgrid(*[np.linspace(-0.6, 0.6, 4)] * 3), -1).reshape(-1, 3)
    )
    sheets = [(SQUARE - [0.5, 0.5, 0]) * rng.uniform(0.15, 0.28) @ rotation(rng).T + place
              for place in places[:count]]  # fmt: skip
    faces = faces_of(np.concatenate([box((-1, -1, -1), (1, 1, 1)), sheets]))
    visibility, _, patches = meshed(faces, 6)
    return visibility, patches, patch_geometry(patches, visibility)


def search(visibility, geometry, i, j):
    """Return HIDDEN, TOO_MANY or the set that `find_blockers` finds between patches i and j."""
    p, q, slack = geometry.vertices[i], geometry.vertices[j], 4 * geometry.grain.max()
    planes, found = np.empty((10, 4)), np.empty(MOST, np.int64)
    free = np.zeros(visibility.blockers.body.max(initial=0) + 1, bool)
    bounds = shaft_planes(geometry, i, j, slack, planes)
    count = find_blockers(
        visibility.blockers, free, p, np.repeat(q, 2, axis=0), planes[:bounds], slack, -slack,
        np.empty(64, np.int64), found,
    )  # fmt: skip
    return count if count < 0 else set(found[:count].tolist())


def in_front(corners, geometry, i):
    return np.max((corners - geometry.centroid[i]) @ geometry.normal[i]) > 4 * geometry.grain.max()


@pytest.mark.parametrize("count", [5, 40])
def test_searches_agree_with_a_plain_loop(count):
    rng = np.random.default_rng(count)
    visibility, patches, geometry = crowd(rng, count)
    blockers, slack = visibility.blockers, 4 * geometry.grain.max()
    assert len(blockers.count) == count
    hidden = some = 0
    for i, j in rng.integers(0, len(patches), (1500, 2)):
        p, q = geometry.vertices[i], geometry.vertices[j]
        sides = [p @ geometry.normal[j] - geometry.centroid[j] @ geometry.normal[j],
                 q @ geometry.normal[i] - geometry.centroid[i] @ geometry.normal[i]]  # fmt: skip
        if min(s.max() for s in sides) <= slack:
            continue
        polygons = [blockers.corners[b, : blockers.count[b]] for b in range(count)]
        sorts = [between(c, n, p, q, slack) for c, n in zip(polygons, blockers.normal, strict=True)]
        front = [in_front(c, geometry, i) for c in polygons]
        found = search(visibility, geometry, i, j)
        if COVERS in sorts:
            assert found == HIDDEN
            hidden += 1
            continue
        allowed = {b for b in range(count) if sorts[b] == BETWEEN and front[b]}
        x, y = segments(rng, p, q)
        needed = {b for b in range(count) if crossed(polygons[b], x, y).any() and front[b]}
        inside = {b for b in needed if in_front(polygons[b], geometry, j)}
        assert inside <= found <= allowed
        some += len(found) > 0
        assert kept(blockers, geometry, i, j, sorted(allowed)) == {
            b for b in allowed if in_front(polygons[b], geometry, j)
        }
    assert some > 100 and (hidden > 10 or count < 40)


def kept(blockers, geometry, i, j, candidates):
    """Return the set that `keep_between` leaves of the candidates."""
    candidates = np.array(candidates, np.int64)
    lines, sides = np.empty((MOST, 8, 4, 4)), np.empty(MOST)
    slack, found = 4 * geometry.grain.max(), np.empty(MOST, np.int64)
    prepare_lines(blockers, candidates, geometry.vertices[i], slack, lines, sides)
    count = keep_between(
        blockers, candidates, lines, sides, geometry.centroid[j], geometry.normal[j],
        geometry.vertices[j], slack, found,
    )  # fmt: skip
    return count if count < 0 else set(found[:count].tolist())


def test_prepared_sorts_agree_with_single_ones():
    """All candidates, also those away and those that cover."""
    rng = np.random.default_rng(7)
    visibility, patches, geometry = crowd(rng, 20)
    blockers, slack = visibility.blockers, 4 * geometry.grain.max()
    seen = set()
    for i, j in rng.integers(0, len(patches), (1000, 2)):
        for b in range(20):
            corners = blockers.corners[b, : blockers.count[b]]
            if not in_front(corners, geometry, i):
                continue
            p, q = geometry.vertices[i], geometry.vertices[j]
            expected = between(corners, blockers.normal[b], p, q, slack)
            if not in_front(corners, geometry, j):
                expected = AWAY
            result = {AWAY: set(), BETWEEN: {b}, COVERS: HIDDEN}[expected]
            assert kept(blockers, geometry, i, j, [b]) == result
            seen.add(expected)
    assert seen == {AWAY, BETWEEN, COVERS}


def test_more_than_can_be_cut_out_are_told():
    """40 sheets on a string: no one of them covers the shaft."""
    sheets = [0.1 * SQUARE + [0.45, 0.45, z] for z in np.linspace(0.2, 0.8, 40)]
    faces = faces_of(np.concatenate([[SQUARE, SQUARE[::-1] + [0, 0, 1.0]], sheets]))
    visibility, _, patches = meshed(faces, 1)
    geometry = patch_geometry(patches, visibility)
    assert search(visibility, geometry, 0, 1) == TOO_MANY
    fewer = faces_of(np.concatenate([[SQUARE, SQUARE[::-1] + [0, 0, 1.0]], sheets[:MOST]]))
    visibility, _, patches = meshed(fewer, 1)
    assert len(search(visibility, patch_geometry(patches, visibility), 0, 1)) == MOST


# ------------------------------------------------------------------------------- against rays


def test_rays_confirm_what_is_hidden_and_what_is_open():
    rng = np.random.default_rng(9)
    visibility, patches, geometry = crowd(rng, 30)
    kinds = {"hidden": 0, "open": 0}
    for i, j in rng.integers(0, len(patches), (2000, 2)):
        x, y = segments(rng, 0.98 * geometry.vertices[i] + 0.02 * geometry.centroid[i],
                        0.98 * geometry.vertices[j] + 0.02 * geometry.centroid[j], 64)  # fmt: skip
        facing = ((y - x) @ geometry.normal[i] > 0.05) & ((x - y) @ geometry.normal[j] > 0.05)
        if not facing.all():
            continue
        start, span = x + 1e-4 * (y - x), (1 - 2e-4) * (y - x)  # off both surfaces
        blocked = visibility.blocked(start.astype(np.float32), span.astype(np.float32))
        found = search(visibility, geometry, i, j)
        if found == HIDDEN:
            assert blocked.all()
            kinds["hidden"] += 1
        elif found == set():
            assert not blocked.any()
            kinds["open"] += 1
    assert kinds["hidden"] > 10 and kinds["open"] > 10


FLOATING = block((0.4, 0.3, 0.2), (0.8, 0.6, 0.5))
STANDING = {
    "blocks": [ROOM, FLOATING, block((1, 0.3, 0.1), (1.3, 0.6, 0.9))],
    "ball": [ROOM, 0.2 * reversed_winding(uv_sphere(5)) + [1, 0.5, 0.5]],
    "open": [2 * SQUARE[None] - 1, FLOATING, SQUARE[None, ::-1] + [0, 0, 2]],
}


@pytest.mark.parametrize("name", STANDING)
def test_backs_of_closed_bodies_may_be_left_out(name, monkeypatch):
    """Who is on a body's free side meets its fronts first: factors are those of all its faces."""
    visibility, _, patches = meshed(faces_of(np.concatenate(STANDING[name])), 2)
    live = ~patches.covered
    assert visibility.free_sides(patches).any()
    few = form_factors(patches, visibility, live, 1e-3)
    every = np.zeros_like(visibility.free_sides(patches))
    monkeypatch.setattr(visibility, "free_sides", lambda patches: every, raising=False)
    many = form_factors(patches, visibility, live, 1e-3)
    # cells are divided at other places where the tolerance is met at once
    apart = np.abs(few.exchange - many.exchange).sum(axis=1) / few.area
    assert apart.max() < 1e-3
    one_only = (few.exchange > 0) != (many.exchange > 0)  # at grazing angles, 6e-8 of the largest
    assert np.maximum(few.exchange, many.exchange)[one_only].max(initial=0.0) < 1e-7
