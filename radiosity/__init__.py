"""Radiosity that reaches the accuracy you ask for and says what it reached.

Examples
--------
>>> import radiosity
>>> scene = radiosity.load("scenes/furnace.toml")
>>> solution = radiosity.solve(scene, accuracy=0.1)
>>> E, error = solution.irradiance([[1, 1, 0]], [[0, 0, 1]])
>>> E.round(3).tolist()
[[1.25, 4.0, 2.5]]
"""

from importlib import import_module

from radiosity import solve  # a room that can be called, see there

__version__ = "0.1.0"

# Imported when first used: numba, scipy and VTK take longer to load than `--help` may.
_HOMES = {
    "Camera": "radiosity.scene.model",
    "FormFactors": "radiosity.transport.operator",
    "Image": "radiosity.view.image",
    "Material": "radiosity.scene.model",
    "NotClosable": "radiosity.transport.closure",
    "NotConverged": "radiosity.solve.methods",
    "Refused": "radiosity.solve.plan",
    "Scene": "radiosity.scene.model",
    "SceneError": "radiosity.scene.model",
    "Solution": "radiosity.solve.solution",
    "form_factors": "radiosity.solve.matrix",
    "load": "radiosity.solve.load",
    "plan": "radiosity.solve.forecast",
    "plot": "radiosity.view.shown",
    "render": "radiosity.view.methods",
    "report": "radiosity.view.report",
    "save": "radiosity.view.export",
    "to_pyvista": "radiosity.view.polydata",
    "write": "radiosity.view.image",
}
__all__ = [
    "Camera", "FormFactors", "Image", "Material", "NotClosable", "NotConverged", "Refused", "Scene",
    "SceneError", "Solution", "form_factors", "load", "plan", "plot", "render", "report", "save",
    "solve", "to_pyvista", "write",
]  # fmt: skip


def __getattr__(name: str):
    """Import a public name from the room it lives in."""
    if name not in _HOMES:
        raise AttributeError(f"module 'radiosity' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """List the public names."""
    return [*__all__, "__version__"]
