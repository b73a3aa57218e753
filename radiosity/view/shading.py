"""What the gather needs to know of every patch: how it shines and reflects, and its plane."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from radiosity.solve.solution import Solution
from radiosity.view.image import exposure_for
from radiosity.view.smoothing import MIXED

if TYPE_CHECKING:
    from radiosity.view.detail import Detail


@dataclass(frozen=True)
class Shading:
    """What `radiance` needs to know of every patch: emission, diffuse reflectance, lobe, coats."""

    emission: np.ndarray  # (n, bands) W/(m2 sr)
    diffuse: np.ndarray  # (n, bands)
    lobe: np.ndarray  # (n,) index into lobes and coats, -1 for none
    lobes: tuple  # by material, None for none
    coats: tuple  # by material: what lies on its base and dims it, () for nothing
    plane: np.ndarray  # (n,) 2 * face, + 1 for its back, one face for all in its plane; or MIXED
    plane_diffuse: np.ndarray  # (2 * faces, bands)
    plane_axes: np.ndarray  # (2 * faces, 2, 3)
    detail: "Detail | None" = None  # what varies inside of patches
    through: np.ndarray | None = None  # (n, bands) what comes through, None where nothing does


def make_shading(solution: Solution) -> Shading:
    """Return the optical properties of every patch's active side."""
    scene, patches = solution.scene, solution.patches
    material = scene.faces.material[patches.face]
    lobes = tuple(m.specular for m in scene.materials)
    coats = tuple(m.coats for m in scene.materials)
    plain = [s is None and not c for s, c in zip(lobes, coats, strict=True)]
    lobe = np.where(plain, -1, np.arange(len(lobes)))[material]
    two_sided = np.array([m.two_sided for m in scene.materials])[material]
    reflects = patches.front | two_sided
    diffuse = np.array([m.diffuse for m in scene.materials])[material] * reflects[:, None]
    plane = 2 * _surfaces(scene.faces)[patches.face] + ~patches.front
    plane_diffuse = np.zeros((2 * len(scene.faces), diffuse.shape[1]))
    plane_diffuse[plane] = diffuse
    detail = None
    if _is_detailed(scene):
        from radiosity.view.detail import Detail

        detail = Detail(scene, solution.surroundings.table)
        bumped = np.array([m.bump is not None for m in scene.materials])[material]
        plane = np.where(bumped, MIXED, plane)  # there irradiance varies with the bumps
    return Shading(
        solution.emission / np.pi, diffuse, np.where(reflects, lobe, -1), lobes,
        coats, plane, plane_diffuse, np.repeat(_axes(scene.faces.normals()), 2, axis=0), detail,
        solution.transmittance,
    )  # fmt: skip


def _is_detailed(scene):
    """Whether a face has a texture, bumps or normals at its corners."""
    used = [scene.materials[k] for k in np.unique(scene.faces.material)]
    some = any(m.is_detailed for m in used)
    return some or bool(scene.faces.is_curved.any())


def _surfaces(faces):
    """Return (f,) for each face the first of those in its plane that look and shine as it does."""
    normals, corner = faces.normals(), faces.vertices[:, 0]
    middle = corner.mean(axis=0)
    offset = np.einsum("fc,fc->f", corner - middle, normals) / np.ptp(faces.vertices, (0, 1)).max()
    key = np.round(np.column_stack([normals, offset]) * 1e6)
    _, first, same = np.unique(
        np.column_stack([key, faces.material]), axis=0, return_index=True, return_inverse=True
    )
    return first[same.ravel()]


def _axes(normals):
    """Return (f, 2, 3) two unit vectors at right angles to each normal."""
    other = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    one = np.cross(normals, other)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    return np.stack([one, np.cross(normals, one)], axis=1)


def auto_exposure(solution: Solution) -> float:
    """Return one exposure for all views of a solution, from what its surfaces reflect."""
    reflected = (solution.radiosity - solution.emission) / np.pi
    dark = solution.live & ~solution.emission.any(axis=1)
    if not dark.any():
        reflected, dark = solution.radiosity / np.pi, solution.live
    bright = solution.scene.bands.luminance(np.maximum(reflected[dark], 0))
    return exposure_for(bright, solution.patches.area[dark])
