"""Whether two faces that lie on each other look at each other or stand back to back, told by rays.

Geometry alone does not tell a block on a floor, inside of which nothing can be seen, from the walls
of two rooms in one place, or the sides of a sheet. Who looks around from a free place meets fronts;
from within a solid, or from behind a room's walls, backs.
"""

from dataclasses import replace

import numpy as np

from radiosity.mesh.contact import Contacts
from radiosity.mesh.cutting import common, twice_area
from radiosity.mesh.faces import Faces
from radiosity.transport.hemisphere import rays_from
from radiosity.transport.visibility import Visibility

RAYS = 32  # from each side
SAME = 1e-6  # share by which the areas of a sheet's two sides may differ


def settled(contacts: Contacts, faces: Faces, visibility: Visibility) -> Contacts:
    """Return the contacts, faces that stand back to back hidden there instead of covered.

    Those are pairs of opposite normals from both of which mostly fronts are seen, or that have the
    same corners and nothing around: the two sides of a sheet.
    """
    pairs, normals = [], faces.normals()
    for f, contact in contacts.faces.items():
        pairs += [(f, g) for g, _ in contact.covers if f < g and normals[f] @ normals[g] < 0]
    if not pairs:
        return contacts
    apart = {}
    for f, g in np.array(pairs)[_are_apart(np.array(pairs), faces, visibility)].tolist():
        apart.setdefault(f, set()).add(g)
        apart.setdefault(g, set()).add(f)
    found = dict(contacts.faces)
    for f in apart.keys() & found.keys():
        others = apart[f]
        covers, hides = found[f].covers, found[f].hides
        hides = hides + [cover for cover in covers if cover[0] in others]
        covers = [cover for cover in covers if cover[0] not in others]
        found[f] = replace(found[f], covers=covers, hides=hides)
    return Contacts(found)


def _are_apart(pairs, faces, visibility):
    """Return (p,) bool: whether faces of pairs (p, 2) stand back to back."""
    v, normals = faces.vertices, faces.normals()
    shared = [common(v[f], v[g], normals[f]) for f, g in pairs]
    middle = np.array([np.mean(polygon, axis=0) for polygon in shared])
    area = 0.5 * np.linalg.norm([twice_area(polygon) for polygon in shared], axis=1)
    same = np.all(np.abs(faces.areas()[pairs] - area[:, None]) <= SAME * area[:, None], axis=1)
    doubled = np.zeros(len(faces), bool)
    doubled[pairs] = True  # which of the two a ray meets is chance
    free = np.ones((len(pairs), 2), bool)
    around = np.zeros(len(pairs), bool)
    for side in range(2):
        out = normals[pairs[:, side]]
        origins, directions = rays_from(
            visibility, middle, out, np.arange(len(pairs)), range(RAYS), side
        )
        met, _ = visibility.first_hits(origins, directions)
        front = np.einsum("rc,rc->r", directions, visibility.face_normal[met]) < 0
        told = (met >= 0) & ~doubled[met]
        fronts, backs = (
            np.sum((told & kind).reshape(-1, RAYS), axis=1) for kind in (front, ~front)
        )
        some = (met >= 0).reshape(-1, RAYS).any(axis=1)
        free[:, side] = (fronts > backs) | (some & (fronts + backs == 0))
        around |= some
    return free.all(axis=1) | (same & ~around)
