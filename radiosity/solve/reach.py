"""From faces to the patches that light can reach, and what rays need to find them."""

from dataclasses import dataclass

import numpy as np

from radiosity.mesh.contact import Contacts, find_contacts
from radiosity.mesh.division import Division
from radiosity.mesh.facets import merge_facets
from radiosity.mesh.patches import Patches, make_patches
from radiosity.scene.model import Scene
from radiosity.solve.system import goes_through, lights_of
from radiosity.transport.facing import settled
from radiosity.transport.lookup import Table, make_table
from radiosity.transport.survey import sides_that_see_out, survey
from radiosity.transport.threads import Progress, silent
from radiosity.transport.visibility import Visibility


@dataclass(frozen=True)
class Reach:
    """The meshed scene and where light gets to in it.

    Attributes
    ----------
    patches : Patches
        All fronts, and the backs that light reaches.
    live : (n,) bool
        Patches that light reaches.
    visibility : Visibility
    table : Table
    contacts : Contacts
    """

    patches: Patches
    live: np.ndarray
    visibility: Visibility
    table: Table
    contacts: Contacts


def find_reach(
    scene: Scene, division: Division, seed: int, force: bool = False, like: Reach | None = None,
    progress: Progress = silent,
) -> Reach:  # fmt: skip
    """Divide the faces into cells and follow the light from its sources.

    ``force`` takes every face for one that can block. What does not depend on the mesh is taken
    from ``like``, of the same scene.
    """
    progress("mesh", 0, 1)
    emits = np.array([m.emits for m in scene.materials])[scene.faces.material]
    if like is None:
        facets = merge_facets(scene.faces)
        visibility = Visibility(scene.faces, facets, force)
        contacts = find_contacts(scene.faces, emits, facets=facets)
        contacts = settled(contacts, scene.faces, visibility)
    else:
        contacts, visibility = like.contacts, like.visibility
    cells = make_patches(scene.faces, division, contacts)
    table = make_table(scene.faces, cells)
    sources = np.zeros((cells.fronts, 2), bool)
    sources[:, 0] = emits[cells.face]
    if scene.ambient.any():
        sources |= sides_that_see_out(visibility, table, cells, seed)
    through = goes_through(scene)[scene.faces.material[cells.face]]
    lights = lights_of(scene)
    front, back = survey(visibility, table, cells, sources, lights, seed, through).T
    patches = cells.with_backs(back)
    live = np.concatenate([front, back[back]])
    progress("mesh", 1, 1)
    return Reach(patches, live, visibility, table, contacts)
