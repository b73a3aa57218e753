"""Work that takes a while, in a thread of its own, so that the window never waits for it."""

import threading
from collections.abc import Callable
from typing import Any


class Later:
    """What a function returns, once it has.

    Attributes
    ----------
    error : Exception or None
        What the function raised instead.
    thread : threading.Thread

    Examples
    --------
    >>> answer = Later(lambda: 6 * 7)
    >>> answer.thread.join()
    >>> answer.ready, answer.result
    (True, 42)
    """

    def __init__(self, work: Callable[[], Any]):
        """Start the work."""
        self.result, self.error = None, None
        self._work = work
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    @property
    def ready(self) -> bool:
        """Return whether the work is done, or has failed."""
        return not self.thread.is_alive()

    def _run(self):
        try:
            self.result = self._work()
        except Exception as error:  # for the main thread to tell
            self.error = error
