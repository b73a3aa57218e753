"""The command line: one verb a file, and every error in one clear message."""

import os
import signal
import sys
from typing import Annotated

import typer
from typer.exceptions import TyperException

from radiosity.cli.formfactors import formfactors
from radiosity.cli.info import info
from radiosity.cli.materials import materials
from radiosity.cli.plan import plan
from radiosity.cli.probe import probe
from radiosity.cli.render import render
from radiosity.cli.report import report
from radiosity.cli.solve import solve
from radiosity.cli.tradeoff import tradeoff
from radiosity.cli.usage import as_typed, complaint
from radiosity.cli.verb import WIDEST, Verb, Verbs
from radiosity.cli.verify import verify
from radiosity.cli.view import view

SETTINGS = {"max_content_width": WIDEST, "help_option_names": ["-h", "--help"], "color": False}
app = typer.Typer(
    name="radiosity",
    cls=Verbs,
    invoke_without_command=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=SETTINGS,
)
for verb in (
    view, solve, render, probe, report, plan, tradeoff, formfactors, verify, info, materials,
):  # fmt: skip
    app.command(cls=Verb, context_settings=SETTINGS)(verb)


@app.callback()
def radiosity(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Radiosity that reaches the accuracy you ask for and says what it reached.

    Results go to stdout, all else to stderr; with --json stdout holds one object. NO_COLOR is
    honoured. radiosity VERB --help has the options of a verb, with examples.

    Examples
    --------
    radiosity view scenes/cornell_box.toml
    radiosity render scenes/cornell_box.toml -o cornell.png
    radiosity probe scenes/lroom.toml --grid 0.75

    Exit codes
    ----------
      0  done
      1  the accuracy that was asked was not reached (what was reached is said), or a check failed
      2  bad usage or bad input: where, the value, its bound and the way out
      3  refused: it would take more memory than allowed
    130  interrupted; nothing half-written is left
    """
    if version:
        from radiosity import __version__

        print(f"radiosity {__version__}")
    elif context.invoked_subcommand is None:
        print(context.get_help())


class Interrupted(BaseException):
    """Ctrl-C; not a KeyboardInterrupt, which the argument parser would turn into exit code 1."""


def run() -> None:
    """Run the command line; exit codes as documented (0, 1, 2, 3, 130)."""
    signal.signal(signal.SIGINT, _interrupt)
    try:
        sys.exit(app(prog_name="radiosity", standalone_mode=False))
    except Interrupted:
        _stop("interrupted; nothing half-written is left", 130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except TyperException as error:
        _stop(complaint(error), 2)
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
    return as_typed(str(error))


def _stop(message: str, code: int) -> None:
    print(f"radiosity: {message}", file=sys.stderr)
    if "--json" in sys.argv[1:]:
        from radiosity.cli.answer import print_failure

        print_failure(message, code)
    sys.exit(code)
