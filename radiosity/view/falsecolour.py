"""False colours: luminance, or another quantity, as a colour to be read off a scale.

The map is viridis (van der Walt & Smith 2015, CC0, as matplotlib has it): its lightness rises
evenly, so equal steps look equal, also in grey and to most who see colours otherwise.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

STEPS = 256  # of the map
DECADES = 3.0  # of a logarithmic scale
_ROUND = np.array([1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])
_LINES = 28  # of text that fit into a picture's height
_SMALLEST, _LARGEST = 11, 48  # pixels that a line of text may be high
_SINGLE = 1e-6  # what pictures in single precision may be off
_APART = 1.5  # lines from number to number at least


@dataclass(frozen=True)
class Scale:
    """What luminance, or value in another unit, a colour of the map stands for.

    Attributes
    ----------
    maximum : float
        Luminance in cd/m2 of the map's upper end; what is brighter has its colour, too.
    decades : float
        0 for a linear scale from 0; otherwise a logarithmic one from maximum/10^decades.
    unit : str
        Of the values, where they are no luminances.

    Raises
    ------
    ValueError
        A maximum that is not positive and finite.

    Examples
    --------
    >>> Scale(500.0).colours([0.0, 500.0]).tolist()
    [[68, 1, 84], [253, 231, 36]]
    >>> Scale(500.0, decades=2.0).position(50.0).tolist()
    0.5
    """

    maximum: float
    decades: float = 0.0
    unit: str = "cd/m\u00b2"

    def __post_init__(self):
        if not 0.0 < self.maximum < np.inf:
            raise ValueError(
                f"false colours up to {self.maximum:g} {self.unit}: the scale's end must be "
                "positive and finite"
            )

    @property
    def minimum(self) -> float:
        """Return the luminance in cd/m2 of the map's lower end."""
        return self.maximum / 10.0**self.decades if self.decades else 0.0

    def position(self, luminance: np.ndarray) -> np.ndarray:
        """Return (...) where luminances in cd/m2 are on the scale, clipped to [0, 1].

        p = Y/Y_max, or 1 + log10(Y/Y_max)/decades.
        """
        return np.clip(self.place(luminance), 0.0, 1.0)

    def place(self, luminance: np.ndarray) -> np.ndarray:
        """Return (...) the position of luminances, above 1 what is brighter, to be interpolated.

        Logarithmic ones are not below -1, where black would be infinitely far from all else.
        """
        share = np.maximum(np.asarray(luminance, float) / self.maximum, 0.0)
        if self.decades:
            share = np.maximum(1.0 + np.log10(np.maximum(share, 1e-300)) / self.decades, -1.0)
        return share

    def luminance(self, position: np.ndarray) -> np.ndarray:
        """Return (...) luminances in cd/m2 of places on the scale: the inverse of `position`."""
        p = np.asarray(position, float)
        return self.maximum * (10.0 ** (self.decades * (p - 1.0)) if self.decades else p)

    def colours(self, luminance: np.ndarray) -> np.ndarray:
        """Return (..., 3) uint8 display values of luminances (...) in cd/m2, in 256 steps."""
        return _map()[np.minimum((self.position(luminance) * STEPS).astype(int), STEPS - 1)]

    def ticks(self, most: int) -> np.ndarray:
        """Return round luminances on the scale, ascending, both ends included, about ``most``."""
        if self.decades:
            return _decades(self.minimum, self.maximum)
        from matplotlib.ticker import MaxNLocator

        found = MaxNLocator(max(most, 1), steps=[1, 2, 5, 10]).tick_values(0.0, self.maximum)
        inner = found[(found > 0.0) & (found < 0.999 * self.maximum)]
        return np.concatenate([[0.0], inner, [self.maximum]])


def round_up(luminance: float) -> float:
    """Return the next round number, 1 for what is not positive."""
    if not luminance > 0.0:
        return 1.0
    unit = 10.0 ** np.floor(np.log10(luminance))
    return float(unit * _ROUND[_ROUND * unit >= luminance * (1.0 - 1e-9)][0])


def false_colours(luminance: np.ndarray, scale: Scale) -> np.ndarray:
    """Return (h', w', 3) uint8: a picture (h, w) of luminances in cd/m2 and the scale at its right.

    The picture's pixels stay where they are; a low one gets white below, for the numbers' sake.
    """
    height, width = np.shape(luminance)
    over = np.max(luminance) > scale.maximum * (1.0 + _SINGLE)
    under = np.min(luminance) < scale.minimum * (1.0 - _SINGLE)
    strip = bar(scale, height, bool(over), bool(under))
    whole = np.full((len(strip), width + strip.shape[1], 3), 255, np.uint8)
    whole[:height, :width] = scale.colours(luminance)
    whole[:, width:] = strip
    return whole


def bar(scale: Scale, height: int, over: bool = False, under: bool = False) -> np.ndarray:
    """Return (h, w, 3) uint8 of a strip with the scale and its numbers, h at least the height.

    ``over`` and ``under`` say that something is brighter or darker than the scale's ends.
    """
    line = int(np.clip(height // _LINES, _SMALLEST, _LARGEST))
    height = max(height, 6 * line)
    top, bottom = 2 * line + line // 2, height - line
    ticks = scale.ticks((bottom - top) // (3 * line))
    rows = bottom - scale.position(ticks) * (bottom - top)
    words = [f"{tick:.6g}" for tick in ticks]
    words[0] = "\u2264 " * under + words[0]
    words[-1] = "\u2265 " * over + words[-1]
    numbers = [(rows[k], words[k]) for k in spaced(rows, _APART * line)]
    strip = _lettered(height, line, numbers, scale.unit)
    at = (bottom - 0.5 - np.arange(top, bottom)) / (bottom - top)
    strip[top:bottom, line : 2 * line] = scale.colours(scale.luminance(at))[:, None]
    return strip


def spaced(rows, gap):
    """Return which of descending rows have room for a number: both ends, then from the top."""
    kept, last = [len(rows) - 1, 0], rows[-1]
    for k in range(len(rows) - 2, 0, -1):
        if rows[k] - last >= gap and rows[0] - rows[k] >= gap:
            kept.append(k)
            last = rows[k]
    return kept


def _lettered(height, line, words, unit):
    """Return a white strip (h, w, 3) uint8 with ticks and words at rows, and the unit above."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    longest = max(4, *(len(text) for _, text in words))
    dpi, width = 72.0, int((3.2 + 0.65 * longest) * line)
    figure = Figure((width / dpi, height / dpi), dpi=dpi, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.axis("off")
    axes.text(line, line, unit, size=line, va="center")
    for row, text in words:
        axes.plot([2 * line, 2.4 * line], [row, row], color="black", lw=line / 12)
        axes.text(2.7 * line, row, text, size=line, va="center_baseline")
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _decades(low, high):
    """Return both ends and, between them, 1, 2 and 5 times the powers of ten."""
    powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.log10(high) + 1)
    inner = np.outer(powers, [1.0, 2.0, 5.0]).ravel()
    inner = inner[(inner > 1.001 * low) & (inner < 0.999 * high)]
    return np.concatenate([[low], inner, [high]])


@cache
def _map():
    """Return (256, 3) uint8, read-only, the colours from the lower end to the upper."""
    from matplotlib import colormaps

    colours = np.asarray(colormaps["viridis"](np.arange(STEPS), bytes=True))[:, :3].copy()
    colours.flags.writeable = False
    return colours
