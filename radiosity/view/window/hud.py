"""What lies over the picture: panels in the window's corners, drawn anew only where they change."""

from dataclasses import dataclass

from radiosity.view.progressive import Cover
from radiosity.view.window.drawing import Control, Panel

LEAST = 240  # pixels of a side of a window that has room for any panel
LINE = (10, 16)  # pixels that letters are high, in small windows and in large ones
LINES = 42  # of text that a window of a size in between is high
PANELS = 2  # layer; marks and labels lie in the one below, above the picture
MARGIN = 6  # pixels between panels, and to the window's edges


@dataclass
class _Sheet:
    cover: Cover
    key: object = None
    panel: Panel | None = None
    left: int = 0
    top: int = 0
    layer: int = 0
    shown: bool = False


@dataclass(frozen=True)
class Grip:
    """A control that the mouse holds: ``value`` is where on its slider, None for a button."""

    control: Control
    left: int

    def value(self, x: float) -> float | None:
        """Return where on the slider, 0 to 1, the mouse is at a column of the window."""
        return None if self.control.track is None else self.control.value(x - self.left)


def line_height(size: tuple[int, int]) -> int:
    """Return how many pixels letters are high in a window."""
    return min(max(min(size) // LINES, LINE[0]), LINE[1])


class Hud:
    """Panels over a VTK renderer, by name."""

    def __init__(self, renderer):
        """Show nothing as yet."""
        self._renderer, self._sheets = renderer, {}

    def draw(self, name: str, key: object, make, layer: int = PANELS) -> tuple[int, int]:
        """Make a panel ready where its ``key`` is new, by ``make()``; return its (w, h).

        The mouse takes no notice of what lies in lower layers than `PANELS`.
        """
        if name not in self._sheets:
            self._sheets[name] = _Sheet(Cover(self._renderer, layer), layer=layer)
            for sheet in sorted(self._sheets.values(), key=lambda sheet: sheet.layer):
                if sheet.layer > layer:
                    sheet.cover.raise_up()
        sheet = self._sheets[name]
        if sheet.panel is None or sheet.key != key:
            sheet.key, sheet.panel = key, make()
            sheet.shown = False
        height, width, _ = sheet.panel.pixels.shape
        return width, height

    def put(self, name: str, left: int, top: int, height: int) -> None:
        """Show a panel with its upper left corner at a pixel of a window of a height."""
        sheet = self._sheets[name]
        bottom = height - top - len(sheet.panel.pixels)
        if not sheet.shown:
            sheet.cover.show(sheet.panel.pixels, left, bottom)
        else:
            sheet.cover.move(left, bottom)
        sheet.left, sheet.top, sheet.shown = left, top, True

    def hide(self, names=None) -> None:
        """Take panels away, all where none are named."""
        for name in self._sheets if names is None else names:
            if name in self._sheets:
                self._sheets[name].cover.hide()
                self._sheets[name].shown = False

    def place_of(self, name: str) -> tuple[int, int, int, int] | None:
        """Return left, top, width and height of a panel that is shown, in pixels."""
        sheet = self._sheets.get(name)
        if sheet is None or not sheet.shown:
            return None
        height, width, _ = sheet.panel.pixels.shape
        return sheet.left, sheet.top, width, height

    def places(self) -> list[tuple[int, int, int, int]]:
        """Return `place_of` all panels that are shown."""
        return [place for name in self._sheets if (place := self.place_of(name)) is not None]

    def covers(self, x: float, y: float) -> bool:
        """Return whether a panel lies over a pixel, y down from the top."""
        return self._at(x, y) is not None

    def grip(self, x: float, y: float) -> Grip | None:
        """Return the control at a pixel, y down from the top, None where there is none."""
        sheet = self._at(x, y)
        if sheet is None:
            return None
        within = (c for c in sheet.panel.controls if c.top <= y - sheet.top < c.bottom)
        control = next(within, None)
        return None if control is None else Grip(control, sheet.left)

    def _at(self, x, y):
        for name, sheet in reversed(self._sheets.items()):
            place = self.place_of(name)
            if place is None or sheet.layer < PANELS:
                continue
            left, top, width, height = place
            if left <= x < left + width and top <= y < top + height:
                return sheet
        return None
