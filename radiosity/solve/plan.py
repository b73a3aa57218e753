"""What reaching an accuracy takes: mesh, rays, samples and tolerance; and whether it fits."""

import os
from dataclasses import dataclass, replace
from numbers import Real

import numpy as np

from radiosity.mesh.division import Division, divisions
from radiosity.scene.model import Scene, SceneError

SOLVER_NAMES = ("gauss-seidel", "jacobi", "southwell", "gmres", "cg", "direct")
FEWEST = 150
MOST_LINEAR = 3000  # patches of order 1: their matrix has 9 n^2 entries
FIRST = 0.03  # accuracy that the first mesh is for, where no larger one is asked for
AS_GOOD_AS_CAN_BE, START = 1e-3, 0.2  # accuracies that a time is spent on: last and first
MOST_FACES = 400  # beyond which blockers are too many for exact shadows
CLUSTERS_AT_UNIT_ACCURACY, FEWEST_CLUSTERS, MOST_CLUSTERS = 60.0, 500, 6000
RAYS_AT_UNIT_ACCURACY = 1.5e5
CHAINED_AT_UNIT_ACCURACY, CHAINED = 2.0, (6, 10)  # rays from a node; powers of 2
# Of the accuracy: the solver's tolerance, and that of far factors where at least FADES of the light
# is absorbed at each bounce.
SOLVED, RULE, FADES, FINEST_RULE = 1e-5, 3e-2, 0.1, 1e-7
# Bytes at the peak a pair of patches; measured for order 0: 28 while closure is repaired, 39 with
# the direct solver (29 with the others); for order 1: 83 to 125. And a face, in the trees that are
# searched.
FACTORS, FACE, BYTES = 32, 2500, (40, 105)
# Patches for the accuracy 1: more as its inverse to the power MORE of linear elements, which are
# refined, and as its inverse of constant ones, whose order is 2 in the size of the patches.
PATCHES_AT_UNIT_ACCURACY, MORE, CONSTANT_AT_UNIT_ACCURACY = 9.0, 0.7, 24.0


class Refused(RuntimeError):
    """The plan needs more memory than it may take; nothing was computed.

    Examples
    --------
    >>> import radiosity
    >>> radiosity.solve(radiosity.load("scenes/box6.toml"), memory=1e5)
    Traceback (most recent call last):
    radiosity.solve.plan.Refused: 128 patches need about ..., more than the 85.0 kB allowed: ...
    """


@dataclass(frozen=True)
class Recipe:
    """How a mesh is solved.

    Attributes
    ----------
    order : int
        Of the elements, 0 or 1.
    factors : float
        Accuracy of form factors of order 0: bound of the summed errors of a row.
    rule : float
        Relative tolerance of the factors from points to far patches; 0 for exact sums.
    tolerance : float
        Of the solver, relative.
    solver : str
    seed : int
    rays : int
        That look around from a point where light is exchanged between clusters.
    counted : int
        Rays that count the factors between clusters, in all.
    chained : int
        Rays from each node of a mesh that are followed through mirrors, clear bodies and lobes.
    force : bool
        Model everything, also what the scene does not require.
    """

    order: int
    factors: float
    rule: float
    tolerance: float
    solver: str
    seed: int = 0
    rays: int = 256
    counted: int = 0
    chained: int = 0
    force: bool = False


@dataclass(frozen=True)
class Plan:
    """How a scene will be solved.

    Attributes
    ----------
    accuracy : float
        Asked bound of the relative error (95th percentile over the surfaces).
    division : Division
        Of the faces into cells; the first guess where ``adapts``.
    adapts : bool
        Whether the mesh is refined until the estimated error meets the accuracy.
    recipe : Recipe
    clusters : int
        Between how many of them light is exchanged; 0 where it is between patches.
    seconds : float or None
        Time to take for an answer that is as good as can be, where that is asked for.
    """

    accuracy: float
    division: Division
    adapts: bool
    recipe: Recipe
    clusters: int = 0
    seconds: float | None = None

    def _repr_html_(self) -> str:
        """Return it as a notebook shows it."""
        from radiosity.solve.overview import plan_html

        return plan_html(self)


def make_plan(
    scene: Scene, accuracy: float, mesh: str = "auto", *, order: int | None = None,
    solver: str = "gauss-seidel", seed: int = 0, force: bool = False,
    seconds: float | None = None,
) -> Plan:  # fmt: skip
    """Choose elements, mesh, rays, samples and tolerance for an accuracy.

    Parameters
    ----------
    accuracy : float
        In [0.0001, 1).
    mesh : str
        ``auto``; ``input`` for the faces as they are; or N for N x N cells a face.
    order : int, optional
        0 or 1; if not given 1 where the mesh is ``auto`` and not too large, 0 otherwise.
    force : bool
        Model everything, also what the scene does not require.
    seconds : float, optional
        Time to take, for the mesh ``auto``, instead of an accuracy to reach.

    Raises
    ------
    ValueError
        Accuracy, mesh, order or solver out of range.
    SceneError
        A material in a raw form that serves local shading only.
    """
    _refuse_seed_forms(scene)
    if not isinstance(accuracy, Real):
        raise TypeError(f"accuracy = {accuracy!r} must be a number: 0.02 asks for 2 percent")
    if not 1e-4 <= accuracy < 1:
        raise ValueError(
            f"accuracy = {accuracy:g} must lie in [0.0001, 1): 0.02 asks for 2 percent"
        )
    if order not in (None, 0, 1):
        raise ValueError(f"order = {order!r} must be 0 (constant) or 1 (linear elements)")
    if solver not in SOLVER_NAMES:
        raise ValueError(f"solver = {solver!r} must be one of {', '.join(SOLVER_NAMES)}")
    if seconds is not None:
        if mesh != "auto":
            raise ValueError(f"mesh = {mesh!r} leaves nothing to choose by time: use auto")
        accuracy, start = AS_GOOD_AS_CAN_BE, START
    else:
        start = max(accuracy, FIRST)
    faces = scene.faces
    division = _division(faces, mesh, PATCHES_AT_UNIT_ACCURACY / start**MORE)
    if order is None and mesh == "auto" and _is_large(faces, division):
        begin = accuracy if seconds is None else start
        planned = plan_of_clusters(scene, begin, solver, seed, force)
        return replace(planned, accuracy=accuracy, seconds=seconds)
    if order is None:
        order = 1 if mesh == "auto" and solver != "cg" else 0
    if order == 0 and mesh == "auto":
        division = _division(faces, mesh, max(CONSTANT_AT_UNIT_ACCURACY / accuracy, FEWEST))
    rule = 0.0 if force else _rule(scene, accuracy)
    if order == 1 and solver == "cg":
        raise ValueError("solver = 'cg' needs reciprocal factors: use order 0, or gmres")
    if seconds is not None and order == 0:
        raise ValueError(
            "a time to take needs a mesh that can be refined: leave out --order 0, --solver cg and "
            "factors"
        )
    recipe = Recipe(
        order, accuracy, rule, SOLVED * accuracy, solver, seed, chained=_chained(accuracy),
        force=force,
    )  # fmt: skip
    return Plan(accuracy, division, mesh == "auto", recipe, seconds=seconds)


def _refuse_seed_forms(scene: Scene) -> None:
    """Refuse lobes in the seeds' raw form, of which more light may leave than arrives."""
    raw = [m.name for m in scene.materials if m.specular is not None
           and not hasattr(m.specular, "mean_albedo")]  # fmt: skip
    if raw:
        raise SceneError(scene.source or scene.name, [
            f'materials.{name}.specular.convention = "seed" has no albedo: such a lobe reflects '
            "more than arrives and serves --method local only; leave the convention out"
            for name in raw
        ])  # fmt: skip


def _is_large(faces, division) -> bool:
    """Whether linear elements on all faces, and a check of them, would be too many."""
    return division.count > MOST_LINEAR or len(faces) > MOST_FACES


def plan_of_clusters(
    scene: Scene, accuracy: float, solver: str = "gauss-seidel", seed: int = 0, force: bool = False
) -> Plan:
    """Return the plan of a scene of many small faces."""
    clusters = int(np.clip(CLUSTERS_AT_UNIT_ACCURACY / accuracy, FEWEST_CLUSTERS, MOST_CLUSTERS))
    division = divisions(scene.faces, np.sqrt(scene.faces.areas().sum() / clusters))
    rays = int(2 ** np.clip(np.ceil(np.log2(20 / accuracy)), 8, 14))
    counted = int(RAYS_AT_UNIT_ACCURACY / accuracy)
    tolerance = SOLVED * accuracy
    recipe = Recipe(
        0, accuracy, 0.0, tolerance, solver, seed, rays, counted, _chained(accuracy), force
    )
    return Plan(accuracy, division, True, recipe, clusters)


def _chained(accuracy) -> int:
    return int(2 ** np.clip(np.ceil(np.log2(CHAINED_AT_UNIT_ACCURACY / accuracy)), *CHAINED))


def _rule(scene, accuracy) -> float:
    """Return the tolerance of far factors: exact sums where reflections hardly fade."""
    left = min((float(m.least_absorptance.min()) for m in scene.materials), default=1.0)
    rule = RULE * accuracy * min(1.0, left / FADES)
    return rule if rule > FINEST_RULE else 0.0


def _division(faces, mesh, wanted):
    mesh = str(mesh)
    if mesh == "auto":
        return divisions(faces, np.sqrt(faces.areas().sum() / wanted))
    if mesh == "input":
        count = 1
    elif mesh.isascii() and mesh.isdigit() and 0 < int(mesh) <= 1024:
        count = int(mesh)
    else:
        raise ValueError(f"mesh = {mesh!r} must be auto, input or a number from 1 to 1024")
    shape = np.where(faces.is_triangle[:, None], [count, 0], [count, count])
    return Division(shape)


def check_memory(patches: int, limit: float | None, order: int = 0) -> int:
    """Raise `Refused` where a dense solution would not fit; return the bytes that it takes."""
    linear = "" if order else "linear elements (--order 1), "
    way_out = f"use a larger --accuracy, a coarser --mesh, {linear}or allow more with --memory"
    return check_fits(f"{patches} patches", BYTES[order] * patches**2, limit, way_out)


def left_beside(faces: int, limit: float | None) -> float:
    """Return the bytes that so many faces leave of ``limit``; raise `Refused` if none."""
    limit = free_memory() / 2 if limit is None else limit
    way_out = "merge faces, or allow more with --memory"
    return limit - check_fits(f"{faces} faces", FACE * faces, limit, way_out)


def left_beside_chains(kinds: int, limit: float, order: int) -> float:
    """Return the part of ``limit`` bytes for all but chains, whose matrices are so many more.

    One for each of ``kinds`` of bands, and one more while they are made; see `BYTES`.
    """
    width = 3 if order else 1
    chains = 8 * width**2 * (kinds + 1) if kinds else 0
    return limit * BYTES[order] / (BYTES[order] + chains)


def fits(patches: float, order: int, limit: float | None) -> bool:
    """Whether a dense solution on so many patches would fit."""
    return patches <= most_that_fit(order, limit)


def most_that_fit(order: int, limit: float | None) -> int:
    """Return of how many patches a dense solution fits into ``limit`` bytes; see `check_fits`."""
    return int(np.sqrt((free_memory() / 2 if limit is None else limit) / BYTES[order]))


def check_factors(rows: int, faces: int, limit: float | None) -> int:
    """Raise `Refused` where factors of so many rows would not fit; return the bytes they take.

    ``faces`` counts all that may block, rows or not.
    """
    way_out = "merge faces, or allow more with --memory"
    what = f"form factors of {rows} faces" + (f", {faces} in all," if faces > rows else "")
    return check_fits(what, FACTORS * rows**2 + FACE * faces, limit, way_out)


def check_fits(what: str, needed: int, limit: float | None, way_out: str) -> int:
    """Return ``needed`` bytes; raise `Refused` above ``limit``, half of what is free if None."""
    limit = free_memory() / 2 if limit is None else limit
    if needed > limit:
        raise Refused(
            f"{what} need about {size_text(needed)}, more than the {size_text(limit)} allowed: "
            f"{way_out}"
        )
    return needed


def size_text(count: float) -> str:
    """Return a count of bytes in GB, MB or kB."""
    for unit, name in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if count >= 0.1 * unit:
            return f"{count / unit:.1f} {name}"
    return f"{count:.0f} bytes"


def free_memory() -> float:
    """Return the bytes of memory that are free now (4 GB where the system does not say)."""
    try:
        with open("/proc/meminfo") as info:
            for line in info:
                if line.startswith("MemAvailable"):
                    return 1024.0 * int(line.split()[1])
    except OSError:
        pass
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")) / 2
    except (ValueError, OSError, AttributeError):
        return 4e9
