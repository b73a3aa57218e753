"""Work over ranges on all cores; results do not depend on how many there are."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

Progress = Callable[[str, int, int], None]


def silent(stage: str, done: int, total: int) -> None:
    """Report nothing."""


def over_ranges(
    work: Callable[[int, int], None],
    count: int,
    chunk: int,
    stage: str = "",
    progress: Progress = silent,
) -> None:
    """Call ``work(start, stop)`` for consecutive ranges of 0..count on all cores.

    ``work`` writes to its own part of an output and releases the interpreter lock where it can.
    ``progress(stage, done, total)`` is called as ranges are finished, by the caller's thread, which
    does its share of the work.
    """
    starts = range(0, count, chunk)
    left, done = list(reversed(starts)), []

    def take():
        try:
            return left.pop()
        except IndexError:
            return None

    def labour(report):
        try:
            for a in iter(take, None):
                work(a, min(a + chunk, count))
                done.append(a)
                report(stage, len(done), len(starts))
        except BaseException:
            left.clear()
            raise

    helpers = min(core_count(), len(starts)) - 1
    if helpers < 1:
        labour(progress)
        return
    with ThreadPoolExecutor(helpers) as pool:
        try:
            others = [pool.submit(labour, silent) for _ in range(helpers)]
            labour(progress)
        except BaseException:
            left.clear()
            raise
        for other in others:
            other.result()
    progress(stage, len(done), len(starts))


def core_count() -> int:
    """Return how many cores this process may use (``RADIOSITY_THREADS`` overrides it)."""
    asked = os.environ.get("RADIOSITY_THREADS")
    if asked:
        return max(1, int(asked))
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
