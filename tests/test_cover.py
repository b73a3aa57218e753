"""Surfaces of several blockers that hide one polygon from another: proven, or not claimed."""

import numpy as np
import pytest
from scenes_for_tests import SQUARE, box, normal_of, rotation, uv_sphere
from test_shadow import passes_through

from radiosity.transport.blockers import make_blockers
from radiosity.transport.cover import is_covered

GRAIN = 1e-15  # of coordinates about 1
SLACK = 4 * GRAIN
LOW = SQUARE - [0.5, 0.5, 0.0]
HIGH = LOW + [0.0, 0.0, 2.0]
QUADS = uv_sphere(4) * [1.5, 1.5, 0.4] + [0.0, 0.0, 1.0]
EGG = [x[:3] if np.all(x[2] == x[3]) else x for x in QUADS]


def fan(count, radius, height=1.0):
    """Return triangles about the axis z that add up to a regular polygon."""
    angle = 2 * np.pi * np.arange(count + 1) / count
    rim = radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(count + 1)], axis=1)
    rim[-1] = rim[0]
    return [
        np.array([[0, 0, 0], a, b]) + [0, 0, height] for a, b in zip(rim, rim[1:], strict=False)
    ]


def sheets(count, overlap=0.0):
    """Return strips side by side in the plane z = 1, by default with shared edges."""
    x = np.linspace(-1, 1, count + 1)
    return [np.array([[a, -1, 1], [b + overlap, -1, 1], [b + overlap, 1, 1], [a, 1, 1]])
            for a, b in zip(x, x[1:], strict=False)]  # fmt: skip


def covered(polygons, p=LOW, q=HIGH, turn=None, offset=0.0):
    """Whether polygons in the middle of a far larger room, so that all can block, hide q from p."""
    turn = np.eye(3) if turn is None else turn
    room = box((-9, -9, -9), (9, 9, 9))
    p, q, *polygons = (np.asarray(x) @ turn.T + offset for x in (p, q, *polygons, *room))
    corners = np.array([x[np.minimum(np.arange(8), len(x) - 1)] for x in polygons])
    normal, count = np.array([normal_of(x) for x in polygons]), np.array([len(x) for x in polygons])
    made = make_blockers(corners, count, normal, np.zeros(len(count)), GRAIN)
    return is_covered(p, q, made, np.arange(len(made.count)), SLACK + 1e-15 * np.abs(offset).max())


def reversed_some(polygons, every):
    return [x[::-1] if k % every == 0 else x for k, x in enumerate(polygons)]


COVERS = {
    "one sheet": sheets(1),
    "strips": sheets(5),
    "a fan": fan(12, 1.5),
    "an egg": EGG,
    "two sides of a sheet": [x[::k] for x in sheets(5) for k in (1, -1)],
    "one of two": fan(12, 0.3, 0.5) + fan(12, 1.5),
}
OPEN = {
    "nothing near": fan(12, 0.1),
    "a sheet left out": sheets(5)[:2] + sheets(5)[3:],
    "a sector left out": fan(12, 1.5)[1:],
    "too small": fan(12, 0.6),
    "a small egg": [[0.2, 0.2, 1] * x for x in EGG],
    "a hairpin": [
        np.array([[-1, -1, 1], [0, -1, 1], [0, 1, 1], [-1, 1, 1]]),
        np.array([[0, 1, 1], [0, -1, 1], [-1, -1, 1.3], [-1, 1, 1.3]]),
    ],
    "a slit": sheets(5, overlap=-1e-5),
    "two halves far apart": [sheets(2)[0] - [0, 0, 0.5], sheets(2)[1] + [0, 0, 0.5]],
}


@pytest.mark.parametrize("name", COVERS)
def test_surfaces_that_hide_all_are_found(name):
    assert covered(COVERS[name])
    assert covered(COVERS[name], HIGH, LOW)
    assert covered([x[::-1] for x in COVERS[name]])


@pytest.mark.parametrize("name", OPEN)
def test_what_leaves_a_way_open_covers_nothing(name):
    assert not covered(OPEN[name])
    assert not covered(OPEN[name], HIGH, LOW)


@pytest.mark.parametrize("name", [*COVERS, *OPEN])
def test_the_answer_does_not_depend_on_the_frame(name):
    rng = np.random.default_rng(3)
    polygons = {**COVERS, **OPEN}[name]
    for _ in range(5):
        polygons = [polygons[k] for k in rng.permutation(len(polygons))]
        assert covered(polygons, turn=rotation(rng), offset=rng.normal(size=3)) == (name in COVERS)


def test_edges_of_unlike_winding_are_not_trusted():
    assert not covered(reversed_some(sheets(4), 2))


def test_what_is_called_covered_no_segment_passes():
    """Eggs with random holes against segments between random points."""
    rng, found = np.random.default_rng(5), 0
    for _ in range(200):
        cap = [x for x in EGG if rng.random() < 0.8]
        p = LOW * rng.uniform(0.2, 1) + [*rng.uniform(-0.3, 0.3, 2), 0]
        if not covered(cap, p):
            continue
        found += 1
        s = rng.uniform(0, 1, (2000, 4, 1))
        x = p[0] + s[:, 0] * (p[1] - p[0]) + s[:, 1] * (p[3] - p[0])
        y = HIGH[0] + s[:, 2] * (HIGH[1] - HIGH[0]) + s[:, 3] * (HIGH[3] - HIGH[0])
        assert np.all(np.any([passes_through(polygon, x, y) for polygon in cap], axis=0))
    assert 10 < found < 190
