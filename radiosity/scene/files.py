"""Files: what may be read from disk, and which reader reads it."""

import difflib
import io
from functools import partial
from pathlib import Path

import numpy as np

from radiosity.light.palette import ACCURACY, kind_of
from radiosity.mesh.faces import Faces, has_area
from radiosity.mesh.given import Given
from radiosity.scene.assemble import default_camera, geometry_problem, in_bands, with_materials
from radiosity.scene.geometry import DEFAULT, LONGEST, Geometry
from radiosity.scene.model import Scene, SceneError
from radiosity.scene.obj import read_obj

LARGEST = 2**30  # bytes


def load(
    path: str | Path, merge: bool = True, bands: str | int = "auto", accuracy: float = ACCURACY
) -> Scene:
    """Return the scene of a TOML file, or of a bare geometry file.

    Parameters
    ----------
    path : str or Path
        ``.toml``, or ``.obj``, ``.ply`` or ``.stl``: then in metres, z up, with default material
        and camera where the file says nothing else, which `Scene.notes` mentions.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    bands : str or int
        ``grey`` (the luminance only), ``rgb``, ``spectral``, a number of wavelengths, or ``auto``:
        spectral where a colour comes from a spectrum's file, otherwise rgb.
    accuracy : float
        That answers will be asked for: of spectra it chooses how many wavelengths.

    Raises
    ------
    SceneError
        Lists everything that is wrong with the file and with those it names.
    ValueError
        Unknown ``bands``.

    Examples
    --------
    >>> scene = load("scenes/box6.toml")
    >>> scene.name, len(scene.faces), scene.unit
    ('Room of six faces', 6, 'm')
    """
    path = Path(path)
    kind = kind_of(bands, False, accuracy)
    if path.suffix.lower() != ".toml":
        return _bare(path, merge, kind)
    from radiosity.scene.toml import read_toml  # pydantic takes 0.2 s to import

    text = _decoded(read_bytes(path), path)
    named, picture, spectrum = (partial(read, path.parent) for read in (_named, _picture, _text_of))
    return read_toml(
        text, str(path), partial(named, merge), path.stem, merge, picture, spectrum, bands, accuracy
    )


def read_geometry(
    path: str | Path, folder: Path | None = None, merge: bool = True, uv: bool = False
) -> Geometry:
    """Return the geometry of an OBJ, PLY or STL file.

    Parameters
    ----------
    path : str or Path
    folder : Path, optional
        The folder outside which nothing is read; None if the user named the file.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    uv : bool
        Read texture coordinates; only OBJ files have them here.

    Raises
    ------
    SceneError
        If the file is not there, lies outside the folder, is of another format or is broken.
    """
    path = Path(path)
    readers = {".obj": _obj, ".ply": _trimesh, ".stl": _trimesh}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        suffix = f'the suffix "{path.suffix}"' if path.suffix else "no suffix"
        raise SceneError(
            str(path),
            [f"has {suffix}: scenes are .toml files, geometry is read from .obj, .ply and .stl"],
        )
    if folder is not None:
        _check_inside(path, folder)
    geometry = reader(path, folder or path.parent, merge, uv)
    problem = geometry_problem(geometry)
    if problem:
        raise SceneError(str(path), [problem])
    return geometry


def read_bytes(path: Path) -> bytes:
    """Return the content of a regular file of at most 1 GiB; raise SceneError otherwise."""
    problem = file_problem(path)
    if problem is None:
        try:
            return path.read_bytes()
        except OSError as error:
            problem = f"cannot be read: {error.strerror}"
    raise SceneError(str(path), [problem])


def file_problem(path: Path, largest: int = LARGEST) -> str | None:
    """Return why a path is no file of at most so many bytes to read, or None."""
    try:
        if path.is_dir():
            return "is a folder: name a file in it"
        if not path.exists():
            return f"does not exist{_like(path)}"
        if not path.is_file():
            return "is not a regular file"
        size = path.stat().st_size
    except (OSError, ValueError) as error:
        return f"cannot be read: {error}"
    if size > largest:
        most = f"at most {largest} ({largest >> 30} GiB) are read"
        return f"has {size} bytes, {most}: reduce the mesh"
    return None


def _like(path):
    """Return a question with the most similar name in the folder, the endings set aside."""
    if not path.parent.is_dir():
        return f": there is no folder {path.parent}"
    stems = difflib.get_close_matches(path.stem, [p.stem for p in path.parent.iterdir()])
    names = [p.name for p in path.parent.iterdir() if p.stem in stems]
    like = difflib.get_close_matches(path.name, names, n=1)
    return f": did you mean {like[0]}?" if like else ""


def _check_inside(path, folder):
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError) as error:
        raise SceneError(str(path), [f"cannot be read: {error}"]) from None
    if not inside:
        raise SceneError(
            str(path),
            [
                f"lies outside the scene's folder {folder.resolve()}, and a scene reads only what "
                "lies under it: copy the file there"
            ],
        )


def _decoded(data, path):
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SceneError(
            str(path), [f"line {line} is not UTF-8: save the file in that encoding"]
        ) from None


def _named(folder, merge, name, uv):
    """Return the geometry that a scene file names, relative to its folder."""
    return read_geometry(folder / name, folder, merge, uv)


def _picture(folder, name):
    """Return the pixels of a picture that a scene file names, relative to its folder."""
    from radiosity.scene.textures import read_picture

    path = folder / name
    _check_inside(path, folder)
    return read_picture(path, read_bytes)


def _text_of(folder, name):
    """Return the text of a spectrum that a scene file names, relative to its folder."""
    path = folder / name
    _check_inside(path, folder)
    return _decoded(read_bytes(path), path)


def _obj(path, folder, merge, uv):
    def read_library(name):
        library = path.parent / name
        _check_inside(library, folder)
        if not library.is_file():
            return None
        return _loosely_decoded(read_bytes(library))

    return read_obj(_loosely_decoded(read_bytes(path)), str(path), read_library, merge, uv)


def _loosely_decoded(data):
    """Return text of any encoding that has ASCII digits; comments may hold anything."""
    text = data.decode("utf-8-sig", errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _trimesh(path, folder, merge, uv):
    """Return what trimesh reads of a PLY or STL file, checked."""
    import trimesh  # takes 0.3 s

    data = read_bytes(path)
    try:
        with np.errstate(all="ignore"):  # it computes normals of vertices not yet checked
            mesh = trimesh.load_mesh(io.BytesIO(data), path.suffix.lower()[1:], process=False)
        vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
    except Exception as error:  # a reader of other people's files fails in any way
        kind = path.suffix[1:].upper()
        problem = f"is not a {kind} file that can be read: {type(error).__name__}: {error}"
        raise SceneError(str(path), [problem]) from error
    problems = _array_problems(vertices, faces)
    if problems:
        raise SceneError(str(path), problems)
    triangles = vertices[faces]
    made = Faces.from_triangles(triangles, 0, 0, merge)
    solid = np.flatnonzero(has_area(triangles[:, [0, 1, 2, 2]]))
    given = None if merge else Given(made, solid, len(faces))
    return Geometry(made, (DEFAULT,), (path.stem,), given=given)


def _array_problems(vertices, faces):
    """Return what is wrong with vertices (n, 3) and triangles (t, 3)."""
    if faces.ndim != 2 or faces.shape[0] == 0:
        return ["has no faces: nothing can be lit"]
    problems = []
    bad = np.flatnonzero(~(np.abs(vertices) <= LONGEST).all(axis=1))
    if len(bad):
        value = vertices[bad[0]].tolist()
        problems.append(f"vertex {bad[0]} = {value} must be finite and at most {LONGEST:g}")
    lost = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))
    if len(lost):
        problems.append(
            f"face {lost[0]} = {faces[lost[0]].tolist()} names a vertex that does not exist: "
            f"there are {len(vertices)}, counted from 0"
        )
    return problems


def _bare(path, merge, kind):
    """Return a scene of one geometry file and nothing else."""
    return in_bands(kind, False, partial(_furnished, path, read_geometry(path, None, merge)))


def _furnished(path, geometry, palette):
    """Return a scene with what a geometry file says, and the defaults for what it does not."""
    faces, materials, notes = with_materials(geometry, {}, palette)
    notes.append("lengths are taken as metres and z as up; a .toml scene can say otherwise")
    notes.append("no camera is given: one outside looks at the whole scene")
    camera = default_camera(faces, "z")
    return Scene(
        name=path.stem,
        faces=faces,
        materials=materials,
        groups=geometry.group_names,
        cameras={camera.name: camera},
        source=str(path),
        notes=(*geometry.notes, *notes),
        bands=palette.bands,
    )
