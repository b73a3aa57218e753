"""What a scene holds, one row a thing, in numbers and words: for all that tells of it."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.bands import RGB
from radiosity.light.palette import NEUTRAL, palette_of
from radiosity.light.photometry import photometric
from radiosity.light.sources import Falloff
from radiosity.mesh.contact import find_contacts
from radiosity.mesh.findings import MEANS, Findings, find_flaws
from radiosity.scene.groups import AMBIENT, groups_of_lights, kind_of_light
from radiosity.scene.model import Camera, Scene
from radiosity.scene.names import counted

FEW = 3  # bands whose numbers are all told


@dataclass(frozen=True)
class MaterialRow:
    """A material and what it covers.

    Attributes
    ----------
    name : str
    faces : int
    area_m2 : float
    diffuse, emission : str
        Reflectances and W/(m2 sr) a band, in words; the emission "-" where there is none.
    more : str
        Lobe, mirror, transmission, texture and the like; each after two spaces.
    reflectance : float
        Luminous, of the diffuse base under neutral light.
    rgb : (r, g, b)
        Linear sRGB of that light, of emitters of their own with the largest 1.
    luminance_cd_m2, flux_lm : float
        Of the emission, and of all faces together.
    """

    name: str
    faces: int
    area_m2: float
    diffuse: str
    emission: str
    more: str
    reflectance: float
    rgb: tuple[float, float, float]
    luminance_cd_m2: float
    flux_lm: float


@dataclass(frozen=True)
class LightRow:
    """An abstract light source, or the ambient light.

    Attributes
    ----------
    kind : str
        Its ``type`` in a scene file.
    place : tuple of float
        Position, scene units; of directional light the way it travels; of ambient light ().
    strength : str
        W/sr, W/m2 or, of ambient light, W/(m2 sr) a band, in words.
    group : str
    label : str
        What a luminaire was read from, "" of others.
    peak_cd, flux_lm : float or None
        None where it has none.
    """

    kind: str
    place: tuple[float, ...]
    strength: str
    group: str
    label: str = ""
    peak_cd: float | None = None
    flux_lm: float | None = None

    @property
    def place_words(self) -> str:
        """Return where it is, or which way it shines."""
        return number_words(self.place) if self.place else "from outside, W/(m2 sr)"


def material_rows(scene: Scene) -> list[MaterialRow]:
    """Return a row for each material, in the scene's order.

    Examples
    --------
    >>> import radiosity
    >>> rows = material_rows(radiosity.load("scenes/box6.toml"))
    >>> [(r.name, r.area_m2, r.reflectance) for r in rows][:2]
    [('floor', 12.0, 0.2), ('ceiling', 12.0, 0.7)]
    """
    area, bands = scene.faces.areas() * scene.unit_m**2, scene.bands
    white = palette_of(bands).light(NEUTRAL)
    found = []
    for k, material in enumerate(scene.materials):
        mine = scene.faces.material == k
        size, emits = float(area[mine].sum()), material.emits
        shown = bands.to_rgb(material.emission if emits else material.diffuse * white)
        luminance = float(photometric(material.emission, bands))
        found.append(MaterialRow(
            material.name, int(mine.sum()), size, share_words(material.diffuse),
            light_words(material.emission, bands) if emits else "-",
            _optics(material) + _detail(material) + ("" if material.two_sided else "  back black"),
            round(float(bands.luminance(material.diffuse * white) / bands.luminance(white)), 12),
            tuple(float(v) for v in (shown / max(shown.max(), 1e-300) if emits else shown)),
            luminance, np.pi * luminance * size,
        ))  # fmt: skip
    return found


def light_rows(scene: Scene) -> list[LightRow]:
    """Return a row for each abstract light, then one for what enters from outside, if anything."""
    found = []
    for light, group in zip(scene.lights, groups_of_lights(scene), strict=True):
        kind, peak = kind_of_light(light), float(photometric(light.strength, scene.bands))
        strength, label = light_words(light.strength, scene.bands), getattr(light, "label", "")
        if kind == "directional":
            found.append(LightRow(kind, tuple(map(float, light.direction)), strength, group))
            continue
        flux = peak * light.solid_angle if light.falloff == Falloff() else None
        place = tuple(map(float, light.position))
        found.append(LightRow(kind, place, strength, group, label, peak, flux))
    if scene.ambient.any():
        strength = light_words(scene.ambient, scene.bands)
        found.append(LightRow("ambient", (), strength, AMBIENT))
    return found


def view_words(camera: Camera, unit: str) -> str:
    """Return how much of the scene a camera shows from top to bottom."""
    if camera.orthographic:
        return f"{camera.height:.4g} {unit} high"
    return f"{camera.fov:.4g} degrees"


def colour_words(scene: Scene) -> str:
    """Return what a scene is computed in, "" where that is plain red, green and blue."""
    if scene.bands is RGB and not scene.spectra:
        return ""
    wavelengths = scene.bands.wavelengths is not None
    kind = f"{scene.bands.count} wavelengths" if wavelengths else " ".join(scene.bands.names)
    return f"colours in {kind}" + (", of " if scene.spectra else "") + ", ".join(scene.spectra)


def face_words(scene: Scene) -> str:
    """Return how many faces of which kind a scene has, its area, extent and axis that is up."""
    faces = scene.faces
    area = faces.areas() * scene.unit_m**2
    low, high = (f(faces.vertices.reshape(-1, 3), axis=0) for f in (np.min, np.max))
    extent = " x ".join(f"{v:g}" for v in high - low)
    triangles = int(faces.is_triangle.sum())
    return (
        f"faces {len(faces)} (quadrilaterals {len(faces) - triangles}, triangles {triangles}), "
        f"{area.sum():.6g} m2, {extent} {scene.unit}, {scene.up} up"
    )


def flaws_of(scene: Scene) -> tuple[dict, Findings]:
    """Return the contacts of a scene's faces and what is odd about its mesh."""
    emits = np.array([m.emits for m in scene.materials])[scene.faces.material]
    contacts = find_contacts(scene.faces, emits)
    return contacts.faces, find_flaws(scene.faces, emits, contacts)


def finding_words(scene: Scene) -> list[str]:
    """Return what was found in the mesh, a line each."""
    contacts, flaws = flaws_of(scene)
    covered = sum(bool(c.covers or c.hides) for c in contacts.values())
    found = [
        f"contact: {counted(len(contacts), 'face')} met by others in their plane, {covered} of all "
        "lie on others",
        f"mesh: {counted(flaws.outward + flaws.inward, 'closed piece')} ({flaws.outward} look out, "
        f"{flaws.inward} in), {flaws.open} open",
        *(f"found: {f.count} {MEANS[f.kind]}{_places(f, scene)}" for f in flaws.found),
    ]
    if scene.truth is not None:
        found.append(
            f"truth: carries its radiosity for mesh {scene.truth.mesh}, "
            f"to {scene.truth.relative_tolerance:g} relative"
        )
    if scene.faces.is_curved.any():
        curved = int(scene.faces.is_curved.sum())
        found.append(f"normals: {curved} faces stand for a curved surface")
    return found


def number_words(values) -> str:
    """Return numbers as text."""
    return " ".join(f"{v:.6g}" for v in values)


def share_words(values) -> str:
    """Return shares as text, of many wavelengths the least and the most."""
    if len(values) <= FEW:
        return number_words(values)
    return " to ".join(dict.fromkeys(f"{v:.6g}" for v in (values.min(), values.max())))


def light_words(values, bands) -> str:
    """Return watts as text, of wavelengths as RGB."""
    return number_words(values if bands.wavelengths is None else bands.to_rgb(values))


def _places(finding, scene) -> str:
    """Return where the first of a kind are: faces, their groups and points."""
    places = [
        f"face {f} ({scene.groups[scene.faces.group[f]]}) at {number_words(point)}"
        for f, point in zip(finding.faces, finding.points, strict=True)
    ]
    return "; ".join(["", *places]) + ("; .." if finding.count > len(places) > 0 else "")


def _detail(material) -> str:
    """Return what is said of a material's texture, whose mean was told, and of its bumps."""
    words = ""
    if material.texture is not None:
        height, width, _ = material.texture.texels.shape
        words += f"  texture {width}x{height}, from {share_words(material.texture.lowest)} to "
        words += share_words(material.texture.highest)
    if material.shininess is not None:
        words += f"  roughness by a texture from {material.shininess.minimum:g}"
    if material.bump is not None:
        words += f"  bumps {material.bump.height:g} high"
    return words


def _optics(material) -> str:
    named = {"": material.specular, "mirror ": material.mirror, "transmits ": material.transmit}
    words = "".join(f"  {name}{part.summary}" for name, part in named.items() if part is not None)
    if material.translucent is not None:
        words += f"  translucent {share_words(material.translucent)}"
    if material.absorption is not None:
        words += f"  absorbs {share_words(material.absorption)} a metre"
    return words
