"""Assembling: materials and a camera for a geometry, and the defaults where a scene has none."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radiosity.light.palette import Nanometres, Palette, Rgb, of_source
from radiosity.mesh.faces import Faces
from radiosity.scene.geometry import DEFAULT, LONGEST, Geometry
from radiosity.scene.model import Camera, Material, Scene
from radiosity.scene.repair import repaired
from radiosity.scene.units import extent_notes

DEFAULT_REFLECTANCE = 0.5
DEFAULT_FOV = 40.0
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
FROM = {"x": (0.45, 0.5, -0.8), "y": (0.5, 0.45, 0.8), "z": (0.5, -0.8, 0.45)}


def geometry_problem(geometry: Geometry) -> str | None:
    """Return what makes a geometry useless, as a sentence, or None."""
    faces = geometry.faces
    if len(faces) == 0:
        return f"there is nothing to light: none of its {faces.degenerate} faces has an area"
    farthest = np.abs(faces.vertices).max()
    if not farthest <= LONGEST:
        return f"a vertex lies {farthest:.3g} from the origin, at most {LONGEST:g} can be computed"
    if not faces.areas().all():
        return "a face is too small for its area to be computed: choose a smaller unit"
    return None


def with_materials(
    geometry: Geometry, defined: dict[str, Material], bands: int
) -> tuple[Faces, tuple[Material, ...], list[str]]:
    """Return the faces with indices into a table of materials, the table and notes.

    All defined materials come first, in their order, whether used or not; what is not defined is
    grey, which is noted.
    """
    table, notes = dict(defined), []
    for name in geometry.material_names:
        if name not in table:
            named = "faces without a material" if name == DEFAULT else f'material "{name}"'
            notes.append(
                f"{named}: not defined, reflects {DEFAULT_REFLECTANCE:g} of all light; "
                f"[materials.{name}] defines it"
            )
            grey = np.full(bands, DEFAULT_REFLECTANCE)
            table[name] = Material(name, grey, 1 - grey, np.zeros(bands))
    unused = [name for name in defined if name not in geometry.material_names]
    notes += [f'material "{name}" is defined but no face has it' for name in unused]
    place = {name: k for k, name in enumerate(table)}
    index = np.array([place[name] for name in geometry.material_names], int)
    old = geometry.faces
    faces = replace(old, material=index[old.material])
    if old.degenerate:
        notes.append(f"{old.degenerate} faces without area were left out")
    if old.duplicates:
        notes.append(f"{old.duplicates} faces that repeat another one were left out")
    return faces, tuple(table.values()), notes


def as_solved(
    faces: Faces, materials: tuple[Material, ...], geometry: Geometry, unit: str, source: str
) -> tuple[Faces, list[str]]:
    """Return the faces as they are solved, turned where `repaired` says so, and notes.

    Raises
    ------
    SceneError
        See `repaired`.
    """
    fixed = [name in geometry.fixed for name in geometry.group_names]
    faces, notes = repaired(faces, materials, np.array(fixed, bool)[faces.group], source)
    return faces, notes + extent_notes(faces, unit)


def in_bands(kind: str | int, has_spectra: bool, make: Callable[[Palette], Scene]) -> Scene:
    """Return the scene that ``make`` returns of the palette of a kind.

    Where the light that there is decides what is grey, or how spectra look, it is added up before.
    """
    source = None
    if kind == "grey" or (kind == "rgb" and has_spectra):
        source = _light_in(make(Nanometres() if has_spectra else Rgb()))
    return make(of_source(kind, source))


def _light_in(scene: Scene) -> np.ndarray:
    """Return (bands,) the watts that all lights of a scene send out.

    What comes from afar counts with what falls on a sphere about the scene.
    """
    faces, emission = scene.faces, np.array([m.emission for m in scene.materials])
    total = np.pi * scene.unit_m**2 * faces.areas() @ emission[faces.material]
    section = np.pi * (scene.unit_m * np.ptp(faces.vertices, (0, 1)).max() / 2.0) ** 2
    for light in scene.lights:
        total = total + light.strength * getattr(light, "solid_angle", section)
    return total + 4.0 * np.pi * section * scene.ambient


def default_camera(faces: Faces, up: str) -> Camera:
    """Return a camera outside that looks at the centre and sees all vertices."""
    low, high = faces.vertices.min(axis=(0, 1)), faces.vertices.max(axis=(0, 1))
    centre, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    direction = np.array(FROM[up]) / np.linalg.norm(FROM[up])
    distance = 1.05 * radius / np.sin(np.radians(DEFAULT_FOV / 2))
    position = centre + distance * direction
    return Camera(DEFAULT, position, centre, np.array(AXES[up]), DEFAULT_FOV, (512, 512))
