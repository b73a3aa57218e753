"""Clusters of small patches, and the factors between them that rays count."""

import numpy as np
import pytest
from scenes_for_tests import box, faces_of, meshed, rotation, uv_sphere

from radiosity.analytic import box_form_factors
from radiosity.mesh.clusters import make_clusters
from radiosity.transport.closure import repaired
from radiosity.transport.counting import count_rays, counted_factors

CUBE = box((0, 0, 0), (1, 1, 1))


def test_clusters_hold_what_lies_together_and_looks_the_same_way():
    _, _, patches = meshed(faces_of(uv_sphere(32)), 1)
    rows, kind = np.arange(len(patches)), (patches.centroid[:, 0] > 0).astype(int)
    labels = make_clusters(patches, rows, kind, 150)
    count = labels.max() + 1
    assert 75 <= count <= 150 and np.array_equal(np.unique(labels), np.arange(count))
    for c in range(count):
        mine = labels == c
        assert len(set(kind[mine])) == 1
        assert (patches.normal[mine] @ patches.normal[mine].T).min() > np.cos(np.radians(75))
        assert np.ptp(patches.centroid[mine], axis=0).max() < 0.8


def test_many_kinds_take_no_more_clusters_than_wanted():
    """Once each material in each direction was a cluster, and the walls were one each."""
    _, _, patches = meshed(faces_of(np.concatenate([uv_sphere(24), 3 * CUBE - 1.5])), 1)
    rows = np.arange(len(patches))
    for wanted in (600, 150, 40):
        for kinds in (1, 10, 300):
            labels = make_clusters(patches, rows, rows % kinds, wanted)
            assert wanted / 2.5 <= labels.max() + 1 <= wanted
            parts = [patches.centroid[labels == c] for c in range(labels.max() + 1)]
            across = max(np.ptp(p, axis=0).max() for p in parts)
            assert across < (1.2 if wanted > 100 else 2.2)


def test_few_patches_are_clusters_of_their_own():
    _, _, patches = meshed(faces_of(CUBE), 2)
    labels = make_clusters(patches, np.arange(24), np.zeros(24, int), 24)
    assert np.array_equal(labels, np.arange(24))


def test_both_sides_of_a_sheet_are_apart():
    sheet = np.array([[[0, 0, 0.5], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0.5]]])
    _, _, patches = meshed(faces_of(np.concatenate([CUBE, sheet])), 8)
    patches = patches.with_backs(patches.face == 6)
    labels = make_clusters(patches, np.arange(len(patches)), np.zeros(len(patches), int), 50)
    fronts = set(labels[(patches.face == 6) & patches.front])
    assert not fronts & set(labels[~patches.front])


def counted(polygons, rays, labels=None, n=6, seed=0):
    visibility, table, patches = meshed(faces_of(polygons), n)
    labels = patches.face if labels is None else labels
    return count_exchange(patches, np.arange(len(patches)), labels, visibility, table, rays, seed)


def count_exchange(patches, rows, labels, visibility, table, rays, seed=0):
    met = count_rays(patches, rows, labels, visibility, table, range(rays), seed)
    return counted_factors(met, np.bincount(labels, patches.area[rows]), rays)


def test_counts_of_parts_of_a_sequence_add_up():
    visibility, table, patches = meshed(faces_of(CUBE), 2)
    args = patches, np.arange(24), patches.face, visibility, table
    whole = count_rays(*args, range(512))
    parts = count_rays(*args, range(200)) + count_rays(*args, range(200, 512))
    assert np.array_equal(whole, parts) and np.all(whole.sum(axis=1) == 512)


def test_faces_of_a_cube_have_their_closed_form():
    exact = box_form_factors((1, 1, 1))
    factors = counted(CUBE, 1 << 14)
    assert factors.toarray() == pytest.approx(exact, abs=3.3e-3)  # 1.5 sqrt(0.2 0.8/32768)
    assert factors.reciprocity == 0.0 and factors.is_closed
    assert np.abs(repaired(factors).closure).max() < 1e-12


def test_more_rays_bring_less_error_as_estimated():
    """The stated error is that of random rays: even ones beat it, the more the more they are."""
    exact = box_form_factors((1, 1, 1))
    off, said = [], []
    for rays in (256, 4096, 65536):
        factors = [counted(CUBE, rays, seed=s) for s in range(4)]
        off.append(np.sqrt(np.mean([(f.toarray() - exact) ** 2 for f in factors])))
        said.append(float(np.sqrt(np.mean((factors[0].error / factors[0].area[:, None]) ** 2))))
    rate = np.log(off[0] / off[-1]) / np.log(256)
    assert 0.5 < rate < 1.0
    assert np.all(np.array(off) < said)


def test_clusters_of_any_shape_see_what_their_patches_see():
    """Random groups of a cube's patches against the pooled exact factors of its faces' patches."""
    from radiosity import form_factors

    visibility, table, patches = meshed(faces_of(CUBE), 3)
    labels = np.random.default_rng(0).integers(0, 7, len(patches))
    corners = patches.vertices.reshape(-1, 3)
    exact = form_factors((corners, np.arange(len(corners)).reshape(-1, 4)), 1e-6).grouped(labels)
    found = count_exchange(patches, np.arange(len(patches)), labels, visibility, table, 1 << 15)
    assert found.toarray() == pytest.approx(exact.toarray(), abs=3e-3)
    assert found.area == pytest.approx(exact.area, rel=1e-12)


def test_an_open_box_sends_out_what_its_lid_would_get():
    factors = counted(CUBE[[0, 2, 3, 4, 5]], 1 << 14)
    exact = box_form_factors((1, 1, 1))[[0, 2, 3, 4, 5], 1]
    assert factors.environment == pytest.approx(exact, abs=2e-3)
    assert not factors.is_closed


def test_turning_changes_only_noise_and_threads_change_nothing(monkeypatch):
    turn = rotation(np.random.default_rng(1))
    one, other = counted(CUBE, 4096), counted(CUBE @ turn.T, 4096)
    assert other.toarray() == pytest.approx(one.toarray(), abs=0.01)
    monkeypatch.setenv("RADIOSITY_THREADS", "1")
    assert np.array_equal(counted(CUBE, 4096).exchange, one.exchange)
