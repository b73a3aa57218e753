"""Polygons of a file, with what their corners have, as the faces of a geometry."""

from dataclasses import replace

import numpy as np

from radiosity.mesh.faces import Faces, has_area
from radiosity.mesh.given import Given
from radiosity.mesh.outlines import Outlines
from radiosity.scene.geometry import LONGEST


def faces_of(
    polygons: np.ndarray, found: Outlines, count: int, material: np.ndarray, group: np.ndarray,
    merge: bool, uv: np.ndarray | None, normals: np.ndarray | None,
) -> tuple[Faces, Given | None]:  # fmt: skip
    """Return the faces that polygons were split into, and as parts of the polygons if not joined.

    Parameters
    ----------
    polygons : (k, 4, 3) float
        Vertices of the parts, in scene units.
    found : Outlines
    count : int
        How many polygons the file has.
    material, group : (count,) int
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    uv, normals : (c, 2), (c, 3) float, optional
        Of every listed corner, nan where it has none.
    """
    details = (None if x is None else _whole(x[found.place]) for x in (uv, normals))
    faces = Faces.from_polygons(
        polygons, material[found.origin], group[found.origin], merge, *details
    )
    if faces.corner_normals is not None:
        from radiosity.mesh.curves import curved  # others need none of it

        faces = replace(faces, corner_normals=curved(faces))
    given = None if merge else Given(faces, found.origin[has_area(polygons)], count)
    return faces, given


def _whole(values):
    """Return corners (k, 4, c), nan on all of a face where one of them is."""
    missing = np.isnan(values).any(axis=(1, 2), keepdims=True)
    return np.where(missing, np.nan, values)


def flat_notes(found: Outlines) -> list[str]:
    """Return the note that a file has polygons without area, if it has any."""
    return [f"{found.flat} faces with all corners on one line were left out"] * bool(found.flat)


def vertex_problems(vertices: np.ndarray) -> list[str]:
    """Return what is wrong with the first vertex (n, 3) that cannot be computed with."""
    bad = np.flatnonzero(~(np.abs(vertices) <= LONGEST).all(axis=1))  # true for nan
    return [
        f"vertex {k} = {vertices[k].tolist()} must be finite and at most {LONGEST:g}"
        for k in bad[:1]
    ]
