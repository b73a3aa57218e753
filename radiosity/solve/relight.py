"""Relighting: what each light group does by itself, and their sum with other weights.

B = M_e + rho F B is linear in the light, so the answer for any mixture of light groups is that
mixture of their own answers. These are found together, each group in bands of its own
(`radiosity.scene.apart`), by the factors that the solution has; what they miss its sum by,
within the solver's tolerance, is given to them as their sizes are, so that they add up to it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from radiosity.scene.apart import apart
from radiosity.scene.groups import checked_factors, light_groups, material_factors, scaled
from radiosity.scene.model import Scene
from radiosity.solve.adapt import smoothed
from radiosity.solve.clustered import Clustered, grouped, under_other_light
from radiosity.solve.estimate import Check, compare, unknown
from radiosity.solve.level import Kept, Level, solve_level
from radiosity.solve.system import lights_of, make_terms

MOST_GROUPS = 32  # each is as much to solve, and to keep, as the scene itself


@dataclass(frozen=True)
class Share:
    """What some of the light does on a level, in W/m2; arrays as of `Level`."""

    coefficients: np.ndarray
    arriving: np.ndarray
    lamplight: np.ndarray
    straight: np.ndarray
    escaping: np.ndarray


PARTS = tuple(field.name for field in fields(Share))


@dataclass(frozen=True)
class Shares:
    """What each light group does, on the level of a solution and on that of its check.

    Attributes
    ----------
    names : tuple of str
    level, check : tuple of Share
        One a group.
    """

    names: tuple[str, ...]
    level: tuple[Share, ...]
    check: tuple[Share, ...]


def share_of(level: Level | Clustered) -> Share:
    """Return what all light does on a level."""
    return Share(*(getattr(level, name) for name in PARTS))


def shares_of(level: Level | Clustered, check: Level | Clustered) -> Shares:
    """Return what the light groups do on a level, and on its check, solved by their factors.

    Raises
    ------
    ValueError
        There are more than MOST_GROUPS groups.
    """
    names = light_groups(level.scene)
    if len(names) > MOST_GROUPS:
        raise ValueError(
            f"{len(names)} light groups are more than the {MOST_GROUPS} that are told apart: "
            'let lights share a group, as group = "lamps" does in a scene file'
        )
    if len(names) < 2:
        return Shares(names, *((share_of(x),) * len(names) for x in (level, check)))
    scene = apart(level.scene, names)
    fine = _under(level, scene)
    coarse = _check_under(level, fine, check, scene)
    count = level.scene.bands.count
    return Shares(names, _split(fine, level, count), _split(coarse, check, count))


def _under(level, scene):
    """Return a level solved for a scene of the same surfaces under other light."""
    if isinstance(level, Clustered):
        return under_other_light(level, scene)
    return solve_level(scene, level.reach, level.recipe, like=level)


def _check_under(level, fine, check, scene):
    """Return the check of a level under other light, itself made of the level where it was."""
    if isinstance(check, Clustered):
        above = np.zeros(level.labels.max(initial=-1) + 1, int)
        above[level.labels] = check.labels
        return grouped(fine, above, check.factors)
    if check.kept is not None:
        return smoothed(fine)
    return _under(check, scene)


def _split(found, level, count) -> tuple[Share, ...]:
    """Return the share of each group, ``found`` in bands of their own; their sum is the level's."""
    parts = [np.split(x, x.shape[1] // count, axis=1) for x in vars(share_of(found)).values()]
    whole = vars(share_of(level)).values()
    fitted = [_adding_up(np.array(x), y) for x, y in zip(parts, whole, strict=True)]
    return tuple(Share(*share) for share in zip(*fitted, strict=True))


def _adding_up(parts, whole):
    """Return parts (groups, ...) changed in proportion to their sizes so that they add up."""
    size = np.abs(parts)
    total = size.sum(axis=0)
    return parts + (whole - parts.sum(axis=0)) * size / np.where(total > 0.0, total, 1.0)


def dimmed(solution, factors: Mapping[str, float]):
    """Return a solution with its light groups scaled; see `Solution.dimmed`."""
    factors = checked_factors(solution.groups, factors)
    if all(factor == 1.0 for factor in factors.values()):
        return solution
    shares, check = solution.shares, solution.check
    weights = [factors[name] for name in shares.names]
    scene = scaled(solution.scene, factors)
    level, other = (
        _lit(x, scene, _dimmed_terms(x, scene, factors), _mixed(share, weights))
        for x, share in ((solution.level, shares.level), (check.level, shares.check))
    )
    other = Check(other, check.share)
    known = np.isfinite(solution.estimate.reached)

    def judge():
        return (other, compare(level, other)) if known else unknown(level)

    left = Shares(
        shares.names, *(_weighted(x, weights) for x in (shares.level, shares.check))
    )  # fmt: skip
    return replace(solution, scene=scene, level=level, judge=judge, given=left)


def _weighted(shares, weights):
    return tuple(_mixed([share], [w]) for share, w in zip(shares, weights, strict=True))


def _mixed(shares, weights) -> Share:
    """Return the sum of shares with these weights."""
    sums = (
        sum(w * getattr(share, name) for share, w in zip(shares, weights, strict=True))
        for name in PARTS
    )
    return Share(*sums)


def told_apart(solution) -> Level | Clustered:
    """Return a solution's level with each of its ``groups`` in bands of their own, in that order.

    What is gathered from it are the bands (k, groups bands) of one group after the other: as much
    work as for all of the light together.

    Raises
    ------
    ValueError
        There are more than MOST_GROUPS groups.
    """
    shares, level = solution.shares, solution.level
    if len(shares.names) < 2:
        return level
    scene = apart(solution.scene, shares.names)
    beside = (np.concatenate([getattr(x, name) for x in shares.level], axis=1) for name in PARTS)
    terms = make_terms(scene, level.reach.patches, level.reach.live)
    return _lit(level, scene, terms, Share(*beside))


def _dimmed_terms(level, scene, factors):
    """Return a level's terms with what patches emit scaled."""
    material = scene.faces.material[level.reach.patches.face]
    emission = level.terms.emission * material_factors(scene, factors)[material][:, None]
    return replace(level.terms, emission=emission)


def _lit(level, scene: Scene, terms, share: Share):
    """Return a level as the light of another scene of the same surfaces has it."""
    parts = {name: getattr(share, name) for name in ("coefficients", "arriving", "lamplight")}
    made = replace(
        level, scene=scene, terms=terms, kept=Kept(share.straight, share.escaping), **parts
    )
    if isinstance(level, Clustered):
        lights = lights_of(scene, len(scene.faces) if len(level.lights.polygons) else 0)
        made = replace(made, straight=share.straight, lights=lights)
    return made if level.tracer is None else replace(made, tracer=_tracer(made))


def _tracer(level):
    """Return what follows light along single directions in a level's scene."""
    from radiosity.solve.chains import tracer_of  # scenes without mirrors and lobes need none of it

    return tracer_of(level)


