"""Light that comes to elements through mirrors, clear bodies and lobes: extended form factors (E23).

E(x) = sum over j of int_j (K + K_c)(x, y) B_j(y) dA: beside the kernel K of what x sees, K_c of what
it sees by way of surfaces that send light on along single directions. It is found by cosine-
distributed rays from x, each followed through such surfaces (`follow`), for all that B holds what
leaves diffusely only.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.sparse import csr_array

from radiosity.light.frames import frame, to_local
from radiosity.light.sources import Light
from radiosity.mesh.elements import Elements, Nodes
from radiosity.transport.hemisphere import meet, rays_from
from radiosity.transport.lamps import reaching
from radiosity.transport.paths import Bundle, Space, first_rays, follow
from radiosity.transport.threads import Progress, over_ranges, silent

RAYS_AT_ONCE = 1 << 15


@dataclass(frozen=True)
class Tracer:
    """What follows light back from points, by way of what sends it on, to elements.

    Attributes
    ----------
    space : Space
    elements : Elements
    element : (2 * fronts,) int
        Element of each side, -1 where there is none.
    lamps : tuple of Light
    unit_m : float
        Metres a scene unit.
    seed : int
    """

    space: Space
    elements: Elements
    element: np.ndarray
    lamps: tuple[Light, ...]
    unit_m: float
    seed: int

    def paths(self, points, normals, keys, samples: range) -> Iterator[tuple[np.ndarray, Bundle]]:
        """Yield the point (k,) and the end of all rays from points: first hits, then bounces.

        Parameters
        ----------
        points, normals : (p, 3) float64
            Scene units, unit vectors.
        keys : (p,) int
            What patterns are hashed from.
        samples : range
            Which points of the pattern to use; every ray stands for 1 of so many.
        """
        space, count = self.space, len(samples)
        origins, directions = rays_from(
            space.visibility, points, normals, keys, samples, self.seed
        )
        begin = origins.copy()
        sides, hits = meet(space.visibility, space.table, origins, directions)
        owner = np.repeat(np.arange(len(points)), count)
        start = first_rays(space, sides, hits, begin, directions, owner)
        yield owner, start
        index = np.tile(np.arange(samples.start, samples.stop), len(points))
        for ends in follow(space, start, np.repeat(keys, count), index, self.seed):
            yield owner[ends.ray], ends

    def lamplight(self, ends: Bundle) -> np.ndarray:
        """Return (k, bands) the radiance that lobes at the ends make of lamps' light, W/(m2 sr)."""
        found, space = np.zeros_like(ends.share), self.space
        k = np.flatnonzero(space.sends_on(ends.sides)) if self.lamps else np.zeros(0, int)
        if not len(k):
            return found
        face, back = space.faces(ends.sides[k]), ends.sides[k] % 2
        points = space.points(ends.hits[k].astype(np.float64))
        normals = space.optics.facing(face, back == 1, points)
        for side, _, _, mine in space.optics.groups(face, back):
            if side.lobe is None:
                continue
            frames = frame(normals[mine])
            view = to_local(frames, -ends.directions[k[mine]].astype(np.float64))
            for lamp in self.lamps:
                here = reaching(space.visibility, lamp, points[mine], normals[mine], self.unit_m)
                value = side.lobe.value(to_local(frames, here.to_light), view)
                found[k[mine]] += value * here.irradiance
        return found

    def radiosity(self, ends: Bundle, coefficients, ambient) -> np.ndarray:
        """Return (k, bands) what the ends send back: B of elements, pi L of the outside, W/m2."""
        found = np.zeros_like(ends.share)
        found[ends.sides < 0] = np.pi * ambient
        k, owner, basis = self.places(ends)
        n = len(self.elements)
        for a in range(self.elements.width):
            found[k] += basis[:, a, None] * coefficients[a * n + owner]
        return found

    def places(self, ends: Bundle) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return which of the ends lie on elements, on which, and their basis there (k, width)."""
        owner = np.where(ends.sides >= 0, self.element[ends.sides], -1)
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
    lamplight : (k, bands) float64
        Irradiance that lamps cause, W/m2.
    """

    weights: np.ndarray
    outside: np.ndarray
    escaping: np.ndarray
    lamplight: np.ndarray


def sent_to(
    tracer: Tracer, points, normals, keys, samples: range, bands: np.ndarray
) -> Sent:
    """Return what points get by way of surfaces that send light on; weights of some ``bands``."""
    n, every = len(tracer.elements) * tracer.elements.width, tracer.space.optics.bands
    weights = np.zeros((len(bands), len(points), n))
    outside, escaping, lamplight = (np.zeros((len(points), every)) for _ in range(3))
    for bounce, (owner, ends) in enumerate(tracer.paths(points, normals, keys, samples)):
        weight = ends.weight / len(samples)
        if tracer.lamps:
            np.add.at(lamplight, owner, np.pi * weight * tracer.lamplight(ends))
        if bounce == 0:
            continue
        k, element, basis = tracer.places(ends)
        _add(owner[k], element, basis, weight[k][:, bands], weights)
        k = np.flatnonzero(ends.sides < 0)
        np.add.at(outside, owner[k], weight[k])
        np.add.at(escaping, owner[k], ends.share[k] / len(samples))
    return Sent(weights, outside, escaping, lamplight)


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
    outside, escaping, lamplight : (m, bands) float64
        Coefficients of what `Sent` holds.
    """

    matrix: np.ndarray
    which: np.ndarray
    outside: np.ndarray
    escaping: np.ndarray
    lamplight: np.ndarray

    def arriving(self, b: np.ndarray) -> np.ndarray:
        """Return the coefficients (m, bands) of the irradiance that radiosities b cause."""
        found = np.empty_like(b)
        for k in np.unique(self.which):
            mine = self.which == k
            found[:, mine] = self.matrix[k] @ b[:, mine]
        return found

    def entering(self, ambient: np.ndarray) -> np.ndarray:
        """Return the coefficients (m, bands) of the irradiance that no element sends."""
        return np.pi * self.outside * ambient + self.lamplight

    def without_slopes(self, n: int) -> "Chains":
        """Return the same where the slopes of n linear elements neither send nor receive."""
        matrix = np.zeros_like(self.matrix)
        matrix[:, :n, :n] = self.matrix[:, :n, :n]
        parts = (x.copy() for x in (self.outside, self.escaping, self.lamplight))
        flat = Chains(matrix, self.which, *parts)
        for x in (flat.outside, flat.escaping, flat.lamplight):
            x[n:] = 0.0
        return flat

    def of_bands(self, bands: np.ndarray | slice) -> "Chains":
        """Return the same for some bands."""
        parts = (x[:, bands] for x in (self.outside, self.escaping, self.lamplight))
        return Chains(self.matrix, self.which[bands], *parts)

    def spread(self, rows: np.ndarray, n: int) -> "Chains":
        """Return the same for n coefficients of which these are the ``rows`` (m,)."""
        matrix = np.zeros((len(self.matrix), n, n))
        matrix[:, rows[:, None], rows] = self.matrix
        parts = (np.zeros((n, len(self.which))) for _ in range(3))
        made = Chains(matrix, self.which, *parts)
        for name in ("outside", "escaping", "lamplight"):
            getattr(made, name)[rows] = getattr(self, name)
        return made


def find_chains(
    tracer: Tracer, nodes: Nodes, rays: int, progress: Progress = silent
) -> Chains:
    """Return the extended form factors of elements, by ``rays`` from each of their nodes."""
    laws = tracer.space.optics.laws
    _, bands, which = np.unique(laws, axis=1, return_index=True, return_inverse=True)
    elements = tracer.elements
    n, width = len(elements), elements.width
    fit = nodes.fit[: width * n]
    m, every = width * n, len(laws[0])
    matrix = np.zeros((len(bands), m, m))
    parts = [np.zeros((len(nodes.points), every)) for _ in range(3)]
    first = np.searchsorted(nodes.owner, np.arange(n + 1))
    normal = elements.normal[nodes.owner]

    def work(a, b):
        here = slice(first[a], first[b])
        keys = np.arange(first[a], first[b])
        sent = sent_to(tracer, nodes.points[here], normal[here], keys, range(rays), bands)
        rows = (np.arange(width)[:, None] * n + np.arange(a, b)).ravel()
        part = csr_array(fit[rows][:, here])
        for k in range(len(bands)):
            matrix[k, rows] = part @ sent.weights[k]
        for to, found in zip(parts, (sent.outside, sent.escaping, sent.lamplight), strict=True):
            to[here] = found

    over_ranges(work, n, max(1, RAYS_AT_ONCE // (4 * rays)), "chains", progress)
    return Chains(matrix, which.ravel(), *(fit @ x for x in parts))
