"""``radiosity materials``."""

import json

from radiosity.cli import options as o
from radiosity.cli.session import scene_of


def materials(scene: o.SceneFile, as_json: o.Json = False) -> None:
    """Print what each material of the files was read as, as tables for a scene file.

    Beside each stands where it comes from. With --json an object of the materials by their names.

    Examples
    --------
    radiosity materials scenes/cornell_box.obj
    radiosity materials scenes/cornell_box.obj --json
    """
    from radiosity.solve.load import load

    found = read_as(scene_of(load(scene)))
    if as_json:
        print(json.dumps(found, indent=2))
        return
    print("\n\n".join(f"# {said['origin']}\n{toml(name, said)}" for name, said in found.items()))


def read_as(scene) -> dict[str, dict]:
    """Return by name where a material comes from, and its table."""
    from radiosity.scene.assemble import DEFAULT_REFLECTANCE
    from radiosity.scene.model import ReadAs

    default = ReadAs("defined nowhere, taken by default", {"diffuse": DEFAULT_REFLECTANCE})
    return {m.name: vars(scene.read_as.get(m.name, default)) for m in scene.materials}


def toml(name: str, said: dict) -> str:
    """Return a material as TOML that can stand in a scene file."""
    from radiosity.scene.schema import dotted

    lines = [f"{_key(key)} = {_value(value)}" for key, value in said["table"].items()]
    return "\n".join([f"[{dotted(('materials', name))}]", *lines])


def _value(value) -> str:
    """Return a value as TOML writes it, as JSON does but for tables."""
    if isinstance(value, dict):
        inside = ", ".join(f"{_key(key)} = {_value(v)}" for key, v in value.items())
        return f"{{ {inside} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    from radiosity.scene.schema import quoted

    return quoted(value) if isinstance(value, str) else json.dumps(value)


def _key(key) -> str:
    from radiosity.scene.schema import dotted

    return dotted((key,))
