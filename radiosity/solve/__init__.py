"""Solving: the system, its solvers, the plan and the solution.

The room and the function `radiosity.solve` share their name, so the room can be called:
``radiosity.solve(scene, accuracy)`` is `radiosity.solve.solve.solve`.
"""

import sys
from types import ModuleType


class _Room(ModuleType):
    def __call__(self, scene, accuracy: float = 0.02, **options):
        """Solve a scene; see `radiosity.solve.solve.solve`, which is imported only now.

        Examples
        --------
        >>> import radiosity
        >>> solution = radiosity.solve(radiosity.load("scenes/furnace.toml"), accuracy=0.1)
        >>> solution.radiosity[0].round(3).tolist()
        [1.25, 4.0, 2.5]
        """
        from radiosity.solve.solve import solve

        return solve(scene, accuracy, **options)


sys.modules[__name__].__class__ = _Room
