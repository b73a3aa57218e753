"""Progressive gathering: a thread that gathers one view, and the picture that covers a window.

The thread computes and touches nothing of VTK; who shows its pictures asks for the newest.
"""

import threading
from dataclasses import dataclass, replace

import numpy as np

from radiosity.scene.model import Camera
from radiosity.solve.solution import Solution
from radiosity.view import gather
from radiosity.view.image import Image


@dataclass(frozen=True)
class _Progress:
    """How many pictures came, the newest and whether it is the last, replaced as a whole."""

    done: int
    image: Image | None
    last: bool = False


class Job:
    """One view being gathered in a thread of its own.

    Attributes
    ----------
    error : Exception or None
        What ended the thread early.
    thread : threading.Thread
    """

    def __init__(
        self,
        solution: Solution,
        camera: Camera,
        samples: int | None,
        turn: threading.Lock,
    ):
        """Start to gather; of the jobs that share ``turn`` one computes at a time."""
        self._expected = gather.pass_count(samples)
        self.error = None
        self._newest = self._returned = _Progress(0, None)
        self._stopped = threading.Event()
        self.thread = threading.Thread(
            target=self._run, args=(solution, camera, samples, turn), daemon=True
        )
        self.thread.start()

    @property
    def total(self) -> int:
        """Return how many pictures are expected, where errors decide it a guess."""
        return max(self._expected, self.done + 1)

    @property
    def done(self) -> int:
        """Return how many came until the picture that `newest` returned last."""
        return self._returned.done

    @property
    def finished(self) -> bool:
        """Return whether the last picture was returned."""
        return self._returned.last

    def newest(self) -> Image | None:
        """Return the newest picture, or None where it was returned before."""
        newest = self._newest
        if newest is self._returned:
            return None
        self._returned = newest
        return newest.image

    def stop(self) -> None:
        """Let the thread end soon, within the pass that it computes."""
        self._stopped.set()

    def _run(self, solution, camera, samples, turn):
        try:
            with turn:
                if self._stopped.is_set():
                    return
                passes = gather.passes(
                    solution, camera, size=camera.size, samples=samples, stop=self._stopped.is_set
                )
                for done, image in enumerate(passes, start=1):
                    self._newest = _Progress(done, image)
                if not self._stopped.is_set():
                    self._newest = replace(self._newest, last=True)
        except Exception as error:  # for the main thread to raise
            self.error = error


class Cover:
    """A picture laid over a renderer pixel for pixel, not scaled."""

    def __init__(self, renderer, layer: int):
        """Make ready to cover a VTK renderer that fills its window, above lower layers."""
        from vtkmodules.vtkRenderingCore import vtkActor2D, vtkImageMapper

        self._renderer, self._mapper, self._actor = renderer, vtkImageMapper(), vtkActor2D()
        self._mapper.SetColorWindow(255.0)  # with this level, bytes are shown as they are
        self._mapper.SetColorLevel(127.5)
        self._actor.SetMapper(self._mapper)
        self._actor.SetLayerNumber(layer)
        self._actor.VisibilityOff()
        renderer.AddViewProp(self._actor)

    @property
    def visible(self) -> bool:
        """Return whether a picture is shown."""
        return bool(self._actor.GetVisibility())

    def show(self, picture: np.ndarray, left: int = 0, bottom: int = 0) -> None:
        """Lay (h, w, 3) or, with opacity, (h, w, 4) uint8 over the window from a pixel on.

        VTK counts rows from the bottom.
        """
        import pyvista

        height, width, bands = picture.shape
        image = pyvista.ImageData(dimensions=(width, height, 1))
        image.point_data["colour"] = np.ascontiguousarray(picture[::-1]).reshape(-1, bands)
        self._mapper.SetInputData(image)
        self.move(left, bottom)

    def move(self, left: int, bottom: int) -> None:
        """Show the picture that was shown last from another pixel on."""
        self._actor.SetPosition(left, bottom)
        self._actor.VisibilityOn()

    def raise_up(self) -> None:
        """Draw it after all that was added to the renderer since: VTK heeds the order only."""
        self._renderer.RemoveViewProp(self._actor)
        self._renderer.AddViewProp(self._actor)

    def hide(self) -> None:
        """Uncover the window."""
        self._actor.VisibilityOff()
