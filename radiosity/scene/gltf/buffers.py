"""The buffers of a glTF file: arrays of its accessors, bytes of its images.

Everything is checked against what is there before memory is taken.
"""

import base64
import binascii
import re
from collections.abc import Callable
from urllib.parse import unquote

import numpy as np

from radiosity.scene.gltf.document import Document, Entry
from radiosity.scene.model import SceneError

MOST = 3 << 22  # elements of one accessor: the corners of as many triangles as are read
LARGEST = 1 << 30  # bytes of all files beside a glTF file
KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")


class Buffers:
    """What the accessors and buffer views of a document hold.

    Parameters
    ----------
    document : Document
    read_file : callable
        Returns the bytes of a file by its name relative to the glTF file; raises SceneError.
    """

    def __init__(self, document: Document, read_file: Callable[[str], bytes]):
        self.document, self.read_file = document, read_file
        self._files, self._buffers, self._arrays = {}, {}, {}

    def array(self, entry: Entry, key: str, shapes: tuple[str, ...]) -> np.ndarray | None:
        """Return the array (n, c) of the accessor that a key names; None if there is no such key.

        Whole numbers stay such unless they are normalised: then they are reals in [-1, 1].
        """
        accessor = self.document.referred(entry, key, "accessors")
        if accessor is None:
            return None
        shape = accessor.text("type")
        if shape not in shapes:
            entry.fail(key, f'names an accessor of type "{shape}", must be {" or ".join(shapes)}')
        if accessor.path not in self._arrays:
            self._arrays[accessor.path] = self._read(accessor, SIZES[shape])
        return self._arrays[accessor.path]

    def has_data(self, entry: Entry, key: str) -> bool:
        """Whether the accessor that a key names has numbers of its own in a buffer."""
        accessor = self.document.referred(entry, key, "accessors")
        return accessor is not None and (accessor.has("bufferView") or accessor.has("sparse"))

    def view(self, entry: Entry, key: str) -> bytes:
        """Return the bytes of the buffer view that a key names."""
        data, start, size, _ = self._view(entry, key)
        return bytes(data[start : start + size])

    def uri(self, entry: Entry) -> bytes:
        """Return the bytes that the key ``uri`` names or holds."""
        uri = entry.text("uri")
        if uri.startswith("data:"):
            return _embedded(entry, uri)
        if SCHEME.match(uri) or uri.startswith("//"):
            entry.fail("uri", "is not read: only files beside this one are, save it there")
        return self._file(unquote(uri))

    def _file(self, name):
        if name not in self._files:
            left = LARGEST - sum(map(len, self._files.values()))
            data = self.read_file(name)
            if len(data) > left:
                text = f"{name}: its files have more than {LARGEST} bytes: split the scene"
                raise SceneError(self.document.source, [text])
            self._files[name] = data
        return self._files[name]

    def _read(self, accessor, width):
        kind = KINDS.get(accessor.whole("componentType"))
        if kind is None:
            accessor.fail("componentType", f"must be one of {', '.join(map(str, KINDS))}")
        count = accessor.whole("count", low=1, high=MOST)
        if accessor.has("bufferView"):
            found = self._numbers(accessor, count, np.dtype(kind), width, True)
        else:
            found = np.zeros((count, width), kind)
        if accessor.has("sparse"):
            found = self._with_sparse(accessor, found)
        return _normalised(found) if accessor.flag("normalized") else found

    def _numbers(self, entry, count, kind, width, strided=False):
        """Return numbers (count, width) of a buffer view, which must hold them all."""
        data, start, size, stride = self._view(entry, "bufferView")
        offset = entry.whole("byteOffset", 0)
        wide = kind.itemsize * width
        step = stride if strided and stride else wide
        if step < wide:
            entry.fail("bufferView", f"has a byteStride of {step}, elements have {wide} bytes")
        needed = offset + (count - 1) * step + wide
        if needed > size:
            key = "count" if entry.has("count") else "bufferView"
            entry.fail(key, f"needs {needed} bytes of a buffer view that has {size}")
        return np.ndarray((count, width), kind, data, start + offset, (step, kind.itemsize))

    def _with_sparse(self, accessor, found):
        sparse = accessor.child("sparse")
        count = sparse.whole("count", low=1, high=len(found))
        where, what = sparse.child("indices"), sparse.child("values")
        kind = KINDS.get(where.whole("componentType"), "f")
        if "u" not in kind:
            where.fail("componentType", "must be one of 5121, 5123, 5125: whole numbers")
        place = self._numbers(where, count, np.dtype(kind), 1)[:, 0].astype(np.int64)
        if place.max() >= len(found):
            text = f"names element {place.max()}, there are {len(found)}, counted from 0"
            where.fail("bufferView", text)
        found = found.copy()
        found[place] = self._numbers(what, count, found.dtype, found.shape[1])
        return found

    def _view(self, entry, key):
        """Return a buffer's bytes, and start, length and stride of the view that a key names."""
        view = self.document.referred(entry, key, "bufferViews")
        if view is None:
            entry.fail(key, "names a buffer view")
        if view.extended("EXT_meshopt_compression") or view.extended("KHR_meshopt_compression"):
            text = "is compressed (meshopt): write it without, npx @gltf-transform/cli copy IN OUT"
            raise SceneError(self.document.source, [f"bufferViews[{view.path[-1]}] {text}"])
        buffer = self.document.referred(view, "buffer", "buffers")
        if buffer is None:
            view.fail("buffer", "names a buffer")
        data = self._buffer(buffer)
        start = view.whole("byteOffset", 0)
        size = view.whole("byteLength", low=1)
        if start + size > len(data):
            view.fail("byteLength", f"ends at byte {start + size} of a buffer that has {len(data)}")
        return data, start, size, view.whole("byteStride", 0, high=252)

    def _buffer(self, buffer):
        number = buffer.path[-1]
        if number in self._buffers:
            return self._buffers[number]
        if buffer.has("uri"):
            data = self.uri(buffer)
        elif number == 0 and self.document.binary is not None:
            data = self.document.binary
        else:
            buffer.fail("uri", "names the file with its bytes, and the file has no binary chunk")
        size = buffer.whole("byteLength", low=1)
        if size > len(data):
            buffer.fail("byteLength", f"is more than the {len(data)} bytes that are there: it is "
                        "cut, get it again")  # fmt: skip
        self._buffers[number] = memoryview(data)[:size]  # no copy
        return self._buffers[number]


def _embedded(entry, uri):
    """Return the bytes of a data: URI."""
    head, comma, text = uri.partition(",")
    if not comma:
        entry.fail("uri", "has no comma after data: ...")
    if not head.endswith(";base64"):
        return unquote(text).encode("utf-8", "replace")
    try:
        return base64.b64decode(text)
    except (binascii.Error, ValueError) as error:
        entry.fail("uri", f"is not base64 that can be read: {error}")


def _normalised(found):
    """Return whole numbers as reals, their greatest as 1."""
    if found.dtype.kind == "f":
        return found
    return np.maximum(found / np.iinfo(found.dtype).max, -1.0)
