"""Reading .glb files back by their specification, and Khronos' validator where it is installed."""

import json
import os
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

KINDS = {5126: "<f4", 5123: "<u2", 5125: "<u4"}
SHAPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}
VALIDATE = """
const v = require("gltf-validator"), fs = require("fs");
v.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])), {maxIssues: 0})
  .then(r => console.log(JSON.stringify(r.issues)));
"""


class Glb:
    """The JSON of a file, and the arrays of its accessors."""

    def __init__(self, path):
        data = Path(path).read_bytes()
        magic, version, total = struct.unpack_from("<4sII", data)
        assert (magic, version, total) == (b"glTF", 2, len(data))
        size, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON" and size % 4 == 0
        self.tree, self.bytes = json.loads(data[20 : 20 + size]), b""
        if 20 + size < total:
            more, kind = struct.unpack_from("<I4s", data, 20 + size)
            assert kind == b"BIN\0" and 28 + size + more == total
            assert self.tree["buffers"] == [{"byteLength": more}]
            self.bytes = data[28 + size :]

    def view(self, number):
        at = self.tree["bufferViews"][number]
        return self.bytes[at["byteOffset"] : at["byteOffset"] + at["byteLength"]]

    def array(self, number):
        told = self.tree["accessors"][number]
        values = np.frombuffer(self.view(told["bufferView"]), KINDS[told["componentType"]])
        return values.reshape(told["count"], SHAPES[told["type"]])

    def triangles(self, what):
        """Return (t, 3, c) values at the corners of all triangles, one mesh after the other."""
        found = []
        for mesh in self.tree["meshes"]:
            for part in mesh["primitives"]:
                index = self.array(part["indices"]).reshape(-1, 3)
                found.append(self.array(part["attributes"][what])[index])
        return np.concatenate(found).astype(float)


def validated(path):
    """Return how many errors and warnings Khronos' validator finds; skip where it is missing."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    here = os.environ.get("GLTF_VALIDATOR", "")  # a folder with node_modules
    done = subprocess.run([node, "-e", VALIDATE, str(path)], capture_output=True, text=True,
                          cwd=here or None)  # fmt: skip
    if "Cannot find module 'gltf-validator'" in done.stderr:
        pytest.skip("gltf-validator is not installed: npm install gltf-validator")
    issues = json.loads(done.stdout)
    return issues["numErrors"], issues["numWarnings"]
