"""A solution on the surfaces of the window, in the light and the colours that are asked for."""

from collections.abc import Callable

import numpy as np

from radiosity.light.photometry import illuminance, photometric
from radiosity.scene.model import Camera, Scene
from radiosity.view.falsecolour import Scale
from radiosity.view.image import tone_map
from radiosity.view.scales import error_shares, round_numbers
from radiosity.view.shading import auto_exposure
from radiosity.view.tones import Tones
from radiosity.view.window.geometry import Corners, bare_faces
from radiosity.view.window.lamps import Lamps
from radiosity.view.window.later import Later
from radiosity.view.window.look import Look
from radiosity.view.window.refining import Refining
from radiosity.view.window.surfaces import Surfaces

NOTHING = (30, 32, 36)  # behind false colours: what has no value
NONE = np.zeros(0)


class Display:
    """What of a scene and its solution is on the surfaces.

    Attributes
    ----------
    surfaces : Surfaces
    solution : Solution, Stage or None
        In the scene's own light, the latest that was found.
    lamps : Lamps or None
        What light there is instead.
    look : Look
    refining : Refining
        What illuminance is shown on, once it is asked for and there.
    scale : Scale or None
        Of the false colours.
    levels : (k,) float64
        Values of lines on it.
    """

    def __init__(self, plotter, scene: Scene, camera: Camera, start: Callable[..., Tones] | None):
        """Show the bare faces; ``start(solution)`` tells what a solution's tones are at first."""
        self.surfaces, self._plotter, self._scene = Surfaces(plotter), plotter, scene
        self._start = start or (lambda solution: Tones(auto_exposure(solution)))
        self.solution = self.lamps = self._corners = self._errors = self.scale = None
        self.look, self.levels, self.refining = Look(Tones(1.0), 1.0), NONE, Refining()
        points, cells, rgb = bare_faces(scene, camera)
        self.surfaces.place(points, cells)
        self.surfaces.paint(tone_map(rgb, 1.0))
        plotter.set_background([int(v) for v in NOTHING])

    def take(self, solution) -> None:
        """Show another solution of the scene, keeping what the user has chosen."""
        if self.solution is None or solution.patches is not self.solution.patches:
            self._corners = Corners(solution)
        tones, first = self._start(solution), self.solution is None
        self.look.tones, self.look.automatic = tones, auto_exposure(solution)
        self.look.ends.clear()
        if tones.scale is not None:
            self.look.begin_with(tones.scale, first)
        self.solution, self.lamps = solution, Lamps(solution, self._corners)
        self._errors = None
        self.refining.stop(0.0)
        self.refining = Refining()
        self.colour()

    @property
    def tones(self) -> Tones:
        """Return how radiance is shown."""
        return Tones(self.look.exposure, self.scale if self.look.mode == "luminance" else None)

    @property
    def estimating(self) -> bool:
        """Return whether the errors are being estimated."""
        return self._errors is not None and not self._errors.ready

    def estimate(self) -> None:
        """Start to estimate the errors in the light that there is."""
        self._errors = Later(lambda solution=self.lamps.solution: error_shares(solution))

    @property
    def shares(self) -> np.ndarray | None:
        """Return (n,) the errors of the patches in %, None where they are not known yet.

        Raises
        ------
        Exception
            What estimating them ended in.
        """
        if self._errors is None or not self._errors.ready:
            return None
        if self._errors.error is not None:
            raise self._errors.error
        return self._errors.result

    def refine(self) -> bool:
        """Begin to refine what illuminance is shown on; return whether it is there just now.

        Raises
        ------
        Exception
            What refining ended in.
        """
        if self.look.mode == "illuminance":
            self.refining.start(self.solution)
        if not self.refining.hear():
            return False
        self.look.forget_suited(self.solution)
        return True

    def colour(self) -> None:
        """Colour the surfaces anew."""
        if self.lamps is None:
            return
        fine = self.refining.mesh
        if fine is not None and self.look.mode == "illuminance" and not self.surfaces.edges:
            self.surfaces.place(fine.points, fine.cells)
            values = fine.illuminance(self.lamps.factors)
            self._map(values, self.look.scale(None, spread=fine.spread), self.look.isolines)
        else:
            self.surfaces.place(self._corners.points, self._corners.cells)
            self._colour_patches()
        behind = NOTHING
        if self.look.gathers:
            outside = self.lamps.solution.surroundings.field.outside
            behind = self.tones.shown(self._scene.bands.to_rgb(outside) / np.pi)
        self._plotter.set_background([int(v) for v in behind])

    def _colour_patches(self):
        (b, e), bands, mode = self.lamps.at_corners(), self._scene.bands, self.look.mode
        if mode == "picture" or (mode == "error" and self.shares is None):
            self.scale, self.levels = None, NONE
            self.surfaces.paint(self.tones.shown(bands.to_rgb(b) / np.pi))
        elif mode == "error":
            self._map(self._corners.flat(self.shares), self.look.scale(None, self.shares), False)
        else:
            lux = mode == "illuminance"
            values = illuminance(e, bands) if lux else photometric(b / np.pi, bands)
            self._map(values, self.look.scale(self.solution), self.look.isolines)

    def _map(self, values, scale: Scale, lines: bool):
        self.scale, self.levels = scale, round_numbers(scale) if lines else NONE
        self.surfaces.map(scale.place(values), scale, scale.place(self.levels))
