"""Draws the chain at several instants, as under a stroboscope. For plot."""

import numpy as np
from drawing.poses import PATHS, Pose, View, in_view, legend_of, lines_of
from matplotlib import pyplot
from matplotlib.colors import ListedColormap, Normalize

WIDEST, HIGHEST = 7.0, 5.5     # inch, size of the drawing at most
LEAST = 2.4, 1.5               # inch, width and height at least
LEFT, RIGHT, BELOW, ABOVE = 0.85, 1.35, 1.05, 0.45  # inch, around it


def frame(view):
    """A figure with the axes of the plane and of the colours, and the metres in a point of the printer."""
    width, height = view.box(WIDEST, HIGHEST, LEAST)
    figure = pyplot.figure(figsize=(LEFT + width + RIGHT, BELOW + height + ABOVE))
    w, h = figure.get_size_inches()
    axes = figure.add_axes([LEFT / w, BELOW / h, width / w, height / h])
    unit = view.limit(axes, np.array([width, height]))
    axes.locator_params(nbins=6)
    return figure, axes, figure.add_axes([(LEFT + width + 0.25) / w, BELOW / h, 0.2 / w, height / h]), unit


def draw_strobe(track, times, apart, title, points):
    """apart: distance by which each instant is moved to the right of the previous one, m. points: of Body.point(), by their names."""
    # The chain at each instant, and the paths of its points.
    body, seen = track.body, (track.t >= times[0]) & (track.t <= times[-1])
    shift = apart * np.arange(len(times))
    now = track.at(times, track.spans(seen), shift)
    along = np.interp(track.t, times, shift)
    paths = {name: np.where(seen, track.path(*point, along), np.nan) for name, point in points.items()}
    figure, axes, bar, unit = frame(View(np.concatenate([in_view(now), *(path[seen] for path in paths.values())]), body.reach))

    # Light is early, dark is late; neither end fades into a white or a black page.
    colour = ListedColormap(pyplot.get_cmap("viridis_r")(np.linspace(0.2, 0.85, 256)))
    span = Normalize(times[0], times[-1])
    for k, (name, path) in enumerate(paths.items()):
        if track.moves(path[seen]):
            trail = track.broken(path)
            axes.plot(trail.real, trail.imag, color=PATHS[k % len(PATHS)], linewidth=0.8, label="path of " + name)
            heads = now.of(*points[name])
            axes.plot(heads.real, heads.imag, "o", color=PATHS[k % len(PATHS)], markersize=3, zorder=3)
    lines = lines_of(now, unit)
    for k, t in enumerate(times):
        Pose(axes, lines, colour(span(t))).show(lines, k)
    legend_of(axes, lines)
    figure.suptitle(title, y=1 - 0.1 / figure.get_figheight(), va="top")
    axes.set(xlabel="x (m)", ylabel="y (m)")
    figure.legend(*axes.get_legend_handles_labels(), fontsize="small", loc="lower center", ncol=3, frameon=False)
    figure.colorbar(pyplot.cm.ScalarMappable(span, colour), cax=bar, label="time (s)")
    bar.hlines(times, 0, 1, color="white", linewidth=0.8)
    return figure
