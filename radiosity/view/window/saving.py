"""Files that the window writes: what it shows, the light that it gathered, and the solution."""

import itertools
from collections.abc import Callable
from pathlib import Path

from radiosity.transport.files import written_whole


def free_stem(source: str, suffixes: tuple[str, ...]) -> Path:
    """Return a name in the current folder, after a scene's file, that no file has with a suffix."""
    stem = Path(source).stem or "radiosity"
    names = (Path(f"{stem}-{k}") for k in itertools.count(1))
    return next(p for p in names if not any(_with(p, s).exists() for s in suffixes))


def save_all(source: str, writers: dict[str, Callable[[Path], None]]) -> str:
    """Write one file a suffix, all of the same free name; return what to tell of it.

    A writer is given the place to write to. What cannot be written is told, too.
    """
    stem = free_stem(source, tuple(writers))
    places = [_with(stem, suffix) for suffix in writers]
    try:
        for place, write in zip(places, writers.values(), strict=True):
            write(place)
    except (OSError, ValueError, RuntimeError, MemoryError) as error:
        return f"not saved: {error}"
    return f"saved {' and '.join(map(str, places))} in {Path.cwd()}"


def write_png(pixels, place: Path) -> None:
    """Write (h, w, 3) uint8 as they are."""
    import imageio.v3

    with written_whole(place) as temporary:
        imageio.v3.imwrite(temporary, pixels, extension=".png")


def _with(stem, suffix):
    return stem.with_name(stem.name + suffix)
