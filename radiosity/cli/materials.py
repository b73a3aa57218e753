"""``radiosity materials``."""

import json
from pathlib import Path

from radiosity.cli import options as o


def materials(scene: o.SceneFile, as_json: o.Json = False) -> None:
    """Print what each material was read as, as tables for a scene file.

    Example: radiosity materials room.glb
    """
    from radiosity.scene.files import load

    found = read_as(load(scene), scene)
    if as_json:
        print(json.dumps(found, indent=2))
        return
    print("\n\n".join(f"# {said['origin']}\n{toml(name, said)}" for name, said in found.items()))


def read_as(scene, path: str) -> dict[str, dict]:
    """Return by name where a material comes from, and its table."""
    from radiosity.scene.assemble import DEFAULT_REFLECTANCE

    own, found = _own(path), {}
    for material in scene.materials:
        name = material.name
        said = scene.read_as.get(name)
        if said is not None:
            found[name] = {"origin": said.origin, "table": said.table}
        elif name in own:
            found[name] = {"origin": "as this scene file has it", "table": own[name]}
        else:
            table = {"diffuse": DEFAULT_REFLECTANCE}
            found[name] = {"origin": "defined nowhere, taken by default", "table": table}
    return found


def _own(path):
    """Return the tables of the materials that a scene file defines itself."""
    import tomllib

    if Path(path).suffix.lower() != ".toml":
        return {}
    return tomllib.loads(Path(path).read_text("utf-8-sig")).get("materials", {})


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
    return json.dumps(value, ensure_ascii=False)


def _key(key) -> str:
    from radiosity.scene.schema import dotted

    return dotted((key,))
