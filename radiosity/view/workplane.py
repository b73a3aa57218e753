"""Grids on horizontal planes: the points of a work plane that lie in lit rooms, off the walls."""

import numpy as np

from radiosity.mesh.patches import NONE
from radiosity.mesh.seams import find_seams
from radiosity.mesh.winding import find_shells
from radiosity.scene.model import Scene
from radiosity.solve.solution import Solution
from radiosity.transport.hemisphere import meet
from radiosity.transport.visibility import LIFT
from radiosity.view.pointgrid import BAND, SHARE, PointGrid, cells, middles

AT_ONCE = 1 << 20  # distances between points and walls
LOOKS = 64  # directions that a point looks in for whether it is inside of a body


def plane_grid(
    solution: Solution, height: float, spacing: float | None = None, margin: float | None = None
) -> PointGrid:
    """Return the points of a horizontal plane that face up, over all of the scene.

    Points count that have a floor: the first surface straight below shows them its front, and less
    than half of what they see all around are backs. That leaves out what lies inside of solid
    bodies, outside of rooms and above their roofs, whether lamps are on or not. Where light falls
    on the side that is met below, points count in any case, so also in rooms turned inside out.
    Points nearer than the margin to anything that stands through the plane, or to the scene's ends,
    do not count.

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
    up, flat = plane_axes(scene)
    keep = _above_floor(solution, points, up)
    if margin > 0.0:
        keep &= _distance(points[:, flat], walls_at(scene, height, up, flat)) >= margin * (1 - 1e-9)
    if not keep.any():
        raise ValueError(
            f"grid at height {height:g} {scene.unit}: none of its {len(points)} points lies above "
            f"the front of a surface and {margin:g} {scene.unit} from walls: use another height or "
            "a smaller margin, or give points"
        )
    normals = np.tile(np.eye(3)[up], (keep.sum(), 1))
    return PointGrid(points[keep], normals, spacing, margin, int((~keep).sum()))


def plane_cells(
    scene: Scene, height: float, spacing: float | None = None, margin: float | None = None
) -> tuple[np.ndarray, tuple[float, float], float]:
    """Return the middles (k, 3) of a plane's cells, the cells' sides and the margin around them.

    See `plane_grid`, which takes those that count.
    """
    up, flat = plane_axes(scene)
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


def roofed(solution: Solution, grid: PointGrid) -> float:
    """Return the share of a plane's points that have a surface straight above them."""
    up, _ = plane_axes(solution.scene)
    return float((_met(solution.surroundings, grid.points, np.eye(3)[up], up) >= 0).mean())


def plane_axes(scene: Scene) -> tuple[int, list[int]]:
    """Return which axis points up, and the other two."""
    up = "xyz".index(scene.up)
    return up, [(up + 1) % 3, (up + 2) % 3]


def _above_floor(solution, points, up):
    """Return (k,) bool: points that look down on a lit side, or on a front and are in no body."""
    around = solution.surroundings
    sides = _met(around, points, -np.eye(3)[up], up)
    row = np.where(sides >= 0, around.field.row[sides], NONE)
    lit = (solution.irradiance_on + solution.emission).any(axis=1)
    found = (row >= 0) & lit[row]
    dark = np.flatnonzero((sides >= 0) & ~found)
    if len(dark):
        turned = _inside_out(solution.scene.faces)[solution.patches.face]
        dark = dark[~_backs(sides[dark], turned)]
        found[dark] = ~_in_a_body(around, points[dark], up, turned)
    return found


def _met(around, points, direction, up):
    """Return (k,) the sides met from points in one direction, 2 patch + 1 for backs, or `NONE`."""
    seen = around.visibility
    raised = (points - seen.centre) * seen.scale + LIFT * np.eye(3)[up]  # off a floor at its height
    along = np.tile(direction.astype(np.float32), (len(points), 1))
    return meet(seen, around.table, raised.astype(np.float32), along)[0]


def _backs(sides, turned):
    """Return (k,) bool: sides that are backs; of patches ``turned`` inside out, fronts are."""
    return (sides >= 0) & ((sides % 2 == 1) != turned[sides // 2])


def _in_a_body(around, points, up, turned):
    """Return (k,) bool: points to which half or more of what they see all around are backs.

    Half it is on a floor within a body that has no bottom of its own: nothing else is below.
    """
    k = np.arange(LOOKS) + 0.5
    height, turn = 1.0 - 2.0 * k / LOOKS, np.pi * (1.0 + 5.0**0.5) * k  # a spiral, about even
    across = np.sqrt(1.0 - height**2)
    backs, some = np.zeros((2, len(points)), int)
    for d in np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1):
        sides = _met(around, points, d, up)
        backs += _backs(sides, turned)
        some += sides >= 0
    return 2 * backs >= some


def _inside_out(faces):
    """Return (f,) bool: faces of a closed body that looks outward and is about all of the scene."""
    shells = find_shells(faces, find_seams(faces))
    low, high = shells.boxes(faces)
    v = faces.vertices
    about = np.all((low <= v.min(axis=(0, 1))) & (high >= v.max(axis=(0, 1))), axis=1)
    return ((shells.volume > 0) & about)[shells.of_face]


def walls_at(scene: Scene, height, up, flat):
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
