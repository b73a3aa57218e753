"""Scene files: TOML text to a `Scene`, every mistake reported at once."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from radiosity.light.bands import RGB
from radiosity.light.palette import ACCURACY, Nanometres, kind_of
from radiosity.scene.assemble import (
    AXES,
    default_camera,
    geometry_problem,
    in_bands,
    with_materials,
)
from radiosity.scene.blocks import parts_of
from radiosity.scene.checks import SpectrumFile, nearest, value_of
from radiosity.scene.geometry import DEFAULT, Geometry, joined
from radiosity.scene.lights import Ambient, IesTable, make_light, read_lights
from radiosity.scene.materials import make_materials
from radiosity.scene.model import Camera, Scene, SceneError, Truth, too_bright, uncovered
from radiosity.scene.schema import (
    OPTICAL,
    POINT,
    UNITS,
    CameraTable,
    EmissionTable,
    MaterialTable,
    SceneTable,
    TruthTable,
    at,
    checked,
    dotted,
    values_of,
)


def read_toml(
    text: str,
    source: str,
    read_geometry: Callable[[str, bool], Geometry],
    name: str = "",
    merge: bool = True,
    read_picture: Callable[[str], np.ndarray] | None = None,
    read_text: Callable[[str], str] | None = None,
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
        Returns the geometry of a file named in the text, with or without texture coordinates;
        raises SceneError.
    name : str
        The scene's name if the text gives none.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    read_picture : callable, optional
        Returns the pixels (h, w, 1 or 3) of a picture named in the text; raises SceneError.
    read_text : callable, optional
        Returns the text of a spectrum's or luminaire's file named in the text; raises SceneError.
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
    tables = raw.get("materials", {})
    uv = any(map(_names_texture, tables.values() if isinstance(tables, dict) else ()))
    parts = parts_of(raw.get("geometry", []), read_geometry, merge, uv, problems)
    materials = _tables(MaterialTable, raw, "materials", problems, _material_problems)
    details = _details(materials, read_picture, problems) if uv else {}
    cameras = _tables(CameraTable, raw, "cameras", problems, _camera_problems)
    lights = _with_photometry(read_lights(raw.get("lights", []), problems), read_text, problems)
    coloured = [
        _with_spectra(found, key, read_text, problems)
        for key, found in (("materials", materials), ("lights", lights))
    ]
    truth = _truth(raw, problems)
    geometry = joined(parts) if parts and None not in parts else None
    if geometry is not None:
        useless = geometry_problem(geometry)
        problems += [f"geometry: {useless}"] if useless else []
        problems += _truth_name_problems(truth, materials, geometry)
        problems += _uncovered(details, geometry)
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
    has_spectra = _names_spectra(materials) or _names_spectra(lights)
    return in_bands(kind, has_spectra, partial(_completed, scene, geometry, *coloured, details))


def _details(materials, read_picture, problems):
    from radiosity.scene.textures import details_of  # others need none of it

    return details_of(materials, read_picture, problems)


def _spectra_of(materials, lights, geometry):
    """Return the names of the files with spectra that faces and lights have."""
    used = [*lights.values(), *(materials[n] for n in geometry.material_names if n in materials)]
    files = (file.name for table in used for file in values_of(table, SpectrumFile))
    return tuple(dict.fromkeys(files))


def _names_spectra(tables) -> bool:
    return any(f for table in tables.values() if table for f in values_of(table, SpectrumFile))


def _with_spectra(tables, key, read_text, problems):
    """Return tables with the spectra read that they name."""
    if not _names_spectra(tables):
        return tables
    from radiosity.scene.spectra import resolved

    found = ((k, table) for k, table in tables.items() if table)
    return {k: resolved(table, (key, k), read_text, problems) for k, table in found}


def _with_photometry(lights, read_text, problems):
    """Return the tables of lights with the photometric files read that they name."""
    if not any(isinstance(table, IesTable) for table in lights.values()):
        return lights
    from radiosity.scene.luminaires import with_photometry  # others need none of it

    return with_photometry(lights, read_text, problems)


def _luminaire_notes(tables, lights, faces, unit_m):
    if not any(isinstance(table, IesTable) for table in tables.values()):
        return []
    from radiosity.scene.luminaires import luminaire_notes

    return luminaire_notes(tables, lights, faces, unit_m)


def _completed(scene, geometry, tables, light_tables, details, palette):
    """Return a scene with its materials and lights, and with a camera where it has none."""
    made, notes = make_materials(tables, geometry, scene.unit_m, palette)
    made |= {name: found.of(made[name], palette) for name, found in details.items()}
    if not isinstance(palette, Nanometres):  # which only adds up what shines
        problems = [p for m in made.values() for p in too_bright(m, palette.bands)]
        if problems:
            raise SceneError(scene.source, problems)
    faces, materials, more = with_materials(geometry, made, palette)
    notes += _colour_notes(scene, palette)
    lights = [make_light(table, palette, scene.up) for table in light_tables.values()]
    more += _luminaire_notes(light_tables, lights, faces, scene.unit_m)
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


def _names_texture(table, depth=4):
    """Whether a table, or one inside of it, names a texture."""
    inside = table.items() if isinstance(table, dict) and depth else ()
    return any(key == "texture" or _names_texture(value, depth - 1) for key, value in inside)


def _tables(model, raw, key, problems, cross_check):
    """Return the tables ``[key.NAME]`` that are right; what is wrong becomes problems."""
    tables = raw.get(key, {})
    good = {}
    for name, table in tables.items() if isinstance(tables, dict) else ():
        good[name] = checked(model, table, (key, name), problems)
        if isinstance(table, dict):
            problems += cross_check(table, (key, name))
    return good


def _material_problems(table, path):
    """Return what is wrong between the keys of a material."""
    problems = []
    if "diffuse" in table and "absorptance" in table:
        problems.append(
            f"{dotted(path)} gives both diffuse and absorptance: give one, "
            "as absorptance = 1 - diffuse"
        )
    if any(key in table for key in OPTICAL):
        from radiosity.scene.optics import optics_problems

        problems += optics_problems(table, path)
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
    return _projection_problems(table, path) + _direction_problems(table, path)


def _projection_problems(table, path):
    """Return which of the keys of a projection are given with the other one, or missing."""
    projection = table.get("projection", "pinhole")
    if projection == "orthographic":
        if "fov" in table:
            text = "is for pinhole cameras: an orthographic one has height instead"
            return [at((*path, "fov"), table["fov"], text)]
        if "height" not in table and set(table) <= set(CameraTable.model_fields):  # no typing error
            text = "is missing: the vertical extent that an orthographic camera shows"
            return [f"{dotted((*path, 'height'))} {text}"]
    elif projection == "pinhole" and "height" in table:
        text = 'needs projection = "orthographic": a pinhole camera has fov instead'
        return [at((*path, "height"), table["height"], text)]
    return []


def _direction_problems(table, path):
    """Return whether a camera looks at nothing or its picture has no top."""
    position, target = value_of(table, "position", POINT), value_of(table, "target", POINT)
    up = value_of(table, "up", POINT)
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


def _uncovered(details, geometry):
    """Return which materials have textures that some of their faces cannot place."""
    for name in details:
        if name in geometry.material_names:
            mine = geometry.faces.material == geometry.material_names.index(name)
            yield from uncovered(f"materials.{name}", geometry.faces, mine)


def _camera(name, table, up):
    view = np.subtract(table.target, table.position)
    axis = np.array(table.up or AXES[up])
    if table.up is None and _parallel(axis, view):
        axis = np.array(AXES["y" if up == "z" else "z"])
    fov = None if table.projection == "orthographic" else table.fov
    place = np.array(table.position), np.array(table.target), axis
    return Camera(name, *place, fov, table.size, table.height)
