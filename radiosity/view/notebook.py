"""Notebooks: the picture of a solution inline, gathered, without a display or VTK."""

import sys
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from radiosity.scene.model import Camera
from radiosity.solve.solution import Solution
from radiosity.transport.threads import Progress, silent
from radiosity.view.camera import fitting
from radiosity.view.image import Image, png

if TYPE_CHECKING:
    from radiosity.view.falsecolour import Scale

LONGEST = 640  # pixels of a picture whose size is not given
SAMPLES = 64  # rays a pixel: a picture in seconds


@dataclass(frozen=True)
class Inline:
    """A picture that a notebook shows in place.

    Attributes
    ----------
    image : Image
        Linear radiance.
    camera : str
    scale : Scale or None
        Of false colours, of luminance in cd/m2.
    """

    image: Image
    camera: str
    scale: "Scale | None" = None

    def _repr_png_(self) -> bytes:
        """Return the picture as a PNG file."""
        if self.scale is None:
            return png(self.image.shown())
        from radiosity.view.falsecolour import false_colours

        return png(false_colours(self.image.luminance, self.scale))

    def __repr__(self) -> str:
        height, width, _ = self.image.pixels.shape
        noise = "" if self.image.noise is None else f", noise {100 * self.image.noise:.2g} %"
        return f"<camera {self.camera}, {width} x {height}{noise}>"


def in_notebook() -> bool:
    """Return whether this runs in a kernel that shows pictures, as Jupyter's do."""
    asked = getattr(sys.modules.get("IPython"), "get_ipython", None)
    shell = asked() if asked else None
    return shell is not None and getattr(shell, "kernel", None) is not None


def inline(
    solution: Solution,
    camera: Camera | str | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    exposure: float | None = None,
    scale: "Scale | None" = None,
    progress: Progress = silent,
) -> Inline:
    """Return the gathered picture of a camera; the parameters are those of `radiosity.plot`.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1)
    >>> inline(solution, size=(8, 6))._repr_png_()[1:4]
    b'PNG'
    """
    from radiosity.view.gather import find_camera, render

    chosen = find_camera(solution.scene, camera)
    size = size or fitting(chosen, LONGEST)
    image = render(
        solution, chosen, size=size, samples=SAMPLES if samples is None else samples,
        progress=progress,
    )  # fmt: skip
    if exposure is not None:
        image = replace(image, exposure=exposure)
    return Inline(image, chosen.name, scale)
