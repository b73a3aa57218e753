"""Blocks: each ``[[geometry]]`` of a scene file as a geometry, placed and smoothed."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radiosity.mesh.faces import Faces
from radiosity.mesh.triangulate import convex_parts
from radiosity.scene.checks import value_of
from radiosity.scene.geometry import DEFAULT, Geometry, rotation
from radiosity.scene.model import SceneError
from radiosity.scene.schema import (
    MATRIX,
    POINT,
    POLYGON,
    SCALE,
    UVS,
    GeometryTable,
    at,
    checked,
    dotted,
)
from radiosity.scene.units import UNITS, turn_between

GLTF = ".glb", ".gltf"


def parts_of(
    blocks, read_geometry: Callable[[str, bool], Geometry], merge: bool, uv: bool,
    frame: tuple[str, str], problems: list[str],
) -> list[Geometry | None]:  # fmt: skip
    """Return the geometry of every ``[[geometry]]`` block, None where something is wrong.

    Values are taken key by key, so that a wrong one does not hide the mistakes of the others.
    ``uv`` tells whether texture coordinates are kept, ``frame`` the scene's unit and axis, see
    `radiosity.scene.toml.read_tables` for the rest.
    """
    if isinstance(blocks, list) and not blocks:
        problems.append(
            'geometry is missing: a scene needs at least one [[geometry]] with file = "..." '
            "or polygons = [...]"
        )
    parts = []
    for k, raw in enumerate(blocks if isinstance(blocks, list) else []):
        path, before = ("geometry", k), len(problems)
        checked(GeometryTable, raw, path, problems)
        raw = raw if isinstance(raw, dict) else {}
        problems += _source_problems(raw, path)
        matrix = _placement(raw, path, problems)
        part = _part(raw, path, read_geometry, merge, uv, problems)
        if len(problems) == before:
            if part.unit is None:
                part = part.per_metre(UNITS[raw.get("unit", frame[0])])
            part = part.placed(matrix @ _into(frame, part, raw))
            part = _smoothed(part, raw.get("smooth"), path, problems)
            if raw.get("repair") is False:
                part = replace(part, fixed=frozenset(part.group_names))
        parts.append(part if len(problems) == before else None)
    return parts


def frame_of(raw: dict) -> tuple[str, str]:
    """Return the unit and the axis of a scene file, given or by default.

    Up is z; y where all geometry comes from glTF files, which have it so.
    """
    unit, up, blocks = raw.get("unit"), raw.get("up"), raw.get("geometry")
    tables = blocks if isinstance(blocks, list) else []
    files = [b.get("file") for b in tables if isinstance(b, dict)]
    all_gltf = files and all(isinstance(f, str) and f.lower().endswith(GLTF) for f in files)
    unit = unit if isinstance(unit, str) and unit in UNITS else "m"
    return unit, up if up in ("x", "y", "z") else "y" if all_gltf else "z"


def _into(frame, part, raw):
    """Return the matrix (4, 4) from a block's unit and axis, or its format's, to the scene's."""
    unit, up = raw.get("unit", part.unit or frame[0]), raw.get("up", part.up or frame[1])
    matrix = np.eye(4)
    matrix[:3, :3] = UNITS[unit] / UNITS[frame[0]] * turn_between(up, frame[1])
    return matrix


def _smoothed(part, smooth, path, problems):
    """Return a geometry with the normals at its corners that the key ``smooth`` asks for."""
    faces = part.faces
    if smooth is None:
        return part
    if smooth is True and faces.corner_normals is None:
        text = "needs a file with normals (vn) of curved surfaces: give an angle, smooth = 40"
        problems.append(at((*path, "smooth"), smooth, text))
    if smooth is True:
        return part
    if smooth is False:
        return replace(part, faces=replace(faces, corner_normals=None))
    from radiosity.mesh.curves import curved, smooth_normals

    faces = replace(faces, corner_normals=smooth_normals(faces, smooth))
    return replace(part, faces=replace(faces, corner_normals=curved(faces)))


def _source_problems(raw, path):
    """Return what is wrong between the keys of a geometry block."""
    found = [key for key in ("file", "polygons") if key in raw]
    if len(found) != 1:
        gives = " and ".join(found) or "neither file nor polygons"
        yield f'{dotted(path)} gives {gives}: give either file = "..." or polygons = [...]'
    others = [key for key in ("translate", "rotate", "scale") if key in raw]
    if "transform" in raw and others:
        yield f"{dotted(path)} gives transform and {' and '.join(others)}: give one or the other"
    if "uv" in raw and "polygons" not in raw:
        yield f"{dotted(path)} gives uv without polygons: a file has its own (vt of an .obj)"


def _placement(raw, path, problems):
    """Return the matrix (4, 4) of a block: scale, then rotate about x, y, z, then translate."""
    key = "transform" if "transform" in raw else "scale"
    matrix = np.array(value_of(raw, "transform", MATRIX) or np.eye(4))
    if not np.array_equal(matrix[3], [0, 0, 0, 1]):
        text = "must be [0, 0, 0, 1]: the last row of a transform that keeps planes planar"
        problems.append(at((*path, key, 3), matrix[3].tolist(), text))
    if key == "scale":
        matrix[:3, :3] = np.diag(value_of(raw, "scale", SCALE) or (1.0, 1.0, 1.0))
        for axis, degrees in enumerate(value_of(raw, "rotate", POINT) or (0, 0, 0)):
            matrix = rotation(axis, degrees) @ matrix
        matrix[:3, 3] = value_of(raw, "translate", POINT) or (0, 0, 0)
    stretch = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    if not stretch[2] > 1e-12 * stretch[0]:
        problems.append(at((*path, key), raw[key], "must not flatten the geometry to a plane"))
    return matrix


def _part(raw, path, read_geometry, merge, uv, problems):
    """Return the geometry of a block as its file or its polygons give it."""
    file, material = raw.get("file"), raw.get("material")
    if isinstance(raw.get("polygons"), list):
        return _inline(raw, material or DEFAULT, path, merge, uv, problems)
    if not isinstance(file, str):
        return None
    try:
        part = read_geometry(file, uv)
    except SceneError as error:
        problems += [at((*path, "file"), file, p) for p in error.problems]
        return None
    return part.of_material(material) if material else part


def _inline(raw, name, path, merge, uv, problems):
    """Return inline polygons; one group a block, named after its material."""
    polygons, pieces, coordinates = raw["polygons"], [], []
    places = _coordinates(raw.get("uv"), polygons, path, problems)
    for k, listed in enumerate(polygons):
        polygon = value_of({"polygon": listed}, "polygon", POLYGON)
        if polygon is None:  # the schema has said why
            continue
        try:
            polygon = np.array(polygon).reshape(-1, 3)
            parts = convex_parts(polygon)
        except ValueError as error:
            problems.append(f"{dotted((*path, 'polygons', k))} {error}")
            continue
        pieces.append(polygon[parts])
        coordinates += [places[k][parts]] if places else []
    if not polygons:
        problems.append(f"{dotted((*path, 'polygons'))} is empty: list at least one polygon")
    if not pieces:
        return None
    more = np.concatenate(coordinates) if uv and coordinates else None
    faces = Faces.from_polygons(np.concatenate(pieces), 0, 0, merge, more)
    return Geometry(faces, (name,), (name,))


def _coordinates(listed, polygons, path, problems):
    """Return the texture coordinates (n, 2) of every polygon, None where not given or wrong."""
    where = (*path, "uv")
    if value_of({"uv": listed}, "uv", UVS) is None:
        return None
    if len(listed) != len(polygons):
        text = f"lists the corners of {len(listed)} polygons, there are {len(polygons)}"
        problems.append(f"{dotted(where)} {text}: give as many")
        return None
    for k, (one, polygon) in enumerate(zip(listed, polygons, strict=True)):
        if isinstance(polygon, list) and len(one) != len(polygon):
            text = f"has {len(one)} pairs [u, v], its polygon has {len(polygon)} points"
            problems.append(f"{dotted((*where, k))} {text}: give one a point")
            return None
    return [np.array(one, float).reshape(-1, 2) for one in listed]
