"""Files that others made: each is loaded, solved and shown, as anybody would who holds one.

usage: foreign.py FOLDER FILE ...

FILEs are scenes, geometry or photometric files; of the last a room is lit. Scenes in which nothing
shines get ambient light. Pictures go to FOLDER.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import radiosity

PHOTOMETRIC = ".ies", ".ldt"
ROOM = """
[[geometry]]
file = "room.obj"
[materials.room]
diffuse = 0.5
[[lights]]
type = "ies"
position = [3, 2, 2.9]
target = [3, 2, 0]
file = "{name}"
[cameras.inside]
position = [3, 0.2, 1.5]
target = [3, 4, 1.4]
fov = 75
"""
BOX = """v 0 0 0
v 6 0 0
v 6 4 0
v 0 4 0
v 0 0 3
v 6 0 3
v 6 4 3
v 0 4 3
usemtl room
f 1 2 3 4
f 8 7 6 5
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
"""


def main(folder: str, files: list[str]) -> None:
    Path(folder).mkdir(parents=True, exist_ok=True)
    print("| file | faces | materials | lights | notes | load s | solve s | reached | picture s |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for file in files:
        try:
            print(row(Path(file), Path(folder)), flush=True)
        except Exception as error:  # the rest is to be seen too
            print(f"| {Path(file).name} | {type(error).__name__}: {str(error)[:200]} |", flush=True)


def row(path: Path, folder: Path) -> str:
    """Load, solve and show a file; return its line of the table."""
    took = []

    def timed(work):
        begun = time.perf_counter()
        found = work()
        took.append(f"{time.perf_counter() - begun:.2f}")
        return found

    scene = timed(lambda: radiosity.load(in_a_room(path, folder)))
    dark = not scene.has_light
    if dark:
        scene = replace(scene, ambient=np.ones(scene.bands.count))
    solution = timed(lambda: radiosity.solve(scene, 0.1))
    image = timed(lambda: radiosity.render(solution, size=(192, 144)))
    radiosity.write(image, folder / f"{path.parent.name}-{path.stem}.png")
    lights = "ambient" if dark else len(scene.lights) + sum(m.emits for m in scene.materials)
    cells = (
        path.name, len(scene.faces), len(scene.materials), lights, len(scene.notes), took[0],
        took[1], f"{100 * solution.estimate.reached:.2g} %", took[2],
    )  # fmt: skip
    return f"| {' | '.join(map(str, cells))} |"


def in_a_room(path: Path, folder: Path) -> Path:
    """Return a file, or a scene of a room that it lights, where it is photometric."""
    if path.suffix.lower() not in PHOTOMETRIC:
        return path
    (folder / "room.obj").write_text(BOX)
    (folder / path.name).write_bytes(path.read_bytes())
    scene = folder / f"{path.stem}.toml"
    scene.write_text(ROOM.format(name=path.name))
    return scene


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])
