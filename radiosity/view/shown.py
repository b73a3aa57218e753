"""A solution shown where the user sits: in a window, or inline in a notebook."""

from typing import TYPE_CHECKING

from radiosity.scene.model import Camera
from radiosity.solve.solution import Solution, refuse_unsolved

if TYPE_CHECKING:
    import numpy as np

    from radiosity.view.falsecolour import Scale
    from radiosity.view.notebook import Inline


def plot(
    solution: Solution,
    camera: Camera | str | None = None,
    size: tuple[int, int] | None = None,
    *,
    samples: int | None = None,
    exposure: float | None = None,
    false_colour: "Scale | float | None" = None,
    off_screen: bool = False,
    inline: bool | None = None,
) -> "Inline | np.ndarray | None":
    """Show a solution: in a notebook its picture inline, otherwise in a window until it is closed.

    Parameters
    ----------
    solution : Solution
    camera : Camera or str, optional
        Where to look from: one of the scene's by name, its first by default.
    size : (w, h), optional
        Pixels, instead of the camera's own; inline these are at most 640.
    samples : int, optional
        Rays over each pixel's hemisphere; in a window by default as the accuracy asks, inline 64.
    exposure : float, optional
        Display value per radiance, instead of the automatic one.
    false_colour : float or Scale, optional
        Luminance in false colours instead, up to so many cd/m2, or on a scale of
        `radiosity.view.falsecolour`.
    off_screen : bool
        Open nothing and return what the window would show at first.
    inline : bool, optional
        Whether to return the picture instead of opening a window; if not given, in notebooks.

    Returns
    -------
    Inline
        Inline: a picture that a notebook shows (``_repr_png_``), with its ``image``. It is gathered
        and needs neither a display nor VTK.
    (h, w, 3) uint8
        Off screen.
    None
        After a window was closed.

    Raises
    ------
    ValueError
        No such camera, one that cannot look, a size, number of samples or luminance out of range.
    RuntimeError
        A window is to be opened and there is no display.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1)
    >>> radiosity.plot(solution, size=(64, 48), inline=True, samples=8)
    <camera inside, 64 x 48>
    >>> radiosity.plot(solution, size=(64, 48), off_screen=True).shape
    (48, 64, 3)
    """
    from radiosity.view import notebook

    refuse_unsolved(solution)
    scale = _scale(false_colour)
    if inline or (inline is None and not off_screen and notebook.in_notebook()):
        return notebook.inline(solution, camera, size, samples, exposure, scale)
    from radiosity.view.window import show  # VTK takes long to load

    return show(
        solution, camera, size, off_screen=off_screen, samples=samples, exposure=exposure,
        scale=scale,
    )  # fmt: skip


def _scale(false_colour):
    """Return the scale that a luminance stands for, a scale as it is."""
    if false_colour is None or hasattr(false_colour, "colours"):
        return false_colour
    from radiosity.view.falsecolour import Scale

    return Scale(float(false_colour))
