"""Form factors between patches: exact polygon exchange times what rays let through."""

import numpy as np
from numba import njit

from radiosity.mesh.patches import Patches
from radiosity.transport.occlusion import seen_share
from radiosity.transport.operator import FormFactors
from radiosity.transport.polygon import GAUSS, exchange_area
from radiosity.transport.threads import Progress, over_ranges, silent
from radiosity.transport.visibility import Visibility

ROWS = 16
PAIRS = 8192


@njit(cache=True, nogil=True)
def _rows(first, stop, live, v, n, c, r, rules, exchange):
    """Fill exchange[i, j] for first <= i < stop and j > i with unoccluded exchange areas."""
    for i in range(first, stop):
        if not live[i]:
            continue
        for j in range(i + 1, len(live)):
            if live[j]:
                exchange[i, j] = exchange_area(
                    v[i], n[i], c[i], r[i], v[j], n[j], c[j], r[j], rules
                )


@njit(cache=True, nogil=True)
def _mirror(first, stop, exchange):
    for i in range(first, stop):
        for j in range(i):
            exchange[i, j] = exchange[j, i]


def form_factors(
    patches: Patches,
    visibility: Visibility,
    live: np.ndarray,
    rays: int,
    seed: int = 0,
    progress: Progress = silent,
) -> FormFactors:
    """Assemble the dense matrix of form factors.

    Parameters
    ----------
    patches : Patches
    visibility : Visibility
    live : (n,) bool
        Patches that exchange light; the rows and columns of the others stay 0.
    rays : int
        Shadow rays for each pair of patches; none are traced in a convex enclosure.

    Returns
    -------
    FormFactors
        Reciprocal by construction: A_i F_ij is stored once and mirrored.
    """
    n = len(patches)
    exchange = np.zeros((n, n))
    geometry = patches.vertices, patches.normal, patches.centroid, patches.radius

    def polygons(a, b):
        _rows(a, b, live, *geometry, GAUSS, exchange)

    over_ranges(polygons, n, ROWS, "form factors", progress)
    if not visibility.convex:
        _shade(exchange, patches, visibility, rays, seed, progress)
    over_ranges(lambda a, b: _mirror(a, b, exchange), n, 256)
    return FormFactors(exchange, patches.area)


def _shade(exchange, patches, visibility, rays, seed, progress):
    """Multiply every exchange area by the share that shadow rays let through."""
    pairs = np.argwhere(exchange)
    sides = patches.vertices, patches.normal
    keys = np.arange(len(patches))

    def work(a, b):
        block = pairs[a:b]
        share = seen_share(visibility, block, sides, sides, keys, range(rays), seed)
        exchange[block[:, 0], block[:, 1]] *= share

    over_ranges(work, len(pairs), PAIRS, "visibility", progress)
