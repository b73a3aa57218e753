"""Files for other programs: a solution as a mesh, a table or arrays."""

from os import PathLike
from pathlib import Path

import numpy as np

from radiosity.light.bands import Bands
from radiosity.light.photometry import illuminance
from radiosity.solve.solution import Solution, refuse_unsolved
from radiosity.transport.files import written_whole
from radiosity.transport.threads import Progress, silent
from radiosity.view.polydata import SIDES, shown_patches, to_pyvista

COLUMNS = (
    *("index", "face", "material", "group", "side"),
    *("x", "y", "z", "nx", "ny", "nz", "area_m2"),
)
BANDED = "emission", "irradiance", "radiosity"  # then a column each for each band, and the rest
REST = "illuminance_lx", "error_lx"


def check_suffix(path: str | PathLike, lightmap: int | None = None) -> None:
    """Refuse a file that `save` could not write, before anything is solved.

    Raises
    ------
    ValueError
        The suffix is not one of the supported, which the message names, or has no ``lightmap``.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in (*_WRITERS, ".html"):
        raise ValueError(
            f"solution file {str(path)!r} has the suffix {suffix!r}; supported are "
            ".radsol (all of it, to be loaded again), .vtp (mesh for ParaView and pyvista), "
            ".glb (model with baked colours), .html (page for any browser), "
            ".csv (one row a patch), .npz (numpy arrays)"
        )
    if lightmap is not None:
        from radiosity.view.unwrap import check_size

        if suffix != ".glb":
            raise ValueError(f"lightmap = {lightmap} is for .glb: {suffix} has no texels")
        check_size(lightmap)


def save(
    solution: Solution,
    path: str | PathLike,
    *,
    lightmap: int | None = None,
    progress: Progress = silent,
) -> None:
    """Write a solution: whole, or not at all.

    ``.radsol`` holds all of it: `radiosity.load` returns the solution again, see docs/radsol.md;
    ``.vtp`` holds the mesh of `to_pyvista`; ``.csv`` the columns of `columns`, one row a patch,
    in full precision; ``.npz`` plain arrays (no pickle) named as in `arrays`. All leave out the
    fronts that another face covers. Coordinates are in scene units.

    ``.glb`` is a glTF model, in metres with y up, whose colours are baked: into its vertices, see
    `radiosity.view.baked.write_baked`, or with ``lightmap`` = N into N x N texels, which are
    written beside it too, see `radiosity.view.lightmap.save_lightmap`.

    ``.html`` is a page that shows the solution in any browser, see `radiosity.view.page.page`.

    Raises
    ------
    ValueError
        For any other suffix; a lightmap for what is not ``.glb``, or of a size out of range.
    OSError
        Where the file cannot be written.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1)
    >>> radiosity.save(solution, "room.csv")
    >>> open("room.csv").read()[:11]
    'index,face,'
    """
    refuse_unsolved(solution)
    check_suffix(path, lightmap)
    if lightmap is not None:
        from radiosity.view.lightmap import save_lightmap

        save_lightmap(solution, Path(path), lightmap, progress)
        return
    if Path(path).suffix.lower() == ".html":
        from radiosity.view.page.page import write_page

        write_page(solution, path, progress=progress)
        return
    with written_whole(path) as temporary:
        _WRITERS[Path(path).suffix.lower()](solution, temporary)


def columns(bands: Bands) -> tuple[str, ...]:
    """Return the heads of the columns of a ``.csv`` file."""
    banded = (f"{what}_{name}_W_m2" for what in BANDED for name in bands.names)
    return (*COLUMNS, *banded, *REST)


def arrays(solution: Solution) -> dict[str, np.ndarray]:
    """Return the patches as named arrays, all rows in the same order.

    ``vertices`` (n, 4, 3), counter-clockwise seen from the active side, a triangle repeats its
    last; ``normal``, ``centroid`` (n, 3); ``area_m2``, ``illuminance_lx``, ``error_lx`` (n,);
    ``emission``, ``irradiance``, ``radiosity`` (n, bands) in W/m2, ``reflectance`` (n, bands),
    with the ``bands``' names; integers (n,) ``index``
    (of the patch in the solution), ``face``, ``material``, ``group``, ``side``, the last three
    into ``material_names``, ``group_names``, ``side_names``; ``scene``, ``unit``, ``unit_m``.
    """
    scene, patches, shown = solution.scene, solution.patches, shown_patches(solution)
    face = patches.face[shown]
    return {
        "index": shown,
        "vertices": patches.vertices[shown],
        "normal": patches.normal[shown] + 0.0,  # no -0.0
        "centroid": patches.centroid[shown],
        "area_m2": patches.area[shown] * scene.unit_m**2,
        "face": face,
        "material": scene.faces.material[face],
        "group": scene.faces.group[face],
        "side": (~patches.front[shown]).astype(np.uint8),
        "emission": solution.emission[shown],
        "reflectance": solution.reflectance[shown],
        "irradiance": solution.irradiance_on[shown],
        "radiosity": solution.radiosity[shown],
        "illuminance_lx": solution.illuminance[shown],
        "error_lx": illuminance(solution.error[shown], scene.bands),
        "material_names": np.array([m.name for m in scene.materials], dtype=np.str_),
        "group_names": np.array(scene.groups, dtype=np.str_),
        "side_names": np.array(SIDES, dtype=np.str_),
        "bands": np.array(scene.bands.names, dtype=np.str_),
        "scene": np.array(scene.name, dtype=np.str_),
        "unit": np.array(scene.unit, dtype=np.str_),
        "unit_m": np.array(scene.unit_m),
    }


def _write_vtp(solution, path):
    to_pyvista(solution).save(path)


def _write_glb(solution, path):
    from radiosity.view.baked import write_baked

    write_baked(solution, path)


def _write_npz(solution, path):
    with open(path, "wb") as file:
        np.savez_compressed(file, **arrays(solution))


def _write_csv(solution, path):
    import csv

    a = arrays(solution)
    values = [
        a["index"],
        a["face"],
        a["material_names"][a["material"]],
        a["group_names"][a["group"]],
        a["side_names"][a["side"]],
        *a["centroid"].T,
        *a["normal"].T,
        a["area_m2"],
        *a["emission"].T,
        *a["irradiance"].T,
        *a["radiosity"].T,
        a["illuminance_lx"],
        a["error_lx"],
    ]
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns(solution.scene.bands))
        writer.writerows(zip(*(c.tolist() for c in values), strict=True))


def _write_radsol(solution, path):
    from radiosity.solve.container import write_solution

    write_solution(solution, path)


_WRITERS = {
    ".radsol": _write_radsol, ".vtp": _write_vtp, ".glb": _write_glb, ".csv": _write_csv,
    ".npz": _write_npz,
}  # fmt: skip
