"""The Torrance-Sparrow model: light mirrored by facets, each after Fresnel."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from radiosity.light.facet_albedo import albedo_of_points, albedo_table, mirrored_share
from radiosity.light.facets import TrowbridgeReitz
from radiosity.light.frames import halfway
from radiosity.light.reflection import diffuse_mean, shown
from radiosity.light.shadowing import smith
from radiosity.light.visible import ellipsoid_view, mirrored_density, mirrored_view


@dataclass(frozen=True, eq=False)
class TorranceSparrow:
    """Mirror facets, f = rho D(H) F(L.H) G(L, V)/(4 (N.L)(N.V)), D normalised.

    *Torrance & Sparrow (1967)*; Blinn (1977), whose D has peak 1; eqs. 3.57 and 3.61 of
    Szirmay-Kalos with Fresnel at L.H, where a facet reflects. Reciprocal. Light that meets a second
    facet is lost, so the albedo is below 1 even where F = 1.

    Attributes
    ----------
    facets : TrowbridgeReitz, Beckmann, Gaussian or CosinePower
    shadowing : callable
        `shadowing.v_groove` or `shadowing.smith`.
    index : (bands,) or (1,), or None
        Relative index, complex for metals; None stands for F = 1.
    reflectance : (bands,) float64
        Scale rho in [0, 1].
    material : str
        What the index belongs to, in words.
    """

    facets: object
    shadowing: Callable
    index: np.ndarray | None = None
    reflectance: np.ndarray = field(default_factory=lambda: np.ones(3))
    material: str = ""
    reciprocal = True

    @property
    def dielectric(self) -> bool:
        """Whether light passes through the facets, to whatever lies below."""
        return self.index is not None and not np.iscomplexobj(self.index)

    @property
    def summary(self) -> str:
        """The model in words."""
        kind = type(self.facets).__name__
        (shape,) = vars(self.facets).items()
        words = f"{shape[0]} {shown(shape[1])}, {self.shadowing.__name__.replace('_', '-')}"
        scale = "" if np.all(self.reflectance == 1) else f", reflectance {shown(self.reflectance)}"
        return f"Torrance-Sparrow, {kind} {words}, {self.material or 'F = 1'}{scale}"

    def with_roughness(self, roughness) -> "TorranceSparrow":
        """Return the model with another roughness, or one for each point."""
        return replace(self, facets=replace(self.facets, roughness=roughness))

    @property
    def index_values(self) -> tuple | None:
        """The index as a tuple, by which tables are found again."""
        return None if self.index is None else tuple(self.index.tolist())

    def fresnel(self, cosine):
        """Return F (..., bands) of one facet; bands is 1 where all are alike."""
        return mirrored_share(self.index, cosine)

    def value(self, to_light, to_view):
        """Return f (..., bands) in 1/sr."""
        light, view, half, across = self._cosines(to_light, to_view)
        lit = (light > 0.0) & (view > 0.0)
        density = self.facets.relative(half) / self.facets.norm()
        hidden = self.shadowing(self.facets, np.abs(light), np.abs(view), across, half)
        mirrored = np.where(lit, density * hidden / 4.0, 0.0)
        return mirrored[..., None] * self.fresnel(across) * self.reflectance

    def shape(self, to_light, to_view):
        """Return s = D F G/(N.V) (..., bands) with D of peak 1, as Blinn writes it."""
        light, view, half, across = self._cosines(to_light, to_view)
        hidden = self.shadowing(self.facets, np.abs(light), np.abs(view), across, half) * light
        lit = (light > 0.0) & (view > 0.0)
        return np.where(lit, self.facets.relative(half) * hidden, 0.0)[..., None] * self.fresnel(
            across
        )

    def albedo(self, cosine):
        """Return the directional albedo (..., bands) to 1e-4, from a table made at first use.

        Where the roughness is an array, between tables of fixed ones, to 2e-3.
        """
        if np.ndim(self._shape):
            return albedo_of_points(self, cosine) * self.reflectance
        facets = type(self.facets)(float(self._shape))
        return albedo_table(facets, self.shadowing, self.index_values)(cosine) * self.reflectance

    @cached_property
    def mean_albedo(self):
        """Albedo under diffuse light, 2 int a(c) c dc."""
        each = np.asarray(self._shape)
        spread = self.with_roughness(each[..., None]) if each.ndim else self
        return diffuse_mean(lambda c: np.moveaxis(spread.albedo(c), -1, -2))

    def sample(self, to_view, u):
        """Return the view mirrored in facets of the distribution that it sees."""
        if self._ellipsoids:
            return ellipsoid_view(self.facets.roughness, u, to_view)
        return mirrored_view(self.facets.cosine_of(u[..., 0]), u[..., 1], to_view)

    def density(self, to_view, directions):
        """Return the density (...) per steradian of `sample`; D/(4 P(V)) with Smith's shadowing."""
        if not self._ellipsoids:
            return mirrored_density(self.facets.chosen, to_view, directions)
        _, view, half, across = self._cosines(directions, to_view)
        seen = 4.0 * np.maximum(view + self.facets.hidden(np.maximum(view, 0.0)), 1e-300)
        density = self.facets.relative(half) / self.facets.norm() / seen
        return np.where((half > 0.0) & (across > 0.0) & (view > 0.0), density, 0.0)

    @property
    def _ellipsoids(self) -> bool:
        """Whether the facets that the view sees can be sampled without any detour."""
        return self.shadowing is smith and isinstance(self.facets, TrowbridgeReitz)

    @property
    def _shape(self):
        return next(iter(vars(self.facets).values()))

    def _cosines(self, to_light, to_view):
        half, across = halfway(to_light, to_view)
        light, view = np.asarray(to_light)[..., 2], np.asarray(to_view)[..., 2]
        return light, view, np.clip(half[..., 2], 0.0, 1.0), across
