"""Form factors on disk: what comes back, and what is refused with which words."""

import tracemalloc

import numpy as np
import pytest
from test_closure import perturbed, symmetric

from radiosity.solve.plan import FACTORS
from radiosity.transport.closure import repaired
from radiosity.transport.operator import FormFactors, Openness
from radiosity.transport.store import BLOCK, count_rows, load_factors, save_factors

CUBE = """View3D 3.3.1 0 {encl} {emit} 6
1 1 1 1 1 1
0.000000 0.200044 0.200044 0.199825 0.200044 0.200044
0.200044 0.000000 0.200044 0.200044 0.199825 0.200044
0.200044 0.200044 0.000000 0.200044 0.200044 0.199825
0.199825 0.200044 0.200044 0.000000 0.200044 0.200044
0.200044 0.199825 0.200044 0.200044 0.000000 0.200044
0.200044 0.200044 0.199825 0.200044 0.200044 0.000000
0.500 0.500 0.500 0.500 0.500 0.500
"""


def same(a, b):
    """Whether two form factors are equal to the bit in all that they hold."""
    return (
        np.array_equal(a.exchange, b.exchange)
        and np.array_equal(a.area, b.area)
        and np.array_equal(a.error, b.error)
        and a.error.dtype == b.error.dtype == np.float32
        and np.array_equal(a.environment, b.environment)
        and np.array_equal(a.openness.error, b.openness.error)
        and np.array_equal(a.raw_closure, b.raw_closure)
        and np.array_equal(a.centroid, b.centroid)
    )


@pytest.mark.parametrize("scale", [1.0, 1e-18, 1e18])
@pytest.mark.parametrize("seed", range(4))
def test_npz_gives_back_every_bit(tmp_path, seed, scale):
    factors = repaired(perturbed(40, 1e-2, seed, zeros=0.3, open_share=0.4)[0])
    factors = factors.replaced(
        exchange=scale * factors.exchange, area=scale * factors.area,
        centroid=scale * np.random.default_rng(seed).normal(size=(40, 3)) if seed else None,
    )  # fmt: skip
    save_factors(factors, tmp_path / "f.npz")
    assert same(load_factors(tmp_path / "f.npz"), factors)


@pytest.mark.parametrize("suffix", [".npz", ".out"])
def test_many_rows_take_no_more_memory_than_their_factors_did(tmp_path, suffix):
    n, path = 2 * BLOCK + 77, tmp_path / f"f{suffix}"
    factors, peaks = repaired(perturbed(n, 1e-3, 0, open_share=0.4)[0]), []
    tracemalloc.start()
    try:
        for work in (lambda: save_factors(factors, path), lambda: load_factors(path)):
            tracemalloc.reset_peak()
            before = tracemalloc.get_traced_memory()[0]
            found = work()
            peaks.append(tracemalloc.get_traced_memory()[1] - before)
    finally:
        tracemalloc.stop()
    assert max(peaks) < 1.05 * FACTORS * n**2
    assert count_rows(path) == n
    if suffix == ".npz":
        assert same(found, factors)
    else:
        assert found.toarray() == pytest.approx(factors.toarray(), rel=1e-14)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"View3D", b"\x00\xff" * 50])
def test_what_is_no_file_of_factors_has_no_rows(tmp_path, content):
    for suffix in (".npz", ".out", ".csv"):
        path = tmp_path / f"f{suffix}"
        path.write_bytes(content)
        assert count_rows(path) == 0
    assert count_rows(tmp_path / "none.npz") == 0


def test_npz_keeps_entries_at_the_edge_of_a_binade(tmp_path):
    """At a power of two the unit in the last place halves below it."""
    edges = [np.nextafter(2.0**k, side) for k in (-30, 0, 7) for side in (0.0, 1e3)]
    for seed in range(20):
        upper = np.random.default_rng(seed).choice(edges, (12, 12))
        area = np.random.default_rng(seed).uniform(1, 1e4, 12)
        factors = FormFactors(symmetric(np.triu(upper, 1)), area)
        save_factors(factors, tmp_path / "f.npz")
        assert same(load_factors(tmp_path / "f.npz"), factors)


def test_npz_keeps_sealed_rows_without_area(tmp_path):
    exchange = np.array([[0, 1.0, 0], [1.0, 0, 0], [0, 0, 0]])
    factors = FormFactors(exchange, np.array([1.0, 1.0, 0.0]))
    save_factors(factors, tmp_path / "f.npz")
    assert same(load_factors(tmp_path / "f.npz"), factors)


def test_npz_is_readable_with_numpy_alone(tmp_path):
    factors = perturbed(9, 1e-3, open_share=0.2)[0]
    save_factors(factors, tmp_path / "f.npz")
    with np.load(tmp_path / "f.npz", allow_pickle=False) as file:
        assert np.array_equal(file["F"], factors.toarray())
        assert np.array_equal(file["closure"], factors.closure)
        assert file["error"].dtype == np.float32 and file["error"].shape == (9, 9)
        assert file["reciprocity"] == 0.0 and file["version"] == 1
        assert set(file.files) == {
            "F", "absorbed", "area", "environment", "environment_error", "error", "closure_raw",
            "closure",
            "reciprocity", "rounding", "version",
        }  # fmt: skip


def test_npz_without_rounding_is_right_to_rounding(tmp_path):
    factors = perturbed(20, 1e-3)[0]
    rewrite(factors, tmp_path / "f.npz", rounding=None)
    loaded = load_factors(tmp_path / "f.npz")
    assert np.array_equal(loaded.exchange, loaded.exchange.T)
    assert loaded.exchange == pytest.approx(factors.exchange, rel=3e-16)  # quotient and product


def rewrite(factors, place, **changes):
    """Save with some keys replaced, those given as None left out."""
    save_factors(factors, place)
    with np.load(place) as file:
        keys = {key: file[key] for key in file.files} | changes
    np.savez(place, **{key: value for key, value in keys.items() if value is not None})


def changed(key, at, value):
    array = getattr(perturbed(6, 1e-3)[0], {"F": "exchange"}.get(key, key)).copy()
    array[at] = value
    return {key: array}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"F": None}, "key 'F' is missing; the file has absorbed, area, closure, closure_raw"),
        ({"error": None}, "key 'error' is missing"),
        ({"version": None}, "key 'version' is missing"),
        ({"version": 2}, "version = 2 must be 1"),
        ({"version": np.array("one")}, "version = one must be 1"),
        ({"area": np.ones(5)}, r"F has shape \(6, 6\) and must have \(5, 5\), n = 5"),
        ({"area": np.ones((6, 1))}, r"area has shape \(6, 1\) and must have \(6,\)"),
        ({"environment": np.zeros(7)}, r"environment has shape \(7,\) and must have \(6,\)"),
        ({"error": np.zeros((6, 5), np.float32)}, r"error has shape \(6, 5\)"),
        ({"area": np.ones(6, int)}, "area has the type int64 and must hold floating-point"),
        ({"rounding": np.zeros((6, 6))}, r"rounding is float64 \(6, 6\) and must be int8"),
        (changed("F", (1, 2), np.nan), r"F\[1, 2\] = nan must be finite and at least 0"),
        (changed("error", (0, 3), np.inf), r"error\[0, 3\] = inf must be finite"),
        (changed("F", (4, 2), -0.1), r"F\[4, 2\] = -0.1 must be finite and at least 0"),
        (changed("area", 5, -1.0), r"area\[5\] = -1.0 must be finite and at least 0"),
        ({"closure_raw": np.full(6, np.nan)}, r"closure_raw\[0\] = nan must be finite"),
        ({"area": np.arange(1.0, 7.0)}, "F is not reciprocal: A_i F_ij = .* 1e-09 of the largest"),
        ({"centroid": np.ones((6, 2))}, r"centroid has shape \(6, 2\) and must have \(6, 3\)"),
        ({"centroid": np.full((6, 3), np.inf)}, r"centroid\[0, 0\] = inf must be finite;"),
        ({"F": np.array([[None] * 6] * 6)}, "is broken or no .npz file of plain arrays"),
    ],
)
@pytest.mark.filterwarnings("ignore::FutureWarning")
def test_a_wrong_npz_is_refused_with_file_key_value_and_way_out(tmp_path, changes, message):
    place = tmp_path / "wrong.npz"
    rewrite(perturbed(6, 1e-3)[0], place, **changes)
    with pytest.raises(ValueError, match=message) as caught:
        load_factors(place)
    assert str(place) in str(caught.value)
    assert "made by radiosity formfactors MESH -o FILE" in str(caught.value)


def test_reciprocity_is_judged_at_one_in_a_thousand_million(tmp_path):
    factors = perturbed(6, 1e-3)[0]
    matrix, largest = factors.toarray(), factors.exchange.max()
    for share, good in ((0.9e-9, True), (1.1e-9, False)):
        other = matrix.copy()
        other[2, 4] += share * largest / factors.area[2]
        rewrite(factors, tmp_path / "f.npz", F=other)
        if good:
            load_factors(tmp_path / "f.npz")
        else:
            with pytest.raises(ValueError, match="i, j = 2, 4|i, j = 4, 2"):
                load_factors(tmp_path / "f.npz")


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut off", b"0.1 0.2", b"\x93NUMPY"])
def test_what_is_no_npz_is_refused(tmp_path, content):
    (tmp_path / "f.npz").write_bytes(content)
    with pytest.raises(ValueError, match="f.npz: is broken or no .npz file of plain arrays"):
        load_factors(tmp_path / "f.npz")


def test_an_npz_that_points_before_its_start_is_refused(tmp_path):
    save_factors(perturbed(6, 1e-3)[0], tmp_path / "f.npz")
    data = bytearray((tmp_path / "f.npz").read_bytes())
    end = data.rindex(b"PK\x05\x06")
    data[end + 16 : end + 20] = (len(data) + 999).to_bytes(4, "little")  # where its list starts
    (tmp_path / "f.npz").write_bytes(data)
    with pytest.raises(ValueError, match="f.npz: is broken or no .npz file of plain arrays"):
        load_factors(tmp_path / "f.npz")


def test_a_single_array_is_no_npz(tmp_path):
    with (tmp_path / "f.npz").open("wb") as file:
        np.save(file, np.zeros(3))
    with pytest.raises(ValueError, match="is broken or no .npz file of plain arrays"):
        load_factors(tmp_path / "f.npz")


def test_csv_names_every_float(tmp_path):
    factors = perturbed(15, 1e-3, zeros=0.3)[0]
    save_factors(factors, tmp_path / "f.csv")
    written = np.loadtxt(tmp_path / "f.csv", delimiter=",")
    assert np.array_equal(written, factors.toarray())
    with pytest.raises(ValueError, match="f.csv: CSV holds F without areas"):
        load_factors(tmp_path / "f.csv")


@pytest.mark.parametrize("open_share", [0.0, 0.5])
def test_view3d_text_comes_back_to_rounding(tmp_path, open_share):
    factors = repaired(perturbed(15, 1e-3, zeros=0.3, open_share=open_share)[0])
    save_factors(factors, tmp_path / "f.out")
    loaded = load_factors(tmp_path / "f.out")
    assert np.array_equal(loaded.area, factors.area)
    assert loaded.exchange == pytest.approx(factors.exchange, rel=4e-16)  # quotient, product, mean
    assert np.array_equal(loaded.exchange, loaded.exchange.T)
    assert loaded.environment == pytest.approx(factors.environment, abs=1e-14)
    assert loaded.is_closed == factors.is_closed


def test_view3d_text_has_its_layout(tmp_path):
    factors = FormFactors(np.array([[0, 1.0], [1.0, 0]]), np.array([1.0, 2.0]))
    save_factors(factors, tmp_path / "f.txt", "view3d")
    lines = (tmp_path / "f.txt").read_text().splitlines()
    assert lines == ["View3D 1.0 0 1 0 2", "1 2", "0 1", "0.5 0", "1 1"]
    opened = FormFactors(factors.exchange, factors.area, None, Openness(np.full(2, 0.5), 0))
    save_factors(opened, tmp_path / "f.vf")
    assert (tmp_path / "f.vf").read_text().split()[3] == "0"


def test_the_cube_of_view3ds_manual_is_read_and_closes(tmp_path):
    place = tmp_path / "cube.out"
    place.write_text(CUBE.format(encl=1, emit=0))
    factors = load_factors(place)
    assert factors.is_closed and factors.exchange[0, 3] == 0.199825
    assert np.abs(factors.closure).max() == pytest.approx(1e-6, rel=1e-6)  # 4 x .200044 + .199825
    assert repaired(factors).exchange[0, 3] == pytest.approx(0.199824896, abs=1e-6)  # its text
    place.write_text(CUBE.format(encl=0, emit=0))
    assert load_factors(place).environment == pytest.approx(np.zeros(6), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the first line is ''"),
        ("0.1 0.2\n", "the first line is '0.1 0.2', not 'View3D version out encl emit n'"),
        (CUBE.format(encl=1, emit=1), "emit = 1: it holds script-F"),
        (CUBE.format(encl=1, emit=0)[:-6], "47 numbers follow the header and there must be 48"),
        (CUBE.format(encl=1, emit=0).replace("View3D 3.3.1 0", "View3D 3.3.1 1"), "out = 1"),
        (CUBE.format(encl=1, emit=0).replace("0.199825 0", "0.1x9825 0"), "is no number"),
        (CUBE.format(encl=1, emit=0).replace("1 1 1 1 1 1", "1 1 1 1 1 2"), "not reciprocal"),
        (CUBE.format(encl=1, emit=0).replace("1 1 1 1 1 1", "1 1 -1 1 1 1"), r"area\[2\] = -1.0"),
        (CUBE.format(encl=1, emit=0).replace("0.000000", "nan", 1), r"F\[0, 0\] = nan"),
    ],
)
def test_a_wrong_view3d_text_is_refused(tmp_path, text, message):
    place = tmp_path / "wrong.out"
    place.write_text(text)
    with pytest.raises(ValueError, match=message) as caught:
        load_factors(place)
    assert str(place) in str(caught.value)


def test_an_unknown_format_is_refused(tmp_path):
    factors = perturbed(4, 1e-3)[0]
    with pytest.raises(ValueError, match=r"format '.xls' must be one of npz, csv and view3d"):
        save_factors(factors, tmp_path / "f.xls")
    with pytest.raises(ValueError, match="format 'pickle' must be one of"):
        load_factors(tmp_path / "f.npz", "pickle")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    place = tmp_path / "f.npz"
    place.write_bytes(b"old")

    def full(file, **arrays):
        file.write(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="disk full"):
        save_factors(perturbed(4, 1e-3)[0], place)
    assert place.read_bytes() == b"old" and list(tmp_path.iterdir()) == [place]


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="does not exist; create it first"):
        save_factors(perturbed(4, 1e-3)[0], tmp_path / "none" / "f.npz")
