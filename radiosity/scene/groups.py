"""Groups of light: what is dimmed together, and a scene of whose light some is dimmed."""

import difflib
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from radiosity.light.bands import Bands
from radiosity.light.texture import Mixed, Texture
from radiosity.scene.model import Material, Scene

AMBIENT = "ambient"
BRIGHTEST = 1e6  # factor by which light may be made brighter
PER_BAND = "share", "reflectance", "index"  # of the laws of lobes, mirrors and clear bodies


def light_groups(scene: Scene) -> tuple[str, ...]:
    """Return the names of what may be dimmed: lights, then materials that emit, then ambient light.

    Lights go by their group, those without by their type and number, as ``point 1``; faces by the
    name of their material. What has the same name is one group.

    Examples
    --------
    >>> import radiosity
    >>> light_groups(radiosity.load("scenes/cornell_box.toml"))
    ('light',)
    """
    used = np.unique(scene.faces.material)
    emitting = [scene.materials[k].name for k in used if scene.materials[k].emits]
    outside = [AMBIENT] if scene.ambient.any() else []
    return tuple(dict.fromkeys([*groups_of_lights(scene), *emitting, *outside]))


def groups_of_lights(scene: Scene) -> list[str]:
    """Return the group of each abstract light."""
    names, seen = [], Counter()
    for light in scene.lights:
        kind = type(light).__name__.lower()
        seen[kind] += 1
        names.append(light.group or f"{kind} {seen[kind]}")
    return names


def checked_factors(names: tuple[str, ...], factors: Mapping[str, float]) -> dict[str, float]:
    """Return a factor of every group, 1 where none is given.

    Raises
    ------
    ValueError
        A name that no group has, with the nearest that one has; a factor that is none.
    """
    for name, factor in factors.items():
        if name not in names:
            like = difflib.get_close_matches(name, names, 1)
            meant = f"did you mean {like[0]!r}? " if like else ""
            known = ", ".join(map(repr, names)) or "none"
            raise ValueError(f"no light is called {name!r}: {meant}Groups of light are {known}")
        if not 0.0 <= factor <= BRIGHTEST:
            raise ValueError(
                f"the factor of {name!r}, {factor:g}, must lie in [0, {BRIGHTEST:g}]: 0 is off, 1 "
                "leaves it as it is"
            )
    return {name: float(factors.get(name, 1.0)) for name in names}


def material_factors(scene: Scene, factors: Mapping[str, float]) -> np.ndarray:
    """Return (materials,) the factors of what materials emit."""
    return np.array([factors.get(m.name, 1.0) for m in scene.materials])


def dimmed(scene: Scene, factors: Mapping[str, float]) -> Scene:
    """Return a scene with its groups of light scaled, those that are not named left as they are.

    The answer that it carries, if any, is left out: it holds for all of the light.

    Raises
    ------
    ValueError
        See `checked_factors`.

    Examples
    --------
    >>> import radiosity
    >>> scene = dimmed(radiosity.load("scenes/cornell_box.toml"), {"light": 0.5})
    >>> scene.materials[3].emission.tolist()
    [8.5, 6.0, 2.0]
    """
    return scaled(scene, checked_factors(light_groups(scene), factors))


def scaled(scene: Scene, factors: Mapping[str, float]) -> Scene:
    """Return what `dimmed` does, for names of groups that the scene may have lost."""
    if all(factor == 1.0 for factor in factors.values()):
        return scene
    emitting = material_factors(scene, factors)
    materials = tuple(
        replace(m, emission=x * m.emission)
        for m, x in zip(scene.materials, emitting, strict=True)
    )
    lights = tuple(
        light.of_strength(factors.get(name, 1.0) * light.strength)
        for light, name in zip(scene.lights, groups_of_lights(scene), strict=True)
    )
    ambient = factors.get(AMBIENT, 1.0) * scene.ambient
    return replace(scene, materials=materials, lights=lights, ambient=ambient, truth=None)


def apart(scene: Scene, names: tuple[str, ...]) -> Scene:
    """Return a scene that has each group of light in bands of its own, in the order of ``names``.

    Its surfaces do to all of these what they do to the scene's: solved once, it tells what each
    group does by itself.
    """
    count, bands = scene.bands.count, scene.bands
    which = np.tile(np.arange(count), len(names))

    def put(values, name):
        found = np.zeros((len(names), count))
        found[names.index(name)] = values
        return found.ravel()

    materials = []
    for m in scene.materials:
        emission = put(m.emission, m.name) if m.name in names else np.zeros(len(which))
        materials.append(replace(_in_bands(m, which, count), emission=emission))
    lights = tuple(
        light.of_strength(put(light.strength, name))
        for light, name in zip(scene.lights, groups_of_lights(scene), strict=True)
    )
    ambient = put(scene.ambient, AMBIENT) if AMBIENT in names else np.zeros(len(which))
    titles = tuple(f"{band} of {name}" for name in names for band in bands.names)
    made = Bands(titles, bands.rgb[:, which], bands.y[which])
    return replace(
        scene, materials=tuple(materials), lights=lights, ambient=ambient, bands=made, truth=None
    )


def _in_bands(m: Material, which, count) -> Material:
    """Return a material of which band k is band ``which[k]`` of one of ``count`` bands."""
    more = {
        name: None if getattr(m, name) is None else getattr(m, name)[which]
        for name in ("diffuse", "absorptance", "translucent", "absorption")
    }
    laws = {
        name: _law_in_bands(getattr(m, name), which, count)
        for name in ("specular", "mirror", "transmit")
    }
    return replace(m, texture=_texture_in_bands(m.texture, which), **more, **laws)


def _law_in_bands(law, which, count):
    if law is None:
        return None
    values = {name: getattr(law, name, None) for name in PER_BAND}
    return replace(law, **{
        name: x[which] for name, x in values.items() if x is not None and np.shape(x) == (count,)
    })  # fmt: skip


def _texture_in_bands(texture, which):
    if texture is None:
        return None
    if isinstance(texture, Mixed):
        return replace(texture, shares=texture.shares[which])
    if texture.bands == 3:  # a picture is not to be kept many times
        return Mixed(texture, np.eye(3)[which])
    return Texture(texture.texels[..., which], texture.repeat)
