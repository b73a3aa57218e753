"""Our own file of a solution, ``.radsol``: all that pictures, probes and relighting need.

It holds the scene, the meshes and the fields on them, of the solution and of the level that tells
its errors, and what each light group does. Factors are left out. What follows from these without
solving, patches, what rays meet, mirrored scenes, is made anew, the same to the bit.
"""

from dataclasses import dataclass, replace
from os import PathLike

import numpy as np

from radiosity.mesh.contact import Contacts
from radiosity.mesh.division import Division
from radiosity.mesh.elements import make_elements
from radiosity.mesh.facets import merge_facets
from radiosity.mesh.patches import make_patches
from radiosity.scene.model import Scene, SceneError
from radiosity.solve.archive import read_archive, write_archive
from radiosity.solve.clustered import Clustered
from radiosity.solve.estimate import Check, Estimate
from radiosity.solve.level import Kept, Level
from radiosity.solve.plan import Plan, Recipe
from radiosity.solve.reach import Reach
from radiosity.solve.record import Unreadable, rebuilt, recorded
from radiosity.solve.relight import MOST_GROUPS, PARTS, Share, Shares, share_of
from radiosity.solve.solution import Solution
from radiosity.solve.system import lights_of, make_terms
from radiosity.transport.arrival import make_senders
from radiosity.transport.factors import patch_geometry
from radiosity.transport.lookup import make_table
from radiosity.transport.visibility import Visibility


@dataclass(frozen=True)
class SavedMesh:
    """How a scene is meshed: cells of the faces, fronts that have backs, patches that are lit."""

    division: Division
    backs: np.ndarray
    live: np.ndarray


@dataclass(frozen=True)
class SavedLevel:
    """What a level is made of again; arrays as of `Level`.

    Attributes
    ----------
    recipe : Recipe
    mesh : SavedMesh or None
        None where it is the solution's.
    order : int
        Of the elements that answer at points.
    tolerance : (m,) float64
        Of far factors.
    outside : (width m,) float64
    share : Share
        Of all light.
    history : list of float
    solver : str
    clustered, sampled : bool
        Whether light is exchanged between clusters, and then whether lights are sampled one by one.
    """

    recipe: Recipe
    mesh: SavedMesh | None
    order: int
    tolerance: np.ndarray
    outside: np.ndarray
    share: Share
    history: list
    solver: str
    clustered: bool
    sampled: bool


@dataclass(frozen=True)
class Saved:
    """What a file holds of a solution.

    Attributes
    ----------
    scene, plan, contacts, estimate : Scene, Plan, Contacts, Estimate
    level, check : SavedLevel
        The solution, and the level that tells its errors.
    portion : float
        Of their difference, that is the error.
    groups : tuple of str
        Names of the light groups.
    shares, check_shares : Share or None
        What each group does on both levels, arrays (groups, ...); None where there is one group, or
        too many.
    """

    scene: Scene
    plan: Plan
    contacts: Contacts
    level: SavedLevel
    check: SavedLevel
    portion: float
    estimate: Estimate
    groups: tuple[str, ...]
    shares: Share | None
    check_shares: Share | None


def write_solution(solution: Solution, path: str | PathLike) -> None:
    """Write a solution to an open place, see `radiosity.view.export.save`.

    More than MOST_GROUPS light groups are not told apart: they cannot be dimmed afterwards.
    """
    from radiosity import __version__

    arrays = {}
    content = recorded(_saved(solution), "solution", arrays)
    write_archive(path, content, arrays, f"radiosity {__version__}")


def read_solution(path: str | PathLike, memory: float | None = None) -> Solution:
    """Return the solution that a ``.radsol`` file holds.

    Raises
    ------
    SceneError
        It is not there, of another format or version, or damaged: says where, and the way out.
    Refused
        It would not fit into ``memory`` bytes, by default half of what is free.
    """
    content, arrays, program = read_archive(path, memory)
    try:
        return _solution_of(_checked(rebuilt(content, arrays)))
    except SceneError as error:
        raise SceneError(str(path), error.problems) from error
    except Exception as error:  # of a file that another program made anything may be wrong
        kind = "" if isinstance(error, Unreadable) else f"{type(error).__name__}: "
        raise SceneError(str(path), [
            f"does not describe a solution, {kind}{error} (made by {program}): solve the scene "
            "again"
        ]) from error  # fmt: skip


def _saved(solution) -> Saved:
    level, check = solution.level, solution.check
    groups, shares = solution.groups, (None, None)
    if 1 < len(groups) <= MOST_GROUPS:
        shares = (_stacked(x) for x in (solution.shares.level, solution.shares.check))
    other = None if check.level.reach is level.reach else _saved_mesh(check.level.reach)
    return Saved(
        solution.scene, solution.plan, level.reach.contacts,
        _saved_level(level, _saved_mesh(level.reach)), _saved_level(check.level, other),
        check.share, solution.estimate, groups, *shares,
    )  # fmt: skip


def _stacked(shares) -> Share:
    return Share(*(np.stack([getattr(s, name) for s in shares]) for name in PARTS))


def _saved_mesh(reach) -> SavedMesh:
    return SavedMesh(reach.patches.grid.division, reach.patches.back_of >= 0, reach.live)


def _saved_level(level, mesh) -> SavedLevel:
    clustered = isinstance(level, Clustered)
    order, tolerance, sampled = 0, np.zeros(0), False
    if clustered:
        sampled = bool(len(level.lights.polygons))
    else:
        order, tolerance = level.senders.elements.order, level.senders.sight.tolerance
    return SavedLevel(
        level.recipe, mesh, order, tolerance, level.outside, share_of(level), level.history,
        level.solver, clustered, sampled,
    )  # fmt: skip


def _checked(saved) -> Saved:
    """Return what was read, if it is what files hold."""
    from radiosity.solve.soundness import problem_of

    problem = problem_of(saved) if isinstance(saved, Saved) else "content is no solution"
    if problem:
        raise Unreadable(problem)
    saved.scene.check()
    return saved


def _solution_of(saved: Saved) -> Solution:
    faces = saved.scene.faces
    visibility = Visibility(faces, merge_facets(faces), saved.plan.recipe.force)
    reach = _reach(saved, saved.level.mesh, visibility)
    other = reach if saved.check.mesh is None else _reach(saved, saved.check.mesh, visibility)
    level = _level(saved.level, saved.scene, reach)
    check = _level(saved.check, saved.scene, other)
    judgement = Check(check, saved.portion), saved.estimate
    return Solution(saved.scene, saved.plan, level, lambda: judgement, _shares(saved, level, check))


def _shares(saved, level, check) -> Shares | None:
    """Return what each light group does; None where that was not kept."""
    names = saved.groups
    if len(names) < 2:
        alone = ((share_of(x),) * len(names) for x in (level, check))
        return Shares(names, *alone)
    if saved.shares is None:
        return None
    parts = (zip(*(getattr(x, name) for name in PARTS), strict=True)
             for x in (saved.shares, saved.check_shares))  # fmt: skip
    return Shares(names, *(tuple(Share(*share) for share in part) for part in parts))


def _reach(saved, mesh: SavedMesh, visibility) -> Reach:
    """Return the meshed scene, its lit sides as they were found."""
    faces = saved.scene.faces
    cells = make_patches(faces, mesh.division, saved.contacts)
    if len(cells) != len(mesh.backs):
        raise Unreadable(f"the mesh has {len(cells)} fronts, what is known of {len(mesh.backs)}")
    patches = cells.with_backs(mesh.backs)
    return Reach(patches, mesh.live, visibility, make_table(faces, cells), saved.contacts)


def _level(saved: SavedLevel, scene, reach) -> Level | Clustered:
    """Return a level as it was but for its factors."""
    share, recipe, patches = saved.share, saved.recipe, reach.patches
    kept = Kept(share.straight, share.escaping)
    made = scene, reach, make_terms(scene, patches, reach.live), recipe
    end = saved.history, saved.solver
    fields = share.coefficients, share.arriving, saved.outside
    if saved.clustered:
        lights = lights_of(scene, len(scene.faces) if saved.sampled else 0)
        straight = share.straight, share.lamplight
        level = Clustered(*made, None, None, lights, *straight, *fields, *end, kept=kept)
    else:
        rows = np.flatnonzero(reach.live)
        elements = make_elements(patches, rows, saved.order)
        geometry = patch_geometry(patches, reach.visibility, rows)
        senders = make_senders(elements, geometry, reach.visibility, saved.tolerance)
        level = Level(*made, senders, None, *fields, share.lamplight, None, *end, kept=kept)
    if scene.sends_on:
        from radiosity.solve.chains import tracer_of  # others need none of it

        level = replace(level, tracer=tracer_of(level))
    return level
