"""Spectra of a scene file: CSV files of wavelength and value, and the tables that name them."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from pydantic import BaseModel

from radiosity.light.spectrum import Spectrum, nanometres
from radiosity.scene.checks import Number, SpectrumFile, Wrong
from radiosity.scene.model import SceneError
from radiosity.scene.schema import at

MOST = 10  # problems of one file that are told
Model = TypeVar("Model", bound=BaseModel)


def read_spectrum(text: str, name: str, check: Number) -> Spectrum:
    """Return the spectrum of a CSV text: lines of a wavelength in nm and a value.

    A first line of words, empty lines and what follows a ``#`` are left out.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    check : Number
        What its values have to be.

    Raises
    ------
    SceneError
        With one problem for each line that is wrong, at most MOST of them.
    """
    rows, problems = [], []
    lines = [line.partition("#")[0].strip() for line in text.splitlines()]
    filled = [(number, line) for number, line in enumerate(lines, 1) if line]
    if filled and _is_heading(filled[0][1].split(",")[0]):
        filled = filled[1:]
    for number, line in filled:
        try:
            rows.append(_row(line, check, rows[-1][0] if rows else 0.0))
        except ValueError as error:
            problems.append(f"line {number}: {error}")
    if not problems:
        problems = _whole_problems(rows)
    if problems:
        more = len(problems) - MOST
        told = [f"and {more} more lines like these"] if more > 0 else []
        raise SceneError(name, problems[:MOST] + told)
    nm, values = np.array(rows).T
    return Spectrum(nm, values, name)


def _is_heading(word) -> bool:
    """Whether a word stands over a column: no number, and no slip in one, as 38O."""
    return not _is_number(word) and not any(letter.isdigit() for letter in word)


def _is_number(word) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _row(line, check, before) -> tuple[float, float]:
    """Return wavelength and value of a line; ValueError says what is wrong with it."""
    words = [word.strip() for word in line.split(",")]
    if len(words) != 2 or not all(map(_is_number, words)):
        raise ValueError(f"{line[:40]!r} must be a wavelength in nm and a value: 550, 0.7")
    nm, value = map(float, words)
    if not before < nm < np.inf:
        raise ValueError(f"{nm:g} nm must be greater than the {before:g} nm before: sort the lines")
    try:
        return nm, check(value)
    except Wrong as error:
        percent = check.high == 1.0 and 1.0 < value <= 100.0
        hint = "; divide percents by 100" if percent else ""
        raise ValueError(f"value = {value:g} {error.found[0][2]}{hint}") from None


def _whole_problems(rows) -> list[str]:
    first, last = nanometres()[[0, -1]]
    if len(rows) < 2:
        return [f"has {len(rows)} lines of values, at least 2 are needed: nm, value"]
    if rows[-1][0] <= first or rows[0][0] >= last:
        return [
            f"runs from {rows[0][0]:g} to {rows[-1][0]:g} nm, but must have a part in "
            f"[{first:g}, {last:g}]: is it in micrometres?"
        ]
    return []


def resolved(
    table: Model, path: tuple, read_text: Callable[[str], str], problems: list[str]
) -> Model:
    """Return a checked table with its spectra read; what is wrong with them becomes problems."""
    found = {}
    for key in type(table).model_fields:
        value = getattr(table, key)
        if isinstance(value, BaseModel):
            found[key] = resolved(value, (*path, key), read_text, problems)
        elif isinstance(value, SpectrumFile):
            try:
                found[key] = read_spectrum(read_text(value.name), value.name, value.check)
            except SceneError as error:
                problems += [at((*path, key), value.name, p) for p in error.problems]
    return table.model_copy(update=found) if found else table
