"""Scene files: TOML text to a `Scene`, every mistake reported at once."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from radiosity.light.bands import RGB
from radiosity.light.palette import ACCURACY, kind_of
from radiosity.mesh.faces import Faces
from radiosity.mesh.triangulate import triangulate
from radiosity.scene.assemble import (
    AXES,
    default_camera,
    geometry_problem,
    in_bands,
    with_materials,
)
from radiosity.scene.geometry import DEFAULT, Geometry, joined
from radiosity.scene.lights import Ambient, make_light, read_lights
from radiosity.scene.materials import excess_of, make_materials
from radiosity.scene.model import Camera, Scene, SceneError, Truth
from radiosity.scene.schema import (
    ABSORPTANCE,
    MATRIX,
    POINT,
    POLYGON,
    REFLECTANCE,
    ROUNDING,
    SCALE,
    UNITS,
    CameraTable,
    EmissionTable,
    GeometryTable,
    MaterialTable,
    SceneTable,
    SpectrumFile,
    TruthTable,
    Wrong,
    at,
    checked,
    dotted,
    nearest,
    values_of,
)


def read_toml(
    text: str,
    source: str,
    read_geometry: Callable[[str], Geometry],
    read_text: Callable[[str], str],
    name: str = "",
    merge: bool = True,
    bands: str | int = "auto",
    accuracy: float = ACCURACY,
) -> Scene:
    """Return the scene that a TOML text describes.

    Parameters
    ----------
    text : str
    source : str
        The file's name, for messages and `Scene.source`.
    read_geometry : callable
        Returns the geometry of a file named in the text; raises SceneError.
    read_text : callable
        Returns the text of a spectrum's file named in the text; raises SceneError.
    name : str
        The scene's name if the text gives none.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    bands, accuracy
        Of the scene, see `radiosity.light.palette.kind_of`.

    Raises
    ------
    SceneError
        With one problem for every mistake in the text and in the files it names.
    ValueError
        Unknown ``bands``.
    """
    raw, problems = _parsed(text, source), []
    top = checked(SceneTable, raw, (), problems)
    parts = _parts(raw.get("geometry", []), read_geometry, merge, problems)
    materials = _tables(MaterialTable, raw, "materials", problems, _material_problems)
    cameras = _tables(CameraTable, raw, "cameras", problems, _camera_problems)
    lights = read_lights(raw.get("lights", []), problems)
    tables = ("materials", materials), ("lights", lights)
    coloured = [_with_spectra(found, key, read_text, problems) for key, found in tables]
    truth = _truth(raw, problems)
    geometry = joined(parts) if parts and None not in parts else None
    if geometry is not None:
        useless = geometry_problem(geometry)
        problems += [f"geometry: {useless}"] if useless else []
        problems += _truth_name_problems(truth, materials, geometry)
    if problems:
        raise SceneError(source, problems)
    scene = Scene(
        name=top.name or name,
        faces=geometry.faces,
        materials=(),
        groups=geometry.group_names,
        cameras={key: _camera(key, camera, top.up) for key, camera in cameras.items()},
        unit=top.unit,
        unit_m=UNITS[top.unit],
        up=top.up,
        truth=truth,
        source=source,
        notes=geometry.notes,
        spectra=_spectra_of(materials, lights, geometry),
    )
    kind = kind_of(bands, bool(scene.spectra), accuracy)
    has_spectra = any(_names_spectra(found) for _, found in tables)
    return in_bands(kind, has_spectra, partial(_completed, scene, geometry, *coloured))


def _spectra_of(materials, lights, geometry):
    """Return the names of the files with spectra that faces and lights have."""
    used = [*lights.values(), *(materials[n] for n in geometry.material_names if n in materials)]
    files = (file.name for table in used for file in values_of(table, SpectrumFile))
    return tuple(dict.fromkeys(files))


def _names_spectra(tables) -> bool:
    return any(
        file for table in tables.values() if table for file in values_of(table, SpectrumFile)
    )


def _with_spectra(tables, key, read_text, problems):
    """Return tables with the spectra read that they name."""
    if not _names_spectra(tables):
        return tables
    from radiosity.scene.spectra import resolved

    found = ((k, table) for k, table in tables.items() if table)
    return {k: resolved(table, (key, k), read_text, problems) for k, table in found}


def _completed(scene, geometry, tables, lights, palette):
    """Return a scene with its materials and lights, and with a camera where it has none."""
    made, notes = make_materials(tables, geometry, scene.unit_m, palette)
    problems = [p for m in made.values() if (p := excess_of(m, palette.bands))]
    if problems:
        raise SceneError(scene.source, problems)
    faces, materials, more = with_materials(geometry, made, palette)
    notes += _colour_notes(scene, palette)
    lights = [make_light(table, palette) for table in lights.values()]
    dark = np.zeros(palette.bands.count)
    cameras = scene.cameras
    if not cameras:
        cameras = {DEFAULT: default_camera(faces, scene.up)}
        more.append("no camera is given: one outside looks at the whole scene")
    return replace(
        scene, faces=faces, materials=materials, cameras=cameras, bands=palette.bands,
        ambient=sum((s.radiance for s in lights if isinstance(s, Ambient)), dark),
        lights=tuple(s for s in lights if not isinstance(s, Ambient)),
        truth=scene.truth if palette.bands is RGB else None,
        notes=(*scene.notes, *notes, *more),
    )  # fmt: skip


def _colour_notes(scene, palette):
    """Yield what is lost where colours are not what the file gives."""
    if scene.spectra and palette.bands.wavelengths is None:
        yield (
            f"{', '.join(scene.spectra)}: taken as they look in the scene's own light, within "
            "sRGB; --bands spectral tells wavelengths apart"
        )
    if scene.truth is not None and palette.bands is not RGB:
        yield "truth is left out: it holds for red, green and blue"


def _parsed(text, source):
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.fullmatch(r"(.*) \((?:at )?(.*)\)", str(error), re.S)
        problem = f"{found[2]}: {found[1]}" if found else str(error)
        raise SceneError(source, [f"{problem} (this is not valid TOML)"]) from None
    except RecursionError:
        raise SceneError(source, ["arrays or tables are nested too deeply"]) from None
    except ValueError as error:  # a whole number of thousands of digits
        raise SceneError(source, [f"a number cannot be read: {error}"]) from None


def _tables(model, raw, key, problems, cross_check):
    """Return the tables ``[key.NAME]`` that are right; what is wrong becomes problems."""
    tables = raw.get(key, {})
    good = {}
    for name, table in tables.items() if isinstance(tables, dict) else ():
        good[name] = checked(model, table, (key, name), problems)
        if isinstance(table, dict):
            problems += cross_check(table, (key, name))
    return good


def _value(table, key, check, default=None):
    """Return what a check makes of a key, None where it finds something wrong."""
    try:
        return check(table[key]) if isinstance(table, dict) and key in table else default
    except Wrong:
        return None


def _material_problems(table, path):
    """Return what is wrong between the keys of a material."""
    problems = []
    if "diffuse" in table and "absorptance" in table:
        problems.append(
            f"{dotted(path)} gives both diffuse and absorptance: give one, "
            "as absorptance = 1 - diffuse"
        )
    kept = _value(table, "absorptance", ABSORPTANCE)
    rest = tuple(1 - np.array(kept)) if isinstance(kept, tuple) else None
    diffuse = _value(table, "diffuse", REFLECTANCE, rest)
    gloss = _value(table.get("specular"), "reflectance", REFLECTANCE)
    if isinstance(diffuse, tuple) and isinstance(gloss, tuple):
        total = np.add(diffuse, gloss)
        if total.max() > 1 + ROUNDING:
            band = "rgb"[int(np.argmax(total))]
            problems.append(
                f"{dotted(path)}: diffuse + specular.reflectance = {total.max():.6g} in band "
                f"{band} must be at most 1: a surface cannot reflect more than it receives; "
                "lower one of them"
            )
    return problems + _emission_problems(table.get("emission"), (*path, "emission"))


def _emission_problems(table, path):
    if not isinstance(table, dict):
        return []
    known = [key for key in table if key in EmissionTable.model_fields]
    if len(known) == 1 or (not known and table):
        return []
    found = " and ".join(known) or "nothing"
    return [f"{dotted(path)} gives {found}: give one of {', '.join(EmissionTable.model_fields)}"]


def _camera_problems(table, path):
    """Return what is wrong between the keys of a camera."""
    position, target = _value(table, "position", POINT), _value(table, "target", POINT)
    up = _value(table, "up", POINT)
    if position is None or target is None:
        return []
    if _nothing(np.subtract(target, position), np.add(np.abs(target), np.abs(position))):
        return [f"{dotted(path)} looks from {list(position)} at the same point: move its target"]
    if up is None:
        return []
    if not np.any(up):
        return [at((*path, "up"), list(up), "must not be zero: it is a direction")]
    if _parallel(up, np.subtract(target, position)):
        text = "must not be parallel to the view from position to target: give any other direction"
        return [at((*path, "up"), list(up), text)]
    return []


def _nothing(step, scale):
    return np.linalg.norm(step) <= 1e-12 * np.linalg.norm(scale)


def _parallel(a, b):
    a, b = (np.asarray(v, float) / np.abs(v).max() for v in (a, b))
    return np.linalg.norm(np.cross(a, b)) <= 1e-6 * np.linalg.norm(a) * np.linalg.norm(b)


def _parts(blocks, read_geometry, merge, problems):
    """Return the geometry of every ``[[geometry]]`` block, None where something is wrong.

    Values are taken key by key, so that a wrong one does not hide the mistakes of the others.
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
        part = _part(raw, path, read_geometry, merge, problems)
        parts.append(part.placed(matrix) if len(problems) == before else None)
    return parts


def _source_problems(raw, path):
    """Return what is wrong between the keys of a geometry block."""
    found = [key for key in ("file", "polygons") if key in raw]
    if len(found) != 1:
        gives = " and ".join(found) or "neither file nor polygons"
        yield f'{dotted(path)} gives {gives}: give either file = "..." or polygons = [...]'
    others = [key for key in ("translate", "rotate", "scale") if key in raw]
    if "transform" in raw and others:
        yield f"{dotted(path)} gives transform and {' and '.join(others)}: give one or the other"


def _placement(raw, path, problems):
    """Return the matrix (4, 4) of a block: scale, then rotate about x, y, z, then translate."""
    key = "transform" if "transform" in raw else "scale"
    matrix = np.array(_value(raw, "transform", MATRIX) or np.eye(4))
    if not np.array_equal(matrix[3], [0, 0, 0, 1]):
        text = "must be [0, 0, 0, 1]: the last row of a transform that keeps planes planar"
        problems.append(at((*path, key, 3), matrix[3].tolist(), text))
    if key == "scale":
        matrix[:3, :3] = np.diag(_value(raw, "scale", SCALE) or (1.0, 1.0, 1.0))
        for axis, degrees in enumerate(_value(raw, "rotate", POINT) or (0, 0, 0)):
            matrix = _rotation(axis, degrees) @ matrix
        matrix[:3, 3] = _value(raw, "translate", POINT) or (0, 0, 0)
    stretch = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    if not stretch[2] > 1e-12 * stretch[0]:
        problems.append(at((*path, key), raw[key], "must not flatten the geometry to a plane"))
    return matrix


def _rotation(axis, degrees):
    """Return the matrix (4, 4) that turns counter-clockwise seen from the tip of an axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(4)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def _part(raw, path, read_geometry, merge, problems):
    """Return the geometry of a block as its file or its polygons give it."""
    file, material = raw.get("file"), raw.get("material")
    if isinstance(raw.get("polygons"), list):
        return _inline(raw["polygons"], material or DEFAULT, path, merge, problems)
    if not isinstance(file, str):
        return None
    try:
        part = read_geometry(file)
    except SceneError as error:
        problems += [at((*path, "file"), file, p) for p in error.problems]
        return None
    return part.of_material(material) if material else part


def _inline(polygons, name, path, merge, problems):
    """Return inline polygons; one group a block, named after its material."""
    pieces = []
    for k, raw in enumerate(polygons):
        polygon = _value({"polygon": raw}, "polygon", POLYGON)
        if polygon is None:  # the schema has said why
            continue
        try:
            pieces.append(triangulate(np.array(polygon).reshape(-1, 3)))
        except ValueError as error:
            problems.append(f"{dotted((*path, 'polygons', k))} {error}")
    if not polygons:
        problems.append(f"{dotted((*path, 'polygons'))} is empty: list at least one polygon")
    if not pieces:
        return None
    return Geometry(Faces.from_polygons(np.concatenate(pieces), 0, 0, merge), (name,), (name,))


def _truth(raw, problems):
    if not isinstance(raw.get("truth"), dict):
        return None
    table = checked(TruthTable, raw["truth"], ("truth",), problems)
    if table is None:
        return None
    radiosity = {name: np.array(rgb) for name, rgb in table.radiosity.items()}
    return Truth(radiosity, table.relative_tolerance, table.mesh)


def _truth_name_problems(truth, materials, geometry):
    known = dict.fromkeys((*materials, *geometry.material_names, *geometry.group_names))
    for name in truth.radiosity if truth else ():
        if name and name not in known:
            path = dotted(("truth", "radiosity", name))
            yield f"{path} is neither a material nor a group: {nearest(name, known)}"


def _camera(name, table, up):
    view = np.subtract(table.target, table.position)
    axis = np.array(table.up or AXES[up])
    if table.up is None and _parallel(axis, view):
        axis = np.array(AXES["y" if up == "z" else "z"])
    return Camera(
        name, np.array(table.position), np.array(table.target), axis, table.fov, table.size
    )
