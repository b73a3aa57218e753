"""Radiance's view files as cameras."""

import numpy as np

NUMBERS = {"-vp": 3, "-vd": 3, "-vu": 3, "-vh": 1, "-vv": 1}
UNREAD = {("-vs", "-vl"): "shifted or lifted", ("-vo", "-va"): "clipped in front or behind"}
IGNORED = {"-vo": 1, "-va": 1, "-vs": 1, "-vl": 1}
WIDTH = 512  # pixels of the longer side
MOST = 100  # views of one file


def read_views(text: str) -> tuple[dict[str, dict], list[str]]:
    """Return the tables ``[cameras.NAME]`` of a view file, and notes on those that are left out.

    Examples
    --------
    >>> cameras, _ = read_views("rvu -vtv -vp 1 2 3 -vd 0 5 0 -vu 0 0 1 -vh 60 -vv 40")
    >>> cameras["view"]["target"], cameras["view"]["fov"]
    ([1.0, 7.0, 3.0], 40.0)
    """
    lines = [line for line in text.split("\n")[:10_000] if "-v" in line and line.strip()[:1] != "#"]
    cameras, wrong = {}, 0
    for line in lines[:MOST]:
        table = _camera(line.split())
        name = "view" if not cameras else f"view-{len(cameras) + 1}"
        if table is None:
            wrong += 1
        else:
            cameras[name] = table
    notes = [f"{wrong} views of the .vf file are neither pinhole nor parallel"] if wrong else []
    if len(lines) > MOST:
        notes.append(f"of {len(lines)} views of the .vf file {MOST} are read")
    for keys, what in UNREAD.items():
        count = sum(_says(line, keys) for line in lines[:MOST])
        if count:
            notes.append(f"{count} views of the .vf file are {what} ({', '.join(keys)}): not read")
    return cameras, notes


def _says(line, keys):
    """Whether a view has one of some keys, and not for 0."""
    words = line.split()
    pairs = zip(words, words[1:], strict=False)
    return any(key in keys and value.strip("+-0.") for key, value in pairs)


def _camera(words):
    """Return the table of a view, None where it is of another kind or wrong."""
    kind, said, k = "v", {"-vu": [0.0, 0, 1], "-vh": [45.0], "-vv": [45.0]}, 0
    while k < len(words):
        word, count = words[k], NUMBERS.get(words[k], IGNORED.get(words[k], 0))
        if word.startswith("-vt"):
            kind = word[3:]
        if count:
            try:
                said[word] = [float(x) for x in words[k + 1 : k + 1 + count]]
            except ValueError:
                return None
            if len(said[word]) != count or not np.all(np.abs(said[word]) < 1e15):
                return None
        k += 1 + count
    if kind not in ("v", "l") or "-vp" not in said or "-vd" not in said:
        return None
    return _table(kind, said)


def _table(kind, said):
    place, way, up = (np.array(said[key]) for key in ("-vp", "-vd", "-vu"))
    wide, high = said["-vh"][0], said["-vv"][0]
    across = np.linalg.norm(np.cross(way, up))
    if across <= 1e-6 * np.linalg.norm(way) * np.linalg.norm(up) or min(wide, high) <= 0.0:
        return None
    table = {"position": place.tolist(), "target": (place + way).tolist(), "up": up.tolist()}
    if kind == "v":
        if max(wide, high) >= 179.0:
            return None
        table["fov"] = high
        wide, high = np.tan(np.radians([wide / 2.0, high / 2.0]))
    else:
        table |= {"projection": "orthographic", "height": high}
    sizes = np.array([wide, high]) / max(wide, high) * WIDTH
    return table | {"size": [max(int(round(x)), 1) for x in sizes]}
