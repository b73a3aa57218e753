"""Form factors on disk: ``.npz`` holds everything, ``.csv`` and View3D's text the matrix F."""

import errno
import os
import zlib
from collections.abc import Callable
from pathlib import Path
from zipfile import BadZipFile, ZipFile

import numpy as np

from radiosity.transport.files import written_whole
from radiosity.transport.operator import FormFactors, Openness

VERSION = 1
MADE_BY = "such files are made by radiosity formfactors MESH -o FILE"
BLOCK = 256  # rows at a time
# What reading a file that is no .npz, a broken, a packed or a locked one ends in.
BROKEN = (BadZipFile, EOFError, ValueError, AttributeError, TypeError, RuntimeError, zlib.error)
# Largest |A_i F_ij - A_j F_ji| over the largest A_i F_ij: above the rounding of F, below any error
# that matters. View3D writes F with 6 decimals, so its two directions differ by up to 1e-6.
RECIPROCITY, TEXT_RECIPROCITY = 1e-9, 1e-5
FORMATS = {".npz": "npz", ".csv": "csv", ".out": "view3d", ".vf": "view3d", ".txt": "view3d"}
SHAPES = {
    "F": 2, "error": 2, "area": 1, "environment": 1, "environment_error": 1, "absorbed": 1,
    "closure_raw": 1,
}  # fmt: skip


def save_factors(factors: FormFactors, path: str | os.PathLike, format: str | None = None) -> None:
    """Write form factors to a file that is whole or absent.

    - ``npz``: numpy arrays ``F`` (n, n), ``area`` (n,) in m2, ``environment``,
      ``environment_error`` and ``absorbed`` (n,), ``error`` (n, n) float32 of A_i F_ij in m2,
      ``closure_raw`` and ``closure`` (n,), ``reciprocity``, ``version``, ``centroid`` (n, 3) in
      scene units where it is known, and ``rounding`` (n, n)
      int8: A_i F_ij minus its product in float64, in half units in the last place. Exchange areas,
      areas, environment and errors come back to the bit.
    - ``csv``: n rows of F with 17 digits, which name each float64. Written only: without areas
      it cannot be read back.
    - ``view3d``: the text that View3D puts out: a header ``View3D version out encl emit n``, the
      areas, n rows of F, the emittances (1, since F holds none), with 17 digits. What meets
      surfaces that are no rows is not told from what leaves: read back, both are environment.

    Parameters
    ----------
    factors : FormFactors
    path : str or path
    format : str, optional
        ``npz``, ``csv`` or ``view3d``; by the suffix (.npz; .csv; .out, .vf, .txt) if not given.

    Raises
    ------
    ValueError
        Where neither names a format.
    OSError
        Where the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "two.npz"
    >>> save_factors(FormFactors(np.array([[0, 1.0], [1.0, 0]]), np.array([1.0, 2.0])), place)
    >>> np.load(place)["F"].tolist()
    [[0.0, 1.0], [0.5, 0.0]]
    """
    writers = {"npz": _write_npz, "csv": _write_csv, "view3d": _write_view3d}
    write = writers[find_format(path, format)]
    with written_whole(path) as temporary:
        write(factors, temporary)


def load_factors(path: str | os.PathLike, format: str | None = None) -> FormFactors:
    """Read what `save_factors` wrote as ``npz`` or ``view3d``, or what View3D wrote.

    From View3D's text the mean of A_i F_ij and A_j F_ji is taken and half their difference is its
    error; what the rows lack goes to the environment unless the header says ``encl = 1``.

    Parameters
    ----------
    path : str or path
    format : str, optional
        As in `save_factors`.

    Returns
    -------
    FormFactors

    Raises
    ------
    ValueError
        Where the file is no such file, or something in it is missing, of a wrong shape, not
        finite, negative or not reciprocal: names file, key, value, bound and a way out.
    OSError
        Where it cannot be read.

    Examples
    --------
    >>> save_factors(FormFactors(np.array([[0, 1.0], [1.0, 0]]), np.ones(2)), "two.npz")
    >>> load_factors("two.npz").toarray().tolist()
    [[0.0, 1.0], [1.0, 0.0]]
    """
    kind = find_format(path, format)
    if kind == "csv":
        raise ValueError(
            f"{path}: CSV holds F without areas and cannot be loaded; save factors as .npz instead"
        )
    return _read_npz(path) if kind == "npz" else _read_view3d(path)


def count_rows(path: str | os.PathLike, format: str | None = None) -> int:
    """Return how many rows the factors in a file have, without reading them; 0 if it is none."""
    try:
        if find_format(path, format) == "npz":
            with ZipFile(path) as file, file.open("F.npy") as header:
                np.lib.format.read_magic(header)
                return np.lib.format.read_array_header_1_0(header)[0][0]
        with open(path, encoding="ascii", errors="replace") as file:
            words = file.readline().split()
            return int(words[5]) if words[:1] == ["View3D"] else 0
    except (*BROKEN, LookupError, OSError):
        return 0


def find_format(path: str | os.PathLike, asked: str | None = None) -> str:
    """Return the format that is asked for, or that the suffix names; ValueError if neither does."""
    kind = asked or FORMATS.get(Path(path).suffix.lower())
    if kind not in FORMATS.values():
        if Path(path).is_dir():
            raise IsADirectoryError(
                errno.EISDIR, "is a folder; add the name of a file, such as F.npz", str(path)
            )
        raise ValueError(
            f"{path}: format {asked or Path(path).suffix!r} must be one of npz, csv and view3d; "
            f"give a format or one of the suffixes {', '.join(FORMATS)}"
        )
    return kind


def _write_npz(factors, place):
    matrix = factors.toarray()
    with place.open("wb") as file:
        np.savez(
            file,
            F=matrix,
            area=factors.area,
            environment=factors.environment,
            environment_error=factors.openness.error,
            absorbed=np.broadcast_to(factors.openness.absorbed, factors.area.shape),
            error=factors.error,
            closure_raw=factors.raw_closure,
            closure=factors.closure,
            reciprocity=factors.reciprocity,
            rounding=_rounding(factors, matrix),
            version=VERSION,
            **({} if factors.centroid is None else {"centroid": factors.centroid}),
        )


def _rounding(factors, matrix):
    """Return (n, n) int8: A_i F_ij less its float64 product, in half units in the last place.

    Both roundings, of the quotient and of the product, are within half a unit, so the difference
    is exact and small.
    """
    found, area = np.empty(matrix.shape, np.int8), _divisor(factors.area)
    for rows in _blocks(len(area)):
        product = area[rows, None] * matrix[rows]
        unit = np.spacing(product) / 2
        found[rows] = (factors.exchange[rows] - product) / np.where(unit > 0, unit, 1.0)
    return found


def _divisor(area):
    """Return what A_i F_ij is divided by for F_ij: areas, 1 for rows without."""
    return np.where(area > 0, area, 1.0)


def _blocks(n):
    """Return slices of rows, so that what is computed on the way takes little memory."""
    return [slice(a, a + BLOCK) for a in range(0, n, BLOCK)]


def _write_csv(factors, place):
    np.savetxt(place, factors.toarray(), fmt="%.17g", delimiter=",")


def _write_view3d(factors, place):
    n = len(factors.area)
    rows = [factors.area, *factors.toarray(), np.ones(n)]
    with place.open("w", encoding="ascii") as file:
        file.write(f"View3D {VERSION}.0 0 {int(not factors.openness.share.any())} 0 {n}\n")
        file.writelines(" ".join(format(x, ".17g") for x in row) + "\n" for row in rows)


def _read_npz(path):
    try:
        with np.load(path, allow_pickle=False) as file:
            found = {key: file[key] for key in file.files}
    except (*BROKEN, OSError) as error:
        if getattr(error, "filename", None):  # it cannot be opened
            raise
        raise ValueError(f"{path}: is broken or no .npz file of plain arrays; {MADE_BY}") from None
    reject = _rejecter(path)
    for key in ("version", *SHAPES):
        if key not in found:
            reject(f"key {key!r} is missing; the file has {', '.join(sorted(found)) or 'none'}")
    if found["version"].shape != () or found["version"] != VERSION:
        reject(f"version = {found['version']} must be {VERSION}, the one this release reads")
    area = found["area"]
    for key, axes in SHAPES.items():
        _check_numbers(reject, key, found[key], (area.size,) * axes, key != "closure_raw")
    exchange = _exact(reject, found, area)
    share = found["environment"] + found["absorbed"]
    openness = Openness(share, found["environment_error"], found["absorbed"])
    error = np.asarray(found["error"], np.float32)
    _mirror(error)
    centroid = found.get("centroid")
    if centroid is not None:
        _check_numbers(reject, "centroid", centroid, (area.size, 3), positive=False)
    return FormFactors(exchange, area, error, openness, found["closure_raw"], centroid)


def _rejecter(path) -> Callable[[str], None]:
    def reject(complaint):
        raise ValueError(f"{path}: {complaint}; {MADE_BY}")

    return reject


def _exact(reject, found, area):
    """Turn F into exchange areas, symmetric as the upper triangle, with their rounding undone."""
    product = np.asarray(found["F"], np.float64)
    product *= _divisor(area)[:, None]
    _check_reciprocity(reject, product, RECIPROCITY)
    if "rounding" in found:
        rounding = found["rounding"]
        if rounding.shape != product.shape or rounding.dtype != np.int8:
            reject(
                f"rounding is {rounding.dtype} {rounding.shape} and must be int8 {product.shape}"
            )
        for rows in _blocks(len(area)):
            product[rows] += rounding[rows] * (np.spacing(product[rows]) / 2)
    np.maximum(product, 0.0, out=product)
    _mirror(product)
    return product


def _mirror(matrix):
    """Write the upper triangle of a matrix over its lower one."""
    for rows in _blocks(len(matrix)):
        matrix[rows, : rows.start] = matrix[: rows.start, rows].T
        square = matrix[rows, rows]
        square[:] = np.triu(square) + np.triu(square, 1).T


def _check_numbers(reject, key, array, shape, positive=True):
    if array.shape != shape:
        reject(f"{key} has shape {array.shape} and must have {shape}, n = {shape[0]} areas")
    if array.dtype.kind != "f":
        reject(f"{key} has the type {array.dtype} and must hold floating-point numbers")
    bad = ~np.isfinite(array)
    if positive:
        bad |= array < 0
    if bad.any():
        at = tuple(int(k) for k in np.argwhere(bad)[0])
        bound = "finite and at least 0" if positive else "finite"
        reject(f"{key}[{', '.join(map(str, at))}] = {array[at]} must be {bound}")


def _check_reciprocity(reject, product, bound):
    """Reject products A_i F_ij that are not symmetric within a share of the largest."""
    largest, worst, i, j = product.max(initial=0.0), 0.0, 0, 0
    for rows in _blocks(len(product)):
        difference = np.abs(product[rows] - product[:, rows].T)
        if difference.max() > worst:
            a, j = np.unravel_index(np.argmax(difference), difference.shape)
            worst, i = difference[a, j], rows.start + a
    if worst > bound * largest:
        reject(
            f"F is not reciprocal: A_i F_ij = {product[i, j]:.10g} and A_j F_ji = "
            f"{product[j, i]:.10g} for i, j = {i}, {j} may differ by {bound:.0e} of the largest, "
            f"{bound * largest:.1e}; F or area was changed, or F is transposed"
        )


def _read_view3d(path):
    def reject(complaint):
        raise ValueError(f"{path}: {complaint}; {MADE_BY}, or by View3D")

    (closed, emit, n), numbers = _view3d_numbers(path, reject)
    if emit:
        reject("emit = 1: it holds script-F, which reflections are part of; rerun with emit=0")
    area, matrix = numbers[:n], numbers[n : n + n * n].reshape(n, n)
    _check_numbers(reject, "area", area, (n,))
    _check_numbers(reject, "F", matrix, (n, n))
    product = matrix * _divisor(area)[:, None]
    _check_reciprocity(reject, product, TEXT_RECIPROCITY)
    openness = Openness.closed(n)
    if not closed:
        outside = np.maximum(0.0, 1.0 - matrix.sum(axis=1))
        sees = (area > 0) & matrix.any(axis=1)
        openness = Openness(np.where(sees, outside, 0.0), openness.error)
    error = (np.abs(product - product.T) / 2).astype(np.float32)
    return FormFactors((product + product.T) / 2, area, error, openness)


def _view3d_numbers(path, reject):
    """Return (encl, emit, n) of the header and the n (n + 2) numbers after it as one array."""
    with open(path, encoding="ascii", errors="replace") as file:
        words = file.readline().split()
        if len(words) != 6 or words[0] != "View3D" or not all(w.isdigit() for w in words[2:]):
            reject(
                f"the first line is {' '.join(words)[:60]!r}, not 'View3D version out encl emit n'"
            )
        if words[2] != "0":
            reject(f"out = {words[2]} is View3D's binary format; rerun it with out=0")
        closed, emit, n = (int(w) for w in words[3:])
        parts, count = [], 0
        for line in file:
            try:
                parts.append(np.array(line.split(), np.float64))
            except ValueError as error:
                reject(f"something after the header is no number ({error})")
            count += len(parts[-1])
    if count != n * (n + 2):
        reject(
            f"{count} numbers follow the header and there must be {n * (n + 2)}: n = {n} "
            "areas, n x n factors, n emittances"
        )
    return (closed, emit, n), np.concatenate(parts) if parts else np.empty(0)
