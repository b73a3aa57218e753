"""Pictures: linear radiance, the exposure that shows it, and the files that keep it."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from radiosity.light.colour import encode, in_gamut, outside
from radiosity.light.photometry import luminance, photometric
from radiosity.transport.files import written_whole

if TYPE_CHECKING:
    from radiosity.view.falsecolour import Scale

_SHOWN = 0.8  # linear display value of the percentile below, automatic exposure
_PERCENTILE = 0.9
_BRIGHTEST_RGBE = 255.0 * 2.0**119  # the largest number that a shared 8-bit exponent holds


@dataclass(frozen=True)
class Image:
    """A picture in linear sRGB radiance.

    Attributes
    ----------
    pixels : (h, w, 3) float32
        Radiance in W/(m2 sr), rows from the top; converted from any real numbers.
    exposure : float
        Display value per radiance; only the tone-mapped files use it.
    error : (h, w) float32, optional
        Standard error of the pixels' luminance, W/(m2 sr), where it was estimated.
    lamp : (h, w, 4) float32, optional
        What lamps that are seen add to the radiance, and the share of the pixel that they fill.

    Raises
    ------
    ValueError
        Where the shape is another, a pixel is not finite or the exposure not positive.

    Examples
    --------
    >>> import numpy as np
    >>> from radiosity import Image
    >>> Image(np.ones((2, 3, 3)), exposure=0.5).pixels.dtype
    dtype('float32')
    """

    pixels: np.ndarray
    exposure: float = 1.0
    error: np.ndarray | None = None
    lamp: np.ndarray | None = None

    def __post_init__(self):
        with np.errstate(over="ignore"):  # told below, with the place
            pixels = np.ascontiguousarray(self.pixels, dtype=np.float32)
        if pixels.ndim != 3 or pixels.shape[2] != 3 or 0 in pixels.shape:
            raise ValueError(
                f"pixels of shape {pixels.shape} must be (h, w, 3): rows, columns, RGB"
            )
        bad = np.argwhere(~np.isfinite(pixels).all(axis=2))
        if len(bad):
            raise ValueError(
                f"{len(bad)} pixels are not finite, the first in row {bad[0][0]}, column "
                f"{bad[0][1]}: radiance must be a number of float32's range"
            )
        if not (self.exposure > 0 and np.isfinite(self.exposure)):
            raise ValueError(f"exposure = {self.exposure} must be positive and finite")
        object.__setattr__(self, "pixels", pixels)
        for name, last in (("error", ()), ("lamp", (4,))):
            if (extra := getattr(self, name)) is not None:
                extra, shape = np.asarray(extra, np.float32), pixels.shape[:2] + last
                if extra.shape != shape:
                    raise ValueError(f"{name} of shape {extra.shape} must be {shape}, as pixels")
                object.__setattr__(self, name, extra)

    @property
    def noise(self) -> float | None:
        """Return the rms of ``error`` relative to the mean luminance, of pixels without lamps."""
        if self.error is None:
            return None
        plain = np.full(self.error.shape, True) if self.lamp is None else self.lamp[..., 3] == 0
        mean = float(luminance(self.pixels[plain].astype(np.float64)).mean()) if plain.any() else 0
        return float(np.sqrt(np.mean(self.error[plain] ** 2.0))) / mean if mean > 0 else 0.0

    @property
    def outside(self) -> int:
        """Return how many pixels lie outside of sRGB: kept in linear files, greyed in ``.png``."""
        return int(np.sum(outside(self.pixels * self.exposure)))

    @property
    def luminance(self) -> np.ndarray:
        """Return (h, w) float64 luminance in cd/m2, 0 where it would be negative."""
        return np.maximum(photometric(self.pixels.astype(np.float64)), 0.0)

    def __repr__(self) -> str:
        """Return its size, without its pixels."""
        height, width = self.pixels.shape[:2]
        return f"<Image of {width} x {height} pixels>"

    def _repr_png_(self) -> bytes:
        """Return the tone-mapped picture as a PNG file, which notebooks show."""
        return png(self.shown())

    def shown(self, gamma: float | None = None) -> np.ndarray:
        """Return (h, w, 3) uint8 for a screen of sRGB, or of a gamma; greyed where `outside`.

        Of a pixel that a lamp fills in part, the lamp and the rest are cut to what the screen can
        show each by itself, then mixed by their shares. Cut after they are mixed, any pixel that
        a bright lamp touches would be as bright as the lamp, and its edges would be steps.
        """
        light = self.pixels.astype(np.float64)
        shown = in_gamut(light * self.exposure)
        if self.lamp is not None:
            share = self.lamp[..., 3].astype(np.float64)
            edge = (share > 0) & (share < 1)
            part, share = self.lamp[edge, :3].astype(np.float64), share[edge, None]
            both = part / share, np.maximum(light[edge] - part, 0.0) / (1.0 - share)
            lamp, rest = (np.clip(in_gamut(x * self.exposure), 0.0, 1.0) for x in both)
            shown[edge] = share * lamp + (1.0 - share) * rest
        return tone_map(shown, 1.0, gamma)


def tone_map(pixels: np.ndarray, exposure: float, gamma: float | None = None) -> np.ndarray:
    """Return 8-bit display values of linear radiance, in the input's shape.

    255 v, rounded to nearest, with v the `encode` of exposure * L, clipped to [0, 1]: by sRGB's
    curve or a power 1/gamma.
    """
    v = encode(np.asarray(pixels, dtype=np.float64) * exposure, gamma)
    return np.floor(255.0 * v + 0.5).astype(np.uint8)


def png(shown: np.ndarray) -> bytes:
    """Return display values (h, w, 3) uint8 as a PNG file."""
    import imageio.v3

    return imageio.v3.imwrite("<bytes>", shown, extension=".png")


def exposure_for(luminances: np.ndarray, weights: np.ndarray) -> float:
    """Return the exposure that shows the 90th percentile of luminance at 0.8 linear.

    exposure = 0.8 / Y90; Y90 is the least luminance such that what is no brighter carries at
    least 90 % of the weight. Where that much is black, Y90 is taken of the rest; where all is, or
    nothing has weight, the exposure is 1.

    Parameters
    ----------
    luminances : (k,) float64
        Luminance-weighted radiance of the surfaces that do not emit, W/(m2 sr).
    weights : (k,) float64
        Areas or numbers of pixels, at least 0.
    """
    lit, weight = np.ravel(luminances), np.ravel(weights)
    if lit.shape != weight.shape or not (np.all(lit >= 0) and np.all(weight >= 0)):
        raise ValueError(
            f"{lit.size} luminances and {weight.size} weights must be as many and none negative"
        )
    lit, weight = lit[weight > 0], weight[weight > 0]
    if not np.any(lit > 0):
        return 1.0
    level = _percentile(lit, weight)
    if level == 0:
        level = _percentile(lit[lit > 0], weight[lit > 0])
    return float(_SHOWN / level)


def write(
    image: Image,
    path: str | PathLike,
    gamma: float | None = None,
    scale: "Scale | None" = None,
) -> None:
    """Write a picture: whole, or not at all.

    ``.png`` is tone-mapped with the image's exposure (8-bit sRGB, or for screens of a ``gamma``),
    or with a ``scale`` (`radiosity.view.falsecolour.Scale`) shows luminance in false colours
    beside the scale; ``.exr`` and ``.npy`` keep the float32 radiance exactly; ``.hdr`` (Radiance
    RGBE) keeps it to 1/256 of a pixel's brightest band, negative values become 0.

    Raises
    ------
    ValueError
        For any other suffix, a gamma that is not positive, a gamma or scale for what is not
        ``.png``, or both.
    OSError
        Where the file cannot be written.

    Examples
    --------
    >>> import numpy as np
    >>> import radiosity
    >>> radiosity.write(radiosity.Image(np.ones((2, 3, 3))), "grey.exr")
    """
    if not isinstance(image, Image):
        raise TypeError(f"{image!r} is no Image: radiosity.render(solution) returns one")
    suffix = check_suffix(path, gamma, scale is not None)
    with written_whole(path) as temporary:
        if gamma is None and scale is None:
            _WRITERS[suffix](image, temporary)
        else:
            _write_png(image, temporary, gamma, scale)


def check_suffix(
    path: str | PathLike, gamma: float | None = None, false_colours: bool = False
) -> str:
    """Return a picture file's suffix; raise ValueError where it is none that `write` knows."""
    suffix = Path(path).suffix.lower()
    if gamma is not None:
        encode(0.0, gamma)
        if false_colours:
            raise ValueError("false colours are given as a screen shows them: leave out gamma")
    asked = "false colours are" if false_colours else gamma and f"gamma = {gamma:g} is"
    if asked and suffix in _WRITERS and suffix != ".png":
        raise ValueError(f"{asked} for .png: {suffix} keeps linear radiance")
    if suffix not in _WRITERS:
        raise ValueError(
            f"picture file {str(path)!r} has the suffix {suffix!r}; supported are "
            f"{', '.join(_WRITERS)}: .png for the eye, the others for linear radiance"
        )
    return suffix


def _percentile(values, weights):
    order = np.argsort(values)
    running = np.cumsum(weights[order])
    # Rounding of the sum must not decide which side of a step 90 % falls on.
    at = np.searchsorted(running, _PERCENTILE * (1.0 - 1e-9) * running[-1])
    return values[order][at]


def _write_png(image, path, gamma=None, scale=None):
    if scale is None:
        shown = image.shown(gamma)
    else:
        from radiosity.view.falsecolour import false_colours

        shown = false_colours(image.luminance, scale)
    path.write_bytes(png(shown))


def _write_exr(image, path):
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": image.pixels}) as file:
        file.write(str(path))


def _write_npy(image, path):
    with open(path, "wb") as file:
        np.save(file, image.pixels)


def _write_hdr(image, path):
    """Write Radiance's picture format, scanlines as they are (Ward 1991, "Real pixels").

    The header names the primaries, since Radiance's own differ from sRGB's. A normalised pixel
    can never look like a run-length code, which starts 2, 2 with a third byte below 128.
    """
    height, width, _ = image.pixels.shape
    header = (
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"
        "PRIMARIES= 0.64 0.33 0.30 0.60 0.15 0.06 0.3127 0.3290\n\n"
        f"-Y {height} +X {width}\n"
    )
    with open(path, "wb") as file:
        file.write(header.encode("ascii") + _rgbe(image.pixels).tobytes())


def _rgbe(pixels):
    """Return (h, w, 4) bytes: value = mantissa * 2^(e - 136), e shared by the three bands.

    Mantissas are rounded to nearest, e is such that the largest lies in 128 to 255.
    """
    value = np.clip(np.asarray(pixels, dtype=np.float64), 0.0, _BRIGHTEST_RGBE)
    brightest = value.max(axis=2)
    fraction, e = np.frexp(brightest)
    e = e + (fraction * 256.0 >= 255.5)
    mantissa = np.floor(np.ldexp(value, (8 - e)[..., None]) + 0.5)
    rgbe = np.concatenate([mantissa, (e + 128)[..., None]], axis=2)
    rgbe[(brightest == 0) | (e <= -128)] = 0
    return rgbe.astype(np.uint8)


_WRITERS = {".png": _write_png, ".exr": _write_exr, ".hdr": _write_hdr, ".npy": _write_npy}
