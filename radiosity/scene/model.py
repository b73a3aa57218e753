"""What a user describes: materials, cameras and the scene, as frozen values."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from radiosity.light.bands import RGB, Bands
from radiosity.light.sources import Light
from radiosity.mesh.faces import Faces
from radiosity.scene.names import counted

if TYPE_CHECKING:
    from radiosity.light.bump import Bump
    from radiosity.light.shininess import Shininess
    from radiosity.light.texture import Texture


class SceneError(ValueError):
    """Bad input: every problem found, each with where, value, bound and way out.

    Attributes
    ----------
    problems : list of str
        One complete sentence a problem.

    Examples
    --------
    >>> import radiosity
    >>> try:
    ...     scene = radiosity.load("scenes/box.toml")
    ... except radiosity.SceneError as error:
    ...     print(error)
    scenes/box.toml: does not exist: did you mean box6.toml?
    """

    def __init__(self, source: str, problems: list[str]):
        self.source, self.problems = source, list(problems)
        super().__init__("\n".join(f"{source}: {p}" for p in self.problems))


@dataclass(frozen=True)
class Material:
    """What a surface does to light, per band of the scene.

    Attributes
    ----------
    diffuse : (bands,) float64
        Lambertian reflectance rho = pi k_d, on both sides unless ``two_sided`` is false.
    absorptance : (bands,) float64
        1 - diffuse, given directly where the reflectance is near 1.
    emission : (bands,) float64
        Radiance in W/(m2 sr), from the front only.
    specular : object or None
        A lobe, see `radiosity.light.reflection`.
    mirror, transmit : object or None
        Laws k_r and k_t of what is mirrored and goes through, see `radiosity.light.coherent`.
    translucent : (bands,) float64, optional
        Share of the light on either side that leaves the other one, evenly: tau = pi T*.
    texture : Texture, optional
        Reflectance of each point, whose mean ``diffuse`` is.
    absorption : (bands,) float64, optional
        Of the clear body behind the front, in 1/m: exp(-absorption d) is left after a way d.
    bump : Bump, optional
        Relief, in scene units, seen in pictures.
    shininess : Shininess, optional
        Roughness of the lobe at each point, in pictures; elsewhere the lobe has its mean.

    Examples
    --------
    >>> import numpy as np
    >>> from radiosity import Material
    >>> white = Material("white", np.full(3, 0.8), np.full(3, 0.2), np.zeros(3))
    >>> white.emits
    False
    """

    name: str
    diffuse: np.ndarray
    absorptance: np.ndarray
    emission: np.ndarray
    specular: object | None = None
    two_sided: bool = True
    mirror: object | None = None
    transmit: object | None = None
    translucent: np.ndarray | None = None
    texture: "Texture | None" = None
    bump: "Bump | None" = None
    shininess: "Shininess | None" = None
    absorption: np.ndarray | None = None

    @property
    def least_absorptance(self) -> np.ndarray:
        """Return (bands,) what of the light neither side sends on, where it is brightest."""
        kept = self.absorptance if self.texture is None else 1.0 - self.texture.highest
        return kept if self.translucent is None else kept - self.translucent

    @property
    def is_detailed(self) -> bool:
        """Whether a picture tells something of it that varies inside of faces."""
        return any(x is not None for x in (self.texture, self.bump, self.shininess))

    @property
    def sends_on(self) -> bool:
        """Whether light goes on from it along single directions."""
        return any(x is not None for x in (self.specular, self.mirror, self.transmit))

    @property
    def emits(self) -> bool:
        """Whether the front sends out light of its own."""
        return bool(np.any(self.emission > 0))

    @property
    def coats(self) -> tuple:
        """Lobe and mirror that lie on the diffuse base as a clear film, which dims it."""
        upon = self.specular, self.mirror
        return tuple(part for part in upon if getattr(part, "dielectric", False))


@dataclass(frozen=True)
class Camera:
    """Pinhole or orthographic camera; lengths in scene units, ``size`` (w, h) in pixels.

    Exactly one of ``fov``, the vertical angle in degrees that a pinhole camera sees, and
    ``height``, the vertical extent that an orthographic one shows, is a number.

    Raises
    ------
    ValueError
        Where both or neither are given.

    Examples
    --------
    >>> import numpy as np
    >>> from radiosity import Camera
    >>> eye, at, up = np.array([0.0, -3, 1]), np.array([0.0, 0, 1]), np.array([0.0, 0, 1])
    >>> Camera("front", eye, at, up, 40.0, (64, 48)).size
    (64, 48)
    >>> Camera("elevation", eye, at, up, None, (64, 48), height=2.5).orthographic
    True
    """

    name: str
    position: np.ndarray
    target: np.ndarray
    up: np.ndarray
    fov: float | None
    size: tuple[int, int]
    height: float | None = None

    def __post_init__(self):
        if (self.fov is None) == (self.height is None):
            raise ValueError(
                f"cameras.{self.name}: fov = {self.fov}, height = {self.height}: give fov for a "
                "pinhole camera or height for an orthographic one, and None for the other"
            )

    @property
    def orthographic(self) -> bool:
        """Whether all of it looks in one direction."""
        return self.height is not None


@dataclass(frozen=True)
class ReadAs:
    """How a material of another format was read.

    Attributes
    ----------
    origin : str
        What the file says of it.
    table : dict
        The ``[materials.NAME]`` of a scene file that it became.
    """

    origin: str
    table: dict


@dataclass(frozen=True)
class Truth:
    """The closed-form answer a scene carries: radiosity in W/m2 by material or group, or of all.

    ``radiosity`` maps a material or group name to (bands,) values; "" stands for every face.
    """

    radiosity: dict[str, np.ndarray]
    relative_tolerance: float
    mesh: str


@dataclass(frozen=True)
class Scene:
    """A scene as read; lengths are in ``unit``, whose size in metres is ``unit_m``.

    ``bands`` tells what the numbers of its materials, of its ``lights``, abstract sources that
    surfaces see and cameras do not, and of its ``ambient`` radiance stand for; ``spectra`` names
    the files that colours come from; ``read_as`` tells how materials of other formats were read.

    Examples
    --------
    >>> import numpy as np
    >>> from radiosity import Material, Scene
    >>> from radiosity.mesh.faces import Faces
    >>> white = Material("white", np.full(3, 0.8), np.full(3, 0.2), np.ones(3))
    >>> square = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]])
    >>> scene = Scene("square", Faces.from_polygons(square, 0, 0), (white,), ("all",))
    >>> scene.faces.areas().tolist()
    [1.0]
    """

    name: str
    faces: Faces
    materials: tuple[Material, ...]
    groups: tuple[str, ...]
    cameras: dict[str, Camera] = field(default_factory=dict)
    unit: str = "m"
    unit_m: float = 1.0
    up: str = "z"
    ambient: np.ndarray | None = None  # (bands,) W/(m2 sr) that enter from outside; none is 0
    lights: tuple[Light, ...] = ()
    truth: Truth | None = None
    source: str = ""
    notes: tuple[str, ...] = ()
    bands: Bands = RGB
    spectra: tuple[str, ...] = ()
    read_as: dict[str, ReadAs] = field(default_factory=dict)

    def __post_init__(self):
        if self.ambient is None:
            object.__setattr__(self, "ambient", np.zeros(self.bands.count))

    @property
    def sends_on(self) -> bool:
        """Whether light goes on along single directions from any face."""
        return any(self.materials[k].sends_on for k in np.unique(self.faces.material))

    @property
    def has_light(self) -> bool:
        """Whether any face emits, any light shines or any enters from outside."""
        emits = any(m.emits for m in self.materials)
        return bool(emits or self.ambient.any() or any(s.strength.any() for s in self.lights))

    def __repr__(self) -> str:
        """Return what it is, without its arrays."""
        held = counted(len(self.faces), "face"), counted(len(self.materials), "material")
        return f"<Scene {self.name!r}: {', '.join(held)}, lengths in {self.unit}>"

    def _repr_html_(self) -> str:
        """Return what it holds, as a notebook shows it."""
        from radiosity.scene.overview import scene_html

        return scene_html(self)

    def check(self) -> None:
        """Refuse what no reader lets through, for scenes that are made in code.

        Raises
        ------
        SceneError
            Numbers that are not finite, negative light, reflectances outside [0, 1], no faces, as
        many numbers as the scene has no bands.
        """
        problems = [] if len(self.faces) else ["faces are missing: there is nothing to light"]
        problems += [
            f"faces.vertices[{k}] = {self.faces.vertices[k].tolist()} must be finite"
            for k in np.flatnonzero(~np.isfinite(self.faces.vertices).all(axis=(1, 2)))[:3]
        ]
        problems += self._miscounted()
        for k, m in enumerate(self.materials):
            where = f"materials.{m.name}"
            if m.texture is not None:
                bounds = np.append(m.texture.lowest, m.texture.highest)
                problems += _outside(f"{where}.texture", bounds, 1.0, "it is a reflectance")
            if m.is_detailed:
                problems += uncovered(where, self.faces, self.faces.material == k)
            why = "a surface cannot reflect more than it receives"
            problems += _outside(f"{where}.diffuse", m.diffuse, 1.0, why)
            problems += _outside(f"{where}.absorptance", m.absorptance, 1.0, "a share of the light")
            problems += _outside(f"{where}.emission", m.emission, np.inf, "radiance in W/(m2 sr)")
            problems += self._impossible(m, where) or too_bright(m, self.bands)
        for k, light in enumerate(self.lights):
            problems += _outside(f"lights[{k}]", light.strength, np.inf, "in W/sr, or W/m2")
            problems += [f"lights[{k}] {text}" for text in light.problems()]
        problems += _outside("ambient", self.ambient, np.inf, "radiance in W/(m2 sr)")
        if problems:
            raise SceneError(self.source or self.name, problems)

    def _impossible(self, m, where) -> list[str]:
        """Return what is wrong with what a material does beside reflecting diffusely."""
        found, count = [], self.bands.count
        shares = {"translucent": m.translucent}
        for key, name in (("specular", "reflectance"), ("mirror", "share"), ("transmit", "share")):
            shares[f"{key}.{name}"] = getattr(getattr(m, key), name, None)
        for key, values in shares.items():
            if values is not None and np.shape(values) != (count,):
                shape = np.shape(values)
                found.append(f"{where}.{key} has the shape {shape}, must have ({count},)")
            elif values is not None:
                found += _outside(f"{where}.{key}", values, 1.0, "a share of the light")
        if m.translucent is not None and not m.two_sided:
            found.append(f"{where} is translucent and not two_sided: sheets have two sides alike")
        return found

    def _miscounted(self) -> list[str]:
        """Return which numbers are not one a band."""
        count, values = self.bands.count, {"ambient": self.ambient}
        for m in self.materials:
            for key in ("diffuse", "absorptance", "emission"):
                values[f"materials.{m.name}.{key}"] = getattr(m, key)
        values |= {f"lights[{k}]": light.strength for k, light in enumerate(self.lights)}
        return [
            f"{where} has the shape {np.shape(x)}, must have ({count},): one number a band of the "
            f"scene ({', '.join(self.bands.names[:3])}{', ..' if count > 3 else ''})"
            for where, x in values.items()
            if np.shape(x) != (count,)
        ]


def uncovered(where: str, faces: Faces, mine: np.ndarray) -> list[str]:
    """Return what is wrong where not all of some faces (f,) bool have texture coordinates."""
    bare = mine if faces.uv is None else mine & np.isnan(faces.uv).any(axis=(1, 2))
    if not bare.any():
        return []
    return [
        f"{where} names a texture, but {bare.sum()} of its {mine.sum()} faces have no texture "
        f"coordinates, face {np.flatnonzero(bare)[0]} for one: give vt in the OBJ file or uv "
        "beside the polygons"
    ]


def too_bright(material: Material, bands: Bands) -> list[str]:
    """Return what is wrong where a material returns more light than arrives."""
    optics = material.specular, material.mirror, material.transmit, material.translucent
    if all(part is None for part in optics):
        return []
    from radiosity.scene.energy import excess

    texture = material.texture
    found = excess(material.diffuse if texture is None else texture.highest, *optics, bands.names)
    return [f"materials.{material.name}: {found}"] if found else []


def _outside(where, values, most, why) -> list[str]:
    """Return what is wrong with numbers that must lie between 0 and ``most`` and be finite."""
    values = np.atleast_1d(np.asarray(values, float))
    good = np.isfinite(values) & (values >= 0.0) & (values <= most + 1e-12)
    bound = "in [0, 1]" if most == 1.0 else "at least 0 and finite"
    return [
        f"{where}[{k}] = {values[k]:g} must be {bound}: {why}" for k in np.flatnonzero(~good)[:1]
    ]


def check_scene(scene: Scene) -> None:
    """Refuse what is no scene, with TypeError, and a scene that `Scene.check` refuses."""
    if not isinstance(scene, Scene):
        raise TypeError(f"{scene!r} is no Scene: radiosity.load reads one from its file")
    scene.check()
