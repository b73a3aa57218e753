"""The keys of the window, and the lines of help that tell them."""

from dataclasses import dataclass

from radiosity.view.window.walking import WAYS


@dataclass(frozen=True)
class Key:
    """A key, and what it does.

    Attributes
    ----------
    symbols : tuple of str
        As VTK names it, in lower case; behind ``ctrl+`` with that key.
    shown, words : str
        Its line of help; none where ``words`` is empty.
    action : str
        The method of `Commands` that it calls; empty where the line only tells of something.
    """

    symbols: tuple[str, ...]
    shown: str
    words: str
    action: str = ""


KEYS = (
    Key((), "drag", "turn    shift+drag  move    wheel  zoom"),
    Key((), "click", "read the illuminance at a point"),
    Key(("p",), "p", "the same, under the mouse pointer", "pick_under_pointer"),
    Key((), "w a s d", "walk, or arrow keys; then drag looks around"),
    Key((), "Page Up/Down", "eyes higher, lower"),
    Key(("o",), "o", "turn the scene again, after walking", "orbit"),
    Key(("c",), "c", "next camera of the scene", "next_camera"),
    Key(("r",), "r", "return to the camera", "reset"),
    Key(("f",), "f", "illuminance, luminance, picture", "next_mode"),
    Key(("x",), "x", "estimated error", "toggle_error"),
    Key(("l",), "l", "scale linear or logarithmic", "toggle_logarithmic"),
    Key(("i",), "i", "isolux lines", "toggle_isolines"),
    Key(("plus", "equal", "kp_add"), "+ -", "brighter, darker; of a scale: its end", "brighter"),
    Key(("minus", "underscore", "kp_subtract"), "", "", "darker"),
    Key(("0", "kp_0"), "0", "automatic exposure or scale", "adapt"),
    Key((), "1 .. 9", "switch a group of lights"),
    Key(("e",), "e", "edges of the patches", "toggle_edges"),
    Key(("g",), "g", "gather the view at rest, or not", "toggle_gathering"),
    Key(("tab",), "Tab", "hide or show the panels", "toggle_panels"),
    Key(("f2",), "F2", "save what is shown (PNG)", "save_screen"),
    Key(("f3", "ctrl+s"), "F3, ctrl+s", "save radiance (EXR) and solution", "save_light"),
    Key(("h", "f1", "question"), "h", "this help", "toggle_help"),
    Key(("escape",), "", "", "dismiss"),
    Key(("q", "ctrl+q", "ctrl+w"), "q", "quit", "quit"),
)
ACTIONS = {symbol: key.action for key in KEYS for symbol in key.symbols}
DIGITS = {str(k): k - 1 for k in range(1, 10)} | {f"kp_{k}": k - 1 for k in range(1, 10)}
STEPS = {symbol.lower(): symbol for symbol in WAYS}


class Keyboard:
    """What is pressed, handed on to the commands."""

    def __init__(self, interactor, commands, guarded):
        """Listen to a VTK interactor; ``guarded`` makes observers, see `Window.guarded`."""
        self._interactor, self._commands = interactor, commands
        interactor.AddObserver("KeyPressEvent", guarded(self._press))
        interactor.AddObserver("KeyReleaseEvent", guarded(self._release))

    def _symbol(self):
        return (self._interactor.GetKeySym() or "").lower()

    def _press(self):
        symbol, commands = self._symbol(), self._commands
        action = ACTIONS.get(f"ctrl+{symbol}" if self._interactor.GetControlKey() else symbol)
        if action is not None:
            getattr(commands, action)()
        elif self._interactor.GetControlKey():
            return
        elif symbol in STEPS:
            commands.walk(STEPS[symbol])
        elif symbol in DIGITS:
            commands.switch_light(DIGITS[symbol])

    def _release(self):
        symbol = self._symbol()
        if symbol in STEPS:
            self._commands.halt(STEPS[symbol])
