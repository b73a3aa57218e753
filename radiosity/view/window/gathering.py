"""The gathered picture of a view that rests, laid over the surfaces."""

import threading

from radiosity.scene.model import Camera
from radiosity.view import gather
from radiosity.view.image import Image
from radiosity.view.progressive import Cover, Job
from radiosity.view.tones import Tones
from radiosity.view.window.later import Later

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
        self._tones = self._toning = None  # those asked for, and a picture that is being given them
        self._shown = None  # image and tones of the picture that covers the window

    @property
    def begun(self) -> bool:
        """Return whether the view is being gathered, or is."""
        return self._job is not None

    @property
    def finished(self) -> bool:
        """Return whether the view is gathered with all samples and shown."""
        return self.begun and self._job.finished and self._is_shown()

    @property
    def progress(self) -> tuple[int, int] | None:
        """Return how many pictures came and are expected, None where nothing is waited for."""
        if not self.begun or self._job.finished:
            return None
        return self._job.done, self._job.total

    def start(self, solution, camera: Camera, tones: Tones) -> None:
        """Gather a view, in a thread."""
        self._tones = tones
        self._job = Job(solution, camera, self._samples, self._turn)

    def hear(self) -> bool:
        """Show the newest picture in its tones, which a thread finds; return whether it changed.

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
        self.image = self._job.newest() or self.image
        changed, toning = False, self._toning
        if toning is not None and toning.ready:
            self._toning = None
            if toning.error is not None:
                raise toning.error
            picture, self._shown = toning.result
            self._cover.show(picture)
            changed = True
        if self._toning is None and self.image is not None and not self._is_shown():
            image, tones = self.image, self._tones
            self._toning = Later(lambda: (tones.picture(image), (image, tones)))
        return changed

    def retone(self, tones: Tones) -> None:
        """Show the picture in other tones, soon."""
        self._tones = tones

    def _is_shown(self):
        """Return whether the newest picture is shown, in the tones asked for."""
        shown = self._shown
        return shown is not None and shown[0] is self.image and shown[1] == self._tones

    def uncover(self) -> None:
        """Show the surfaces until there is another picture."""
        self._cover.hide()
        self._shown = None

    def drop(self) -> threading.Thread | None:
        """Uncover the surfaces; return the thread, which ends within its pass, if there is one."""
        job, self._job, self.image, self._toning = self._job, None, None, None
        self.uncover()
        if job is None:
            return None
        job.stop()
        return job.thread
