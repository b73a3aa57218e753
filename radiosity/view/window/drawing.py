"""Panels of words and sliders as pictures, readable on bright and on dark."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np

from radiosity.view.falsecolour import Scale, spaced

GROUND, CLEAR, SOLID = (18, 20, 24), 205, 248  # of panels: red, green, blue; opacity
INK, FAINT, ACCENT = (242, 242, 240, 255), (160, 164, 170, 255), (255, 184, 82, 255)
GROOVE = (78, 82, 90, 255)
TRACK = 8.0  # width of a slider, in lines
FINE = 4  # times as fine as pixels, that round corners are drawn


@dataclass(frozen=True)
class Row:
    """A line of a panel: words, then a slider where there is a ``value``, then more words.

    Attributes
    ----------
    label, right : str
    value : float or None
        Where the slider's knob is, 0 to 1.
    name : str or None
        What the mouse takes hold of; None for what is only to be read.
    knob : bool
        Whether the slider is one, not a bar of progress.
    strong, faint : bool
        Words in the accent's colour, or in grey.
    size : float
        Of the letters, in lines.
    """

    label: str
    right: str = ""
    value: float | None = None
    name: str | None = None
    knob: bool = True
    strong: bool = False
    faint: bool = False
    size: float = 1.0


@dataclass(frozen=True)
class Control:
    """What the mouse can take hold of, in pixels from the panel's upper left corner.

    ``track`` are the left and right ends of a slider, None for a button.
    """

    name: str
    top: int
    bottom: int
    track: tuple[float, float] | None = None

    def value(self, x: float) -> float:
        """Return where on the slider, 0 to 1, a horizontal position is."""
        low, high = self.track
        return float(np.clip((x - low) / (high - low), 0.0, 1.0))


@dataclass(frozen=True)
class Panel:
    """A picture (h, w, 4) uint8 with opacity, and what of it the mouse can take hold of."""

    pixels: np.ndarray
    controls: tuple[Control, ...] = field(default=())


def panel(rows: tuple[Row, ...], line: int, solid: bool = False) -> Panel:
    """Draw rows below each other, words and sliders in columns.

    ``line`` is how many pixels letters are high; what lies below a ``solid`` one is not seen.
    """
    from PIL import ImageDraw

    pad, gap = round(0.7 * line), round(0.7 * line)
    left = max(_width(r.label, r.size * line) for r in rows)
    slid = any(r.value is not None for r in rows)
    right = max(_width(r.right, r.size * line) for r in rows)
    track = pad + left + gap
    after = track + (round(TRACK * line) + gap if slid else 0)
    width = (after + right if right else after - gap) + pad
    heights = [round(1.6 * r.size * line) for r in rows]
    image = _ground(width, sum(heights) + pad, SOLID if solid else CLEAR)
    pen, top, controls = ImageDraw.Draw(image), pad // 2, []
    for row, height in zip(rows, heights, strict=True):
        middle, ink = top + height / 2, ACCENT if row.strong else FAINT if row.faint else INK
        letters = _font(round(row.size * line))
        pen.text((pad, middle), row.label, ink, letters, "lm")
        pen.text((after, middle), row.right, FAINT if row.faint else INK, letters, "lm")
        ends = None
        if row.value is not None:
            ends = track, track + TRACK * line
            _draw_slider(image, ends, middle, row, line)
        if row.name is not None:
            controls.append(Control(row.name, top, top + height, ends))
        top += height
    return Panel(np.asarray(image), tuple(controls))


def scale_panel(scale: Scale, levels: np.ndarray, title: str, height: int, line: int) -> Panel:
    """Draw a scale of false colours with its numbers, and where lines of equal value are."""
    from PIL import ImageDraw

    pad, ticks = round(0.7 * line), scale.ticks(max(2, height // (4 * line)))
    words = [f"{tick:.4g}" for tick in ticks]
    words[0], words[-1] = ("\u2264 " if scale.decades else "") + words[0], "\u2265 " + words[-1]
    top, bottom = pad // 2 + 3 * line, height - pad - line // 2
    bar, beside = (pad, pad + 2 * line), pad + round(2.6 * line)
    wide = max(_width(text, line) for text in words)
    width = max(beside + wide, pad + _width(title, line)) + pad
    image = _ground(width, height)
    pen = ImageDraw.Draw(image)
    pen.text((pad, pad // 2 + line), title, INK, _font(line), "lm")
    at = (bottom - 0.5 - np.arange(top, bottom)) / (bottom - top)
    colours = np.asarray(image).copy()
    colours[top:bottom, slice(*bar), :3] = scale.colours(scale.luminance(at))[:, None]
    colours[top:bottom, slice(*bar), 3] = 255
    image = _image(colours)
    pen = ImageDraw.Draw(image)
    for place in scale.position(levels):
        row = round(bottom - place * (bottom - top))
        pen.line([bar[0], row, bar[1] - 1, row], (20, 20, 20) if place > 0.6 else (255,) * 3)
    rows = bottom - scale.position(ticks) * (bottom - top)
    for k in spaced(rows, 1.5 * line):
        pen.text((beside, rows[k]), words[k], INK, _font(line), "lm")
    return Panel(np.asarray(image))


def tag(text: str, line: int) -> Panel:
    """Draw a small label."""
    from PIL import ImageDraw

    letters = round(0.9 * line)
    image = _ground(_width(text, letters) + line // 2, round(1.25 * line))
    ImageDraw.Draw(image).text(
        (image.width / 2, image.height / 2), text, INK, _font(letters), "mm"
    )
    return Panel(np.asarray(image))


def mark(line: int) -> np.ndarray:
    """Return (h, w, 4) uint8: a ring around the point that was picked, bright on dark."""
    from PIL import Image, ImageDraw

    size = 2 * line + 1
    image = Image.new("RGBA", (FINE * size, FINE * size), (0, 0, 0, 0))
    pen = ImageDraw.Draw(image)
    for inset, ink, wide in ((0.2, (0, 0, 0, 230), 0.4), (0.3, INK, 0.2)):
        ends = FINE * inset * line, FINE * (size - inset * line) - 1
        thick = round(FINE * wide * line)
        pen.ellipse([ends[0], ends[0], ends[1], ends[1]], outline=ink, width=thick)
    middle, dot = FINE * size / 2, FINE * 0.18 * line
    pen.ellipse([middle - dot, middle - dot, middle + dot, middle + dot], fill=ACCENT)
    return np.asarray(image.resize((size, size), Image.Resampling.BOX))


def _draw_slider(image, ends, middle, row, line):
    """Draw a groove, filled as far as the value, with a knob where it can be moved."""
    from PIL import ImageDraw

    pen, (low, high) = ImageDraw.Draw(image), ends
    at, thick = low + np.clip(row.value, 0.0, 1.0) * (high - low), max(2, line // 5)
    pen.rounded_rectangle([low, middle - thick, high, middle + thick], thick, GROOVE)
    if at - low > 1.0:
        pen.rounded_rectangle([low, middle - thick, at, middle + thick], thick, ACCENT)
    if row.knob:
        reach = 0.5 * line
        pen.ellipse([at - reach, middle - reach, at + reach, middle + reach], INK)


@cache
def _font(pixels: int):
    from pathlib import Path

    from matplotlib import get_data_path
    from PIL import ImageFont

    return ImageFont.truetype(str(Path(get_data_path(), "fonts/ttf/DejaVuSans.ttf")), pixels)


def _width(text, pixels):
    return round(_font(round(pixels)).getlength(text)) if text else 0


def _image(pixels):
    from PIL import Image

    return Image.fromarray(pixels, "RGBA")


def _ground(width, height, opacity=CLEAR):
    """Return an empty panel with round corners."""
    from PIL import Image, ImageDraw

    mask = Image.new("L", (FINE * width, FINE * height), 0)
    ends = [0, 0, FINE * width - 1, FINE * height - 1]
    ImageDraw.Draw(mask).rounded_rectangle(ends, FINE * 5, opacity)
    ground = Image.new("RGBA", (width, height), (*GROUND, 255))
    ground.putalpha(mask.resize((width, height), Image.Resampling.BOX))
    return ground
