"""The pictures of a report's page, each a figure of matplotlib made from the rows of tables."""
import math

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  pylint: disable=wrong-import-position

# pylint: disable=wrong-import-position
from robot import RUNS  # noqa: E402
from results import AUTO, LEVELS, OWN, best_of_engines, by_contestant, grouped, name_of, number  # noqa: E402

# Text stays text and ticks are lines of the grid, which keeps the files small.
plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "planar_chain", "font.sans-serif": ["DejaVu Sans"],
                     "font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "axes.spines.top": False,
                     "axes.spines.right": False, "xtick.bottom": False, "ytick.left": False, "axes.titlesize": 8,
                     "legend.frameon": False, "legend.fontsize": 7, "legend.columnspacing": 0.8,
                     "legend.handlelength": 1.9, "legend.handletextpad": 0.5, "legend.labelspacing": 0.35})

WIDTH = 7.0  # inch: letters of 8 points are 11 pixels high on a page that is 700 wide
# No two alike, of this program's methods and of other programs.
COLOURS = {"auto": "black", "rk4": "#9467bd", "dopri5": "#1f77b4", "dop853": "#17becf", "rodas5p": "#d62728",
           "radau13": "#ff7f0e", "taylor": "#2ca02c", "ros34pw2": "#e377c2", "ros34pw2_fixed": "#8c564b",
           "by hand": "#7f7f7f", "odeint": "#3d3db8", "SUNDIALS": "#c8a200", "MuJoCo": "#8e1a4f", "Bullet": "#00896b",
           "DART": "#8fbf00", "Simbody": "#d9534f", "ODE": "#5b6b8c"}
MARKS = {"by hand": "D", "odeint": "s", "SUNDIALS": "^", "MuJoCo": "v", "Bullet": "P", "DART": "X", "Simbody": "<",
         "ODE": ">"}
LINES = {"RK4": ":", "implicit": "-."}
FAILURES = {"diverged": "x", "refused": "1", "timed out": r"$\rightarrow$"}
GREY_ZONE = dict(color="grey", alpha=0.18, linewidth=0)
RED = "#b2182b"
# The title of each family of chains, and what varies.
FAMILIES = {"stiff": ("Stiff joints", "spring k, N m/rad"),
            "stiff_damped": ("Stiff joints, d = k · 1 ms", "spring k, N m/rad"),
            "heavy_tip": ("Heavy tip", "its mass over a link's"), "long": ("Long chains", "links"),
            "whip": ("Whips", "links"), "spin": ("Ten links that spin", "rad/s")}


def style_of(who):
    """How a contestant (engine, method) is drawn: methods of this program solid, other programs dashed."""
    engine, method = who
    if engine != OWN:
        return dict(color=COLOURS.get(engine, "grey"), marker=MARKS.get(engine, "*"),
                    linestyle=LINES.get(method, "--"), linewidth=1.1, markersize=4)
    bold = who == AUTO
    return dict(color=COLOURS.get(method, "grey"), marker="o", linewidth=3.4 if bold else 1.2,
                markersize=5 if bold else 3, zorder=2.5 if bold else 3)  # a curve that equals auto's lies on it


def plot(axes, points, **style):
    """Leaves out what is not a number; zero errors are drawn as 1e-17."""
    finite = [(x, max(y, 1e-17)) for x, y in points if math.isfinite(x + y)]
    axes.plot(*(zip(*finite) if finite else ([], [])), **style)


def columns_of(rows, x, y):
    return [(number(row[x]), number(row[y])) for row in rows]


def mark_at_edge(axes, xs, marker, colour):
    """Marks at the upper edge: runs that failed."""
    edge = matplotlib.transforms.blended_transform_factory(axes.transData, axes.transAxes)
    axes.plot(xs, [0.97] * len(xs), marker=marker, markersize=6, linestyle="", transform=edge, color=colour,
              clip_on=False)


def panels(count, height, rows=1, **more):
    figure, axes = plt.subplots(rows, count, figsize=(WIDTH, height), squeeze=False, **more)
    figure.subplots_adjust(left=0.09, right=0.985, bottom=1.25 / height, top=1 - 0.5 / height, wspace=0.06)
    return figure, list(axes.flat)


def logarithmic(axes, x_label, title="", y_label=""):
    axes.set(xscale="log", yscale="log", xlabel=x_label, title=title)
    if y_label:
        axes.set_ylabel(y_label)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(matplotlib.ticker.LogLocator(numticks=8))
        axis.set_minor_locator(matplotlib.ticker.NullLocator())
        axis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda value, _: f"1e{round(math.log10(value))}"))


def legend(axes, columns, more=(), of=None, side="center"):
    """Below the panel, flush with one of its sides; or at the top of the figure `of`."""
    handles = [*axes.get_legend_handles_labels()[0], *more]
    if of:
        of.legend(handles=handles, loc="upper center", ncol=columns)
    else:
        axes.legend(handles=handles, loc=f"upper {side}", ncol=columns, borderaxespad=0,
                    bbox_to_anchor=({"left": 0, "center": 0.5, "right": 1.02}[side], -0.42 / (axes.get_position().height * axes.figure.get_figheight())))


# ---- Error against run time ----------------------------------------------------------------------

def scene(title, rows, floor):
    """This program's methods by time; beside them auto and the best method of each other program. If several runs of one failed in
    one way, only the slowest is marked."""
    groups = grouped(rows, "engine", "method")
    arrived = by_contestant(rows)
    figure, axes = panels(2, 4.6, sharex=True, sharey=True)
    shown = {"methods of planar_chain": [who for who in groups if who[0] == OWN],
             "auto and each other program's best method": [AUTO, *best_of_engines(rows)]}
    seen = set()
    for each, (heading, names) in zip(axes, shown.items()):
        for who in (who for who in names if who in groups):
            plot(each, columns_of(arrived[who], "cpu_seconds", "error_theta"), **style_of(who), label=name_of(who))
            for outcome, mark in FAILURES.items():
                times = [number(row["cpu_seconds"]) for row in groups[who] if row["outcome"] == outcome]
                if times:
                    mark_at_edge(each, [max(times)], mark, style_of(who)["color"])
                    seen.add(outcome)
        logarithmic(each, "time on the processor, s", heading)
        if floor:
            each.axhspan(1e-18, floor, **GREY_ZONE)
    errors = [number(row["error_theta"]) for row in rows if row["outcome"] == "ok"]
    axes[0].set_ylim(max(min(errors, default=1) / 5, 3e-18), max(10 * max(errors, default=1), 10))
    axes[0].set_ylabel("error of the angles at the end, rad")
    legend(axes[1], 2, side="right")
    zone = [plt.Rectangle((0, 0), 1, 1, label="rounding", **GREY_ZONE)] * bool(floor)
    legend(axes[0], 3, zone + [plt.Line2D([], [], marker=mark, linestyle="", color="grey", label=word)
                               for word, mark in FAILURES.items() if word in seen], side="left")
    figure.suptitle(title, fontsize=9)
    return figure


def asked_and_got(scenes):
    """Errors of auto over the tolerance, of angles and of rates: a curve for each scene."""
    figure, axes = panels(2, 4, sharex=True, sharey=True)
    figure.subplots_adjust(bottom=0.12, top=0.76)
    for each, column, heading in zip(axes, ("error_theta", "error_omega"), ("angles, rad", "rates, rad/s")):
        for k, (name, scene_) in enumerate(scenes.items()):
            points = [(asked, got / asked) for asked, got in columns_of(by_contestant(scene_["rows"])[AUTO], "setting", column)]
            plot(each, points, color=list(COLOURS.values())[k % len(COLOURS)], linestyle=("-", "--")[k % 2],
                 marker="os^"[k % 3], markersize=3, label=name)
        each.axhspan(1e-3, 1, color="green", alpha=0.15, linewidth=0)
        logarithmic(each, "tolerance", heading)
    axes[0].set(ylabel="error at the end over the tolerance", ylim=(1e-8, 1e8))
    legend(axes[0], 6, of=figure)
    return figure


def verdict(cells, scenes):
    """Each cell: the time of auto over that of the fastest other method."""
    scale = matplotlib.colors.LinearSegmentedColormap.from_list("ratio", ["#5aae61", "#f7f7f7", "#e08214"], N=64)
    grey, striped = "#dddddd", dict(facecolor="white", edgecolor="#999999", hatch="///", linewidth=0)
    height = 0.34 * len(scenes) + 1.6
    figure, (axes,) = panels(1, height)
    figure.subplots_adjust(left=0.125, right=1.06, bottom=0.8 / height)
    axes.grid(False)
    mesh = axes.pcolormesh([[cells[name, level].ratio for level in LEVELS] for name in scenes], cmap=scale,
                           norm=matplotlib.colors.LogNorm(0.25, 4), edgecolors="white", linewidth=2)
    for i, name in enumerate(scenes):
        for j, level in enumerate(LEVELS):
            cell = cells[name, level]
            text = f"{cell.ratio:.2f}" if cell.outcome in ("fastest", "slower") else cell.outcome.replace("nobody", "–")
            if cell.outcome == "slower":
                text += "\n" + cell.fastest[cell.fastest[0] == OWN].replace("_", "\n")
            axes.text(j + 0.5, i + 0.5, text, ha="center", va="center", fontsize=6.5, linespacing=0.95)
            if cell.outcome in ("nobody", "not reached"):
                style = dict(facecolor=grey) if cell.outcome == "nobody" else striped
                axes.add_patch(plt.Rectangle((j + 0.02, i + 0.04), 0.96, 0.92, **style))
    axes.set(xticks=[j + 0.5 for j in range(len(LEVELS))], xticklabels=LEVELS.values(),
             yticks=[i + 0.5 for i in range(len(scenes))], yticklabels=scenes, ylim=(len(scenes), 0),
             xlabel="error of the angles, rad, that every finer setting keeps",
             title="Time of auto over that of the fastest other method of any program.\n"
                   "Green: auto is faster. Orange: the cell names the faster method.")
    axes.legend(handles=[plt.Rectangle((0, 0), 1, 1, facecolor=scale(0.0), label="alone: auto and no other"),
                         plt.Rectangle((0, 0), 1, 1, label="not reached: not by auto, but by another", **striped),
                         plt.Rectangle((0, 0), 1, 1, facecolor=grey, label="–: no method reaches it")],
                loc="upper center", bbox_to_anchor=(0.5, -0.42 / (0.34 * len(scenes))), ncol=3)
    bar = figure.colorbar(mesh, ax=axes, extend="both", pad=0.01)
    bar.set_ticks([0.25, 0.5, 1, 2, 4])
    bar.ax.set_yticklabels(["1/4", "1/2", "1", "2", "4"])
    bar.minorticks_off()
    return figure


# ---- The other studies ---------------------------------------------------------------------------

def stability(rows):
    """A curve ends where every step tried blows up."""
    families = grouped(rows, "family")
    lines = math.ceil(len(families) / 3)
    figure, axes = panels(3, 2.3 * lines + 0.9, lines, sharey=True)
    figure.subplots_adjust(bottom=0.45 / figure.get_figheight(), top=1 - 0.75 / figure.get_figheight(), hspace=0.4)
    for each in axes[len(families):]:
        each.set_visible(False)
    for each, (family, members) in zip(axes, families.items()):
        for method, group in grouped(members, "method").items():
            style = style_of((OWN, method))
            plot(each, columns_of(group, "value", "auto_mean_step_s" if method == "auto" else "largest_stable_s"),
                 **style, label="auto: mean step" if method == "auto" else method)
            plot(each, columns_of(group, "value", "predicted_s"), color=style["color"], linestyle=":", linewidth=1)
        logarithmic(each, *reversed(FAMILIES.get(family, (family, ""))))
        each.set_ylim(3e-10, 3)
    legend(axes[0], 5, [plt.Line2D([], [], color="grey", linestyle=":", label="by theory")], figure)
    axes[0].set_ylabel("largest stable step, s")
    return figure


def scaling(rows):
    groups = grouped(rows, "engine", "method")
    figure, axes = panels(2, 4.2, sharex=True, sharey=True)
    for each, heading in zip(axes, ("methods of planar_chain", "rk4 and other programs, with equal steps")):
        for who, group in groups.items():
            if (who[0] == OWN) == (each is axes[0]) or who[1] == "rk4":
                plot(each, columns_of(group, "links", "seconds"), **style_of(who), label=name_of(who))
        logarithmic(each, "links", heading)
        legend(each, 3)
    axes[0].set_ylabel("one step, s")
    return figure


def effects(rows):
    """The share of an evaluation's time that is left without one effect: a point above each scene."""
    scenes = grouped(rows, "scene")
    figure, (axes,) = panels(1, 3.8)
    figure.subplots_adjust(bottom=0.24, top=0.82)
    for k, effect in enumerate(dict.fromkeys(row["without"] for row in rows if row["without"] != "nothing")):
        points = [(i, number(row["seconds"]) / number(group[0]["seconds"])) for i, group in enumerate(scenes.values())
                  for row in group if row["without"] == effect]
        plot(axes, points, linestyle="", marker="osD^v"[k % 5], markersize=6,
             color=list(COLOURS.values())[k % len(COLOURS)], label=f"without {effect}")
    axes.axhline(1, color="grey", linewidth=1)
    axes.set(xticks=range(len(scenes)), ylabel="part of the time that is left")
    axes.set_xticklabels(scenes, rotation=40, ha="right")
    legend(axes, 4, of=figure)
    return figure


def long_runs(rows):
    figure, (axes,) = panels(1, 4)
    for (method, setting), run in grouped(rows, "method", "setting").items():
        colour = COLOURS.get(method, "grey")
        points = [(t, abs(error)) for t, error in columns_of(run, "t", "energy")]
        plot(axes, points, color=colour, linewidth=1.4, linestyle="--" if setting == "1e-12" else "-",
             label=f"{method}, {setting}")
        mark_at_edge(axes, [t for t, error in points if not math.isfinite(error)], "x", colour)
    logarithmic(axes, "t, s", "Double pendulum, let go at (2, 1) from hanging", "error of the energy, relative")
    legend(axes, 5)
    return figure


def from_python(rows):
    figure, (steps, batches) = panels(2, 4.4)
    figure.subplots_adjust(bottom=0.4, wspace=0.2)
    for k, row in enumerate(row for row in rows if row["error"]):
        plot(steps, columns_of([row], "seconds", "error"), linestyle="", marker="osD^v<>"[k % 7], markersize=7, color=f"C{k}",
             label=row["way"])
    logarithmic(steps, "s per step of 5 ms", "Double pendulum", "error of an angle, rad")
    for way, group in grouped([row for row in rows if row["faster"]], "way").items():
        plot(batches, columns_of(group, "links", "faster"), marker="o", label=way)
    batches.axhline(1, color="grey", linewidth=1)
    batches.set(xlabel="links", ylabel="times as fast", title="Many runs", xticks=range(0, 21, 2))
    legend(steps, 1)
    legend(batches, 1)
    return figure


def real_time(rows):
    rates = grouped(rows, "rate")
    figure, axes = panels(len(rates), 3.8, sharex=True, sharey=True)
    for each, (rate, members) in zip(axes, rates.items()):
        colours = {}
        for (links, loosest), cell in grouped(members, "links", "loosest_tolerance").items():
            yields = loosest != "none"
            ticks = number(cell[0]["ticks"])
            points = [(number(row["seconds"]), max(number(row["share"]), 1 / ticks)) for row in cell
                      if row["share"] == "0" or number(row["share"]) * ticks >= 1]
            plot(each, points, color=colours.setdefault(links, f"C{len(colours)}"), linewidth=1.5,
                 linestyle="--" if yields else "-", label=None if yields else f"{links} links")
        each.axvline(1 / number(rate), color=RED, linewidth=1, label="period")
        logarithmic(each, "late, s", f"{rate} Hz")
        legend(each, 3)
    axes[0].set_ylabel("part of the ticks that are later")
    return figure


def robot(rows):
    """Both angles of each recording: measured, and by the model with friction and without."""
    runs = grouped(rows, "run")
    figure, axes = panels(len(runs), 3.8)
    figure.subplots_adjust(wspace=0.12)
    styles = {"measured": dict(color="black", linewidth=3, alpha=0.35), "friction": dict(color="#2b8a3e"),
              "without": dict(color=RED, linestyle="--", linewidth=1.1)}
    words = {"measured": "measured", "friction": "with friction", "without": "without friction"}
    for each, (run, group) in zip(axes, runs.items()):
        for model, motion in grouped(group, "model").items():
            for column in ("q1", "q2"):
                each.plot(*zip(*columns_of(motion, "t", column)), **styles[model],
                          label=words[model] if column == "q1" else None)
        last = grouped(group, "model")["measured"][-1]
        for k in (1, 2):
            each.annotate(f"joint {k}", (number(last["t"]), number(last[f"q{k}"])), (4, -3), textcoords="offset points",
                          fontsize=8)
        each.set(xlabel="t, s", title=RUNS[run], xlim=(-0.02, 1.17))
    axes[0].set_ylabel("angles, rad")
    legend(axes[0], 3)
    return figure


def orders(rows):
    figure, (axes,) = panels(1, 4)
    for method, group in grouped(rows, "method").items():
        plot(axes, columns_of(group, "step", "error"), **style_of((OWN, method)), label=method)
    logarithmic(axes, "step, s", "Equal steps on a single link: the slope is the order", "error, rad and rad/s")
    axes.set_ylim(1e-16, 10)
    legend(axes, 7)
    return figure
