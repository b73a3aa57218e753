"""How pictures are shown: exposure and false colours as typed, and what they come to."""

import re
from dataclasses import dataclass
from typing import Annotated, Any

import typer

from radiosity.cli import completion
from radiosity.cli.options import PICTURE, with_point

_STEP = 2.0  # a stop


@dataclass(frozen=True)
class Exposure:
    """Display value per radiance, given or ``stops`` from the automatic one."""

    value: float | None = None
    stops: float = 0.0

    def of(self, solution) -> float:
        """Return the exposure, the same for all views of a solution."""
        if self.value is not None:
            return self.value
        from radiosity.view.shading import auto_exposure

        return auto_exposure(solution) * _STEP**self.stops


@dataclass(frozen=True)
class FalseColours:
    """Luminance on a linear or logarithmic scale up to a maximum in cd/m2, None for automatic."""

    logarithmic: bool
    maximum: float | None

    def of(self, solution):
        """Return the scale, the same for all views of a solution."""
        from radiosity.view.falsecolour import DECADES, Scale
        from radiosity.view.scales import luminance_scale

        if self.maximum is not None:
            return Scale(self.maximum, DECADES if self.logarithmic else 0.0)
        return luminance_scale(solution, self.logarithmic)


@dataclass(frozen=True)
class Look:
    """How pictures are shown: exposure, gamma if not that of sRGB, `Scale` of false colours."""

    exposure: float
    gamma: float | None
    scale: Any

    @classmethod
    def of(cls, solution, asked: Exposure, colours: FalseColours | None, gamma=None) -> "Look":
        """Return the look of all views of a solution."""
        return cls(asked.of(solution), gamma, colours and colours.of(solution))


def exposure(text: str) -> Exposure:
    """Return what ``auto``, ``auto+1.5``, ``auto-2`` or ``0.05`` means."""
    match = re.fullmatch(r"auto([+-][0-9.]+)?", text.strip().lower())
    try:
        if match:
            found = Exposure(stops=float(match[1] or 0.0))
        else:
            found = Exposure(float(text) if text[:1] != "+" else 0.0)  # stops, as in auto+1?
    except ValueError:
        found = Exposure(0.0)
    if abs(found.stops) > 100.0 or (found.value is not None and not 0 < found.value < 1e30):
        raise typer.BadParameter(
            f"{text!r} must be auto, auto+1 or auto-1 (stops), or a positive display value per "
            f"radiance, such as 0.05{with_point(text)}"
        )
    return found


def false_colours(text: str) -> FalseColours:
    """Return what ``auto``, ``log``, ``500`` or ``log:500`` means."""
    match = re.fullmatch(r"(log)?(:?)(.*)", text.strip().lower())
    logarithmic, rest = match[1] is not None, match[3]
    if rest == ("" if logarithmic else "auto") and not match[2]:
        return FalseColours(logarithmic, None)
    try:
        maximum = float(rest) if logarithmic == bool(match[2]) else 0.0
    except ValueError:
        maximum = 0.0
    if not 0 < maximum < 1e30:
        raise typer.BadParameter(
            f"{text!r} must be auto, log, or the luminance in cd/m2 at the scale's end, such as "
            f"500 or log:500{with_point(text)}"
        )
    return FalseColours(logarithmic, maximum)


def check_display(output: str, asked: Exposure, gamma: float | None, scale: FalseColours | None):
    """Raise ValueError where a picture file cannot be shown as asked."""
    from radiosity.view.image import check_suffix

    suffix = check_suffix(output, gamma, scale is not None)
    if asked == Exposure():
        return
    if suffix != ".png":
        raise ValueError(f"--exposure is for .png: {suffix} keeps linear radiance")
    if scale is not None:
        raise ValueError(
            "--exposure does not change false colours: give the scale's end, --false-colour 500"
        )


ExposureOption = Annotated[
    Exposure,
    typer.Option(
        "--exposure",
        metavar="auto|auto+STOPS|auto-STOPS|VALUE",
        parser=exposure,
        help="Display value per radiance, one for all views of a solution; a stop is a factor 2.",
        autocompletion=completion.words("auto", "auto+1", "auto-1"),
        rich_help_panel=PICTURE,
    ),
]
FalseColourOption = Annotated[
    FalseColours | None,
    typer.Option(
        "--false-colour",
        "--false-color",
        metavar="auto|MAX|log|log:MAX",
        parser=false_colours,
        help="Luminance in false colours with a scale up to MAX cd/m2, linear or of 3 decades.",
        autocompletion=completion.words("auto", "log"),
        rich_help_panel=PICTURE,
    ),
]
