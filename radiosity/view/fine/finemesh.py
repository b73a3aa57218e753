"""The fine mesh: a solution's surfaces with gathered light at their vertices.

A page shows it, and the window illuminance on it.
"""

from dataclasses import dataclass

import numpy as np

from radiosity.light.photometry import illuminance
from radiosity.mesh.corners import between, weights
from radiosity.solve.positive import not_negative
from radiosity.solve.relight import told_apart
from radiosity.solve.solution import Solution
from radiosity.transport.curved import smooth_normals
from radiosity.transport.lookup import coordinates_at
from radiosity.transport.threads import Progress, silent
from radiosity.view.detail import Detail
from radiosity.view.fine.looks import looks_of
from radiosity.view.fine.refine import Light, refined
from radiosity.view.fine.seams import fans_of
from radiosity.view.polydata import shown_patches

ALL, STAGE = "all light", "gathered light"
MOST, MOST_TRACED = 40_000, 10_000  # vertices, about; where rays follow light they take far longer


@dataclass(frozen=True)
class FineMesh:
    """Triangles with light at their vertices.

    Attributes
    ----------
    points : (k, 3) float64
        Scene units.
    patch : (k,) int
        Of the solution.
    uv : (k, 2) float64
        Texture coordinates, 0 where there are none.
    triangles : (t, 3) int
        Counter-clockwise seen from the side that is shown.
    groups : (g,) tuple of str
        Of light, in the order of what follows.
    lux : (k, g) float64
        Illuminance by each group.
    reflected : (k, g, 3) float64
        Radiosity in W/m2 without emission, linear sRGB, of textures as of their means.
    error : (k,) float64
        Estimated, of the illuminance by all groups, lx; infinite where it is not known.
    """

    points: np.ndarray
    patch: np.ndarray
    uv: np.ndarray
    triangles: np.ndarray
    groups: tuple[str, ...]
    lux: np.ndarray
    reflected: np.ndarray
    error: np.ndarray


def gathered_mesh(
    solution: Solution,
    progress: Progress = silent,
    most: int | None = None,
    with_errors: bool = False,
) -> FineMesh:
    """Return a solution's surfaces, fine enough that light is straight between the vertices.

    See `radiosity.view.fine.refine.refined` for what that is. ``most`` is about how many there may
    be, MOST or, where light is followed by rays through mirrors and glass, MOST_TRACED if not
    given. Errors are estimated where ``with_errors`` asks for them: light is gathered from the
    solution's check, too.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/furnace.toml"), 0.1)
    >>> mesh = gathered_mesh(solution)
    >>> mesh.groups, set(mesh.lux.round().ravel().tolist())  # everywhere as much, 683 Y(E)
    (('wall',), {2259.0})
    """
    if most is None:
        most = MOST if solution.level.tracer is None else MOST_TRACED
    look, patches = _Look(solution, most, with_errors), solution.patches
    cells, seen = refined(patches, shown_patches(solution), look, progress, most)
    fans = fans_of(patches, cells, seen, look, progress)
    progress(STAGE, 1, 1)
    uv = _uv(solution, fans.patch, fans.points)
    light = fans.light
    shape = fans.points, fans.patch, uv, fans.triangles
    return FineMesh(*shape, look.groups, light.lux, light.reflected, light.error)


class _Look:
    """Looks at light on patches, of each group by itself, at about ``most`` points in all."""

    def __init__(self, solution, most, with_errors):
        self.looked, self.most = 0, most
        self.solution, self.looks = solution, looks_of(solution.scene)
        self.groups = solution.groups if solution.can_dim else (ALL,)
        self.groups = self.groups or (ALL,)
        level = told_apart(solution) if solution.can_dim else solution.level
        self.level = not_negative(level)
        known = with_errors and np.isfinite(solution.estimate.reached)
        self.check = not_negative(solution.check.level) if known else None

    def __call__(self, patch, points, progress) -> Light:
        """Return the `Light` at points (k, 3) of patches (k,)."""
        solution, patches = self.solution, self.solution.patches
        live, bands = solution.live[patch], solution.scene.bands
        shape = len(points), len(self.groups), bands.count
        e, noise = np.zeros(shape), np.zeros((len(points), bands.count))
        error = np.zeros(len(points)) if self.check else np.full(len(points), np.inf)
        points, normals = self._on_curve(patch, points)
        if live.any():
            report = self._counted(progress, len(points))
            found = self.level.gathered(points[live], normals[live], report)
            e[live] = np.maximum(found.total.reshape(-1, *shape[1:]), 0.0)
            noise[live] = found.error.reshape(-1, *shape[1:]).sum(axis=1)
            if self.check:
                where = points[live], normals[live]
                error[live] = self._error(where, e[live].sum(axis=1), noise[live])
        self.looked += len(points)
        material = solution.scene.faces.material[patches.face[patch]]
        side = np.where(patches.front[patch], 0, 1)
        sent = self.looks.reflects[side, material][:, None] * e
        self._add_passed(sent, material, live, points, normals)
        noise = illuminance(noise, bands)
        return Light(illuminance(e, bands), noise, bands.to_rgb(sent), error)

    def _error(self, where, e, noise):
        """Return (k,) error bars in lx of irradiances (k, bands), as `Solution.irradiance` does."""
        check, estimate = self.solution.check, self.solution.estimate
        there = self.check.gathered(*where)
        bars = estimate.bars(e, check.share * (e - np.maximum(there.total, 0.0)))
        bars += 2.0 * np.hypot(noise, check.share * there.error)
        return illuminance(bars, self.solution.scene.bands)

    def _counted(self, progress, count):
        """Return what tells how many of all points are done while ``count`` are looked at."""
        before = self.looked
        self.most = most = max(self.most, count)  # already of the first look, where patches abound

        def report(stage, done, total):
            progress(STAGE, min(before + count * done // total, most), most)

        return report

    def _add_passed(self, sent, material, live, points, normals):
        """Add to what sheets send (k, g, bands) what comes through them from the other side."""
        passes = self.looks.passes[material]
        some = np.flatnonzero(live & passes.any(axis=1))
        if len(some):
            behind = self.level.gathered(points[some], -normals[some]).total
            behind = np.maximum(behind, 0.0).reshape(len(some), *sent.shape[1:])
            sent[some] += passes[some, None] * behind

    def _on_curve(self, patch, points):
        """Return points and the patches' normals (k, 3), of curves those of the curve itself.

        A lamp then sets behind the curve, not behind the plane of a face.
        """
        scene, patches = self.solution.scene, self.solution.patches
        own, face = patches.normal[patch], patches.face[patch]
        if not scene.faces.is_curved.any():
            return points, own
        sides, table = np.where(patches.front[patch], 1.0, -1.0), self.solution.surroundings.table
        smooth = smooth_normals(scene.faces, table, sides[:, None] * own, face, points)
        return Detail(scene, table).raised(face, points, sides), sides[:, None] * smooth


def _uv(solution, patch, points):
    """Return texture coordinates (k, 2) at points of patches."""
    faces, found = solution.scene.faces, np.zeros((len(points), 2))
    if faces.uv is None:
        return found
    face = solution.patches.face[patch]
    some = np.flatnonzero(np.isfinite(faces.uv[face]).all(axis=(1, 2)))
    if len(some):
        table = solution.surroundings.table
        st = coordinates_at(table, face[some], np.ascontiguousarray(points[some]))
        weight = weights(st, faces.is_triangle[face[some]])
        found[some] = between(faces.uv[face[some]], weight)
    return found
