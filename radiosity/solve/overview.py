"""Plans and solutions as notebooks show them: what is modelled, power, errors, light."""

from typing import TYPE_CHECKING

import numpy as np

from radiosity.light.photometry import illuminance, photometric
from radiosity.scene.markup import in_notebook, line, table
from radiosity.scene.names import counted
from radiosity.scene.overview import capped
from radiosity.solve.plan import Plan, size_text

if TYPE_CHECKING:
    from radiosity.solve.requirements import Forecast
    from radiosity.solve.solution import Solution


def plan_html(plan: Plan) -> str:
    """Return how a scene will be solved, as HTML."""
    kind = f"{plan.clusters} clusters" if plan.clusters else f"order {plan.recipe.order}"
    asked = f"{100 * plan.accuracy:g} %"
    if plan.seconds is not None:
        asked = f"the best within {plan.seconds:g} s"
    rows = [
        ("accuracy", asked), ("elements", kind),
        ("mesh", "refined until the error is met" if plan.adapts else "as it was given"),
        ("cells at first", plan.division.count), ("solver", plan.recipe.solver),
        ("seed", plan.recipe.seed),
    ]  # fmt: skip
    return in_notebook("Plan", table([], rows))


def forecast_text(forecast: "Forecast") -> str:
    """Return what a scene requires and what its answer will cost, as lines of text."""
    lines = [f"{r.name:17}{r.model:18}{r.reason}" for r in forecast.requirements]
    return "\n".join([
        *lines,
        "",
        f"{'patches':17}about {forecast.patches}",
        f"{'time':17}about {forecast.seconds:.2g} s, start-up left out",
        f"{'memory':17}about {size_text(forecast.memory)}",
    ])  # fmt: skip


def forecast_html(forecast: "Forecast") -> str:
    """Return what a scene requires and what its answer will cost, as HTML."""
    required = [(r.name, r.model, r.reason) for r in forecast.requirements]
    cost = [
        ("patches", f"about {forecast.patches}"),
        ("time", f"about {forecast.seconds:.2g} s, start-up left out"),
        ("memory", f"about {size_text(forecast.memory)}"),
    ]
    return in_notebook(
        f"Plan for an accuracy of {100 * forecast.plan.accuracy:g} %",
        table(["part", "modelled", "because"], required), table([], cost),
    )  # fmt: skip


def solution_html(solution: "Solution") -> str:
    """Return what a solution is, as HTML: error, power balance and light of the materials.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/furnace.toml"), 0.1)
    >>> ">2259<" in solution_html(solution)  # lx on its walls
    True
    """
    plan, level = solution.plan, solution.level
    asked = f"asked {100 * plan.accuracy:g} %"
    if plan.seconds is not None or not plan.adapts:
        asked = "on the mesh given" if plan.seconds is None else f"within {plan.seconds:g} s"
    said = (
        f"{counted(len(solution.patches), 'patch')}, "
        f"{counted(len(level.history), 'iteration')} of {level.solver}; "
        f"error {asked}, estimated {100 * solution.estimate.reached:.2g} %; "
        f"{'closed' if solution.closed else 'open'}"
    )
    groups = f"light groups: {', '.join(solution.groups[:30]) or 'none'}"
    return in_notebook(
        solution.scene.name, line(said), line(groups), capped(_light(solution)), _power(solution)
    )


def _light(solution):
    """Return mean illuminances of the materials' lit patches, by area, with the means of errors."""
    scene, patches, rows = solution.scene, solution.patches, []
    lux, error = solution.illuminance, illuminance(solution.error, scene.bands)
    owner = scene.faces.material[patches.face]
    for k in np.unique(owner[solution.live]):
        mine = (owner == k) & solution.live
        area = patches.area[mine]
        values = [np.average(x[mine], weights=area) for x in (lux, error)]
        least, most = lux[mine].min(), lux[mine].max()
        rows.append([scene.materials[k].name, *(f"{v:.4g}" for v in (values[0], least, most)),
                     f"{values[1]:.2g}"])  # fmt: skip
    heads = ["illuminance in lx of", "mean", "smallest patch", "largest patch", "error of the mean"]
    return heads, rows, range(1, 5)


def _power(solution):
    """Return the power balance, a column a band; of wavelengths in lumens."""
    balance, bands = solution.balance, solution.scene.bands
    few = bands.wavelengths is None
    heads = ["power", *(f"{name}, W" for name in bands.names if few), "luminous, lm"]
    rows = []
    for name in ("emitted", "absorbed", "escaped"):
        power = getattr(balance, name)
        values = [*(power if few else ()), photometric(power, bands)]
        rows.append([name, *(f"{v:.4g}" for v in values)])
    return table(heads, rows, range(1, len(heads)))
