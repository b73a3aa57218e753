"""Material libraries: the MTL files that an OBJ file names, and what they make of its faces."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import PurePosixPath

import numpy as np

from radiosity.mesh.faces import Faces
from radiosity.scene.geometry import Geometry
from radiosity.scene.model import SceneError
from radiosity.scene.wavefront.mtl import Statements, read_mtl
from radiosity.scene.wavefront.tables import make


@dataclass(frozen=True)
class Libraries:
    """What the MTL files of an OBJ file say.

    ``materials`` by name, ``places`` the folder of the library that each comes from, relative to
    the OBJ file, ``notes`` and ``problems`` on the way.
    """

    materials: dict[str, Statements]
    places: dict[str, PurePosixPath]
    notes: tuple[str, ...]
    problems: tuple[str, ...]

    def textured(self, names) -> bool:
        """Whether any of the materials is laid over with a picture."""
        used = (self.materials[n] for n in names if n in self.materials)
        return any("map_Kd" in said.maps for said in used)


def read_libraries(
    named: list[tuple[int, str]], read_library: Callable[[str], str | None]
) -> Libraries:
    """Return what the libraries say that lines of an OBJ file name, (line, rest of it) each."""
    found, places, notes, wrong = {}, {}, [], []
    for number, rest in named:
        texts = _library_texts(number, rest, read_library, wrong)
        for name, file_text in texts.items():
            if file_text is None:
                notes.append(
                    f"line {number}: the material library {name} is not there: its materials come "
                    "from the scene file or reflect 0.5"
                )
                continue
            more, problems = read_mtl(file_text)
            found = more | found
            places = dict.fromkeys(more, PurePosixPath(name).parent) | places
            wrong += [f"line {number}: {name}: {p}" for p in problems]
            if more:
                notes.append(
                    f"{name}: Kd is read as diffuse reflectance, Ke as emitted radiance "
                    "in W/(m2 sr), the rest as docs/files.md tells"
                )
    return Libraries(found, places, tuple(notes), tuple(wrong))


def _library_texts(number, rest, read_library, problems):
    """Return {name: text or None} of the files a ``mtllib`` line names: one, or several words."""
    words, told = rest.split(), []
    for names in ([rest], words) if len(words) > 1 else ([rest],):
        texts = {}
        for name in names:
            try:
                texts[name] = read_library(name)
            except SceneError as error:
                told = [f"line {number}: mtllib {name}: {p}" for p in error.problems]
        if any(text is not None for text in texts.values()):
            return texts
    problems += told
    return {} if told else {rest: None}


def with_materials(
    geometry: Geometry, libraries: Libraries, read_picture: Callable[[str], np.ndarray], called: str
) -> Geometry:
    """Return a geometry with the materials of its libraries, their pictures and notes.

    ``read_picture`` is given names relative to the OBJ file, which is ``called`` so within the
    scene's folder: there tables name pictures.
    """
    faces, materials, pictures, told = geometry.faces, {}, {}, {}
    index = {name: k for k, name in enumerate(geometry.material_names)}
    for name, its in libraries.materials.items():
        place, mine = libraries.places[name], faces.material == index.get(name, -1)
        said = its if name in index else replace(its, maps={})
        made = make(
            said, partial(_beside, read_picture, place),
            partial(_beside, str, PurePosixPath(called).parent / place), _covered(faces, mine),
            partial(_closes, geometry.faces, mine),
        )  # fmt: skip
        materials[name], pictures = made.said, pictures | made.pictures
        for note in dict.fromkeys(made.notes if name in index else ()):
            told.setdefault(note, []).append(name)
        if made.texture is not None and made.texture.placed:
            faces = replace(faces, uv=_laid(faces.uv, mine, made.texture))
    notes = [f"materials {', '.join(n[:3])}{', ..' * (len(n) > 3)} ({len(n)}): {note}"
             for note, n in told.items()]  # fmt: skip
    return replace(
        geometry, faces=faces, materials=materials, pictures=pictures,
        notes=(*geometry.notes, *notes),
    )  # fmt: skip


def _beside(take, folder, file):
    return take(str(folder / file))


def _covered(faces, mine):
    """Whether all faces of a material have texture coordinates."""
    return faces.uv is not None and bool(np.isfinite(faces.uv[mine]).all())


def _laid(uv, mine, texture):
    """Return texture coordinates, those of one material scaled and shifted."""
    return np.where(mine[:, None, None], uv * texture.scale + np.array(texture.offset), uv)


def _closes(faces, mine):
    """Whether the faces of a material close bodies that look outward."""
    from radiosity.mesh.bodies import find_bodies

    one = Faces(faces.vertices[mine], faces.material[mine], faces.group[mine])
    bodies = find_bodies(one)
    if not len(one) or (bodies.of_face == bodies.count).any():
        return False
    v = one.vertices
    outward = np.einsum("fc,fc->f", v.mean(axis=1), np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1]))
    return bool((np.bincount(bodies.of_face, outward) > 0).all())
