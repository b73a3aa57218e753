"""What solving a scene will take, before it is solved; `radiosity.plan`."""

from radiosity.scene.model import Scene, check_scene
from radiosity.solve.plan import make_plan
from radiosity.solve.requirements import Forecast, foresee


def plan(
    scene: Scene, accuracy: float = 0.02, *, mesh: str = "auto", order: int | None = None,
    solver: str = "gauss-seidel", force: bool = False,
) -> Forecast:  # fmt: skip
    """Say what a scene requires to be modelled, and foresee patches, time and memory.

    The first, coarse meshes are tried; of scenes of many faces, a small share of the rays.

    Parameters
    ----------
    scene : Scene
    accuracy, mesh, order, solver, force
        As in `radiosity.solve`.

    Returns
    -------
    Forecast
        ``requirements`` (each with ``name``, ``model`` and ``reason``), ``patches``, ``seconds``
        without start-up, ``memory`` in bytes, and the ``plan`` itself.

    Raises
    ------
    ValueError
        An option out of range.
    SceneError
        Nothing in a closed scene absorbs, or a scene made in code holds impossible numbers.

    Examples
    --------
    >>> import radiosity
    >>> forecast = radiosity.plan(radiosity.load("scenes/box6.toml"), accuracy=0.1)
    >>> {r.name: r.model for r in forecast.requirements}["visibility"]
    'nothing'
    >>> 0 < forecast.seconds < 60 and forecast.memory > 1e8
    True
    """
    check_scene(scene)
    planned = make_plan(scene, accuracy, mesh, order=order, solver=solver, force=force)
    return foresee(scene, planned)
