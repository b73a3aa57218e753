"""Form factors between patches: exact polygons, exact shadows of few blockers, else rays."""

import numpy as np
from numba import njit

from radiosity.mesh.patches import Patches
from radiosity.transport.blockers import MOST
from radiosity.transport.environment import FEW, measure_openness
from radiosity.transport.exchange import Geometry, make_geometry
from radiosity.transport.near import APART, FLAT
from radiosity.transport.occlusion import refined_shares
from radiosity.transport.operator import FormFactors, Openness
from radiosity.transport.pairs import FEWER, RAYS, Barriers, fill_rows, look_near, make_spaces
from radiosity.transport.screen import make_columns
from radiosity.transport.threads import Progress, over_ranges, silent
from radiosity.transport.visibility import Visibility

ROWS = 16
ENTRIES = 1 << 22  # of the matrix whose pairs are traced at a time
TILE = 64
# Shares of the asked accuracy: of the unoccluded exchange, of what blockers leave of it, and of an
# entry too small to matter: 1 together.
WHOLE, SHARE, SMALL = 1e-2, 0.75, 0.24
TIGHTEST, LOOSEST = 1e-12, 1e-4
# FEW patches get exact unoccluded factors, shares with so much more care, and a careful look for
# shadows between sample points.
CARE = 0.05
MISSING, ROUNDED = 3.0, 1e-9  # of its error, and absolute: what a closed row may miss of 1


def patch_geometry(
    patches: Patches, visibility: Visibility, rows: np.ndarray | slice = slice(None)
) -> Geometry:
    """Return patches, or some rows of them, as the kernels read them, in ray coordinates."""
    centre, scale = visibility.centre, visibility.scale
    return make_geometry(
        (patches.vertices[rows] - centre) * scale, patches.normal[rows],
        (patches.centroid[rows] - centre) * scale, patches.area[rows] * scale**2,
        visibility.grain[patches.face[rows]],
    )  # fmt: skip


def form_factors(
    patches: Patches,
    visibility: Visibility,
    live: np.ndarray,
    accuracy: float,
    seed: int = 0,
    progress: Progress = silent,
    *,
    complete: bool = False,
) -> FormFactors:
    """Assemble the dense matrix of form factors, as it is before its closure is repaired.

    Parameters
    ----------
    patches : Patches
    visibility : Visibility
    live : (n,) bool
        Patches that exchange light; the rows and columns of the others stay 0.
    accuracy : float
        Asked bound of the sum over j of |error of F_ij| in every row.
    complete : bool
        Whether every side that a row sees is a row too, so that where nothing can block all that
        is missing of 1 leaves the scene, and no ray need measure it.

    Returns
    -------
    FormFactors
        Reciprocal by construction: A_i F_ij is stored once and mirrored. With what the rows see of
        the outside, measured by rays of its own.
    """
    n = len(patches)
    exchange, error = np.zeros((n, n)), np.zeros((n, n), np.float32)
    geometry = patch_geometry(patches, visibility)
    columns, blockers = make_columns(geometry), visibility.blockers
    how = look_near(geometry, blockers)
    limit = np.where(how == APART, FEWER, MOST)
    few = n <= FEW
    barriers = Barriers(blockers, visibility.free_sides(patches), limit, few)
    whole = TIGHTEST if few else float(np.clip(WHOLE * accuracy, TIGHTEST, LOOSEST))
    care = CARE if few else 1.0
    asked = whole, care * SHARE * accuracy, care * SMALL * accuracy / max(1, n)
    unit = visibility.scale**-2.0

    def pairs(a, b):
        spaces = make_spaces()
        fill_rows(a, b, live, geometry, columns, barriers, asked, spaces, unit, exchange, error)

    over_ranges(pairs, n, 1 if few else ROWS, "form factors", progress)
    _trace_rest(exchange, error, patches, visibility, asked, seed, progress)
    over_ranges(lambda a, b: _mirror(a, b, exchange, error), n, TILE)
    found = FormFactors(exchange, patches.area, error, centroid=patches.centroid)
    if complete and not visibility.can_block:
        return found.replaced(openness=_what_is_missing(found))
    flat = look_near(geometry, visibility.facets) == FLAT
    openness = measure_openness(patches, visibility, live, accuracy, seed, found, flat)
    return found.replaced(openness=openness)


def _what_is_missing(found):
    """Return the openness of exact rows: what they miss of 1, beyond their errors."""
    error, missing = found.row_errors(), 1.0 - found.row_sums()
    share = np.where((found.area > 0) & (missing > MISSING * error + ROUNDED), missing, 0.0)
    return Openness(share, np.where(share > 0.0, error, 0.0))


def _trace_rest(exchange, error, patches, visibility, asked, seed, progress):
    """Fill in by rays the pairs whose error is a mark, so many at a time that little is copied."""
    n, total, before = len(error), np.count_nonzero(error < 0), 0
    rows = max(1, ENTRIES // max(1, n))
    for a in range(0, n if total else 0, rows):
        i, j = np.nonzero(error[a : a + rows] < 0)
        if len(i) == 0:
            continue
        pairs, done = np.stack([a + i, j], axis=1), before
        whole, hidden = exchange[a + i, j], RAYS - error[a + i, j].astype(float)
        smaller = np.minimum(patches.area[a + i], patches.area[j])
        tolerance = np.maximum(asked[1], asked[2] * smaller / whole)
        share, doubt = refined_shares(
            visibility, pairs, patches, tolerance, seed,
            lambda stage, k, _, done=done: progress(stage, done + k, total),
        )  # fmt: skip
        less = 0.5 * np.minimum(share, hidden)  # half of what may be hidden: the rest is error
        exchange[a + i, j] = (share - less) * whole
        error[a + i, j] = (doubt + less + asked[0]) * whole
        before += len(pairs)


@njit(cache=True, nogil=True, error_model="numpy")
def _mirror(first, stop, exchange, error):
    """Write rows below the diagonal, by tiles that the cache holds."""
    for start in range(0, stop, TILE):
        for i in range(first, stop):
            for j in range(start, min(start + TILE, i)):
                exchange[i, j] = exchange[j, i]
                error[i, j] = error[j, i]
