"""Grids on horizontal planes: the points of a work plane that lie in lit rooms, off the walls."""

import numpy as np

from radiosity.mesh.patches import NONE
from radiosity.scene.model import Scene
from radiosity.solve.solution import Solution
from radiosity.transport.hemisphere import meet
from radiosity.transport.visibility import LIFT
from radiosity.view.pointgrid import BAND, SHARE, PointGrid, cells, middles

AT_ONCE = 1 << 20  # distances between points and walls


def plane_grid(
    solution: Solution, height: float, spacing: float | None = None, margin: float | None = None
) -> PointGrid:
    """Return the points of a horizontal plane that face up, over all of the scene.

    Points count where the first surface straight below is lit on the side that is met. That leaves
    out what lies inside of solid bodies, outside of rooms and above their roofs. Points nearer than
    the margin to anything that stands through the plane, or to the scene's ends, do not count.

    Parameters
    ----------
    height : float
        Coordinate along the scene's ``up`` axis, scene units.
    spacing, margin : float, optional
        Most that cells may measure, and least distance from walls, scene units; as EN 12464-1
        wants them if not given.

    Raises
    ------
    ValueError
        A height outside of the scene, impossible lengths, too many points, or none that count.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/lroom.toml"), 0.1)
    >>> grid = plane_grid(solution, 0.75)
    >>> grid.margin, len(grid.points), grid.left_out  # 4 m x 4 m of 6 m x 6 m are missing
    (0.5, 32, 49)
    """
    scene = solution.scene
    points, spacing, margin = plane_cells(scene, height, spacing, margin)
    up, flat = _axes(scene)
    keep = _above_light(solution, points, up)
    if margin > 0.0:
        keep &= _distance(points[:, flat], _walls(scene, height, up, flat)) >= margin * (1 - 1e-9)
    if not keep.any():
        raise ValueError(
            f"grid at height {height:g} {scene.unit}: none of its {len(points)} points lies above "
            f"a lit surface and {margin:g} {scene.unit} from walls: use another height or a "
            "smaller margin, or give points"
        )
    normals = np.tile(np.eye(3)[up], (keep.sum(), 1))
    return PointGrid(points[keep], normals, spacing, margin, int((~keep).sum()))


def plane_cells(
    scene: Scene, height: float, spacing: float | None = None, margin: float | None = None
) -> tuple[np.ndarray, tuple[float, float], float]:
    """Return the middles (k, 3) of a plane's cells, the cells' sides and the margin around them.

    See `plane_grid`, which takes those that count.
    """
    up, flat = _axes(scene)
    low, high = (f(scene.faces.vertices, axis=(0, 1)) for f in (np.min, np.max))
    if not low[up] <= height <= high[up]:
        raise ValueError(
            f"grid at height {height:g} must lie within the scene, from {scene.up} = {low[up]:g} "
            f"to {high[up]:g} {scene.unit}"
        )
    sides = (high - low)[flat]
    if margin is None:
        margin = min(BAND / scene.unit_m, SHARE * float(sides.min()))
    shape = cells(sides, spacing, margin, scene)
    points = np.empty((shape[0] * shape[1], 3))
    points[:, flat] = low[flat] + middles(sides, shape, margin)
    points[:, up] = height
    return points, tuple(float(x) for x in (sides - 2 * margin) / shape), margin


def _axes(scene: Scene):
    """Return which axis points up, and the other two."""
    up = "xyz".index(scene.up)
    return up, [(up + 1) % 3, (up + 2) % 3]


def _above_light(solution, points, up):
    """Return (k,) bool: points that look down on a lit side of a face first."""
    around = solution.surroundings
    seen = around.visibility
    raised = (points - seen.centre) * seen.scale + LIFT * np.eye(3)[up]  # off a floor at its height
    down = np.tile(-np.eye(3, dtype=np.float32)[up], (len(points), 1))
    sides, _ = meet(seen, around.table, raised.astype(np.float32), down)
    row = np.where(sides >= 0, around.field.row[sides], NONE)
    lit = (solution.irradiance_on + solution.emission).any(axis=1)
    return (row >= 0) & lit[row]


def _walls(scene: Scene, height, up, flat):
    """Return (m, 2, 2): where faces stand on a plane or through it."""
    v = scene.faces.vertices
    above = v[:, :, up] - height
    over = above > 1e-9 * np.ptp(v[:, :, up])  # what ends at the plane, as a desk does, is no wall
    face, edge = np.nonzero(over != np.roll(over, -1, axis=1))  # a convex polygon is cut twice
    here, there = v[face, edge], v[face, (edge + 1) % 4]
    share = above[face, edge] / (here[:, up] - there[:, up])
    ends = here + share[:, None] * (there - here)
    return ends[:, flat].reshape(-1, 2, 2)


def _distance(points, segments):
    """Return (k,) how far points (k, 2) are from the nearest of segments (m, 2, 2)."""
    found = np.full(len(points), np.inf)
    if not len(segments):
        return found
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    square = np.maximum(np.einsum("mc,mc->m", along, along), 1e-300)
    step = max(1, AT_ONCE // len(segments))
    for a in range(0, len(points), step):
        r = points[a : a + step, None] - start
        t = np.clip(np.einsum("kmc,mc->km", r, along) / square, 0.0, 1.0)
        found[a : a + step] = np.linalg.norm(r - t[:, :, None] * along, axis=2).min(axis=1)
    return found
