"""Numbers for a page: short, deflated, and as text."""

import base64
import zlib

import numpy as np

HALF = 60_000.0  # what the greatest value of a row becomes: half floats end at 65504


class Packer:
    """Arrays one after another, with what a page needs to read them.

    Attributes
    ----------
    entries : dict
        By name: ``kind``, ``shape`` and, of half floats, a ``scale`` for each row.
    """

    def __init__(self):
        self.entries, self._parts = {}, []

    def floats(self, name: str, values: np.ndarray) -> None:
        """Add (n, c) numbers in single precision."""
        self._add(name, "float32", np.asarray(values, "<f4"))

    def halves(self, name: str, values: np.ndarray) -> None:
        """Add rows (r, n) of numbers of 11 binary digits, each row with its own scale."""
        scale = np.abs(values).max(axis=1, initial=0.0) / HALF
        scale[scale == 0.0] = 1.0
        self._add(name, "float16", (values / scale[:, None]).astype("<f2"), scale=scale.tolist())

    def steps(self, name: str, values: np.ndarray) -> None:
        """Add whole numbers (n,) as differences of each to the one before."""
        self._add(name, "int32", np.diff(np.ravel(values), prepend=0).astype("<i4"))

    def text(self) -> str:
        """Return all of them, deflated, in base64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 9)).decode("ascii")

    def _add(self, name, kind, values, **more):
        """Add values, the first byte of all of them first: alike bytes deflate well together."""
        self.entries[name] = {"kind": kind, "shape": list(values.shape), **more}
        rows = np.frombuffer(values.tobytes(), np.uint8).reshape(-1, values.itemsize)
        self._parts.append(np.ascontiguousarray(rows.T).tobytes())


def picture_url(texels: np.ndarray) -> tuple[str, float]:
    """Return a picture (h, w, 3) of linear values as a data: address, and what its white is."""
    import imageio.v3

    from radiosity.view.image import tone_map

    white = float(texels.max(initial=0.0)) or 1.0
    kind, more = ("png", {}) if texels[..., 0].size <= _SMALL else ("jpeg", {"quality": 92})
    shown = tone_map(_reduced(texels), 1.0 / white)
    data = imageio.v3.imwrite("<bytes>", shown, extension=f".{kind}", **more)
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}", white


_SMALL, _LARGEST = 1 << 16, 1024  # texels of a picture that is kept to the bit; along its side


def _reduced(texels):
    """Return a picture with sides of at most _LARGEST: means over blocks."""
    for axis in (0, 1):
        block = -(-texels.shape[axis] // _LARGEST)
        start = np.arange(0, texels.shape[axis], block)
        count = np.diff(np.append(start, texels.shape[axis]))
        shape = (-1, 1, 1) if axis == 0 else (1, -1, 1)
        texels = np.add.reduceat(texels, start, axis=axis) / count.reshape(shape)
    return texels
