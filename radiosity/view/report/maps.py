"""Illuminance over a zone on cells fine enough for a map, in metres as one looks at it."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.photometry import illuminance
from radiosity.solve.solution import Solution
from radiosity.view.grids import height_of
from radiosity.view.report.zones import Zone
from radiosity.view.surfacegrid import points_on, surface_cells
from radiosity.view.workplane import plane_axes, plane_cells, plane_grid, walls_at

FINE = 56  # cells along the longer side of a map
UPRIGHT = 0.99  # cosine to the vertical beyond which a plane is seen from above
ABOVE = {"x": "yz", "y": "xz", "z": "xy"}  # axes to the right and, of y downwards, up, by `up`


@dataclass(frozen=True)
class Map:
    """Illuminance on the cells of one plane.

    Attributes
    ----------
    zone : Zone
    place : (n, m, 2) float64
        Middles of the cells, metres to the right and up.
    lux : (n, m) float64
        nan where no point counts.
    outline : (k, 2, 2) float64
        Lines to draw: walls that a plane cuts, or edges of the faces; metres.
    points : (p, 2) float64
        The zone's points on the plane, metres.
    values : (p,) float64
        Their illuminance, lx.
    axes : tuple of two str
        What the axes are called.
    down : bool
        Whether the second axis points down.
    """

    zone: Zone
    place: np.ndarray
    lux: np.ndarray
    outline: np.ndarray
    points: np.ndarray
    values: np.ndarray
    axes: tuple[str, str]
    down: bool


def map_of(solution: Solution, zone: Zone) -> Map:
    """Return the map of a plane, or of the largest plane of a surface that has a grid."""
    if zone.kind == "plane":
        return _of_plane(solution, zone)
    return _of_surface(solution, zone)


def _of_plane(solution, zone) -> Map:
    scene, height = solution.scene, height_of(zone.grid)
    _, flat = plane_axes(scene)
    low, high = (f(scene.faces.vertices, axis=(0, 1))[flat] for f in (np.min, np.max))
    every, step, _ = plane_cells(scene, height, float((high - low).max()) / FINE, 0.0)
    grid = plane_grid(solution, height, float((high - low).max()) / FINE, 0.0)
    shape = np.round((high - low) / step).astype(int)
    cell = np.floor((grid.points[:, flat] - low) / step).astype(int)
    lux = _filled(solution, shape, cell, grid.points, grid.normals)
    show, axes, down = _from_above(scene)
    walls = walls_at(scene, height, *plane_axes(scene))
    lines = np.zeros((*walls.shape[:2], 3))
    lines[..., flat] = walls
    return Map(
        zone, show(every).reshape(*shape, 2), lux, show(lines), show(zone.where.points), zone.lux,
        axes, down,
    )  # fmt: skip


def _of_surface(solution, zone) -> Map:
    scene = solution.scene
    planes, _ = surface_cells(scene, zone.grid)
    up = np.eye(3)["xyz".index(scene.up)]
    plane = max(planes, key=lambda p: (round(float(np.prod(p.sides)), 9), float(p.normal @ up)))
    shape = np.maximum(np.round(plane.sides / plane.sides.max() * FINE), 1).astype(int)
    step = plane.sides / shape
    points, normals, _ = points_on(solution, plane, step, 0.0)
    cell = np.floor((points - plane.corner) @ plane.axes.T / step).astype(int)
    lux = _filled(solution, shape, cell, points, normals)
    show, axes, down = _facing(scene, plane)
    middles = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in shape), indexing="ij"), -1) * step
    own = np.abs((zone.where.points - plane.corner) @ plane.normal) < 1e-6 * plane.sides.max()
    v = scene.faces.vertices[plane.face]
    edges = np.stack([v, np.roll(v, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return Map(
        zone, show(plane.corner + middles @ plane.axes), lux, show(edges),
        show(zone.where.points[own]), zone.lux[own], axes, down,
    )  # fmt: skip


def _filled(solution, shape, cell, points, normals):
    """Return (n, m) illuminances of cells (k, 2), nan in all others."""
    found = np.full(tuple(shape), np.nan)
    if len(points):
        arriving = np.maximum(solution.level.gathered(points, normals).total, 0.0)  # no bars here
        lux = illuminance(arriving, solution.scene.bands)
        found[tuple(np.clip(cell, 0, shape - 1).T)] = lux
    return found


def _from_above(scene):
    """Return what shows points (..., 3) as one sees them from above, and the axes' names."""
    axes, down = ABOVE[scene.up], scene.up == "y"
    order = ["xyz".index(a) for a in axes]

    def show(points):
        return points[..., order] * scene.unit_m

    return show, tuple(f"{a} in m" for a in axes), down


def _facing(scene, plane):
    """Return the same for a plane: level ones from above, others as one stands before them."""
    up = np.eye(3)["xyz".index(scene.up)]
    if abs(plane.normal @ up) > UPRIGHT:
        return _from_above(scene)
    above = up - (up @ plane.normal) * plane.normal
    above /= np.linalg.norm(above)
    right = np.cross(above, plane.normal)

    def show(points):
        flat = (points - plane.corner) @ np.stack([right, above]).T
        return flat * scene.unit_m + shift

    shift = np.zeros(2)
    corners = show(scene.faces.vertices[plane.face]).reshape(-1, 2)
    base = float(scene.faces.vertices[plane.face][..., "xyz".index(scene.up)].min())
    shift = np.array([0.0, base * scene.unit_m]) - corners.min(axis=0)
    return show, ("to the right in m", f"{scene.up} in m"), False
