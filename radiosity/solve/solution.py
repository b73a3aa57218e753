"""The solution: radiosity of every patch, how it was obtained, and irradiance anywhere."""

from dataclasses import dataclass

import numpy as np

from radiosity.light.photometry import illuminance
from radiosity.mesh.patches import Patches
from radiosity.scene.model import Scene
from radiosity.solve.plan import Plan
from radiosity.transport.irradiance import (
    Surroundings,
    direct_irradiance,
    indirect_irradiance,
)
from radiosity.transport.threads import Progress, over_ranges, silent

POINTS_AT_ONCE = 65536


@dataclass(frozen=True)
class Balance:
    """Power in W a band (3,): what is emitted (or enters) is absorbed or escapes."""

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
    patches : Patches
    live : (n,) bool
        Patches that light reaches; the others stay 0.
    reflectance, emission : (n, 3) float64
        Reflectance, and exitance of their own in W/m2.
    irradiance_on : (n, 3) float64
        Mean irradiance E on each patch, W/m2.
    radiosity : (n, 3) float64
        B = M_e + rho E, W/m2.
    balance : Balance
    history : list of float
        The solver's error bound after each iteration.
    solver : str
    plan : Plan
    seed : int
    closed : bool
    surroundings : Surroundings
    """

    scene: Scene
    patches: Patches
    live: np.ndarray
    reflectance: np.ndarray
    emission: np.ndarray
    irradiance_on: np.ndarray
    radiosity: np.ndarray
    balance: Balance
    history: list
    solver: str
    plan: Plan
    seed: int
    closed: bool
    surroundings: Surroundings

    def irradiance(
        self, points: np.ndarray, normals: np.ndarray, progress: Progress = silent
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the irradiance at points, gathered from the lights and the patches.

        Parameters
        ----------
        points : (k, 3) array_like
            In scene units.
        normals : (k, 3) array_like
            Of any length; their side receives.

        Returns
        -------
        E : (k, 3) float64
            W/m2 for each band.
        error : (k, 3) float64
            What about 95 % of the errors stay below: three times the standard error from two
            halves of the samples and from patches taken as constant against linear. Errors of
            the form factors themselves are not in it.

        Raises
        ------
        ValueError
            Arrays of another shape, numbers that are not finite, normals of length 0.
        """
        points, normals = _checked(points, normals)
        total, error = np.empty_like(points), np.empty_like(points)

        def work(a, b):
            total[a:b], error[a:b] = self._gathered(points[a:b], normals[a:b], a)

        chunk = max(1, POINTS_AT_ONCE // self.plan.samples)
        over_ranges(work, len(points), chunk, "irradiance", progress)
        return total, error

    def _gathered(self, points, normals, first):
        keys = np.arange(first, first + len(points))
        half = self.plan.samples // 2
        args = self.surroundings, points, normals, keys
        one, one_flat, _ = indirect_irradiance(*args, range(half), self.seed)
        two, two_flat, _ = indirect_irradiance(*args, range(half, 2 * half), self.seed)
        seen = self.surroundings.visibility, self.surroundings.lights, points, normals, keys
        lit = direct_irradiance(*seen, range(half // 4), self.seed)
        lit_too = direct_irradiance(*seen, range(half // 4, half // 2), self.seed)
        mean = (one + two) / 2
        error = np.abs(one - two) / 2 + np.abs(lit - lit_too) / 2
        error += np.abs(mean - (one_flat + two_flat) / 2)
        return mean + (lit + lit_too) / 2, 3 * error

    @property
    def illuminance(self) -> np.ndarray:
        """Return (n,) mean illuminance on each patch in lx."""
        return illuminance(self.irradiance_on)

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


def _checked(points, normals):
    points = np.ascontiguousarray(points, dtype=np.float64)
    normals = np.ascontiguousarray(normals, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or points.shape != normals.shape:
        raise ValueError(
            f"points {points.shape} and normals {normals.shape} must both have the shape (k, 3)"
        )
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
