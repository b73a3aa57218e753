"""Coherent reflection and refraction: the share of light that a smooth surface mirrors or passes.

k_r and k_t of the shading equation, as laws of the angle: ``albedo(cosine)`` of any shape (...)
returns (..., bands), ``mean_albedo`` (bands,) is the share of diffuse light, 2 int k(c) c dc, and
``behind`` is the law for light that comes from inside the medium.
"""

from dataclasses import dataclass

import numpy as np

from radiosity.light import fresnel
from radiosity.light.reflection import shown


@dataclass(frozen=True, eq=False)
class Constant:
    """The same share at every angle.

    Attributes
    ----------
    share : (bands,) float64
        k_r or k_t in [0, 1].
    index : (bands,) or (1,), or None
        Relative index by which what passes is bent; None where it goes straight on.
    """

    share: np.ndarray
    index: np.ndarray | None = None

    @property
    def summary(self) -> str:
        """The law in words."""
        return shown(self.share)

    @property
    def mean_albedo(self):
        """The share itself."""
        return self.share

    @property
    def behind(self) -> "Constant":
        """The same share, bent the other way."""
        return Constant(self.share, None if self.index is None else 1.0 / self.index)

    def albedo(self, cosine):
        """Return the share (..., bands)."""
        return np.broadcast_to(self.share, (*np.shape(cosine), len(self.share)))


@dataclass(frozen=True, eq=False)
class FresnelMirror:
    """k_r = F(theta): what a smooth surface of some index reflects.

    Attributes
    ----------
    index : (bands,) or (1,)
        Relative, complex for metals.
    """

    index: np.ndarray

    @property
    def dielectric(self) -> bool:
        """Whether light passes through, to whatever lies below."""
        return not np.iscomplexobj(self.index)

    @property
    def summary(self) -> str:
        """The law in words."""
        return f"Fresnel, {shown_index(self.index)}"

    @property
    def behind(self) -> "FresnelMirror":
        """The law for light from the far side, which is totally reflected beyond an angle."""
        return FresnelMirror(1.0 / self.index)

    @property
    def mean_albedo(self):
        """Share of diffuse light, (bands,)."""
        return fresnel.mean_reflectance(self.index)

    def albedo(self, cosine):
        """Return F (..., bands)."""
        return fresnel.reflectance(np.asarray(cosine)[..., None], self.index)


@dataclass(frozen=True, eq=False)
class FresnelPassage:
    """k_t = 1 - F(theta): what goes on into a clear medium of some index.

    Attributes
    ----------
    index : (bands,) or (1,)
        Relative, real.
    """

    index: np.ndarray

    @property
    def summary(self) -> str:
        """The law in words."""
        return f"Fresnel, {shown_index(self.index)}"

    @property
    def behind(self) -> "FresnelPassage":
        """The law for light that leaves the medium."""
        return FresnelPassage(1.0 / self.index)

    @property
    def mean_albedo(self):
        """Share of diffuse light, (bands,)."""
        return 1.0 - fresnel.mean_reflectance(self.index)

    def albedo(self, cosine):
        """Return 1 - F (..., bands)."""
        return fresnel.transmittance(np.asarray(cosine)[..., None], self.index)


@dataclass(frozen=True, eq=False)
class Straight:
    """What passes, as if both sides had one index: the share of a law, along the same line.

    Attributes
    ----------
    passage : Constant or FresnelPassage
    """

    passage: object
    index = None

    def albedo(self, cosine):
        """Return k_t (..., bands)."""
        return self.passage.albedo(cosine)


def shown_index(index) -> str:
    """Return an index of refraction in words."""
    if not np.iscomplexobj(index):
        return f"index {shown(index)}"
    return "index " + " ".join(f"{v.real:.4g}+{v.imag:.4g}j" for v in index)
