"""Names that users type: the nearest known one, and the error where none is meant."""

import difflib
from collections.abc import Iterable

SHOWN = 20  # names that a message lists


class UnknownName(ValueError):
    """A camera, light group or surface that the scene does not have.

    Attributes
    ----------
    name : str
    known : list of str
        What the scene has instead.

    Examples
    --------
    >>> import radiosity
    >>> scene = radiosity.load("scenes/cornell_box.toml")
    >>> radiosity.render(scene, "fornt")
    Traceback (most recent call last):
    radiosity.scene.names.UnknownName: no camera is called 'fornt': did you mean 'front'? ...
    """

    def __init__(self, what: str, name: str, known: Iterable[str]):
        self.name, self.known = name, list(known)
        like = difflib.get_close_matches(name, self.known, 1)
        meant = f"did you mean {like[0]!r}? The" if like else "the"
        listed = ", ".join(map(repr, self.known[:SHOWN])) or "none"
        more = len(self.known) - SHOWN
        super().__init__(
            f"no {what} is called {name!r}: {meant} scene has {listed}"
            + (f" and {more} more" if more > 0 else "")
        )


def counted(count: int, thing: str) -> str:
    """Return ``1 patch``, ``2 patches``: the plural but where there is one."""
    plural = thing + ("es" if thing.endswith("ch") else "s")
    return f"{count} {thing if count == 1 else plural}"


# What heat transfer has other words for, and what it is here.
ELSEWHERE = {
    "emissivity": "a grey surface of emissivity e has diffuse = 1 - e",
    "temperature": "a grey surface of emissivity e and temperature T in kelvins has "
    "emission = { exitance = 5.670374419e-8 * e * T^4 }, as a number",
}


def nearest(name: str, known: Iterable[str]) -> str:
    """Return a question with the known name most like this one, or all that are known."""
    if name in ELSEWHERE:
        return ELSEWHERE[name]
    like = difflib.get_close_matches(name, list(known), n=1)
    return f"did you mean {like[0]}?" if like else f"known are {', '.join(known) or 'none'}"
