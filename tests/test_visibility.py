"""Rays against faces, compared with a plain intersection of every ray with every triangle."""

import numpy as np
import pytest
from scenes_for_tests import (
    SQUARE,
    block,
    box,
    faces_of,
    l_room,
    meshed,
    rotation,
    tetrahedron,
    uv_sphere,
)

from radiosity.transport.hemisphere import look_out
from radiosity.transport.visibility import Visibility


def every_crossing(faces, origins, spans):
    """Moller-Trumbore in double precision: (rays, faces) parameter t of each hit, inf for none.

    Also (rays,) how near the closest call was: distance to an edge or an end.
    """
    v = faces.vertices
    best = np.full((len(origins), len(faces)), np.inf)
    doubt = np.full(len(origins), np.inf)
    for corners in ([0, 1, 2], [0, 2, 3]):
        a, b, c = (v[:, k] for k in corners)
        e1, e2 = b - a, c - a
        real = np.linalg.norm(np.cross(e1, e2), axis=1) > 0
        p = np.cross(spans[:, None], e2[None])
        det = np.where(real, np.einsum("fc,rfc->rf", e1, p), 1.0)
        s = origins[:, None] - a[None]
        u = np.einsum("rfc,rfc->rf", s, p) / det
        q = np.cross(s, e1[None])
        w = np.einsum("rc,rfc->rf", spans, q) / det
        t = np.einsum("fc,rfc->rf", e2, q) / det
        hit = real & (u >= 0) & (w >= 0) & (u + w <= 1) & (t > 0)
        best = np.where(hit & (t < best), t, best)
        edge = np.abs([u, w, 1 - u - w, t, 1 - t]).min(axis=0)
        doubt = np.minimum(doubt, np.where(real, edge, np.inf).min(axis=1))
    return best, doubt


def random_scene(rng, count=40):
    polygons = [
        ((SQUARE if rng.random() < 0.5 else 1.2 * SQUARE[[0, 1, 2, 2]]) - 0.4) @ rotation(rng).T
        + rng.uniform(-1, 1, 3)
        for _ in range(count)
    ]
    return faces_of(np.array(polygons) * 7 + [3, -2, 100])


def random_rays(rng, faces, count):
    visibility = Visibility(faces)
    origins = rng.uniform(-1.2, 1.2, (count, 3)).astype(np.float32)
    spans = rng.normal(size=(count, 3)).astype(np.float32)
    scale, centre = visibility.scale, visibility.centre
    crossings, doubt = every_crossing(faces, origins / scale + centre, spans / scale)
    return visibility, origins, spans, crossings, doubt > 1e-4  # single precision at the edges


@pytest.mark.parametrize("seed", [0, 1])
def test_blocked_agrees_with_the_plain_twin(seed):
    rng = np.random.default_rng(seed)
    visibility, origins, spans, crossings, sure = random_rays(rng, random_scene(rng), 2000)
    expected = np.any(crossings < 1, axis=1)
    found = visibility.blocked(origins, spans)
    assert sure.mean() > 0.9 and 0.1 < expected.mean() < 0.9
    assert np.array_equal(found[sure], expected[sure])


@pytest.mark.parametrize("seed", [2, 3])
def test_first_hits_agree_with_the_plain_twin(seed):
    rng = np.random.default_rng(seed)
    visibility, origins, spans, crossings, sure = random_rays(rng, random_scene(rng), 2000)
    nearest = crossings.min(axis=1)
    face, distance = visibility.first_hits(origins, spans)
    hit = np.isfinite(nearest)
    assert 0.1 < hit.mean() < 0.9
    assert np.array_equal(face[sure] >= 0, hit[sure])
    known = sure & hit
    assert np.array_equal(face[known], crossings.argmin(axis=1)[known])
    # 1e-5: single precision of rays that meet faces at down to 1 degree
    assert distance[known] == pytest.approx(nearest[known], rel=1e-4, abs=1e-5)


def test_a_ray_ends_at_its_target():
    visibility = Visibility(faces_of(np.array([SQUARE, SQUARE + [0, 0, 1]])))
    origin = np.array([[0, 0, -0.5]], np.float32)
    for reach, blocked in ((0.99, False), (1.01, False), (1.51, True)):
        span = np.array([[0, 0, reach]], np.float32)
        assert visibility.blocked(origin, span)[0] == blocked, reach


def test_the_scene_fits_into_rays_of_order_one():
    for size in (1e-9, 1.0, 1e9):
        faces = faces_of(size * (box((0, 0, 0), (4, 3, 2)) + 5))
        visibility = Visibility(faces)
        local = (faces.vertices - visibility.centre) * visibility.scale
        assert 0.5 < np.abs(local).max() <= 1.0  # a power of 2, so that scaling rounds nothing
        assert np.frexp(visibility.scale)[0] == 0.5
        assert len(visibility.blockers.count) == 0


def test_rays_of_another_type_are_refused():
    visibility = Visibility(faces_of(SQUARE[None]))
    good = np.zeros((4, 3), np.float32)
    for call in (visibility.blocked, visibility.first_hits):
        with pytest.raises(ValueError, match=r"float32 arrays of one shape \(k, 3\), not float64"):
            call(good.astype(float), good)
        with pytest.raises(ValueError, match=r"and float64 \(4, 3\)"):
            call(good, good.astype(float))
        with pytest.raises(ValueError, match=r"\(4, 3\) and float32 \(3, 3\)"):
            call(good, good[:3])


@pytest.mark.parametrize(
    "polygons, unobstructed",
    [
        (box((0, 0, 0), (1, 2, 3)), True),
        (tetrahedron(), True),
        (uv_sphere(6), True),
        (box((0, 0, 0), (1, 1, 1))[:3], True),  # an open corner
        (block((0, 0, 0), (1, 1, 1)), True),  # seen from outside, but convex all the same
        (np.concatenate([box((0, 0, 0), (1, 1, 1)), block((0.3, 0.3, 0), (0.6, 0.6, 0.5))]), False),
        (l_room(), False),
        (np.concatenate([box((0, 0, 0), (1, 1, 1)), 0.3 * SQUARE[None] + 0.2]), False),
    ],
)
def test_scenes_without_obstacles_are_told(polygons, unobstructed):
    rng = np.random.default_rng(0)
    for size in (1e-6, 1.0, 1e6):
        turned = size * (polygons @ rotation(rng).T + rng.normal(size=3))
        blockers = Visibility(faces_of(turned)).blockers
        assert (len(blockers.count) == 0) == unobstructed


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("bottom", [True, False])
def test_nothing_leaks_out_of_a_closed_room(size, bottom):
    """A shell around a room with a block is met by no ray from inside, whatever the scale."""
    rng = np.random.default_rng(4)
    inside = [box((0, 0, 0), (2, 1, 1)), block((0.4, 0.3, 0), (0.8, 0.6, 0.5), bottom)]
    room = np.concatenate(inside)
    shell = box((-0.01, -0.01, -0.01), (2.01, 1.01, 1.01))
    turn = rotation(rng)
    faces = faces_of(size * (np.concatenate([room, shell]) @ turn.T + 1))
    visibility, table, patches = meshed(faces, 6)
    seen = ~patches.covered & (patches.face < len(room))
    # the floor inside a block without bottom is a sealed cavity and looks at nothing else either
    k = np.flatnonzero(seen)
    sides, _ = look_out(
        visibility, table, patches.centroid[k], patches.normal[k], k, range(256), seed=0
    )
    assert len(k) * 256 > 90000
    assert np.all(sides >= 0)
    met = patches.face[sides // 2]
    assert met.max() < len(room), "rays leaked through to the shell"
    if bottom:
        assert np.all(sides % 2 == 0), "rays met a back from inside"
