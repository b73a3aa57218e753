"""The groups of light in the window: how bright each is, and what surfaces look like then."""

import numpy as np

from radiosity.solve.solution import Solution
from radiosity.view.window.geometry import Corners
from radiosity.view.window.later import Later

FULL = 2.0  # factor at the right end of a group's slider


class Lamps:
    """The groups of light of a solution, each with a factor.

    Attributes
    ----------
    names : tuple of str
        Empty where groups are not told apart.
    factors : dict of str to float
    """

    def __init__(self, solution, corners: Corners):
        """Leave all light as it is; a `Stage` in place of a Solution has no groups."""
        dims = isinstance(solution, Solution) and solution.can_dim
        self.names = solution.groups if dims else ()
        self.factors, self._before = dict.fromkeys(self.names, 1.0), {}
        self._whole, self._corners = solution, corners
        self._all = _at_corners(solution, corners)
        self._parts = self._lit = None

    @property
    def changed(self) -> bool:
        """Return whether any group is not as bright as it is in the scene."""
        return any(factor != 1.0 for factor in self.factors.values())

    @property
    def waiting(self) -> bool:
        """Return whether the groups are being told apart, so that no factor shows as yet."""
        return self._parts is not None and not self._parts.ready

    @property
    def trouble(self) -> Exception | None:
        """Return what telling the groups apart ended in."""
        return None if self._parts is None else self._parts.error

    def dim(self, name: str, factor: float) -> None:
        """Give a group a factor; the first time, start to tell the groups apart."""
        self.factors[name] = factor
        self._lit = None
        if self._parts is None:
            self._parts = Later(self._told_apart)

    def switched(self, name: str) -> float:
        """Return the factor that a group that is switched gets: 0, or the one before."""
        if not self.factors[name]:
            return self._before.get(name, 1.0)
        self._before[name] = self.factors[name]
        return 0.0

    def at_corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Return radiosity and irradiance (p, bands) in W/m2 at the corners, in this light."""
        found = self._all
        if self.changed and self._parts is not None and self._parts.result is not None:
            weighted = [(self.factors[name], part) for name, part in self._parts.result.items()]
            found = [sum(factor * part[k] for factor, part in weighted) for k in range(2)]
        return tuple(np.maximum(x, 0.0) for x in found)

    @property
    def solution(self):
        """Return the solution in this light."""
        if not self.changed or self.waiting or self.trouble is not None:
            return self._whole
        if self._lit is None:
            self._lit = self._whole.dimmed(self.factors)
        return self._lit

    def _told_apart(self):
        parts = self._whole.by_groups().items()
        return {name: _at_corners(solution, self._corners) for name, solution in parts}


def _at_corners(solution, corners):
    return corners.smooth(solution.radiosity), corners.smooth(solution.irradiance_on)
