"""The gathered picture of a view that rests, laid over the surfaces."""

import threading

from radiosity.scene.model import Camera
from radiosity.view import gather
from radiosity.view.image import Image
from radiosity.view.progressive import Cover, Job
from radiosity.view.tones import Tones

REST = 0.5  # seconds without movement after which a view is gathered


class Gathering:
    """One view being gathered, pass by pass.

    Attributes
    ----------
    image : Image or None
        Linear radiance of the newest picture, None where none is shown.
    """

    def __init__(self, renderer, samples: int | None):
        """Gather nothing as yet; ``samples`` as `radiosity.view.gather.render` takes them."""
        gather.pass_count(samples)  # refuses a number out of range
        self._cover, self._samples = Cover(renderer, 0), samples
        self._turn, self._job = threading.Lock(), None
        self.image: Image | None = None

    @property
    def begun(self) -> bool:
        """Return whether the view is being gathered, or is."""
        return self._job is not None

    @property
    def finished(self) -> bool:
        """Return whether the view is gathered with all samples and shown."""
        return self.begun and self._job.finished and self._cover.visible

    @property
    def progress(self) -> tuple[int, int] | None:
        """Return how many pictures came and are expected, None where nothing is waited for."""
        if not self.begun or self._job.finished:
            return None
        return self._job.done, self._job.total

    def start(self, solution, camera: Camera) -> None:
        """Gather a view, in a thread."""
        self._job = Job(solution, camera, self._samples, self._turn)

    def hear(self, tones: Tones) -> bool:
        """Show the newest picture; return whether there was a new one.

        Raises
        ------
        Exception
            What ended the gathering.
        """
        if not self.begun:
            return False
        if self._job.error is not None:
            error = self._job.error
            self.drop()
            raise error
        image = self._job.newest()
        if image is None:
            return False
        self.image = image
        self.show(tones)
        return True

    def show(self, tones: Tones) -> None:
        """Show the picture in other tones."""
        if self.image is not None:
            self._cover.show(tones.picture(self.image))

    def drop(self) -> threading.Thread | None:
        """Uncover the surfaces; return the thread, which ends within its pass, if there is one."""
        job, self._job, self.image = self._job, None, None
        self._cover.hide()
        if job is None:
            return None
        job.stop()
        return job.thread
