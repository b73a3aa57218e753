"""Palettes: how the colours that a user writes become the numbers of a scene's bands.

A colour is written as [r, g, b] in linear sRGB (a number stands for three) or as a `Spectrum`. A
palette turns it into one number a band: `share` what is between 0 and 1, `light` what is watts. A
number of watts is neutral: white light, D65 where wavelengths are told apart.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from radiosity.light.bands import FEWEST, GREY, MOST, RGB, Bands, mixed

NEUTRAL = 1.0, 1.0, 1.0  # as light: white of the luminance 1
KINDS = "auto", "grey", "rgb", "spectral"
CELLS, ACCURACY = 24, 0.02  # measured: as many add little to what errs (benchmarks/bands.md)
PRIMARIES = 128  # cells that the spectra of red, green and blue are made of, where all nm are used


def kind_of(asked: str | int, has_spectra: bool, accuracy: float) -> str | int:
    """Return "grey", "rgb" or how many wavelengths a scene is to be computed in.

    Parameters
    ----------
    asked : str or int
        One of `KINDS`, or the number of wavelengths; ``auto`` takes rgb, or, where there are
        spectra, as many as ``spectral``: 24 for the accuracy 0.02, more as its inverse square root.

    Raises
    ------
    ValueError
        Anything else.
    """
    text = str(asked)
    count = int(text) if text.isascii() and text.isdecimal() and len(text) < 9 else 0
    if text not in KINDS and not FEWEST <= count <= MOST:
        raise ValueError(
            f"bands = {text!r} must be {', '.join(KINDS)} or a number of wavelengths from {FEWEST} "
            f"to {MOST}"
        )
    if count:
        return count
    if text == "spectral" or (text == "auto" and has_spectra):
        if not accuracy > 0.0:
            return CELLS  # no accuracy: whoever solves says so
        return int(np.clip(np.ceil(CELLS * np.sqrt(ACCURACY / accuracy)), FEWEST, MOST))
    return "rgb" if text == "auto" else text


@dataclass(frozen=True)
class Rgb:
    """Linear sRGB; spectra as they look in the light of a ``source`` (471,)."""

    source: np.ndarray | None = None
    bands = RGB
    shares = None

    def light(self, value) -> np.ndarray:
        """Return (3,) watts; none where light lies outside of sRGB."""
        return np.array(value) if isinstance(value, tuple) else np.maximum(_rgb_of(value), 0.0)

    def share(self, value) -> np.ndarray:
        """Return (3,) RGB(rho S)/RGB(S), cut to [0, 1]."""
        if isinstance(value, tuple):
            return np.array(value)
        from radiosity.light.spectrum import colour_of

        return np.clip(colour_of(value.share(), self.source), 0.0, 1.0)


@dataclass(frozen=True)
class Grey:
    """One band, the luminance; reflectances as they look in the light of a source.

    The ``rgb`` (3,) of the source, and, where there are spectra, the ``source`` (471,) itself.
    """

    rgb: np.ndarray
    source: np.ndarray | None = None
    bands = GREY

    @cached_property
    def shares(self) -> np.ndarray:
        """Return (1, 3) the shares of red, green and blue in the luminance of the light.

        Of light outside of sRGB components are negative, and have no share.
        """
        parts = RGB.y * np.maximum(self.rgb, 0.0)
        return (parts / parts.sum())[None]

    def light(self, value) -> np.ndarray:
        """Return (1,) watts, of which each counts K lumens."""
        if isinstance(value, tuple):
            return RGB.luminance(value)[None]
        from radiosity.light.spectrum import tristimulus

        return tristimulus(value.light())[1:2]

    def share(self, value) -> np.ndarray:
        """Return (1,) the luminous reflectance Y(rho S)/Y(S)."""
        if isinstance(value, tuple):
            return mixed(value, self.shares)
        from radiosity.light.spectrum import tristimulus

        left, whole = tristimulus(value.share() * self.source), tristimulus(self.source)
        return left[1:2] / whole[1]


@dataclass(frozen=True)
class Cells:
    """So many cells of wavelengths; RGB as smooth spectra, RGB light times D65."""

    count: int

    @cached_property
    def bands(self) -> Bands:
        """Return the cells."""
        from radiosity.light.spectrum import cells

        return cells(self.count)

    @property
    def shares(self) -> np.ndarray:
        """Return (count, 3) the shares of red, green and blue in the cells."""
        from radiosity.light.upsampling import primaries

        return primaries(self.count)

    def light(self, value) -> np.ndarray:
        """Return (count,) watts in the cells."""
        from radiosity.light import spectrum, upsampling

        if isinstance(value, tuple):
            return upsampling.white(self.count) * mixed(value, self.shares)
        return spectrum.watts(value.light(), self.count)

    def share(self, value) -> np.ndarray:
        """Return (count,) means over the cells."""
        from radiosity.light.spectrum import means

        if isinstance(value, tuple):
            return np.clip(mixed(value, self.shares), 0.0, 1.0)
        return means(value.share(), self.count)


@dataclass(frozen=True)
class Nanometres:
    """All of the 471 nm that spectra are summed over: what sources are added up in."""

    @cached_property
    def bands(self) -> Bands:
        """Return the whole nm."""
        from radiosity.light.colour import XYZ_TO_RGB
        from radiosity.light.spectrum import matching, nanometres

        names = tuple(f"{nm:.0f}nm" for nm in nanometres())
        return Bands(names, XYZ_TO_RGB @ matching().T, matching()[:, 1], nanometres())

    def light(self, value) -> np.ndarray:
        """Return (471,) watts."""
        from radiosity.light.spectrum import daylight

        return daylight() * self.share(value) if isinstance(value, tuple) else value.light()

    def share(self, value) -> np.ndarray:
        """Return (471,) values."""
        return mixed(value, self.shares) if isinstance(value, tuple) else value.share()

    @property
    def shares(self) -> np.ndarray:
        """Return (471, 3) the shares of red, green and blue."""
        from radiosity.light.spectrum import cells, nanometres
        from radiosity.light.upsampling import primaries

        middles = cells(PRIMARIES).wavelengths
        found = [np.interp(nanometres(), middles, p) for p in primaries(PRIMARIES).T]
        return np.stack(found, axis=1)


Palette = Rgb | Grey | Cells | Nanometres


def of_source(kind: str | int, source: np.ndarray | None) -> Palette:
    """Return the palette of a kind, see `kind_of`.

    Parameters
    ----------
    source : (3,) or (471,) float64 or None
        What light there is in the scene, to weigh reflectances with: RGB, or, where there are
        spectra, watts a nm; equal energy where all is dark. Not needed by wavelengths, nor by
        "rgb" where there are no spectra.
    """
    if isinstance(kind, int):
        return Cells(kind)
    if source is not None and not source.any():
        source = np.ones_like(source)
    if kind == "rgb":
        return Rgb(source if source is not None and len(source) > 3 else None)
    if len(source) == 3:
        return Grey(source)
    return Grey(Nanometres().bands.to_rgb(source), source)


def palette_of(bands: Bands) -> Palette:
    """Return a palette of some bands, for light; it knows nothing of the light in a scene."""
    if bands.wavelengths is None:
        return Rgb() if bands is RGB else Grey(np.ones(3))
    return Cells(bands.count)


def _rgb_of(spectrum):
    return Nanometres().bands.to_rgb(spectrum.light())
