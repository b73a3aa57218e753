"""The nodes of a glTF scene: where things are, and the lights and cameras among them."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.photometry import EFFICACY
from radiosity.scene.geometry import LONGEST
from radiosity.scene.gltf.buffers import Buffers
from radiosity.scene.gltf.document import Document, Entry, Names
from radiosity.scene.lights import NARROWEST
from radiosity.scene.schema import BRIGHTEST, LARGEST_PICTURE

HEIGHT = 512  # pixels of a camera's picture; its width follows from the aspect ratio
LIGHTS = "KHR_lights_punctual"
INSTANCES = "EXT_mesh_gpu_instancing"
VISIBLE = "KHR_node_visibility"
MOST_PLACES = 1 << 20  # of one mesh


@dataclass(frozen=True)
class Node:
    """A node of the scene: its table and its matrix (4, 4) to the scene, acting on columns."""

    entry: Entry
    matrix: np.ndarray

    @property
    def number(self) -> int:
        """Return its index in the file."""
        return self.entry.path[-1]

    def name(self, fallback: str = "") -> str:
        """Return what it is called."""
        return self.entry.name(fallback or f"node-{self.number + 1}")

    def axis(self, column: int) -> np.ndarray | None:
        """Return one of its axes as a unit vector, None where its scale is 0."""
        way = self.matrix[:3, column]
        length = np.linalg.norm(way)
        return way / length if length > 0 else None


def placed_nodes(document: Document) -> tuple[list[Node], int]:
    """Return the nodes of the file's scene in the order of the file, and how many are hidden.

    Raises
    ------
    SceneError
        A node that is met twice: the tree has a circle, or two parents share a child.
    """
    found, met, hidden = [], set(), 0
    waiting = [(*root, np.eye(4)) for root in reversed(_roots(document))]
    while waiting:
        entry, key, number, outer = waiting.pop()
        if number in met:
            entry.fail(key, f"names nodes[{number}] a second time: nodes must form a tree")
        met.add(number)
        node = document.numbered(entry, key, number, "nodes")
        if node.extension(VISIBLE).value.get("visible") is False:
            hidden += 1
            continue
        with np.errstate(all="ignore"):  # what is not finite is told below
            matrix = outer @ _local(node)
        if not (np.abs(matrix) <= LONGEST).all():
            node.fail("matrix", f"takes things farther away than {LONGEST:g} m")
        found.append(Node(node, matrix))
        children = node.wholes("children")
        waiting += [(node, "children", child, matrix) for child in reversed(children)]
    return found, hidden


def _roots(document) -> list[tuple[Entry, str, int]]:
    """Return the roots of the default scene, or of all trees where there are no scenes."""
    scenes = document.listed("scenes")
    if scenes:
        scene = document.numbered(document.top, "scene", document.top.whole("scene", 0), "scenes")
        return [(scene, "nodes", number) for number in scene.wholes("nodes")]
    nodes = document.listed("nodes")
    children = {child for node in nodes for child in node.wholes("children")}
    return [(document.top, "nodes", k) for k in range(len(nodes)) if k not in children]


def _local(node) -> np.ndarray:
    """Return the matrix (4, 4) of a node within its parent."""
    if not node.has("matrix"):
        parts = (
            np.array([node.numbers("translation", (0.0,) * 3)]),
            np.array([node.numbers("rotation", (0.0, 0.0, 0.0, 1.0))]),
            np.array([node.numbers("scale", (1.0,) * 3)]),
        )
        return composed(*parts)[0]
    matrix = np.array(node.numbers("matrix", tuple(np.eye(4).ravel()))).reshape(4, 4).T
    if np.abs(matrix[3] - [0, 0, 0, 1]).max() > 1e-6:
        node.fail("matrix", "must keep planes planar: its last row must be 0, 0, 0, 1")
    return matrix


def composed(translation, rotation, scale) -> np.ndarray:
    """Return matrices (n, 4, 4) that scale, then turn by quaternions (n, 4) xyzw, then move."""
    length = np.linalg.norm(rotation, axis=1, keepdims=True)
    none = np.array([0.0, 0, 0, 1])
    x, y, z, w = np.where(length > 0, rotation / np.where(length > 0, length, 1.0), none).T
    matrix = np.zeros((len(x), 4, 4))
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    matrix[:, :3, :3] = np.moveaxis(np.array(rows), -1, 0)
    matrix[:, :3, :3] *= np.asarray(scale, float)[:, None]
    matrix[:, :3, 3], matrix[:, 3, 3] = translation, 1.0
    return matrix


def places_of(node: Node, buffers: Buffers) -> np.ndarray:
    """Return the matrices (n, 4, 4) at which the mesh of a node stands, several where instanced."""
    if not node.entry.extended(INSTANCES):
        return node.matrix[None]
    table = node.entry.extension(INSTANCES).child("attributes")
    given = {
        key: buffers.array(table, key, (shape,))
        for key, shape in (("TRANSLATION", "VEC3"), ("ROTATION", "VEC4"), ("SCALE", "VEC3"))
    }
    counts = {len(values) for values in given.values() if values is not None}
    if len(counts) != 1 or max(counts) > MOST_PLACES:
        text = f"must list TRANSLATION, ROTATION or SCALE, all of 1 to {MOST_PLACES} places"
        node.entry.extension(INSTANCES).fail("attributes", text)
    count = counts.pop()
    usual = {"TRANSLATION": (0, 0, 0), "ROTATION": (0, 0, 0, 1), "SCALE": (1, 1, 1)}
    parts = [
        np.broadcast_to(usual[key], (count, len(usual[key]))) if values is None else values
        for key, values in given.items()
    ]
    return node.matrix @ composed(*(np.asarray(part, float) for part in parts))


def cameras_of(nodes: list[Node], document: Document, notes: list[str]) -> dict[str, dict]:
    """Return the tables ``[cameras.NAME]`` of the cameras that nodes have; add to the notes."""
    found, names, flat = {}, Names(), 0
    for node in nodes:
        camera = document.referred(node.entry, "camera", "cameras")
        back, up = node.axis(2), node.axis(1)
        if camera is None:
            continue
        if back is None or up is None or np.linalg.norm(np.cross(back, up)) < 1e-3:
            flat += 1
            continue
        name = names.free(node.entry.name(camera.name(f"camera-{camera.path[-1] + 1}")))
        position = node.matrix[:3, 3]
        table = {
            "position": position.tolist(),
            "target": (position - back * _step(position)).tolist(),
            "up": up.tolist(),
        }
        found[name] = table | _projection(camera)
    if flat:
        notes.append(f"cameras of nodes that are flattened: left out ({flat})")
    return found


def _projection(camera) -> dict:
    """Return what a camera sees: keys of a table ``[cameras.NAME]``."""
    kind = camera.text("type")
    if kind == "perspective":
        lens = camera.child(kind)
        if not lens.has("yfov"):
            lens.fail("yfov", "is the vertical angle that the camera sees, in radians")
        fov = np.degrees(lens.number("yfov", 0.0, 1e-6, 3.14159))
        return {"fov": float(fov), "size": _size(lens.number("aspectRatio", 1.0, 1e-9, 1e9))}
    if kind == "orthographic":
        lens = camera.child(kind)
        wide, high = (abs(lens.number(key, 1.0, -1e29, 1e29)) for key in ("xmag", "ymag"))
        if not (wide > 0 and high > 0):
            lens.fail("ymag" if wide > 0 else "xmag", "must not be 0: it is half of what is shown")
        table = {"projection": "orthographic", "height": 2.0 * high}
        return table | {"size": _size(min(wide / high, 1e9))}
    camera.fail("type", 'must be "perspective" or "orthographic"')


def _size(aspect) -> list[int]:
    return [int(np.clip(round(HEIGHT * aspect), 1, LARGEST_PICTURE)), HEIGHT]


def _step(position) -> float:
    """Return a length that is not lost in rounding when it is added to a position."""
    return float(max(1.0, 1e-6 * np.abs(position).max()))


def lights_of(nodes: list[Node], document: Document, notes: list[str]) -> list[dict]:
    """Return the tables ``[[lights]]`` of the lights that nodes have."""
    found, ranged = [], 0
    for node in nodes:
        if not node.entry.extended(LIGHTS):
            continue
        table = node.entry.extension(LIGHTS)
        known, number = document.top.extension(LIGHTS).tables("lights"), table.whole("light")
        if number >= len(known):
            table.fail("light", f"names light {number}, there are {len(known)}, counted from 0")
        light = _light(known[number], node)
        ranged += known[number].has("range")
        found += [light | {"group": node.name(known[number].name(""))}] if light else []
        if not light:
            notes.append(f'light "{node.name()}": has no direction, as its node\'s scale is 0')
    if ranged:
        notes.append(f"{ranged} lights have a range, which is ignored: light fades as 1/d^2 only")
    return found


def _light(light, node) -> dict | None:
    """Return the table of a light that shines along -z of its node."""
    colour = np.array(light.numbers("color", (1.0,) * 3, 0.0, 1e6))
    kind = light.text("type")
    strength = (colour * (light.number("intensity", 1.0, 0.0, BRIGHTEST / 1e6) / EFFICACY)).tolist()
    back, position = node.axis(2), node.matrix[:3, 3]
    if kind == "point":
        return {"type": "point", "position": position.tolist(), "intensity": strength}
    if kind not in ("spot", "directional"):
        light.fail("type", 'must be "point", "spot" or "directional"')
    if back is None:
        return None
    if kind == "directional":
        return {"type": kind, "direction": (-back).tolist(), "irradiance": strength}
    cone = light.child("spot")
    outer = np.degrees(cone.number("outerConeAngle", np.pi / 4, 0.0, np.pi / 2 + 1e-6))
    outer = float(np.clip(outer, NARROWEST, 90.0))
    inner = np.degrees(cone.number("innerConeAngle", 0.0, 0.0, np.pi / 2 + 1e-6))
    return {
        "type": "spot", "position": position.tolist(),
        "target": (position - back * _step(position)).tolist(), "intensity": strength,
        "beam_angle": float(min(inner, outer)), "cutoff_angle": outer,
    }  # fmt: skip
