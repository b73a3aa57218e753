"""Make what stands in ``museum.toml`` and ``living_room.toml``: OBJ files of boxes and panels.

    python scenes/furnished.py [-o FOLDER]

Lengths are in metres, z is up, faces are counter-clockwise seen from the front.
"""

import argparse
from collections.abc import Iterable
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
Mesh = list[tuple[str, np.ndarray]]  # the material and the (4, 3) corners of each face

BOOKS = [("red", 0.06, 0.3), ("white", 0.09, 0.26), ("blue", 0.07, 0.33), ("yellow", 0.05, 0.24)]
CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
SIDES = {
    "-x": (0, 4, 6, 2), "+x": (1, 3, 7, 5), "-y": (0, 1, 5, 4),
    "+y": (2, 6, 7, 3), "-z": (0, 2, 3, 1), "+z": (4, 5, 7, 6),
}  # fmt: skip


def box(material: str, low, high, sides: Iterable[str] = SIDES, turn: float = 0.0) -> Mesh:
    """Return some sides of a box, turned by degrees about the vertical through its middle."""
    low, high = np.array(low, float), np.array(high, float)
    corners, middle = low + CORNERS * (high - low), 0.5 * (low + high)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    corners = middle + (corners - middle) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return [(material, corners[list(SIDES[side])]) for side in sides]


def inside(low, high, **materials: str) -> Mesh:
    """Return the sides of a box seen from inside: those of ``floor``, ``ceiling``, ``west`` etc."""
    names = {
        "west": "-x", "east": "+x", "south": "-y", "north": "+y", "floor": "-z", "ceiling": "+z",
    }  # fmt: skip
    return [
        (material, box(material, low, high, [names[name]])[0][1][::-1])
        for name, material in materials.items()
    ]


def painting(
    fields: list[str], columns, rows, width: float, height: float, place, wall: str
) -> Mesh:
    """Return a canvas 4 cm thick, its front a grid of coloured fields between black bars.

    ``fields`` go row by row from below, ``columns`` and ``rows`` are the shares of width and
    height; ``place`` is the middle of its back, on the ``north`` or the ``west`` wall.
    """
    x, z = (np.concatenate([[0], np.cumsum(part) / np.sum(part)]) - 0.5 for part in (columns, rows))
    x, z, depth, bar = x * width, z * height, 0.04, 0.012
    flat: Mesh = []
    for k, name in enumerate(fields):
        i, j = k % len(columns), k // len(columns)
        low, high = [x[i] + bar, -depth, z[j] + bar], [x[i + 1] - bar, -depth, z[j + 1] - bar]
        flat += box(name, low, high, ["-y"])
    for i in range(len(columns) + 1):
        left, right = max(x[i] - bar, x[0]), min(x[i] + bar, x[-1])
        flat += box("black", [left, -depth, z[0]], [right, -depth, z[-1]], ["-y"])
    for j in range(len(rows) + 1):
        below, above = max(z[j] - bar, z[0]), min(z[j] + bar, z[-1])
        for i in range(len(columns)):
            left, right = x[i] + bar, x[i + 1] - bar
            flat += box("black", [left, -depth, below], [right, -depth, above], ["-y"])
    edges = ["-x", "+x", "-z", "+z"]
    flat += box("black", [x[0], -depth, z[0]], [x[-1], 0, z[-1]], edges)
    if wall == "west":  # a quarter turn: what looked to -y looks to +x
        flat = [(m, c @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])) for m, c in flat]
    return [(m, c + np.array(place, float)) for m, c in flat]


def museum() -> Mesh:
    """Return a gallery of 8 x 6 x 3.6 m with five paintings, a bench and a plinth."""
    mesh = inside([0, 0, 0], [8, 6, 3.6], floor="oak", ceiling="ceiling", west="wall", east="wall",
                  south="wall", north="wall")  # fmt: skip
    mesh += painting(["white", "blue", "white", "red", "white", "yellow"], [3, 2], [1, 2, 1.5],
                     1.2, 1.5, [1.6, 6, 1.65], "north")  # fmt: skip
    mesh += painting(["yellow", *3 * ["white"], "red", "blue", *3 * ["white"]],
                     [1, 3, 1], [1, 3, 1], 1.5, 1.5, [4.0, 6, 1.65], "north")  # fmt: skip
    mesh += painting(["red", "white", "white", "blue", "yellow", "white"], [1, 2], [2, 1, 1],
                     1.2, 1.5, [6.4, 6, 1.65], "north")  # fmt: skip
    mesh += painting(["blue", "white", "yellow", "red"], [2, 1], [1, 2], 1.3, 1.3,
                     [0, 4.4, 1.65], "west")  # fmt: skip
    mesh += painting(["white", "red", "blue", "white"], [1, 2], [2, 1], 1.3, 1.3,
                     [0, 2.2, 1.65], "west")  # fmt: skip
    mesh += box("leather", [3.1, 2.6, 0.36], [4.9, 3.2, 0.46])
    for x in (3.3, 4.55):
        mesh += box("black", [x, 2.7, 0], [x + 0.15, 3.1, 0.36], ["-x", "+x", "-y", "+y"])
    mesh += box("white", [6.35, 3.35, 0], [6.75, 3.75, 1.05], turn=20)
    mesh += box("bronze", [6.42, 3.42, 1.05], [6.68, 3.68, 1.31], turn=55)
    return mesh


def living_room() -> Mesh:
    """Return a room of 5 x 4 x 2.6 m with a window of 2.4 x 1.5 m in the wall on the left."""
    mesh = inside([0, 0, 0], [5, 4, 2.6], floor="oak", ceiling="ceiling", east="wall",
                  south="wall", north="sage")  # fmt: skip
    mesh += window_wall([1.0, 0.7], [3.4, 2.2], 4.0, 2.6, 0.3)
    mesh += box("rug", [1.5, 1.1, 0.0], [3.9, 2.75, 0.015], ["-x", "+x", "-y", "+y", "+z"])
    mesh += sofa()
    mesh += table([2.05, 1.55, 0.015], [3.25, 2.15, 0.42])
    mesh += box("red", [2.3, 1.75, 0.42], [2.55, 1.93, 0.45], turn=15)
    mesh += box("blue", [2.31, 1.76, 0.45], [2.52, 1.92, 0.475], turn=-5)
    mesh += box("white", [2.85, 1.83, 0.42], [2.95, 1.93, 0.6])
    mesh += shelf()
    mesh += painting(["yellow", "white", "red", "blue"], [2, 1], [1, 2],
                     0.9, 0.7, [2.2, 4, 1.6], "north")  # fmt: skip
    return mesh


def window_wall(low, high, length: float, height: float, thick: float) -> Mesh:
    """Return the wall x = 0 round an opening from ``low`` to ``high`` (y, z), reveal and frame."""
    (y0, z0), (y1, z1) = low, high
    panes = [((0, 0), (length, z0)), ((0, z1), (length, height)),
             ((0, z0), (y0, z1)), ((y1, z0), (length, z1))]  # fmt: skip
    mesh: Mesh = []
    for (a, b), (c, d) in panes:
        mesh += box("wall", [0, a, b], [0, c, d], ["+x"])
    opening = box("wall", [-thick, y0, z0], [0, y1, z1], ["-y", "+y", "-z", "+z"])
    mesh += [(m, corners[::-1]) for m, corners in opening]
    bar = 0.05
    for y in (y0, 0.5 * (y0 + y1 - bar), y1 - bar):
        mesh += box("white", [-0.2, y, z0], [-0.15, y + bar, z1], ["-x", "+x", "-y", "+y"])
    return mesh


def sofa() -> Mesh:
    """Return a sofa along the wall at the back: seat, back, arms and two cushions."""
    mesh = box("cloth", [1.3, 3.05, 0.1], [3.5, 3.9, 0.42])
    mesh += box("cloth", [1.3, 3.68, 0.42], [3.5, 3.9, 0.82])
    for x in (1.1, 3.5):
        mesh += box("cloth", [x, 3.05, 0.1], [x + 0.2, 3.9, 0.6])
    mesh += box("yellow", [1.45, 3.5, 0.42], [1.85, 3.62, 0.8], turn=-12)
    mesh += box("red", [2.9, 3.48, 0.42], [3.3, 3.6, 0.8], turn=14)
    return mesh


def table(low, high) -> Mesh:
    """Return a table: a top 4 cm thick on four legs."""
    (x0, y0, z0), (x1, y1, z1), leg = low, high, 0.05
    mesh = box("walnut", [x0, y0, z1 - 0.04], [x1, y1, z1])
    for x in (x0 + 0.04, x1 - 0.04 - leg):
        for y in (y0 + 0.04, y1 - 0.04 - leg):
            sides = ["-x", "+x", "-y", "+y"]
            mesh += box("walnut", [x, y, z0], [x + leg, y + leg, z1 - 0.04], sides)
    return mesh


def shelf() -> Mesh:
    """Return a low shelf on the wall at the back, with a row of books and a vase on it."""
    mesh = box("walnut", [3.9, 3.6, 0], [4.9, 4, 0.8], ["-x", "+x", "-y", "+z"])
    x = 3.96
    for colour, thick, tall in BOOKS:
        mesh += box(colour, [x, 3.68, 0.8], [x + thick, 3.9, 0.8 + tall], ["-x", "+x", "-y", "+z"])
        x += thick + 0.004
    return mesh + box("white", [4.58, 3.7, 0.8], [4.72, 3.84, 1.2], turn=30)


def obj(mesh: Mesh) -> str:
    """Return the text of an OBJ file, faces sorted by material."""
    lines = []
    for name in sorted({material for material, _ in mesh}):
        lines.append(f"usemtl {name}")
        for material, corners in mesh:
            if material == name:
                lines += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in corners]
                lines.append("f -4 -3 -2 -1")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=HERE)
    folder = parser.parse_args().output
    (folder / "museum.obj").write_text(obj(museum()))
    (folder / "living_room.obj").write_text(obj(living_room()))
