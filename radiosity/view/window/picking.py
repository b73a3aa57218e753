"""A point on a surface: which one is seen at a pixel, and what is to be read there."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.photometry import illuminance, photometric
from radiosity.scene.model import Camera
from radiosity.solve.solution import Solution
from radiosity.view.camera import rays
from radiosity.view.sightlines import first_rows
from radiosity.view.window.later import Later

ROUNDING = 1e-6  # of the largest coordinate, what a sight line may miss a plane by
DARK = -2  # what `first_rows` says of a sight line that ends where no light reaches


@dataclass(frozen=True)
class Place:
    """What a pixel shows.

    Attributes
    ----------
    patch : int
        -1 where the sight line leaves the scene, -2 where it ends on what no light reaches.
    point, normal : (3,) float64
        In scene units; of the side that is seen.
    """

    patch: int
    point: np.ndarray
    normal: np.ndarray


@dataclass(frozen=True)
class Reading:
    """What was measured at a place.

    Attributes
    ----------
    illuminance, error : float
        In lx; the error is infinite where it is not known.
    luminance : float
        In cd/m2, of the light that is emitted and diffusely reflected.
    material, group : str
    reflectance : float
        Diffuse, weighted by the eye.
    back : bool
        Whether it is the back of a face.
    point : (3,) float64
    unit : str
        Of the point.
    """

    illuminance: float
    error: float
    luminance: float
    material: str
    group: str
    reflectance: float
    back: bool
    point: np.ndarray
    unit: str


def seen_at(solution, camera: Camera, x: float, y: float) -> Place:
    """Return what a camera's picture shows at a pixel position, y down from the top."""
    origins, directions = rays(camera, camera.size, np.array([[x, y]]))
    rows, points = first_rows(solution, origins, directions)
    patch = int(rows[0])
    normal = solution.patches.normal[patch] if patch >= 0 else -directions[0]
    return Place(patch, points[0], normal)


def read(solution, place: Place) -> Reading:
    """Return what is to be read at a place on a lit patch, the illuminance gathered there.

    Without a solution, as for ``--method local``, it is what the patch gets, of unknown error.
    """
    scene, patch = solution.scene, place.patch
    bands = scene.bands
    if isinstance(solution, Solution):
        e, error = solution.irradiance(place.point[None], place.normal[None])
    else:
        e, error = solution.irradiance_on[None, patch], solution.error[None, patch]
    rho, face = solution.reflectance[patch], solution.patches.face[patch]
    white = np.ones(bands.count)
    leaving = (solution.emission[patch] + rho * e[0]) / np.pi
    return Reading(
        float(illuminance(e, bands)[0]), float(illuminance(error, bands)[0]),
        float(photometric(leaving, bands)), scene.materials[scene.faces.material[face]].name,
        scene.groups[scene.faces.group[face]], float(bands.luminance(rho) / bands.luminance(white)),
        not solution.patches.front[patch], place.point, scene.unit,
    )  # fmt: skip


def words(reading: Reading) -> list[str]:
    """Return the lines that tell a reading, the first one the illuminance with its error.

    Examples
    --------
    >>> where = np.array([0.5, 1.0, -2e-8])
    >>> words(Reading(312.4, 4.2, 71.1, "white", "", 0.715, False, where, "m"))[1:]
    ['71.1 cd/m\u00b2', 'white, reflects 71.5 %', '(0.5, 1, 0) m']
    """
    side = " (back)" if reading.back else ""
    least = ROUNDING * np.abs(reading.point).max()
    where = ", ".join(f"{v if abs(v) > least else 0.0:.4g}" for v in reading.point)
    lines = [
        with_error(reading.illuminance, reading.error),
        f"{reading.luminance:.3g} cd/m\u00b2",
        f"{reading.material}{side}, reflects {100.0 * reading.reflectance:.3g} %",
        f"({where}) {reading.unit}",
    ]
    if reading.group and reading.group != reading.material:
        lines.insert(3, f"group {reading.group}")
    return lines


def with_error(value: float, error: float) -> str:
    """Return a value in lx and its error, both to the first digit of the error.

    Examples
    --------
    >>> with_error(312.44, 4.2), with_error(31.244, 0.26), with_error(31.0, float("inf"))
    ('312 \u00b1 4 lx', '31.2 \u00b1 0.3 lx', '31 lx, error unknown')
    """
    if not np.isfinite(error):
        return f"{value:.3g} lx, error unknown"
    if error <= 0.0:
        return f"{value:.4g} \u00b1 0 lx"
    digits = -int(np.floor(np.log10(error) + 1e-9))
    digits = min(max(digits, 0), 6)
    return f"{value:.{digits}f} \u00b1 {error:.{digits}f} lx"


class Pick:
    """The point that is picked, and what is known of it.

    Attributes
    ----------
    place : Place or None
        On a surface.
    lines : list of str
        What to tell of it.
    """

    def __init__(self):
        """Pick nothing as yet."""
        self.clear()

    @property
    def measuring(self) -> bool:
        """Return whether a reading is waited for."""
        return self._reading is not None

    def take(self, solution, camera: Camera, x: float, y: float) -> None:
        """Pick what a camera's picture shows at a pixel position, y down from the top."""
        self.clear()
        place = seen_at(solution, camera, x, y)
        if place.patch >= 0:
            self.place = place
            self.measure(solution)
        elif place.patch == DARK:
            self.lines = ["0 lx", "no light reaches this side"]
        else:
            self.lines = ["nothing", "no surface is seen here"]

    def measure(self, solution) -> None:
        """Read at the point that is picked, in a thread."""
        if self.place is not None:
            self._reading = Later(lambda place=self.place: words(read(solution, place)))

    def hear(self) -> bool:
        """Return whether a reading has come.

        Raises
        ------
        Exception
            What measuring ended in.
        """
        reading = self._reading
        if reading is None or not reading.ready:
            return False
        self._reading = None
        if reading.error is not None:
            raise reading.error
        self.lines = reading.result
        return True

    def clear(self) -> None:
        """Forget the point."""
        self.place, self.lines, self._reading = None, [], None
