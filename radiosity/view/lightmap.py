"""Lightmaps: irradiance on a square of texels, and a glTF model that shows it.

Texels hold what points on the surfaces receive, gathered there as `Solution.irradiance` does, so
shadows are as sharp as the texels, whatever the mesh.
"""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from radiosity.mesh.patches import reversed_winding
from radiosity.solve.solution import Solution
from radiosity.solve.system import side_reflectance
from radiosity.transport.files import written_whole
from radiosity.transport.threads import Progress, silent
from radiosity.view.baked import COLOURS, add_groups, add_materials, finish, shown_colours
from radiosity.view.gltf import Document, to_gltf
from radiosity.view.image import Image, tone_map, write
from radiosity.view.polydata import NONE, patches_at
from radiosity.view.shading import auto_exposure
from radiosity.view.unwrap import Layout, check_size, unwrap

POINTS_AT_ONCE = 1 << 14
LINEAR, CLAMP = 9729, 33071  # OpenGL's names: filter between texels, stop at the border


@dataclass(frozen=True)
class Lightmap:
    """Irradiance of surfaces, laid out flat.

    Attributes
    ----------
    layout : Layout
        Of the sides of faces that can be seen lit.
    face : (n,) int
        The scene's face that each polygon of the layout is.
    irradiance : (N, N, 3) float32
        W/m2, linear sRGB, rows from the top; no texel is empty, see `make_lightmap`.
    colours : (N, N, 3) float32
        Linear display values in [0, 1]: exposure times radiance.
    exposure : float
    """

    layout: Layout
    face: np.ndarray
    irradiance: np.ndarray
    colours: np.ndarray
    exposure: float


def make_lightmap(solution: Solution, size: int, progress: Progress = silent) -> Lightmap:
    """Gather a solution's irradiance at the texels of size x size that lie on a surface.

    The fronts of all faces are laid out, and the backs that light reaches; fronts that it does not
    reach are left out where it reaches their backs. Texels beside surfaces, and those that another
    face covers, take the value of the nearest one that sees light, so that nothing leaks in.

    Raises
    ------
    ValueError
        For a size out of range, or that is too small for so many surfaces.
    """
    check_size(size)
    face, back = _sides(solution)
    faces = solution.scene.faces
    corners = faces.vertices[face]
    corners[back] = reversed_winding(corners[back])
    normals = np.where(back[:, None], -1.0, 1.0) * faces.normals()[face]
    kind = 2 * (faces.group[face] * len(solution.scene.materials) + faces.material[face]) + back
    layout = unwrap(corners, normals, kind, size)
    texel, side, points = layout.texels()
    patch = patches_at(solution, face[side], back[side], points)
    lit = patch != NONE
    dark = np.isin(side, np.setdiff1d(np.arange(len(face)), side[lit]))  # all of it is
    e = np.zeros((size * size, 3), np.float32)
    colours, exposure = np.zeros_like(e), auto_exposure(solution)
    found = _gathered(solution, points[lit], normals[side[lit]], patch[lit], exposure, progress)
    e[texel[lit]], colours[texel[lit]] = found
    known = np.zeros(size * size, bool)
    known[texel[lit | dark]] = True
    nearest = _nearest(known.reshape(size, size))
    shape = size, size, 3
    return Lightmap(layout, face, e[nearest].reshape(shape), colours[nearest].reshape(shape),
                    exposure)  # fmt: skip


def save_lightmap(solution: Solution, path: Path, size: int, progress: Progress = silent) -> None:
    """Write a model with a lightmap, and the lightmap beside it: all of the files, or none.

    OUT-lightmap.exr holds the irradiance in W/m2. OUT-lightmap.png holds what surfaces look like
    by it, exposure times radiance in sRGB, and is what the model shows through TEXCOORD_1, which
    TEXCOORD_0 equals.
    """
    import imageio.v3

    places = path, *beside(path)
    with ExitStack() as files:
        glb, exr, png = (files.enter_context(written_whole(p)) for p in places)
        found = make_lightmap(solution, size, progress)
        write(Image(found.irradiance), exr)
        picture = imageio.v3.imwrite("<bytes>", tone_map(found.colours, 1.0), extension=".png")
        png.write_bytes(picture)
        _write_model(found, solution, picture, places[1].name, glb)


def beside(path: Path) -> tuple[Path, Path]:
    """Return the files that hold the lightmap of a model, ``.exr`` and ``.png``."""
    exr, png = (path.with_name(f"{path.stem}-lightmap{suffix}") for suffix in (".exr", ".png"))
    return exr, png


def _write_model(found, solution, picture, exr_name, path):
    document, scene, layout = Document(), solution.scene, found.layout
    image = document.picture(picture, "lightmap")
    document.add("samplers", magFilter=LINEAR, minFilter=LINEAR, wrapS=CLAMP, wrapT=CLAMP)
    shown = {"index": document.add("textures", source=image, sampler=0), "texCoord": 1}
    materials = add_materials(document, scene, baseColorTexture=shown)
    corners, face = to_gltf(scene, layout.corners), found.face[layout.polygon]

    def primitive(mine):
        corner = np.concatenate([corners[mine], layout.uv[mine]], axis=2).astype(np.float32)
        rows, index = np.unique(corner.reshape(-1, 5), axis=0, return_inverse=True)
        uv = document.vertices(rows[:, 3:])
        return {
            "attributes": {
                "POSITION": document.vertices(rows[:, :3], bounds=True),
                "TEXCOORD_0": uv,
                "TEXCOORD_1": uv,
            },
            "indices": document.indices(index.ravel()),
            "material": materials[scene.faces.material[face[mine[0]]]],
        }

    add_groups(document, solution, face, primitive)
    told = {"colours": COLOURS, "exposure": found.exposure, "lightmap": exr_name}
    finish(document, solution, told)
    document.write(path)


def _sides(solution):
    """Return the face (n,) and whether it is the back (n,) of each side to lay out."""
    patches, faces = solution.patches, solution.scene.faces
    front = patches.front.copy()
    front[: patches.fronts] = ~patches.covered
    bare, lit, back = np.zeros((3, len(faces)), bool)
    bare[patches.face[front]] = True
    lit[patches.face[front & solution.live]] = True
    back[patches.face[~patches.front & solution.live]] = True
    first, second = np.flatnonzero(bare & (lit | ~back)), np.flatnonzero(back)
    return np.concatenate([first, second]), np.arange(len(first) + len(second)) >= len(first)


def _gathered(solution, points, normals, patch, exposure, progress):
    """Return irradiance in W/m2 and display values (k, 3) at points, linear sRGB."""
    scene, patches = solution.scene, solution.patches
    rest = solution.radiosity - solution.reflectance * solution.irradiance_on
    rho = side_reflectance(scene)[(~patches.front).astype(int), scene.faces.material[patches.face]]
    irradiance, colours = np.empty((2, len(points), 3), np.float32)
    for a in range(0, len(points), POINTS_AT_ONCE):
        some = slice(a, a + POINTS_AT_ONCE)
        e = solution.level.gathered(points[some], normals[some]).total
        e = np.maximum(e, 0.0)  # in deep shadow linear elements may fall below
        irradiance[some] = scene.bands.to_rgb(e)
        sent = rest[patch[some]] + rho[patch[some]] * e
        colours[some] = shown_colours(solution, sent, exposure)
        progress("lightmap", min(a + POINTS_AT_ONCE, len(points)), len(points))
    return irradiance, colours


def _nearest(known):
    """Return (N N,) for each texel the nearest ``known`` one."""
    from scipy.ndimage import distance_transform_edt

    at = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return (at[0] * len(known) + at[1]).ravel()
