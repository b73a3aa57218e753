"""Following light back from points by way of surfaces that send it on, to elements (E22, E23)."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from radiosity.mesh.elements import Elements
from radiosity.transport.aiming import Targets, aimed_rays
from radiosity.transport.caustics import Caustics
from radiosity.transport.hemisphere import meet, rays_from
from radiosity.transport.highlights import counted, in_lobes
from radiosity.transport.images import Image
from radiosity.transport.irradiance import Lights
from radiosity.transport.paths import DEEP, Bundle, Space, first_rays, follow


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
    caustics : Caustics, optional
        Light of lamps by way of other mirrors and clear bodies.
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
    caustics: Caustics | None = None

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
        steps = itertools.chain([start], follow(space, start, keys, index, self.seed, depth=DEEP))
        for bounce, ends in enumerate(steps):
            k = ends.ray
            yield Step(owner[k], ends, bounce, keys[k], index[k], factor[k])

    def straight(self, step: Step) -> np.ndarray:
        """Return (k, bands) the radiance at the ends, W/(m2 sr), that comes straight from lights.

        What lobes there make of it, and what lights met after a bounce send themselves.
        """
        ends = step.ends
        found = in_lobes(
            self.space, self.lights, ends, step.keys, step.index, step.bounce, self.seed,
            self.images if self.lights.lamps else (),
        )
        if step.bounce > 0 and self.emitted.any():
            k, owner, _ = self.places(ends)
            share = counted(self.space, ends, self.areas)[k, None]
            found[k] += share * self.emitted[owner] / np.pi
        return found

    def beside_lights(self, coefficients: np.ndarray) -> np.ndarray:
        """Return coefficients (width n, bands) of radiosity without what `straight` tells."""
        rest = coefficients.copy()
        rest[: len(self.emitted)] -= self.emitted
        return rest

    def radiosity(self, ends: Bundle, coefficients: np.ndarray, ambient) -> np.ndarray:
        """Return (k, bands) what the ends send back: B of elements, pi L of the outside, W/m2."""
        found = np.zeros_like(ends.share)
        found[ends.sides < 0] = np.pi * ambient
        k, owner, basis = self.places(ends)
        n = len(self.elements)
        for a in range(self.elements.width):
            found[k] += basis[:, a, None] * coefficients[a * n + owner]
        return found

    def by_mirrors(self, points, normals, keys, samples: range, seed: int) -> np.ndarray:
        """Return (k, bands) the irradiance at points of surfaces by lights, but not straight.

        Of all lights in planar mirrors, of abstract ones by other ways, too.
        """
        found = np.zeros((len(points), self.space.optics.bands))
        for image in self.images:
            found += image.direct(points, normals, keys, samples, seed)
        return found if self.caustics is None else found + self.caustics.near(points, normals)

    @property
    def areas_of_elements(self) -> np.ndarray:
        """Return (n,) in scene units."""
        v = self.elements.vertices
        return 0.5 * np.linalg.norm(np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1]), axis=1)

    def lamplight(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Return the irradiance (k, bands) at points by lamps seen in planar mirrors, W/m2."""
        found = np.zeros((len(points), self.space.optics.bands))
        for image in self.images:
            found += image.lamplight(points, normals)
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
