"""Plots: the trade of speed for accuracy, and how solvers converge."""

from collections.abc import Mapping, Sequence
from os import PathLike

import numpy as np

from radiosity.solve.tradeoff import Trial
from radiosity.transport.files import written_whole
from radiosity.view.levels import PictureTrial

STYLE = {"linear": ("o-", "C0"), "constant": ("s-", "C1"), "clusters": ("^-", "C2")}
MARKS = "o-", "s-", "^-", "D-", "v-", "P-"
APART = 0.1  # relative difference in time and error below which labels would overlap


def plot_tradeoff(
    found: list[Trial], name: str, path: str | PathLike, pictures: list[PictureTrial]
) -> None:
    """Write log-log plots of true error against time: of kinds of elements, and of pictures."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.4, 4.2), layout="constrained")
    axes, beside = figure.subplots(1, 2, width_ratios=(3, 2))
    _plot_trials(axes, found, name)
    _plot_pictures(beside, pictures)
    with written_whole(path) as temporary:
        figure.savefig(temporary, dpi=120)


def plot_histories(
    found: Mapping[str, Sequence[float]], name: str, path: str | PathLike, tolerance: float
) -> None:
    """Write a plot of error bounds against iterations, a curve a solver.

    Parameters
    ----------
    found : mapping
        The error bound after each iteration, see `radiosity.Solution.history`, by solver.
    name : str
        Of the scene.
    path : str or path
        ``.png``, ``.pdf`` or ``.svg``.
    tolerance : float
        At which solvers stop: drawn as a line.

    Examples
    --------
    >>> import radiosity
    >>> solution = radiosity.solve(radiosity.load("scenes/box6.toml"), 0.1, solver="jacobi")
    >>> plot_histories({"jacobi": solution.history}, "box", "jacobi.png", 1e-6)
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for k, (solver, history) in enumerate(found.items()):
        at = np.arange(1, len(history) + 1)
        bounds = np.maximum(history, np.finfo(float).tiny)  # 0: nothing emits
        axes.semilogy(at, bounds, MARKS[k % len(MARKS)], markersize=4, label=solver)
    axes.axhline(tolerance, color="grey", linestyle="--", linewidth=1, label="tolerance")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_title(f"{name}: convergence")
    axes.set_xlabel("iterations, each about one product with the matrix")
    axes.set_ylabel("bound of the relative error")
    axes.grid(True, which="major", alpha=0.3)
    axes.legend()
    with written_whole(path) as temporary:
        figure.savefig(temporary, dpi=120)


def _plot_trials(axes, found, name):
    for way, (marker, colour) in STYLE.items():
        mine = [t for t in found if t.way == way]
        seconds, error = [t.seconds for t in mine], [100 * t.error for t in mine]
        axes.loglog(seconds, error, marker, color=colour, label=way)
        for some in _in_one_place(mine):
            label = ", ".join(f"{100 * t.accuracy:g}" for t in some)
            axes.annotate(f"{label} %", (some[0].seconds, 100 * some[0].error), (4, 4),
                          textcoords="offset points", fontsize=7, color=colour)  # fmt: skip
    axes.set_title(f"{name}: labels are the accuracies asked")
    axes.legend()
    _finish(axes, "time to solve, s", "true error, % (95 % of the surfaces)")


def _plot_pictures(axes, pictures):
    for trial in pictures:
        axes.loglog([trial.seconds], [100 * trial.error], "o", label=trial.way)
    axes.set_title("pictures by method")
    axes.legend()
    _finish(axes, "time to solve and picture, s", "rms error of the picture, %")


def _finish(axes, across, up):
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.grid(True, which="both", alpha=0.3)


def _in_one_place(trials: list[Trial]) -> list[list[Trial]]:
    """Return runs of trials that one label serves: they took as long, and err as much."""
    runs = []
    for trial in trials:
        if runs and np.abs(_place(trial) - _place(runs[-1][0])).max() <= APART:
            runs[-1].append(trial)
        else:
            runs.append([trial])
    return runs


def _place(trial):
    return np.log(np.maximum([trial.seconds, trial.error], 1e-9))
