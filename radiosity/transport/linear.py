"""Form factors between elements of order 1, by collocation at the Gauss points of the patches."""

import numpy as np
from scipy.sparse.linalg import LinearOperator

from radiosity.mesh.elements import Elements, Nodes, make_nodes
from radiosity.transport.arrival import Senders, close, points_at_once, weights_of
from radiosity.transport.threads import Progress, over_ranges, silent


class LinearFactors(LinearOperator):
    """How the irradiance on n patches depends on their radiosities, both linear on each patch.

    ``factors @ b`` are the coefficients of the irradiance that radiosities of coefficients b cause
    (see `Elements`): the exact integral over what each node sees, fitted over each patch. At every
    node of a closed scene the factors sum to 1 up to rounding, or up to the tolerance of far ones
    and then they are scaled. Reciprocity holds to the order of the elements.

    Attributes
    ----------
    area : (n,) float64
    matrix : (3 n, 3 n) float64
    nodes : Nodes
    outside_at, outside : (k,), (3 n,) float64
        Factor to what is no patch: at the nodes, and its coefficients.
    """

    def __init__(self, area, matrix, nodes: Nodes, outside_at):
        self.area, self.matrix, self.nodes = area, matrix, nodes
        self.outside_at, self.outside = outside_at, nodes.fit @ outside_at
        super().__init__(np.float64, matrix.shape)

    def _matmat(self, x):
        return self.matrix @ x

    def _matvec(self, x):
        return self.matrix @ x

    def without_slopes(self) -> "LinearFactors":
        """Return the factors of linear elements whose slopes neither send nor receive."""
        n = len(self.area)
        matrix = np.zeros_like(self.matrix)
        matrix[:n, :n] = self.matrix[:n, :n]
        flat = LinearFactors(self.area, matrix, self.nodes, self.outside_at)
        flat.outside[n:] = 0.0
        return flat

    def escaping(self, elements: Elements, b: np.ndarray) -> np.ndarray:
        """Return (n, bands): the mean over each patch of B times its factor to the outside."""
        at = elements.at(self.nodes.points, self.nodes.owner, b)
        return (self.nodes.fit @ (at * self.outside_at[:, None]))[: len(self.area)]

    def rows(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a matrix and divisors of its rows whose quotient is F."""
        return self.matrix, np.ones(len(self.matrix))

    @property
    def weight(self) -> np.ndarray:
        """Return (3 n,) what a coefficient is worth: the area of its patch."""
        return np.tile(self.area, 3)

    @property
    def loss(self) -> np.ndarray:
        """Return (3 n,) shares of a row's light that arrive at no patch; 1 for slopes."""
        n = len(self.area)
        return np.concatenate([self.outside[:n], np.ones(2 * n)])


def linear_factors(
    senders: Senders, area: np.ndarray, seed: int = 0, progress: Progress = silent
) -> LinearFactors:
    """Assemble the factors between elements of order 1 on patches of areas (n,) (E13)."""
    elements = senders.elements
    n, nodes = len(elements), make_nodes(elements)
    matrix, seen = np.empty((3, n, 3 * n)), np.empty(len(nodes.points))
    first = np.searchsorted(nodes.owner, np.arange(n + 1))
    normal = elements.normal[nodes.owner]

    def work(a, b):
        here = slice(first[a], first[b])
        weights, unsure = weights_of(
            senders, nodes.points[here], normal[here], int(first[a]), seed=seed
        )
        seen[here] = close(weights, n, unsure, senders.blur)
        matrix[:, a:b] = (_rows(nodes, a, b, here, n) @ weights).reshape(3, b - a, 3 * n)

    over_ranges(work, n, max(1, points_at_once(n) // 4), "form factors", progress)
    out = 1.0 - seen
    out[out <= 0.0] = 0.0
    return LinearFactors(area, matrix.reshape(3 * n, 3 * n), nodes, out)


def _rows(nodes: Nodes, a: int, b: int, here: slice, n: int):
    """Return the part of the fit of patches a to b - 1 from their own nodes."""
    wanted = (np.arange(3)[:, None] * n + np.arange(a, b)).ravel()
    return nodes.fit[wanted][:, here]
