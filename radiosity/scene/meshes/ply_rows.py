"""Rows of a PLY file: tables of numbers and of lists of them, as text or as bytes."""

import struct
from dataclasses import dataclass

import numpy as np

from radiosity.mesh.faces import ranges

CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
CHUNK = 1 << 20  # numbers taken at once


class Broken(ValueError):
    """What is wrong with the file, as a sentence without a subject."""


@dataclass(frozen=True)
class Property:
    """A number of each row, or with ``counted``, the type of their count, a list of them."""

    name: str
    type: str
    counted: str | None = None


@dataclass(frozen=True)
class Element:
    """So many rows of the same properties, one after the other."""

    name: str
    count: int
    properties: tuple[Property, ...]


@dataclass(frozen=True)
class Text:
    """The numbers after the header of a text file; positions count words."""

    words: np.ndarray

    def __len__(self) -> int:
        return len(self.words)

    def size(self, kind: str) -> int:
        """Return how many places a number of a type takes."""
        return 1

    def one(self, kind: str, position: int) -> float:
        """Return the number of a type at a place."""
        return self.words[position]

    def at(self, kind: str, positions: np.ndarray) -> np.ndarray:
        """Return (m,) the numbers of a type at places (m,)."""
        return self.words[positions]


@dataclass(frozen=True)
class Binary:
    """The bytes after the header of a binary file; positions count them."""

    data: memoryview
    order: str

    def __len__(self) -> int:
        return len(self.data)

    def size(self, kind: str) -> int:
        """Return how many places a number of a type takes."""
        return int(kind[1])

    def one(self, kind: str, position: int) -> float:
        """Return the number of a type at a place."""
        return struct.unpack_from(self.order + CODES[kind], self.data, position)[0]

    def at(self, kind: str, positions: np.ndarray) -> np.ndarray:
        """Return (m,) the numbers of a type at places (m,)."""
        data, step = np.frombuffer(self.data, np.uint8), np.arange(self.size(kind))
        found = np.empty(len(positions))
        for k in range(0, len(found), CHUNK):  # so that the bytes' places take little memory
            taken = data[positions[k : k + CHUNK, None] + step]
            found[k : k + CHUNK] = taken.view(self.order + kind)[:, 0]
        return found


def columns_of(elements, body):
    """Return the values of vertices and faces by element and property, and read no further.

    Numbers are (count,), lists (values, lengths (count,)).
    """
    columns, start = {}, 0
    for e in elements:
        places, end = _layout(e, body, start)
        if end > len(body):
            raise Broken(
                f"ends within its {e.count} {e.name}: it has {len(body)} "
                f"{'words' if isinstance(body, Text) else 'bytes'} after the header, and "
                f"{end} are needed up to there"
            )
        if e.name in ("vertex", "face"):
            columns[e.name] = _values(e, body, places)
        if columns.keys() >= {"vertex", "face"}:
            break
        start = end
    return columns


def _values(element, body, places):
    found = {}
    for p, (position, length) in zip(element.properties, places, strict=True):
        if p.counted:
            step = body.size(p.type)
            k, owner = ranges(np.zeros(len(length), int), length)
            found[p.name] = body.at(p.type, position[owner] + k * step), length
        else:
            found[p.name] = body.at(p.type, position)
    return found


def _layout(element, body, start):
    """Return where each property's numbers start (count,), the lists' lengths, and the end."""
    lengths, stride = [], 0
    if not element.properties:  # then any count of them takes no place
        return [], start
    for p in element.properties:  # as if all rows were as long as the first one
        length = 1
        if p.counted:
            length = _length(p, body, start + stride, 0) if element.count else 0
            stride += body.size(p.counted)
        lengths.append(length)
        stride += length * body.size(p.type)
    end = start + element.count * stride
    if end > len(body):
        return _walked(element, body, start)
    rows, places = start + np.arange(element.count) * stride, []
    for p, length in zip(element.properties, lengths, strict=True):
        if p.counted:
            if np.any(body.at(p.counted, rows) != length):
                return _walked(element, body, start)
            rows = rows + body.size(p.counted)
        places.append((rows, np.full(element.count, length)))
        rows = rows + length * body.size(p.type)
    return places, end


def _walked(element, body, position):
    """Return the layout of rows that differ in length, row by row."""
    starts = [[] for _ in element.properties]
    lengths = [[] for _ in element.properties]
    sizes = [(p, body.size(p.counted) if p.counted else 0, body.size(p.type))
             for p in element.properties]  # fmt: skip
    for row in range(element.count):
        for k, (p, head, size) in enumerate(sizes):
            length = _length(p, body, position, row) if head else 1
            position += head
            starts[k].append(position)
            lengths[k].append(length)
            position += length * size
        if position > len(body):
            raise Broken(f"ends within {element.name} {row} of {element.count}: it was cut off")
    return [(np.array(s, int), np.array(n, int)) for s, n in zip(starts, lengths, strict=True)], (
        position
    )


def _length(p, body, position, row):
    """Return how long the list at a position is."""
    if position + body.size(p.counted) > len(body):
        raise Broken(f"ends before list {p.name} of row {row}: it was cut off")
    length = body.one(p.counted, position)
    if not 0 <= length == length // 1 or length > len(body):
        raise Broken(f"gives list {p.name} of row {row} the length {length:g}, more than there is")
    return int(length)


