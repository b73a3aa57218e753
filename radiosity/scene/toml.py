"""Scene files: TOML text to a `Scene`, every mistake reported at once."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radiosity.light import photometry
from radiosity.scene.assemble import (
    AXES,
    DEFAULT_REFLECTANCE,
    default_camera,
    geometry_problem,
    with_materials,
)
from radiosity.scene.blocks import parts_of
from radiosity.scene.checks import TextureKey, nearest, value_of
from radiosity.scene.geometry import DEFAULT, Geometry, joined
from radiosity.scene.lights import Ambient, read_lights
from radiosity.scene.model import Camera, Material, Scene, SceneError, Truth, uncovered
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
)


def read_toml(
    text: str,
    source: str,
    read_geometry: Callable[[str, bool], Geometry],
    name: str = "",
    merge: bool = True,
    read_picture: Callable[[str], np.ndarray] | None = None,
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

    Raises
    ------
    SceneError
        With one problem for every mistake in the text and in the files it names.
    """
    raw, problems = _parsed(text, source), []
    top = checked(SceneTable, raw, (), problems)
    tables = raw.get("materials", {})
    uv = any(map(_names_texture, tables.values() if isinstance(tables, dict) else ()))
    parts = parts_of(raw.get("geometry", []), read_geometry, merge, uv, problems)
    materials = _tables(MaterialTable, raw, "materials", problems, _material_problems)
    details = {}
    if uv:
        from radiosity.scene.textures import details_of  # others need none of it

        details = details_of(materials, read_picture, problems)
    cameras = _tables(CameraTable, raw, "cameras", problems, _camera_problems)
    lights = read_lights(raw.get("lights", []), problems)
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
        ambient=sum((s.radiance for s in lights if isinstance(s, Ambient)), np.zeros(3)),
        lights=tuple(s for s in lights if not isinstance(s, Ambient)),
        truth=truth,
        source=source,
        notes=geometry.notes,
    )
    return _completed(scene, geometry, materials, details)


def _completed(scene, geometry, tables, details):
    """Return a scene with its materials, and with a camera where it has none."""
    made, notes = _materials(tables, geometry, scene.unit_m)
    made |= {name: found.of(made[name]) for name, found in details.items()}
    faces, materials, more = with_materials(geometry, made)
    cameras = scene.cameras
    if not cameras:
        cameras = {DEFAULT: default_camera(faces, scene.up)}
        more.append("no camera is given: one outside looks at the whole scene")
    notes = (*scene.notes, *notes, *more)
    return replace(scene, faces=faces, materials=materials, cameras=cameras, notes=notes)


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


def _names_texture(table):
    """Whether a table, or one inside of it, names a texture."""
    inside = table.items() if isinstance(table, dict) else ()
    return any(key == "texture" or _names_texture(value) for key, value in inside)


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


def _materials(tables, geometry, unit_m):
    """Return the materials of the scene file by name, and notes."""
    made, notes = {}, []
    areas = geometry.faces.areas() * unit_m**2
    for name, table in tables.items():
        used = name in geometry.material_names
        faces = geometry.faces.material == (geometry.material_names.index(name) if used else -1)
        lobe, mirror, transmit, said = _optics(name, table)
        through = None if table.translucent is None else np.array(table.translucent)
        shines = any(part is not None for part in (lobe, mirror, transmit, through))
        diffuse, absorptance, note = _diffuse(name, table, shines)
        notes += [note, *said] if note else said
        emission = _radiance(table.emission, float(areas[faces].sum()))
        made[name] = Material(name, diffuse, absorptance, emission, lobe, table.two_sided,
                              mirror, transmit, through)  # fmt: skip
    return made, notes


def _optics(name, table):
    """Return lobe, mirror and transmission of a material, and notes."""
    if not any(getattr(table, key) for key in OPTICAL):
        return None, None, None, []
    from radiosity.scene.optics import notes_of, optics_of

    lobe, mirror, transmit = optics_of(table)
    return lobe, mirror, transmit, notes_of(name, mirror, transmit)


def _diffuse(name, table, shines):
    """Return reflectance and absorptance (3,), and a note where neither is given."""
    if isinstance(table.diffuse, TextureKey):
        return np.zeros(3), np.ones(3), None  # the texture tells
    if table.absorptance is not None:
        absorptance = np.array(table.absorptance)
        return 1 - absorptance, absorptance, None
    if table.diffuse is not None:
        return np.array(table.diffuse), 1 - np.array(table.diffuse), None
    value = 0.0 if shines else DEFAULT_REFLECTANCE
    diffuse = np.full(3, value)
    return diffuse, 1 - diffuse, f'material "{name}" gives no diffuse: {value:g} is taken'


def _radiance(emission, area):
    """Return the emitted radiance (3,) in W/(m2 sr) of a material of some area in m2."""
    if emission is None:
        return np.zeros(3)
    if emission.radiance is not None:
        return np.array(emission.radiance)
    if emission.exitance is not None:
        return photometry.radiance_from_exitance(emission.exitance)
    if emission.luminance is not None:
        return photometry.radiance_from_luminance(emission.luminance)
    if area == 0:
        return np.zeros(3)
    if emission.radiant_flux is not None:
        return photometry.radiance_from_radiant_flux(emission.radiant_flux, area)
    return photometry.radiance_from_luminous_flux(emission.luminous_flux, area)


def _camera(name, table, up):
    view = np.subtract(table.target, table.position)
    axis = np.array(table.up or AXES[up])
    if table.up is None and _parallel(axis, view):
        axis = np.array(AXES["y" if up == "z" else "z"])
    return Camera(
        name, np.array(table.position), np.array(table.target), axis, table.fov, table.size
    )
