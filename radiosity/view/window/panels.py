"""What the panels of the window say, and where they lie."""

import textwrap
import time
from dataclasses import replace

from radiosity.view.window.drawing import Panel, Row, mark, panel, scale_panel
from radiosity.view.window.hud import LEAST, MARGIN, PANELS, Hud, line_height
from radiosity.view.window.keys import KEYS
from radiosity.view.window.lamps import FULL
from radiosity.view.window.look import RANGE, TITLES

HINT = "click reads lux, f false colours, w a s d walk"
RESERVED = 9  # lines of the window's height that the left column leaves free
ALL = "lamps", "cameras", "exposure", "notes", "reading", "scale", "help", "hint"
NARROW = 380  # pixels of width below which there are no sliders


def lamp_rows(lamps, most: int) -> tuple[Row, ...]:
    """Return a slider for each group of light, as many as there is room for."""
    rows = []
    for k, name in enumerate(lamps.names[:most]):
        factor = lamps.factors[name]
        key = f"{k + 1} " if k < 9 else ""
        short = name if len(name) <= 16 else name[:15] + "\u2026"
        rows.append(
            Row(f"{key}{short}", f"{100 * factor:.0f} %", factor / FULL, f"lamp {name}")
        )
    more = len(lamps.names) - len(rows)
    return (*rows, *([Row(f"and {more} more: --dim NAME=F", faint=True)] if more else ()))


def camera_rows(cameras: dict, current, most: int) -> tuple[Row, ...]:
    """Return a button for each of so many cameras, none where there is only one."""
    if len(cameras) < 2:
        return ()
    return tuple(
        Row(name, name=f"camera {name}", strong=camera is current)
        for name, camera in list(cameras.items())[:most]
    )


def exposure_rows(look) -> tuple[Row, ...]:
    """Return the slider of exposure, in stops from the automatic one."""
    stops = look.from_automatic
    told = "auto" if abs(stops) < 0.05 else f"{stops:+.1f}"
    return (Row("exposure", told, (stops + RANGE) / (2 * RANGE), "exposure"),)


def help_rows() -> tuple[Row, ...]:
    """Return a line for each key."""
    return tuple(Row(key.shown, key.words, strong=True) for key in KEYS if key.words)


def solving_row(stage, patches: int | None, now: float) -> Row:
    """Return how far a solve is, with the time that its stage takes still."""
    found = "" if patches is None else f"{patches} patches"
    if stage is None or stage.over(now):
        return Row("solving \u2026", found)
    told, left = [f"{100 * stage.share:.0f} %"], stage.left()
    told += [] if left is None else [f"{_seconds(left)} left"]
    told += [found] if found else []
    return Row(f"solving: {stage.name}", ", ".join(told), stage.share, knob=False)


def note_rows(window, stage, message: str) -> list[Row]:
    """Return what is being waited for, with the ``stage`` of a solve, and a message."""
    rows, display, progress = [], window.display, window.gathered.progress
    if window.answer is None:
        found = None if display.solution is None else len(display.solution.patches)
        rows.append(solving_row(stage, found, time.monotonic()))
    elif display.lamps.waiting:
        rows.append(Row("telling the lights apart \u2026"))
    if display.look.mode == "error" and display.estimating:
        rows.append(Row("estimating the error \u2026"))
    if display.refining.share is not None:
        rows.append(Row("refining", "", display.refining.share, knob=False, faint=True))
    if window.pick.measuring:
        rows.append(Row("measuring \u2026"))
    if progress is not None:
        rows.append(Row("gathering", "", progress[0] / progress[1], knob=False, faint=True))
    return [*rows, Row(message)] if message else rows


def reading_rows(lines: list[str]) -> tuple[Row, ...]:
    """Return what was read at a point, the first line large."""
    first, *rest = lines
    return (Row(first, strong=True, size=1.25), *(Row(line) for line in rest))


class Panels:
    """All panels of a window, laid out so that none lies over another.

    Attributes
    ----------
    shown : bool
        Whether there are sliders and lists; words and scales always are.
    help : bool
        Whether the keys are listed.
    plain : bool
        Whether only what belongs to the picture is shown: scales, and what was read.
    """

    def __init__(self, hud: Hud):
        """Show nothing as yet."""
        self._hud, self.shown, self.help, self.plain = hud, True, False, False

    def draw(self, size, window, notes: list[Row]) -> None:
        """Lay all panels out in a window of ``size`` (w, h) pixels; ``notes`` tell of work."""
        if min(size) < LEAST:
            self._hud.hide(ALL)
            return
        line, look = line_height(size), window.display.look
        controls = self.shown and size[0] >= NARROW and not self.plain
        self._put_lists(size, line, window, controls)
        exposed = exposure_rows(look) if controls and look.mode == "picture" else ()
        used = self._put("exposure", exposed, line, size, -MARGIN, -MARGIN)[0]
        lines = window.pick.lines
        below = self._put("reading", reading_rows(lines) if lines else (), line, size,
                          -MARGIN, MARGIN)[1]  # fmt: skip
        used = max(used, self._put_scale(window.display, line, size, MARGIN + below))
        low = self._put_hint(size, line, size[0] - used)
        room = max(10, int((size[0] - used - 4 * MARGIN) / (0.62 * line)))
        rows = () if self.plain else tuple(_wrapped(notes, room))
        self._put("notes", rows, line, size, MARGIN, -MARGIN - low)
        fits = int((size[1] - 2 * MARGIN) / (1.6 * len(help_rows()) + 1.0))
        rows = help_rows() if self.help and not self.plain else ()
        self._put("help", rows, max(6, min(line, fits)), size, None, None, solid=True)

    def _put_lists(self, size, line, window, controls):
        """Put the lists of lights and of cameras below each other at the left."""
        most, top = max(1, (size[1] // line - RESERVED) // 4), MARGIN
        dims = controls and window.answer is not None
        lists = {
            "lamps": lamp_rows(window.display.lamps, most) if dims else (),
            "cameras": camera_rows(window.scene.cameras, window.home, most) if controls else (),
        }
        for name, rows in lists.items():
            top += self._put(name, rows, line, size, MARGIN, top)[1]

    def _put_hint(self, size, line, room):
        """Tell how to find help, and more where there is room; return the height it takes."""
        if self.plain:
            return self._put("hint", (), line, size, 0, 0)[1]
        rows = (Row("h help", HINT, faint=True),)
        wide = self._hud.draw("hint", (rows, line), lambda: panel(rows, line))[0]
        if wide + 2 * MARGIN > room:
            rows = (Row("h help", faint=True),)
        return self._put("hint", rows, line, size, MARGIN, -MARGIN)[1]

    def mark(self, size, place) -> None:
        """Show the mark of a picked point at a pixel (x, y), or take it away."""
        if place is None:
            self._hud.hide(["mark"])
            return
        line = line_height(size)
        wide, high = self._hud.draw("mark", line, lambda: Panel(mark(line)), layer=PANELS - 1)
        self._hud.put("mark", round(place[0] - wide / 2), round(place[1] - high / 2), size[1])

    def _put(self, name, rows, line, size, left, top, solid=False):
        """Put a panel at an edge, or in the middle; see `_start`.

        Returns the width and height that it takes, with a margin; 0 where it has no rows.
        """
        if not rows:
            self._hud.hide([name])
            return 0, 0
        layer = PANELS + solid
        wide, high = self._hud.draw(name, (rows, line), lambda: panel(rows, line, solid), layer)
        self._hud.put(name, _start(left, wide, size[0]), _start(top, high, size[1]), size[1])
        return wide + MARGIN, high + MARGIN

    def _put_scale(self, display, line, size, top):
        """Put the scale of false colours at the right; return the width that it takes."""
        height, scale, levels = size[1] - top - MARGIN, display.scale, display.levels
        if scale is None or height < 8 * line:
            self._hud.hide(["scale"])
            return 0
        title = TITLES[display.look.mode]
        key = scale, tuple(levels), title, height, line
        made = self._hud.draw("scale", key, lambda: scale_panel(scale, levels, title, height, line))
        self._hud.put("scale", size[0] - MARGIN - made[0], top, size[1])
        return made[0] + MARGIN


def _start(offset, extent, whole):
    """Return where something begins: negative offsets count from the end, None is the middle."""
    if offset is None:
        return (whole - extent) // 2
    return offset if offset >= 0 else whole + offset - extent


def _wrapped(notes, room):
    """Yield notes, those without a slider in lines of so many letters."""
    for row in notes:
        if row.value is not None:
            yield row
            continue
        first, *rest = textwrap.wrap(row.label, room)
        yield replace(row, label=first)
        yield from (replace(row, label=part, right="") for part in rest)


def _seconds(value):
    return f"{value:.0f} s" if value < 100 else f"{value / 60:.0f} min"
