"""Linear elements that send no negative light.

Beside what stands on a surface its light rises steeply from a shadow, and a line through it may
fall below 0 before the edge. Of all their light that is little; right beside the edge it is
more than what else arrives.
"""

from dataclasses import replace

import numpy as np

from radiosity.solve.clustered import Clustered
from radiosity.solve.level import Level


def not_negative(level: Level | Clustered) -> Level | Clustered:
    """Return a level whose elements send at least 0 at all of their points, for gathering.

    Slopes are lessened by t = min(1, b_0 / (b_0 - min B)), the least B at the corners, band by
    band. Means stay, and elements that are not negative anywhere are as they were (Zhang & Shu
    2010, "On maximum-principle-satisfying high order schemes for scalar conservation laws").
    Clusters and constant elements have no slopes: they are returned as they are.
    """
    if isinstance(level, Clustered) or level.senders.elements.order == 0:
        return level
    elements, found = level.senders.elements, level.coefficients.copy()
    n = len(elements)
    place = np.einsum("nac,nvc->nva", elements.axes, elements.vertices - elements.centroid[:, None])
    slopes, mean = found[n:].reshape(2, n, found.shape[1]), np.maximum(found[:n], 0.0)
    fall = -np.einsum("nva,anm->nvm", place, slopes).min(axis=1)
    share = np.where(fall > mean, mean / np.maximum(fall, 1e-300), 1.0)
    found[n:] = (slopes * share).reshape(found[n:].shape)
    return replace(level, coefficients=found)
