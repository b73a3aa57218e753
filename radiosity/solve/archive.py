"""Zip archives of a JSON manifest and numpy arrays, of which nothing is trusted when read.

``manifest.json`` names every other member with its type, shape and SHA-256. Sizes are compared with
it, and with the memory there is, before anything is unpacked. Same content, same bytes.
"""

import hashlib
import io
import json
import struct
import zlib
from os import PathLike
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np

from radiosity.scene.files import file_problem
from radiosity.scene.model import SceneError
from radiosity.solve.plan import Refused, check_fits
from radiosity.solve.record import TYPES

MANIFEST = "manifest.json"
FORMAT, VERSION = "radsol", 1
LARGEST = 1 << 36  # bytes of the file
LARGEST_MANIFEST, MOST_MEMBERS, MOST_AXES = 1 << 27, 20_000, 8
PACKED = 1100  # times smaller that deflate can make a member, and a little
EPOCH = (1980, 1, 1, 0, 0, 0)
LEVEL = 1  # of packing: higher ones take longer and save little of floating-point numbers
# What reading a file that is no archive, a broken or a locked one ends in.
BROKEN = (
    BadZipFile, EOFError, ValueError, RuntimeError, NotImplementedError, KeyError, OSError,
    struct.error, zlib.error,
)  # fmt: skip


def write_archive(
    path: str | PathLike, content: object, arrays: dict[str, np.ndarray], program: str
) -> None:
    """Write content, which JSON can hold, and arrays by names."""
    members, packed = {}, []
    for name in sorted(arrays):
        data = _as_npy(arrays[name])
        shape, kind = list(arrays[name].shape), arrays[name].dtype.str
        members[f"{name}.npy"] = {
            "type": kind, "shape": shape, "sha256": hashlib.sha256(data).hexdigest()
        }  # fmt: skip
        packed.append((f"{name}.npy", data))
    manifest = {
        "format": FORMAT, "version": VERSION, "program": program, "members": members,
        "content": content,
    }  # fmt: skip
    text = json.dumps(manifest, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    with ZipFile(path, "w") as file:
        for name, data in [(MANIFEST, text.encode()), *packed]:
            info = ZipInfo(name, EPOCH)
            info.compress_type, info.create_system = ZIP_DEFLATED, 3
            info.external_attr = 0o644 << 16
            file.writestr(info, data, compresslevel=LEVEL)


def _as_npy(array):
    file = io.BytesIO()
    np.lib.format.write_array(file, array, version=(1, 0), allow_pickle=False)
    return file.getvalue()


def read_archive(
    path: str | PathLike, memory: float | None = None
) -> tuple[object, dict[str, np.ndarray], str]:
    """Return the content, the arrays and the program that made them.

    Raises
    ------
    SceneError
        The file is not there, no such archive, of another version, or damaged: names the member.
    Refused
        Its arrays would not fit into ``memory`` bytes, by default half of what is free.
    """
    problem = file_problem(Path(path), LARGEST)
    if problem:
        raise SceneError(str(path), [problem])
    try:
        with open(path, "rb") as raw, ZipFile(raw) as file:
            return _read(str(path), file, Path(path).stat().st_size, memory)
    except (SceneError, Refused):
        raise
    except BROKEN as error:
        raise SceneError(str(path), [
            f"is no .radsol file, or a damaged one ({type(error).__name__}: {error}): copy it "
            "again, or solve the scene again"
        ]) from error  # fmt: skip


def _read(path, file, size, memory):
    infos = _checked_infos(path, file, size)
    total = sum(info.file_size for info in infos.values())
    way_out = "free some memory, or allow more with --memory"
    check_fits(f"{path}: {len(infos)} members", 2 * total, memory, way_out)
    manifest = _manifest(path, file, infos)
    members, found = manifest["members"], {}
    strange = sorted(members.keys() ^ (infos.keys() - {MANIFEST}))
    if strange:
        where = "the archive" if strange[0] in members else MANIFEST
        _refuse(path, strange[0], f"is missing in {where}")
    for name, told in members.items():
        kind, shape = _checked_entry(path, name, told, infos[name].file_size)
        found[name.removesuffix(".npy")] = _array(path, file, name, told, kind, shape)
    return manifest["content"], found, manifest["program"]


def _refuse(path, member, problem, way_out="the file is damaged, copy it or solve again"):
    raise SceneError(path, [f"member {member[:80]!r} {problem}: {way_out}"])


def _checked_infos(path, file, size):
    """Return what the archive says of its members by their names, where it can be true."""
    infos = file.infolist()
    if len(infos) > MOST_MEMBERS:
        raise SceneError(path, [f"has {len(infos)} members, at most {MOST_MEMBERS} are read"])
    for info in infos:
        if info.flag_bits & 1:
            _refuse(path, info.filename, "is locked by a password", "such files are not read")
        if info.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
            _refuse(path, info.filename, f"is packed by method {info.compress_type}, not deflate")
        if info.file_size > PACKED * info.compress_size + PACKED or info.compress_size > size:
            text = f"claims {info.file_size} bytes, packed as {info.compress_size}"
            _refuse(path, info.filename, text)
    if sum(info.compress_size for info in infos) > size:
        raise SceneError(path, ["its members claim more bytes than the file has: it is damaged"])
    names = {info.filename: info for info in infos}
    if len(names) != len(infos) or MANIFEST not in names:
        raise SceneError(path, [f"has no {MANIFEST}, or members twice: it is no .radsol file"])
    return names


def _manifest(path, file, infos):
    """Return the manifest, of a version and with the parts that this release reads."""
    if infos[MANIFEST].file_size > LARGEST_MANIFEST:
        _refuse(path, MANIFEST, f"has more than {LARGEST_MANIFEST} bytes")
    try:
        found = json.loads(file.read(MANIFEST).decode())
    except RecursionError:
        _refuse(path, MANIFEST, "is nested too deeply")
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        _refuse(path, MANIFEST, f'has no "format": "{FORMAT}"', "it is no .radsol file")
    version, program = found.get("version"), str(found.get("program"))[:80]
    if version != VERSION or isinstance(version, bool):
        _refuse(
            path, MANIFEST, f"has version {str(version)[:20]}, made by {program}; this release "
            f"reads {VERSION}", "use the release that made it, or solve the scene again",
        )  # fmt: skip
    if not isinstance(found.get("members"), dict) or "content" not in found:
        _refuse(path, MANIFEST, "lacks members or content")
    return found | {"program": program}


def _checked_entry(path, name, told, size):
    """Return the type and shape of a member that fit its size."""
    told = told if isinstance(told, dict) else {}
    kind, shape = told.get("type"), told.get("shape")
    whole = isinstance(shape, list) and len(shape) <= MOST_AXES
    whole = whole and all(type(n) is int and 0 <= n <= LARGEST for n in shape)
    if kind not in TYPES or not whole or not name.endswith(".npy"):
        _refuse(path, name, f"has the type {kind!r} and the shape {str(shape)[:80]}")
    needed = np.dtype(kind).itemsize
    for n in shape:
        needed *= n  # of whole numbers of any size
    if not 0 < size - needed <= 16384:
        _refuse(path, name, f"has {size} bytes, {needed} are needed for {kind} {shape}")
    return kind, tuple(shape)


def _array(path, file, name, told, kind, shape):
    """Return a member's array; nothing of its header is taken before it equals the manifest."""
    try:
        data = file.read(name)
    except BROKEN as error:
        _refuse(path, name, f"cannot be unpacked ({error})")
    if hashlib.sha256(data).hexdigest() != told.get("sha256"):
        _refuse(path, name, "has another SHA-256 than the manifest says")
    head = io.BytesIO(data)
    version = np.lib.format.read_magic(head)
    if version != (1, 0):
        _refuse(path, name, f"is of version {version} of the .npy format, not (1, 0)")
    real, turned, dtype = np.lib.format.read_array_header_1_0(head)
    if (real, dtype.str) != (shape, kind):
        _refuse(path, name, f"holds {dtype} {real}, the manifest says {kind} {shape}")
    values = np.frombuffer(data, dtype, offset=head.tell())
    if values.size != np.prod(shape, dtype=float):
        _refuse(path, name, f"holds {values.size} numbers for the shape {shape}")
    if kind == "|b1" and np.any(values.view(np.uint8) > 1):
        _refuse(path, name, "holds values that are neither true nor false")
    return values.reshape(shape, order="F" if turned else "C").copy(order="K")
