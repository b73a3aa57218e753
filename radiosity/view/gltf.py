"""glTF 2.0 files in one piece (.glb): JSON, and the numbers that it points to.

Khronos, "glTF 2.0 specification": metres, y up, counter-clockwise fronts, linear colours, texture
coordinates from a picture's upper left corner.
"""

import json
import struct
from pathlib import Path

import numpy as np

from radiosity import __version__
from radiosity.scene.model import Camera, Scene
from radiosity.scene.units import turn_between
from radiosity.view.camera import basis

_MAGIC, _VERSION, _JSON, _BIN = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
_VERTICES, _INDICES = 34962, 34963  # what a view of the buffer is for
_TYPES = {(np.float32, 1): (5126, "SCALAR"), (np.float32, 2): (5126, "VEC2"),
          (np.float32, 3): (5126, "VEC3"), (np.uint16, 1): (5123, "SCALAR"),
          (np.uint32, 1): (5125, "SCALAR")}  # fmt: skip
_SHORT = 65535  # vertices that two bytes can number: the last number means something else


class Document:
    """A glTF file in the making.

    Attributes
    ----------
    tree : dict
        The JSON part; lists that stay empty are left out.

    Examples
    --------
    >>> document = Document()
    >>> document.indices(np.array([0, 1, 2])), document.tree["accessors"][0]["count"]
    (0, 3)
    """

    def __init__(self):
        self.tree = {"asset": {"version": "2.0", "generator": f"radiosity {__version__}"}}
        self._parts, self._size = [], 0

    def add(self, kind: str, **what) -> int:
        """Add an object to one of the lists and return its number there."""
        self.tree.setdefault(kind, []).append(what)
        return len(self.tree[kind]) - 1

    def vertices(self, values: np.ndarray, bounds: bool = False) -> int:
        """Add values (n, 2) or (n, 3), one a vertex, as float32; return their number.

        ``bounds`` states the least and largest ones, which positions must.
        """
        values = np.ascontiguousarray(values, np.float32)
        more = {}
        if bounds:
            more = {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self._numbers(values, _VERTICES, **more)

    def indices(self, numbers: np.ndarray) -> int:
        """Add vertices' numbers (3 t,), three a triangle; return their number."""
        kind = np.uint16 if numbers.max(initial=0) < _SHORT else np.uint32
        return self._numbers(np.ascontiguousarray(numbers, kind), _INDICES)

    def picture(self, png: bytes, name: str) -> int:
        """Add a PNG file's bytes; return the picture's number."""
        view = self.add("bufferViews", **self._stored(png))
        return self.add("images", bufferView=view, mimeType="image/png", name=name)

    def _numbers(self, values, target, **more) -> int:
        view = self.add("bufferViews", **self._stored(values.tobytes()), target=target)
        component, shape = _TYPES[values.dtype.type, values[0].size]
        return self.add("accessors", bufferView=view, componentType=component, type=shape,
                        count=len(values), **more)  # fmt: skip

    def _stored(self, data: bytes) -> dict:
        """Append bytes to the buffer, filled up to whole words; return where they lie."""
        place = {"buffer": 0, "byteOffset": self._size, "byteLength": len(data)}
        padding = -len(data) % 4
        self._parts += [data, bytes(padding)]
        self._size += len(data) + padding
        return place

    def write(self, path: Path) -> None:
        """Write the file; ValueError where it would be larger than its four-byte lengths tell."""
        tree = self.tree | ({"buffers": [{"byteLength": self._size}]} if self._size else {})
        text = json.dumps(tree, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        text = text.encode("utf-8")
        text += b" " * (-len(text) % 4)
        chunks = [struct.pack("<II", len(text), _JSON), text]
        if self._size:
            chunks += [struct.pack("<II", self._size, _BIN), *self._parts]
        total = 12 + sum(len(c) for c in chunks)
        if total >= 2**32:
            raise ValueError(f"a .glb of {total} bytes is above the format's 4 GiB: solve on a "
                             "coarser --mesh or save .vtp")  # fmt: skip
        with open(path, "wb") as file:
            file.write(struct.pack("<III", _MAGIC, _VERSION, total))
            file.writelines(chunks)


def to_gltf(scene: Scene, points: np.ndarray) -> np.ndarray:
    """Return points (..., 3) of a scene in metres with y up."""
    return (np.asarray(points, float) * scene.unit_m) @ turn_between(scene.up, "y").T


def add_cameras(document: Document, scene: Scene) -> list[int]:
    """Add a scene's cameras; return the numbers of their nodes.

    A glTF camera looks along -z of its node with y up. Planes before and behind lie so that all of
    the scene is between them.
    """
    return [_add_camera(document, scene, camera) for camera in scene.cameras.values()]


def _add_camera(document: Document, scene: Scene, camera: Camera) -> int:
    right, up, forward = (turn_between(scene.up, "y") @ v for v in basis(camera))
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([right, up, -forward])
    matrix[:3, 3] = to_gltf(scene, camera.position)
    width, height = camera.size
    corners = to_gltf(scene, scene.faces.vertices.reshape(-1, 3))
    far = 2.0 * float(np.linalg.norm(corners - matrix[:3, 3], axis=1).max())
    if camera.orthographic:
        half = 0.5 * camera.height * scene.unit_m
        lens = {"type": "orthographic", "orthographic": {
            "xmag": half * width / height, "ymag": half, "znear": 0.0, "zfar": far}}  # fmt: skip
    else:
        lens = {"type": "perspective", "perspective": {
            "yfov": float(np.radians(camera.fov)), "aspectRatio": width / height,
            "znear": 1e-4 * far, "zfar": far}}  # fmt: skip
    number = document.add("cameras", name=camera.name, **lens)
    return document.add("nodes", name=camera.name, camera=number, matrix=matrix.T.ravel().tolist())
