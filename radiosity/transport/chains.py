"""Light that comes to elements by way of mirrors, clear bodies and lobes (E23).

Extended form factors: E(x) = sum over j of int_j (K + K_c)(x, y) B_j(y) dA, beside the kernel K of
what x sees K_c of what it sees by way of surfaces that send light on along single directions. B
holds only what leaves diffusely. K_c is found by rays from x at such surfaces, each followed on
(`Tracer`), and of planar mirrors exactly (`Image`).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.sparse import csr_array

from radiosity.mesh.elements import Nodes
from radiosity.mesh.patches import Patches
from radiosity.transport.counting import make_beams
from radiosity.transport.threads import Progress, over_ranges, silent
from radiosity.transport.tracer import Step, Tracer

RAYS_AT_ONCE = 1 << 15
KEY = 1 << 48  # tells the patterns of clusters from others


@dataclass(frozen=True)
class Sent:
    """What arrives at points by way of other surfaces, or is sent on by their own.

    Attributes
    ----------
    weights : (different bands, k, width n) float64
        Of the coefficients of elements.
    outside, escaping : (k, bands) float64
        Factor to the outside for radiance that enters, and for light that leaves.
    straight : (k, bands) float64
        Irradiance that lights cause, W/m2.
    """

    weights: np.ndarray
    outside: np.ndarray
    escaping: np.ndarray
    straight: np.ndarray


def sent_to(
    tracer: Tracer, steps: Iterator[Step], count: int, bands: np.ndarray,
    labels: np.ndarray | None = None,
) -> Sent:  # fmt: skip
    """Return what ``count`` owners of rays get by way of surfaces that send light on.

    Weights of some ``bands``, of elements, or of groups of elements that ``labels`` (n,) name.
    """
    n, every = len(tracer.elements) * tracer.elements.width, tracer.space.optics.bands
    if labels is not None:
        n = int(labels.max(initial=-1)) + 1
    weights = np.zeros((len(bands), count, n))
    outside, escaping, straight = (np.zeros((count, every)) for _ in range(3))
    for step in steps:
        owner, ends = step.owner, step.ends
        weight = step.weight
        np.add.at(straight, owner, np.pi * weight * tracer.straight(step))
        if step.bounce == 0:
            continue
        k, element, basis = tracer.places(ends)
        to = element if labels is None else labels[element]
        _add(owner[k], to, basis, weight[k][:, bands], weights)
        k = np.flatnonzero(ends.sides < 0)
        np.add.at(outside, owner[k], weight[k])
        np.add.at(escaping, owner[k], step.factor[k, None] * ends.share[k])
    return Sent(weights, outside, escaping, straight)


@njit(cache=True, nogil=True)
def _add(owner, element, basis, weight, out):
    n = out.shape[2] // basis.shape[1]
    for k in range(len(owner)):
        for a in range(basis.shape[1]):
            for b in range(weight.shape[1]):
                out[b, owner[k], a * n + element[k]] += weight[k, b] * basis[k, a]


@dataclass(frozen=True)
class Chains:
    """Extended form factors: what elements get by way of surfaces that send light on.

    Attributes
    ----------
    matrix : (different bands, m, m) float64
        Between coefficients.
    which : (bands,) int
        Whose matrix each band has.
    outside, escaping, straight : (m, bands) float64
        Coefficients of what `Sent` holds.
    emitted : (m, bands) float64
        Of the lights that ``straight`` holds, whose light the matrix is not to carry again.
    """

    matrix: np.ndarray
    which: np.ndarray
    outside: np.ndarray
    escaping: np.ndarray
    straight: np.ndarray
    emitted: np.ndarray

    def arriving(self, b: np.ndarray) -> np.ndarray:
        """Return the coefficients (m, bands) of the irradiance that radiosities b cause."""
        found = np.empty_like(b)
        for k in np.unique(self.which):
            mine = self.which == k
            found[:, mine] = self.matrix[k] @ b[:, mine]
        return found

    def entering(self, ambient: np.ndarray) -> np.ndarray:
        """Return the coefficients (m, bands) of the irradiance that no element sends."""
        return np.pi * self.outside * ambient + self.straight - self.arriving(self.emitted)

    def without_slopes(self, n: int) -> "Chains":
        """Return the same where the slopes of n linear elements neither send nor receive."""
        matrix = np.zeros_like(self.matrix)
        matrix[:, :n, :n] = self.matrix[:, :n, :n]
        parts = [x.copy() for x in self._parts]
        for x in parts:
            x[n:] = 0.0
        return Chains(matrix, self.which, *parts)

    def grouped(self, above: np.ndarray, area: np.ndarray) -> "Chains":
        """Return the same for groups of elements of areas (m,) and constant fields."""
        n, k = int(above.max(initial=-1)) + 1, np.arange(len(above))
        share = area / np.bincount(above, area, n)[above]
        shape, one = (n, len(k)), np.ones(len(k))
        mean, put = (csr_array((x, (above, k)), shape=shape) for x in (share, one))
        matrix = np.stack([mean @ matrix @ put.T for matrix in self.matrix])
        return Chains(matrix, self.which, *(mean @ x for x in self._parts))

    def of_bands(self, bands: np.ndarray | slice) -> "Chains":
        """Return the same for some bands."""
        return Chains(self.matrix, self.which[bands], *(x[:, bands] for x in self._parts))

    def spread(self, rows: np.ndarray, n: int) -> "Chains":
        """Return the same for n coefficients of which these are the ``rows`` (m,)."""
        matrix = np.zeros((len(self.matrix), n, n))
        matrix[:, rows[:, None], rows] = self.matrix
        parts = [np.zeros((n, len(self.which))) for _ in self._parts]
        for to, mine in zip(parts, self._parts, strict=True):
            to[rows] = mine
        return Chains(matrix, self.which, *parts)

    @property
    def _parts(self):
        return self.outside, self.escaping, self.straight, self.emitted


def find_chains(
    tracer: Tracer, nodes: Nodes, rays: int, progress: Progress = silent,
    known: Chains | None = None,
) -> Chains:
    """Return the extended form factors of elements, by ``rays`` from each of their nodes.

    The matrix is taken from what is ``known`` of the same elements under other light.
    """
    bands, which = _kinds(tracer, known)
    elements = tracer.elements
    n, width = len(elements), elements.width
    fit = nodes.fit[: width * n]
    m, every = width * n, len(which)
    matrix = np.zeros((len(bands), m, m))
    parts = [np.zeros((len(nodes.points), every)) for _ in range(3)]
    first = np.searchsorted(nodes.owner, np.arange(n + 1))
    normal = elements.normal[nodes.owner]

    emitted = np.zeros((m, every))
    emitted[:n] = tracer.emitted

    def work(a, b):
        here = slice(first[a], first[b])
        keys = np.arange(first[a], first[b])
        steps = tracer.paths(nodes.points[here], normal[here], keys, range(rays))
        sent = sent_to(tracer, steps, len(keys), bands)
        for image in tracer.images:
            seen = image.weights(nodes.points[here], normal[here], first[a], 0.0, tracer.seed)
            sent.weights[:] += image.share[bands, None, None] * seen
            sent.straight[:] += image.share * (seen @ emitted)
        sent.straight[:] += tracer.lamplight(nodes.points[here], normal[here])
        rows = (np.arange(width)[:, None] * n + np.arange(a, b)).ravel()
        part = csr_array(fit[rows][:, here])
        for k in range(len(bands)):
            matrix[k, rows] = part @ sent.weights[k]
        for to, found in zip(parts, (sent.outside, sent.escaping, sent.straight), strict=True):
            to[here] = found

    over_ranges(work, n, max(1, RAYS_AT_ONCE // (4 * rays)), "chains", progress)
    matrix = matrix if known is None else known.matrix
    parts = [fit @ x for x in parts]
    if tracer.caustics is not None:
        parts[2][:n] += tracer.caustics.on(tracer.element, tracer.areas_of_elements)
    return Chains(matrix, which, *parts, emitted)


def cluster_chains(
    tracer: Tracer, patches: Patches, rows: np.ndarray, labels: np.ndarray, rays: int,
    known: Chains | None = None,
) -> Chains:
    """Return the extended form factors between clusters of patches ``rows``, see `count_rays`.

    The tracer's elements are these patches, of order 0; ``known`` is as for `find_chains`.
    """
    bands, which = _kinds(tracer, known)
    clusters = make_beams(patches, rows, labels)
    n = int(labels.max(initial=-1)) + 1
    matrix = np.zeros((len(bands), n, n))
    parts = [np.zeros((n, len(which))) for _ in range(4)]

    def work(a, b):
        beams = clusters.rays(tracer.space.visibility, a, b, range(rays), tracer.seed)
        owner = np.repeat(np.arange(b - a), rays)
        index, factor = np.tile(np.arange(rays), b - a), np.full(len(owner), 1.0 / rays)
        steps = tracer.of_rays(*beams, owner, KEY + a + owner, index, factor)
        sent = sent_to(tracer, steps, b - a, bands, labels)
        matrix[:, a:b] = sent.weights
        for to, found in zip(parts, (sent.outside, sent.escaping, sent.straight), strict=False):
            to[a:b] = found

    over_ranges(work, n, max(1, RAYS_AT_ONCE // rays), "chains")
    matrix = matrix if known is None else known.matrix
    if tracer.caustics is not None:
        area = tracer.areas_of_elements
        power = area[:, None] * tracer.caustics.on(tracer.element, area)
        np.add.at(parts[2], labels, power / np.bincount(labels, area, n)[labels, None])
    return Chains(matrix, which, *parts)


def _kinds(tracer, known):
    """Return the bands that weights are asked of, and whose matrix each band has."""
    bands, which = tracer.space.optics.different_bands()
    return bands if known is None else bands[:0], which
