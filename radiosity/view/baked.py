"""A solution as a glTF model that shows its light in any viewer, baked into vertex colours."""

from pathlib import Path

import numpy as np

from radiosity.light.colour import in_gamut
from radiosity.scene.model import Scene
from radiosity.solve.solution import Solution
from radiosity.view.gltf import Document, add_cameras, to_gltf
from radiosity.view.polydata import corner_radiosity, shown_patches
from radiosity.view.shading import auto_exposure

UNLIT = "KHR_materials_unlit"
COLOURS = "exposure times radiance in W/(m2 sr), sRGB, clipped to [0, 1]"


def write_baked(solution: Solution, path: Path) -> None:
    """Write a ``.glb`` with vertex colours, smooth across patches.

    COLOR_0 = exposure B/pi in linear sRGB, cut to [0, 1], with the exposure of pictures. A mesh a
    group, in it a primitive a material; fronts, and backs that light reaches, as in `to_pyvista`.
    """
    scene, shown = solution.scene, shown_patches(solution)
    exposure = auto_exposure(solution)
    colours = shown_colours(solution, corner_radiosity(solution)[shown], exposure)
    vertices = to_gltf(scene, solution.patches.vertices[shown])
    document, face = Document(), solution.patches.face[shown]
    materials = add_materials(document, scene)

    def primitive(mine):
        corner = np.concatenate([vertices[mine], colours[mine]], axis=2).astype(np.float32)
        triangles = _triangles(corner)
        rows, index = np.unique(triangles.reshape(-1, 6), axis=0, return_inverse=True)
        return {
            "attributes": {
                "POSITION": document.vertices(rows[:, :3], bounds=True),
                "COLOR_0": document.vertices(rows[:, 3:]),
            },
            "indices": document.indices(index.ravel()),
            "material": materials[scene.faces.material[face[mine[0]]]],
        }

    add_groups(document, solution, face, primitive)
    finish(document, solution, {"colours": COLOURS, "exposure": exposure})
    document.write(path)


def shown_colours(solution: Solution, radiosity: np.ndarray, exposure: float) -> np.ndarray:
    """Return display values (..., 3) in [0, 1], linear sRGB, of radiosities (..., bands)."""
    rgb = solution.scene.bands.to_rgb(radiosity) * (exposure / np.pi)
    return np.clip(in_gamut(rgb), 0.0, 1.0)


def add_materials(document: Document, scene: Scene, **shown) -> list[int]:
    """Add the scene's materials as ones that viewers show as they are; return their numbers.

    ``shown`` goes into each, such as a texture.
    """
    return [
        document.add("materials", name=m.name, extensions={UNLIT: {}},
                     pbrMetallicRoughness={"metallicFactor": 0.0, **shown})
        for m in scene.materials
    ]  # fmt: skip


def add_groups(document: Document, solution: Solution, face: np.ndarray, primitive) -> None:
    """Add a mesh and its node for each group that has cells.

    ``face`` (n,) is the scene's face of each cell; ``primitive`` makes one of cells (k,) of one
    group and material.
    """
    scene = solution.scene
    group, material = scene.faces.group[face], scene.faces.material[face]
    order = np.lexsort((material, group))  # in the cells' own order within each
    for g, mine in zip(*_runs(group[order], order), strict=True):
        parts = [primitive(cells) for cells in _runs(material[mine], mine)[1]]
        mesh = document.add("meshes", name=scene.groups[g], primitives=parts)
        document.add("nodes", name=scene.groups[g], mesh=mesh)


def _runs(values, items):
    """Return the different of sorted values, and for each its items."""
    found, start = np.unique(values, return_index=True)
    return found, np.split(items, start[1:])


def finish(document: Document, solution: Solution, extras: dict) -> None:
    """Add the cameras, and the scene with all nodes and with what its numbers mean."""
    scene = solution.scene
    add_cameras(document, scene)
    document.tree["extensionsUsed"] = [UNLIT]
    nodes = list(range(len(document.tree.get("nodes", ()))))
    told = extras | {"unit": "m", "scene_unit": scene.unit, "scene_up": scene.up}
    document.add("scenes", name=scene.name, extras=told, **({"nodes": nodes} if nodes else {}))
    document.tree["scene"] = 0


def _triangles(corner):
    """Return (t, 3, 6) triangles of quadrilaterals (n, 4, 6) of places and colours.

    Cut along the diagonal whose ends look more alike, so that edges of shadows do not fray.
    """
    triangle = np.all(corner[:, 3, :3] == corner[:, 2, :3], axis=1)
    lightness = corner[:, :, 3:].sum(axis=2)
    other = np.abs(lightness[:, 1] - lightness[:, 3]) < np.abs(lightness[:, 0] - lightness[:, 2])
    first = np.where((other & ~triangle)[:, None, None], corner[:, [0, 1, 3]], corner[:, :3])
    second = np.where(other[:, None, None], corner[:, [1, 2, 3]], corner[:, [0, 2, 3]])
    return np.concatenate([first, second[~triangle]])
