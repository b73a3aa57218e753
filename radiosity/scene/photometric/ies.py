"""Photometric files of the IES: LM-63 of 1986, 1991, 1995, 2002 and 2019.

Label lines, the line TILT, and then nothing but numbers: how many lamps, angles and planes,
factors, the angles, and the intensities of one C-plane after the other. ANSI/IES LM-63-19.
"""

import re
from functools import partial

from radiosity.scene.model import SceneError
from radiosity.scene.photometric.photometric import (
    CLOSE,
    MOST_VALUES,
    Photometric,
    Words,
    by_range,
    text_lines,
)

METRES = {1: 0.3048, 2: 1.0}  # by the number that stands for feet and metres
PHOTOMETRY = {1: "C", 2: "B", 3: "A"}
MOST_ANGLES, MOST_LAMPS = 1 << 16, 1 << 20
LEAST = 0.1  # of the lamps' flux, below which the rest of a file is questioned
WITHOUT_FACTOR = 1995  # from which on a second factor is no factor any more


def read_ies(text: str, name: str) -> Photometric:
    """Return what the text of an LM-63 file says; ``name`` is the file's, for messages.

    candela = value * multiplier * ballast factor (* ballast-lamp factor, before 1995).

    Raises
    ------
    SceneError
        What is no LM-63 file, breaks off, or is of type A or B.

    Examples
    --------
    >>> numbers = "1 1000 2 3 1 1 2 0 0 0", "1 1 10", "0 45 90", "0", "100 50 0"
    >>> found = read_ies(chr(10).join(["TILT=NONE", *numbers]), "x.ies")
    >>> found.candela[0].tolist(), found.stated
    ([200.0, 100.0, 0.0], 1000.0)
    """
    lines = text_lines(text, name)
    year, tilt = _year(lines[0]), _tilt_line(lines, name)
    labels = _labels(lines[:tilt])
    words = Words(lines, tilt + 1, name)
    notes = _tilt_notes(lines[tilt].partition("=")[2].strip(), words)
    lamps = words.whole("the number of lamps", 0, MOST_LAMPS)
    lumens, multiplier = words.one("the lumens a lamp"), words.positive("the multiplier")
    a = words.whole("the number of angles gamma", 2, MOST_ANGLES)
    p = words.whole("the number of C-planes", 1, MOST_ANGLES)
    if a * p > MOST_VALUES:
        raise words.wrong(f"{p} planes of {a} angles are more than {MOST_VALUES} values")
    _check_type(words)
    metres = METRES[words.whole("the unit of lengths (1 feet, 2 metres)", 1, 2)]
    opening = metres * float(abs(words.take(3, "width, length and height")).max())
    factor = words.positive("the ballast factor")
    second = words.one("the number after the ballast factor")
    words.one("the power in W")
    if year < WITHOUT_FACTOR and second > 0.0:
        factor *= second
    elif second != 1.0 and year < 2019:
        notes.append(f"the number {second:g} after the ballast factor has no meaning, and is left")
    angles = words.rising(a, "the angles gamma", 0.0, 180.0)
    planes = words.rising(p, "the C-planes", 0.0, 360.0)
    refuse = partial(words.wrong, line=words.line())
    values = words.table(p, a, "intensities", multiplier * factor)
    planes, values = by_range(planes, values, refuse)
    if words.left:
        notes.append(f"{words.left} words after the last intensity are not read")
    found = Photometric(
        name, f"LM-63-{year}", _label(labels, "MANUFAC"), _label(labels, "LUMCAT", "LUMINAIRE", ""),
        planes, angles, values,
        lamps * lumens * factor if lumens > 0.0 and lamps else None, True, opening,
        tuple(notes),
    )  # fmt: skip
    return found.noting(*_flux_notes(found))


def _year(line) -> int:
    """Return the year of the standard that the first line names; without one it is the first."""
    found = re.match(r"\s*IES(?:NA)?:?\s*(?:LM-63-)?(\d{4}|\d{2})\b", line, re.I)
    if not found:
        return 1986
    year = int(found[1])
    return year if year > 99 else year + (1900 if year > 50 else 2000)


def _tilt_line(lines, name) -> int:
    for k, line in enumerate(lines):
        if re.match(r"\s*TILT\s*=", line, re.I):
            return k
    raise SceneError(
        name, ["has no line TILT=, after which LM-63 files have their numbers: is it one?"]
    )


def _check_type(words):
    kind = PHOTOMETRY[words.whole("the type (1 is C, 2 is B, 3 is A)", 1, 3)]
    if kind != "C":
        raise words.wrong(
            f"is of type {kind}, whose axis is horizontal; only type C is read: ask the maker for "
            "it, or convert the file"
        )


def _tilt_notes(tilt, words) -> list[str]:
    """Return what is noted of factors for lamps that are tilted; reads those in the file."""
    if tilt.upper() == "NONE":
        return []
    if tilt.upper() != "INCLUDE":
        return [f"factors for a tilted lamp, in the file {tilt[:40]!r}, are not read"]
    words.whole("how the lamp lies (1, 2 or 3)", 1, 3)
    count = words.whole("the number of tilt angles", 1, MOST_ANGLES)
    words.take(count, "the tilt angles")
    factors = words.take(count, "the factors of the tilt angles")
    if (factors == 1.0).all():
        return []
    return [
        f"factors for a tilted lamp, from {factors.min():g} to {factors.max():g}, are not applied: "
        "luminous_flux of the scene can be lowered by them"
    ]


def _labels(lines) -> dict[str, str]:
    """Return the first text of each keyword; "" names the first line that is no heading."""
    found = {}
    for k, line in enumerate(lines):
        keyword = re.match(r"\s*\[(\w+)[\]=]\s*(.*?)\]?\s*$", line)
        if keyword and keyword[2]:
            found.setdefault(keyword[1].upper(), " ".join(keyword[2].split()))
        elif not keyword and line.strip() and (k > 0 or not line.upper().startswith("IES")):
            found.setdefault("", " ".join(line.split()))
    return found


def _label(labels, *keys) -> str:
    return next((labels[key][:60] for key in keys if labels.get(key)), "")


def _flux_notes(found):
    """Yield what is noted where the lamps' flux is unlikely, for that of the luminaire.

    That luminaires keep some of it is what `Photometric.label` says.
    """
    if found.stated is None:
        return
    share = found.flux / found.stated
    both = f"sends out {found.flux:.6g} lm of the {found.stated:.6g} lm of its lamps"
    if share > 1.0 + CLOSE:
        yield f"{both}, {share:.0%}: more than all; is a factor wrong?"
    elif share < LEAST:
        yield f"{both}, {share:.1%}: hardly any; is a factor wrong?"
