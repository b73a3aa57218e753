"""Materials of a scene file: the tables ``[materials.NAME]``, in the bands of a palette."""

import numpy as np

from radiosity.light import photometry
from radiosity.light.palette import NEUTRAL, Palette
from radiosity.scene.assemble import DEFAULT_REFLECTANCE
from radiosity.scene.checks import TextureKey
from radiosity.scene.geometry import Geometry
from radiosity.scene.model import Material
from radiosity.scene.schema import OPTICAL, EmissionTable, MaterialTable


def make_materials(
    tables: dict[str, MaterialTable], geometry: Geometry, unit_m: float, palette: Palette
) -> tuple[dict[str, Material], list[str]]:
    """Return the materials of the scene file by name, and notes."""
    made, notes = {}, []
    areas = geometry.faces.areas() * unit_m**2
    for name, table in tables.items():
        used = name in geometry.material_names
        faces = geometry.faces.material == (geometry.material_names.index(name) if used else -1)
        lobe, *rest = _optics(table, palette)
        shines = any(part is not None for part in (lobe, *rest))
        diffuse, absorptance, note = _diffuse(name, table, shines, palette)
        notes += [note] if note else []
        emission = _radiance(table.emission, float(areas[faces].sum()), palette)
        made[name] = Material(
            name, diffuse, absorptance, emission, lobe, table.two_sided, *rest,
            absorption=_absorption(table.absorption, palette),
        )  # fmt: skip
    return made, notes


def _optics(table, palette):
    """Return lobe, mirror, transmission and what goes through evenly."""
    if not any(getattr(table, key) for key in OPTICAL):
        return (None,) * 4
    from radiosity.scene.optics import optics_of

    return optics_of(table, palette)


def _absorption(given, palette):
    """Return the absorption (bands,) in 1/m: of spectra that which leaves their mean after 1 m."""
    if given is None or not any(given):
        return None
    most = max(given)  # as if of so short a way that the darkest band keeps 1/e
    left = palette.share(tuple(np.exp(-np.array(given) / most)))
    return -most * np.log(np.clip(left, 1e-300, 1.0))


def _diffuse(name, table, shines, palette):
    """Return reflectance and absorptance (bands,), and a note where neither is given."""
    if isinstance(table.diffuse, TextureKey):
        dark = np.zeros(palette.bands.count)
        return dark, 1 - dark, None  # the texture tells
    if table.absorptance is not None:
        absorptance = palette.share(table.absorptance)
        return 1 - absorptance, absorptance, None
    if table.diffuse is not None:
        diffuse = palette.share(table.diffuse)
        return diffuse, 1 - diffuse, None
    value = 0.0 if shines else DEFAULT_REFLECTANCE
    diffuse = np.full(palette.bands.count, value)
    return diffuse, 1 - diffuse, f'material "{name}" gives no diffuse: {value:g} is taken'


def _radiance(emission: EmissionTable | None, area, palette):
    """Return the emitted radiance (bands,) in W/(m2 sr) of a material of some area in m2."""
    if emission is None:
        return np.zeros(palette.bands.count)
    if emission.radiance is not None:
        return palette.light(emission.radiance)
    if emission.exitance is not None:
        return photometry.radiance_from_exitance(palette.light(emission.exitance))
    white = palette.light(NEUTRAL)
    if emission.luminance is not None:
        return photometry.radiance_from_luminance(emission.luminance, white)
    if area == 0:
        return np.zeros(palette.bands.count)
    if emission.radiant_flux is not None:
        return photometry.radiance_from_radiant_flux(palette.light(emission.radiant_flux), area)
    return photometry.radiance_from_luminous_flux(emission.luminous_flux, area, white)
