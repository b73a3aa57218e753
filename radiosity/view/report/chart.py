"""Maps drawn: false colours of illuminance, isolux lines with their numbers, dimensions, a scale.

The levels are those that EN 12464-1 grades illuminance in, 1, 1.5, 2, 3, 5 and 7.5 times powers of
ten, or of many 1, 2 and 5; where not three of them fall on a map, even steps of round numbers.
"""

import io

import numpy as np

from radiosity.view.report.maps import Map

GRADES, COARSER = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 7.5]), np.array([1.0, 2.0, 5.0])
FEW, MOST = 3, 9  # lines
WIDE, HIGH = 7.0, 5.2  # inches that a map takes at most, with its scale
SPREAD = 8.0  # of the brightest to the median, beyond which colours are logarithmic
GAP = 0.035  # of the scale, between numbers
LOWEST = 1e-3  # of the brightest, where logarithmic colours begin
DPI = 150
DOTS = 800  # points of a grid that are still marked


def draw(found: Map) -> bytes:
    """Return a map as a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    size = np.ptp(found.outline if len(found.outline) else found.place, axis=(0, 1))
    room = np.array([WIDE - 1.7, HIGH - 0.9])
    scale = float((room / np.maximum(size, 1e-12)).min())
    body = np.maximum(size * scale, 0.8)
    figure = Figure(tuple(body + [1.7, 0.9]), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    _fill(figure, axes, found)
    _frame(axes, found)
    stored = io.BytesIO()
    figure.savefig(stored, format="png", bbox_inches="tight", pad_inches=0.04,
                   metadata={"Software": None})  # fmt: skip
    return stored.getvalue()


def levels(low: float, high: float) -> np.ndarray:
    """Return the illuminances in lx of isolux lines between two, ascending, at most `MOST`.

    Examples
    --------
    >>> levels(90.0, 700.0).tolist(), levels(401.0, 419.0).tolist()
    ([100.0, 150.0, 200.0, 300.0, 500.0], [404.0, 408.0, 412.0, 416.0])
    >>> levels(0.0, 0.0).tolist()
    []
    """
    if not high > max(low, 0.0) or high - low < 1e-6 * high:
        return np.zeros(0)
    inner = _graded(GRADES, low, high)
    if len(inner) > MOST:
        inner = _graded(COARSER, low, high)
    if len(inner) < FEW:
        from matplotlib.ticker import MaxNLocator

        even = MaxNLocator(5, steps=[1, 2, 2.5, 4, 5, 10]).tick_values(low, high)
        inner = even[(even > low) & (even < high)]
    return inner[-MOST:]


def _graded(steps, low, high):
    top = np.floor(np.log10(high))
    grades = np.outer(10.0 ** np.arange(top - 3, top + 1), steps).ravel()
    return grades[(grades > low) & (grades < high)]


def _fill(figure, axes, found):
    """Draw the colours, the lines, and the scale with their levels."""
    from matplotlib.patheffects import withStroke

    lux = np.ma.masked_invalid(found.lux)
    if lux.count() == 0 or lux.max() <= 0.0:
        axes.text(0.5, 0.5, "no light", transform=axes.transAxes, ha="center", va="center")
        return
    x, y = np.moveaxis(found.place, -1, 0)
    shown = axes.pcolormesh(x, y, lux, cmap="viridis", norm=_norm(lux), shading="nearest",
                            rasterized=True)  # fmt: skip
    bar = figure.colorbar(shown, ax=axes, shrink=0.9, pad=0.03, fraction=0.06)
    bar.set_label("illuminance in lx")
    lines = levels(float(lux.min()), float(lux.max()))
    if len(lines) and min(lux.shape) > 1:
        halo = [withStroke(linewidth=2.2, foreground="#00000055")]
        drawn = axes.contour(x, y, lux, levels=lines, colors="white", linewidths=0.9)
        drawn.set(path_effects=halo)
        for label in axes.clabel(drawn, fmt=lambda v: f"{v:g}", fontsize=8):
            label.set_path_effects(halo)
    bar.minorticks_off()
    if len(lines):
        ticks = _apart(lines, shown.norm)
        bar.set_ticks(ticks, labels=[f"{v:g}" for v in ticks])


def _apart(lines, norm):
    """Return those of some levels whose numbers have room on the scale, from the top."""
    kept = [lines[-1]]
    for level in lines[-2::-1]:
        if float(norm(kept[-1]) - norm(level)) >= GAP:
            kept.append(level)
    return kept[::-1]


def _norm(lux):
    """Return what makes colours of illuminances: even steps, or ratios where few are bright."""
    from matplotlib.colors import LogNorm, Normalize

    top, middle = float(lux.max()), float(np.ma.median(lux))
    if middle > 0.0 and top > SPREAD * middle:
        return LogNorm(max(float(lux.min()), LOWEST * top), top, clip=True)
    return Normalize(min(0.0, float(lux.min())), top)


def _frame(axes, found):
    """Draw the walls or edges, the points, and what the axes are."""
    from matplotlib.collections import LineCollection

    axes.add_collection(LineCollection(found.outline, colors="black", linewidths=1.4))
    if len(found.points) <= DOTS:
        axes.plot(*found.points.T, ".", color="black", markersize=2.2, alpha=0.7)
    axes.set_xlabel(found.axes[0])
    axes.set_ylabel(found.axes[1])
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.02)
    if found.down:
        axes.invert_yaxis()
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
