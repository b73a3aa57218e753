"""Plots: the trade of speed for accuracy."""

from os import PathLike

import numpy as np

from radiosity.solve.tradeoff import Trial
from radiosity.transport.files import written_whole

STYLE = {"linear": ("o-", "C0"), "constant": ("s-", "C1"), "clusters": ("^-", "C2")}
APART = 0.1  # relative difference in time and error below which labels would overlap


def plot_tradeoff(found: list[Trial], name: str, path: str | PathLike) -> None:
    """Write a log-log plot of true error against time, one line for each kind of element."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for way, (marker, colour) in STYLE.items():
        mine = [t for t in found if t.way == way]
        seconds, error = [t.seconds for t in mine], [100 * t.error for t in mine]
        axes.loglog(seconds, error, marker, color=colour, label=way)
        for some in _in_one_place(mine):
            label = ", ".join(f"{100 * t.accuracy:g}" for t in some)
            axes.annotate(f"{label} %", (some[0].seconds, 100 * some[0].error), (4, 4),
                          textcoords="offset points", fontsize=7, color=colour)  # fmt: skip
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("time to solve, s")
    axes.set_ylabel("true error, % (95 % of the surfaces)")
    axes.set_title(f"{name}: labels are the accuracies asked")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    with written_whole(path) as temporary:
        figure.savefig(temporary, dpi=120)


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
