"""The meshes of a glTF file: triangles with what they have at their corners."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.corners import unit
from radiosity.scene.gltf.buffers import Buffers
from radiosity.scene.gltf.document import Document, Entry
from radiosity.scene.gltf.nodes import Node
from radiosity.scene.meshes.polygons import vertex_problems
from radiosity.scene.model import SceneError
from radiosity.scene.schema import dotted

DRACO = "KHR_draco_mesh_compression"
POINTS_AND_LINES = range(4)
TRIANGLES, STRIP, FAN = 4, 5, 6
MOST_TRIANGLES = 1 << 22
MOST_VERTICES = 1 << 25  # of all meshes, each counted as often as a skin or a morph moves it
MOST_COORDINATE = 1e9  # beyond, texture coordinates have no digits left


@dataclass(frozen=True)
class Shape:
    """Triangles of one primitive in the axes of its node.

    Attributes
    ----------
    points : (t, 3, 3) float64
        Corners of triangles, counter-clockwise seen from the front.
    normals : (t, 3, 3) float64 or None
    coordinates : dict of int to (t, 3, 2) float64
        Texture coordinates by set, v downwards as in the file; those that are not finite are left
        out.
    colour : (3,) float64 or None
        Mean of the vertices' colours, linear.
    """

    points: np.ndarray
    normals: np.ndarray | None
    coordinates: dict[int, np.ndarray]
    colour: np.ndarray | None

    def placed(self, matrix: np.ndarray, uv: np.ndarray | None) -> tuple:
        """Return points, normals and uv (t, 3, c), None where there are none, moved by a matrix.

        Fronts stay fronts where it is a reflection. Normals follow its cofactors, which are the
        inverse transpose times the determinant, and there even where there is no inverse.
        """
        linear, normals = matrix[:3, :3], self.normals
        points = self.points @ linear.T + matrix[:3, 3]
        turned = np.linalg.det(linear) < 0
        if normals is not None:
            x, y, z = linear.T
            across = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)])
            normals = unit(unit(normals) @ across)
        if not turned:
            return points, normals, uv
        return tuple(None if v is None else v[:, [0, 2, 1]] for v in (points, normals, uv))


class Shapes:
    """The primitives of a document's meshes as triangles.

    Parameters
    ----------
    document : Document
    buffers : Buffers
    """

    def __init__(self, document: Document, buffers: Buffers):
        self.document, self.buffers = document, buffers
        self.skipped = self.posed = self.morphed = self.crowded = 0
        self._known, self._vertices = {}, 0

    def of(
        self, primitive: Entry, node: Node, mesh: Entry, places: dict[int, Node]
    ) -> Shape | None:  # fmt: skip
        """Return the triangles of a primitive of a node's mesh; None for points and lines.

        ``places`` are all nodes by number, which move the vertices of skins.
        """
        if primitive.path in self._known:
            return self._known[primitive.path]
        mode = primitive.whole("mode", TRIANGLES, high=6)
        attributes = primitive.child("attributes")
        if mode in POINTS_AND_LINES or not attributes.has("POSITION"):
            self.skipped += 1
            return None
        self._check_packed(primitive, attributes)
        shape = self._read(primitive, attributes, node, mesh, places)
        if not (node.entry.has("skin") or primitive.has("targets")):
            self._known[primitive.path] = shape
        return shape

    def _read(self, primitive, attributes, node, mesh, places):
        points = np.asarray(self.buffers.array(attributes, "POSITION", ("VEC3",)), float)
        self._vertices += len(points)
        check_count(self._vertices, MOST_VERTICES, "vertices", self.document.source)
        mode = primitive.whole("mode", TRIANGLES)
        corners = self._corners(primitive, mode, len(points))
        points = self._morphed(primitive, node, mesh, points)
        normals = self._same(attributes, "NORMAL", ("VEC3",), len(points))
        points, normals = self._posed(attributes, node, places, points, normals)
        self._check_points(attributes, points)
        coordinates = self._coordinates(attributes, len(points))
        return Shape(
            points[corners], None if normals is None else normals[corners],
            {number: uv[corners] for number, uv in coordinates.items()},
            self._colour(attributes, corners, len(points)),
        )  # fmt: skip

    def _check_packed(self, primitive, attributes):
        if primitive.extended(DRACO) and not self.buffers.has_data(attributes, "POSITION"):
            text = "is compressed (Draco): write it without, npx @gltf-transform/cli copy IN OUT"
            raise SceneError(self.document.source, [f"{dotted(primitive.path)} {text}"])

    def _check_points(self, attributes, points):
        for problem in vertex_problems(points):
            attributes.fail("POSITION", f"names an accessor whose {problem}")

    def _same(self, attributes, key, shapes, count) -> np.ndarray | None:
        """Return one row a vertex, real numbers; not finite ones are 0."""
        values = self.buffers.array(attributes, key, shapes)
        if values is None:
            return None
        if len(values) != count:
            text = f"names an accessor of {len(values)} elements, there are {count} vertices"
            attributes.fail(key, text)
        return np.asarray(values, float)

    def _corners(self, primitive, mode, count) -> np.ndarray:
        """Return the vertices (t, 3) of triangles."""
        index = self.buffers.array(primitive, "indices", ("SCALAR",))
        if index is None:
            index = np.arange(count)
        elif index.dtype.kind != "u":
            primitive.fail("indices", "names an accessor of numbers that are not whole, from 0")
        many = len(index) // 3 if mode == TRIANGLES else len(index) - 2
        check_count(many, MOST_TRIANGLES, "triangles", self.document.source)
        index = index.reshape(-1).astype(np.int64)
        if index.max() >= count:
            text = f"names vertex {index.max()}, there are {count}, counted from 0"
            primitive.fail("indices", text)
        if mode == TRIANGLES:
            return index[: len(index) // 3 * 3].reshape(-1, 3)
        k = np.arange(max(len(index) - 2, 0))
        if mode == FAN:
            return np.stack([index[k + 1], index[k + 2], np.full(len(k), index[0])], axis=1)
        odd = k % 2
        return np.stack([index[k], index[k + 1 + odd], index[k + 2 - odd]], axis=1)

    def _morphed(self, primitive, node, mesh, points):
        """Return the points moved by the morph targets as far as their weights say."""
        targets = primitive.tables("targets")
        if not targets:
            return points
        given = node.entry.weights("weights")
        given = mesh.weights("weights") if given is None else given
        self.morphed += 1
        for weight, target in zip(given or [], targets, strict=False):
            moved = self._same(target, "POSITION", ("VEC3",), len(points)) if weight else None
            points = points if moved is None else points + weight * moved
        return points

    def _posed(self, attributes, node, places, points, normals):
        """Return points and normals moved by the joints of a skin, back in the node's own axes."""
        skin = self.document.referred(node.entry, "skin", "skins")
        joints = self.buffers.array(attributes, "JOINTS_0", ("VEC4",)) if skin else None
        weights = self._same(attributes, "WEIGHTS_0", ("VEC4",), len(points)) if skin else None
        if joints is None or weights is None or len(joints) != len(points):
            return points, normals
        moves = self._moves(skin, node, places)
        if joints.dtype.kind != "u" or joints.max() >= len(moves):
            text = f"must name joints by whole numbers below {len(moves)}, the joints of the skin"
            attributes.fail("JOINTS_0", text)
        self.posed += 1
        self.crowded += attributes.has("JOINTS_1")
        moved, turned = np.zeros_like(points), np.zeros_like(points)
        for k in range(4):
            by, share = moves[joints[:, k]], weights[:, k, None]
            moved += share * (np.einsum("nij,nj->ni", by[:, :3, :3], points) + by[:, :3, 3])
            if normals is not None:
                turned += share * np.einsum("nij,nj->ni", by[:, :3, :3], normals)
        return moved, None if normals is None else turned

    def _moves(self, skin, node, places) -> np.ndarray:
        """Return (j, 4, 4) from the mesh through each joint back to the node's axes."""
        numbers = skin.wholes("joints")
        lost = [k for k in numbers if k not in places]
        if lost or not numbers:
            skin.fail("joints", "must list nodes of the scene")
        inverse = self.buffers.array(skin, "inverseBindMatrices", ("MAT4",))
        if inverse is not None and len(inverse) < len(numbers):
            skin.fail("inverseBindMatrices", f"has {len(inverse)} for {len(numbers)} joints")
        bound = np.broadcast_to(np.eye(4), (len(numbers), 4, 4))
        if inverse is not None:
            bound = inverse[: len(numbers)].reshape(-1, 4, 4).transpose(0, 2, 1).astype(float)
        back = np.linalg.pinv(node.matrix) if np.isfinite(node.matrix).all() else np.eye(4)
        return back @ np.array([places[k].matrix for k in numbers]) @ bound

    def _coordinates(self, attributes, count) -> dict[int, np.ndarray]:
        found = {}
        for number in (0, 1):
            uv = self._same(attributes, f"TEXCOORD_{number}", ("VEC2",), count)
            if uv is not None and (np.abs(uv) <= MOST_COORDINATE).all():
                found[number] = uv
        return found

    def _colour(self, attributes, corners, count) -> np.ndarray | None:
        """Return the mean colour of the vertices that triangles have."""
        colours = self._same(attributes, "COLOR_0", ("VEC3", "VEC4"), count)
        if colours is None or len(corners) == 0:
            return None
        mean = colours[corners.ravel(), :3].mean(axis=0)
        return np.clip(mean, 0.0, 1.0) if np.isfinite(mean).all() else None


def check_count(total: int, most: int, what: str, source: str) -> None:
    """Raise SceneError where a file has more of something than is read."""
    if total > most:
        text = f"has {total} {what} or more, at most {most} are read: reduce the mesh"
        raise SceneError(source, [text])
