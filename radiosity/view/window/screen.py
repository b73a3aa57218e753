"""The screen: whether a window can be opened on it, and how large one may be."""

import functools
import os
import subprocess
import sys

import numpy as np

FILL = 0.9  # of the screen that a window takes at most, all of it where a size is asked for

_PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
name = window.GetClassName()
print("EGL" not in name and "OSOpenGL" not in name and "OSMesa" not in name
      and bool(window.SupportsOpenGL()))
"""


@functools.cache
def display_available() -> bool:
    """Return whether a window can be opened here.

    On Linux a child process asks VTK, because a display without OpenGL ends the process that
    tries it; elsewhere there always is one.
    """
    if not sys.platform.startswith("linux"):
        return True
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    try:
        answer = subprocess.run(
            [sys.executable, "-c", _PROBE], capture_output=True, text=True, timeout=30
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return answer.returncode == 0 and answer.stdout.strip().endswith("True")


def check_display() -> None:
    """Raise RuntimeError where no window can be opened."""
    if not display_available():
        raise RuntimeError(
            f"no window can be opened: DISPLAY = {os.environ.get('DISPLAY', '')!r} has no screen "
            "with OpenGL; render the camera into a file instead, or show with off_screen=True"
        )


def fit_to_screen(window, fill: float) -> None:
    """Shrink a VTK window that would not fit on the screen, keeping its proportions."""
    size, screen = np.array(window.GetSize()), np.array(window.GetScreenSize())
    if np.all(screen > 0):
        size = size * min(1.0, *(fill * screen / size))
        window.SetSize(*(max(1, int(v)) for v in size))
