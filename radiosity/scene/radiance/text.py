"""The text of Radiance scene descriptions: primitives and commands, nothing understood yet."""

import re
import shlex
from dataclasses import dataclass

from radiosity.scene.names import nearest

SURFACES = (
    "source", "sphere", "bubble", "polygon", "cone", "cup", "cylinder", "tube", "ring", "instance",
    "mesh",
)  # fmt: skip
MATERIALS = (
    "plastic", "metal", "trans", "plastic2", "metal2", "trans2", "ashik2", "light", "illum", "glow",
    "spotlight", "mirror", "dielectric", "interface", "glass", "prism1", "prism2", "mist",
    "antimatter", "plasfunc", "metfunc", "transfunc", "plasdata", "metdata", "transdata",
    "BRTDfunc", "WGMDfunc", "BSDF", "aBSDF",
)  # fmt: skip
MODIFIERS = (
    "texfunc", "texdata", "colorfunc", "brightfunc", "colordata", "brightdata", "colorpict",
    "colortext", "brighttext", "mixfunc", "mixdata", "mixpict", "mixtext", "spectrum", "specfile",
    "specfunc", "specdata", "specpict",
)  # fmt: skip
TYPES = (*SURFACES, *MATERIALS, *MODIFIERS)
WORD = re.compile(r"\"[^\"]*\"|'[^']*'|\S+")
COMMENT = re.compile(r"(?:^|(?<=\s))#.*")
UNSAFE = re.compile(r"[<>;&$`*?()\[\]{}~]")  # what a shell would have to understand


@dataclass(frozen=True)
class Primitive:
    """One surface, material or pattern: ``modifier kind name`` and its arguments.

    An alias has the kind ``alias`` and what it stands for as its only string.
    """

    line: int
    modifier: str
    kind: str
    name: str
    strings: tuple[str, ...] = ()
    reals: tuple[float, ...] = ()


@dataclass(frozen=True)
class Command:
    """A line that starts with ``!``: words of piped programs, None if a shell is needed."""

    line: int
    text: str
    pipes: tuple[tuple[str, ...], ...] | None


class RadError(ValueError):
    """What is wrong with the text, with its line."""


def parsed(text: str) -> list[Primitive | Command]:
    r"""Return what a scene description lists, in order.

    Raises
    ------
    RadError
        Counts that are wrong, numbers that are none, types that do not exist. After the first of
        them nothing can be relied on.

    Examples
    --------
    >>> parsed("void light lamp\n0\n0\n3 1 1 1")[0].reals
    (1.0, 1.0, 1.0)
    """
    commands, words = _words(text)
    found, reader = list(commands), _Reader(words)
    while reader.left:
        found.append(reader.primitive())
    return sorted(found, key=lambda said: said.line)


def _words(text):
    """Return the commands, and the words (line, word) of everything else."""
    commands, words, command, start = [], [], None, 0
    for number, line in enumerate(text.split("\n"), 1):
        if command is None and line.lstrip().startswith("!"):
            command, start = "", number
        if command is not None:
            command += " " + line.rstrip("\\")
            if not line.endswith("\\"):
                commands.append(_command(start, command))
                command = None
            continue
        if "#" in line:
            line = COMMENT.sub("", line)
        if '"' in line or "'" in line:
            words += [(number, word.strip("\"'")) for word in WORD.findall(line)]
        else:
            words += [(number, word) for word in line.split()]
    if command is not None:
        commands.append(_command(start, command))
    return commands, words


def _command(line, text):
    text = text.strip().removeprefix("!").strip()
    if UNSAFE.search(text):
        return Command(line, text, None)
    try:
        words = shlex.split(text, comments=True)
    except ValueError:
        return Command(line, text, None)
    pipes = [[]]
    for word in words:
        if word == "|":
            pipes.append([])
        else:
            pipes[-1].append(word)
    return Command(line, text, tuple(map(tuple, pipes)) if all(pipes) else None)


class _Reader:
    """Takes primitives from a list of words; ``at`` is the next one."""

    def __init__(self, words):
        self.words, self.at = words, 0

    @property
    def left(self):
        return len(self.words) - self.at

    def primitive(self):
        """Return the next primitive."""
        line = self.words[self.at][0]
        modifier, kind, name = (self._next(what, line) for what in ("", "a type", "a name"))
        if kind == "alias":
            return Primitive(line, modifier, kind, name, (self._next("what it stands for", line),))
        if kind not in TYPES:
            like = nearest(kind, TYPES)
            raise RadError(f"line {line}: {modifier} {kind} {name}: {kind} is no type of Radiance: "
                           f"{like if 'did' in like else 'see its manual'}")  # fmt: skip
        whose = f"{kind} {name}"
        strings = self._arguments("strings", line, whose)
        self._arguments("whole numbers", line, whose)
        reals = _reals(self._arguments("numbers", line, whose), line, whose)
        return Primitive(line, modifier, kind, name, strings, reals)

    def _next(self, what, line):
        if not self.left:
            raise RadError(f"line {line}: the file ends where {what} should follow")
        self.at += 1
        return self.words[self.at - 1][1]

    def _arguments(self, what, line, whose):
        """Return the words that a count announces."""
        text = self._next(f"how many {what} {whose} has", line)
        if not text.isdecimal() or not text.isascii() or len(text) > 9:
            raise RadError(
                f"line {self.words[self.at - 1][0]}: {whose}: {text} must be a whole number: how "
                f"many {what} follow"
            )
        count = int(text)
        if count > self.left:
            raise RadError(
                f"line {line}: {whose} should have {count} {what}, {self.left} words are left"
            )
        self.at += count
        return tuple(word for _, word in self.words[self.at - count : self.at])


def _reals(words, line, whose):
    try:
        numbers = tuple(map(float, words))
    except ValueError:
        numbers = None
    if numbers is None or not all(abs(x) <= 1e30 for x in numbers):  # false for nan
        wrong = next(w for w in words if not _is_real(w))
        raise RadError(f"line {line}: {whose}: {wrong} must be a finite number, at most 1e+30")
    return numbers


def _is_real(word):
    try:
        return abs(float(word)) <= 1e30
    except ValueError:
        return False
