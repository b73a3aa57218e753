"""The command line: one verb a file, and every error in one clear message."""

import os
import signal
import sys

import typer

from radiosity.cli.formfactors import formfactors
from radiosity.cli.info import info
from radiosity.cli.materials import materials
from radiosity.cli.plan import plan
from radiosity.cli.probe import probe
from radiosity.cli.render import render
from radiosity.cli.report import report
from radiosity.cli.solve import solve
from radiosity.cli.tradeoff import tradeoff
from radiosity.cli.verify import verify
from radiosity.cli.view import view

app = typer.Typer(
    name="radiosity",
    help="Radiosity that reaches the accuracy you ask for and says what it reached.",
    epilog="Start with: radiosity view scenes/cornell_box.toml",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for verb in (
    view, solve, render, probe, report, plan, tradeoff, formfactors, verify, info, materials,
):  # fmt: skip
    app.command()(verb)


class Interrupted(BaseException):
    """Ctrl-C; not a KeyboardInterrupt, which the argument parser would turn into exit code 1."""


def run() -> None:
    """Run the command line; exit codes as documented (0, 1, 2, 3, 130)."""
    signal.signal(signal.SIGINT, _interrupt)
    try:
        app()
    except Interrupted:
        _stop("interrupted; nothing half-written is left", 130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except (ValueError, OSError) as error:
        _stop(_told(error), 2)
    except MemoryError:
        _stop("out of memory: use a larger --accuracy or a coarser --mesh", 3)
    except RuntimeError as error:
        from radiosity.solve.plan import Refused

        if isinstance(error, Refused):
            _stop(str(error), 3)
        from radiosity.solve.methods import NotConverged  # numba takes a second
        from radiosity.transport.closure import NotClosable

        if isinstance(error, NotConverged):
            _stop(str(error), 1)
        if isinstance(error, NotClosable):
            _stop(f"{error}; radiosity formfactors --raw writes them as they are", 1)
        raise


def _interrupt(signum, frame):
    raise Interrupted


def _told(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def _stop(message: str, code: int) -> None:
    print(f"radiosity: {message}", file=sys.stderr)
    sys.exit(code)
