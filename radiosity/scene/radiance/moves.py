"""Where Radiance's ``xform`` puts things: its options as matrices, arrays of copies included."""

from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from radiosity.scene.geometry import rotation

MOST = 10_000  # copies of one thing
NEEDED = {"-t": 3, "-rx": 1, "-ry": 1, "-rz": 1, "-s": 1, "-mx": 0, "-my": 0, "-mz": 0}


class MoveError(ValueError):
    """What cannot be followed in the options."""


@dataclass(frozen=True)
class Moves:
    """What ``xform`` does: matrices (n, 4, 4), one a copy, and options beside them.

    ``inverted`` turns fronts to backs, ``modifier`` takes the place of the surfaces' own, ``rest``
    are the files.
    """

    matrices: np.ndarray
    rest: tuple[str, ...]
    modifier: str | None = None
    inverted: bool = False


def read_moves(words: tuple[str, ...]) -> Moves:
    """Return what the options of ``xform`` do, its name left out.

    Raises
    ------
    MoveError

    Examples
    --------
    >>> read_moves(("-a", "3", "-t", "2", "0", "0")).matrices[:, 0, 3].tolist()
    [0.0, 2.0, 4.0]
    """
    parts, words, kept = [("-i", 1, np.eye(4))], list(words), {"modifier": None, "inverted": False}
    while words and words[0].startswith("-"):
        option = words.pop(0)
        if option in NEEDED:
            kind, count, matrix = parts[-1]
            numbers = _numbers(option, words, NEEDED[option])
            parts[-1] = kind, count, _matrix(option, numbers) @ matrix
        elif option in ("-a", "-i"):
            parts.append((option, _count(option, words), np.eye(4)))
        elif option == "-m":
            kept["modifier"] = _word(option, words)
        elif option == "-n":
            _word(option, words)  # names of surfaces are those of groups here
        elif option == "-I":
            kept["inverted"] = True
        elif option not in ("-c", "-e"):
            raise MoveError(f"option {option} is not read")
    return Moves(_copies(parts), tuple(words), **kept)


def _word(option, words):
    if not words:
        raise MoveError(f"{option} is not followed by a name")
    return words.pop(0)


def _numbers(option, words, count):
    try:
        numbers = [float(words.pop(0)) for _ in range(count)]
    except (IndexError, ValueError):
        numbers = [np.nan]
    if not all(abs(x) <= 1e30 for x in numbers):  # false for nan
        raise MoveError(f"{option} needs {count} finite numbers")
    if option == "-s" and numbers[0] == 0.0:
        raise MoveError("-s 0 shrinks all to a point")
    return numbers


def _count(option, words):
    text = words.pop(0) if words else ""
    if not text.isdecimal() or len(text) > 9 or not 0 <= int(text) <= MOST:
        raise MoveError(f"{option} {text} must be a whole number up to {MOST}")
    return int(text)


def _matrix(option, numbers):
    matrix = np.eye(4)
    if option == "-t":
        matrix[:3, 3] = numbers
    elif option == "-s":
        matrix[:3, :3] *= numbers[0]
    elif option[1] == "m":
        axis = "xyz".index(option[2])
        matrix[axis, axis] = -1.0
    else:
        return rotation("xyz".index(option[2]), numbers[0])
    return matrix


def _copies(parts):
    """Return the matrices (n, 4, 4) of parts that are repeated (-i) or make rows of copies (-a)."""
    copies = np.eye(4)[None]
    for kind, count, matrix in parts:
        if kind == "-a" and count * len(copies) > MOST:
            raise MoveError(f"makes more than {MOST} copies")
        with np.errstate(all="ignore"):
            powers = list(accumulate([np.eye(4), *[matrix] * count], lambda a, b: b @ a))
        steps = np.array(powers[:-1] if kind == "-a" else powers[-1:]).reshape(-1, 1, 4, 4)
        copies = (steps @ copies).reshape(-1, 4, 4)
    if not np.isfinite(copies).all() or np.abs(copies).max(initial=0.0) > 1e30:
        raise MoveError("moves things beyond what can be computed")
    return copies
