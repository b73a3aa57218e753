"""Divisions: nested grids fill their faces, and points are found in their cells again."""

import numpy as np
import pytest
from scenes_for_tests import SKEW, SQUARE, TRIANGLE, faces_of

from radiosity.mesh.contact import find_contacts
from radiosity.mesh.division import Division
from radiosity.mesh.patches import centroids, make_patches
from radiosity.transport.lookup import cell_at, make_table

FACES = faces_of(np.stack([SKEW, TRIANGLE, SQUARE]))
SHAPE = np.array([[3, 2], [4, 0], [1, 5]])


def nested(depth, seed=0):
    rng, division = np.random.default_rng(seed), Division(SHAPE)
    for _ in range(depth):
        division = division.divided(rng.choice([1, 1, 2, 3], division.count))
    return division


@pytest.mark.parametrize("depth", [0, 1, 2, 3])
def test_cells_fill_their_faces(depth):
    division = nested(depth)
    cells = division.cells(FACES)
    assert len(cells) == len(division.face) == division.count == division.ends[-1]
    across = np.cross(cells[:, 2] - cells[:, 0], cells[:, 3] - cells[:, 1])
    areas = np.bincount(division.face, np.linalg.norm(across, axis=1) / 2)
    assert areas == pytest.approx(FACES.areas(), rel=1e-12)  # rounding
    assert np.all(np.sum(across * FACES.normals()[division.face], axis=1) > 0)


@pytest.mark.parametrize("finer", [1, 2, 4])
@pytest.mark.parametrize("depth", [0, 1, 2, 3])
def test_cells_are_found_by_their_middles(depth, finer):
    division = nested(depth)
    patches = make_patches(FACES, division, find_contacts(FACES, np.zeros(3, bool)))
    table, parts = make_table(FACES, patches), division.divided(finer)
    middle = parts.cells(FACES)[:, :3].mean(axis=1)
    found = [cell_at(table, f, x, finer) for f, x in zip(parts.face, middle, strict=True)]
    assert np.array_equal(found, np.arange(parts.count))


def test_dividing_all_cells_of_a_grid_makes_the_finer_grid():
    """Whatever their numbers, the cells are the same ones."""
    twice, finer = Division(SHAPE).divided(2).cells(FACES), Division(2 * SHAPE).cells(FACES)
    keys = [np.sort(np.round(centroids(c) @ [1.0, 7.3, 53.1], 9)) for c in (twice, finer)]
    assert np.array_equal(*keys)


def test_only_plain_grids_of_even_numbers_are_halved():
    assert np.array_equal(Division(2 * SHAPE).halved().shape, SHAPE)
    assert Division(SHAPE).halved() is None
    assert Division(2 * SHAPE).divided(2).halved() is None
