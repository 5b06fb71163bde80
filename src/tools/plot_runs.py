"""Many runs in one picture: the angles at the end over each value that varied, and their spread over time."""

import numpy as np
from matplotlib import pyplot
from plot_panels import FINE, kinds

PANEL = 2.6  # inch
MOST_PATHS = 4
MANY = 2000  # runs; of more, colour shows how many lie in a place
CELLS = 70   # of a panel, across
GRID = 0.1   # of the runs: so many values of a number at most are a grid

# Units of the keys of a scene, by the last names of their path.
UNITS = {
    "mass": "kg", "inertia": "kg m²", "rotor_inertia": "kg m²", "com": "m", "pin": "m", "point": "m", "angle": "rad",
    "rest_angle": "rad", "lower": "rad", "upper": "rad", "phase": "rad", "velocity": "rad/s", "position": "m", "velocity_limit": "rad/s",
    "damping": "N m s/rad", "stop_damping": "N m s/rad", "stiffness": "N m/rad", "stop_stiffness": "N m/rad", "torque": "N m",
    "friction": "N m", "breakaway": "N m", "joint/drag": "N m s²/rad²", "effort_limit": "N m", "moment": "N m", "force": "N",
    "drag": "N s²/m²", "coefficient": "N s²/m²", "springs/stiffness": "N/m", "springs/damping": "N s/m", "rest_length": "m",
    "ground": "m", "no_load_speed": "rad/s", "time_constant": "s", "command_delay": "s", "gravity": "m/s²",
    "frequency": "Hz", "start": "s", "stop": "s", "times": "s", "step": "s", "drive/amplitude": "rad", "drive/offset": "rad",
    "drive/values": "rad", "x/amplitude": "m", "x/offset": "m", "x/values": "m", "y/amplitude": "m", "y/offset": "m",
    "y/values": "m", "angle/amplitude": "rad", "angle/offset": "rad", "angle/values": "rad"}


ALONG = {  # in a prismatic joint
    "rad": "m", "rad/s": "m/s", "N m": "N", "N m s/rad": "N s/m", "N m/rad": "N/m", "N m s²/rad²": "N s²/m²", "kg m²": "kg"}


def with_unit(path, links=None):
    """links/a/mass (kg). links: of prismatic joints; None if that is not known: links/a/joint/damping (N m s/rad or N s/m)"""
    keys = [key for key in path.split("/") if not key.isdigit()]
    names = ("/".join(keys[-2:]), f"{keys[0]}/{keys[-1]}", keys[-1]) if keys else ()
    unit = next((UNITS[name] for name in names if name in UNITS), None)
    if unit in ALONG and (keys[2:3] == ["joint"] or keys[2:] == ["initial", "velocity"]) and (links is None or keys[1] in links):
        unit = ALONG[unit] if links is not None else f"{unit} or {ALONG[unit]}"
    return f"{path} ({unit})" if unit else path


class Runs:
    """The rows of a CSV of `sweep`: paths and values of what varied; t; q, one column for each joint; failed."""

    def __init__(self, header, rows):
        self.prismatic = self.links = self.body = None  # as of a Motion; the links of these joints
        at = header.index("t")
        self.paths, self.joints = header[1:at], [name[2:] for name in header if name.startswith("q_")]
        table = np.array([row[:-1] for row in rows], dtype=float)
        self.values, self.t = table[:, 1:at], table[:, at]
        self.q = table[:, at + 1:at + 1 + len(self.joints)]
        self.failed = np.array([row[-1] != "" for row in rows])

    def know(self, body):
        self.prismatic, self.links = ([name for name, axis in zip(names, body.axis) if axis != 0] for names in (body.joints, body.names))

    @staticmethod
    def are_in(header):
        return header[:1] == ["run"] and "t" in header[2:] and header[-1] == "reason"


def scatter(panel, x, y, shade, colour):
    """A point for each run, coloured by `shade` unless that is None. Many runs that are no grid become cells: the more runs, the darker.
    Returns what a bar of colours shows, or None; and True if they are cells."""
    is_grid = shade is not None and len(np.unique(shade)) < GRID * len(x)
    if not (len(x) <= MANY or is_grid or np.ptp(x) == 0 or np.ptp(y) == 0):
        return panel.hexbin(x, y, gridsize=CELLS, mincnt=1, bins="log", cmap="viridis_r", linewidths=0), True
    if shade is None:
        panel.plot(x, y, ".", markersize=3, color=colour)
        return None, False
    return panel.scatter(x, y, s=6 if len(x) <= MANY else 2, c=shade, linewidths=0), False


def show_colours(figure, column, points, label):
    """A bar of colours above a column of panels. points: what scatter() returned for each."""
    coloured, is_cells = zip(*points)
    if coloured[0] is None:
        return
    limits = np.array([each.get_clim() for each in coloured])
    for each in coloured:  # one scale
        each.set_clim(limits[:, 0].min(), limits[:, 1].max())
    bar = figure.colorbar(coloured[0], ax=list(column), location="top", shrink=0.9, aspect=40, label="runs in a cell" if is_cells[0] else label)
    if not is_cells[0]:
        bar.formatter.set_useOffset(False)
        bar.update_ticks()


def draw_runs(runs, columns, title, wrap, colour):
    paths = runs.paths[:MOST_PATHS]
    times = np.unique(runs.t[np.isfinite(runs.t)])
    last, whole = runs.t == times[-1], ~np.isnan(runs.q).any(axis=1)
    turns = np.array([wrap and name not in (runs.prismatic or ()) for name in runs.joints])
    q = runs.q - np.where(turns, 2 * np.pi * np.ceil((runs.q - np.pi) / (2 * np.pi)), 0)
    shape = len(columns), len(paths) + (len(times) > 1)
    figure, axes = pyplot.subplots(*shape, figsize=(1 + PANEL * 1.5 * shape[1], 1 + PANEL * shape[0]), squeeze=False,
                                   sharex="col", sharey="row", constrained_layout=True)
    failed = np.count_nonzero(last & runs.failed)
    figure.suptitle(f"{title}: {np.count_nonzero(last)} runs at {times[-1]:g} s" +
                    (f", {failed} failed (× at the lower edge)" if failed else ""))
    shown, points = last & whole, [[] for _ in paths]
    others = [1 - min(k, 1) if len(paths) > 1 else None for k in range(len(paths))]  # the second one gives the colour; beside itself, the first
    for row, j in zip(axes, columns):
        for k, (panel, other) in enumerate(zip(row, others)):
            shade = None if other is None else runs.values[shown, other]
            points[k].append(scatter(panel, runs.values[shown, k], q[shown, j], shade, colour))
            lost = runs.values[last & runs.failed, k]
            panel.plot(lost, np.zeros(len(lost)), "x", color="#D55E00", transform=panel.get_xaxis_transform())
        if len(times) > 1:
            spread = np.array([np.percentile(q[(runs.t == t) & whole, j], [5, 25, 50, 75, 95]) for t in times])
            for low, high in ((0, 4), (1, 3)):
                row[-1].fill_between(times, spread[:, low], spread[:, high], color=colour, alpha=0.25, linewidth=0)
            row[-1].plot(times, spread[:, 2], color=colour)
        row[0].set_ylabel(f"q of {runs.joints[j]} ({kinds(runs, [j])[0][0][0][1]})")
    for panel, path in zip(axes[-1], paths):
        panel.set_xlabel(with_unit(path, runs.links))
    for column, other, found in zip(axes.T, others, points):
        show_colours(figure, column, found, "" if other is None else with_unit(paths[other], runs.links))
    for panel in axes.flat:
        panel.ticklabel_format(useOffset=False)
        low, high = panel.get_xlim()
        if high - low < FINE * max(abs(low), abs(high)):
            panel.locator_params(axis="x", nbins=2)
    if len(times) > 1:
        axes[-1][-1].set_xlabel("time (s): median, half and 90 % of the runs")
    return figure
