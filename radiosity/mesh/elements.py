"""Elements of order 0 and 1 over patches: what values inside a patch its coefficients stand for.

Order 0 is constant. Order 1 is linear and may jump from patch to patch:
B(y) = b_0 + b_1 u + b_2 v, with u, v = axes . (y - centroid), lengths in radii of the patch.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from radiosity.mesh.patches import Patches

_G = 0.5 - 0.5 / np.sqrt(3.0)
# Nodes (s, t) of the unit square: the 2 x 2 Gauss points, at which linear elements are as good as
# their mean error; and the weights of a triangle's corners at its three nodes of degree 2.
SQUARE = np.array([[_G, _G], [1 - _G, _G], [1 - _G, 1 - _G], [_G, 1 - _G]])
TRIANGLE = np.array([[4, 1, 1, 0], [1, 4, 1, 0], [1, 1, 4, 0]]) / 6.0


@dataclass(frozen=True)
class Elements:
    """Coefficients of n patches: all b_0, then for order 1 all b_1 and all b_2.

    Attributes
    ----------
    order : int
    vertices, normal, centroid : (n, 4, 3), (n, 3), (n, 3) float64
        In scene units.
    axes : (n, 2, 3) float64
        In-plane, at right angles, of length 1 / radius.
    """

    order: int
    vertices: np.ndarray
    normal: np.ndarray
    centroid: np.ndarray
    axes: np.ndarray

    def __len__(self) -> int:
        """Return the number of patches."""
        return len(self.normal)

    @property
    def width(self) -> int:
        """Return how many coefficients a patch has."""
        return 1 if self.order == 0 else 3

    def gradients(self, coefficients: np.ndarray) -> np.ndarray:
        """Return (n, m, 3): the gradients of fields given by coefficients (width n, m)."""
        n = len(self)
        if self.order == 0:
            return np.zeros((n, coefficients.shape[1], 3))
        slopes = coefficients[n:].reshape(2, n, coefficients.shape[1])
        return np.einsum("anm,nac->nmc", slopes, self.axes)

    def slopes(self, gradients: np.ndarray) -> np.ndarray:
        """Return (2, n, m): the coefficients b_1 and b_2 of fields of gradients (n, m, 3)."""
        axes = self.axes / np.sum(self.axes**2, axis=2, keepdims=True)
        return np.einsum("nmc,nac->anm", gradients, axes)

    def middles(self, weights: np.ndarray, owner: np.ndarray) -> np.ndarray:
        """Return (k, 3): where on patches (k,) what points see of them is centred.

        ``weights`` (k, width n) of the points, of elements of order 1: factors and first moments.
        """
        k, n, axes = np.arange(len(owner)), len(self), self.axes[owner]
        axes = axes / np.sum(axes**2, axis=2, keepdims=True)
        moment = np.stack([weights[k, a * n + owner] for a in (1, 2)], axis=1)
        along = moment / weights[k, owner][:, None]
        return self.centroid[owner] + np.einsum("ka,kac->kc", along, axes)

    def at(self, points: np.ndarray, owner: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """Return (k, m): a field's values at points (k, 3) of the patches ``owner`` (k,)."""
        values = coefficients[owner]
        if self.order == 1:
            place = np.einsum("kac,kc->ka", self.axes[owner], points - self.centroid[owner])
            for a in range(2):
                values = values + place[:, a, None] * coefficients[(a + 1) * len(self) + owner]
        return values


@dataclass(frozen=True)
class Nodes:
    """Points on the patches at which a field decides the coefficients of its element.

    Attributes
    ----------
    points : (k, 3) float64
        Scene units.
    owner : (k,) int
        Patch of each.
    fit : (width n, k) csr_array
        Coefficients of the element nearest to values at the nodes, in the mean square; b_0 is the
        mean over the patch of what is linear.
    """

    points: np.ndarray
    owner: np.ndarray
    fit: csr_array


def make_elements(patches: Patches, rows: np.ndarray, order: int) -> Elements:
    """Return the elements of some patches."""
    v, normal = patches.vertices[rows], patches.normal[rows]
    edge = np.roll(v, -1, axis=1) - v
    longest = np.argmax(np.linalg.norm(edge, axis=2), axis=1)
    one = edge[np.arange(len(v)), longest]
    one /= np.maximum(np.linalg.norm(one, axis=1), 1e-300)[:, None]
    axes = np.stack([one, np.cross(normal, one)], axis=1)
    radius = np.maximum(patches.radius[rows], 1e-300)
    return Elements(order, v, normal, patches.centroid[rows], axes / radius[:, None, None])


def make_nodes(elements: Elements) -> Nodes:
    """Return the nodes of elements of order 1: four of a quadrilateral, three of a triangle."""
    v = elements.vertices
    n = len(v)
    triangle = np.all(v[:, 3] == v[:, 2], axis=1)
    s, t = SQUARE.T
    corners = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
    shares = np.where(triangle[:, None, None], np.vstack([TRIANGLE, np.zeros(4)]), corners)
    weight = np.where(triangle[:, None], [1.0, 1.0, 1.0, 0.0], _stretch(v))
    real = np.flatnonzero(weight.ravel() > 0.0)
    points = (shares @ v).reshape(-1, 3)[real]
    owner, weight = real // 4, weight.ravel()[real]
    apart = points - elements.centroid[owner]
    place = np.einsum("kac,kc->ka", elements.axes[owner], apart)
    basis = np.column_stack([np.ones(len(real)), place])
    gram = np.zeros((n, 3, 3))
    np.add.at(gram, owner, weight[:, None, None] * basis[:, :, None] * basis[:, None, :])
    inverse = np.linalg.pinv(gram, hermitian=True)[owner]
    dual = np.einsum("kab,kb->ka", inverse, weight[:, None] * basis)
    row, column = np.arange(3) * n + owner[:, None], np.repeat(np.arange(len(real)), 3)
    fit = csr_array((dual.ravel(), (row.ravel(), column)), shape=(3 * n, len(real)))
    return Nodes(points, owner, fit)


def from_other_side(elements: Elements, twin: np.ndarray) -> csr_array:
    """Return (width n, width n): coefficients of fields as seen from the other side of a sheet.

    Patch i has the values at its points that patch ``twin`` (n,) has there, 0 where that is -1.
    """
    n = len(elements)
    k = np.flatnonzero(twin >= 0)
    rows, columns, values = [k], [twin[k]], [np.ones(len(k))]
    if elements.order == 1:
        mine, theirs = elements.axes[k], elements.axes[twin[k]]
        turn = np.einsum("kac,kbc->kab", mine / np.sum(mine**2, axis=2, keepdims=True), theirs)
        for a in range(2):
            for b in range(2):
                rows.append((a + 1) * n + k)
                columns.append((b + 1) * n + twin[k])
                values.append(turn[:, a, b])
    place = np.concatenate(rows), np.concatenate(columns)
    return csr_array((np.concatenate(values), place), shape=(elements.width * n,) * 2)


def _stretch(v):
    """Return (n, 4): the stretch of area of the bilinear map at the nodes."""
    s, t = SQUARE[:, 0, None], SQUARE[:, 1, None]
    v = v[:, :, None, :]
    along = (1 - t) * (v[:, 1] - v[:, 0]) + t * (v[:, 2] - v[:, 3])
    across = (1 - s) * (v[:, 3] - v[:, 0]) + s * (v[:, 2] - v[:, 1])
    return np.linalg.norm(np.cross(along, across), axis=2)
