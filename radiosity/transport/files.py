"""Files that are whole or absent: written beside their place, then renamed into it."""

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written_whole(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a temporary path beside ``path`` that becomes it when the block ends well.

    The temporary file has the same suffix and exists, empty, from the start, so that an
    impossible place is found before the work. If the block raises, it is removed and whatever
    stood at ``path`` stays untouched. A link is followed; a device (``/dev/null``) is yielded as
    it is, since it cannot be replaced.

    Raises
    ------
    OSError
        Where no file can be made: the folder is missing or closed, or ``path`` is a folder.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "answer.txt"
    >>> with written_whole(place) as temporary:
    ...     _ = temporary.write_text("42")
    >>> place.read_text()
    '42'
    """
    place = Path(os.path.realpath(path))
    if _is_device(place):
        with _named(place):
            yield place
        return
    temporary = _beside(place)
    _check_place(place, temporary)
    try:
        with _named(place):
            yield temporary
        os.replace(temporary, place)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def _named(place):
    """Say in what is raised for lack of space, or the like, where that is."""
    try:
        yield
    except OSError as error:
        if error.filename or error.errno is None:
            raise
        message = f"cannot write: {error.strerror}"
        raise OSError(error.errno, message, str(place)) from error


def check_place(path: str | os.PathLike) -> None:
    """Raise the OSError that writing ``path`` would end in, before the work is done for it."""
    place = Path(os.path.realpath(path))
    if _is_device(place):
        return
    temporary = _beside(place)
    _check_place(place, temporary)
    temporary.unlink()


def _is_device(place):
    return place.exists() and not place.is_file() and not place.is_dir()


def _beside(place):
    return place.with_name(f".radiosity-{secrets.token_hex(8)}{place.suffix}")


def _check_place(place, temporary):
    """Create the temporary file, or say why nothing can be written there."""
    if place.is_dir():
        raise IsADirectoryError(
            errno.EISDIR, "cannot write a file over a folder; add a file name", str(place)
        )
    try:
        temporary.open("xb").close()
    except OSError as error:
        if not place.parent.exists():
            message = f"cannot write: folder {str(place.parent)!r} does not exist; create it first"
            raise FileNotFoundError(errno.ENOENT, message, str(place)) from None
        message = f"cannot write in folder {str(place.parent)!r}: {error.strerror}"
        raise OSError(error.errno, message, str(place)) from None
