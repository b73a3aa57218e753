"""The solution: radiosity of every patch, how it was obtained, and irradiance anywhere."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from radiosity.light.photometry import illuminance
from radiosity.mesh.patches import Patches
from radiosity.scene.groups import light_groups
from radiosity.scene.model import Scene
from radiosity.solve.estimate import Check, Estimate, noise_of
from radiosity.solve.level import Level
from radiosity.solve.plan import Plan
from radiosity.transport.irradiance import Surroundings
from radiosity.transport.threads import Progress, silent

if TYPE_CHECKING:
    from radiosity.solve.relight import Shares
    from radiosity.transport.paths import Space


@dataclass(frozen=True)
class Balance:
    """Power in W a band (bands,): what is emitted (or enters) is absorbed or escapes."""

    emitted: np.ndarray
    absorbed: np.ndarray
    escaped: np.ndarray

    @property
    def defect(self) -> float:
        """Return the largest share of the emitted power that is unaccounted for."""
        scale = self.emitted.max()
        missing = np.abs(self.emitted - self.absorbed - self.escaped).max()
        return float(missing / scale) if scale > 0 else 0.0


@dataclass(frozen=True)
class Solution:
    """Radiosities of a scene's patches.

    Attributes
    ----------
    scene : Scene
    plan : Plan
    level : Level
        The solved mesh.
    judge : callable
        Returns the `Check` and the `Estimate` of its error.
    given : Shares, optional
        What each light group does, where that was found before.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/furnace.toml"), accuracy=0.1)
    >>> E, error = solution.irradiance([[1, 1, 0]], [[0, 0, 1]])
    >>> E.round(3).tolist(), solution.closed
    ([[1.25, 4.0, 2.5]], True)
    """

    scene: Scene
    plan: Plan
    level: Level
    judge: Callable[[], tuple[Check, Estimate]]
    given: "Shares | None" = None

    def _repr_html_(self) -> str:
        """Return it as a notebook shows it."""
        from radiosity.solve.overview import solution_html

        return solution_html(self)

    def __repr__(self) -> str:
        """Return what it is a solution of, without its arrays."""
        return f"<Solution of {self.scene.name!r}: {len(self.patches)} patches, {self.solver}>"

    @property
    def patches(self) -> Patches:
        """Return the patches: all fronts, and the backs that light reaches."""
        return self.level.reach.patches

    @property
    def live(self) -> np.ndarray:
        """Return (n,) bool: patches that light reaches; the others stay 0."""
        return self.level.reach.live

    @property
    def reflectance(self) -> np.ndarray:
        """Return (n, bands) reflectances."""
        return self.level.terms.reflectance

    @property
    def emission(self) -> np.ndarray:
        """Return (n, bands) exitance of the patches' own in W/m2."""
        return self.level.terms.emission

    @property
    def transmittance(self) -> np.ndarray | None:
        """Return (n, bands) what comes diffusely through patches, None where nothing does."""
        return self.level.terms.transmittance

    @cached_property
    def irradiance_on(self) -> np.ndarray:
        """Return (n, bands) mean irradiance E on each patch, W/m2."""
        return self.level.on_patches(self.level.arriving)

    @cached_property
    def radiosity(self) -> np.ndarray:
        """Return (n, bands) mean radiosity B = M_e + rho E of each patch, W/m2."""
        return self.level.on_patches(self.level.coefficients)

    @property
    def history(self) -> list[float]:
        """Return the solver's error bound after each iteration."""
        return self.level.history

    @property
    def solver(self) -> str:
        """Return the name of the solver that was used."""
        return self.level.solver

    @property
    def seed(self) -> int:
        """Return the seed of all sample patterns."""
        return self.plan.recipe.seed

    @property
    def closed(self) -> bool:
        """Return whether no light leaves the scene."""
        return not np.any(self.level.outside > 0)

    @property
    def surroundings(self) -> Surroundings:
        """Return what rays that look around meet."""
        return self.level.surroundings

    @property
    def space(self) -> "Space | None":
        """Return what sight lines are followed through, None where nothing sends light on."""
        return self.surroundings.space

    @cached_property
    def balance(self) -> Balance:
        """Return where the emitted power goes."""
        level, rows = self.level, self.level.rows
        area = (self.patches.area[rows] * self.scene.unit_m**2)[:, None]
        m = len(rows)
        emitted = (area * (level.terms.emission[rows] + level.entering[:m])).sum(axis=0)
        absorbed = area * level.terms.absorptance[rows] * level.arriving[:m]
        escaped = (area * level.escaping).sum(axis=0)
        if level.terms.sent_on is None:
            return Balance(emitted, absorbed.sum(axis=0), escaped)
        from radiosity.solve.budget import find_onward

        onward = find_onward(level)
        absorbed[onward.rows] = 0.0
        absorbed = absorbed.sum(axis=0) + onward.absorbed + onward.swallowed
        return Balance(emitted, absorbed, escaped + onward.escaped)

    @cached_property
    def _judgement(self):
        return self.judge()

    @property
    def check(self) -> Check:
        """Return the other level that tells the errors."""
        return self._judgement[0]

    @cached_property
    def shares(self) -> "Shares":
        """Return what each light group does by itself, solved when first asked for.

        Raises
        ------
        ValueError
            There are more groups than are told apart.
        """
        if self.given is not None:
            return self.given
        from radiosity.solve.relight import shares_of  # who dims nothing needs none of it

        return shares_of(self.level, self.check.level)

    @property
    def groups(self) -> tuple[str, ...]:
        """Return the names of the light groups, see `radiosity.scene.groups.light_groups`."""
        return light_groups(self.scene) if self.given is None else self.given.names

    @property
    def can_dim(self) -> bool:
        """Whether light groups are told apart: `dimmed` raises ValueError where they are not."""
        if self.given is not None:
            return True
        from radiosity.solve.relight import MOST_GROUPS

        return len(self.groups) <= MOST_GROUPS

    def dimmed(self, factors: Mapping[str, float]) -> "Solution":
        """Return the solution for the same scene with light groups scaled, without solving.

        Exact, as light adds up; on the same mesh. Errors are estimated anew, relative to the light
        that is left. What is off stays off in solutions made of this one.

        Parameters
        ----------
        factors : dict of str to float
            Of some `groups`: 0 is off, 1, which the others have, leaves a group as it is.

        Raises
        ------
        ValueError
            An unknown name, a factor out of range, or more groups than are told apart.

        Examples
        --------
        >>> import radiosity
        >>> solution = radiosity.solve(radiosity.load("scenes/cornell_box.toml"), accuracy=0.1)
        >>> half = solution.dimmed({"light": 0.5})
        >>> solution.groups, bool(np.allclose(2 * half.radiosity, solution.radiosity))
        (('light',), True)
        """
        from radiosity.solve.relight import dimmed

        return dimmed(self, factors)

    def by_groups(self) -> dict[str, "Solution"]:
        """Return a solution for each light group alone; their irradiances add up to this one's.

        Raises
        ------
        ValueError
            There are more groups than are told apart.
        """
        return {
            name: self.dimmed({other: float(other == name) for other in self.groups})
            for name in self.groups
        }

    @property
    def estimate(self) -> Estimate:
        """Return the estimated errors, computed when first asked for where the mesh was given."""
        return self._judgement[1]

    @property
    def error(self) -> np.ndarray:
        """Return (n, bands) estimated errors of the irradiance on each patch, W/m2."""
        rows, found = self.level.rows, np.zeros_like(self.irradiance_on)
        found[rows] = self.estimate.on_patches(self.irradiance_on[rows])
        return found

    def irradiance(
        self, points: np.ndarray, normals: np.ndarray, progress: Progress = silent
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the irradiance at points, gathered from all patches they see.

        Parameters
        ----------
        points : (k, 3) array_like
            In scene units.
        normals : (k, 3) array_like
            Of any length; their side receives.

        Returns
        -------
        E : (k, bands) float64
            W/m2 for each band, at least 0.
        error : (k, bands) float64
            What at least 95 % of the errors stay below, estimated from another level, see
            `Solution.estimate`, and from rays where those had to tell what is seen.

        Raises
        ------
        ValueError
            Arrays of another shape, numbers that are not finite, normals of length 0.
        """
        points, normals = checked_points(points, normals)
        check, estimate = self._judgement
        here = self.level.gathered(points, normals, progress)
        there = check.level.gathered(points, normals)
        difference = check.share * (here.total - there.total)
        error = estimate.bars(here.total, difference) + noise_of(here, there, check.share)
        below = np.maximum(-here.total, 0.0)  # light of linear elements that dip below 0
        return here.total + below, error + below

    @property
    def illuminance(self) -> np.ndarray:
        """Return (n,) mean illuminance on each patch in lx."""
        return illuminance(self.irradiance_on, self.scene.bands)

    def truth_error(self) -> float | None:
        """Return the largest relative error against the answer the scene carries, if any."""
        truth = self.scene.truth
        if truth is None:
            return None
        faces = self.scene.faces
        worst = 0.0
        front = self.patches.front & self.live
        for name, expected in truth.radiosity.items():
            mine = front & _named(self.scene, faces, self.patches.face, name)
            weight = self.patches.area[mine] / self.patches.area[mine].sum()
            found = weight @ self.radiosity[mine]
            scale = np.where(expected > 0, expected, expected.max() or 1.0)
            worst = max(worst, float(np.max(np.abs(found - expected) / scale)))
        return worst


def _named(scene, faces, face, name):
    """Return which patches belong to a material or group; "" stands for all."""
    if name == "":
        return np.ones(len(face), bool)
    materials = np.array([m.name == name for m in scene.materials])
    if materials.any():
        return materials[faces.material[face]]
    return np.array([g == name for g in scene.groups])[faces.group[face]]


def refuse_unsolved(value) -> None:
    """Raise TypeError for what is no solution where one is needed, with the way to have one."""
    if isinstance(value, Scene):
        raise TypeError(f"{value!r} is not solved: radiosity.solve(scene) returns its Solution")
    if not isinstance(value, Solution):
        raise TypeError(
            f"{value!r} is no Solution: radiosity.load reads a scene or a .radsol file, and "
            "radiosity.solve solves a scene"
        )


def checked_points(points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (k, 3) and normals of length 1.

    Raises
    ------
    ValueError
        Arrays of another shape, numbers that are not finite, normals of length 0.
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    normals = np.ascontiguousarray(normals, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or points.shape != normals.shape:
        raise ValueError(
            f"points {points.shape} and normals {normals.shape} must both have the shape (k, 3)"
        )
    if len(points) == 0:
        raise ValueError("no points are given: give at least one, and its normal")
    bad = ~(np.isfinite(points).all(axis=1) & np.isfinite(normals).all(axis=1))
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    bad |= length[:, 0] == 0
    if bad.any():
        k = int(np.flatnonzero(bad)[0])
        raise ValueError(
            f"point {k + 1}: position {points[k].tolist()} and normal {normals[k].tolist()} must "
            "be finite, and the normal longer than 0"
        )
    return points, normals / length
