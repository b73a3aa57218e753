"""Reflectances of patches whose faces have textures: means over each patch."""

from dataclasses import replace

import numpy as np

from radiosity.light.texture import Texture
from radiosity.mesh.corners import affine, between, weights
from radiosity.mesh.faces import Faces
from radiosity.scene.model import Scene
from radiosity.solve.albedo import reflectance_of
from radiosity.transport.lookup import Table, coordinates_at

PARTS = 8  # along each side of a patch whose texture is not laid on evenly


def textured_reflectance(
    scene: Scene, table: Table, face: np.ndarray, polygons: np.ndarray
) -> np.ndarray:
    """Return the reflectances (n, bands) of polygons (n, 4, 3) on textured faces (n,)."""
    material = scene.faces.material[face]
    found = np.empty((len(face), len(scene.materials[0].diffuse)))
    for k in np.unique(material):
        m, mine = scene.materials[k], np.flatnonzero(material == k)
        mean = mean_over(m.texture, scene.faces, table, face[mine], polygons[mine])
        found[mine] = reflectance_of(replace(m, diffuse=mean))
    return found


def mean_over(
    texture: Texture, faces: Faces, table: Table, face: np.ndarray, polygons: np.ndarray
) -> np.ndarray:
    """Return the mean values (n, bands) of a texture over polygons (n, 4, 3) on faces (n,).

    Exact where texture coordinates are affine on a face, as on all triangles; elsewhere of second
    order in the size of a part, of PARTS x PARTS a polygon.
    """
    found = np.empty((len(face), texture.bands))
    even = faces.is_triangle[face] | affine(faces.vertices, faces.uv)[face]
    found[even] = _plainly(texture, faces, table, face[even], polygons[even])
    if not even.all():
        parts, area = _parts(polygons[~even])
        owner = np.repeat(face[~even], PARTS**2)
        value = _plainly(texture, faces, table, owner, parts.reshape(-1, 4, 3))
        value = value.reshape(*area.shape, -1)
        share = area / area.sum(axis=1, keepdims=True)
        found[~even] = np.einsum("np,npb->nb", share, value)
    return found


def _plainly(texture, faces, table, face, polygons):
    """Return the means over polygons, as if coordinates were affine on each."""
    corner = np.repeat(face, 4)
    st = coordinates_at(table, corner, polygons.reshape(-1, 3))
    uv = between(faces.uv[corner], weights(st, faces.is_triangle[corner]))
    return texture.mean_over(uv.reshape(-1, 4, 2))


def _parts(polygons):
    """Return PARTS x PARTS parts (n, parts, 4, 3) of polygons and their areas (n, parts)."""
    along = np.linspace(0.0, 1.0, PARTS + 1)
    st = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    weight = weights(st, np.zeros(len(st), bool))
    p = np.einsum("gv,nvc->ngc", weight, polygons).reshape(-1, PARTS + 1, PARTS + 1, 3)
    parts = np.stack([p[:, :-1, :-1], p[:, :-1, 1:], p[:, 1:, 1:], p[:, 1:, :-1]], axis=3)
    parts = parts.reshape(len(polygons), PARTS**2, 4, 3)
    across = np.cross(parts[:, :, 2] - parts[:, :, 0], parts[:, :, 3] - parts[:, :, 1])
    return parts, 0.5 * np.linalg.norm(across, axis=2)
