"""Grids on surfaces: points on all faces of a group or material."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.faces import welded
from radiosity.scene.model import Scene
from radiosity.scene.names import UnknownName
from radiosity.solve.solution import Solution
from radiosity.view.pointgrid import PointGrid, cells, check_count, middles
from radiosity.view.polydata import NONE, patches_at

STEPS = 2000  # places along the edges of a plane's faces where its rim is looked for


def surface_grid(
    solution: Solution, name: str, spacing: float | None = None, margin: float = 0.0
) -> PointGrid:
    """Return points on all faces of a group or material, on the side that is lit.

    A grid on each plane along its longest edge, with the spacing of the largest one. Parts that
    other faces cover do not count, nor what is nearer than the margin to a plane's edge. A plane
    that is too small for the grid has one point if there is no margin.

    Parameters
    ----------
    name : str
    spacing, margin : float, optional
        Scene units; 0.2 5^(log10 d) metres and none if not given.

    Raises
    ------
    ValueError
        No such name, impossible lengths, too many points, or none that count.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/lroom.toml"), 0.1)
    >>> grid = surface_grid(solution, "floor", spacing=0.5)
    >>> len(grid.points), grid.normals[0].tolist()  # 20 m2
    (80, [0.0, 0.0, 1.0])
    """
    scene = solution.scene
    planes, step = surface_cells(scene, name, spacing, margin)
    found = [points_on(solution, p, step, margin) for p in planes]
    points, normals = (np.concatenate(x) for x in zip(*[f[:2] for f in found], strict=True))
    if not len(points):
        raise ValueError(
            f"grid on {name!r}: none of its points is lit and {margin:g} {scene.unit} from its "
            "edges: use a smaller margin or spacing, or give points"
        )
    size = tuple(float(x) for x in step)
    return PointGrid(points, normals, size, margin, sum(f[2] for f in found))


def surface_cells(
    scene: Scene, name: str, spacing: float | None = None, margin: float = 0.0
) -> tuple[list["Plane"], np.ndarray]:
    """Return the planes of a surface and the sides (2,) of a cell of the largest one.

    See `surface_grid`, which lays the grid.
    """
    planes = _planes(scene, _named(scene, name))
    largest = max(planes, key=lambda p: np.prod(p.sides))
    step = (largest.sides - 2 * margin) / cells(largest.sides, spacing, margin, scene)
    check_count(sum(np.prod(np.maximum((p.sides - 2 * margin) / step, 1)) for p in planes))
    return planes, step


@dataclass(frozen=True)
class Plane:
    """Faces (m,) of one plane: in the axes (2, 3) from a corner (3,), their polygons (m, 4, 2)."""

    face: np.ndarray
    normal: np.ndarray
    corner: np.ndarray
    axes: np.ndarray
    polygons: np.ndarray

    @property
    def sides(self) -> np.ndarray:
        """Return (2,) how far the faces reach along both axes, scene units."""
        return self.polygons.max(axis=(0, 1))


def _named(scene: Scene, name):
    groups, materials = list(scene.groups), [m.name for m in scene.materials]
    faces = scene.faces
    found = np.array([g == name for g in groups])[faces.group]
    found |= np.array([m == name for m in materials])[faces.material]
    if not found.any():
        known = dict.fromkeys([*groups, *materials])
        raise UnknownName("face group or material", name, known)
    return np.flatnonzero(found)


def _planes(scene: Scene, mine) -> list[Plane]:
    """Return the planes that some faces lie in, each with the directions of its longest edge."""
    v, normal = scene.faces.vertices[mine], scene.faces.normals()[mine]
    middle = v.mean(axis=(0, 1))
    size = np.linalg.norm(np.ptp(v, axis=(0, 1)))
    offset = np.einsum("fc,fc->f", v[:, 0] - middle, normal)
    plane = welded(np.column_stack([normal * size, offset]))
    found = []
    for number in np.unique(plane):
        here = np.flatnonzero(plane == number)
        edges = (np.roll(v[here], -1, axis=1) - v[here]).reshape(-1, 3)
        one = edges[np.argmax(np.linalg.norm(edges, axis=1))]
        one = one / np.linalg.norm(one)
        axes = np.stack([one, np.cross(normal[here[0]], one)])
        flat = (v[here] - middle) @ axes.T
        low = flat.min(axis=(0, 1))
        corner = middle + low @ axes + offset[here[0]] * normal[here[0]]
        found.append(Plane(mine[here], normal[here[0]], corner, axes, flat - low))
    return found


def points_on(solution, plane: Plane, step, margin):
    """Return the lit points (k, 3) of a plane's grid, their normals, and how many are not."""
    inner = plane.sides - 2 * margin
    flat, tried = np.empty((0, 2)), 0
    if np.all(inner > 0.0):
        shape = np.maximum(np.round(inner / step), 1).astype(int)
        flat, tried = middles(plane.sides, shape, margin), int(shape.prod())
    owner = _holder(plane.polygons, flat)
    if margin > 0.0:
        owner[_far_from_edge(plane.polygons, flat) < margin * (1 - 1e-9)] = NONE
    elif not np.any(owner != NONE):
        flat, owner = plane.polygons[:1].mean(axis=1), np.zeros(1, int)
    flat, owner = flat[owner != NONE], owner[owner != NONE]
    points, face = plane.corner + flat @ plane.axes, plane.face[owner]
    front, back = (
        patches_at(solution, face, np.full(len(face), side), points) != NONE
        for side in (False, True)
    )
    lit = front | back
    normals = np.where(front, 1.0, -1.0)[:, None] * plane.normal + 0.0  # no -0.0
    return points[lit], normals[lit], max(tried, len(lit)) - int(lit.sum())


def _far_from_edge(polygons, points):
    """Return (k,) how far points (k, 2) are from the rim of what polygons (m, 4, 2) cover."""
    from scipy.spatial import cKDTree

    start, along = polygons, np.roll(polygons, -1, axis=1) - polygons
    length = np.linalg.norm(along, axis=2)
    real = length > 0.0
    start, along, length = start[real], along[real], length[real]
    count = np.maximum(np.ceil(STEPS * length / length.sum()), 1).astype(int)
    edge = np.repeat(np.arange(len(count)), count)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)) / count[edge]
    places = start[edge] + share[:, None] * along[edge]
    middles = places + 0.5 / count[edge, None] * along[edge]
    outward = np.column_stack([along[:, 1], -along[:, 0]]) / length[:, None]
    beyond = middles + 1e-6 * np.ptp(polygons, axis=(0, 1)).max() * outward[edge]
    bare = _holder(polygons, beyond) == NONE
    return cKDTree(np.concatenate([places[bare], middles[bare]])).query(points)[0]


def _holder(polygons, points):
    """Return (k,) the first of convex polygons (m, 4, 2) that holds each point, or `NONE`."""
    found = np.full(len(points), NONE)
    for k, corner in enumerate(polygons):
        low, high = corner.min(axis=0), corner.max(axis=0)
        near = np.flatnonzero(np.all((points >= low) & (points <= high), axis=1) & (found == NONE))
        edge, r = np.roll(corner, -1, axis=0) - corner, points[near, None] - corner
        inside = edge[:, 0] * r[:, :, 1] - edge[:, 1] * r[:, :, 0]
        found[near[np.all(inside >= -1e-12 * np.ptp(corner, axis=0).prod(), axis=1)]] = k
    return found
