"""The textures of a glTF file: pictures that are laid over faces, or their mean colours."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from radiosity.scene.gltf.buffers import Buffers
from radiosity.scene.gltf.document import Document, Entry
from radiosity.scene.model import SceneError

TRANSFORM = "KHR_texture_transform"
MOST_PIXELS = 1 << 27  # of all pictures of a file
CLAMPED, MIRRORED, REPEATED = 33071, 33648, 10497
SIGNATURES = {b"\x89PNG\r\n\x1a\n": "PNG", b"\xff\xd8\xff": "JPEG"}


@dataclass(frozen=True)
class Picture:
    """A decoded image file.

    Attributes
    ----------
    name : str
        By which a material's table names it.
    pixels : (h, w, 1 or 3) array
        Whole numbers as coded.
    alpha : (h, w) array or None
        Whole numbers as coded.
    """

    name: str
    pixels: np.ndarray
    alpha: np.ndarray | None

    @cached_property
    def counts(self) -> np.ndarray:
        """Return how many pixels have each coded value, (3, values)."""
        most = np.iinfo(self.pixels.dtype).max
        bands = np.moveaxis(self.pixels, 2, 0).reshape(self.pixels.shape[2], -1)
        found = np.array([np.bincount(band, minlength=most + 1) for band in bands])
        return np.broadcast_to(found, (3, most + 1))

    @cached_property
    def mean(self) -> np.ndarray:
        """Return the mean (3,) over the picture in linear light, where it is encoded as sRGB."""
        from radiosity.light.texture import srgb_to_linear  # files without textures need it not

        return self._mean(srgb_to_linear)

    @cached_property
    def linear_mean(self) -> np.ndarray:
        """Return the mean (3,) over the picture of values that are linear."""
        return self._mean(np.asarray)

    @property
    def highest(self) -> np.ndarray:
        """Return the greatest value (3,) of each band, in linear light."""
        from radiosity.light.texture import srgb_to_linear

        levels = np.arange(self.counts.shape[1])
        return srgb_to_linear(np.where(self.counts > 0, levels, 0).max(axis=1) / levels[-1])

    def _mean(self, linear):
        levels = np.arange(self.counts.shape[1])
        return self.counts @ linear(levels / levels[-1]) / self.counts[0].sum()

    @property
    def opacity(self) -> float:
        """Return the mean of alpha."""
        if self.alpha is None:
            return 1.0
        return float(self.alpha.mean() / np.iinfo(self.alpha.dtype).max)


class Images:
    """The pictures of a document, decoded where they are needed.

    Parameters
    ----------
    document : Document
    buffers : Buffers
    called : str
        What the names of its pictures begin with.
    """

    def __init__(self, document: Document, buffers: Buffers, called: str):
        self.document, self.buffers, self.called = document, buffers, called
        self.notes, self.pixels = {}, 0
        self._pictures = {}

    def picture(self, table: Entry, key: str) -> Picture | None:
        """Return the picture that a texture's key names; None without one or if it is not read."""
        if not table.has(key):
            return None
        texture = self.document.referred(table.child(key), "index", "textures")
        if texture is None:
            table.child(key).fail("index", "names a texture")
        image = self.document.referred(texture, "source", "images")
        if image is None:
            others = ", ".join(texture.child("extensions").value) or "no source"
            self._note(f"textures of {others}: not read, their factors alone count")
            return None
        if image.path[-1] not in self._pictures:
            self._pictures[image.path[-1]] = self._decoded(image)
        return self._pictures[image.path[-1]]

    def set_of(self, info: Entry) -> int:
        """Return which texture coordinates a texture takes."""
        return info.extension(TRANSFORM).whole("texCoord", info.whole("texCoord", 0))

    def repeats(self, info: Entry) -> bool:
        """Whether a texture repeats beyond its edges."""
        texture = self.document.referred(info, "index", "textures")
        sampler = texture and self.document.referred(texture, "sampler", "samplers")
        if sampler is None:
            return True
        wraps = {sampler.whole(key, REPEATED) for key in ("wrapS", "wrapT")}
        if MIRRORED in wraps:
            self._note("textures that repeat mirrored: repeat as they are")
        if len(wraps) > 1 and CLAMPED in wraps:
            self._note("textures that repeat along one axis only: repeat along both")
        return wraps != {CLAMPED}

    def placed(self, info: Entry, uv: np.ndarray) -> np.ndarray:
        """Return coordinates (..., 2) of a picture, v upwards, of those in the file.

        KHR_texture_transform scales, turns counter-clockwise as seen with v downwards, and moves:
        u' = s_x u cos(r) + s_y v sin(r) + o_x, v' = -s_x u sin(r) + s_y v cos(r) + o_y.
        """
        table = info.extension(TRANSFORM)
        scale = np.array(table.numbers("scale", (1.0, 1.0), -1e6, 1e6))
        offset = np.array(table.numbers("offset", (0.0, 0.0), -1e6, 1e6))
        angle = table.number("rotation", 0.0, -1e6, 1e6)
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        moved = uv * scale if angle == 0.0 else (uv * scale) @ turn.T
        return np.array([0.0, 1.0]) + (moved + offset) * [1.0, -1.0]

    def _note(self, text):
        self.notes[text] = self.notes.get(text, 0) + 1

    def _decoded(self, image) -> Picture | None:
        """Return the picture of an image; None, and a note, if it is of a kind that is not read."""
        data = self.buffers.view(image, "bufferView") if image.has("bufferView") else (
            self.buffers.uri(image)
        )
        kind = next((k for start, k in SIGNATURES.items() if data.startswith(start)), None)
        where = f"images[{image.path[-1]}]"
        if kind is None:
            said = image.text("mimeType") or "another format"
            self._note(f"images of {said}: not read, as they are not PNG or JPEG")
            return None
        from radiosity.scene.textures import decoded  # others need none of it

        try:
            pixels = decoded(data, f"{where}.{kind.lower()}")
        except SceneError as error:
            problems = [f"{where} {problem}" for problem in error.problems]
            raise SceneError(self.document.source, problems) from None
        self.pixels += pixels.shape[0] * pixels.shape[1]
        if self.pixels > MOST_PIXELS:
            text = f"has more than {MOST_PIXELS} pixels in its pictures: reduce them"
            raise SceneError(self.document.source, [text])
        if kind == "JPEG" and pixels.shape[2] == 4:
            self._note("JPEG images for print (CMYK): not read")
            return None
        alpha = pixels[..., -1] if pixels.shape[2] in (2, 4) else None
        bands = pixels[..., :1] if pixels.shape[2] < 3 else pixels[..., :3]
        return Picture(f"{self.called}/{where}.{kind.lower()}", bands, alpha)
