"""Photometric files of makers: what they say of a luminaire, whatever the format.

LM-63 (`radiosity.scene.photometric.ies`) and EULUMDAT (`radiosity.scene.photometric.eulumdat`) both
list intensities at angles gamma in some of the C-planes, and leave out planes that follow by
symmetry.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from radiosity.light.luminaire import Distribution, of_values
from radiosity.scene.model import SceneError

LONGEST_TEXT = 1 << 24  # characters
MOST_VALUES = 1 << 22
DIMMEST, BRIGHTEST = 1e-30, 1e30  # cd
CLOSE = 0.05  # share by which what is measured may miss what is stated
SAME = 1e-6  # degrees, by which angles may miss what they mean
STEP = 1e-3  # degrees, the least by which angles must rise: digits of the flux are lost below
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True)
class Photometric:
    """What a file says of a luminaire.

    Attributes
    ----------
    file : str
        The name of the file.
    format : str
        As LM-63-2002 or EULUMDAT.
    maker, name : str
        Empty where the file does not say.
    planes : (p,) float64
        C in degrees, all round: rising from 0 to 360.
    angles : (a,) float64
        gamma in degrees, rising, in [0, 180]; 0 is nadir.
    candela : (p, a) float64
    stated : float or None
        lm that leave its lamps (LM-63) or itself (EULUMDAT) by what the file says.
    of_lamps : bool
        Which of both.
    opening : float
        Largest extent of the luminous opening in m, 0 for a point.
    notes : tuple of str
        What a user may want to know.
    """

    file: str
    format: str
    maker: str
    name: str
    planes: np.ndarray
    angles: np.ndarray
    candela: np.ndarray
    stated: float | None
    of_lamps: bool
    opening: float
    notes: tuple[str, ...] = ()

    @cached_property
    def distribution(self) -> tuple[Distribution, float]:
        """Return the shares of the peak, and the peak in cd."""
        return of_values(self.planes, self.angles, self.candela)

    @cached_property
    def flux(self) -> float:
        """Return the integral of the intensities over all directions in lm (E29)."""
        shares, peak = self.distribution
        return peak * shares.solid_angle

    @property
    def label(self) -> str:
        """Return where this comes from: file, format, maker, name, and how much its lamps lose."""
        said = ", ".join(word for word in (self.maker, self.name) if word)
        text = f"{self.file}, {self.format}" + (f": {said}" if said else "")
        if not self.of_lamps or self.stated is None:
            return text
        return f"{text} ({self.flux / self.stated:.0%} of the {self.stated:.6g} lm of its lamps)"

    def noting(self, *notes: str) -> "Photometric":
        """Return the same with more notes."""
        return replace(self, notes=(*self.notes, *notes))


class Words:
    """The numbers of a text from one of its lines on, taken in order.

    Parameters
    ----------
    lines : list of str
    start : int
        The first line to read, counted from 0.
    name : str
        Of the file, for messages.
    decimal : str
        ``,`` where commas stand for decimal points; otherwise they part numbers as spaces do.
    """

    def __init__(self, lines: list[str], start: int, name: str, decimal: str = "."):
        mark = "." if decimal == "," else " "
        split = [(k, w) for k, line in enumerate(lines[start:], start + 1)
                 for w in line.replace(",", mark).split()]  # fmt: skip
        self._line, self._word = [k for k, _ in split], [w for _, w in split]
        self._next, self._name, self._start = 0, name, start + 1

    @property
    def left(self) -> int:
        """Return how many words have not been taken."""
        return len(self._word) - self._next

    def line(self, back: int = 0) -> int:
        """Return in which line, counted from 1, the number stands that was taken so long ago."""
        return self._line[max(self._next - 1 - back, 0)] if self._line else self._start

    def wrong(self, text: str, line: int | None = None) -> SceneError:
        """Return the error that says what is wrong in a line, by default that of the last one."""
        return SceneError(self._name, [f"line {line or self.line()}: {text}"])

    def take(self, count: int, what: str) -> np.ndarray:
        """Return the next numbers (count,), which ``what`` names in messages.

        Raises
        ------
        SceneError
            Fewer are left, or one of them is none, or not finite.
        """
        if count > self.left:
            self._next = len(self._word)
            found = f"the file ends before {what}: {count} numbers must follow"
            raise self.wrong(found)
        words = self._word[self._next : self._next + count]
        for word in words:
            self._next += 1
            if not NUMBER.fullmatch(word) or abs(float(word)) > BRIGHTEST:
                raise self.wrong(f"{word[:20]!r} is no number that can be {what}")
        return np.array([float(word) for word in words])

    def one(self, what: str) -> float:
        """Return the next number."""
        return float(self.take(1, what)[0])

    def whole(self, what: str, low: int, high: int) -> int:
        """Return the next number, which must be whole and lie in [low, high]."""
        value = self.one(what)
        if value != int(value) or not low <= value <= high:
            raise self.wrong(f"{what} = {value:g} must be a whole number in [{low}, {high}]")
        return int(value)

    def positive(self, what: str) -> float:
        """Return the next number, which must be greater than 0."""
        value = self.one(what)
        if value <= 0.0:
            raise self.wrong(f"{what} = {value:g} must be greater than 0: no light would leave")
        return value

    def rising(self, count: int, what: str, low: float, high: float) -> np.ndarray:
        """Return the next numbers (count,), angles in degrees that rise from low to high."""
        values = self.take(count, what)
        steps = np.flatnonzero(np.diff(values) < STEP)
        if len(steps):
            k = steps[0]
            more = f"{values[k]:g} is followed by {values[k + 1]:g}"
            raise self.wrong(f"{what} must rise by {STEP:g} degrees at least: {more}")
        if values[0] < low or values[-1] > high + SAME:
            more = f"they run from {values[0]:g} to {values[-1]:g}"
            raise self.wrong(f"{what} must lie in [{low:g}, {high:g}] degrees: {more}")
        return np.minimum(values, high)

    def table(self, planes: int, angles: int, what: str, factor: float) -> np.ndarray:
        """Return factor times the next values (planes, angles): at least 0, and not all 0."""
        values = self.take(planes * angles, what)
        if np.any(values < 0.0):
            k = int(np.argmax(values < 0.0))
            where = f"value {k % angles + 1} of plane {k // angles + 1}"
            text = f"{what} = {values[k]:g} ({where}) must be at least 0"
            raise self.wrong(f"{text}: light cannot be taken away", self.line(len(values) - 1 - k))
        if not values.any():
            raise self.wrong(f"{what} are all 0: the luminaire sends out no light")
        found = factor * values.reshape(planes, angles)
        if not DIMMEST <= found.max() <= BRIGHTEST:
            bounds = f"[{DIMMEST:g}, {BRIGHTEST:g}]"
            raise self.wrong(f"the largest of {what} is {found.max():g} cd, must lie in {bounds}")
        return found


def text_lines(text: str, name: str) -> list[str]:
    """Return the lines of a file's text, without marks of its beginning and end.

    Raises
    ------
    SceneError
        Where it is longer than any photometric file.
    """
    if len(text) > LONGEST_TEXT:
        found = f"has {len(text)} characters, at most {LONGEST_TEXT} are read"
        raise SceneError(name, [f"{found}: is it a photometric file?"])
    plain = re.sub("[\ufeff\x1a\x00]", "", text)
    return plain.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def mirrored(planes: np.ndarray, values: np.ndarray, at: float):
    """Return planes (p,) in degrees and values (p, a) with their mirror image beyond ``at``."""
    return (
        np.concatenate([planes, 2.0 * at - planes[-2::-1]]),
        np.concatenate([values, values[-2::-1]]),
    )


def all_round(planes: np.ndarray, values: np.ndarray):
    """Return planes in degrees from 0 to 360 and their values, of planes once round from anywhere.

    The plane 360 is the plane 0; where there is neither it is interpolated (E28).
    """
    turned = np.mod(planes, 360.0)
    turned[turned > 360.0 - SAME] = 0.0
    turned, first = np.unique(turned, return_index=True)
    values = values[first]
    if turned[0] > 0.0:
        gap = turned[0] - turned[-1] + 360.0
        zero = (values[0] * (360.0 - turned[-1]) + values[-1] * turned[0]) / gap
        turned, values = np.append(0.0, turned), np.vstack([zero, values])
    return np.append(turned, 360.0), np.vstack([values, values[:1]])


def by_range(planes: np.ndarray, values: np.ndarray, refuse: Callable[[str], SceneError]):
    """Return planes and values all round, of planes whose range tells the symmetry (LM-63).

    One plane stands for all; 0 to 90 for four quarters, 0 to 180 and 90 to 270 for two halves.

    Raises
    ------
    SceneError
        What ``refuse`` returns for any other range.
    """
    first, last = planes[0], planes[-1]
    ends = tuple(round(float(v) / SAME) * SAME for v in (first, last))
    if len(planes) == 1:
        return np.array([0.0, 360.0]), np.repeat(values, 2, axis=0)
    if ends == (0.0, 90.0):
        return mirrored(*mirrored(planes, values, 90.0), 180.0)
    if ends == (0.0, 180.0):
        return mirrored(planes, values, 180.0)
    if ends == (90.0, 270.0):
        return all_round(*mirrored(planes, values, 270.0))
    if ends == (0.0, 360.0):
        return planes, values
    if ends[0] == 0.0 and 180.0 < ends[1] < 360.0:
        return all_round(planes, values)
    raise refuse(
        f"the C-planes run from {first:g} to {last:g} degrees, and must be one, or run from 0 to "
        "90, 180 or 360, or from 90 to 270"
    )
