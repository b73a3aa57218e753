"""Plots: the trade of speed for accuracy."""

from itertools import groupby
from os import PathLike

from radiosity.solve.tradeoff import Trial
from radiosity.transport.files import written_whole

STYLE = {"linear": ("o-", "C0"), "constant": ("s-", "C1"), "clusters": ("^-", "C2")}


def plot_tradeoff(found: list[Trial], name: str, path: str | PathLike) -> None:
    """Write a log-log plot of true error against time, one line for each kind of element."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for way, (marker, colour) in STYLE.items():
        mine = [t for t in found if t.way == way]
        seconds, error = [t.seconds for t in mine], [100 * t.error for t in mine]
        axes.loglog(seconds, error, marker, color=colour, label=way)
        for _, same in groupby(mine, key=lambda t: t.patches):  # one answer to several accuracies
            some = list(same)
            label = ", ".join(f"{100 * t.accuracy:g}" for t in some)
            axes.annotate(f"{label} %", (some[0].seconds, 100 * some[0].error), (4, 4),
                          textcoords="offset points", fontsize=7, color=colour)  # fmt: skip
    axes.set_xlabel("time to solve, s")
    axes.set_ylabel("true error, % (95 % of the surfaces)")
    axes.set_title(f"{name}: labels are the accuracies asked")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    with written_whole(path) as temporary:
        figure.savefig(temporary, dpi=120)
