"""Rooms that benchmarks share: small ones in code, and one furnished with many triangles."""

from dataclasses import replace
from pathlib import Path

import numpy as np

import radiosity
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Material, Scene

CORNELL = Path(__file__).resolve().parent.parent / "scenes" / "cornell_box.toml"


def box(low, high):
    """Return the faces (6, 4, 3) of a room seen from inside: floor, ceiling, x0, x1, y0, y1."""
    (x, y, z), (a, b, c) = low, high
    return np.array([
        [[x, y, z], [a, y, z], [a, b, z], [x, b, z]], [[x, y, c], [x, b, c], [a, b, c], [a, y, c]],
        [[x, y, z], [x, b, z], [x, b, c], [x, y, c]], [[a, y, z], [a, y, c], [a, b, c], [a, b, z]],
        [[x, y, z], [x, y, c], [a, y, c], [a, y, z]], [[x, b, z], [a, b, z], [a, b, c], [x, b, c]],
    ], float)  # fmt: skip


def block(low, high):
    """Return the sides and the top of a solid box, seen from outside."""
    return box(low, high)[1:, ::-1]


def material(name, reflectance, radiance=0.0):
    rho = np.full(3, float(reflectance))
    return Material(name, rho, 1 - rho, np.full(3, float(radiance)))


def scene(name, parts, reflectance, radiance):
    """Return a scene of parts (k, 4, 3), a reflectance and a radiance for each."""
    kind = np.repeat(np.arange(len(parts)), [len(p) for p in parts])
    faces = Faces.from_polygons(np.concatenate(parts), kind, 0, merge=False)
    materials = tuple(
        material(str(k), r, m) for k, (r, m) in enumerate(zip(reflectance, radiance, strict=True))
    )
    return Scene(name, faces, materials, ("all",))


def lamp(low, high, z):
    (x, y), (a, b) = low, high
    return np.array([[[x, y, z], [x, b, z], [a, b, z], [a, y, z]]], float)


def bright_box():
    walls = box((0, 0, 0), (4, 3, 2.5))
    return scene("box", [walls[[k]] for k in range(6)], [0.2, 0.7, 0.5, 0.3, 0.6, 0.4],
                 [0, 1, 0, 0, 0, 0.3])  # fmt: skip


def two_rooms():
    """A wall with a door between them, a lamp in one."""
    wall = np.array([[[2, 0, 0], [2, 1.2, 0], [2, 1.2, 2.5], [2, 0, 2.5]],
                     [[2, 1.8, 0], [2, 3, 0], [2, 3, 2.5], [2, 1.8, 2.5]]])  # fmt: skip
    parts = [box((0, 0, 0), (4, 3, 2.5)), wall, lamp((0.5, 0.5), (1, 1), 2.5)]
    return scene("two rooms", parts, [0.7, 0.6, 0.0], [0, 0, 5])


def table():
    """A table with four legs under a hanging lamp."""
    legs = [block((x, y, 0), (x + 0.08, y + 0.08, 0.7)) for x in (1.02, 2.4) for y in (1.02, 1.9)]
    top = box((1, 1, 0.7), (2.5, 2, 0.75))[:, ::-1]
    parts = [box((0, 0, 0), (4, 3, 2.5)), lamp((1, 1), (2.5, 1.3), 2.2), top, *legs]
    return scene("table", parts, [0.6, 0.0, *[0.6] * 5], [0, 8, *[0] * 5])


def cut(whole: Scene) -> Scene:
    """Return the same scene of quadrilaterals as triangles."""
    faces = whole.faces
    halves = faces.vertices[:, [[0, 1, 2, 2], [0, 2, 3, 3]]].reshape(-1, 4, 3)
    twice = (np.repeat(x, 2) for x in (faces.material, faces.group))
    return replace(whole, faces=Faces.from_polygons(halves, *twice, merge=False))


SCENES = {
    "cornell_box": lambda: radiosity.load(CORNELL), "box": bright_box, "two rooms": two_rooms,
    "table": table, "two rooms, triangles": lambda: cut(two_rooms()),
}  # fmt: skip


def furnished(triangles: int, seed: int = 0) -> Scene:
    """Return a room with four lamps and 24 ellipsoids of about so many triangles in all."""
    rng = np.random.default_rng(seed)
    lamps = [lamp((x, y), (x + 0.6, y + 0.6), 2.99) for x in (1, 4) for y in (1, 3.4)]
    things = [_ellipsoid(rng, triangles // 24) for _ in range(24)]
    parts = [box((0, 0, 0), (6, 5, 3)), np.concatenate(lamps), np.concatenate(things)]
    return scene("furnished", parts, [0.7, 0.0, 0.5], [0, 10, 0])


def _ellipsoid(rng, triangles):
    rings = max(2, int(np.sqrt(triangles / 4)))
    u, v = np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1)
    centre = rng.uniform([0.6, 0.6, 0.4], [5.4, 4.4, 2.3])
    s, t = np.meshgrid(u, v, indexing="ij")
    ball = np.stack([np.sin(s) * np.cos(t), np.sin(s) * np.sin(t), np.cos(s)], axis=-1)
    x = centre + rng.uniform(0.15, 0.38, 3) * ball
    a, b, c, d = x[:-1, :-1], x[1:, :-1], x[1:, 1:], x[:-1, 1:]
    halves = [np.stack(k, axis=2).reshape(-1, 4, 3) for k in ((a, b, c, c), (a, c, d, d))]
    return np.concatenate(halves)
