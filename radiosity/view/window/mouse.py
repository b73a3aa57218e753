"""The mouse over the window: it moves sliders, looks around, picks, or else turns the scene."""

import math

from radiosity.view.window.commands import Commands
from radiosity.view.window.hud import Hud

FIRST = 10.0  # before VTK's own style of interaction
STILL = 4.0  # pixels that a click may move


class Mouse:
    """What the left button does; the rest, and turning the scene, is VTK's."""

    def __init__(self, interactor, commands: Commands, hud: Hud, guarded):
        """Listen to a VTK interactor; ``guarded`` makes observers, see `Window.guarded`.

        While its style turns the scene, only that hears of the mouse; it tells when it ends.
        """
        self._interactor, self._commands, self._hud = interactor, commands, hud
        self._grip = self._begun = self._last = None
        for event, answer in {
            "LeftButtonPressEvent": self._press,
            "MouseMoveEvent": self._move,
            "LeftButtonReleaseEvent": self._release,
        }.items():
            self._listen(event, guarded(answer))
        style = interactor.GetInteractorStyle()
        style.AddObserver("EndInteractionEvent", guarded(self._release))

    @property
    def sliding(self) -> bool:
        """Return whether a control is held."""
        return self._grip is not None

    def position(self) -> tuple[float, float]:
        """Return where the mouse is, in pixels from the left and from the top."""
        x, y = self._interactor.GetEventPosition()
        return x + 0.5, self._height() - (y + 0.5)

    def _height(self):
        return self._interactor.GetRenderWindow().GetSize()[1]

    def _listen(self, event, answer):
        """Call ``answer``; where it returns true nothing else hears of the event."""

        def heard(*_):
            if answer():
                self._interactor.GetCommand(tag).SetAbortFlag(1)

        tag = self._interactor.AddObserver(event, heard, FIRST)

    def _press(self):
        at = self.position()
        self._grip = self._hud.grip(*at)
        if self._grip is not None:
            self._use(at)
            return True
        if self._hud.covers(*at):
            return True
        self._begun = self._last = at
        return self._commands.look_around(0.0, 0.0)

    def _move(self):
        at = self.position()
        if self._grip is not None:
            if self._grip.control.track is not None:
                self._use(at)
            return True
        if self._begun is None:
            return False
        (x, y), height, self._last = self._last, self._height(), at
        return self._commands.look_around((at[0] - x) / height, (y - at[1]) / height)

    def _release(self):
        if self._grip is not None:
            self._grip = None
            return True
        begun, self._begun = self._begun, None
        still = begun is not None and math.dist(begun, self.position()) < STILL
        if still and not (self._interactor.GetShiftKey() or self._interactor.GetControlKey()):
            self._commands.pick(*begun)
        return begun is not None and self._commands.look_around(0.0, 0.0)

    def _use(self, at):
        self._commands.use(self._grip.control.name, self._grip.value(at[0]))
