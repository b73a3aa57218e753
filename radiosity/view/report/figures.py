"""All figures of a report, gathered from a solution: what a page shows and what JSON tells."""

import platform
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import radiosity
from radiosity.light.photometry import photometric
from radiosity.scene.contents import (
    LightRow,
    MaterialRow,
    face_words,
    finding_words,
    light_rows,
    material_rows,
)
from radiosity.scene.described import AS_IT_IS
from radiosity.solve.requirements import Requirement, requirements_of
from radiosity.solve.solution import Solution
from radiosity.view.report.words import left_out
from radiosity.view.report.zones import Zone, default_planes, default_surfaces, zone_of

LIBRARIES = "numpy", "scipy", "numba", "embreex", "trimesh", "matplotlib"


@dataclass(frozen=True)
class Power:
    """Where the emitted power goes.

    Attributes
    ----------
    bands : tuple of str
        Whose watts are told, none where these are wavelengths.
    watts : dict of str to tuple
        ``emitted``, ``absorbed`` and ``escaped`` W a band.
    lumens : dict of str to float
        The same in lm.
    defect : float
        Largest share of the emitted power that is unaccounted for.
    """

    bands: tuple[str, ...]
    watts: dict[str, tuple[float, ...]]
    lumens: dict[str, float]
    defect: float


@dataclass(frozen=True)
class Error:
    """Relative errors: what was asked, what was reached, and what that is made of.

    ``asked`` is None where a time was given instead, and not ``aimed`` at on a mesh that was given;
    ``truth`` is the error against the answer that the scene carries, ``stated`` what that is
    good for.
    """

    asked: float | None
    aimed: bool
    reached: float
    mesh: float
    factors: float
    solver: float
    truth: float | None
    stated: float | None


@dataclass(frozen=True)
class Pictured:
    """A picture of a report: pixels, display value per radiance, rms noise of the mean or None."""

    camera: str
    width: int
    height: int
    exposure: float
    noise: float | None


@dataclass(frozen=True)
class Figures:
    """The figures of a report; see the parts.

    ``remarks`` tell why planes or surfaces are missing, ``left_out`` what is not modelled at all,
    ``settings`` and ``versions`` map names to words.
    """

    scene: str
    file: str
    date: str
    contents: str
    closed: bool
    settings: dict[str, str]
    versions: dict[str, str]
    error: Error
    requirements: tuple[Requirement, ...]
    left_out: tuple[str, ...]
    grids: tuple[Zone, ...]
    surfaces: tuple[Zone, ...]
    remarks: tuple[str, ...]
    materials: tuple[MaterialRow, ...]
    lights: tuple[LightRow, ...]
    light_groups: tuple[str, ...]
    power: Power
    findings: tuple[str, ...]
    notes: tuple[str, ...]
    unit: str
    pictures: tuple[Pictured, ...] = ()

    def as_dict(self) -> dict:
        """Return the figures as plain values, lists and dicts; what does not exist is None or nan.

        They are those of ``radiosity report --json``, which docs/json.md describes.
        """
        names = (
            "scene", "file", "date", "unit", "closed", "versions", "light_groups", "findings",
            "notes", "remarks",
        )  # fmt: skip
        told = {name: getattr(self, name) for name in names}
        error = self.error
        return told | {
            "command": self.settings.get("command"),
            "grids": [_zone(z) for z in self.grids],
            "surfaces": [_zone(z) for z in self.surfaces],
            "lights": [_light(x) for x in self.lights],
            "materials": [_material(m) for m in self.materials],
            "requirements": [asdict(r) for r in self.requirements],
            "not_modelled": self.left_out,
            "power": asdict(self.power),
            "error": {name: getattr(error, name) for name in ("mesh", "factors", "solver")},
            "truth": None if error.truth is None else {
                "error": error.truth, "tolerance": error.stated,
            },
            "pictures": [asdict(p) for p in self.pictures],
        }  # fmt: skip


def gather(
    solution: Solution, date: str, grids: tuple[str, ...] = (), spacing: float | None = None,
    margin: float | None = None, command: str = "",
) -> Figures:  # fmt: skip
    """Return the figures of a report.

    Parameters
    ----------
    solution : Solution
    date : str
        As it is to stand there.
    grids : tuple of str
        As ``probe --grid`` names them, instead of floor and work plane.
    spacing, margin : float, optional
        Of these planes, scene units.
    command : str
        That made it, if any.

    Raises
    ------
    ValueError
        A grid that is impossible.
    """
    scene = solution.scene
    planes, said = default_planes(solution, spacing, margin) if not grids else (
        [zone_of(solution, grid, spacing, margin) for grid in grids], []
    )  # fmt: skip
    surfaces, dark = default_surfaces(solution)
    if dark:
        said = [*said, f"No light falls on {', '.join(dark[:10])}{' ..' if dark[10:] else ''}."]
    if not solution.can_dim:
        said = [*said, f"The {len(solution.groups)} light groups are too many to be told apart."]
    used = [m for m in material_rows(scene) if m.faces]
    return Figures(
        scene.name, Path(scene.source).name, date, face_words(scene), solution.closed,
        _settings(solution, command), _versions(), _error(solution),
        requirements_of(solution), left_out(scene), tuple(planes), tuple(surfaces), tuple(said),
        tuple(used), tuple(light_rows(scene)), solution.groups, _power(solution),
        tuple(finding_words(scene)), (*_foreign(scene), *scene.notes), scene.unit,
    )  # fmt: skip


def _foreign(scene) -> list[str]:
    """Return how materials of other formats were read."""
    return [f"{name} was read as: {said.origin}" for name, said in scene.read_as.items()
            if said.origin != AS_IT_IS]  # fmt: skip


def _settings(solution, command) -> dict[str, str]:
    plan, level = solution.plan, solution.level
    asked = f"an error of {100 * plan.accuracy:g} %"
    if plan.seconds is not None:
        asked = f"the best answer in {plan.seconds:g} s"
    kind = "linear" if level.recipe.order else "constant"
    mesh = "refined until the error is met" if plan.adapts else "as it was given"
    found = {
        "asked for": asked,
        "mesh": f"{len(solution.patches)} patches, {mesh}",
        "elements": f"{plan.clusters} clusters of constant" if plan.clusters else kind,
        "solver": f"{solution.solver}, {len(solution.history)} iterations",
        "bands": ", ".join(solution.scene.bands.names[:3]) if solution.scene.bands.count <= 3
        else f"{solution.scene.bands.count} wavelengths",
        "seed": str(solution.seed),
    }  # fmt: skip
    return found | ({"command": command} if command else {})


def _versions() -> dict[str, str]:
    found = {"radiosity": radiosity.__version__, "Python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # built otherwise than by pip
            found[name] = "unknown"
    return found


def _error(solution) -> Error:
    found, plan, truth = solution.estimate, solution.plan, solution.scene.truth
    return Error(
        None if plan.seconds is not None else plan.accuracy, plan.adapts, found.reached, found.mesh,
        found.kernel, float(solution.history[-1]), solution.truth_error(),
        None if truth is None else truth.relative_tolerance,
    )  # fmt: skip


def _power(solution) -> Power:
    balance, bands = solution.balance, solution.scene.bands
    rows = {name: getattr(balance, name) for name in ("emitted", "absorbed", "escaped")}
    lumens = {name: float(photometric(power, bands)) for name, power in rows.items()}
    if bands.wavelengths is not None:
        return Power((), dict.fromkeys(rows, ()), lumens, balance.defect)
    watts = {name: tuple(float(v) for v in power) for name, power in rows.items()}
    names = tuple({"r": "red", "g": "green", "b": "blue"}.get(n, n) for n in bands.names)
    return Power(names, watts, lumens, balance.defect)


def _light(light: LightRow) -> dict:
    return {
        "type": light.kind, "group": light.group, "place": light.place or None,
        "read_as": light.label or None,
        "flux_lm": light.flux_lm, "peak_cd": light.peak_cd,
    }  # fmt: skip


def _material(material: MaterialRow) -> dict:
    names = "name", "faces", "area_m2", "reflectance", "luminance_cd_m2", "flux_lm"
    told = {name: getattr(material, name) for name in names}
    return told | {"optics": material.more.strip().replace("  ", "; ")}


def _zone(zone: Zone) -> dict:
    """Return a zone as ``probe --grid --json`` tells it, with its names."""
    return {
        "name": zone.name, "kind": zone.kind,
        "grid": zone.grid, "by": "patches" if zone.where is None else "points",
        "points": zone.points, "left_out": zone.left_out, "spacing": zone.spacing or None,
        "margin": zone.margin,
        "illuminance_lx": asdict(zone.found),
    }  # fmt: skip
