"""How the window shows a solution: as the eye sees it or in false colours, and how bright."""

from dataclasses import dataclass, field, replace

import numpy as np

from radiosity.view.falsecolour import Scale, round_up
from radiosity.view.scales import error_scale, illuminance_scale, luminance_scale, spread_scale
from radiosity.view.tones import Tones

STOP = 0.5  # of exposure, that a key changes
RANGE = 6.0  # stops to either side of the automatic exposure that a slider reaches
WIDER = 2.0  # times, about, that a key makes a scale
TITLES = {"illuminance": "lx", "luminance": "cd/m\u00b2", "error": "error, %"}


@dataclass
class Look:
    """What of a solution is shown, and how.

    Attributes
    ----------
    tones : Tones
        What it began with.
    automatic : float
        The exposure that suits the solution.
    stops : float
        By which the exposure differs from what it was at first.
    mode : str
        ``picture``, or the quantity in false colours: ``illuminance``, ``luminance``, ``error``.
    logarithmic, isolines : bool
        Of false colours.
    ends : dict
        Scales by mode and whether they are logarithmic, where they were made or changed.
    """

    tones: Tones
    automatic: float
    stops: float = 0.0
    mode: str = "picture"
    logarithmic: bool = False
    isolines: bool = True
    ends: dict = field(default_factory=dict)

    @property
    def exposure(self) -> float:
        """Return the display value of a unit of radiance."""
        return self.tones.exposure * 2.0**self.stops

    @property
    def from_automatic(self) -> float:
        """Return by how many stops the exposure differs from the automatic one."""
        return float(np.log2(self.exposure / self.automatic))

    @property
    def gathers(self) -> bool:
        """Return whether a gathered picture can show this: it knows radiance only."""
        return self.mode in ("picture", "luminance")

    def expose(self, from_automatic: float) -> None:
        """Take an exposure so many stops from the automatic one."""
        self.stops += from_automatic - self.from_automatic

    def step(self, up: bool) -> None:
        """Make the picture brighter or darker, or the scale's end higher or lower."""
        if self.mode == "picture":
            self.stops += STOP if up else -STOP
        elif (scale := self.ends.get(self._key)) is not None:
            end = round_up(scale.maximum * (WIDER if up else 1.0 / WIDER) * (1.0 - 1e-9))
            self.ends[self._key] = replace(scale, maximum=end)

    def adapt(self, automatic: float) -> None:
        """Return to an automatic exposure, or to the scale that suits."""
        if self.mode == "picture":
            self.stops = float(np.log2(automatic / self.tones.exposure))
        else:
            self.ends.pop(self._key, None)

    def scale(self, solution, shares=None, spread=None) -> Scale:
        """Return the scale of the false colours.

        ``shares`` (n,) are the errors in %. ``spread`` are illuminances and areas of parts finer
        than patches, as `radiosity.view.scales.spread_scale` takes them.
        """
        if self._key not in self.ends:
            if self.mode == "error":
                made = error_scale(shares, self.logarithmic)
            elif spread is not None:
                made = spread_scale(*spread, self.logarithmic)
            else:
                suited = illuminance_scale if self.mode == "illuminance" else luminance_scale
                made = suited(solution, self.logarithmic)
            self.ends[self._key] = made
        return self.ends[self._key]

    def begin_with(self, scale: Scale, first: bool) -> None:
        """Take a scale of luminance, and at first show it."""
        if first:
            self.mode, self.logarithmic = "luminance", scale.decades > 0.0
        self.ends["luminance", scale.decades > 0.0] = scale

    def forget_suited(self, solution) -> None:
        """Let scales of illuminance be made anew but for those that the user has changed."""
        for logarithmic in (False, True):
            key = "illuminance", logarithmic
            if self.ends.get(key) == illuminance_scale(solution, logarithmic):
                del self.ends[key]

    @property
    def _key(self):
        return self.mode, self.logarithmic

