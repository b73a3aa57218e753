"""MTL: what the material libraries of OBJ files say, statement by statement.

`radiosity.scene.wavefront.tables` makes materials of it; docs/files.md has the table.
"""

from dataclasses import dataclass, field

import numpy as np

from radiosity.scene.checks import RECEIVES

COLOURS = "Kd", "Ks", "Ke", "Tf"
NUMBERS = {  # least, most, what the bounds mean
    "Ns": (0.0, np.inf, "it is the exponent of a highlight"),
    "Ni": (0.0, 100.0, "vacuum has 1, glass 1.5"),
    "d": (0.0, 1.0, "1 is opaque"),
    "Tr": (0.0, 1.0, "0 is opaque"),
    "Pr": (0.0, 1.0, "0 is a mirror, 1 is dull"),
    "Pm": (0.0, 1.0, "0 is no metal, 1 is one"),
    "illum": (0.0, 10.0, "illumination models are counted from 0 to 10"),
}
MAPS = "map_Kd", "map_Ke"
AMBIENT = "Ka", "map_Ka"  # light that is solved for here
OPTIONS = {  # of textures, with the least and the most numbers that follow
    "-o": (1, 3), "-s": (1, 3), "-t": (1, 3), "-mm": (2, 2), "-bm": (1, 1), "-boost": (1, 1),
    "-texres": (1, 2), "-clamp": (1, 1), "-blendu": (1, 1), "-blendv": (1, 1), "-cc": (1, 1),
    "-imfchan": (1, 1), "-type": (1, 1), "-colorspace": (1, 1),
}  # fmt: skip
HANDLED = "-o", "-s", "-clamp"


@dataclass(frozen=True)
class Map:
    """A picture that a library names, and how it lies: (u, v) becomes scale (u, v) + offset."""

    name: str
    offset: tuple[float, float] = (0.0, 0.0)
    scale: tuple[float, float] = (1.0, 1.0)
    clamp: bool = False
    ignored: tuple[str, ...] = ()

    @property
    def placed(self) -> bool:
        """Whether it is shifted or scaled."""
        return self.offset != (0.0, 0.0) or self.scale != (1.0, 1.0)


@dataclass
class Statements:
    """What a library says of one material.

    ``colours`` (3,) and ``numbers`` by keyword, ``maps`` by keyword, ``lines`` as they stand,
    ``others`` the keywords that are not read; ``blender`` tells who wrote it.
    """

    colours: dict[str, np.ndarray] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    maps: dict[str, Map] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)
    others: dict[str, None] = field(default_factory=dict)
    blender: bool = False

    def colour(self, key: str, default: float = 0.0) -> np.ndarray:
        """Return a colour (3,), or the default where it is not given."""
        return self.colours.get(key, np.full(3, default))


def read_mtl(text: str) -> tuple[dict[str, Statements], list[str]]:
    r"""Return what an MTL file says of its materials by name, and its problems.

    Examples
    --------
    >>> said, problems = read_mtl("newmtl wall\nKd 0.5 0.4 0.3\nKs 2 x 1")
    >>> said["wall"].colours["Kd"].tolist()
    [0.5, 0.4, 0.3]
    >>> problems
    ['line 3: Ks 2 x 1 must be one or three finite numbers (spectral and xyz forms are not read)']
    """
    found, problems, name = {}, [], None
    blender = "blender" in text[:200].lower()
    for number, line in enumerate(text.split("\n"), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        if words[0] == "newmtl":
            name = "".join(line.strip().split(None, 1)[1:])
            found[name] = Statements(blender=blender)
            continue
        problem = _add(words, line, found.get(name))
        if problem:
            problems.append(f"line {number}: {problem}")
    return found, problems


def _add(words, line, said):
    """Add one statement to a material's; return what is wrong with it, or None."""
    key, stated = words[0], " ".join(words)
    known = key in COLOURS or key in NUMBERS or key in MAPS
    if said is None:
        text = "comes before the first newmtl: name the material it belongs to"
        return f"{stated} {text}" if known else None
    if key in COLOURS:
        problem = _add_colour(key, words, stated, said)
    elif key in NUMBERS and words[1:2] != ["-halo"]:
        problem = _add_number(key, words, stated, said)
    elif key in MAPS:
        problem = _add_map(key, words, stated, said)
    else:
        if key not in AMBIENT:
            said.others[key] = None
        return None
    if problem is None:
        said.lines.append(stated)
    return problem


def _add_colour(key, words, stated, said):
    rgb = finite(words[1:] * (3 if len(words) == 2 else 1), 3)
    if rgb is None:
        return f"{stated} must be one or three finite numbers (spectral and xyz forms are not read)"
    if min(rgb) < 0:
        return f"{stated} must not be negative"
    if key == "Kd" and max(rgb) > 1:
        return f"{stated} must lie in [0, 1]: {RECEIVES}"
    said.colours[key] = np.array(rgb)
    return None


def _add_number(key, words, stated, said):
    value = finite(words[1:2], 1)
    if value is None:
        return f"{stated} must be a finite number"
    low, high, why = NUMBERS[key]
    if not low <= value[0] <= high:
        bound = f"lie in [{low:g}, {high:g}]" if np.isfinite(high) else f"be at least {low:g}"
        return f"{stated} must {bound}: {why}"
    said.numbers[key] = value[0]
    return None


def _add_map(key, words, stated, said):
    """Read the options and the name, which may hold blanks, of a texture."""
    words, kept = list(words[1:]), {"ignored": []}
    while words and words[0] in OPTIONS:
        option, values = words.pop(0), []
        least, most = OPTIONS[option]
        while words and len(values) < most and (
            len(values) < least or finite(words[:1], 1) is not None
        ):  # fmt: skip
            values.append(words.pop(0))
        problem = _option(option, values, kept)
        if problem:
            return f"{stated}: {problem}"
    if not words:
        return f"{stated} names no picture"
    name = " ".join(words).replace("\\", "/")
    said.maps[key] = Map(name, **kept | {"ignored": tuple(kept["ignored"])})
    return None


def _option(option, values, kept):
    """Add what an option of a texture says to ``kept``; return what is wrong with it, or None."""
    if option not in HANDLED:
        kept["ignored"].append(option)
        return None
    if option == "-clamp":
        kept["clamp"] = values == ["on"]
        return None
    numbers = finite(values, len(values))
    if not numbers or max(map(abs, numbers)) > 1e6:
        return f"{option} {' '.join(values)} must be one to three numbers, at most 1e+06"
    fill = 0.0 if option == "-o" else 1.0
    kept["offset" if option == "-o" else "scale"] = tuple((*numbers, fill)[:2])
    return None


def finite(words: list[str], count: int) -> list[float] | None:
    """Return words as finite floats, None if there are not exactly ``count`` or they are not."""
    try:
        numbers = [float(w) for w in words]
    except ValueError:
        return None
    return numbers if len(numbers) == count and np.isfinite(numbers).all() else None
