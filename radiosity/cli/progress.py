"""Progress bars with time left, and remarks; both on stderr."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from radiosity.transport.threads import Progress, silent


@contextmanager
def progress_bars(quiet: bool) -> Iterator[Progress]:
    """Yield a function ``(stage, done, total)`` that draws a bar a stage on a terminal.

    rich draws none where the cursor cannot be moved (``TERM=dumb``), and no colours where
    ``NO_COLOR`` is set.
    """
    if quiet or not sys.stderr.isatty():
        yield silent
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = TextColumn("{task.description:14}"), BarColumn(), TimeElapsedColumn()
    with Progress(
        *columns, TextColumn("left"), TimeRemainingColumn(),
        console=Console(stderr=True), transient=True,
    ) as bars:  # fmt: skip
        tasks = {}

        def report(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=total)
            bars.update(tasks[stage], completed=done, total=total)

        yield report


def remark(text: str, quiet: bool = False) -> None:
    """Say something that is not a result."""
    if not quiet:
        print(text, file=sys.stderr)
