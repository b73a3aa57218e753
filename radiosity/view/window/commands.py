"""What the keys and the mouse do to the window."""

from radiosity.solve.solution import Solution
from radiosity.view.image import write
from radiosity.view.shading import auto_exposure
from radiosity.view.standpoint import current_camera, look_from
from radiosity.view.window.lamps import FULL
from radiosity.view.window.look import RANGE
from radiosity.view.window.saving import save_all, write_png

NEXT = {"picture": "illuminance", "illuminance": "luminance"}  # mode; after others the picture


class Commands:
    """The commands of a window, by the names that `radiosity.view.window.keys` calls them."""

    def __init__(self, window):
        """Command a `radiosity.view.window.Window`."""
        self._window = window

    def walk(self, key: str) -> None:
        """Walk in a key's direction, until `halt`."""
        window = self._window
        if not window.walk.on:
            window.say("walking: drag looks around, o turns the scene again")
        window.walk.press(key)
        window.changed()

    def halt(self, key: str) -> None:
        """Walk no more in a key's direction."""
        self._window.walk.release(key)

    def look_around(self, dx: float, dy: float) -> bool:
        """Turn the eyes of one who walks, by parts of the window's height to the right and up.

        Returns whether one walks.
        """
        if self._window.walk.on:
            self._window.walk.look(dx, dy)
            self._window.changed()
        return self._window.walk.on

    def orbit(self) -> None:
        """Turn the scene by dragging, about a point within it."""
        window = self._window
        window.walk.stop()
        here = current_camera(window.plotter, "here")
        look_from(window.plotter, here, window.scene.faces.vertices)
        window.say("dragging turns the scene")

    def reset(self) -> None:
        """Look from the scene's camera, turning about a point within the scene."""
        window = self._window
        window.walk.stop()
        look_from(window.plotter, window.home, window.scene.faces.vertices)
        window.changed()

    def next_camera(self) -> None:
        """Look from the scene's next camera, to which a reset then returns."""
        cameras = list(self._window.scene.cameras.values())
        here = [k for k, camera in enumerate(cameras) if camera is self._window.home]
        if cameras:
            self._window.home = cameras[(here[0] + 1) % len(cameras) if here else 0]
            self.reset()

    def next_mode(self) -> None:
        """Show illuminance, then luminance in false colours, then the picture again."""
        self._window.show_mode(NEXT.get(self._window.display.look.mode, "picture"))

    def toggle_error(self) -> None:
        """Show the estimated error in false colours, or the picture again."""
        window = self._window
        if window.display.look.mode == "error":
            window.show_mode("picture")
        elif window.answer is None:
            window.say("no error is known before the answer is")
        elif not isinstance(window.answer, Solution):
            window.say("no error is known: nothing was solved for")
        else:
            window.display.estimate()
            window.show_mode("error")

    def toggle_logarithmic(self) -> None:
        """Switch false colours between a linear and a logarithmic scale."""
        look = self._window.display.look
        look.logarithmic = not look.logarithmic
        self._window.recolour()

    def toggle_isolines(self) -> None:
        """Draw lines of equal value over false colours, or leave them out."""
        look = self._window.display.look
        look.isolines = not look.isolines
        self._window.recolour()

    def brighter(self) -> None:
        """Expose for half a stop more, or give the scale a higher end."""
        self._window.display.look.step(up=True)
        self._window.recolour()

    def darker(self) -> None:
        """Expose for half a stop less, or give the scale a lower end."""
        self._window.display.look.step(up=False)
        self._window.recolour()

    def adapt(self) -> None:
        """Take the exposure or the scale that suits the light that there is."""
        display = self._window.display
        if display.lamps is not None:
            display.look.adapt(auto_exposure(display.lamps.solution))
            self._window.recolour()

    def switch_light(self, number: int) -> None:
        """Switch a group of lights off, or on again, counted from 0."""
        lamps = self._window.display.lamps
        if self._window.answer is not None and number < len(lamps.names):
            name = lamps.names[number]
            self._window.dim(name, lamps.switched(name))

    def toggle_edges(self) -> None:
        """Draw the edges of the patches, over the surfaces alone, or leave them out."""
        surfaces = self._window.display.surfaces
        surfaces.show_edges(not surfaces.edges)
        self._window.gathered.drop()
        self._window.recolour()

    def toggle_gathering(self) -> None:
        """Switch the gathering of resting views; the first starts at once."""
        window = self._window
        window.gathering = not window.gathering
        window.gathered.drop()
        window.say("views are gathered at rest" if window.gathering else "views are not gathered")
        window.recolour()
        window.rested()

    def toggle_panels(self) -> None:
        """Hide sliders and lists, or show them again."""
        self._window.panels.shown = not self._window.panels.shown
        self._window.changed()

    def toggle_help(self) -> None:
        """Show the list of keys, or take it away."""
        self._window.panels.help = not self._window.panels.help
        self._window.changed()

    def dismiss(self) -> None:
        """Take away the help, or else the point that was read."""
        if self._window.panels.help:
            self._window.panels.help = False
        else:
            self._window.pick.clear()
        self._window.changed()

    def pick(self, x: float, y: float) -> None:
        """Read the point that a pixel shows, in pixels from the left and the top."""
        window = self._window
        if window.answer is None:
            window.say("nothing can be read before the answer is known")
            return
        camera = current_camera(window.plotter, "window")
        window.pick.take(window.display.lamps.solution, camera, x, y)
        window.changed()

    def pick_under_pointer(self) -> None:
        """Read the point under the mouse."""
        self.pick(*self._window.mouse.position())

    def use(self, name: str, value: float | None) -> None:
        """Do what a control of a panel is for; sliders have a value, 0 to 1."""
        window, (kind, _, which) = self._window, name.partition(" ")
        if kind == "exposure":
            window.display.look.expose((2.0 * value - 1.0) * RANGE)
            window.recolour()
        elif kind == "lamp":
            window.dim(which, round(value * FULL, 2))
        elif kind == "camera":
            window.home = window.scene.cameras[which]
            self.reset()

    def save_screen(self) -> None:
        """Write what the window shows as a PNG file into the current folder."""
        pixels = self._window.screenshot()
        writers = {".png": lambda place: write_png(pixels, place)}
        self._window.say(save_all(self._window.scene.source, writers))

    def save_light(self) -> None:
        """Write the gathered radiance (EXR) and the solution (radsol) into the current folder."""
        from radiosity.view.export import save

        window, image, writers = self._window, self._window.gathered.image, {}
        if window.display.lamps.waiting:
            window.say("the lamps are being told apart: save again in a moment")
            return
        if image is not None:
            writers[".exr"] = lambda place: write(image, place)
        if isinstance(window.answer, Solution):
            lit = window.display.lamps.solution
            writers[".radsol"] = lambda place: save(lit, place)
        if writers:
            window.save(lambda: save_all(window.scene.source, writers))
        else:
            window.say("nothing to save as yet: the answer is not known")

    def quit(self) -> None:
        """End the loop."""
        self._window.gathering = False
        self._window.gathered.drop()
        self._window.plotter.iren.terminate_app()
