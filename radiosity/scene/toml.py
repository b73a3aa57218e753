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
    as_solved,
    default_camera,
    geometry_problem,
    in_bands,
    with_materials,
)
from radiosity.scene.blocks import frame_of, parts_of
from radiosity.scene.cameras import camera_problems, make_camera
from radiosity.scene.checks import SpectrumFile, TextureKey
from radiosity.scene.described import read_as, with_described
from radiosity.scene.geometry import DEFAULT, Geometry, joined
from radiosity.scene.lights import Ambient, IesTable, make_light, read_lights
from radiosity.scene.materials import make_materials
from radiosity.scene.model import Scene, SceneError, Truth, too_bright, uncovered
from radiosity.scene.names import nearest
from radiosity.scene.schema import (
    OPTICAL,
    CameraTable,
    EmissionTable,
    MaterialTable,
    SceneTable,
    TruthTable,
    checked,
    dotted,
    values_of,
)
from radiosity.scene.units import UNITS


def read_toml(text: str, source: str, *rest, **options) -> Scene:
    """Return the scene that a TOML text describes; see `read_tables`, whose arguments it takes."""
    return read_tables(_parsed(text, source), source, *rest, **options)


def read_tables(
    raw: dict,
    source: str,
    read_geometry: Callable[[str, bool], Geometry],
    name: str = "",
    merge: bool = True,
    read_picture: Callable[[str], np.ndarray] | None = None,
    read_text: Callable[[str], str] | None = None,
    bands: str | int = "auto",
    accuracy: float = ACCURACY,
) -> Scene:
    """Return the scene that the tables of a scene file describe, and the files they name.

    Parameters
    ----------
    raw : dict
        The tables, not yet checked.
    source : str
        The file's name, for messages and `Scene.source`.
    read_geometry : callable
        Returns the geometry of a file named in the tables, with or without texture coordinates;
        raises SceneError.
    name : str
        The scene's name if the tables give none.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    read_picture : callable, optional
        Returns the pixels (h, w, 1 or 3) of a picture named in the tables; raises SceneError.
    read_text : callable, optional
        Returns the text of a spectrum's or luminaire's file named in the tables; raises SceneError.
    bands, accuracy
        Of the scene, see `radiosity.light.palette.kind_of`.

    Raises
    ------
    SceneError
        With one problem for every mistake in the tables and in the files they name.
    ValueError
        Unknown ``bands``.
    """
    problems = []
    top = checked(SceneTable, raw, (), problems)
    unit, up = frame_of(raw)
    uv = _names_texture(raw.get("materials"))
    parts = parts_of(raw.get("geometry", []), read_geometry, merge, uv, (unit, up), problems)
    own = raw.get("materials") if isinstance(raw.get("materials"), dict) else {}
    geometry = joined(parts, own) if parts and None not in parts else None
    raw = raw if geometry is None else with_described(raw, geometry)
    materials = _tables(MaterialTable, raw, "materials", problems, _material_problems)
    details = _details(materials, geometry, read_picture, problems)
    cameras = _tables(CameraTable, raw, "cameras", problems, camera_problems)
    lights = _with_photometry(read_lights(raw.get("lights", []), problems), read_text, problems)
    coloured = [
        _with_spectra(found, key, read_text, problems)
        for key, found in (("materials", materials), ("lights", lights))
    ]
    truth = _truth(raw, problems)
    if geometry is not None:
        problems += _between(geometry, truth, materials, details)
    if problems:
        raise SceneError(source, problems)
    scene = Scene(
        name=top.name or name,
        faces=geometry.faces,
        materials=(),
        groups=geometry.group_names,
        cameras={key: make_camera(key, camera, up) for key, camera in cameras.items()},
        unit=unit,
        unit_m=UNITS[unit],
        up=up,
        truth=truth,
        source=source,
        notes=geometry.notes,
        spectra=_spectra_of(materials, lights, geometry),
        read_as=read_as(raw, geometry),
    )
    kind = kind_of(bands, bool(scene.spectra), accuracy)
    has_spectra = _names_spectra(materials) or _names_spectra(lights)
    return in_bands(kind, has_spectra, partial(_completed, scene, geometry, *coloured, details))


def _details(materials, geometry, read_picture, problems):
    """Return what pictures tell of materials: those that came with the geometry, or files."""
    if not any(t for table in materials.values() if table for t in values_of(table, TextureKey)):
        return {}
    from radiosity.scene.textures import details_of  # others need none of it

    brought = geometry.pictures if geometry is not None else {}

    def picture(name):
        return brought[name] if name in brought else read_picture(name)

    return details_of(materials, picture, problems)


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
    from radiosity.scene.photometric.luminaires import with_photometry  # others need none of it

    return with_photometry(lights, read_text, problems)


def _luminaire_notes(tables, lights, faces, unit_m):
    if not any(isinstance(table, IesTable) for table in tables.values()):
        return []
    from radiosity.scene.photometric.luminaires import luminaire_notes

    return luminaire_notes(tables, lights, faces, unit_m)


def _completed(scene, geometry, tables, light_tables, details, palette):
    """Return a scene with its materials and lights, and with a camera where it has none."""
    made, notes = make_materials(tables, geometry, scene.unit_m, palette)
    made |= {name: found.of(made[name], palette) for name, found in details.items()}
    if not isinstance(palette, Nanometres):  # which only adds up what shines
        problems = [p for m in made.values() for p in too_bright(m, palette.bands)]
        if problems:
            raise SceneError(scene.source, problems)
    faces, materials, more = with_materials(geometry, made, palette.bands.count)
    faces, odd = as_solved(faces, materials, geometry, scene.unit, scene.source)
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
        notes=(*scene.notes, *notes, *more, *odd),
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


def _names_texture(table, depth=5):
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


def _truth(raw, problems):
    if not isinstance(raw.get("truth"), dict):
        return None
    table = checked(TruthTable, raw["truth"], ("truth",), problems)
    if table is None:
        return None
    radiosity = {name: np.array(rgb) for name, rgb in table.radiosity.items()}
    return Truth(radiosity, table.relative_tolerance, table.mesh)


def _between(geometry, truth, materials, details):
    """Yield what is wrong with the geometry, and between it and the tables."""
    useless = geometry_problem(geometry)
    if useless:
        yield f"geometry: {useless}"
    yield from _truth_name_problems(truth, materials, geometry)
    yield from _uncovered(details, geometry)


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
