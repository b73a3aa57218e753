"""Textures from files: pictures laid over the faces of a material."""

import contextlib
import io
import re
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from radiosity.light.bump import Bump
from radiosity.light.palette import Palette
from radiosity.light.shininess import Shininess
from radiosity.light.texture import Mixed, Texture, srgb_to_linear
from radiosity.scene.checks import RECEIVES, SpectrumFile, TextureKey
from radiosity.scene.energy import ROUNDING
from radiosity.scene.model import Material, SceneError
from radiosity.scene.schema import OPTICAL, MaterialTable, at, dotted, values_of

LARGEST, MOST = 1 << 24, 1 << 26  # pixels of a picture, of all of a scene
GREATEST = 1e30  # value, of single precision
CODED = ".png", ".jpg", ".jpeg"  # whole numbers, of which sRGB is the usual meaning
SUFFIXES = (*CODED, ".exr", ".npy")


@dataclass(frozen=True)
class Details:
    """What the textures of a material tell: its reflectance, its relief, its shininess."""

    texture: Texture | None = None
    bump: Bump | None = None
    shininess: Shininess | None = None

    def of(self, material: Material, palette: Palette) -> Material:
        """Return a material with these details; of textures diffuse and roughness are the mean.

        The three bands of a reflectance are mixed to those of the palette.
        """
        found = replace(material, bump=self.bump, shininess=self.shininess)
        if self.shininess is not None:
            lobe = found.specular.with_roughness(self.shininess.mean)
            found = replace(found, specular=lobe)
        if self.texture is None:
            return found
        shares = palette.shares
        texture = self.texture if shares is None else Mixed(self.texture, shares)
        mean = texture.mean
        return replace(found, texture=texture, diffuse=mean, absorptance=1.0 - mean)


def read_picture(path: Path, read_bytes: Callable[[Path], bytes]) -> np.ndarray:
    """Return the pixels (h, w, 1 or 3) of a picture: whole numbers as coded, or real ones.

    Raises
    ------
    SceneError
        Another format, too many pixels, a picture that is broken, or see-through.
    """
    if path.suffix.lower() not in SUFFIXES:
        text = f'has the suffix "{path.suffix}": textures are read from {", ".join(SUFFIXES)}'
        raise SceneError(str(path), [text])
    return _opaque(path, _pixels(path, read_bytes(path)))


def decoded(data: bytes, name: str) -> np.ndarray:
    """Return the pixels (h, w, 1 to 4) of the bytes of a PNG or JPEG file, whole numbers as coded.

    Its size is checked before it is decoded. Raises SceneError as `read_picture`; ``name`` ends in
    .png or .jpeg.
    """
    pixels = _pixels(Path(name), data)
    return pixels if pixels.dtype.kind == "u" else pixels.astype(np.uint16)  # older Pillow's int32


def _pixels(path, data):
    """Return the pixels (h, w, bands) of a file's bytes."""
    reader = {".exr": _exr, ".npy": _npy}.get(path.suffix.lower(), _coded)
    try:
        pixels = reader(path, data)
    except SceneError:
        raise
    except Exception as error:  # a reader of other people's files fails in any way
        cause = error.__cause__ or error
        said = re.sub(r"<[^<>]* object at 0x[0-9a-f]+>", "it", str(cause))
        problem = f"is not a picture that can be read: {type(cause).__name__}: {said}"
        raise SceneError(str(path), [problem]) from error
    return pixels[..., None] if pixels.ndim == 2 else pixels


def _check_size(path, shape):
    """Raise where a picture is too large, before it is decoded."""
    if len(shape) not in (2, 3) or 0 in shape:
        text = f"has the shape {tuple(shape)}, a picture has rows, columns and 1 or 3 bands"
        raise SceneError(str(path), [text])
    if shape[0] * shape[1] > LARGEST:
        text = f"has {shape[1]} x {shape[0]} pixels, at most {LARGEST} are read: reduce it"
        raise SceneError(str(path), [text])


def _coded(path, data):
    """Return the pixels of a PNG or JPEG file."""
    import imageio.v3

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its size, which is checked here
        with imageio.v3.imopen(io.BytesIO(data), "r", plugin="pillow") as file:
            _check_size(path, file.properties(index=0).shape)
            return file.read(index=0)


def _exr(path, data):
    """Return the pixels of an OpenEXR file: its R, G and B, or Y."""
    import OpenEXR

    low, high = OpenEXR.File(str(path), header_only=True).header()["dataWindow"]
    _check_size(path, (high - low + 1)[::-1])
    with contextlib.redirect_stdout(sys.stderr):  # where it warns, amid results
        channels = OpenEXR.File(str(path)).channels()
    for name in ("RGB", "RGBA", "Y"):
        if name in channels:
            return channels[name].pixels.astype(float)
    text = f"has the channels {', '.join(channels)}: give R, G and B, or Y"
    raise SceneError(str(path), [text])


def _npy(path, data):
    """Return the numbers of an array file, whose header tells its size."""
    pixels = np.load(io.BytesIO(data), allow_pickle=False)
    _check_size(path, pixels.shape)
    if pixels.dtype.kind not in "biuf":
        raise SceneError(str(path), [f"holds {pixels.dtype}, a picture holds real numbers"])
    return pixels.astype(float)


def _most(pixels):
    """Return the number that stands for 1."""
    return np.iinfo(pixels.dtype).max if pixels.dtype.kind in "iu" else 1.0


def _opaque(path, pixels):
    """Return pixels (h, w, 1 or 3) without an opaque alpha; raise SceneError for other bands."""
    bands = pixels.shape[2]
    if bands in (2, 4):
        see_through = np.argwhere(pixels[..., -1] < _most(pixels))
        if len(see_through):
            row, column = see_through[0]
            text = (
                f"row {row}, column {column} is see-through, or the picture is for print (CMYK): "
                "give it a background, or save it as RGB"
            )
            raise SceneError(str(path), [text])
        pixels = pixels[..., :-1]
    elif bands not in (1, 3):
        raise SceneError(str(path), [f"has {bands} bands, textures have 1 or 3"])
    return pixels


def details_of(
    tables: dict[str, MaterialTable | None], picture: Callable[[str], np.ndarray], problems: list
) -> dict[str, Details]:
    """Return the details of the materials that have some; what is wrong becomes a problem."""
    found, read = {}, _Reader(picture, problems)
    for name, table in tables.items():
        before, texture, bump, shininess = len(problems), None, None, None
        if table is None:
            continue
        path = ("materials", name, "diffuse")
        if isinstance(table.diffuse, TextureKey):
            texture = read(table.diffuse, path)
            texture = texture and _reflectance(table, texture, path, problems)
        if table.bump is not None:
            key = replace(table.bump, encoding=table.bump.encoding or "linear")
            bump = read(key, (*path[:2], "bump"))
            bump = bump and Bump(replace(bump, texels=bump.texels[..., :1]), table.bump.height)
        rough = table.specular and table.specular.roughness
        if isinstance(rough, TextureKey):
            shininess = _shininess(rough, (*path[:2], "specular", "roughness"), read, problems)
        if (texture or bump or shininess) and len(problems) == before:
            found[name] = Details(texture, bump, shininess)
    return found


class _Reader:
    """Textures that keys name, one for all materials that share it; what is wrong is a problem."""

    def __init__(self, picture, problems):
        self._picture, self._problems = picture, problems
        self._found, self._texels = {}, 0

    def __call__(self, key, path) -> Texture | None:
        """Return a texture, None where something is wrong with it; ``path`` is that of its key."""
        coded = Path(key.texture).suffix.lower() in CODED
        encoded = key.encoding == "sRGB" or (key.encoding is None and coded)
        which = key.texture, encoded, key.repeat
        if which not in self._found:
            try:
                self._found[which] = self._read(key, encoded)
            except SceneError as error:
                where = (*path, "texture")
                self._problems += [at(where, key.texture, text) for text in error.problems]
                return None
        return self._found[which]

    def _read(self, key, encoded):
        pixels = self._picture(key.texture)
        self._texels += pixels.shape[0] * pixels.shape[1]
        if self._texels > MOST:
            text = f"brings the scene's textures to {self._texels} texels, at most {MOST} are read"
            raise SceneError(key.texture, [f"{text}: reduce them"])
        bad = np.argwhere(~(np.abs(pixels) < GREATEST).all(axis=2))
        if len(bad):
            text = f"row {bad[0][0]}, column {bad[0][1]} must be finite, and below {GREATEST:g}"
            raise SceneError(key.texture, [text])
        return Texture(_linear(pixels, encoded), key.repeat)


def _linear(pixels, encoded):
    """Return the values of pixels, in single precision; whole numbers are looked up."""
    decode = srgb_to_linear if encoded else np.asarray
    if pixels.dtype.kind not in "iu":
        return decode(pixels.astype(float))
    most = _most(pixels)
    return decode(np.arange(most + 1) / most).astype(np.float32)[pixels]


def _shininess(key, path, read, problems):
    """Return the shininess that a texture tells; texels out of bounds are problems."""
    texture = read(replace(key, encoding=key.encoding or "linear"), path)
    if texture is None:
        return None
    texels = texture.texels[..., :1]
    wrong = np.argwhere((texels < 0.0) | (texels > 1.0 + ROUNDING))
    if len(wrong):
        row, column, _ = wrong[0]
        problems.append(
            f'{dotted((*path, "texture"))} = "{key.texture}" row {row}, column {column}: '
            f"{texels[row, column, 0]:.6g} must lie in [0, 1]: 0 is shiny, 1 is dull"
        )
        return None
    return Shininess(replace(texture, texels=texels), key.minimum)


def _reflectance(table, texture, path, problems):
    """Return the texture of the reflectance, three bands; texels out of bounds are problems."""
    key = table.diffuse
    scaled = texture.bands != 3 or key.scale != (1.0, 1.0, 1.0)
    texels = texture.texels * np.array(key.scale, np.float32) if scaled else texture.texels
    wrong = (texels < 0.0) | (texels > 1.0 + ROUNDING)
    if wrong.any():
        row, column, band = np.argwhere(wrong)[0]
        problems.append(
            f'{dotted((*path, "texture"))} = "{key.texture}" row {row}, column {column}: '
            f"{texels[row, column, band]:.6g} in band {'rgb'[band]} must lie in [0, 1]: "
            f"{RECEIVES}; {wrong.any(axis=2).sum()} texels do not: lower its scale"
        )
        return None
    found = Texture(texels, key.repeat) if scaled else texture
    too_much = _with_others(table, found.highest)
    if too_much:
        problems.append(f'{dotted((*path, "texture"))} = "{key.texture}": where it is brightest '
                        f"{too_much}")  # fmt: skip
    return None if too_much else found


def _with_others(table, highest):
    """Return how a texture's brightest texel and what else a material returns are too much."""
    if not any(getattr(table, key) for key in OPTICAL) or any(values_of(table, SpectrumFile)):
        return ""  # with spectra it is told of all materials
    from radiosity.scene.optics import excess, optics_of

    return excess(highest, *optics_of(table))
