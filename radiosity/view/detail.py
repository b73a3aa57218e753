"""Detail inside of patches, as pictures show it: textures, bumps and normals between corners.

A shading normal differs from the face's own. Light arrives from where it would arrive at a small
surface of that normal that stands on the face: lamps below the face give nothing, as their shadow
rays meet it, and in other directions below it the face itself is seen, as beside every real bump.
So in light that comes evenly from everywhere a bumped surface looks like a flat one.
"""

from dataclasses import dataclass

import numpy as np

from radiosity.light.bump import tilt
from radiosity.mesh.corners import (
    between,
    in_front,
    onto_curve,
    slopes,
    weights,
)
from radiosity.scene.model import Scene
from radiosity.transport.curved import smooth_normals
from radiosity.transport.lookup import Table, coordinates_at


@dataclass(frozen=True)
class Detail:
    """What varies inside of the patches of a scene; ``table`` finds places on faces."""

    scene: Scene
    table: Table

    @property
    def textured(self) -> bool:
        """Whether a material has a texture."""
        return any(m.texture is not None for m in self.scene.materials)

    def diffuse(self, face: np.ndarray, points: np.ndarray, diffuse: np.ndarray) -> np.ndarray:
        """Return the reflectances (k, bands) of points on faces: ``diffuse``, or a texture's."""
        found, textured = diffuse.copy(), [m.texture and m for m in self.scene.materials]
        for material, mine, weight, _ in self._used(textured, face, points):
            texels = material.texture.at(between(self.scene.faces.uv[face[mine]], weight))
            reflects = found[mine].any(axis=1, keepdims=True)  # not a black back
            found[mine] = np.where(reflects, texels, 0.0)
        return found

    def roughness(self, face: np.ndarray, points: np.ndarray) -> np.ndarray | None:
        """Return the roughness (k,) of a lobe at points of one material, None where it is even."""
        told = [m.shininess for m in self.scene.materials]
        for shininess, _, weight, _ in self._used(told, face, points):
            return shininess.at(between(self.scene.faces.uv[face], weight))
        return None

    def normals(self, face: np.ndarray, points: np.ndarray, sides: np.ndarray) -> np.ndarray:
        """Return the unit shading normals (k, 3) at points of faces, on the sides (k,) 1 or -1."""
        faces = self.scene.faces
        own = faces.normals()[face]
        found = smooth_normals(faces, self.table, own, face, points)
        bumps = [m.bump for m in self.scene.materials]
        for bump, mine, weight, st in self._used(bumps, face, points):
            slope = bump.slope(between(faces.uv[face[mine]], weight))
            along = self._along_uv(face[mine], st)
            found[mine] = in_front(found[mine] + tilt(own[mine], *along, slope), own[mine])
        return found * sides[:, None]

    def raised(self, face: np.ndarray, points: np.ndarray, sides: np.ndarray) -> np.ndarray:
        """Return points (k, 3) of faces where the curved surface lies that these stand for.

        From there a lamp sets behind the curve, not behind the plane of a face.
        """
        faces, found = self.scene.faces, points.copy()
        for mine, weight in self._curved(face, points):
            normals = faces.corner_normals[face[mine]] * sides[mine, None, None]
            found[mine] = onto_curve(points[mine], faces.vertices[face[mine]], normals, weight)
        return found

    def _curved(self, face, points):
        """Yield which points lie on faces that stand for a curve, and their corners' weights."""
        mine = np.flatnonzero(self.scene.faces.is_curved[face])
        if len(mine):
            yield mine, self._places(face[mine], points[mine])[1]

    def _used(self, details, face, points):
        """Yield each detail, which points have it, and their corners' weights, s and t."""
        material = self.scene.faces.material[face]
        for k, detail in enumerate(details):
            mine = np.flatnonzero(material == k)
            if detail is not None and len(mine):
                st, weight = self._places(face[mine], points[mine])
                yield detail, mine, weight, st

    def _places(self, face, points):
        st = coordinates_at(self.table, face, np.ascontiguousarray(points))
        return st, weights(st, self.scene.faces.is_triangle[face])

    def _along_uv(self, face, st):
        """Return P_u and P_v (k, 3), the derivatives of the place by texture coordinates."""
        faces = self.scene.faces
        slope = slopes(st, faces.is_triangle[face])
        place = np.einsum("kvd,kvc->kcd", slope, faces.vertices[face])
        uv = np.einsum("kvd,kvc->kcd", slope, faces.uv[face])
        det = uv[:, 0, 0] * uv[:, 1, 1] - uv[:, 0, 1] * uv[:, 1, 0]
        safe = np.where(det == 0.0, np.inf, det)[:, None]
        along_u = (place[..., 0] * uv[:, 1, 1, None] - place[..., 1] * uv[:, 1, 0, None]) / safe
        along_v = (place[..., 1] * uv[:, 0, 0, None] - place[..., 0] * uv[:, 0, 1, None]) / safe
        return along_u, along_v
