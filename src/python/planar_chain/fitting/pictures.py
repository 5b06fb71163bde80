"""A picture of a fit: measured and fitted angles, residuals, and the ellipse of the two numbers with the largest correlation."""

import matplotlib
matplotlib.use("Agg")
import numpy as np  # noqa: E402  pylint: disable=wrong-import-position
from matplotlib import pyplot  # noqa: E402  pylint: disable=wrong-import-position

from .varied import NOT_ZERO  # noqa: E402  pylint: disable=wrong-import-position

COLOURS = ("#1F77B4", "#D62728", "#2CA02C", "#9467BD", "#FF7F0E", "#17BECF", "#8C564B", "#E377C2")
MOST_RECORDINGS, MOST_JOINTS, MOST_POINTS = 3, 8, 150
ROUNDING = 1e-12  # of a correlation: two numbers that hang together fully have a region of no width


def draw(result, title):
    """A figure. It draws the first few recordings."""
    columns = min(len(result.recordings), MOST_RECORDINGS)
    figure = pyplot.figure(figsize=(2.6 * columns + 3.2, 5.0), constrained_layout={"w_pad": 0.12})
    shown = f", the first {columns} of {len(result.recordings)} recordings" if columns < len(result.recordings) else ""
    figure.suptitle(title + shown)
    grid = figure.add_gridspec(2, columns + 1, width_ratios=[1] * (columns + 1), height_ratios=[2, 1])
    upper = lower = None
    for k in range(columns):
        recording, angles = result.recordings[k], result.angles[k]
        upper = figure.add_subplot(grid[0, k], sharey=upper)
        lower = figure.add_subplot(grid[1, k], sharex=upper, sharey=lower)
        every = max(1, len(recording) // MOST_POINTS)
        for j, joint in list(enumerate(result.joints))[:MOST_JOINTS]:
            colour = COLOURS[j]
            upper.plot(recording.t[::every], recording.q[::every, j], "o", markersize=3, markeredgewidth=0.6,
                       markerfacecolor="none", color="#7F7F7F", label="_" * (j > 0) + "measured")
            upper.plot(recording.t, angles[:, j], color=colour, linewidth=1.1, label=f"{joint}, fitted")
            lower.plot(recording.t, 1e3 * (angles[:, j] - recording.q[:, j]), color=colour, linewidth=0.8)
        upper.set_title(recording.name, fontsize="medium")
        upper.label_outer()
        lower.label_outer()
        lower.set_xlabel("time (s)")
        for axes in (upper, lower):
            axes.grid(alpha=0.3)
        if k == 0:
            upper.set_ylabel("q (rad or m)" if "m" in result.units else "angle q (rad)")
            lower.set_ylabel("residual (mrad or mm)" if "m" in result.units else "residual (mrad)")
            handles = upper.get_legend_handles_labels()
    beside = figure.add_subplot(grid[0, columns])
    if result.pair is None:
        beside.axis("off")
    else:
        ellipse(beside, result)
    figure.add_subplot(grid[1, columns], frame_on=False, xticks=[], yticks=[]).legend(*handles, loc="upper left", frameon=False)
    return figure


def ellipse(axes, result):
    """Where both numbers lie with 95 % probability, if the others may have any values."""
    a, b = result.pair
    covariance = result.covariance[np.ix_([a, b], [a, b])]
    one, other = result.numbers[a], result.numbers[b]
    turn = np.linspace(0, 2 * np.pi, 200)
    size = np.sqrt(np.maximum(np.diag(covariance), NOT_ZERO))
    root = np.linalg.cholesky(covariance / np.outer(size, size) + ROUNDING * np.eye(2)) * size[:, None]
    x, y = np.array([[one.value], [other.value]]) + np.sqrt(-2 * np.log(0.05)) * root @ [np.cos(turn), np.sin(turn)]
    units = [10.0 ** np.floor(np.log10(max(abs(values).max(), NOT_ZERO))) for values in (x - one.value, y - other.value)]
    axes.plot((x - one.value) / units[0], (y - other.value) / units[1], color=COLOURS[0])
    axes.plot(0, 0, "+", color=COLOURS[0])
    correlation = covariance[0, 1] / (size[0] * size[1])
    axes.set_title(f"95 % region of the two with the\nlargest correlation ({correlation:+.4f})", fontsize="medium")
    xlabel, ylabel = (f"{found.path}\n(value − {found.value:.5g}) / {unit:g}" for found, unit in zip((one, other), units))
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.locator_params(nbins=4)
    axes.grid(alpha=0.3)
