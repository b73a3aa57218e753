"""Files: what may be read from disk, and which reader reads it."""

import difflib
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

from radiosity.light.palette import ACCURACY, kind_of
from radiosity.scene.assemble import geometry_problem
from radiosity.scene.geometry import Geometry
from radiosity.scene.model import Scene, SceneError
from radiosity.scene.wavefront.obj import read_obj

LARGEST = 2**30  # bytes


def load(
    path: str | Path, merge: bool = True, bands: str | int = "auto", accuracy: float = ACCURACY,
    unit: str | None = None, up: str | None = None,
) -> Scene:  # fmt: skip
    """Return the scene of a TOML file, or of a bare geometry file.

    Parameters
    ----------
    path : str or Path
        ``.toml``, or ``.obj``, ``.ply``, ``.stl`` or ``.rad``: then in metres, z up, with default
        material and camera where the file says nothing else, which `Scene.notes` mentions; or
        ``.glb`` or ``.gltf``, in metres, y up.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    bands : str or int
        ``grey`` (the luminance only), ``rgb``, ``spectral``, a number of wavelengths, or ``auto``:
        spectral where a colour comes from a spectrum's file, otherwise rgb.
    accuracy : float
        That answers will be asked for: of spectra it chooses how many wavelengths.
    unit, up : str, optional
        Of a bare geometry file: ``m``, ``cm``, ``mm``, ``in`` or ``ft``, and ``x``, ``y`` or ``z``.

    Raises
    ------
    SceneError
        Lists everything that is wrong with the file and with those it names.
    ValueError
        Unknown ``bands``; ``unit`` or ``up`` of a scene file, which has its own.

    Examples
    --------
    >>> scene = load("scenes/box6.toml")
    >>> scene.name, len(scene.faces), scene.unit
    ('Room of six faces', 6, 'm')
    """
    path = Path(path)
    kind_of(bands, False, accuracy)
    if path.suffix.lower() != ".toml":
        return _bare(path, merge, bands, accuracy, {"unit": unit, "up": up})
    if unit is not None or up is not None:
        raise ValueError(f"{path} says its unit and up itself: leave out unit and up, or edit it")
    from radiosity.scene.toml import read_toml  # pydantic takes 0.2 s to import

    text = _decoded(read_bytes(path), path)
    named, picture, spectrum = (partial(read, path.parent) for read in (_named, _picture, _text_of))
    return read_toml(
        text, str(path), partial(named, merge), path.stem, merge, picture, spectrum, bands, accuracy
    )


def read_geometry(
    path: str | Path, folder: Path | None = None, merge: bool = True, uv: bool = False
) -> Geometry:
    """Return the geometry of an OBJ, PLY, STL, Radiance or glTF file.

    Parameters
    ----------
    path : str or Path
    folder : Path, optional
        The folder outside which nothing is read; None if the user named the file.
    merge : bool
        Join pairs of coplanar triangles, see `Faces.from_polygons`.
    uv : bool
        Read texture coordinates, of OBJ, PLY and glTF files.

    Raises
    ------
    SceneError
        If the file is not there, lies outside the folder, is of another format or is broken.
    """
    path = Path(path)
    readers = {
        ".obj": _obj, ".ply": _ply, ".stl": _stl, ".rad": _rad, ".glb": _gltf, ".gltf": _gltf,
    }  # fmt: skip
    reader = readers.get(path.suffix.lower())
    if reader is None:
        suffix = f'the suffix "{path.suffix}"' if path.suffix else "no suffix"
        known = f"scenes are .toml files, geometry is read from {', '.join(readers)}"
        folder_named = "is a folder: name a file in it" if path.is_dir() else None
        raise SceneError(str(path), [folder_named or f"has {suffix}: {known}"])
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


def _is_inside(path, folder):
    try:
        return path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError) as error:
        raise SceneError(str(path), [f"cannot be read: {error}"]) from None


def _check_inside(path, folder):
    if not _is_inside(path, folder):
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
    """Return the text of a file that a scene file names, relative to its folder.

    Spectra are in UTF-8; photometric files are older than that, and may be in Latin-1.
    """
    path = folder / name
    _check_inside(path, folder)
    data = read_bytes(path)
    if path.suffix.lower() == ".csv":
        return _decoded(data, path)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _rad(path, folder, merge, uv):
    from radiosity.scene.radiance.rad import read_rad  # few scenes need it

    text = _loosely_decoded(read_bytes(path))
    return read_rad(text, str(path), partial(_text_beside, path, folder), merge)


def _beside(path, folder, name):
    """Return the path of a file that a geometry file names, relative to its own folder.

    Where there is none in the folder that it names, one right beside the geometry file is taken.

    Raises
    ------
    SceneError
        It is in neither place, and the named one lies outside of the scene's folder.
    """
    named = path.parent / name.replace("\\", "/")
    for place in (named, path.parent / named.name):
        if _is_inside(place, folder) and _is_file(place):
            return place
    _check_inside(named, folder)
    return named


def _is_file(path):
    """Whether a file is there; names that no system allows are none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _text_beside(path, folder, name):
    """Return the text of a file that a geometry file names, None if there is none."""
    beside = _beside(path, folder, name)
    return _loosely_decoded(read_bytes(beside)) if _is_file(beside) else None


def _obj(path, folder, merge, uv):
    text = _loosely_decoded(read_bytes(path))
    picture = cache(partial(_picture_beside, path, folder))  # several materials may show it
    library = partial(_text_beside, path, folder)
    return read_obj(text, str(path), library, merge, uv, picture, _called(path, folder))


def _picture_beside(path, folder, name):
    """Return the pixels of a picture that a geometry file names, relative to its own folder."""
    from radiosity.scene.textures import read_picture

    return read_picture(_beside(path, folder, name), read_bytes)


def _loosely_decoded(data):
    """Return text of any encoding that has ASCII digits; comments may hold anything."""
    text = data.decode("utf-8-sig", errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _gltf(path, folder, merge, uv):
    from radiosity.scene.gltf.gltf import read_gltf

    def read_file(name):
        return read_bytes(_beside(path, folder, name))

    return read_gltf(read_bytes(path), str(path), read_file, merge, uv, _called(path, folder))


def _called(path, folder):
    """Return the name of a file within the scene's folder."""
    place = path.parent.resolve() / path.name
    inside = place.is_relative_to(folder.resolve())
    return place.relative_to(folder.resolve()).as_posix() if inside else path.name


def _ply(path, folder, merge, uv):
    from radiosity.scene.meshes.ply import read_ply

    return read_ply(read_bytes(path), str(path), path.stem, merge, uv)


def _stl(path, folder, merge, uv):
    from radiosity.scene.meshes.stl import read_stl

    return read_stl(read_bytes(path), str(path), path.stem, merge)


def _bare(path, merge, bands, accuracy, frame):
    """Return a scene of one geometry file and nothing else."""
    from radiosity.scene.schema import at
    from radiosity.scene.toml import read_tables
    from radiosity.scene.units import UNITS

    frame = {key: value for key, value in frame.items() if value is not None}
    for key, known in (("unit", UNITS), ("up", "xyz")):
        if key in frame and frame[key] not in list(known):
            raise ValueError(at((key,), frame[key], f"must be one of {', '.join(known)}"))
    geometry = read_geometry(path, None, merge)
    block = {"file": path.name, **frame}
    if not frame and geometry.unit is None:
        note = "lengths are taken as metres and z as up: --unit, --up or a scene file say otherwise"
        geometry = replace(geometry, notes=(*geometry.notes, note))
    return read_tables(
        {"geometry": [block], **frame}, str(path), lambda name, uv: geometry, path.stem, merge,
        bands=bands, accuracy=accuracy,
    )  # fmt: skip
