"""Light that comes to elements by way of mirrors, clear bodies and lobes (E23).

Extended form factors: E(x) = sum over j of int_j (K + K_c)(x, y) B_j(y) dA, beside the kernel K of
what x sees K_c of what it sees by way of surfaces that send light on along single directions. B
holds only what leaves diffusely. K_c is found by cosine-distributed rays from x, each followed
through such surfaces (`follow`).
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.sparse import csr_array

from radiosity.mesh.elements import Elements, Nodes
from radiosity.mesh.patches import Patches
from radiosity.transport.aiming import Targets, aimed_rays
from radiosity.transport.counting import make_beams
from radiosity.transport.hemisphere import meet, rays_from
from radiosity.transport.highlights import counted, in_lobes
from radiosity.transport.images import Image
from radiosity.transport.irradiance import Lights
from radiosity.transport.paths import Bundle, Space, first_rays, follow
from radiosity.transport.threads import Progress, over_ranges, silent

RAYS_AT_ONCE = 1 << 15
KEY = 1 << 48  # tells the patterns of clusters from others


@dataclass(frozen=True)
class Step:
    """Where rays from points end, after some bounces.

    Attributes
    ----------
    owner : (k,) int
        Point that each comes from.
    ends : Bundle
    bounce : int
        0 for what the rays from the points met first.
    keys, index : (k,) int
        Of the rays, see `follow`.
    factor : (k,) float64
        What radiance there is worth in irradiance of the point, as a share of pi.
    """

    owner: np.ndarray
    ends: Bundle
    bounce: int
    keys: np.ndarray
    index: np.ndarray
    factor: np.ndarray

    @property
    def weight(self) -> np.ndarray:
        """Return (k, bands): what radiosity at the ends is worth in irradiance of the points."""
        return self.factor[:, None] * self.ends.weight


@dataclass(frozen=True)
class Tracer:
    """What follows light back from points, by way of what sends it on, to elements.

    Attributes
    ----------
    space : Space
    elements : Elements
    element : (2 * fronts,) int
        Element of each side, -1 where there is none.
    lights : Lights
        That lobes look for by themselves.
    emitted : (n, bands) float64
        Exitance of the elements that these are, W/m2.
    areas : (f,) float64
        Of the faces that these are, 0 for others.
    seed : int
    targets : Targets, optional
        What rays are aimed at; without, they look all around.
    images : tuple of Image
        What is known exactly of planar mirrors, and left out of what rays bring.
    """

    space: Space
    elements: Elements
    element: np.ndarray
    lights: Lights
    emitted: np.ndarray
    areas: np.ndarray
    seed: int
    targets: Targets | None = None
    images: tuple[Image, ...] = ()

    def paths(self, points, normals, keys, samples: range) -> Iterator[Step]:
        """Return the ends of all rays from points: first hits, then bounce by bounce.

        Parameters
        ----------
        points, normals : (p, 3) float64
            Scene units, unit vectors.
        keys : (p,) int
            What patterns are hashed from.
        samples : range
            Which points of the pattern to use; every ray stands for 1 of so many.
        """
        visibility, count = self.space.visibility, len(samples)
        owner = np.repeat(np.arange(len(points)), count)
        index = np.tile(np.asarray(samples), len(points))
        here = points, normals, keys, samples, self.seed
        if self.targets is None:
            rays = rays_from(visibility, *here)
            return self.of_rays(*rays, owner, keys[owner], index, np.full(len(owner), 1.0 / count))
        *rays, face, factor = aimed_rays(visibility, self.targets, *here)
        return self.of_rays(*rays, owner, keys[owner], index, factor / count, face)

    def of_rays(
        self, origins, directions, owner, keys, index, factor, face=None
    ) -> Iterator[Step]:
        """Yield the ends of rays, see `Step` and `paths`.

        Parameters
        ----------
        origins, directions : (k, 3) float32
            In ray coordinates; origins are overwritten.
        face : (k,) int, optional
            That each is aimed at: one that meets another face first does not count.
        """
        space, begin = self.space, origins.copy()
        sides, hits = meet(space.visibility, space.table, origins, directions)
        if face is not None:
            factor[(sides < 0) | (space.faces(sides) != face)] = 0.0
        good = np.flatnonzero(space.sends_on(sides) & (factor > 0.0))
        start = first_rays(space, sides, hits, begin, directions, owner).some(good)
        steps = itertools.chain([start], follow(space, start, keys, index, self.seed))
        for bounce, ends in enumerate(steps):
            k = ends.ray
            yield Step(owner[k], ends, bounce, keys[k], index[k], factor[k])

    def straight(self, step: Step) -> np.ndarray:
        """Return (k, bands) the radiance at the ends, W/(m2 sr), that comes straight from lights.

        What lobes there make of it, and what lights met after a bounce send themselves.
        """
        ends = step.ends
        found = in_lobes(
            self.space, self.lights, ends, step.keys, step.index, step.bounce, self.seed
        )
        if step.bounce > 0 and self.emitted.any():
            k, owner, _ = self.places(ends)
            share = counted(self.space, ends, self.areas)[k, None]
            found[k] += share * self.emitted[owner] / np.pi
        return found

    def radiosity(self, ends: Bundle, coefficients: np.ndarray, ambient) -> np.ndarray:
        """Return (k, bands) what the ends send back: B of elements, pi L of the outside, W/m2."""
        found = np.zeros_like(ends.share)
        found[ends.sides < 0] = np.pi * ambient
        k, owner, basis = self.places(ends)
        n = len(self.elements)
        for a in range(self.elements.width):
            found[k] += basis[:, a, None] * coefficients[a * n + owner]
        return found

    def lamplight(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Return the irradiance (k, bands) at points by lamps seen in mirrors, W/m2."""
        found = np.zeros((len(points), self.space.optics.bands))
        for image in self.images:
            found += image.lamplight(points, normals, self.lights.unit_m)
        return found

    def places(self, ends: Bundle) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return which of the ends lie on elements, on which, and their basis there (k, width).

        But for those that are known exactly.
        """
        owner = np.where((ends.sides >= 0) & (ends.state <= 0), self.element[ends.sides], -1)
        k = np.flatnonzero(owner >= 0)
        owner, basis = owner[k], np.ones((len(k), self.elements.width))
        if self.elements.order == 1:
            apart = self.space.points(ends.hits[k]) - self.elements.centroid[owner]
            basis[:, 1:] = np.einsum("kac,kc->ka", self.elements.axes[owner], apart)
        return k, owner, basis


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
    tracer: Tracer, nodes: Nodes, rays: int, progress: Progress = silent
) -> Chains:
    """Return the extended form factors of elements, by ``rays`` from each of their nodes."""
    bands, which = tracer.space.optics.different_bands()
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
    return Chains(matrix, which, *(fit @ x for x in parts), emitted)


def cluster_chains(
    tracer: Tracer, patches: Patches, rows: np.ndarray, labels: np.ndarray, rays: int
) -> Chains:
    """Return the extended form factors between clusters of patches ``rows``, see `count_rays`.

    The tracer's elements are these patches, of order 0.
    """
    bands, which = tracer.space.optics.different_bands()
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
    return Chains(matrix, which, *parts)
