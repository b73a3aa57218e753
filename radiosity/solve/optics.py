"""From a scene's materials to what rays need that are followed along single directions."""

import numpy as np

from radiosity.scene.model import Material, Scene
from radiosity.transport.curved import smooth_normals
from radiosity.transport.lookup import Table
from radiosity.transport.optics import Optics, Side


def make_optics(scene: Scene, table: Table) -> Optics:
    """Return how the faces of a scene send light on along single directions."""
    faces = scene.faces
    normal = faces.normals()
    smooth = None
    if faces.is_curved.any():

        def smooth(face, points):
            return smooth_normals(faces, table, normal[face], face, points)

    sides = tuple(_sides_of(m) for m in scene.materials)
    return Optics(faces.material, sides, _absorption(scene), normal, smooth)


def different_bands(scene: Scene) -> int:
    """Return in how many ways the bands of a scene are sent on."""
    sides, absorption = tuple(_sides_of(m) for m in scene.materials), _absorption(scene)
    none = np.zeros((0, 3))
    optics = Optics(np.zeros(0, int), sides, absorption, none)
    return len(optics.different_bands()[0])


def _absorption(scene):
    """Return (materials, bands) in 1/scene unit."""
    found = np.zeros((len(scene.materials), scene.bands.count))
    for k, m in enumerate(scene.materials):
        if m.absorption is not None:
            found[k] = m.absorption * scene.unit_m
    return found


def _sides_of(material: Material) -> tuple[Side | None, Side | None]:
    """Return front and back; a clear body is seen from outside and from inside."""
    lobe, mirror, passage = material.specular, material.mirror, material.transmit
    if lobe is None and mirror is None and passage is None:
        return None, None
    front = Side(lobe, mirror, passage)
    if getattr(passage, "index", None) is not None:
        behind = mirror.behind if mirror is not None else None
        return front, Side(lobe, behind, passage.behind)
    return front, front if material.two_sided else None
