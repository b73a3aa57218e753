"""Photometric files in the format EULUMDAT, ``.ldt``.

One value a line: twelve lines of text and counts, dimensions in mm, shares and factors, the sets of
lamps, ten direct ratios, the angles, and the intensities in cd per 1000 lm of the lamps, of the
C-planes that do not follow by symmetry. Stockmar (1990), "EULUMDAT - ein Leuchtendatenformat fuer
den europaeischen Beleuchtungsplaner".
"""

import numpy as np

from radiosity.scene.model import SceneError
from radiosity.scene.photometric.photometric import (
    CLOSE,
    MOST_VALUES,
    SAME,
    Photometric,
    Words,
    all_round,
    mirrored,
    text_lines,
)

NUMBERS, SETS = 12, 26  # lines after which there are numbers, and sets of lamps
MOST_PLANES, MOST_ANGLES, MOST_SETS = 721, 3601, 20
RATIOS, LINES_OF_SET = 10, 6
KILO = 1000.0  # lm that intensities are given for
SYMMETRIES = {
    0: "no", 1: "about the axis", 2: "about C0-C180", 3: "about C90-C270", 4: "about both",
}  # fmt: skip


def read_eulumdat(text: str, name: str) -> Photometric:
    """Return what the text of an EULUMDAT file says; ``name`` is the file's, for messages.

    candela = value * conversion factor * flux of the first set of lamps / 1000 lm.

    Raises
    ------
    SceneError
        What is no EULUMDAT file or breaks off.
    """
    lines = text_lines(text, name)
    if len(lines) <= SETS:
        found = f"has {len(lines)} lines, an EULUMDAT file more than {SETS}: is it one?"
        raise SceneError(name, [found])

    def line(number):
        """Return the number that stands in a line, counted from 1; commas may be its point."""
        return Words([""] * (number - 1) + [lines[number - 1]], number - 1, name, ",")

    symmetry = line(3).whole("the symmetry Isym", 0, 4)
    p = line(4).whole("the number of C-planes Mc", 1, MOST_PLANES)
    a = line(6).whole("the number of angles Ng", 2, MOST_ANGLES)
    opening = [line(k).one("the size of the luminous opening in mm") for k in range(16, 22)]
    lorl = line(23).one("the light output ratio LORL in %")
    factor = line(24).positive("the conversion factor of intensities")
    tilt = line(25).one("the tilt when measured, in degrees")
    lamp, absolute, after, notes = _lamps(lines, line)
    if tilt:
        notes.append(f"was measured with a tilt of {tilt:g} degrees, which target has to repeat")
    words = Words(lines, after, name, ",")
    words.take(RATIOS, "the direct ratios")
    planes = words.rising(p, "the C-planes", 0.0, 360.0)
    rows = _listed(planes, symmetry, words)
    angles = words.rising(a, "the angles gamma", 0.0, 180.0)
    if len(rows) * a > MOST_VALUES:
        raise words.wrong(f"{len(rows)} planes of {a} angles are more than {MOST_VALUES} values")
    values = words.table(len(rows), a, "intensities", factor * lamp / KILO)
    if words.left:
        notes.append(f"{words.left} words after the last intensity are not read")
    whole, values = _whole(planes[rows], values, symmetry)
    found = Photometric(
        name, "EULUMDAT", _text(lines[0]), _text(lines[8]), whole, angles, values,
        lamp if absolute else lamp * lorl / 100.0, False, float(np.abs(opening).max()) / 1000.0,
        tuple(notes),
    )  # fmt: skip
    return found.noting(*_flux_notes(found, lamp, lorl))


def _text(line) -> str:
    return " ".join(line.replace('"', " ").split())[:60]


def _lamps(lines, line):
    """Return the lamps' flux in lm, whether it is the luminaire's, what follows, and notes.

    A negative number of lamps says that the flux was measured with the luminaire.
    """
    sets = line(SETS).whole("the number of sets of lamps", 0, MOST_SETS)
    after = SETS + LINES_OF_SET * sets
    if after > len(lines):
        raise line(SETS).wrong(f"{sets} sets of lamps do not fit into the {len(lines)} lines")
    flux = line(SETS + 3).one("the flux of the lamps in lm") if sets else 0.0
    absolute = bool(sets) and line(SETS + 1).one("the number of lamps") < 0.0
    notes = []
    if sets > 1:
        notes.append(f"has {sets} sets of lamps: the first one, of {flux:g} lm, is taken")
    if flux <= 0.0:
        flux = KILO
        notes.append(
            f"names no flux of its lamps: {KILO:g} lm are taken; luminous_flux of the scene can "
            "give another"
        )
    return flux, absolute, after, notes


def _listed(planes, symmetry, words) -> np.ndarray:
    """Return which planes have intensities in the file, in their order."""
    first, last = {
        0: (0.0, 360.0), 1: (0.0, 0.0), 2: (0.0, 180.0), 3: (270.0, 450.0), 4: (0.0, 90.0),
    }[symmetry]  # fmt: skip
    if symmetry == 1:
        return np.zeros(1, int)
    around = np.concatenate([planes, planes + 360.0])
    inside = np.flatnonzero((around >= first - SAME) & (around <= last + SAME))
    inside = inside[inside < len(planes)] if symmetry == 0 else inside
    ends = around[inside[[0, -1]]] if len(inside) else np.zeros(2)
    if symmetry and np.abs(ends - (first, last)).max() > SAME:
        raise words.wrong(
            f"symmetry {symmetry} ({SYMMETRIES[symmetry]}) needs C-planes at {first:g} and "
            f"{last % 360.0:g} degrees, and the file has none there"
        )
    return inside % len(planes)


def _whole(planes, values, symmetry):
    """Return planes all round and the values of all of them."""
    if symmetry == 1:
        return np.array([0.0, 360.0]), np.repeat(values, 2, axis=0)
    if symmetry == 2:
        planes, values = mirrored(planes, values, 180.0)
    elif symmetry == 3:
        turned = np.where(planes > 180.0, planes - 360.0, planes)
        planes, values = mirrored(turned, values, 90.0)
    elif symmetry == 4:
        planes, values = mirrored(*mirrored(planes, values, 90.0), 180.0)
    return all_round(planes, values)


def _flux_notes(found, lamp, lorl):
    """Yield what is noted where intensities and the stated flux do not agree."""
    if abs(found.flux - found.stated) > CLOSE * found.stated:
        yield (
            f"intensities add up to {found.flux:.6g} lm, and {found.stated:.6g} lm are stated "
            f"({lamp:g} lm of lamps, light output ratio {lorl:g} %)"
        )
