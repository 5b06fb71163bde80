"""The pictures of a report's page, each a figure of matplotlib made from the rows of tables."""
import math
import textwrap

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  pylint: disable=wrong-import-position

# pylint: disable=wrong-import-position
from robot import RUNS  # noqa: E402
from results import (AUTO, HALF, LEVELS, OWN, best_of_engines, by_contestant, excesses, grouped, name_of, number,  # noqa: E402
                     over_tolerance, side_of)

# Text stays text, letters repeat pixel by pixel, and ticks are lines of the grid, which keeps the files small.
plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "planar_chain", "font.sans-serif": ["DejaVu Sans"],
                     "text.hinting_factor": 2, "font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "axes.spines.top": False,
                     "axes.spines.right": False, "xtick.bottom": False, "ytick.left": False, "axes.titlesize": 8,
                     "legend.frameon": False, "legend.fontsize": 7, "legend.columnspacing": 0.8,
                     "legend.handlelength": 1.9, "legend.handletextpad": 0.5, "legend.labelspacing": 0.35})

WIDTH = 7.0  # inch: letters of 8 points are 11 pixels high on a page that is 700 wide
# No two alike: of this program's methods, and one of each other program.
COLOURS = {"auto": "black", "rk4": "#9467bd", "dopri5": "#1f77b4", "dop853": "#17becf", "rodas5p": "#d62728",
           "radau13": "#ff7f0e", "taylor": "#2ca02c", "ros34pw2": "#e377c2", "ros34pw2_fixed": "#8c564b",
           "by hand": "#7f7f7f", "odeint": "#3d3db8", "SUNDIALS": "#c8a200", "MuJoCo": "#8e1a4f", "Bullet": "#00896b",
           "DART": "#8fbf00", "Simbody": "#d9534f", "ODE": "#5b6b8c", "heyoka": "#ff00c8",
           "Pinocchio": "#0055d4", "Drake": "#b35900", "Exudyn": "#6a0dad", "scipy": "#9ecae1"}
MARKS = {"by hand": "D", "odeint": "s", "SUNDIALS": "^", "MuJoCo": "v", "Bullet": "P", "DART": "X", "Simbody": "<",
         "ODE": ">", "heyoka": "*", "Pinocchio": "p", "Drake": "d", "Exudyn": "h"}
MOST_PROGRAMS = 9  # beside auto in one panel
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


def panels(count, height, rows=1, below=0.95, **more):
    """below: inches for the axis' label and the legend."""
    figure, axes = plt.subplots(rows, count, figsize=(WIDTH, height), squeeze=False, **more)
    figure.subplots_adjust(left=0.09, right=0.985, bottom=below / height, top=1 - 0.5 / height, wspace=0.06)
    return figure, list(axes.flat)


def logarithmic(axes, x_label, title="", y_label=""):
    axes.set(xscale="log", yscale="log", xlabel=x_label, title=title)
    if y_label:
        axes.set_ylabel(y_label)
    width = axes.get_position().width * axes.figure.get_figwidth()
    for axis, most in ((axes.xaxis, 2.3 * width), (axes.yaxis, 8)):
        axis.set_major_locator(matplotlib.ticker.LogLocator(numticks=int(most)))
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
    """Time and error of auto beside the best method of each other program, beside integrators of others, and beside its own methods.
    If several runs of one method failed in one way, only the slowest is marked."""
    groups = grouped(rows, "engine", "method")
    arrived = by_contestant(rows)
    programs, integrators = ([AUTO, *best_of_engines(rows, side)][:1 + MOST_PROGRAMS] for side in ("programs", "integrators"))
    shown = {"against other programs": programs,
             " and ".join(sorted(engine for engine, _ in integrators[1:])) + "\nunder our equations": integrators,
             "against its own methods": [who for who in groups if side_of(who) == "own"]}
    shown = {heading: names for heading, names in shown.items() if names != [AUTO] or "\n" not in heading}
    figure, axes = panels(len(shown), 5.2, below=1.9, sharex=True, sharey=True,
                          gridspec_kw={"width_ratios": [1.5 if "\n" in heading else 2.2 for heading in shown]})
    seen = set()
    for each, (heading, names) in zip(axes, shown.items()):
        for who in (who for who in names if who in groups):
            plot(each, columns_of(arrived[who], "cpu_seconds", "error_theta"), **style_of(who),
                 label=name_of(who).replace(": ", ":\n" if "\n" in heading else ": "))
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
    figure.subplots_adjust(top=0.87)
    for each in axes[:-1]:
        legend(each, 1, side="left")
    zone = [plt.Rectangle((0, 0), 1, 1, label="rounding", **GREY_ZONE)] * bool(floor)
    legend(axes[-1], 2, zone + [plt.Line2D([], [], marker=mark, linestyle="", color="grey", label=word)
                                for word, mark in FAILURES.items() if word in seen], side="right")
    figure.suptitle(title, fontsize=9)
    return figure


def asked_and_got(scenes):
    """Errors of auto a second over the tolerance, of angles and of rates: a curve for each scene, named if it is above 1."""
    above = [each.scene for each in excesses(scenes)]
    figure, axes = panels(2, 3.6, below=0.8, sharex=True, sharey=True)
    for each, column, heading in zip(axes, ("error_theta", "error_omega"), ("angles, rad", "rates, rad/s")):
        for name, scene_ in scenes.items():
            style = (dict(color=f"C{above.index(name)}", marker="o", label=name, zorder=3) if name in above else
                     dict(color="#aaaaaa", linewidth=0.9))
            plot(each, over_tolerance(scene_, column), markersize=3, **style)
        each.axhspan(1e-3, 1, color="green", alpha=0.15, linewidth=0)
        logarithmic(each, "tolerance", heading)
    axes[0].set(ylabel="error a second over the tolerance", ylim=(1e-9, 1e7))
    legend(axes[0], 5, [plt.Line2D([], [], color="#aaaaaa", label="the other scenes")], side="left")
    return figure


def verdict(cells, scenes, others, middle):
    """Each cell: the time of auto over that of the fastest other. The colours turn from green to orange at `middle`, from where on the
    cell names that other."""
    scale = matplotlib.colors.LinearSegmentedColormap.from_list("ratio", ["#5aae61", "#f7f7f7", "#e08214"], N=40)
    grey, striped = "#dddddd", dict(facecolor="white", edgecolor="#999999", hatch="///", linewidth=0)
    height = 0.34 * len(scenes) + 1.6
    figure, (axes,) = panels(1, height)
    figure.subplots_adjust(left=0.125, right=1.035, bottom=0.8 / height)
    axes.grid(False)
    mesh = axes.pcolormesh([[cells[name, level].ratio for level in LEVELS] for name in scenes], cmap=scale,
                           norm=matplotlib.colors.LogNorm(middle / 4, 4 * middle), edgecolors="white", linewidth=2)
    for i, name in enumerate(scenes):
        for j, level in enumerate(LEVELS):
            cell = cells[name, level]
            text = format(cell.ratio, ".2f" if cell.ratio >= 0.1 else ".2g") if cell.outcome in ("fastest", "slower") else cell.outcome.replace("nobody", "–")
            if cell.fastest and not cell.ratio <= middle:
                text += "\n" + cell.fastest[cell.fastest[0] == OWN].replace("_", "\n")
            axes.text(j + 0.5, i + 0.5, text, ha="center", va="center", fontsize=6.5, linespacing=0.95)
            if cell.outcome in ("nobody", "not reached"):
                style = dict(facecolor=grey) if cell.outcome == "nobody" else striped
                axes.add_patch(plt.Rectangle((j + 0.02, i + 0.04), 0.96, 0.92, **style))
    axes.set(xticks=[j + 0.5 for j in range(len(LEVELS))], xticklabels=LEVELS.values(),
             yticks=[i + 0.5 for i in range(len(scenes))], yticklabels=scenes, ylim=(len(scenes), 0),
             xlabel="error of the angles, rad, that every finer setting keeps",
             title=f"Time of auto over that of the fastest {others}.\n"
                   f"Green: at most {middle:g} of it. Orange: more, and the cell names the other.")
    axes.legend(handles=[plt.Rectangle((0, 0), 1, 1, facecolor=scale(0.0), label="alone: auto and no other"),
                         plt.Rectangle((0, 0), 1, 1, label="not reached: not by auto, but by that", **striped),
                         plt.Rectangle((0, 0), 1, 1, facecolor=grey, label="–: no method reaches it")],
                loc="upper center", bbox_to_anchor=(0.5, -0.42 / (0.34 * len(scenes))), ncol=3)
    bar = figure.colorbar(mesh, ax=axes, extend="both", pad=0.01)
    bar.set_ticks([middle * 2**k for k in range(-2, 3)])
    bar.ax.set_yticklabels([f"{middle * 2**k:g}" for k in range(-2, 3)])
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
    figure, axes = panels(2, 4.4, below=1.25, sharex=True, sharey=True)
    for each, heading in zip(axes, ("its own methods", "rk4 against other programs, with equal steps")):
        for who, group in groups.items():
            if (who[0] == OWN) == (each is axes[0]) or who[1] == "rk4":
                plot(each, columns_of(group, "links", "seconds"), **style_of(who), label=name_of(who))
        logarithmic(each, "links", heading)
        legend(each, 3, side="center" if each is axes[0] else "right")
    axes[0].set_ylabel("one step, s")
    return figure


def long_runs(rows):
    figure, (axes,) = panels(1, 3.6)
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
    """Bars: the time of a step by each way, and how many times as fast many runs are."""
    timed = [row for row in rows if row["error"]]
    gains = grouped([row for row in rows if row["faster"]], "way")
    figure, (steps, batches) = panels(2, 3.6, below=1.1, gridspec_kw={"width_ratios": [1, 1.3]})
    figure.subplots_adjust(left=0.235, wspace=0.22)
    colours = [next((colour for program, colour in COLOURS.items() if row["way"].startswith(program)), "black") for row in timed]
    bars = steps.barh(range(len(timed)), [1e6 * number(row["seconds"]) for row in timed], color=colours)
    for bar, row in zip(bars, timed):
        steps.annotate(f"{bar.get_width():.3g} µs, error {number(row['error']):.0e}", (bar.get_width(), bar.get_y() + bar.get_height() / 2), (4, 0),
                       textcoords="offset points", va="center", fontsize=7)
    steps.set(yticks=range(len(timed)), yticklabels=[textwrap.fill(row["way"], 22) for row in timed], title="A step of 5 ms, double pendulum",
              xlabel="time on the processor, µs", xlim=(0, 2.4e6 * max((number(row["seconds"]) for row in timed), default=1)))
    steps.invert_yaxis()
    steps.grid(False, axis="y")
    links = sorted({int(row["links"]) for group in gains.values() for row in group})
    for k, (way, group) in enumerate(gains.items()):
        places = [links.index(int(row["links"])) + (k + 0.5) / len(gains) * 0.8 - 0.4 for row in group]
        batches.bar(places, [number(row["faster"]) for row in group], 0.8 / len(gains), color=plt.cm.Greys(0.9 - 0.65 * k / len(gains)), label=way)
    batches.axhline(1, color="grey", linewidth=1)
    batches.set(xlabel="links", ylabel="times as fast as one by one", title="Many runs", xticks=range(len(links)), xticklabels=links)
    batches.grid(False, axis="x")
    legend(batches, 2)
    return figure


def real_time(rows):
    rates = grouped(rows, "rate")
    figure, axes = panels(len(rates), 3.5, sharex=True, sharey=True)
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
        legend(each, 3, [plt.Line2D([], [], color="grey", linestyle="--", label="loosest: 1e-2")])
    axes[0].set_ylabel("part of the ticks that are later")
    return figure


def robot(rows):
    """Both angles of each recording: measured, and by the model with friction and without."""
    runs = grouped(rows, "run")
    figure, axes = panels(len(runs), 3.4, below=0.8)
    figure.subplots_adjust(wspace=0.12)
    styles = {"measured": dict(label="measured", color="black", linewidth=3, alpha=0.35),
              "friction": dict(label="with friction", color="#2b8a3e"),
              "without": dict(label="without friction", color=RED, linestyle="--", linewidth=1.1)}
    for each, (run, group) in zip(axes, runs.items()):
        for motion, style in styles.items():
            for k in (1, 2):
                each.plot(*zip(*columns_of(group, "t", f"{motion}_{k}")), **{**style, "label": style["label"] if k == 1 else None})
        for k in (1, 2):
            each.annotate(f"joint {k}", (number(group[-1]["t"]), number(group[-1][f"measured_{k}"])), (4, -3), textcoords="offset points",
                          fontsize=8)
        each.set(xlabel="t, s", title=RUNS[run], xlim=(-0.02, 1.17))
    axes[0].set_ylabel("angles, rad")
    legend(axes[0], 3)
    return figure


def orders(rows):
    figure, (axes,) = panels(1, 3.5, below=0.8)
    for method, group in grouped(rows, "method").items():
        plot(axes, columns_of(group, "step", "error"), **style_of((OWN, method)), label=method)
    logarithmic(axes, "step, s", "Equal steps on a single link: the slope is the order", "error, rad and rad/s")
    axes.set_ylim(1e-16, 10)
    legend(axes, 7)
    return figure
