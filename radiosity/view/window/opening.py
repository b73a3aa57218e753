"""Opening a window: on a solution, or on a scene while it is being solved."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from radiosity.scene.model import Camera, Scene
from radiosity.solve.solution import Solution
from radiosity.transport.threads import Progress
from radiosity.view.shading import auto_exposure
from radiosity.view.tones import Tones
from radiosity.view.window.solving import Solving
from radiosity.view.window.viewer import Window

if TYPE_CHECKING:
    from radiosity.view.falsecolour import Scale


def show(
    solution: Solution,
    camera: Camera | str | None = None,
    size: tuple[int, int] | None = None,
    off_screen: bool = False,
    samples: int | None = None,
    exposure: float | None = None,
    scale: "Scale | None" = None,
) -> np.ndarray | None:
    """Show a solution until the user closes the window; in a notebook, its picture inline.

    Parameters
    ----------
    solution : Solution
    camera : Camera or str, optional
        Where to start: one of the scene's by name, its first by default.
    size : (w, h), optional
        Pixels, instead of the camera's own.
    off_screen : bool
        Open nothing and return what the window would show at first.
    samples : int, optional
        Rays over each pixel's hemisphere that a gathered view ends with; by default the accuracy of
        the solution decides.
    exposure : float, optional
        Display value per radiance that it starts with, instead of the automatic one.
    scale : Scale, optional
        Of `radiosity.view.falsecolour`: luminance in false colours at first, with the scale.

    Returns
    -------
    (h, w, 3) uint8 or None
        The picture, if ``off_screen``.

    Raises
    ------
    ValueError
        No such camera, one that cannot look, or a number of samples out of range.
    RuntimeError
        There is no display.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1)
    >>> show(solution, size=(64, 48), off_screen=True).shape
    (48, 64, 3)
    """
    tones = Tones(auto_exposure(solution) if exposure is None else exposure, scale)
    window = Window(
        solution, camera, size, samples=samples, off_screen=off_screen, tones=lambda _: tones
    )
    try:
        return window.screenshot() if off_screen else window.run()
    finally:
        window.close()


def show_solving(
    scene: Scene,
    solve: Callable[[Progress, Callable[[Solution], None]], Solution],
    camera: Camera | str | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    tones: Callable[[Solution], Tones] | None = None,
) -> Solution | None:
    """Open a window on a scene at once, and show what a solve in a thread finds.

    Parameters
    ----------
    scene : Scene
    solve : callable
        Called as ``solve(progress, watch)``, see `radiosity.solve.solve.solve`; returns the answer.
    camera, size, samples
        See `show`.
    tones : callable, optional
        Returns the tones that a solution is shown in at first.

    Returns
    -------
    Solution or None
        The answer, None where the window was closed before there was one.

    Raises
    ------
    Exception
        What ended the solve, after the window is closed.
    RuntimeError
        There is no display.
    """
    solving = Solving(solve)
    window = Window(scene, camera, size, samples=samples, tones=tones, solving=solving)
    try:
        solving.start()
        window.run()
        return solving.newest if solving.ready else None
    finally:
        window.close()
