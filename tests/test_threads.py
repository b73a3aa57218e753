"""Work over ranges: each once, in any order; progress in the caller's thread; errors end it."""

import threading
import time

import numpy as np
import pytest

from radiosity.transport import threads as module
from radiosity.transport.threads import over_ranges


@pytest.fixture(params=["1", "2", "5"], autouse=True)
def threads(request, monkeypatch):
    monkeypatch.setenv("RADIOSITY_THREADS", request.param)
    return int(request.param)


@pytest.mark.parametrize("count", [0, 1, 10, 1000, 1001])
def test_every_range_is_worked_on_once(count):
    times = np.zeros(count, int)

    def work(a, b):
        assert b - a == 10 or b == count
        times[a:b] += 1

    over_ranges(work, count, 10)
    assert np.all(times == 1)


def test_progress_grows_to_the_end_in_the_callers_thread():
    seen = []

    def progress(stage, done, total):
        assert threading.current_thread() is threading.main_thread()
        seen.append((stage, done, total))

    over_ranges(lambda a, b: None, 95, 10, "rows", progress)
    assert {(stage, total) for stage, _, total in seen} == {("rows", 10)}
    done = [done for _, done, _ in seen]
    assert done == sorted(done) and done[-1] == 10


def test_all_threads_work(threads):
    together = threading.Barrier(threads, timeout=60)
    over_ranges(lambda a, b: together.wait(), threads, 1)


@pytest.mark.parametrize("wrong", [IndexError, KeyboardInterrupt])
def test_an_error_is_raised_and_ends_the_work(wrong, threads):
    calls = []

    def work(a, b):
        calls.append(a)
        time.sleep(1e-3)
        if a == 3:
            raise wrong("no")

    with pytest.raises(wrong, match="no"):
        over_ranges(work, 100_000, 1)
    assert len(calls) < 50_000


def test_an_error_of_the_progress_ends_the_work():
    def progress(stage, done, total):
        raise KeyboardInterrupt

    calls = []

    def work(a, b):
        calls.append(a)
        time.sleep(1e-3)

    with pytest.raises(KeyboardInterrupt):
        over_ranges(work, 100_000, 1, "rows", progress)
    assert len(calls) < 50_000


def test_a_thread_that_cannot_start_ends_the_work(monkeypatch):
    def refuse(*_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setenv("RADIOSITY_THREADS", "2")
    monkeypatch.setattr(module.ThreadPoolExecutor, "submit", refuse)
    calls = []
    with pytest.raises(RuntimeError, match="start new thread"):
        over_ranges(lambda a, b: calls.append(a), 1000, 1)
    assert calls == []
