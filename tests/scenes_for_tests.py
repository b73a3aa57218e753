"""Small scenes in code: boxes, blocks, sheets, L-rooms and spheres."""

import numpy as np

from radiosity.mesh.contact import find_contacts
from radiosity.mesh.division import Division
from radiosity.mesh.faces import Faces
from radiosity.mesh.patches import make_patches
from radiosity.scene.model import Material, Scene
from radiosity.transport.lookup import make_table
from radiosity.transport.visibility import Visibility

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
TRIANGLE = np.array([[0, 0, 0], [2, 0.3, 0], [0.4, 1.5, 0], [0.4, 1.5, 0]])
SKEW = np.array([[0, 0, 0], [3, 0.2, 0], [2, 1, 0], [0.5, 1.5, 0]])


def box(low, high):
    """Return a room's faces (6, 4, 3), floor, ceiling, x0, x1, y0, y1, seen from inside."""
    (x, y, z), (X, Y, Z) = low, high
    return np.array(
        [
            [[x, y, z], [X, y, z], [X, Y, z], [x, Y, z]],
            [[x, y, Z], [x, Y, Z], [X, Y, Z], [X, y, Z]],
            [[x, y, z], [x, Y, z], [x, Y, Z], [x, y, Z]],
            [[X, y, z], [X, y, Z], [X, Y, Z], [X, Y, z]],
            [[x, y, z], [x, y, Z], [X, y, Z], [X, y, z]],
            [[x, Y, z], [X, Y, z], [X, Y, Z], [x, Y, Z]],
        ],
        float,
    )


def block(low, high, bottom=True):
    """Return the faces of a solid box, seen from outside; the bottom is the first of them."""
    return box(low, high)[:, ::-1][0 if bottom else 1 :]


def l_room(height=3.0):
    """Return the 8 faces of the L-shaped room of Pinney & Bean (View3D test4), 3 x 3 with a leg."""
    z = height
    outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    walls = [
        [(*b, 0), (*a, 0), (*a, z), (*b, z)]
        for a, b in zip(outline, outline[1:] + outline[:1], strict=True)
    ]
    halves = np.array([[(0, 0), (3, 0), (3, 1), (0, 1)], [(0, 1), (1, 1), (1, 3), (0, 3)]], float)
    floor = np.dstack([halves, np.zeros((2, 4))])
    ceiling = np.dstack([halves, np.full((2, 4), z)])[:, ::-1]
    return np.concatenate([floor, ceiling, np.array(walls, float)])


def uv_sphere(n):
    """Return the inside of a unit sphere as 2 n slices in n rings, vertices on the sphere."""
    theta = np.linspace(0, np.pi, n + 1)
    phi = np.linspace(0, 2 * np.pi, 2 * n + 1)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    grid = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=2)
    grid[:, -1], grid[0], grid[-1] = grid[:, 0], [0, 0, 1], [0, 0, -1]
    quads = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=2)
    quads[0] = quads[0][:, [1, 2, 3, 3]]  # the pole's quadrilaterals are triangles
    quads[-1] = quads[-1][:, [0, 1, 2, 2]]
    return quads.reshape(-1, 4, 3)


def tetrahedron():
    """Return the inside of a regular tetrahedron (4, 4, 3)."""
    v = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
    outside = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    return v[outside][:, [2, 1, 0, 0]]


def faces_of(polygons, material=0):
    return Faces.from_polygons(polygons, material, 0, merge=False)


def halves(polygons):
    """Return the triangles (2 n, 4, 3) that quadrilaterals (n, 4, 3) consist of."""
    return polygons[:, [[0, 1, 2, 2], [0, 2, 3, 3]]].reshape(-1, 4, 3)


def material(reflectance=0.5, exitance=0.0, two_sided=True, name="wall"):
    """Return a material; ``exitance`` is M_e in W/m2, a number for all bands or three."""
    rho = np.broadcast_to(np.asarray(reflectance, float), 3).copy()
    emitted = np.broadcast_to(np.asarray(exitance, float), 3) / np.pi
    return Material(name, rho, 1 - rho, emitted, two_sided=two_sided)


def scene(polygons, reflectance=0.5, exitance=0.0, two_sided=True, **more):
    """Return a scene in which every face has a material of its own, numbers or one a face."""
    polygons = np.asarray(polygons, float)
    n = len(polygons)
    rho = np.asarray(reflectance, float)
    rho = np.broadcast_to(rho.reshape(*rho.shape, *[1] * (2 - rho.ndim)), (n, 3))
    emitted = np.asarray(exitance, float)
    emitted = np.broadcast_to(emitted.reshape(*emitted.shape, *[1] * (2 - emitted.ndim)), (n, 3))
    materials = tuple(material(rho[k], emitted[k], two_sided, name=f"m{k}") for k in range(n))
    return Scene("test", faces_of(polygons, np.arange(n)), materials, ("all",), **more)


def rotation(rng):
    """Return a random rotation (3, 3)."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


def ring(rng, corners, size):
    """Return a random convex polygon about the origin."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    flat = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return flat * rng.uniform(0.5, 1, 3) * size @ rotation(rng).T


def normal_of(polygon):
    across = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
    return across / np.linalg.norm(across)


def meshed(faces, n, emits=None):
    """Return visibility, table and patches of faces divided n x n."""
    emits = np.zeros(len(faces), bool) if emits is None else np.asarray(emits, bool)
    shape = np.where(faces.is_triangle[:, None], [n, 0], [n, n])
    patches = make_patches(faces, Division(shape), find_contacts(faces, emits))
    return Visibility(faces), make_table(faces, patches), patches


def mean_of(values, patches, face, weight=None):
    """Return the area-weighted mean of values (n, ...) over the fronts of a face."""
    mine = (patches.face == face) & patches.front
    return np.average(values[mine], axis=0, weights=patches.area[mine])
