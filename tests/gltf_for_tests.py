"""glTF files made of Python values: buffers, accessors and meshes are added one by one."""

import base64
import json
import struct

import numpy as np

CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Gltf:
    """A glTF file in the making; ``json`` is its tree, ``data`` its buffer."""

    def __init__(self, **top):
        self.json = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], **top}
        self.data = b""

    def add(self, kind, **entry):
        """Append to a list at the top; return its number."""
        self.json.setdefault(kind, []).append(entry)
        return len(self.json[kind]) - 1

    def view(self, data, **more):
        """Append bytes to the buffer; return the number of their view."""
        self.data += b"\0" * (-len(self.data) % 4)
        start = len(self.data)
        self.data += bytes(data)
        return self.add("bufferViews", buffer=0, byteOffset=start, byteLength=len(data), **more)

    def accessor(self, values, kind="f4", **more):
        """Append an array (n, c) or (n,); return the number of its accessor."""
        values = np.asarray(values, "<" + kind)
        values = values[:, None] if values.ndim == 1 else values
        return self.add(
            "accessors", bufferView=self.view(values.tobytes()), componentType=CODES[kind],
            count=len(values), type=TYPES[values.shape[1]], **more,
        )  # fmt: skip

    def primitive(self, points, index=None, material=None, **more):
        """Return a primitive of points (n, 3) and corners; more attributes in capitals."""
        attributes = {"POSITION": points if isinstance(points, int) else self.accessor(points)}
        attributes |= {key: more.pop(key) for key in list(more) if key.isupper()}
        found = {"attributes": attributes, **more}
        if index is not None:
            found["indices"] = self.accessor(np.ravel(index), "u2")
        if material is not None:
            found["material"] = material
        return found

    def mesh(self, *primitives, **more):
        return self.add("meshes", primitives=list(primitives), **more)

    def node(self, **entry):
        """Append a node at the root; return its number."""
        return self.add("nodes", **entry)

    def light(self, node=None, **light):
        """Append a light and the node that has it."""
        top = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {})
        top.setdefault("lights", []).append(light)
        number = len(top["lights"]) - 1
        return self.node(**(node or {}), extensions={"KHR_lights_punctual": {"light": number}})

    def tree(self, **buffer):
        buffers = [{"byteLength": len(self.data), **buffer}] if self.data else []
        return {**self.json, **({"buffers": buffers} if buffers else {})}

    def glb(self):
        """Return the bytes of a GLB file."""
        text = json.dumps(self.tree()).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(data), 0x004E4942) + data if data else b""
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def embedded(self):
        """Return the text of a .gltf file with its buffer in a data: URI."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        return json.dumps(self.tree(uri=uri)).encode()


SQUARE = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
TWO = [0, 1, 2, 0, 2, 3]


def square(material=None, **more):
    """Return a file of one rectangle 2 x 1 that faces +z, at the origin."""
    made = Gltf(**({"materials": [material]} if material is not None else {}))
    number = None if material is None else 0
    attributes = {key: made.accessor(value) for key, value in more.items() if key.isupper()}
    rest = {key: value for key, value in more.items() if not key.isupper()}
    made.node(mesh=made.mesh(made.primitive(SQUARE, TWO, number, **attributes)), **rest)
    return made
