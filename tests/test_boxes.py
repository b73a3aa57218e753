"""Boxes that come near: the pairs that comparing all with all finds, each once."""

import numpy as np
import pytest

from radiosity.mesh import boxes
from radiosity.mesh.boxes import near_boxes


def all_pairs(low, high, touch):
    apart = (low[None] > high[:, None] + touch) | (low[:, None] > high[None] + touch)
    return {(int(a), int(b)) for a, b in np.argwhere(~apart.any(axis=2))}


@pytest.mark.parametrize("chunk", [5, boxes.CHUNK])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 64, 150])
def test_pairs_are_those_of_comparing_all(count, chunk, monkeypatch):
    monkeypatch.setattr(boxes, "CHUNK", chunk)
    rng = np.random.default_rng(count)
    low = rng.integers(0, 12, (count, 3)) / 4
    high = low + rng.integers(0, 3, (count, 3)) / 8
    for touch in (0.0, 0.25):
        found = [pair for a, b in near_boxes(low, high, touch) for pair in zip(a, b, strict=True)]
        assert len(found) == len(set(found))
        assert {(int(a), int(b)) for a, b in found} == all_pairs(low, high, touch)
    assert count < 64 or count < len(found) < count**2
