"""Luminaires of a scene file: their photometric files read, and what is noted of them."""

from collections.abc import Callable

import numpy as np

from radiosity.light.luminaire import Luminaire, frame_towards
from radiosity.light.palette import NEUTRAL, Palette
from radiosity.light.photometry import EFFICACY
from radiosity.mesh.faces import Faces
from radiosity.scene.lights import IesTable
from radiosity.scene.model import SceneError
from radiosity.scene.photometric.eulumdat import read_eulumdat
from radiosity.scene.photometric.ies import read_ies
from radiosity.scene.photometric.photometric import Photometric
from radiosity.scene.schema import at

FAR = 5.0  # widths of an opening, from which on a point stands for it within 1 %
LIT = 0.02  # of the peak, above which what falls on a surface counts
GRID = 16  # points along a near face, at most
POINTS = 4096  # about in all


def read_photometric(text: str, name: str) -> Photometric:
    """Return what the text of a ``.ies`` or ``.ldt`` file says.

    Raises
    ------
    SceneError
        See `radiosity.scene.photometric.ies` and `radiosity.scene.photometric.eulumdat`.
    """
    read = read_eulumdat if name.lower().endswith(".ldt") else read_ies
    return read(text, name)


def with_photometry(
    tables: dict, read_text: Callable[[str], str] | None, problems: list[str]
) -> dict:
    """Return the tables of lights with the files read that luminaires name, each once.

    What is wrong with a file becomes problems, and its luminaires are left out.
    """
    files, found = {}, {}
    for k, table in tables.items():
        if not isinstance(table, IesTable):
            found[k] = table
            continue
        if table.file not in files:
            path = ("lights", k, "file")
            files[table.file] = _read(table.file, path, read_text, problems)
        if files[table.file] is not None:
            found[k] = table.model_copy(update={"file": files[table.file]})
    return found


def _read(name, path, read_text, problems):
    if read_text is None:
        problems.append(at(path, name, "cannot be read here: the scene has no folder"))
        return None
    try:
        return read_photometric(read_text(name), name)
    except SceneError as error:
        problems += [at(path, name, text) for text in error.problems]
        return None


def make_luminaire(table: IesTable, axis: np.ndarray, palette: Palette, up: str) -> Luminaire:
    """Return the luminaire of a table whose file was read, of neutral light."""
    shares, peak = table.file.distribution
    if table.luminous_flux is not None:
        peak = table.luminous_flux / shares.solid_angle
    return Luminaire(
        np.array(table.position), palette.light(NEUTRAL) * (peak / EFFICACY), group=table.group,
        frame=frame_towards(axis, np.radians(table.roll), up), distribution=shares,
        label=table.file.label,
    )  # fmt: skip


def luminaire_notes(tables: dict, lights: list, faces: Faces, unit_m: float) -> list[str]:
    """Return what is noted of photometric files, and of openings that are no points, once a file.

    Parameters
    ----------
    tables : dict of tables by number
    lights : list
        What was made of each of them.
    faces : Faces
    unit_m : float
        Of the scene's unit.
    """
    notes, near = [], {}
    for table, light in zip(tables.values(), lights, strict=True):
        if not isinstance(table, IesTable):
            continue
        notes += [f"{table.file.file}: {note}" for note in table.file.notes]
        distance = _nearest_lit(light, faces, FAR * table.file.opening / unit_m) * unit_m
        if distance < FAR * table.file.opening:
            near.setdefault(table.file.file, []).append((distance, table.file.opening))
    for name, found in near.items():
        distance, opening = min(found)
        notes.append(
            f"{name}: is modelled as a point, but lights surfaces {distance:.3g} m away, and its "
            f"opening is {opening:.3g} m wide: nearer than {FAR * opening:.3g} m, five times its "
            "width, illuminances are rough"
        )
    return list(dict.fromkeys(notes))


def _nearest_lit(light, faces, within):
    """Return how far the nearest point is that a luminaire lights; inf where none is ``within``."""
    closest = _closest(light.position, faces)
    near = np.flatnonzero(np.linalg.norm(closest - light.position, axis=1) < within)
    if not len(near):
        return np.inf
    side = int(np.clip(np.sqrt(POINTS / len(near)), 1, GRID))
    s, t = np.stack(np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2)).reshape(2, -1, 1)
    v = faces.vertices[near][:, :, None]
    points = (1 - t) * ((1 - s) * v[:, 0] + s * v[:, 1]) + t * ((1 - s) * v[:, 3] + s * v[:, 2])
    points = np.concatenate([closest[near], points.reshape(-1, 3)])
    to_light, distance, _ = light.reaching(points, 1.0)
    normal = np.concatenate([faces.normals()[near], np.repeat(faces.normals()[near], side**2, 0)])
    strength = light.shape(-to_light) * np.abs(np.einsum("kc,kc->k", to_light, normal))
    lit = (strength > LIT) & (distance > 0.0) & (distance < within)
    return distance[lit].min(initial=np.inf)


def _closest(point, faces):
    """Return the points (f, 3) of faces that are closest to a point: its foot, or on an edge."""
    v, normal = faces.vertices - point, faces.normals()
    edge = np.roll(v, -1, axis=1) - v
    length = np.maximum(np.einsum("fkc,fkc->fk", edge, edge), np.finfo(float).tiny)
    along = np.clip(-np.einsum("fkc,fkc->fk", v, edge) / length, 0.0, 1.0)
    on_edges = v + along[..., None] * edge
    k = np.linalg.norm(on_edges, axis=2).argmin(axis=1)
    foot = np.einsum("fc,fc->f", v[:, 0], normal)[:, None] * normal
    beside = np.einsum("fkc,fkc->fk", np.cross(edge, foot[:, None] - v), normal[:, None])
    inside = (beside >= 0.0).all(axis=1)[:, None]
    return point + np.where(inside, foot, on_edges[np.arange(len(v)), k])
