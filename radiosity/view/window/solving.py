"""Work in a thread of its own, such as a solve: how far it is, what was found, a way to end it."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from radiosity.solve.solution import Solution
from radiosity.transport.threads import Progress

SOON, LITTLE = 0.5, 0.02  # seconds and share of a stage before its time left is told
SILENT = 4.0  # seconds without a report after which a stage is over: something else is done


class Stopped(BaseException):
    """Ends a solve that nobody waits for; no Exception, so that nothing takes it for an error."""


@dataclass(frozen=True)
class Stage:
    """How much of a part of the work is done; when it began, and when that was told."""

    name: str
    done: int
    total: int
    begun: float
    told: float

    @property
    def share(self) -> float:
        """Return what is done of the stage, 0 to 1."""
        return self.done / max(self.total, 1)

    def over(self, now: float) -> bool:
        """Return whether something else seems to be done now."""
        return self.done >= self.total or now - self.told > SILENT

    def left(self) -> float | None:
        """Return the seconds that the stage takes still at its pace, None where it is too early."""
        spent = self.told - self.begun
        if spent < SOON or self.share < LITTLE:
            return None
        return spent * (self.total - self.done) / self.done


class Solving:
    """A solve that a window shows, or other work that tells how far it is.

    Attributes
    ----------
    error : Exception or None
        What ended it.
    stage : Stage or None
        What it is at.
    newest : Solution, other result or None
        The latest that was found; when `ready`, the answer.
    thread : threading.Thread
    """

    def __init__(self, solve: Callable[[Progress, Callable[[Solution], None]], Solution]):
        """Make ready to ``solve(progress, watch)``, which returns the answer."""
        self.error = self.stage = self.newest = None
        self._solve, self._stopped, self._done = solve, threading.Event(), threading.Event()
        self.thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        """Start to solve."""
        self.thread.start()

    @property
    def ready(self) -> bool:
        """Return whether there is an answer, or an error."""
        return self._done.is_set()

    def stop(self, patience: float) -> None:
        """Let the solve end at its next report, and wait for that for some seconds."""
        self._stopped.set()
        if self.thread.is_alive():
            self.thread.join(patience)

    def _run(self):
        try:
            self.newest = self._solve(self._progress, self._watch)
        except Stopped:
            pass
        except Exception as error:  # for the main thread to raise
            self.error = error
        finally:
            self._done.set()

    def _progress(self, name, done, total):
        self._go_on()
        before, now = self.stage, time.monotonic()
        again = before is None or before.name != name or done < before.done
        self.stage = Stage(name, done, total, now if again else before.begun, now)

    def _watch(self, solution):
        self._go_on()
        self.newest = solution

    def _go_on(self):
        if self._stopped.is_set():
            raise Stopped
