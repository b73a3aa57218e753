"""Work over ranges on all cores; results do not depend on how many there are."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed

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
    ``progress(stage, done, total)`` is called as ranges are finished.
    """
    starts = range(0, count, chunk)
    done = 0
    with ThreadPoolExecutor(core_count()) as pool:
        jobs = [pool.submit(work, a, min(a + chunk, count)) for a in starts]
        try:
            for job in as_completed(jobs):
                job.result()
                done += 1
                progress(stage, done, len(starts))
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def core_count() -> int:
    """Return how many cores this process may use (``RADIOSITY_THREADS`` overrides it)."""
    asked = os.environ.get("RADIOSITY_THREADS")
    if asked:
        return max(1, int(asked))
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
