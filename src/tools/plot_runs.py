"""Many runs in one picture: the angles at the end over each value that varied, and their spread over time."""

import numpy as np
from matplotlib import pyplot

PANEL = 2.6  # inch
MOST_PATHS = 4


class Runs:
    """The rows of a CSV of `sweep`: paths and values of what varied; t; q, one column for each joint; failed."""

    def __init__(self, header, rows):
        at = header.index("t")
        self.paths, self.joints = header[1:at], [name[2:] for name in header if name.startswith("q_")]
        table = np.array([row[:-1] for row in rows], dtype=float)
        self.values, self.t = table[:, 1:at], table[:, at]
        self.q = table[:, at + 1:at + 1 + len(self.joints)]
        self.failed = np.array([row[-1] != "" for row in rows])

    @staticmethod
    def are_in(header):
        return header[:1] == ["run"] and "t" in header and header[-1] == "reason"


def draw_runs(runs, columns, title, wrap, colour):
    paths = runs.paths[:MOST_PATHS]
    times = np.unique(runs.t)
    last, whole = runs.t == times[-1], ~np.isnan(runs.q).any(axis=1)
    q = runs.q - 2 * np.pi * np.ceil((runs.q - np.pi) / (2 * np.pi)) if wrap else runs.q
    shape = len(columns), len(paths) + (len(times) > 1)
    figure, axes = pyplot.subplots(*shape, figsize=(1 + PANEL * 1.5 * shape[1], 1 + PANEL * shape[0]), squeeze=False,
                                   sharex="col", sharey="row", constrained_layout=True)
    failed = np.count_nonzero(last & runs.failed)
    figure.suptitle(f"{title}: {np.count_nonzero(last)} runs at {times[-1]:g} s" +
                    (f", {failed} failed (× at the lower edge)" if failed else ""))
    for row, j in zip(axes, columns):
        for k, panel in enumerate(row[:len(paths)]):
            panel.plot(runs.values[last & whole, k], q[last & whole, j], ".", markersize=3, color=colour)
            lost = runs.values[last & runs.failed, k]
            panel.plot(lost, np.zeros(len(lost)), "x", color="#D55E00", transform=panel.get_xaxis_transform())
        if len(times) > 1:
            spread = np.array([np.percentile(q[(runs.t == t) & whole, j], [5, 25, 50, 75, 95]) for t in times])
            for low, high in ((0, 4), (1, 3)):
                row[-1].fill_between(times, spread[:, low], spread[:, high], color=colour, alpha=0.25, linewidth=0)
            row[-1].plot(times, spread[:, 2], color=colour)
        row[0].set_ylabel(f"q of {runs.joints[j]} (rad)")
    for panel, path in zip(axes[-1], paths):
        panel.set_xlabel(path)
    if len(times) > 1:
        axes[-1][-1].set_xlabel("time (s): median, half and 90 % of the runs")
    return figure
