"""Colours and progress bars: on a terminal that has them, and not where they are not wanted."""

import os
import re
import subprocess
import sys

import pytest
from test_cli import CORNELL

pty = pytest.importorskip("pty", reason="needs pseudo-terminals")
COLOUR = re.compile(r"\x1b\[[0-9;]*(?:3[0-7]|38|4[0-7]|48|9[0-7])[0-9;]*m")
BAR = "━"


def on_a_terminal(*words, **env):
    """Return what the command line writes to stderr, which is a terminal, and to stdout."""
    master, slave = pty.openpty()
    plain = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "FORCE_COLOR")}
    process = subprocess.Popen(
        [sys.executable, "-m", "radiosity", *words], stdout=subprocess.PIPE, stderr=slave,
        stdin=subprocess.DEVNULL, env={**plain, "TERM": "xterm-256color", **env},
    )  # fmt: skip
    os.close(slave)
    told = b""
    while True:
        try:
            part = os.read(master, 65536)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        told += part
    os.close(master)
    out = process.stdout.read().decode()
    process.wait(timeout=60)
    assert process.returncode == 0, told
    return told.decode(), out


SOLVE = "solve", CORNELL, "--accuracy", "0.1"


def test_bars_have_colours_and_go_to_stderr():
    told, out = on_a_terminal(*SOLVE)
    assert BAR in told and COLOUR.search(told)
    assert "\x1b" not in out and BAR not in out and "power in W" in out


@pytest.mark.parametrize(
    ("words", "env", "bars"),
    [((), {"NO_COLOR": "1"}, True), ((), {"TERM": "dumb"}, False), (("--quiet",), {}, False)],
)
def test_no_colours_where_they_are_not_wanted(words, env, bars):
    told, _ = on_a_terminal(*SOLVE, *words, **env)
    assert not COLOUR.search(told)
    assert (BAR in told) == bars
    assert bars or "\x1b" not in told


def test_help_and_errors_are_plain_text():
    told, out = on_a_terminal("--help")
    assert "\x1b" not in told + out and "Exit codes:" in out
