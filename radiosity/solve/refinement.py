"""Which cells an error comes from, by its adjoint, and how finely each is to be divided.

The coarse solution b, put on the fine mesh, lacks the residual r = M_e + rho F b - b there, and the
fine solution less b is (1 - rho F)^-1 r. So what a point x with the weights w (E = w . b) finds
differs by p . r with the importance p = w (1 - rho F)^-1, the adjoint solution: each cell's share
of that sum is what the point's error owes to it (E17).

Both are blind for what their cells are too large to hold. Where little was asked for, cells close
to a point are therefore made small beforehand: what it sees of each is a small share.
"""

import numpy as np

from radiosity.mesh.division import Division
from radiosity.mesh.elements import make_elements
from radiosity.scene.model import Scene
from radiosity.solve.estimate import Goal
from radiosity.solve.level import Level
from radiosity.solve.plan import Recipe
from radiosity.solve.reach import Reach, find_reach
from radiosity.transport.arrival import all_weights, make_senders
from radiosity.transport.factors import patch_geometry
from radiosity.transport.lookup import fronts_at

SIGNS = 16  # random sums of points, whose mean square is that of the points
MOST_POINTS = 256
SWEEPS, SETTLED = 30, 0.01  # of the adjoint solution: at most, and the change that ends them
ORDER = 2.0  # of a cell's share of the error in its size
FALL = 0.68  # measured: the error falls as the sum of the shares to this power
LARGEST = 4.0  # factor that a cell is divided by at once
GAIN = 0.6  # measured: cells become more by at least this power of the fall of the error
LEAST, WORTH = 1.3, 1.2  # factors that all cells become more by: where there is room, where not

# Share of what a point sees that one cell may take; goals of how few points are so cared for (of
# more, 5 % may be worse); by how much cells may become more, in so many passes; and how exact
# factors need to be for that.
CLOSE, COUNTED, GRADED, PASSES, ROUGH = 0.1, 20, 4.0, 8, 1e-3


def graded(
    scene: Scene, division: Division, recipe: Recipe, goal: Goal, most: float
) -> tuple[Division, Reach | None]:
    """Divide cells close to the points of a goal until none takes much of what one sees.

    Ends where these are more than ``most`` cells. Returns what reach was found on the way, too.
    """
    most, reach = min(most, GRADED * division.count), None
    for _ in range(PASSES if len(goal.points) < COUNTED else 0):
        reach = find_reach(scene, division, recipe.seed, recipe.force, reach)
        split = np.where(_close_to(goal, reach, division.count, recipe.seed), 2, 1)
        if np.all(split == 1) or np.sum(split**2) > most:
            break
        division = division.divided(split)
    return division, reach


def _close_to(goal, reach, count, seed):
    """Return (count,) bool: cells that take more than CLOSE of what points see, from nearby.

    Points of the goal, and those that they see of these cells: light goes to and fro in a corner.
    """
    patches, rows = reach.patches, np.flatnonzero(reach.live)
    elements, visibility = make_elements(patches, rows, 1), reach.visibility
    senders = make_senders(elements, patch_geometry(patches, visibility, rows), visibility, ROUGH)
    found, cell = np.zeros(count, bool), _cells(patches)[patches.front_of[rows]]
    points, normals = goal.points, goal.normals
    for _ in range(2):
        weights = all_weights(senders, points, normals, seed)
        point, near = np.nonzero(weights[:, : len(rows)] > CLOSE)
        middle = elements.middles(weights[point], near)
        nearby = np.linalg.norm(middle - points[point], axis=1) < patches.radius[rows[near]]
        found[cell[near[nearby]]] = True
        points, normals = middle[nearby], elements.normal[near[nearby]]
    return found


def _cells(patches):
    """Return (fronts,) the cell of each front."""
    start = patches.grid.start
    return np.repeat(np.arange(len(start) - 1), np.diff(start))


def blame(
    level: Level, coarse: Level, points: np.ndarray, normals: np.ndarray, worth: np.ndarray
) -> np.ndarray:
    """Return (cells,) what each coarse cell adds to the errors at points, root mean square.

    Parameters
    ----------
    level, coarse : Level
        Of linear elements; the mesh of the first has cells half as large.
    points, normals : (k, 3) float64
    worth : (k,) float64
        What an error of irradiance, in W/m2 (luminance-weighted), is worth at each.
    """
    grid, rows = level.reach.patches.grid, level.rows
    if len(rows) == 0:
        return np.zeros(coarse.reach.patches.grid.division.count)
    some = np.unique(np.linspace(0, len(points) - 1, MOST_POINTS).astype(int))
    weights = all_weights(level.senders, points[some], normals[some], level.recipe.seed)
    k = len(some)
    random = np.random.default_rng(level.recipe.seed)
    signs = np.sqrt(k) * np.eye(k) if k <= SIGNS else random.choice([-1.0, 1.0], (SIGNS, k))
    share = _importance(level, (signs * worth[some]) @ weights) * _residual(level, coarse)
    share = level.scene.bands.luminance(share).reshape(len(signs), 3, len(rows)).sum(axis=1)
    split, patches = grid.division.splits[-1], level.reach.patches
    parent = np.repeat(np.arange(len(split)), split**2)[_cells(patches)[patches.front_of[rows]]]
    total = np.array([np.bincount(parent, one, minlength=len(split)) for one in share])
    return np.sqrt(np.mean(total**2, axis=0))


def _importance(level, weights):
    """Return (k, width m, bands): the solutions p = w + p rho F for rows of weights (k, width m).

    To SETTLED, or, where bounces hardly fade, their first SWEEPS: they only choose cells.
    """
    rho, sheets = np.tile(level.terms.reflectance[level.rows], (3, 1)), level.sheets
    laws = rho if sheets is None else np.concatenate([rho, sheets.transmittance])
    chains = level.chains
    if chains is not None:
        laws = np.concatenate([laws, chains.which[None]])
    straight, found = level.factors.matrix, np.empty((*weights.shape, rho.shape[1]))
    for band in range(rho.shape[1]):
        same = [k for k in range(band) if np.array_equal(laws[:, k], laws[:, band])]
        if same:
            found[..., band] = found[..., same[0]]
            continue
        matrix = straight if chains is None else straight + chains.matrix[chains.which[band]]
        p = weights
        for _ in range(SWEEPS):
            sent = p * rho[:, band]
            if sheets is not None:
                sent += sheets.asked(p, band)
            before, p = p, weights + sent @ matrix
            if np.abs(p - before).max() <= SETTLED * np.abs(p).max():
                break
        found[..., band] = p
    return found


def _residual(level, coarse):
    """Return the coefficients (width m, bands) of a coarse solution's residual on a fine mesh."""
    apart = level.coefficients - _put_on(level, coarse)
    return apart - level.scattered(level.arrived(apart))


def _put_on(level, coarse):
    """Return the coefficients (width m, bands) on a level's mesh of a coarse one's solution."""
    patches, rows, theirs = level.reach.patches, level.rows, coarse.reach.patches
    where, centres = patches.face[rows], patches.centroid[rows]
    parent = fronts_at(coarse.reach.table, where, centres)
    parent = np.where(patches.front[rows], parent, theirs.back_of[parent])
    place = np.full(len(theirs) + 1, -1)
    place[coarse.rows] = np.arange(len(coarse.rows))
    owner, elements, b = place[parent], coarse.senders.elements, coarse.coefficients
    along = level.senders.elements.slopes(elements.gradients(b)[owner])
    found = np.concatenate([elements.at(centres, owner, b)[None], along])
    found[:, owner < 0] = 0.0
    return found.reshape(-1, b.shape[1])


def refine(division: Division, shares: np.ndarray, wanted: float, most: float) -> Division | None:
    """Return a division whose error is ``wanted`` times as large, or the best of ``most`` cells.

    A cell's share falls as the size of its parts to the power ORDER, and shares add in quadrature:
    with the fewest parts in all, their size is a power of the share; FALL makes up for kinks, where
    the order is less, GAIN for what the shares do not show. None where nothing is left to divide,
    or ``most`` allows too few more cells to be worth a round.

    Parameters
    ----------
    shares : (cells,) float64
        Of the error, see `blame`.
    """
    goal = wanted ** (1.0 / FALL) * np.sqrt(np.sum(shares**2))
    least = max(LEAST, wanted**-GAIN)
    low, high = 0.0, float(shares.max(initial=0.0))  # levels that shares are cut down to
    for _ in range(60):
        middle = 0.5 * (low + high)
        split = _cut_to(shares, middle)
        enough = np.sqrt(np.sum((shares * split**-ORDER) ** 2)) <= (1 + 1e-9) * goal
        enough &= np.sum(split**2) >= least * division.count
        low, high = (middle, high) if enough or np.sum(split**2) > most else (low, middle)
    split = _cut_to(shares, low)
    if np.sum(split**2) > most:
        split = _cut_to(shares, high)
        if np.sum(split**2) < WORTH * division.count:
            return None
    return division.divided(split.astype(int)) if np.any(split > 1) else None


def _cut_to(shares, level):
    return np.rint(np.clip((shares / max(level, 1e-300)) ** (1.0 / (1.0 + ORDER)), 1.0, LARGEST))
