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

POINTS, RAYS = 8, 32  # on what two faces share, and from each of them on either side
SAME = 1e-6  # share by which the areas of a sheet's two sides may differ
UNSURE, APART, TOGETHER = 0, 1, -1


def settled(contacts: Contacts, faces: Faces, visibility: Visibility) -> Contacts:
    """Return the contacts, faces that stand back to back hidden there instead of covered.

    Those are pairs of opposite normals from both of which mostly fronts are seen somewhere, or that
    have the same corners and from neither of which mostly backs are seen: a sheet's two sides.
    """
    normals = faces.normals()
    pairs = {
        (min(f, g), max(f, g))
        for f, contact in contacts.faces.items()
        for g, _ in contact.covers
        if normals[f] @ normals[g] < 0
    }
    if not pairs:
        return contacts
    pairs = np.array(sorted(pairs))
    apart = {}
    for f, g in pairs[_kinds(pairs, contacts, faces, visibility) == APART].tolist():
        apart.setdefault(f, set()).add(g)
        apart.setdefault(g, set()).add(f)
    found = dict(contacts.faces)
    for f in apart.keys() & found.keys():
        others, covers, hides = apart[f], found[f].covers, found[f].hides
        hides = hides + [cover for cover in covers if cover[0] in others]
        covers = [cover for cover in covers if cover[0] not in others]
        found[f] = replace(found[f], covers=covers, hides=hides)
    return Contacts(found)


def _kinds(pairs, contacts, faces, visibility):
    """Return (p,) APART or TOGETHER for pairs (p, 2) of faces.

    Which face of a pair a ray meets is chance: that tells nothing before the pair is settled, so
    pairs are settled from those on that see others.
    """
    v, normals = faces.vertices, faces.normals()
    shared = [common(v[f], v[g], normals[f]) for f, g in pairs]
    shared = [p if len(p) > 2 else v[f] for p, (f, _) in zip(shared, pairs, strict=True)]
    area = 0.5 * np.linalg.norm([twice_area(polygon) for polygon in shared], axis=1)
    same = np.all(np.abs(faces.areas()[pairs] - area[:, None]) <= SAME * area[:, None], axis=1)
    points = np.array([_spread(polygon) for polygon in shared])
    met, front = _look(points, pairs, contacts, normals, visibility)
    kind = np.full(len(pairs), UNSURE)
    while True:
        free, shut, dark = _seen(met, front, pairs, kind, len(faces))
        sure = np.where(shut.any(axis=0), TOGETHER, np.where(free.all(axis=0), APART, UNSURE))
        bare = dark.any(axis=0) & (dark | free).all(axis=0)
        sure[bare] = np.where(same[bare], APART, TOGETHER)
        new = np.where(kind == UNSURE, sure, kind)
        if np.array_equal(new, kind):
            break
        kind = new
    rest = np.where(same | ~dark.any(axis=0), APART, TOGETHER)
    return np.where(kind == UNSURE, rest, kind)


def _look(points, pairs, contacts, normals, visibility):
    """Return (2, p, POINTS, RAYS) the faces that rays from both sides meet, and if their fronts.

    None, -1, where a face that looks the same way covers the point.
    """
    p, seen = len(pairs), []
    for side in range(2):
        out = np.repeat(normals[pairs[:, side]], POINTS, axis=0)
        rays = rays_from(
            visibility, points.reshape(-1, 3), out, np.arange(len(out)), range(RAYS), side
        )
        met, _ = visibility.first_hits(*rays)
        front = np.einsum("rc,rc->r", rays[1], visibility.face_normal[met]) < 0
        met = met.reshape(p, POINTS, RAYS)
        for k, f in enumerate(pairs[:, side].tolist()):
            alike = _alike(contacts.faces.get(f), normals)
            if alike is not None:
                met[k, alike.behind(points[k])[:, 0] >= 0] = -1
        seen.append((met, front.reshape(met.shape)))
    return (np.array(x) for x in zip(*seen, strict=True))


def _alike(contact, normals):
    """Return a face's contact with those that cover it and look the same way; None if none do."""
    covers = [] if contact is None else contact.covers
    alike = [(g, p) for g, p in covers if normals[g] @ contact.normal > 0]
    return replace(contact, covers=alike) if alike else None


def _seen(met, front, pairs, kind, faces):
    """Return (2, p) whether sides see mostly fronts somewhere, else mostly backs, or nothing."""
    both = pairs.ravel()
    unsure, apart, together = (
        np.bincount(both, np.repeat(kind == k, 2), faces) > 0 for k in (UNSURE, APART, TOGETHER)
    )
    front = np.where(apart[met], True, np.where(together[met], False, front))
    some, told = met >= 0, (met >= 0) & ~unsure[met]
    fronts, backs, hits = (np.sum(x, axis=-1) for x in (told & front, told & ~front, some))
    free = (2 * fronts > hits).any(axis=-1)
    backs, hits = backs.sum(axis=-1), hits.sum(axis=-1)
    return free, ~free & (hits > 0) & (2 * backs >= hits), hits == 0


def _spread(polygon):
    """Return (POINTS, 3) points spread over a convex polygon: of its fan of triangles in turn."""
    triangles = np.stack(
        [np.broadcast_to(polygon[0], polygon[2:].shape), polygon[1:-1], polygon[2:]], axis=1
    )
    size = np.linalg.norm(np.cross(*np.diff(triangles, axis=1).swapaxes(0, 1)), axis=1)
    upto = np.cumsum(size) / size.sum()
    k = np.arange(POINTS)
    which = np.searchsorted(upto, (k + 0.5) / POINTS)
    s, t = np.sqrt((k * 0.618034 + 0.5) % 1.0)[:, None], ((k * 0.754878 + 0.5) % 1.0)[:, None]
    a, b, c = triangles[which].swapaxes(0, 1)
    return (1 - s) * a + s * ((1 - t) * b + t * c)
