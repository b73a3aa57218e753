"""glTF 2.0: meshes, materials, lights, cameras and names of ``.gltf`` and ``.glb`` files.

See docs/files.md for what is read as what.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radiosity.mesh.faces import Faces, has_area
from radiosity.mesh.given import Given
from radiosity.scene.geometry import DEFAULT, Geometry
from radiosity.scene.gltf.buffers import Buffers
from radiosity.scene.gltf.document import Document, Names
from radiosity.scene.gltf.images import TRANSFORM, Images
from radiosity.scene.gltf.looks import READ
from radiosity.scene.gltf.materials import Materials
from radiosity.scene.gltf.nodes import (
    INSTANCES,
    LIGHTS,
    VISIBLE,
    cameras_of,
    lights_of,
    placed_nodes,
    places_of,
)
from radiosity.scene.gltf.shapes import DRACO, MOST_TRIANGLES, Shapes, check_count
from radiosity.scene.model import SceneError

KNOWN = READ | {LIGHTS, INSTANCES, VISIBLE, TRANSFORM, "KHR_mesh_quantization"}
HARMLESS = {  # read without: what they add is noted where it is met
    "KHR_materials_clearcoat", "KHR_materials_sheen", "KHR_materials_iridescence",
    "KHR_materials_anisotropy", "KHR_materials_dispersion", "KHR_materials_variants",
    "KHR_animation_pointer", "KHR_xmp_json_ld", "KHR_texture_basisu", "EXT_texture_webp",
    "EXT_texture_avif", DRACO, "EXT_meshopt_compression", "KHR_meshopt_compression",
}  # fmt: skip


def read_gltf(
    data: bytes, source: str, read_file: Callable[[str], bytes], merge: bool = True,
    uv: bool = False, called: str = "",
) -> Geometry:  # fmt: skip
    """Return what a glTF file describes, in metres with y up.

    Parameters
    ----------
    data : bytes
        The content of a ``.gltf`` or ``.glb`` file.
    source : str
        Its name, for messages.
    read_file : callable
        Returns the bytes of a file by its name relative to this one; raises SceneError.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    uv : bool
        Keep all texture coordinates, not only those of the file's own textures.
    called : str
        What its pictures' names begin with; by default ``source``.

    Raises
    ------
    SceneError
        A file that is broken, or needs an extension that is not read.
    """
    document = Document(data, source)
    _check_required(document)
    with np.errstate(all="ignore"):  # of numbers that are no numbers; the checks find them
        return _read(document, Buffers(document, read_file), merge, uv, called or source)


def _read(document, buffers, merge, uv, called):
    images = Images(document, buffers, called)
    materials, shapes = Materials(document, images), Shapes(document, buffers)
    nodes, hidden = placed_nodes(document)
    parts = _Parts(document, buffers, shapes, materials, uv)
    places = {node.number: node for node in nodes}
    for node in nodes:
        parts.add(node, places)
    unseen = 0 if hidden else _unseen(document, places)
    notes = [*_notes(document, shapes, materials, images, hidden, unseen)]
    lights, cameras = lights_of(nodes, document, notes), cameras_of(nodes, document, notes)
    geometry = parts.geometry(merge)
    return replace(
        geometry, materials=materials.tables, notes=tuple(notes), lights=tuple(lights),
        cameras=cameras, pictures=materials.pictures, unit="m", up="y",
    )  # fmt: skip


def _unseen(document, places):
    """Return how many nodes have a mesh and are in none of the trees that are shown."""
    nodes = enumerate(document.listed("nodes"))
    return sum(node.has("mesh") for number, node in nodes if number not in places)


class _Parts:
    """The triangles of all nodes with their materials and groups, as they are met."""

    def __init__(self, document, buffers, shapes, materials, uv):
        self.document, self.buffers, self.uv = document, buffers, uv
        self.shapes, self.materials = shapes, materials
        self.names, self.groups, self._free = {}, {}, Names()
        self.points, self.normals, self.coordinates = [], [], []
        self.material, self.group, self.total = [], [], 0

    def add(self, node, places):
        """Add the mesh of a node, at all places where it stands."""
        mesh = self.document.referred(node.entry, "mesh", "meshes")
        if mesh is None:
            return
        matrices, group = places_of(node, self.buffers), None
        for primitive in mesh.tables("primitives"):
            shape = self.shapes.of(primitive, node, mesh, places)
            if shape is None or len(shape.points) == 0:
                continue
            self.total += len(shape.points) * len(matrices)
            check_count(self.total, MOST_TRIANGLES, "triangles", self.document.source)
            group = self._group(node.name(mesh.name(""))) if group is None else group
            name, texture = self._material(primitive, shape)
            material = self.names.setdefault(name, len(self.names))
            uv = self._uv(shape, texture)
            for matrix in matrices:
                points, normals, turned = shape.placed(matrix, uv)
                self.points.append(points)
                self.normals.append(normals)
                self.coordinates.append(turned)
                self.material.append(np.full(len(points), material))
                self.group.append(np.full(len(points), group))

    def geometry(self, merge: bool) -> Geometry:
        """Return all triangles as faces."""
        if not self.total:
            text = "has no triangles in its scene: nothing can be lit"
            raise SceneError(self.document.source, [text])
        quads = [0, 1, 2, 2]
        polygons = np.concatenate(self.points)[:, quads]
        more = (_all(parts, self.points) for parts in (self.coordinates, self.normals))
        faces = Faces.from_polygons(
            polygons, np.concatenate(self.material), np.concatenate(self.group), merge,
            *(None if x is None else x[:, quads] for x in more),
        )  # fmt: skip
        if faces.corner_normals is not None:
            from radiosity.mesh.curves import curved

            faces = replace(faces, corner_normals=curved(faces))
        given = None if merge else Given(faces, np.flatnonzero(has_area(polygons)), len(polygons))
        return Geometry(faces, tuple(self.names), tuple(self.groups), given=given)

    def _group(self, name):
        """Return the index of a new group, numbered where its name is taken."""
        return self.groups.setdefault(self._free.free(name), len(self.groups))

    def _material(self, primitive, shape):
        """Return the name of a primitive's material, and the texture that it needs uv of."""
        entry = self.document.referred(primitive, "material", "materials")
        if entry is None:
            return DEFAULT, None
        return self.materials.named(entry, shape.colour, shape.coordinates)

    def _uv(self, shape, texture):
        """Return the coordinates (t, 3, 2) of a shape's texture; None where it needs none."""
        if texture is not None:
            images = self.materials.images
            return images.placed(texture, shape.coordinates[images.set_of(texture)])
        found = shape.coordinates.get(0) if self.uv else None
        return None if found is None else np.array([0.0, 1.0]) + found * [1.0, -1.0]


def _all(parts, points):
    """Return one array (t, 3, c) of all parts, nan where one has none; None if all have none."""
    some = [part for part in parts if part is not None]
    if not some:
        return None
    width = some[0].shape[2]
    return np.concatenate([
        np.full((len(p), 3, width), np.nan) if part is None else part
        for part, p in zip(parts, points, strict=True)
    ])  # fmt: skip


def _check_required(document):
    unknown = [name for name in document.required if name not in KNOWN | HARMLESS]
    if unknown:
        text = f"needs {', '.join(unknown)}, which is not read: export the scene without"
        raise SceneError(document.source, [text])


def _notes(document, shapes, materials, images, hidden, unseen):
    """Yield what was decided and what is not modelled, once a kind with a count."""
    for text, named in materials.notes.items():
        listed = ", ".join(list(named)[:3]) + (", ..." if len(named) > 3 else "")
        yield f"{text} ({len(named)} materials: {listed})"
    for text, count in images.notes.items():
        yield f"{text} ({count} times)"
    counted = {
        "mesh primitives of points or lines, or without positions: left out": shapes.skipped,
        "skinned meshes: in the pose of their joints in the file": shapes.posed,
        "skinned meshes of more than 4 joints a vertex: the first 4 count": shapes.crowded,
        "meshes outside of the scene that is shown: left out": unseen,
        "meshes with morph targets: moved by the weights in the file": shapes.morphed,
        "nodes that are not visible: left out": hidden,
        "animations: not modelled, things stand as the file has them": len(
            document.listed("animations")
        ),
    }
    yield from (f"{text} ({count})" for text, count in counted.items() if count)
    told = " ".join(materials.notes) + " ".join(images.notes)
    others = [n for n in document.used if n not in KNOWN and n not in told]
    yield from (f"{name}: not modelled" for name in others)
