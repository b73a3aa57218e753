"""The interactive window: the solution to walk around in, gathered wherever the view rests.

Moving, one sees the patches' radiosity interpolated between their corners, as fast as the
graphics allow. At rest, key ``g`` lets the final gather of the very same camera cover the window
pixel for pixel, pass by pass. A thread gathers; everything that VTK touches stays in the main
thread, which looks for news between events.
"""

import functools
import itertools
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from radiosity.scene.model import Camera
from radiosity.solve.solution import Solution
from radiosity.transport.files import written_whole
from radiosity.view import gather
from radiosity.view.camera import basis
from radiosity.view.polydata import to_pyvista
from radiosity.view.progressive import Cover, Job
from radiosity.view.shading import auto_exposure
from radiosity.view.standpoint import current_camera, look_from
from radiosity.view.tones import Tones

if TYPE_CHECKING:
    from radiosity.view.falsecolour import Scale

REST = 0.3  # seconds without movement after which a view is gathered
TICK = 0.01  # seconds between two looks for events and news
PARTING = 0.5  # seconds that closing waits for the thread, which ends after its pass
FILL = 0.9  # of the screen that a window takes at most, unless a size is asked for
HELP = "drag turns, wheel zooms   g gather  c camera  e edges  r reset  s save  q quit"

_PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
name = window.GetClassName()
print("EGL" not in name and "OSOpenGL" not in name and "OSMesa" not in name
      and bool(window.SupportsOpenGL()))
"""


def show(
    solution: Solution,
    camera: Camera | str | None = None,
    size: tuple[int, int] | None = None,
    off_screen: bool = False,
    samples: int | None = None,
    exposure: float | None = None,
    scale: "Scale | None" = None,
) -> np.ndarray | None:
    """Show a solution until the user closes the window; in a notebook, its picture inline.

    Parameters
    ----------
    solution : Solution
    camera : Camera or str, optional
        Where to start: one of the scene's by name, its first by default.
    size : (w, h), optional
        Pixels, instead of the camera's own.
    off_screen : bool
        Open nothing and return what the window would show at first.
    samples : int, optional
        Rays over each pixel's hemisphere that a gathered view ends with; by default the accuracy of
        the solution decides.
    exposure : float, optional
        Display value per radiance, instead of the automatic one.
    scale : Scale, optional
        Of `radiosity.view.falsecolour`: luminance in false colours instead, with the scale.

    Returns
    -------
    (h, w, 3) uint8 or None
        The picture, if ``off_screen``.

    Raises
    ------
    ValueError
        No such camera, one that cannot look, or a number of samples out of range.
    RuntimeError
        There is no display.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1)
    >>> show(solution, size=(64, 48), off_screen=True).shape
    (48, 64, 3)
    """
    tones = Tones(auto_exposure(solution) if exposure is None else exposure, scale)
    window = Window(solution, camera, size, samples=samples, off_screen=off_screen, tones=tones)
    try:
        return window.screenshot() if off_screen else window.run()
    finally:
        window.close()


plot = show  # its name in ``import radiosity``


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


class Window:
    """A pyvista window on a solution.

    Attributes
    ----------
    plotter : pyvista.Plotter
    gathering : bool
        Whether resting views are gathered.
    edges : bool
        Whether the patches' edges are drawn.
    """

    def __init__(
        self,
        solution: Solution,
        camera: Camera | str | None = None,
        size: tuple[int, int] | None = None,
        *,
        samples: int | None = None,
        off_screen: bool = False,
        tones: Tones | None = None,
    ):
        """Build the window, without entering its loop; see `show` for the parameters."""
        import pyvista

        self._solution, self._samples = solution, samples
        self._tones = tones or Tones(auto_exposure(solution))
        self._home = gather.find_camera(solution.scene, camera)
        basis(self._home)  # refuses a camera that cannot look
        gather.pass_count(samples)  # refuses a number out of range
        self.gathering = self.edges = False
        self._turn, self._job = threading.Lock(), None
        self.plotter = pyvista.Plotter(
            off_screen=off_screen, window_size=size or self._home.size, lighting="none",
            title=f"{solution.scene.name or 'scene'} - radiosity",
        )  # fmt: skip
        if not self.plotter.off_screen:
            _check_display()
            if not size:
                _fit_to_screen(self.plotter.render_window)
        self.plotter.enable_anti_aliasing("msaa", multi_samples=4)
        self._add_surfaces(self._tones.shown)
        self._cover, self._bar = (Cover(self.plotter.renderer, layer) for layer in (0, 1))
        self._help, self._note = self._text(HELP, 8), self._text("", 28)
        self._reset()
        self._bind_keys()
        self._seen, self._since = self._view(), time.monotonic()
        self._place_scale(self._seen[-2:])
        self.plotter.renderer.AddObserver("StartEvent", lambda *_: self._follow())
        inline = {"jupyter_backend": "static"} if self.plotter.notebook else {}
        self.plotter.show(interactive=False, auto_close=False, **inline)

    def run(self) -> None:
        """Let the user look around until the window is closed.

        VTK's own loop would hold the interpreter lock while it waits, and starve the thread.
        """
        if self.plotter.off_screen:
            return
        while self.plotter.iren is not None and not self.plotter.iren.interactor.GetDone():
            self.plotter.iren.process_events()
            self.tick()
            time.sleep(TICK)

    def tick(self) -> None:
        """Do what is due: start to gather a view that rests, or show its latest pass.

        Raises
        ------
        Exception
            What ended the gathering, which is then off.
        """
        self._follow()
        if not self.gathering:
            return
        if self._job is None:
            if time.monotonic() - self._since >= REST:
                camera = current_camera(self.plotter, "window")
                self._job = Job(self._solution, camera, self._samples, self._turn, self._tones)
                self._tell()
            return
        if self._job.error is not None:
            error = self._job.error
            self._toggle_gathering()
            raise error
        picture = self._job.newest()
        if picture is not None:
            self._cover.show(picture)
            self._tell()

    @property
    def finished(self) -> bool:
        """Return whether the view is gathered with all samples and shown."""
        return self._job is not None and self._job.finished and self._cover.visible

    def screenshot(self) -> np.ndarray:
        """Return what the window shows, (h, w, 3) uint8 rows from the top, without its texts."""
        shown = [a.GetVisibility() for a in (self._help, self._note)]
        self._help.VisibilityOff()
        self._note.VisibilityOff()
        self.plotter.render()
        pixels = np.asarray(self.plotter.screenshot(return_img=True))[:, :, :3].copy()
        for actor, was in zip((self._help, self._note), shown, strict=True):
            actor.SetVisibility(was)
        self.plotter.render()
        return pixels

    def close(self) -> None:
        """Close the window, then stop the thread; an unfinished pass runs out by itself."""
        job, self.gathering = self._job, False
        self._drop()
        self.plotter.close()
        if job is not None:
            job.thread.join(PARTING)

    def _add_surfaces(self, display):
        """Add the solved patches, seen from their active sides only, and what is behind them."""
        mesh = to_pyvista(self._solution)
        to_rgb = self._solution.scene.bands.to_rgb
        corners = mesh.point_data["radiosity_W_m2"].reshape(mesh.n_points, -1)
        mesh.point_data["shown"] = display(to_rgb(corners) / np.pi)
        self._surfaces = self.plotter.add_mesh(
            mesh, scalars="shown", rgb=True, lighting=False, culling="back",
            edge_color="#404448", line_width=1, reset_camera=False, show_scalar_bar=False,
        )  # fmt: skip
        outside = to_rgb(self._solution.surroundings.field.outside) / np.pi
        self.plotter.set_background([int(v) for v in display(outside)])

    def _place_scale(self, size):
        """Lay the scale of false colours over the right edge of a window of so many pixels."""
        if self._tones.scale is None:
            return
        from radiosity.view.falsecolour import bar

        strip = bar(self._tones.scale, size[1], over=True, under=self._tones.scale.minimum > 0)
        self._bar.show(strip, size[0] - strip.shape[1])

    def _text(self, words, height):
        actor = self.plotter.add_text(
            words, position=(8, height), font_size=6, color="#f0f0f0", render=False
        )
        actor.prop.background_color, actor.prop.background_opacity = "black", 0.6
        actor.SetLayerNumber(1)  # above the picture
        return actor

    def _bind_keys(self):
        """Answer our keys and none of VTK's own, which would leave, reset or restyle.

        Dragging turns about the camera's up, so that verticals stay upright.
        """
        self.plotter.enable_terrain_style(mouse_wheel_zooms=True, shift_pans=True)
        self.plotter.iren.clear_key_event_callbacks()
        for key, action in {
            "c": self._next_camera,
            "e": self._toggle_edges,
            "g": self._toggle_gathering,
            "r": self._reset,
            "s": self._save,
            "q": self._quit,
        }.items():
            for symbol in (key, key.upper()):
                self.plotter.iren.add_key_event(symbol, action)
        self.plotter.iren.style.AddObserver("CharEvent", lambda *_: None)

    def _view(self):
        """Return all that decides what a pixel shows."""
        c = current_camera(self.plotter, "")
        return (*c.position, *c.target, *c.up, c.fov, c.height, *c.size)

    def _follow(self):
        """Uncover the moving surfaces, and stop gathering what is no longer looked at."""
        view = self._view()
        if view != self._seen:
            if view[-2:] != self._seen[-2:]:
                self._place_scale(view[-2:])
            self._seen, self._since = view, time.monotonic()
            self._drop()

    def _drop(self):
        """Forget the gathered picture and stop the thread that makes it."""
        if self._job is not None:
            self._job.stop()
            self._job = None
        self._cover.hide()
        self._write_note()

    def _tell(self):
        self._write_note()
        self.plotter.render()

    def _write_note(self):
        """Show how far the gathering is; no words over a finished picture."""
        job = self._job
        waiting = job is not None and not job.finished
        self._note.SetInput(f"gathering {job.done} of {job.total}" if waiting else "")
        self._note.SetVisibility(waiting)
        self._help.SetVisibility(not (self._cover.visible or self.plotter.notebook))

    def _toggle_edges(self):
        """Switch the edges of the patches, leaving a gathered picture, which has none."""
        self.edges = not self.edges
        self._surfaces.prop.show_edges = self.edges
        if self.edges and self.gathering:
            self.gathering = False
            self._drop()
        self.plotter.render()

    def _toggle_gathering(self):
        """Switch the gathering of resting views; the first starts at once."""
        self.gathering = not self.gathering
        self._since = -REST
        self._drop()
        self.plotter.render()

    def _reset(self):
        """Look from the scene's camera, turning about a point within the scene."""
        look_from(self.plotter, self._home, self._solution.scene.faces.vertices)
        self.plotter.render()

    def _next_camera(self):
        """Look from the scene's next camera, to which a reset then returns."""
        cameras = list(self._solution.scene.cameras.values())
        here = [k for k, camera in enumerate(cameras) if camera is self._home]
        if cameras:
            self._home = cameras[(here[0] + 1) % len(cameras) if here else 0]
            self._reset()

    def _save(self):
        """Write what the window shows as a PNG file into the current folder."""
        import imageio.v3

        scene = self._solution.scene
        stem = Path(scene.source).stem or "radiosity"
        names = (f"{stem}-{k}.png" for k in itertools.count(1))
        place = next(p for p in map(Path, names) if not p.exists())
        try:
            with written_whole(place) as temporary:
                imageio.v3.imwrite(temporary, self.screenshot(), extension=".png")
        except OSError as error:
            print(f"not saved: {error}", file=sys.stderr)
        else:
            print(f"saved {place.resolve()}", file=sys.stderr)

    def _quit(self):
        self.gathering = False
        self._drop()
        self.plotter.iren.terminate_app()


def _check_display():
    if not display_available():
        raise RuntimeError(
            f"no window can be opened: DISPLAY = {os.environ.get('DISPLAY', '')!r} has no screen "
            "with OpenGL; render the camera into a file instead, or show with off_screen=True"
        )


def _fit_to_screen(window):
    """Shrink a window that would not fit on the screen, keeping its proportions."""
    size, screen = np.array(window.GetSize()), np.array(window.GetScreenSize())
    if np.all(screen > 0):
        size = size * min(1.0, *(FILL * screen / size))
        window.SetSize(*(max(1, int(v)) for v in size))
