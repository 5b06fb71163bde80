"""The page's part on error against run time: diagrams, times, where auto is the fastest, references."""
import collections
import html
import math

import matplotlib
import matplotlib.pyplot as plt

import report_tables as tables
from report_html import OWN, foot, name_of, picture, styles, table
from report_tables import number

FAILURES = {"diverged": ("x", "diverged"), "refused": ("1", "refused"), "timed out": (r"$\rightarrow$", "timed out")}


def draw_panel(axes, groups, style, x, y, floor):
    """Lines of those who arrived; the others at the upper edge."""
    largest = smallest = None
    for who, rows in groups.items():
        points = [(number(row[x]), number(row[y])) for row in rows if row["outcome"] == "ok"]
        points = [(a, max(b, 1e-17)) for a, b in points if a > 0]
        if points:
            axes.plot(*zip(*points), **style[who])
            largest = max([largest or 0, *(b for _, b in points)])
            smallest = min([smallest or 1, *(b for _, b in points)])
    axes.set_xscale("log")
    axes.set_yscale("log")
    if largest:
        axes.set_ylim(max(smallest / 5, 1e-17), max(largest * 10, 10))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(matplotlib.ticker.LogLocator(numticks=12))
        axis.set_minor_locator(matplotlib.ticker.NullLocator())
    edge = matplotlib.transforms.blended_transform_factory(axes.transData, axes.transAxes)
    for who, rows in groups.items():
        for row in rows:
            if row["outcome"] in FAILURES and number(row[x]) > 0:
                marker, _ = FAILURES[row["outcome"]]
                axes.plot(number(row[x]), 0.97, marker=marker, markersize=6, linestyle="", transform=edge,
                          color=style[who]["color"], clip_on=False)
    if floor:
        axes.axhspan(1e-18, floor, color="grey", alpha=0.18, linewidth=0)


def draw_scene(name, title, rows, style, floors):
    groups = collections.OrderedDict()
    for row in rows:
        groups.setdefault((row["engine"], row["method"]), []).append(row)
    figure, panels = plt.subplots(1, 3, figsize=(13.5, 5.4))
    what = [("cpu_seconds", "error_theta", "time on the processor, s", "error of the angles, rad", "theta"),
            ("cpu_seconds", "error_omega", "time on the processor, s", "error of the rates, rad/s", "omega"),
            ("evaluations", "error_theta", "evaluations of the accelerations", "error of the angles, rad", "theta")]
    for axes, (x, y, x_label, y_label, quantity) in zip(panels, what):
        draw_panel(axes, groups, style, x, y, floors.get((name, quantity), 0))
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
    handles = [plt.Line2D([], [], **style[who]) for who in groups]
    labels = [name_of(who) for who in groups]
    outcomes = {row["outcome"] for row in rows}
    for outcome, (marker, word) in FAILURES.items():
        if outcome in outcomes:
            handles.append(plt.Line2D([], [], marker=marker, linestyle="", color="grey", markersize=6))
            labels.append(word + " (at the upper edge)")
    columns = 6
    lines = math.ceil(len(labels) / columns)
    figure.suptitle(title, fontsize=11)
    figure.legend(handles, labels, loc="lower center", ncol=columns, frameon=False, fontsize=8, handlelength=3)
    figure.tight_layout(rect=(0, 0.02 + 0.036 * lines, 1, 1))
    return figure


def race_section(folder, about, rows, titles, floors):
    style = styles(rows)
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    parts = []
    for scene in scenes:
        own = [row for row in rows if row["scene"] == scene]
        keep = folder if scene == "chain10" else None
        parts.append(f"<h3>{html.escape(titles[scene]['title'])}</h3>")
        parts.append(picture(draw_scene(scene, titles[scene]["title"], own, style, floors), scene,
                             f"Error against run time and evaluations: {titles[scene]['title']}", keep, "png"))
        parts.append(foot(about))
        parts.append(times_table(own))
    return parts


def times_table(rows):
    """ms until the angles are right to each level, held by every finer setting."""
    reached = tables.times_to(rows)
    header = ["ms to an error of the angles below", *(f"1e-{k}" for k in tables.LEVELS), "worst step, µs, at 1e-6"]
    body, best = [], [min([times[k] for times in reached.values() if k in times], default=None)
                      for k in tables.LEVELS]
    for (engine, method), times in reached.items():
        worst = tables.worst_step(rows, engine, method, 1e-6)
        body.append([name_of((engine, method)),
                     *(f"{1e3 * times[k]:.3g}" if k in times else "–" for k in tables.LEVELS),
                     f"{1e6 * worst:.3g}" if worst else "–"])
    keys = list(reached)
    return table(header, body, lambda i, j: "best" if 0 < j <= len(tables.LEVELS) and
                 reached[keys[i]].get(tables.LEVELS[j - 1]) == best[j - 1] is not None else "")


def draw_verdict(cells, scenes):
    figure, axes = plt.subplots(figsize=(11.5, 0.5 * len(scenes) + 1.5))
    axes.grid(False)
    for i, scene in enumerate(scenes):
        for j, level in enumerate(tables.LEVELS):
            cell = cells[scene, level]
            text, colour = {"nobody": ("–", "#eeeeee"), "not reached": ("not reached", "#f4a582")}.get(cell.outcome, ("", ""))
            if not text:
                text = f"{cell.ratio:.2f}" if cell.fastest else "alone"
                colour = next((shade for most, shade in ((1, "#a6dba0"), (1.25, "#e6f5d0"), (2, "#fde0c5"))
                               if cell.ratio <= most), "#f4a582")
            if cell.fastest and cell.outcome == "slower":
                engine, method = cell.fastest
                text += f"\n{method if engine == OWN else engine}"
            axes.add_patch(plt.Rectangle((j, -i), 0.99, 0.94, color=colour, linewidth=0))
            axes.text(j + 0.5, -i + 0.47, text, ha="center", va="center", fontsize=8)
    axes.set_xlim(0, len(tables.LEVELS))
    axes.set_ylim(-len(scenes) + 0.95, 1)
    axes.set_xticks([j + 0.5 for j in range(len(tables.LEVELS))], [f"1e-{k}" for k in tables.LEVELS])
    axes.set_yticks([0.47 - i for i in range(len(scenes))], scenes)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_title("Time of auto over that of the fastest other method of any engine,\n"
                   "to an error of the angles, rad, held by every finer setting", fontsize=10)
    figure.tight_layout()
    return figure


def verdict_section(folder, about, rows, runs, floors):
    """Where auto is the fastest; where not, and why."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    cells = {}
    for scene in scenes:
        own = [row for row in rows if row["scene"] == scene]
        scatter = tables.scatter([row for row in runs if row["scene"] == scene], own)
        for level in tables.LEVELS:
            cells[scene, level] = tables.verdict(own, level, floors.get((scene, "theta"), 0), scatter)
    reached = [cell for cell in cells.values() if cell.outcome in ("fastest", "slower")]
    outside = [f"{scene} at 1e-{level}: {name_of(cell.fastest)} takes {1 / cell.ratio:.2f} of the time"
               for (scene, level), cell in cells.items() if cell.outcome == "slower" and cell.fastest[0] != OWN]
    text = (f"<p>The default, <code>auto</code>, is the fastest of all in {sum(c.outcome == 'fastest' for c in reached)} of "
            f"the {len(reached)} cells that it reaches. Below 1 it is faster than everyone else; above 1 the cell names who was "
            "faster, and the table below says by what.</p>")
    text += ("<p>Another engine, or the same equations under another library, was faster here: "
             + html.escape("; ".join(outside)) + ".</p>" if outside else
             "<p>No other engine was faster in any cell.</p>" if about["engines"] else
             "<p>No other engine took part.</p>")
    slower = [[scene, f"1e-{level}", name_of(cell.fastest) if cell.fastest else "–",
               f"{cell.ratio:.2f}" if cell.fastest and cell.ratio else "–",
               f"{cell.evaluations:.2f}" if cell.evaluations else "–", cell.why]
              for (scene, level), cell in cells.items() if cell.outcome in ("slower", "not reached")]
    parts = [text, picture(draw_verdict(cells, scenes), "verdict", "Time of auto over that of the fastest other", folder),
             foot(about)]
    if slower:
        parts += ["<h3>Where auto is not the fastest, and why</h3>",
                  table(["scene", "accuracy, rad", "fastest", "auto takes, times", "auto evaluates, times", "why"], slower,
                        lambda _, j: "words" if j == 5 else "")]
    return parts


def references_section(about, rows, titles):
    made = {"exact": "exact solution by Jacobi's elliptic functions, 20 digits",
            "published": "published, 16 digits (Test Set for IVP Solvers)",
            "collocation": "quadruple precision, Radau collocation of order 17, Lagrange's equations",
            "pins": "quadruple precision, extrapolation of order 18 to 24, pin forces"}
    body = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        ends = [row for row in titles[scene]["ends"] if row["quantity"] == "theta"]
        closest = min((number(row["error_theta"]) for row in rows if row["scene"] == scene and row["outcome"] == "ok"),
                      default=math.nan)
        rounding, uncertainty = (max(number(row[column]) for row in ends) for column in ("rounding", "uncertainty"))
        rounded = 2.0**-53  # ends are compared as doubles: nearer than this is 0
        tighter = max(closest, rounded) / uncertainty if uncertainty else math.inf
        body.append([scene, made[titles[scene]["reference"]], f"{uncertainty:.1e}" if uncertainty else "all digits given",
                     f"{rounding:.1e}" if rounding else "–", f"{closest:.1e}",
                     "yes" if tighter >= 100 else f"no: {tighter:.0f} times"])
    return [table(["scene", "reference", "against a second run, rad", "by rounding the scene, rad",
                   "closest contestant, rad", "100 times tighter"], body, lambda _, j: "words" if j == 1 else ""),
            foot(about)]
