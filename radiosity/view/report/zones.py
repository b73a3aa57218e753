"""Zones that a lighting is judged by: work plane, floor and surfaces, and what light they have."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.photometry import illuminance
from radiosity.scene.model import Scene
from radiosity.solve.solution import Solution
from radiosity.view.grids import height_of, make_grid
from radiosity.view.pointgrid import Evenness, PointGrid, evenness
from radiosity.view.surfacegrid import surface_cells, surface_grid
from radiosity.view.workplane import plane_cells, plane_grid, roofed

DESK = 0.75  # metres over the lowest point
ROOM = 2.0, 1.5  # metres that a room is high and wide at least
UNDER_ROOF = 0.5  # of the points of a room's plane
MOST_FACES, MOST_POINTS = 200, 5000  # of a surface that gets a grid


@dataclass(frozen=True)
class Zone:
    """A plane or a surface, and the illuminance there.

    Attributes
    ----------
    name : str
    grid : str
        What ``probe --grid`` calls it.
    kind : str
        ``plane`` or ``surface``.
    points : int
        Of the grid; of ``patches`` where there is none.
    left_out : int
        Points of the grid that do not count.
    spacing : tuple of two floats
        Sides of a cell in scene units; () where there is no grid.
    margin : float
        Scene units.
    found : Evenness
    where : PointGrid or None
        The points, None of patches.
    lux : (k,) float64
        Illuminance there.
    """

    name: str
    grid: str
    kind: str
    points: int
    left_out: int
    spacing: tuple[float, ...]
    margin: float
    found: Evenness
    where: PointGrid | None
    lux: np.ndarray


def zone_of(
    solution: Solution, grid: str, spacing: float | None = None, margin: float | None = None,
    name: str = "",
) -> Zone:  # fmt: skip
    """Return what ``probe --grid`` tells of a plane, by its height, or of a surface, by its name.

    Raises
    ------
    ValueError
        See `radiosity.view.grids.make_grid`.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/furnace.toml"), 0.1)
    >>> zone = zone_of(solution, "0.75")
    >>> zone.name, round(zone.found.mean, 1), round(zone.found.u0, 3)
    ('Plane at z = 0.75 m', 2258.7, 1.0)
    """
    points = make_grid(solution, grid, spacing, margin)
    if height_of(grid) is None:
        return _measured(solution, name or f"Surface {grid}", grid, "surface", points)
    words = f"Plane at {solution.scene.up} = {height_of(grid):g} {solution.scene.unit}"
    return _measured(solution, name or words, grid, "plane", points)


def default_planes(
    solution: Solution, spacing: float | None = None, margin: float | None = None
) -> tuple[list[Zone], list[str]]:
    """Return the floor and, of a room, the work plane; and why one of them is not there.

    Raises
    ------
    ValueError
        An impossible spacing or margin.
    """
    scene = solution.scene
    low = lowest(scene)
    if spacing is not None or margin is not None:
        plane_cells(scene, low, spacing, margin)
    desk, why = low + DESK / scene.unit_m, _no_room(scene)
    found, said = [], []
    if not why:
        try:
            points = plane_grid(solution, desk, spacing, margin)
        except ValueError as error:
            why = str(error)
        else:
            if roofed(solution, points) < UNDER_ROOF:
                why = "nothing is above most of it, so the scene is no room"
            else:
                found.append(_level(solution, "Work plane", desk, points))
    if why:
        said.append(f"No work plane at {DESK:g} m: {why}. --grid HEIGHT takes one.")
    try:
        floor = _level(solution, "Floor", low, plane_grid(solution, low, spacing, margin))
    except ValueError:
        floor = None
    if floor is None or floor.lux.max() == 0.0 < solution.illuminance.max():
        said.append("No floor: nothing at the scene's lowest height faces up and is lit.")
    else:
        found.append(floor)
    return found, said


def lowest(scene: Scene) -> float:
    """Return the height of a scene's lowest point, scene units."""
    return float(scene.faces.vertices[..., "xyz".index(scene.up)].min())


def _level(solution, name, height, points) -> Zone:
    """Return the zone of a plane at a height."""
    scene = solution.scene
    words = f"{name}, {scene.up} = {height:.6g} {scene.unit}"
    return _measured(solution, words, repr(height), "plane", points)


def _no_room(scene: Scene) -> str:
    """Return why a scene is no room, "" where it may be one."""
    size = np.ptp(scene.faces.vertices, axis=(0, 1)) * scene.unit_m
    up = "xyz".index(scene.up)
    wide = float(np.delete(size, up).min())
    if size[up] < ROOM[0] or wide < ROOM[1]:
        return (
            f"the scene is {size[up]:.3g} m high and {wide:.3g} m wide, less than a room of "
            f"{ROOM[0]:g} m and {ROOM[1]:g} m"
        )
    return ""


def default_surfaces(solution: Solution) -> tuple[list[Zone], list[str]]:
    """Return a zone for each material in use that reflects, and the names of those without light.

    Surfaces of many small faces are told by their patches, whose means by area are exact.
    """
    scene, found, dark = solution.scene, [], []
    for k in np.unique(scene.faces.material):
        material = scene.materials[k]
        if material.emits and not material.diffuse.any():
            continue  # a lamp, which nobody lights
        few = int((scene.faces.material == k).sum()) <= MOST_FACES
        if few and _count(scene, material.name) <= MOST_POINTS:
            try:
                points = surface_grid(solution, material.name)
            except ValueError:
                dark.append(material.name)
                continue
            zone = _measured(solution, material.name, material.name, "surface", points)
        else:
            zone = _of_patches(solution, k)
        if zone is None:
            dark.append(material.name)
        else:
            found.append(zone)
    return found, dark


def _count(scene, name) -> float:
    planes, step = surface_cells(scene, name)
    return sum(float(np.prod(np.maximum(p.sides / step, 1.0))) for p in planes)


def _of_patches(solution, k) -> Zone | None:
    """Return the zone of a material's lit patches, None where none is lit."""
    scene, patches = solution.scene, solution.patches
    mine = np.flatnonzero((scene.faces.material[patches.face] == k) & solution.live)
    if not len(mine):
        return None
    lux, error = solution.illuminance[mine], illuminance(solution.error[mine], scene.bands)
    found = evenness(lux, error, patches.area[mine])
    name = scene.materials[k].name
    return Zone(name, name, "surface", len(mine), 0, (), 0.0, found, None, lux)


def _measured(solution, name, grid, kind, points: PointGrid) -> Zone:
    irradiance, error = solution.irradiance(points.points, points.normals)
    lux, off = (illuminance(x, solution.scene.bands) for x in (irradiance, error))
    return Zone(
        name, grid, kind, len(points.points), points.left_out, points.spacing, points.margin,
        evenness(lux, off), points, lux,
    )  # fmt: skip
