"""``--json``: one object on stdout, whose schema is ``schemas/VERB.json``; see docs/json.md.

With an exit code of 0, or of 1 where what was found falls short, it is the verb's answer; where
there is none, it is that of ``schemas/error.json``. Numbers that do not exist are null.
"""

import json
import math
from typing import Any

from radiosity import __version__


def print_answer(told: dict[str, Any]) -> None:
    """Print a verb's answer, with the version of the program."""
    print(json.dumps(_plain({"radiosity": __version__, **told}), allow_nan=False))


def print_failure(message: str, code: int) -> None:
    """Print the object that stands for an answer which could not be had."""
    print_answer({"error": message, "exit_code": code})


def solved(solution) -> dict[str, Any]:
    """Return what all verbs that solve tell of a solution; of None, a scene that needed none."""
    if solution is None:
        return dict.fromkeys(SOLVED)
    plan = solution.plan
    values = (
        plan.accuracy, plan.seconds, float(solution.estimate.reached), len(solution.patches),
        solution.solver, len(solution.history), solution.seed,
    )  # fmt: skip
    return dict(zip(SOLVED, values, strict=True))


SOLVED = (
    "accuracy", "time_asked", "estimated_error", "patches", "solver", "iterations", "seed",
)  # fmt: skip


def pictured(
    solution, method: str, look, pictures: list[dict], seconds: float, page: str | None = None
) -> dict[str, Any]:
    """Return what is told of pictures, or of a page; only gather needs a solution."""
    scale = look.scale and {"maximum_cd_m2": look.scale.maximum, "decades": look.scale.decades}
    return {
        "scene": solution.scene.name,
        "method": method,
        **solved(solution if method == "gather" else None),
        "false_colour": scale,
        "pictures": pictures,
        "seconds": seconds,
        "written": [*(picture["file"] for picture in pictures), *([page] if page else [])],
    }


def picture(camera, path, image) -> dict[str, Any]:
    """Return what is told of a picture that was written."""
    height, width = image.pixels.shape[:2]
    return {
        "camera": camera.name, "file": str(path), "width": width, "height": height,
        "exposure": float(image.exposure), "noise": image.noise, "outside": int(image.outside),
    }  # fmt: skip


def _plain(value):
    """Return a value as JSON holds it: arrays as lists, null for what is not finite."""
    if isinstance(value, dict):
        return {key: _plain(x) for key, x in value.items()}
    if hasattr(value, "tolist"):  # of numpy, which is not loaded for this
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(x) for x in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
