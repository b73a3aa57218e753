"""Whether light fades from bounce to bounce, and which solver that asks for."""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from radiosity.scene.model import SceneError

KEPT = 1e-6  # share of the light that a mirror absorbs: more than rounding
LOST = 1e-9  # share of a row's light that leaves it: more than rounding
THROUGH = "gmres", "jacobi", "direct"  # solvers that know translucent sheets and chains
STIFF = 0.02  # margin below which an iteration would crawl: solve directly


def suited(solver, system, live, sent_on=None):
    """Refuse rooms that nothing absorbs in; solve directly where bounces hardly fade.

    Where sheets or chains carry light, one that knows them takes the place of one that does not.
    ``sent_on`` is what of diffuse light patches neither scatter nor absorb.
    """
    kept = system.absorptance[: len(live)]
    if sent_on is not None:
        kept = np.where(kept - sent_on > KEPT, kept, 0.0)
    if np.any(kept <= 0.0) and np.any(_never_fades(system, live, kept)):
        raise SceneError(
            "materials",
            ["every lit surface has reflectance 1 in a closed scene, or in a closed part of it, "
             "so light never fades: let something absorb (diffuse below 1)"],
        )  # fmt: skip
    if system.margin < STIFF:
        return "direct"
    return solver if system.is_plain or solver in THROUGH else "gmres"


def _never_fades(system, live, kept) -> np.ndarray:
    """Return (parts, bands) bool: closed parts of the scene where nothing lit absorbs."""
    n = len(live)
    matrix, loss = system.factors.rows()[0][:n, :n], system.factors.loss[:n]
    linked = csr_matrix(matrix > 0)
    if system.sheets is not None:
        linked = linked + abs(system.sheets.across[:n, :n])
    if system.chains is not None:
        linked = linked + csr_matrix(system.chains.matrix.max(axis=0)[:n, :n] > 0)
    parts, part = connected_components(linked, directed=False)
    fades = np.zeros((parts, system.reflectance.shape[1]), bool)
    np.logical_or.at(fades, part, (kept > 0.0) | (loss > LOST)[:, None])
    lit = np.zeros(parts, bool)
    lit[part[live]] = True
    return lit[:, None] & ~fades
