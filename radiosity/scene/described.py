"""Described: what geometry files say beside their faces, among the tables of a scene file."""

from radiosity.scene.geometry import Geometry, free_name
from radiosity.scene.model import ReadAs

AS_IT_IS = "as the scene file has it"  # where materials of scene files come from


def with_described(raw: dict, geometry: Geometry) -> dict:
    """Return the tables of a scene file with those of its geometry files.

    Of materials those that faces have and the scene file does not define; lights come after its
    own; cameras whose names are taken get a number.
    """
    own = {key: raw.get(key, kind()) for key, kind in (("materials", dict), ("lights", list))}
    cameras = raw.get("cameras", {})
    found = dict(raw)
    if isinstance(own["materials"], dict):
        brought = {name: said.table for name, said in _used(own["materials"], geometry).items()}
        found["materials"] = own["materials"] | brought
    if isinstance(own["lights"], list):
        found["lights"] = [*own["lights"], *geometry.lights]
    if isinstance(cameras, dict):
        more = {free_name(name, cameras): table for name, table in geometry.cameras.items()}
        found["cameras"] = cameras | more
    return found


def read_as(raw: dict, geometry: Geometry) -> dict[str, ReadAs]:
    """Return how the materials were read that ``raw``, with those of geometry files, has of them.

    A scene file's own tables are what they are.
    """
    found = {name: ReadAs(AS_IT_IS, x) for name, x in raw["materials"].items()}
    return found | {
        name: said for name, said in geometry.materials.items()
        if name in found and found[name].table is said.table
    }  # fmt: skip


def _used(own, geometry):
    """Return what geometry files say of materials that faces have and ``own`` does not define."""
    names = (n for n in geometry.material_names if n not in own and n in geometry.materials)
    return {name: geometry.materials[name] for name in names}
