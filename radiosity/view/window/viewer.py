"""The window itself: what it is made of, and the loop that keeps it up to date.

Moving, one sees the patches' radiosity interpolated between their corners, as fast as the graphics
allow. At rest the final gather of the very same camera covers the window pixel for pixel, pass by
pass. Threads compute; everything that VTK touches stays in the main thread, which looks for news
between events.
"""

import time
from collections.abc import Callable

import numpy as np

from radiosity.scene.model import Camera, Scene
from radiosity.solve.solution import Solution
from radiosity.view import gather
from radiosity.view.camera import basis, project
from radiosity.view.standpoint import current_camera, look_from
from radiosity.view.tones import Tones
from radiosity.view.window import gathering
from radiosity.view.window.commands import Commands
from radiosity.view.window.display import Display
from radiosity.view.window.hud import Hud
from radiosity.view.window.keys import Keyboard
from radiosity.view.window.labels import Labels
from radiosity.view.window.later import Later
from radiosity.view.window.mouse import Mouse
from radiosity.view.window.panels import Panels, note_rows
from radiosity.view.window.picking import Pick
from radiosity.view.window.screen import FILL, check_display, fit_to_screen
from radiosity.view.window.solving import Solving
from radiosity.view.window.walking import Walk

TICK = 0.01  # seconds between two looks for events and news
PAUSE = 0.15  # seconds without movement after which lines of equal value get their numbers
EVERY = 0.25  # seconds between two looks at a solve
PATIENCE = 5.0  # times as long as showing what was found so far took, before it is shown again
PARTING = 0.5  # seconds that closing waits for a thread that gathers, which ends after its pass
LAST_REPORT = 30.0  # seconds that closing waits for a solve, which ends at its next report
MESSAGE = 6.0  # seconds that a message stays


class Window:
    """A pyvista window on a solution, or on a scene that is being solved.

    Attributes
    ----------
    plotter : pyvista.Plotter
    scene : Scene
    home : Camera
        To which a reset returns.
    display : Display
        The surfaces.
    gathered : Gathering
        The picture that covers them at rest.
    gathering : bool
        Whether resting views are gathered.
    pick : Pick
        The point that is read.
    hud, panels : Hud, Panels
        What lies over all.
    walk : Walk
    mouse : Mouse
    commands : Commands
    """

    def __init__(
        self,
        of: Solution | Scene,
        camera: Camera | str | None = None,
        size: tuple[int, int] | None = None,
        *,
        samples: int | None = None,
        off_screen: bool = False,
        tones: Callable[[Solution], Tones] | None = None,
        solving: Solving | None = None,
    ):
        """Build the window, without entering its loop; see `show` for the parameters.

        Of a Scene, it shows what ``solving`` has found so far. ``tones(solution)`` are those that
        it begins with.
        """
        import pyvista

        self.scene, self._solving = getattr(of, "scene", of), solving
        self.home = gather.find_camera(self.scene, camera)
        basis(self.home)  # refuses a camera that cannot look
        gather.pass_count(samples)  # refuses a number out of range
        if not (off_screen or pyvista.OFF_SCREEN):
            check_display()
        self.plotter = pyvista.Plotter(
            off_screen=off_screen, window_size=size or self.home.size, lighting="none",
            title=f"{self.scene.name or 'scene'} - radiosity",
        )  # fmt: skip
        if not self.plotter.off_screen:
            fit_to_screen(self.plotter.render_window, 1.0 if size else FILL)
        self.plotter.enable_anti_aliasing("msaa", multi_samples=4)
        self.display = Display(self.plotter, self.scene, self.home, tones)
        self.gathered = gathering.Gathering(self.plotter.renderer, samples)
        self.gathering, self.pick, self.hud = True, Pick(), Hud(self.plotter.renderer)
        self.panels, self._saving, self._message = Panels(self.hud), None, ("", 0.0)
        extent = np.linalg.norm(np.ptp(self.scene.faces.vertices, axis=(0, 1)))
        self.walk = Walk(self.plotter, self.scene.up, float(extent))
        self.commands = Commands(self)
        self._labels = Labels(self.hud)
        self._stale = self._measure_again = self._waiting = False
        self._looked = self._told = self._next = 0.0
        self.answer = self._trouble = None
        if solving is None:
            self._take(of)
        self._open()

    def _open(self):
        """Answer to keys and mouse, look from the camera and show the window.

        Dragging turns about the camera's up, so that verticals stay upright. VTK's own keys would
        leave, reset or restyle.
        """
        self.plotter.enable_terrain_style(mouse_wheel_zooms=True, shift_pans=True)
        self.plotter.iren.clear_key_event_callbacks()
        self.plotter.iren.style.AddObserver("CharEvent", lambda *_: None)
        interactor = self.plotter.iren.interactor
        Keyboard(interactor, self.commands, self.guarded)
        self.mouse = Mouse(interactor, self.commands, self.hud, self.guarded)
        look_from(self.plotter, self.home, self.scene.faces.vertices)
        self._seen, self._since = None, time.monotonic()
        self.plotter.renderer.AddObserver("StartEvent", self.guarded(self._prepare))
        inline = {"jupyter_backend": "static"} if self.plotter.notebook else {}
        self.plotter.show(interactive=False, auto_close=False, **inline)

    def run(self) -> None:
        """Let the user look around until the window is closed.

        VTK's own loop would hold the interpreter lock while it waits, and starve the threads.
        """
        if self.plotter.off_screen:
            return
        while self.plotter.iren is not None and not self.plotter.iren.interactor.GetDone():
            self.plotter.iren.process_events()
            self.tick()
            time.sleep(TICK)

    def tick(self) -> None:
        """Do what is due: walk, look for news of threads, gather a view that rests, draw.

        Raises
        ------
        Exception
            What ended a thread's work, or an observer of VTK's.
        """
        if self._trouble is not None:
            trouble, self._trouble = self._trouble, None
            raise trouble
        now = time.monotonic()
        if self.walk.moving:
            self.walk.advance(now - self._looked)
            self.changed()
        self._looked = now
        self._follow()
        if self.answer is None:
            self._hear_solver(now)
        else:
            self._hear_threads()
            self._gather(now)
        if self._message[0] and now > self._message[1]:
            self.say("")
        if self._labels.stale and now - self._since >= PAUSE and not self.mouse.sliding:
            self._label()
        if self._stale:
            self.plotter.render()

    @property
    def size(self) -> tuple[int, int]:
        """Return the window's width and height in pixels."""
        return tuple(self.plotter.render_window.GetSize())

    @property
    def finished(self) -> bool:
        """Return whether the view is gathered with all samples and shown."""
        return self.gathered.finished

    def screenshot(self) -> np.ndarray:
        """Return what the window shows, (h, w, 3) uint8 rows from the top, without its controls.

        Scales, a mark and what was read there belong to the picture.
        """
        self.panels.plain = True
        self.plotter.render()
        pixels = np.asarray(self.plotter.screenshot(return_img=True))[:, :, :3].copy()
        self.panels.plain = False
        self.plotter.render()
        return pixels

    def close(self) -> None:
        """Close the window, then stop the threads; unfinished passes run out by themselves."""
        self.gathering = False
        if self._saving is not None:
            self._saving.thread.join()  # whole files, or none
        thread = self.gathered.drop()
        self.plotter.close()
        if thread is not None:
            thread.join(PARTING)
        self.display.refining.stop(PARTING)
        if self._solving is not None:
            self._solving.stop(LAST_REPORT)

    def guarded(self, work: Callable[[], object]) -> Callable[..., object]:
        """Return an observer of VTK's that does some work.

        VTK would print and forget what it raises; the next tick raises it instead.
        """

        def observe(*_):
            try:
                return work()
            except BaseException as error:  # an interruption, too
                self._trouble = error

        return observe

    def changed(self) -> None:
        """Draw the window anew, soon."""
        self._stale = True

    def rested(self) -> None:
        """Take the view for one that has rested for long."""
        self._since = -gathering.REST

    def say(self, message: str) -> None:
        """Show a message for some seconds."""
        self._message = message, time.monotonic() + MESSAGE
        self.changed()

    def show_mode(self, mode: str) -> None:
        """Show the picture, or another quantity in false colours; see `Look`."""
        self.display.look.mode = mode
        if not self.display.look.gathers:
            self.gathered.drop()
        self.recolour()

    def recolour(self) -> None:
        """Show surfaces and gathered picture in the colours that are asked for now."""
        self.display.colour()
        self.gathered.retone(self.display.tones)
        if self.mouse.sliding:
            self.gathered.uncover()  # surfaces follow at once
        self._labels.clear()
        self.changed()

    def dim(self, name: str, factor: float) -> None:
        """Give a group of light a factor; what was gathered and read is for another light."""
        self.display.lamps.dim(name, factor)
        self.gathered.drop()
        self._since, self._measure_again = time.monotonic(), True
        self.recolour()

    def save(self, work: Callable[[], str]) -> None:
        """Let a thread write files, then show the message that it returns."""
        if self._saving is not None:
            self.say("still saving: try again in a moment")
            return
        self._saving = Later(work)
        self.say("saving \u2026")

    def _take(self, answer):
        """Show the answer, and let it be gathered and read."""
        self.answer = answer
        self.display.take(answer)
        self._since = time.monotonic()
        self.changed()

    def _hear_solver(self, now):
        """Show how far the solve is and, from time to time, what it has found."""
        solving = self._solving
        if solving.ready:
            if solving.error is not None:
                raise solving.error
            self._take(solving.newest)
            self.say("")
            return
        if now - self._told >= EVERY:
            self._told = now
            self.changed()
        found = solving.newest
        if found is not None and found is not self.display.solution and now >= self._next:
            self.display.take(found)
            self._next = time.monotonic() + PATIENCE * (time.monotonic() - now)

    def _hear_threads(self):
        """Show what threads have found, and ask for what is missing."""
        display, lamps = self.display, self.display.lamps
        self._hear_lamps()
        if self.pick.hear():
            self.changed()
        self._refine()
        if self._saving is not None and self._saving.ready:
            done, self._saving = self._saving, None
            if done.error is not None:
                raise done.error
            self.say(done.result)
        if display.look.mode == "error" and display.scale is None and not display.estimating:
            self.recolour()
        settled = not (lamps.waiting or self.mouse.sliding or self.pick.measuring)
        if self._measure_again and settled:
            self._measure_again = False
            self.pick.measure(lamps.solution)
            if display.look.mode == "error":
                display.estimate()
                self.recolour()

    def _refine(self):
        """Show illuminance on the fine mesh as soon as that is there, and how far it is."""
        if self.display.refine():
            self.recolour()
        elif self.display.refining.share is not None and self._looked - self._told >= EVERY:
            self._told = self._looked
            self.changed()

    def _hear_lamps(self):
        """Show the light that was asked for as soon as its groups are told apart."""
        lamps = self.display.lamps
        if lamps.trouble is not None:
            raise lamps.trouble
        if self._waiting and not lamps.waiting:
            self.recolour()
        self._waiting = lamps.waiting

    @property
    def _gathers(self):
        """Whether what is shown is gathered when it rests."""
        display = self.display
        return self.gathering and display.look.gathers and not display.surfaces.edges

    def _gather(self, now):
        """Start to gather a view that rests, or show its latest pass."""
        if not self._gathers:
            return
        try:
            if not self.mouse.sliding and self.gathered.hear():
                self.changed()
        except Exception:
            self.gathering = False
            raise
        held = self.mouse.sliding or self.display.lamps.waiting
        if not self.gathered.begun and not held and now - self._since >= gathering.REST:
            camera = current_camera(self.plotter, "window")
            self.gathered.start(self.display.lamps.solution, camera, self.display.tones)
            self.changed()

    def _view(self):
        """Return all that decides what a pixel shows."""
        c = current_camera(self.plotter, "")
        return (*c.position, *c.target, *c.up, c.fov, c.height, *c.size)

    def _follow(self):
        """Uncover the moving surfaces, and stop gathering what is no longer looked at."""
        view = self._view()
        if view != self._seen:
            self._seen, self._since = view, time.monotonic()
            self.gathered.drop()
            self._labels.clear()
            self.changed()

    def _label(self):
        """Write their values on the lines that are seen, which a gathered picture would cover."""
        display = self.display
        middles, places = display.surfaces.lines()
        if self._gathers or not len(middles):
            self._labels.stale = False
            return
        self.plotter.render()  # so that all panels are where they will be
        camera = current_camera(self.plotter, "window")
        values = np.round(display.scale.luminance(places), 9)
        self._labels.place(display.lamps.solution, camera, middles, values)
        self.changed()

    def _prepare(self):
        """Bring all that depends on the view up to date, before it is drawn."""
        self._follow()
        self._stale, size = False, self.size
        camera = current_camera(self.plotter, "window")
        forward = basis(camera)[2] if camera.orthographic else None
        self.display.surfaces.follow(camera.position, forward)
        at = None
        if self.pick.place is not None:
            at = project(camera, size, self.pick.place.point[None])[0][0]
        self.panels.mark(size, None if at is None or np.isnan(at).any() else at)
        if not self.plotter.notebook:
            stage = None if self.answer is not None else self._solving.stage
            self.panels.draw(size, self, note_rows(self, stage, self._message[0]))
