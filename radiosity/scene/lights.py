"""Abstract light sources of a scene file: the tables ``[[lights]]``."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from pydantic import Field

from radiosity.light.palette import NEUTRAL, Palette
from radiosity.light.photometry import EFFICACY
from radiosity.light.sources import Directional, Falloff, Flood, Light, Point, Spot
from radiosity.scene.checks import photometric_file
from radiosity.scene.names import nearest
from radiosity.scene.schema import (
    BANDS,
    POINT,
    POWER,
    Number,
    StrictTable,
    at,
    checked,
    dotted,
    taken_by,
)

ANGLE = Number(0, 180, "a half angle in degrees")
NARROWEST = 1e-4  # degrees


@dataclass(frozen=True)
class Ambient:
    """Light that enters from outside, the same from all directions; radiance in W/(m2 sr)."""

    radiance: np.ndarray


class _FalloffTable(StrictTable):
    a: taken_by(POWER) = Field(description="the share of the light is 1/(a d^m + b), d in metres")
    b: taken_by(POWER) = 0.0
    m: taken_by(Number(0, 20, "2 is the law of nature")) = 2.0


class _LightTable(StrictTable):
    type: str
    group: str = ""


class _PlacedTable(_LightTable):
    """A point-like light: one of four quantities says how strong it is."""

    position: taken_by(POINT) = Field(description="where the light is, [x, y, z]")
    intensity: taken_by(BANDS) = None
    luminous_intensity: taken_by(POWER) = None
    radiant_flux: taken_by(BANDS) = None
    luminous_flux: taken_by(POWER) = None
    falloff: _FalloffTable | None = None


class _PointTable(_PlacedTable):
    type: Literal["point"]


class _SpotTable(_PlacedTable):
    type: Literal["spot"]
    target: taken_by(POINT) = Field(description="the point that its axis goes through, [x, y, z]")
    beam_angle: taken_by(ANGLE) = Field(description="full intensity up to this half angle, degrees")
    cutoff_angle: taken_by(ANGLE) = Field(description="no light beyond this half angle, degrees")


class _FloodTable(_PlacedTable):
    type: Literal["flood"]
    target: taken_by(POINT) = Field(description="the point that its axis goes through, [x, y, z]")
    exponent: taken_by(Number(0, 1e6, "intensity falls as cos^exponent")) = Field(
        description="intensity falls as cos^exponent; 1 is Lambert's"
    )


class _DirectionalTable(_LightTable):
    type: Literal["directional"]
    direction: taken_by(POINT) = Field(description="the way that the light travels, [x, y, z]")
    irradiance: taken_by(BANDS) = Field(description="on a plane that faces the light, W/m2")


class _AmbientTable(_LightTable):
    type: Literal["ambient"]
    radiance: taken_by(BANDS) = Field(description="the same from all directions, W/(m2 sr)")


class IesTable(_LightTable):
    """A luminaire whose maker measured it; ``file`` is its `Photometric` once it was read."""

    type: Literal["ies"]
    position: taken_by(POINT) = Field(description="where the luminaire is, [x, y, z]")
    target: taken_by(POINT) = Field(description="a point that gamma = 0 points to, [x, y, z]")
    roll: taken_by(Number(-360, 360, "the turn on its axis in degrees")) = 0.0
    file: taken_by(photometric_file) = Field(description='a photometric file, "NAME.ies" or .ldt')
    luminous_flux: taken_by(POWER) = None


TABLES = {
    "point": _PointTable, "spot": _SpotTable, "flood": _FloodTable,
    "directional": _DirectionalTable, "ambient": _AmbientTable, "ies": IesTable,
}  # fmt: skip
STRENGTHS = "intensity", "luminous_intensity", "radiant_flux", "luminous_flux"


def read_lights(blocks: Any, problems: list[str]) -> dict[int, StrictTable]:
    """Return the tables that are right by number; what is wrong with others becomes problems."""
    found = {}
    for k, raw in enumerate(blocks if isinstance(blocks, list) else []):
        path, before = ("lights", k), len(problems)
        kind = raw.get("type") if isinstance(raw, dict) else None
        if not isinstance(raw, dict):
            problems.append(at(path, raw, "must be a table: write [[lights]] above its keys"))
        elif kind not in TABLES:
            problems.append(_unknown(kind, path))
        else:
            table = checked(TABLES[kind], raw, path, problems)
            if len(problems) == before:
                problems += _between_keys(table, raw, path)
            if len(problems) == before:
                found[k] = table
    return found


def _unknown(kind, path):
    if kind is None:
        return f"{dotted(path)}.type is missing: one of {', '.join(TABLES)}"
    if not isinstance(kind, str):
        return at((*path, "type"), kind, f"must be one of {', '.join(TABLES)}")
    return at((*path, "type"), kind, f"is no kind of light: {nearest(kind, TABLES)}")


def _between_keys(table, raw, path):
    """Yield what is wrong between the keys of a light."""
    if isinstance(table, _DirectionalTable) and not np.any(table.direction):
        yield at((*path, "direction"), raw["direction"], "must not be zero: it is a direction")
    target = getattr(table, "target", None)
    if target is not None and target == table.position:
        yield at((*path, "target"), raw["target"], "must differ from position: it gives the axis")
    if not isinstance(table, _PlacedTable):
        return
    given = [key for key in STRENGTHS if getattr(table, key) is not None]
    if len(given) != 1:
        yield (
            f"{dotted(path)} gives {' and '.join(given) or 'no strength'}: give one of "
            f"{', '.join(STRENGTHS)}"
        )
    if table.falloff is not None:
        yield from _falloff_problems(table, given, path)
    if isinstance(table, _SpotTable) and table.cutoff_angle < table.beam_angle:
        text = f"must be at least the beam_angle {table.beam_angle:g}: light fades between them"
        yield at((*path, "cutoff_angle"), raw["cutoff_angle"], text)
    if isinstance(table, _SpotTable) and table.cutoff_angle < NARROWEST:
        text = f"must be at least {NARROWEST:g}: no light leaves a narrower spot"
        yield at((*path, "cutoff_angle"), raw["cutoff_angle"], text)


def _falloff_problems(table, given, path):
    if table.falloff.a == 0.0 and table.falloff.b == 0.0:
        yield f"{dotted((*path, 'falloff'))} has a = 0 and b = 0: 1/(a d^m + b) has no value"
    flux = [key for key in given if key.endswith("flux")]
    if flux:
        yield (
            f"{dotted(path)} gives {flux[0]} and falloff: only light that falls off as 1/d^2 has a "
            "flux; give an intensity"
        )


def make_light(table: StrictTable, palette: Palette, up: str = "z") -> Light | Ambient:
    """Return the light of a table without mistakes, in the bands of a palette.

    ``up`` is the scene's: how a luminaire hangs of which a file was read.
    """
    if isinstance(table, _AmbientTable):
        return Ambient(palette.light(table.radiance))
    if isinstance(table, _DirectionalTable):
        way = np.array(table.direction) / np.abs(table.direction).max()
        way /= np.linalg.norm(way)
        return Directional(way, palette.light(table.irradiance), table.group)
    if isinstance(table, IesTable):
        from radiosity.scene.photometric.luminaires import (
            make_luminaire,  # other scenes need none of it
        )

        return make_luminaire(table, axis_of(table), palette, up)
    falloff = Falloff() if table.falloff is None else Falloff(**table.falloff.model_dump())
    made = np.array(table.position), np.ones(palette.bands.count), falloff, table.group
    if isinstance(table, _SpotTable):
        beam, cutoff = np.radians([table.beam_angle, table.cutoff_angle])
        light = Spot(*made, axis_of(table), float(beam), float(cutoff))
    elif isinstance(table, _FloodTable):
        light = Flood(*made, axis_of(table), table.exponent)
    else:
        light = Point(*made)
    return light.of_intensity(_intensity(table, light.solid_angle, palette))


def axis_of(table: StrictTable) -> np.ndarray:
    """Return the unit vector (3,) from a light's position to its target."""
    way = np.subtract(table.target, table.position)
    way /= np.abs(way).max()
    return way / np.linalg.norm(way)


def _intensity(table, solid_angle, palette) -> np.ndarray:
    """Return the intensity (bands,) in W/sr of a light that sends into so many steradians."""
    if table.intensity is not None:
        return palette.light(table.intensity)
    if table.luminous_intensity is not None:
        return palette.light(NEUTRAL) * (table.luminous_intensity / EFFICACY)
    if table.radiant_flux is not None:
        return palette.light(table.radiant_flux) / solid_angle
    return palette.light(NEUTRAL) * (table.luminous_flux / EFFICACY / solid_angle)
