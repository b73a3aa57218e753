"""Light groups: what is dimmed together, and a scene of whose light some is dimmed."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from radiosity.light.sources import Light
from radiosity.scene.model import Scene
from radiosity.scene.names import UnknownName

AMBIENT = "ambient"
BRIGHTEST = 1e6  # factor by which light may be made brighter


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


def kind_of_light(light: Light) -> str:
    """Return the ``type`` that a scene file gives a light."""
    name = type(light).__name__.lower()
    return {"luminaire": "ies"}.get(name, name)


def groups_of_lights(scene: Scene) -> list[str]:
    """Return the group of each abstract light."""
    names, seen = [], Counter()
    for light in scene.lights:
        kind = kind_of_light(light)
        seen[kind] += 1
        names.append(light.group or f"{kind} {seen[kind]}")
    return names


def checked_factors(names: tuple[str, ...], factors: Mapping[str, float]) -> dict[str, float]:
    """Return a factor of every group, 1 where none is given.

    Raises
    ------
    UnknownName
        A name that no group has.
    ValueError
        A factor that is none.
    """
    if not isinstance(factors, Mapping):
        raise TypeError(f"{factors!r} must be factors by light group, such as {{'desk': 0.5}}")
    for name, factor in factors.items():
        if name not in names:
            raise UnknownName("light group", name, names)
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
    """Return a scene with its light groups scaled, those that are not named left as they are.

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
    told = ", ".join(f"{name} to {100.0 * x:g} %" for name, x in factors.items() if x != 1.0)
    notes = (*scene.notes, f"dimmed: {told}")
    return replace(
        scene, materials=materials, lights=lights, ambient=ambient, truth=None, notes=notes
    )
