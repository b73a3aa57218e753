"""Three levels of what light a picture models (seed, 3.7): radiosity, ray tracing, local shading.

`gather` knows all coupling between surfaces, from a solution. ``raytrace`` follows sight lines by
mirrors and through clear bodies, and at their ends reflects only what comes straight from lights
and from outside. ``local`` knows no coupling: lights, with shadows or without, ambient light that
stands for all the rest, and clear bodies as if their index were 1. Neither needs a solution.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from radiosity.light.photometry import illuminance
from radiosity.mesh.patches import Patches
from radiosity.scene.model import Camera, Scene, SceneError
from radiosity.solve.plan import Plan, make_plan
from radiosity.solve.reach import Reach, find_reach
from radiosity.solve.solution import Solution
from radiosity.solve.solve import solve
from radiosity.solve.surroundings import surroundings_of
from radiosity.solve.system import Terms, lights_of, make_terms
from radiosity.transport.hemisphere import look_out
from radiosity.transport.irradiance import Surroundings, direct_irradiance
from radiosity.transport.threads import Progress, silent
from radiosity.transport.visibility import Unobstructed
from radiosity.view import gather
from radiosity.view.image import Image

if TYPE_CHECKING:
    from radiosity.transport.paths import Space

METHODS = "gather", "raytrace", "local"
RAYS = 16  # to each light, and to all sides, from a patch
ENDLESS = 1e-6  # share of the light that must be lost at a bounce


@dataclass(frozen=True)
class Stage:
    """A scene to be pictured without a solution; what the final gather asks of one.

    Attributes
    ----------
    scene : Scene
    plan : Plan
    reach : Reach
    terms : Terms
    surroundings : Surroundings
        Without light that surfaces reflect.
    space : Space or None
        What sight lines are followed through.
    irradiance_on : (n, bands) float64
        On the patches' middles by lights and ambient light alone, W/m2: what exposes the picture.
    """

    scene: Scene
    plan: Plan
    reach: Reach
    terms: Terms
    surroundings: Surroundings
    space: "Space | None"
    irradiance_on: np.ndarray

    @property
    def patches(self) -> Patches:
        """Return the patches."""
        return self.reach.patches

    @property
    def live(self) -> np.ndarray:
        """Return (n,) bool: patches that light reaches."""
        return self.reach.live

    @property
    def emission(self) -> np.ndarray:
        """Return (n, bands) exitance of the patches' own in W/m2."""
        return self.terms.emission

    @property
    def reflectance(self) -> np.ndarray:
        """Return (n, bands) reflectances."""
        return self.terms.reflectance

    @property
    def radiosity(self) -> np.ndarray:
        """Return (n, bands) what patches emit, and reflect of the irradiance here, W/m2."""
        return self.emission + self.reflectance * self.irradiance_on

    @property
    def illuminance(self) -> np.ndarray:
        """Return (n,) that of the patches in lx."""
        return illuminance(self.irradiance_on, self.scene.bands)

    @property
    def error(self) -> np.ndarray:
        """Return (n, bands) errors of the irradiance: unknown, infinite."""
        return np.full(self.irradiance_on.shape, np.inf)

    @property
    def transmittance(self) -> np.ndarray | None:
        """Return (n, bands) what comes diffusely through patches."""
        return self.terms.transmittance

    @property
    def seed(self) -> int:
        """Return the seed of all sample patterns."""
        return self.plan.recipe.seed


def render(
    of: Scene | Solution,
    camera: Camera | str | None = None,
    *,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    method: str = "gather",
    shadows: bool = True,
    progress: Progress = silent,
) -> Image:
    """Compute a camera's picture.

    Parameters
    ----------
    of : Scene or Solution
        Of a scene, ``gather`` first makes a solution, at the default accuracy.
    camera : Camera or str, optional
        One of the scene's by name; its first by default.
    size : (w, h), optional
        Pixels, instead of the camera's own.
    samples : int, optional
        Rays over each pixel's hemisphere, see `radiosity.view.gather.render`.
    method : str
        ``gather``, ``raytrace`` or ``local``; see this module.
    shadows : bool
        Whether lights cast shadows; without, for ``local`` only.

    Returns
    -------
    Image
        (h, w, 3) radiance in W/(m2 sr), with an automatic exposure.

    Raises
    ------
    ValueError
        No such camera or method, or a size or number of samples out of range.
    SceneError
        ``local`` derives its ambient light from a scene in which nothing absorbs.

    Examples
    --------
    >>> import radiosity
    >>> scene = radiosity.load("scenes/box6.toml")
    >>> radiosity.render(scene, size=(8, 6), samples=8, method="raytrace").pixels.shape
    (6, 8, 3)
    """
    view = view_of(of, method, shadows)
    return gather.render(view, camera, size=size, samples=samples, progress=progress)


def view_of(of: Scene | Solution, method: str, shadows: bool = True) -> Solution | Stage:
    """Return what `radiosity.view.gather` makes pictures of by a method, see `render`."""
    check_method(method, shadows)
    scene = of if isinstance(of, Scene) else of.scene
    if method == "gather":
        return solve(of) if isinstance(of, Scene) else of
    seed = 0 if isinstance(of, Scene) else of.seed
    return make_stage(scene, method == "local", shadows=shadows, seed=seed)


def check_method(method: str, shadows: bool = True) -> None:
    """Refuse what is no method, and lights without shadows where these are always modelled."""
    if method not in METHODS:
        raise ValueError(f"method = {method!r} must be one of {', '.join(METHODS)}")
    if not shadows and method != "local":
        raise ValueError(
            f'to leave out the shadows of lights is for method = "local": "{method}" always models '
            "them"
        )


def make_stage(
    scene: Scene, local: bool, *, shadows: bool = True, accuracy: float = 0.02, seed: int = 0
) -> Stage:
    """Return a scene ready to be pictured by ray tracing, or by local shading.

    ``accuracy`` is what the noise of pictures is held to, where no samples are given.

    Raises
    ------
    SceneError
        Impossible numbers, a lobe in a raw form, but for local shading, or ambient light that would
        never end.
    """
    scene.check()
    tame = scene
    if local:
        tame = replace(scene, materials=tuple(map(_without_raw_lobes, scene.materials)))
    plan = make_plan(tame, accuracy, seed=seed)
    reach = find_reach(tame, plan.division, seed)
    terms = make_terms(tame, reach.patches, reach.live)
    lights = lights_of(scene, most=len(scene.faces))
    direct = _direct(reach, lights, seed)
    even = None if scene.ambient.any() else np.zeros(scene.bands.count)
    if local:
        even = scene.ambient if even is None else _balanced(scene, reach, terms, direct, seed)
    n, bands = len(reach.patches), scene.bands.count
    around = surroundings_of(
        scene, reach, lights, np.zeros((n, bands)), np.zeros((n, bands, 3)), seed, False
    )
    visibility = reach.visibility if shadows else Unobstructed(reach.visibility)
    around = replace(around, even=even, visibility=visibility)
    arriving = direct + np.pi * (scene.ambient if even is None else even)
    arriving = np.where(reach.live[:, None], arriving, 0.0)
    return Stage(scene, plan, reach, terms, around, _space(scene, reach, local), arriving)


def _without_raw_lobes(material):
    """Return a material without a lobe in the seeds' raw form, which has no albedo."""
    raw = material.specular is not None and not hasattr(material.specular, "mean_albedo")
    return replace(material, specular=None) if raw else material


def _space(scene, reach, local) -> "Space | None":
    """Return what sight lines are followed through, None where they end at the first surface."""
    used = [scene.materials[k] for k in np.unique(scene.faces.material)]
    if all(m.transmit is None and (local or m.mirror is None) for m in used):
        return None
    from radiosity.view.coherent import space_of  # others need none of it

    return space_of(scene, reach, local)


def _direct(reach, lights, seed) -> np.ndarray:
    """Return (n, bands) irradiance that lights cause in the middle of live patches, W/m2."""
    found = np.zeros((len(reach.patches), lights.exitance.shape[1]))
    rows = np.flatnonzero(reach.live)
    points, normals = reach.patches.centroid[rows], reach.patches.normal[rows]
    found[rows] = direct_irradiance(
        reach.visibility, lights, points, normals, rows, range(RAYS), seed
    )
    return found


def _balanced(scene, reach, terms, direct, seed) -> np.ndarray:
    """Return (bands,) the ambient radiance that stands for all light reflected more than once.

    Of what surfaces reflect of light from lights, rho E, a share w leaves the scene; what stays is
    reflected again with the mean reflectance r: L = (1 - w) mean(rho E) / (pi (1 - (1 - w) r)),
    means by area (E27).
    """
    rows = np.flatnonzero(reach.live)
    patches, area = reach.patches, reach.patches.area[rows]
    rho = sum(x[rows] for x in (terms.reflectance, terms.transmittance, terms.sent_on)
              if x is not None)  # fmt: skip
    sides, _ = look_out(
        reach.visibility, reach.table, patches.centroid[rows], patches.normal[rows], rows,
        range(RAYS), seed,
    )  # fmt: skip
    if not len(rows):
        return np.zeros(scene.bands.count)
    stays = 1.0 - np.average((sides < 0).mean(axis=1), weights=area)
    once = np.average(rho * direct[rows], axis=0, weights=area)
    again = stays * np.average(rho, axis=0, weights=area)
    if np.any(again > 1.0 - ENDLESS):
        raise SceneError(scene.source or scene.name, [
            "all that lights reach reflects everything, so the ambient light that stands for "
            "what is reflected again has no end: let something absorb (diffuse below 1), or give "
            "an ambient light"
        ])  # fmt: skip
    return stays * once / (np.pi * (1.0 - again))
