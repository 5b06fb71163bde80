"""The pictures of a report's page, each a figure of matplotlib made from the rows of tables."""
import math

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  pylint: disable=wrong-import-position

from results import AUTO, LEVELS, OWN, best_of_engines, grouped, name_of, number  # noqa: E402  pylint: disable=wrong-import-position

# Text stays text and ticks are lines of the grid, which keeps the files small.
plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "planar_chain", "font.sans-serif": ["DejaVu Sans"],
                     "font.size": 9, "axes.grid": True,
                     "grid.alpha": 0.25, "axes.spines.top": False, "axes.spines.right": False, "xtick.bottom": False,
                     "ytick.left": False, "axes.titlesize": 9, "legend.frameon": False, "legend.fontsize": 8,
                     "legend.columnspacing": 1.2})

COLOURS = {"auto": "black", "rk4": "#9467bd", "dopri5": "#1f77b4", "dop853": "#17becf", "rodas5p": "#d62728",
           "radau13": "#ff7f0e", "taylor": "#2b8a3e", "ros34pw2": "#e377c2", "ros34pw2_fixed": "#8c564b",
           "by hand": "#7f7f7f", "odeint": "#1f77b4", "SUNDIALS": "#ff7f0e", "MuJoCo": "#d62728", "Bullet": "#2b8a3e",
           "DART": "#9467bd", "Simbody": "#e377c2", "ODE": "#8c564b"}
MARKS = {"by hand": "s", "odeint": "D", "SUNDIALS": "v", "MuJoCo": "^", "Bullet": "<", "DART": ">", "Simbody": "p",
         "ODE": "P", "Euler": "v", "RK4": "^", "implicit": "s"}
FAILURES = {"diverged": "x", "refused": "1", "timed out": r"$\rightarrow$"}
RED = "#b2182b"
FAMILIES = {"stiff": "Stiff joints: springs k, N m/rad", "stiff_damped": "Stiff joints, damped: k, N m/rad; d = k · 1 ms",
            "damped": "Damped joints, k = 100 N m/rad: d, N m s/rad",
            "heavy_tip": "Heavy tip: its mass over a link's", "slack_tip": "Heavy tip, slack: its mass over a link's",
            "light_tip": "Tapering: first mass over the last", "long": "Long chains: links", "whip": "Whips: links",
            "spin": "Spinning chain of ten links: rad/s"}


def style_of(who):
    """How a contestant (engine, method) is drawn: methods of this program solid, other programs dashed."""
    engine, method = who
    if engine != OWN:
        return dict(color=COLOURS.get(engine, "grey"), marker=MARKS.get(engine, "X"), linestyle="--", linewidth=1.1,
                    markersize=3.5)
    bold = who == AUTO
    return dict(color=COLOURS.get(method, "grey"), marker="o", linewidth=2.4 if bold else 1.3,
                markersize=4 if bold else 3, zorder=5 if bold else 3)


def plot(axes, points, **style):
    axes.plot([x for x, _ in points], [y for _, y in points], **style)


def mark_at_edge(axes, xs, marker, colour):
    """Marks at the upper edge: runs that failed."""
    edge = matplotlib.transforms.blended_transform_factory(axes.transData, axes.transAxes)
    axes.plot(xs, [0.97] * len(xs), marker=marker, markersize=6, linestyle="", transform=edge, color=colour,
              clip_on=False)


def logarithmic(axes, x_label, y_label=""):
    axes.set(xscale="log", yscale="log", xlabel=x_label, ylabel=y_label)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(matplotlib.ticker.LogLocator(numticks=12))
        axis.set_minor_locator(matplotlib.ticker.NullLocator())
        axis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda value, _: f"1e{round(math.log10(value))}"))


def legend_below(axes, columns, handles=None):
    handles = handles or axes.get_legend_handles_labels()[0]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=columns, handlelength=3)


def common_legend(figure, axes, columns, height):
    """One legend for all panels, in so much of the figure's height."""
    figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncol=columns, handlelength=3)
    figure.tight_layout(rect=(0, height, 1, 0.98))


# ---- Error against run time ----------------------------------------------------------------------

def scene(title, rows, floor):
    """This program's methods by time and by evaluations; beside them auto and the best method of each other program."""
    groups = grouped(rows, "engine", "method")
    own = [who for who in groups if who[0] == OWN]
    figure, panels = plt.subplots(1, 3, figsize=(13.5, 5.2), sharey=True)
    for axes, column, shown, x_label, heading in (
            (panels[0], "cpu_seconds", own, "time on the processor, s", "methods of planar_chain"),
            (panels[1], "evaluations", own, "evaluations of the accelerations", "the same by evaluations"),
            (panels[2], "cpu_seconds", [AUTO, *best_of_engines(rows)], "time on the processor, s",
             "auto, and the best method of each other program")):
        for who in (who for who in shown if who in groups):
            style = style_of(who)
            points = [(number(row[column]), max(number(row["error_theta"]), 1e-17)) for row in groups[who]
                      if row["outcome"] == "ok" and number(row[column]) > 0]
            plot(axes, points, **style, label=name_of(who))
            for outcome, mark in FAILURES.items():
                failed = [number(row[column]) for row in groups[who] if row["outcome"] == outcome]
                mark_at_edge(axes, [value for value in failed if value > 0], mark, style["color"])
        logarithmic(axes, x_label)
        axes.set_title(heading)
        if floor:
            axes.axhspan(1e-18, floor, color="grey", alpha=0.18, linewidth=0)
    errors = [number(row["error_theta"]) for row in rows if row["outcome"] == "ok"]
    panels[0].set_ylim(max(min(errors, default=1) / 5, 3e-18), max(10 * max(errors, default=1), 10))
    panels[0].set_ylabel("error of the angles at the end, rad")
    legend_below(panels[0], 3)
    legend_below(panels[1], 1, [plt.Line2D([], [], marker=mark, linestyle="", color="grey", label=f"{word} (upper edge)")
                             for word, mark in FAILURES.items()])
    legend_below(panels[2], 2)
    figure.suptitle(title, fontsize=11)
    figure.subplots_adjust(left=0.06, right=0.99, bottom=0.27, top=0.88, wspace=0.05)
    return figure


def verdict(cells, scenes):
    """Each cell: the time of auto over that of the fastest other method."""
    shades = {"nobody": "#eeeeee", "not reached": "#f4a582"}
    figure, axes = plt.subplots(figsize=(11.5, 0.45 * len(scenes) + 1.2))
    colours = []
    for i, name in enumerate(scenes):
        for j, level in enumerate(LEVELS):
            cell = cells[name, level]
            text = {"nobody": "–", "not reached": "not reached"}.get(cell.outcome) or (
                f"{cell.ratio:.2f}" if cell.fastest else "alone")
            if cell.outcome == "slower":
                engine, method = cell.fastest
                text += f"\n{method if engine == OWN else engine}"
            colours.append(shades.get(cell.outcome) or next(
                (shade for most, shade in ((1, "#a6dba0"), (1.25, "#e6f5d0"), (2, "#fde0c5")) if cell.ratio <= most),
                "#f4a582"))
            axes.text(j, i, text, ha="center", va="center", fontsize=8)
    image = matplotlib.colors.to_rgba_array(colours).reshape(len(scenes), len(LEVELS), 4)
    axes.imshow(image, aspect="auto", interpolation="nearest")
    axes.vlines([j - 0.5 for j in range(1, len(LEVELS))], -0.5, len(scenes) - 0.5, color="white", linewidth=2)
    axes.hlines([i - 0.5 for i in range(1, len(scenes))], -0.5, len(LEVELS) - 0.5, color="white", linewidth=2)
    axes.set(xticks=range(len(LEVELS)), xticklabels=[f"1e-{k}" for k in LEVELS], yticks=range(len(scenes)),
             yticklabels=scenes)
    axes.grid(False)
    axes.set_title("Time of auto over that of the fastest other method of any program, to an error of the angles, rad, "
                   "that every finer setting keeps;\nbelow 1 auto is the fastest; above 1 the cell names the faster method")
    figure.tight_layout()
    return figure


# ---- The other studies ---------------------------------------------------------------------------

def stability(rows, column, title, y_label):
    """A column of the stability table by family and method. A curve ends where the method fails."""
    families = grouped(rows, "family")
    lines = math.ceil(len(families) / 3)
    figure, panels = plt.subplots(lines, 3, figsize=(13.5, 2.8 * lines + 0.8), squeeze=False, sharey=True)
    for axes in panels.flat[len(families):]:
        axes.set_visible(False)
    for axes, (family, members) in zip(panels.flat, families.items()):
        for method, group in grouped(members, "method").items():
            if method == "auto" and column != "largest_stable_s":
                continue
            style = style_of((OWN, method))
            values = [mean_step(row) if method == "auto" else number(row[column])
                      for row in group]
            points = [(number(row["value"]), max(value, 1e-17)) for row, value in zip(group, values) if math.isfinite(value)]
            plot(axes, points, **style, label=method)
            if column == "largest_stable_s":
                theory = [(number(row["value"]), number(row["predicted_s"])) for row in group if row["predicted_s"]]
                plot(axes, theory, color=style["color"], linestyle=":", linewidth=1)
                axes.set_ylim(3e-10, 3)
        logarithmic(axes, FAMILIES.get(family, family))
    for axes in panels[:, 0]:
        axes.set_ylabel(y_label)
    figure.suptitle(title, fontsize=11)
    common_legend(figure, panels[0, 0], 8, 0.03)
    return figure


def mean_step(row):
    """auto's, s"""
    return number(row["auto_duration_s"]) / max(1, int(row["auto_steps"]))


def scaling(rows):
    groups = grouped(rows, "engine", "method")
    figure, panels = plt.subplots(1, 2, figsize=(13.5, 5.4), sharey=True)
    for axes, shown, heading in ((panels[0], [who for who in groups if who[0] == OWN], "methods of planar_chain"),
                                 (panels[1], [(OWN, "rk4"), *(who for who in groups if who[0] != OWN)],
                                  "rk4, and other programs' methods with equal steps")):
        for who in shown:
            style = style_of(who)
            if who[0] != OWN:  # an engine's methods apart
                style.update(marker=MARKS.get(who[1], "X"))
            plot(axes, [(int(row["links"]), number(row["seconds"])) for row in groups.get(who, [])], **style,
                 label=name_of(who))
        logarithmic(axes, "links")
        axes.set_title(heading)
        legend_below(axes, 4)
    panels[0].set_ylabel("one step, s")
    figure.tight_layout()
    return figure


def long_runs(rows):
    titles = {"double": "Double pendulum, (2, 1) from hanging", "free_chain": "Five rods whirling, no gravity"}
    figure, panels = plt.subplots(1, 3, figsize=(13.5, 5.2))
    for axes, (name, column) in zip(panels, (("double", "energy"), ("free_chain", "energy"), ("free_chain", "momentum"))):
        runs = grouped([row for row in rows if row["scene"] == name], "method", "setting")
        for (method, setting), run in runs.items():
            colour = COLOURS.get(method, "grey")
            points = [(number(row["t"]), max(abs(number(row[column])), 1e-17)) for row in run
                      if math.isfinite(number(row[column]))]
            plot(axes, points, color=colour, linewidth=1.4, linestyle="--" if setting == "1e-12" else "-",
                 label=f"{method}, {setting}")
            if any(not math.isfinite(number(row["energy"])) for row in run):
                mark_at_edge(axes, [points[-1][0] if points else 1], "x", colour)
        logarithmic(axes, "t, s", f"error of the {'energy' if column == 'energy' else 'angular momentum'}, relative")
        axes.set_title(titles[name])
    common_legend(figure, panels[0], 5, 0.1)
    return figure


def real_time(rows):
    rates = grouped(rows, "rate")
    figure, panels = plt.subplots(1, len(rates), figsize=(13.5, 4.9), sharey=True, squeeze=False)
    for axes, (rate, members) in zip(panels.flat, rates.items()):
        lengths = grouped(members, "links")
        for k, (links, cell) in enumerate(lengths.items()):
            for quantity, line, words in (("late", "-", "late"), ("work", ":", "work of a tick")):
                points = [(number(row["seconds"]), max(number(row["share"]), 1 / number(row["ticks"]))) for row in cell
                          if row["quantity"] == quantity and (row["share"] == "0" or
                                                              number(row["share"]) * number(row["ticks"]) >= 1)]
                plot(axes, points, linestyle=line, color=plt.get_cmap("viridis")(0.9 * k / max(1, len(lengths) - 1)),
                     linewidth=1.5, label=f"{links} links, {words}")
        axes.axvline(1 / number(rate), color=RED, linewidth=1)
        axes.annotate("period", (1 / number(rate), 1.01), xycoords=("data", "axes fraction"), color=RED, ha="center")
        logarithmic(axes, "late (solid), work of a tick (dotted), s")
        axes.set_title(f"{rate} Hz", pad=16)
    panels[0, 0].set_ylabel("part of the ticks that take longer")
    common_legend(figure, panels[0, 0], 4, 0.1)
    return figure
