"""A virtual screen with real key and mouse events: Xvfb and xdotool."""

import contextlib
import os
import shutil
import subprocess
import time

import numpy as np
import pytest


class Screen:
    """A screen of an X server of its own, whose pixels lie in a file."""

    def __init__(self, display, frame):
        self.display, self._frame = display, frame
        self.environment = os.environ | {"DISPLAY": f":{display}"}

    def xdotool(self, *words):
        """Send events, as ``xdotool`` takes them."""
        command = ["xdotool", *map(str, words)]
        subprocess.run(command, env=self.environment, check=True, timeout=20, capture_output=True)

    def key(self, *names):
        self.xdotool("key", "--delay", 30, *names)

    def click(self, x, y):
        self.xdotool("mousemove", x, y, "click", 1)

    def drag(self, start, stop):
        self.xdotool("mousemove", *start, "mousedown", 1)
        time.sleep(0.1)
        self.xdotool("mousemove", *stop)
        time.sleep(0.1)
        self.xdotool("mouseup", 1)

    def pixels(self):
        """Return what is on the screen, (h, w, 3) uint8: the server's frame, in XWD format."""
        raw = self._frame.read_bytes()
        header = np.frombuffer(raw[:100], ">u4")
        size, width, height, bits, colours = header[[0, 4, 5, 11, 19]].astype(int)
        assert bits == 32
        data = np.frombuffer(raw[size + 12 * colours :], np.uint8, height * width * 4)
        return data.reshape(height, width, 4)[:, :, 2::-1].copy()

    def until(self, condition, what, limit=120.0):  # the first run compiles
        """Return the first pixels that meet a condition."""
        end = time.monotonic() + limit
        while True:
            pixels = self.pixels()
            if condition(pixels):
                return pixels
            assert time.monotonic() < end, f"the screen does not show {what}"
            time.sleep(0.05)


@contextlib.contextmanager
def virtual_screen(folder, size):
    """Start a server of so many pixels on a free display; skip, saying why, where none starts."""
    for program in ("Xvfb", "xdotool"):
        if shutil.which(program) is None:
            pytest.skip(f"no {program} on this machine, so no real window to drive")
    read, write = os.pipe()
    # Without -noreset the server starts anew when its last client leaves, and refuses meanwhile.
    command = ["Xvfb", "-displayfd", str(write), "-noreset", "-fbdir", str(folder)]
    server = subprocess.Popen(
        [*command, "-screen", "0", "{}x{}x24".format(*size)],
        pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(write)
    try:
        with os.fdopen(read) as numbers:
            display = numbers.readline().strip()
        if not display:
            pytest.skip("Xvfb does not start on this machine")
        yield Screen(display, folder / "Xvfb_screen0")
    finally:
        server.terminate()
        server.wait(10)
