"""Whether what a ``.radsol`` file holds fits together, before compiled code is let near it."""

import numpy as np

from radiosity.scene.geometry import LONGEST
from radiosity.solve.relight import PARTS

FINEST = 1 << 15  # cells along an edge of a face
WIDEST = 16384  # pixels of a camera's picture
MOST_RAYS = 1 << 24  # of a recipe, from a point or a node


def problem_of(saved) -> str | None:
    """Return the first thing that is wrong with a `radiosity.solve.container.Saved`, or None."""
    checks = (_scene, _lights_and_cameras, _contacts, _meshes, _levels, _estimate, _shares)
    return next(filter(None, (check(saved) for check in checks)), None)


def _shaped(where, value, shape, kind="f", finite=True) -> str | None:
    """Return what is wrong with an array: None in ``shape`` stands for any length."""
    fits = value.ndim == len(shape) and all(
        b is None or a == b for a, b in zip(value.shape, shape, strict=False)
    )
    if not fits or value.dtype.kind not in kind:
        return f"{where} is {value.dtype} {value.shape}, must be {kind} {shape}"
    if finite and kind == "f" and not np.isfinite(value).all():
        return f"{where} holds numbers that are not finite"
    return None


def _inside(where, value, count, least=0) -> str | None:
    """Return what is wrong with indices (k,) of so many things."""
    if value.size and not (value.min() >= least and value.max() < count):
        return f"{where} holds an index outside of [{least}, {count})"
    return None


def _first(*problems) -> str | None:
    return next(filter(None, problems), None)


def _scene(saved):
    scene, faces = saved.scene, saved.scene.faces
    f, bands = len(faces.vertices), scene.bands
    optional = {"uv": (f, 4, 2), "corner_normals": (f, 4, 3)}
    n = len(bands.names)
    if not f or not scene.materials or not n or not (np.isfinite(scene.unit_m) and scene.unit_m):
        return "the scene has no faces, materials, bands or unit"
    if not np.all(np.abs(faces.vertices) <= LONGEST):
        return f"faces.vertices must be finite and at most {LONGEST:g}"
    return _first(
        _shaped("faces.vertices", faces.vertices, (f, 4, 3)),
        _shaped("faces.material", faces.material, (f,), "i"),
        _shaped("faces.group", faces.group, (f,), "i"),
        _inside("faces.material", faces.material, len(scene.materials)),
        _inside("faces.group", faces.group, len(scene.groups)),
        *(_shaped(f"faces.{name}", getattr(faces, name), shape, finite=False)
          for name, shape in optional.items() if getattr(faces, name) is not None),
        _shaped("bands.rgb", bands.rgb, (3, n)), _shaped("bands.y", bands.y, (n,)),
        _shaped("ambient", scene.ambient, (n,)),
        *(_shaped(f"materials.{m.name}.absorption", m.absorption, (n,))
          for m in scene.materials if m.absorption is not None),
        *(_shaped(f"materials.{m.name}.{name}", texels, (None, None, None))
          for m in scene.materials for name, texels in _pictures(m)),
    )  # fmt: skip


def _pictures(m):
    """Yield the texels of a material's pictures, which nothing else looks at."""
    for name, part in (("bump", m.bump), ("shininess", m.shininess)):
        if part is not None:
            yield name, part.texture.texels


def _lights_and_cameras(saved):
    vectors = {"position": (3,), "axis": (3,), "direction": (3,), "frame": (3, 3)}
    places = [
        (f"lights[{k}].{name}", getattr(light, name), shape)
        for k, light in enumerate(saved.scene.lights)
        for name, shape in vectors.items() if hasattr(light, name)
    ]  # fmt: skip
    for name, camera in saved.scene.cameras.items():
        parts = ("position", "target", "up")
        places += [(f"cameras.{name}.{x}", getattr(camera, x), (3,)) for x in parts]
        if not all(1 <= n <= WIDEST for n in camera.size):
            return f"cameras.{name}.size = {camera.size} must lie in [1, {WIDEST}]"
    for where, place, shape in places:
        if not isinstance(place, np.ndarray):
            return f"{where} is no array"
        problem = _shaped(where, place, shape)
        if problem:
            return problem
    return None


def _contacts(saved):
    count = len(saved.scene.faces)
    for face, contact in saved.contacts.faces.items():
        where, parts = f"contacts[{face}]", [*contact.covers, *contact.hides]
        if not 0 <= face < count or not all(
            isinstance(p, tuple) and len(p) == 2 and type(p[0]) is int and 0 <= p[0] < count
            and isinstance(p[1], np.ndarray) for p in parts
        ):  # fmt: skip
            return f"{where} names a face that does not exist"
        problem = _first(
            _shaped(f"{where}.segments", contact.segments, (None, 2, 3)),
            _shaped(f"{where}.normal", contact.normal, (3,)),
            *(_shaped(f"{where}.covers", p[1], (None, 3)) for p in parts),
        )
        if problem:
            return problem
    return None


def _meshes(saved):
    if saved.level.mesh is None:
        return "the solution has no mesh"
    return _first(*(
        _mesh(f"{name}.mesh", level.mesh, saved.scene.faces)
        for name, level in (("level", saved.level), ("check", saved.check))
        if level.mesh is not None
    ))  # fmt: skip


def _mesh(where, mesh, faces):
    """Return what is wrong with a mesh; no cell is made before their number is known."""
    division, fronts = mesh.division, len(mesh.backs)
    problem = _first(
        _shaped(f"{where}.division", division.shape, (len(faces), 2), "i"),
        _shaped(f"{where}.backs", mesh.backs, (None,), "b"),
        _shaped(f"{where}.live", mesh.live, (fronts + int(mesh.backs.sum()),), "b"),
    )
    if problem:
        return problem
    columns, rows = division.shape.T
    if not np.array_equal(rows == 0, faces.is_triangle) or not (
        columns.min() >= 1 and columns.max() <= FINEST and rows.min() >= 0 and rows.max() <= FINEST
    ):
        return f"{where}.division must hold from 1 to {FINEST} cells along each edge"
    count = float(np.sum(np.where(rows == 0, columns, rows) * columns.astype(float)))
    for split in division.splits:
        if split.dtype.kind != "i" or split.shape != (count,) or not (
            split.min(initial=1) >= 1 and split.max(initial=1) <= FINEST
        ):
            return f"{where}.division.splits must hold a number from 1 to {FINEST} for each cell"
        count = float(np.sum(split.astype(float) ** 2))
    if count > fronts:
        return f"{where}.division has {count:.0f} cells, of which {fronts} patches are told"
    return None


def _levels(saved):
    live = saved.level.mesh.live
    other = live if saved.check.mesh is None else saved.check.mesh.live
    if saved.check.clustered != saved.level.clustered:
        return "one level alone has clusters"
    return _first(
        _level("level", saved.level, int(live.sum()), saved.scene.bands.count),
        _level("check", saved.check, int(other.sum()), saved.scene.bands.count),
    )


def _level(where, level, m, bands):
    recipe = level.recipe
    if level.order not in (0, 1) or recipe.order not in (0, 1):
        return f"{where}.order must be 0 or 1"
    if not 0 <= recipe.seed < 1 << 32:
        return f"{where}.recipe.seed must lie in [0, {1 << 32})"
    if not all(0 <= n <= MOST_RAYS for n in (recipe.rays, recipe.chained)):
        return f"{where}.recipe asks for rays outside of [0, {MOST_RAYS}]"
    if not level.history or not all(isinstance(x, float | int) for x in level.history):
        return f"{where}.history must hold numbers"
    width = 3 if recipe.order == 1 else 1
    return _first(
        _shaped(f"{where}.outside", level.outside, (width * m,)),
        _shaped(f"{where}.tolerance", level.tolerance, (0 if level.clustered else m,)),
        _share(f"{where}.share", level.share, (), _lengths(level, m), bands),
    )


def _lengths(level, m) -> dict[str, int]:
    """Return how many coefficients the fields of a level have."""
    field = m * (3 if level.recipe.order == 1 else 1)
    own = dict.fromkeys(PARTS, field)
    return own | {"coefficients": m * (3 if level.order == 1 else 1), "escaping": m}


def _share(where, share, groups, lengths, bands):
    return _first(*(
        _shaped(f"{where}.{name}", getattr(share, name), (*groups, length, bands))
        for name, length in lengths.items()
    ))  # fmt: skip


def _estimate(saved):
    estimate, m = saved.estimate, int(saved.level.mesh.live.sum())
    k = len(estimate.patches)
    return _first(
        _shaped("estimate.patches", estimate.patches, (k,), "i"),
        _inside("estimate.patches", estimate.patches, m),
        _shaped("estimate.found", estimate.found, (k, saved.scene.bands.count)),
    )


def _shares(saved):
    parts = saved.shares, saved.check_shares
    if (parts[0] is None) != (parts[1] is None):
        return "shares are told of one level alone"
    if parts[0] is None:
        return None
    live = saved.level.mesh.live
    lives = live, live if saved.check.mesh is None else saved.check.mesh.live
    return _first(*(
        _share("shares", part, (len(saved.groups),), _lengths(level, int(lit.sum())),
               saved.scene.bands.count)
        for part, level, lit in zip(parts, (saved.level, saved.check), lives, strict=True)
    ))  # fmt: skip
