"""The page of a report: its tables as pictures and words. report.py measures and calls write()."""
import base64
import collections
import html
import io
import json
import math

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  pylint: disable=wrong-import-position

from PIL import Image  # noqa: E402  pylint: disable=wrong-import-position

import report_tables as tables  # noqa: E402  pylint: disable=wrong-import-position
from report_tables import number, read  # noqa: E402  pylint: disable=wrong-import-position

plt.rcParams.update({"svg.hashsalt": "planar_chain", "font.size": 9, "axes.grid": True, "grid.alpha": 0.25,
                     "axes.spines.top": False, "axes.spines.right": False, "figure.dpi": 100})

OWN = "planar_chain"
COLOURS = {"auto": "black", "rk4": "#9467bd", "dopri5": "#1f77b4", "dop853": "#17becf", "rodas5p": "#d62728",
           "radau13": "#ff7f0e", "ros34pw2": "#e377c2", "ros34pw2_fixed": "#8c564b"}
PEER_COLOURS = ["#2ca02c", "#98df8a", "#556b2f", "#bcbd22", "#7f7f7f", "#393b79", "#8c6d31", "#5254a3", "#637939",
                "#3182bd", "#a55194", "#c7c7c7", "#e6550d", "#17a589"]
PEER_MARKS = "sDv^<>pP*hXd8H"
FAILURES = {"diverged": ("x", "diverged"), "refused": ("1", "refused"), "timed out": (r"$\rightarrow$", "timed out")}


# ---- Pieces of HTML ------------------------------------------------------------------------------

def picture(figure, name, alt, folder=None, kind="svg"):
    """The figure inline, and as a file of its own where a folder is given. Those of thousands of marks are shorter as
    png."""
    if folder is not None:
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    content = io.BytesIO()
    figure.savefig(content, format=kind, metadata={"Date": None} if kind == "svg" else None)
    plt.close(figure)
    if kind == "png":  # few colours, a quarter of the size
        few = Image.open(content).convert("RGB").quantize(64)
        content = io.BytesIO()
        few.save(content, format="png", optimize=True)
    mime = "svg+xml" if kind == "svg" else kind
    data = base64.b64encode(content.getvalue()).decode()
    return f'<img id="{name}" alt="{html.escape(alt)}" src="data:image/{mime};base64,{data}">'


def table(header, rows, classes=None):
    """Cells are text; classes(row, column) may give a cell's class."""
    lines = ["<div class=wide><table><tr>" + "".join(f"<th>{html.escape(cell)}</th>" for cell in header) + "</tr>"]
    for i, row in enumerate(rows):
        cells = []
        for j, cell in enumerate(row):
            kind = classes(i, j) if classes else ""
            cells.append(f"<td{f' class={kind}' if kind else ''}>{html.escape(str(cell))}</td>")
        lines.append("<tr>" + "".join(cells) + "</tr>")
    return "\n".join(lines) + "</table></div>"


def foot(about):
    """Under each figure: what made it."""
    engines = "; ".join(f"{name} {version}" for name, version in about["engines"].items())
    return (f"<p class=foot>{html.escape(about['command'])} — commit {html.escape(about['commit'])}, "
            f"{html.escape(about['compiler'])}, {html.escape(about['flags'].strip())}, {html.escape(about['cpu'])}, "
            f"{about['date']}{'; ' + html.escape(engines) if engines else ''}</p>")


# ---- Error against run time ----------------------------------------------------------------------

def styles(rows):
    """(engine, method): how it is drawn, the same on every picture."""
    found = {}
    peers = sorted({(row["engine"], row["method"]) for row in rows if row["engine"] != OWN})
    for k, peer in enumerate(peers):
        found[peer] = dict(color=PEER_COLOURS[k % len(PEER_COLOURS)], linestyle="--", linewidth=1,
                           marker=PEER_MARKS[k % len(PEER_MARKS)], markersize=3.5)
    for row in rows:
        if row["engine"] == OWN:
            is_auto = row["method"] == "auto"
            found[OWN, row["method"]] = dict(color=COLOURS.get(row["method"], "grey"), marker="o",
                                             linewidth=2.4 if is_auto else 1.3, markersize=4 if is_auto else 3,
                                             zorder=5 if is_auto else 3)
    return found


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
    labels = [method if engine == OWN else f"{engine}: {method}" for engine, method in groups]
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
        body.append([method if engine == OWN else f"{engine}: {method}",
                     *(f"{1e3 * times[k]:.3g}" if k in times else "–" for k in tables.LEVELS),
                     f"{1e6 * worst:.3g}" if worst else "–"])
    keys = list(reached)
    return table(header, body, lambda i, j: "best" if 0 < j <= len(tables.LEVELS) and
                 reached[keys[i]].get(tables.LEVELS[j - 1]) == best[j - 1] is not None else "")


def verdict_section(folder, about, rows, titles):
    """Where auto is the fastest, and where not."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure, axes = plt.subplots(figsize=(9.6, 0.42 * len(scenes) + 1.7))
    axes.grid(False)
    body, fastest, cells, outside = [], 0, 0, []
    for i, scene in enumerate(scenes):
        reached = tables.times_to([row for row in rows if row["scene"] == scene])
        auto = reached.get((OWN, "auto"), {})
        line = [scene]
        for j, level in enumerate(tables.LEVELS):
            others = {who: times[level] for who, times in reached.items() if level in times and who != (OWN, "auto")}
            if level not in auto and not others:
                text, colour = "–", "#eeeeee"
            elif level not in auto:
                text, colour = "not reached", "#f4a582"
            else:
                who = min(others, key=others.get) if others else None
                ratio = auto[level] / others[who] if who else 0
                cells += 1
                fastest += ratio <= 1
                name = who and (who[1] if who[0] == OWN else f"{who[0]} {who[1]}")
                if who and who[0] != OWN and ratio > 1:
                    outside.append(f"{scene} at 1e-{level}: {name} takes {1 / ratio:.2f} of the time")
                text = f"{ratio:.2f}" if who else "alone"
                colour = next((shade for most, shade in ((1, "#a6dba0"), (1.25, "#e6f5d0"), (2, "#fde0c5"))
                               if ratio <= most), "#f4a582")
                if ratio > 1:
                    text += f"\n{name}"
            axes.add_patch(plt.Rectangle((j, -i), 1, 0.94, color=colour, linewidth=0))
            axes.text(j + 0.5, -i + 0.47, text, ha="center", va="center", fontsize=6.5)
            line.append(text.replace("\n", " "))
        body.append(line)
    axes.set_xlim(0, len(tables.LEVELS))
    axes.set_ylim(-len(scenes) + 0.95, 1)
    axes.set_xticks([j + 0.5 for j in range(len(tables.LEVELS))], [f"1e-{k}" for k in tables.LEVELS])
    axes.set_yticks([0.47 - i for i in range(len(scenes))], scenes)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_title("Time of auto over that of the fastest other method of any engine,\n"
                   "to an error of the angles held by every finer setting", fontsize=10)
    figure.tight_layout()
    text = (f"<p>The default, <code>auto</code>, is the fastest of all in {fastest} of the {cells} cells that it "
            "reaches. Below 1 it is faster than everyone else; above 1 the cell names who was faster. Where that is one "
            "of its own methods, <code>auto</code> pays for what only hindsight knows: it finds out while running "
            "which of dopri5, dop853, rodas5p and radau13 comes forward fastest, and its trials cost time.</p>")
    text += ("<p>Another engine or the same equations under another library were faster here: "
             + html.escape("; ".join(outside)) + ".</p>" if outside else
             "<p>No other engine was faster in any cell.</p>" if about["engines"] else
             "<p>No other engine took part.</p>")
    return [text, picture(figure, "verdict", "Time of auto over that of the fastest other", folder), foot(about)]


# ---- The other studies ---------------------------------------------------------------------------

def stability_section(about, rows):
    families = list(dict.fromkeys(row["family"] for row in rows))
    methods = list(dict.fromkeys(row["method"] for row in rows if row["method"] != "auto"))

    def draw(column, title, low, high, palette, unstable):
        figure, panels = plt.subplots(math.ceil(len(families) / 2), 2,
                                      figsize=(13.5, 2.5 * math.ceil(len(families) / 2)), squeeze=False)
        colours = plt.get_cmap(palette)
        for axes in panels.flat:
            axes.set_visible(False)
        for axes, family in zip(panels.flat, families):
            axes.set_visible(True)
            axes.grid(False)
            values = list(dict.fromkeys(row["value"] for row in rows if row["family"] == family))
            for row in rows:
                if row["family"] != family or row["method"] == "auto":
                    continue
                text, value = row[column], number(row[column])
                if column == "largest_stable_s" and text == "":
                    text, value = "none", 0
                elif text == "":
                    text = "?"
                elif not math.isfinite(value):
                    text = "fails"
                is_missing = not math.isfinite(value) or value <= 0
                share = 0 if is_missing else (math.log10(value) - low) / (high - low)
                face = (unstable if text in ("none", "fails") else "#dddddd" if is_missing
                        else colours(min(1.0, max(0.0, share))))
                at = values.index(row["value"]), -methods.index(row["method"])
                axes.add_patch(plt.Rectangle(at, 1, 1, facecolor=face, edgecolor="white"))
                label = text if is_missing else ("≥ 1" if column == "largest_stable_s" and not row["unstable_s"]
                                                 else f"{value:.0e}".replace("e-0", "e-"))
                shade = matplotlib.colors.to_rgb(face)
                bright = 0.3 * shade[0] + 0.6 * shade[1] + 0.1 * shade[2]
                axes.text(at[0] + 0.5, at[1] + 0.5, label, ha="center", va="center", fontsize=7,
                          color="black" if bright > 0.5 else "white")
            axes.set_xlim(0, len(values))
            axes.set_ylim(1 - len(methods), 1)
            axes.set_xticks([k + 0.5 for k in range(len(values))], [f"{float(v):.3g}" for v in values])
            axes.set_yticks([0.5 - k for k in range(len(methods))], methods)
            axes.set_title(tables.FAMILIES.get(family, family), fontsize=9)
            axes.tick_params(length=0)
        figure.suptitle(title, fontsize=11)
        figure.tight_layout()
        return figure

    steps = draw("largest_stable_s", "Largest stable step, s, by method", -9, 0, "viridis", "#b2182b")
    parts = [picture(steps, "stability", "Largest stable step of each method", kind="png"), foot(about)]
    if any(row["error_at_1ms_rad"] for row in rows):
        errors = draw("error_at_1ms_rad", "Error of an angle after 1 s with equal steps of 1 ms, rad; ?: no reference",
                      -15, 1, "viridis_r", "#b2182b")
        parts += [picture(errors, "stability_errors", "Error with steps of 1 ms", kind="png"), foot(about)]
    automatic = [row for row in rows if row["method"] == "auto"]
    parts.append("<p>Beside it, <code>auto</code> at tolerance 1e-6: its mean step and its method at the end.</p>")
    parts.append(table(["family", "value", "mean step, s", "method at the end"],
                       [[row["family"], row["value"],
                         f"{number(row['auto_duration_s']) / max(1, int(row['auto_steps'])):.2g}", row["auto_method"]]
                        for row in automatic]))
    return parts


def scaling_section(about, rows):
    style = styles(rows)
    figure, axes = plt.subplots(figsize=(9, 5.2))
    body = []
    for who in dict.fromkeys((row["engine"], row["method"]) for row in rows):
        points = [(int(row["links"]), number(row["seconds"])) for row in rows
                  if (row["engine"], row["method"]) == who and math.isfinite(number(row["seconds"]))]
        slope = tables.slope([(n, s) for n, s in points if n >= 100])
        name = who[1] if who[0] == OWN else f"{who[0]}: {who[1]}"
        axes.loglog(*zip(*points), **style[who], label=f"{name}, n^{slope:.2f}" if slope else name)
        at = dict(points)
        body.append([name, *(f"{1e6 * at[n]:.3g}" if n in at else "–" for n in (1, 10, 100, 1000, 10000)),
                     f"{slope:.2f}" if slope else "–"])
    axes.set_xlabel("links n")
    axes.set_ylabel("one step, s")
    axes.legend(fontsize=7.5, frameon=False, loc="center left", bbox_to_anchor=(1.01, 0.5))
    axes.set_title("One step against the number of links; slopes from 100 links on", fontsize=10)
    figure.tight_layout()
    return [picture(figure, "scaling", "Time of a step against the number of links"), foot(about),
            table(["one step, µs; links:", "1", "10", "100", "1000", "10,000", "slope from 100 on"], body)]


def effects_section(about, rows):
    scenes = list(dict.fromkeys((row["scene"], row["links"]) for row in rows))
    effects = [name for name in dict.fromkeys(row["without"] for row in rows) if name != "nothing"]
    ratio = {(row["scene"], row["without"]): row["ratio"] for row in rows}
    time = {row["scene"]: number(row["seconds"]) for row in rows if row["without"] == "nothing"}
    body = [[scene, links, f"{1e9 * time[scene]:.4g}",
             *(f"{float(ratio[scene, name]):.2f}" if (scene, name) in ratio else "" for name in effects)]
            for scene, links in scenes]
    return [table(["scene", "links", "an evaluation, ns", *(f"without {name}" for name in effects)], body),
            "<p>Empty: the scene has none of it, and runs nothing for it.</p>", foot(about)]


def long_section(about, rows):
    titles = {"double": "Double pendulum, (2, 1) from hanging", "free_chain": "Five rods whirling, no gravity"}
    figure, panels = plt.subplots(1, 3, figsize=(13.5, 5))
    handles = {}
    shown = (("double", "energy"), ("free_chain", "energy"), ("free_chain", "momentum"))
    for axes, (scene, column) in zip(panels, shown):
        for who in dict.fromkeys((row["method"], row["setting"]) for row in rows):
            run = [row for row in rows if row["scene"] == scene and (row["method"], row["setting"]) == who]
            points = [(number(row["t"]), max(abs(number(row[column])), 1e-17)) for row in run
                      if math.isfinite(number(row[column]))]
            line, = axes.loglog(*zip(*points), color=COLOURS.get(who[0], "grey"), linewidth=1.4,
                                linestyle="--" if who[1] == "1e-12" else "-") if points else [None]
            if any(not math.isfinite(number(row["energy"])) for row in run):
                axes.plot(points[-1][0] if points else 1, 0.97, "x", color=COLOURS.get(who[0], "grey"),
                          transform=matplotlib.transforms.blended_transform_factory(axes.transData, axes.transAxes))
            if line:
                handles[f"{who[0]}, {who[1]}"] = line
        axes.set_xlabel("t, s")
        axes.set_ylabel(f"error of the {'energy' if column == 'energy' else 'angular momentum'}, relative")
        axes.set_title(titles[scene], fontsize=9)
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncol=4, frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.1, 1, 1))
    last = {}
    for row in rows:
        last[row["scene"], row["method"], row["setting"]] = row
    return [picture(figure, "long", "Drift of energy and angular momentum"), foot(about),
            table(["scene", "method", "tolerance or step, s", "until t, s", "steps", "energy off by", "momentum off by"],
                  [[*who, row["t"], row["steps"], row["energy"], row["momentum"].replace("nan", "–")]
                   for who, row in last.items()])]


def consistency_section(about, rows, race_rows):
    parts = ["<p>A wrong sign in a method's coefficients shows in its measured order; one in the equations of motion "
             "in the energy, or in the disagreement with the references, which other equations made. "
             "Rows in red do not fit.</p>"]
    orders = tables.orders(rows, race_rows)
    if orders:
        parts.append(table(["method", "with equal steps on", "order by theory", "measured", "verdict"],
                           [[name, where, theory, order, "fits" if fits else "DOES NOT FIT"]
                            for name, where, theory, order, fits in orders],
                           lambda i, _: "" if orders[i][4] else "bad"))
    energy = [row for row in rows if row["study"] == "energy"]
    if energy:
        fits = [number(row["value"]) <= 1e-8 * number(row["scale"]) for row in energy]
        parts.append(table(["auto at tolerance 1e-10 on", "energy balance off by, J", "energy at hand, J", "verdict"],
                           [[row["scene"], row["value"], row["scale"], "fits" if ok else "DOES NOT FIT"]
                            for row, ok in zip(energy, fits)], lambda i, _: "" if fits[i] else "bad"))
    agreement = tables.agreement(race_rows)
    if agreement:
        scenes, body, bad = agreement
        parts.append("<p>How close each engine comes to the reference, by its best method and setting: largest error of an "
                     "angle, rad.</p>")
        parts.append(table(["engine", *scenes], body, lambda i, j: "bad" if (i, j) in bad else ""))
    parts.append(foot(about))
    return parts


def references_section(rows, titles):
    made = {"exact": "exact solution by Jacobi's elliptic functions, 20 digits",
            "published": "published, 16 digits (Test Set for IVP Solvers)",
            "collocation": "quadruple precision, Radau collocation of order 17, Lagrange's equations",
            "pins": "quadruple precision, extrapolation of order 24; Newton's equations with pin forces"}
    body = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        ends = titles[scene]["ends"]
        errors = [number(row["error_theta"]) for row in rows if row["scene"] == scene and row["outcome"] == "ok"]
        rounding = max(number(row["rounding"]) for row in ends)
        body.append([scene, made[titles[scene]["reference"]], f"{max(number(row['uncertainty']) for row in ends):.1e}",
                     f"{rounding:.1e}" if rounding else "–", f"{min(errors, default=math.nan):.1e}"])
    return [table(["scene", "reference", "difference to a second run", "what rounding the scene to double changes",
                   "closest contestant, rad"], body)]


# ---- The page ------------------------------------------------------------------------------------

STYLE = """body{font:15px/1.5 sans-serif;max-width:1360px;margin:2em auto;padding:0 1em;color:#222}
img{max-width:100%;height:auto} table{border-collapse:collapse;font-size:13px;margin:.6em 0}
td,th{border-bottom:1px solid #ddd;padding:2px 9px;text-align:right;white-space:nowrap}
td:first-child,th:first-child{text-align:left} .foot{font-size:11px;color:#777;margin:0 0 1em}
.best{font-weight:bold;background:#e6f5d0} .bad{background:#f4a582;font-weight:bold}
.wide{overflow-x:auto} h2{border-top:2px solid #ddd;padding-top:.7em}"""


def write(folder, data, titles):
    """index.html from the tables of the folder; titles: the lines of scenes.csv by name."""
    about = json.loads((folder / "about.json").read_text(encoding="utf-8"))
    is_quick = any(facts["quick"] for facts in about.values())
    rows = read(folder / "work_precision.csv")
    floors = {}
    for name, title in titles.items():
        title["ends"] = read(data / f"{name}.csv")
        for quantity in ("theta", "omega"):
            floors[name, quantity] = max([number(row["rounding"]) for row in title["ends"]
                                          if row["quantity"] == quantity], default=0)
    study = {name: read(folder / f"{name}.csv") for name in ("consistency", "stability", "scaling", "effects", "long")}
    sections = []
    if rows:
        sections += [("Is the default the fastest?", verdict_section(folder, about["race"], rows, titles)),
                     ("Error against run time", [tables.EXPLANATION, *race_section(folder, about["race"], rows, titles, floors)]),
                     ("References", [tables.REFERENCES, *references_section(rows, titles)])]
    if study["consistency"]:
        sections.append(("Consistency", consistency_section(about["consistency"], study["consistency"], rows)))
    if study["stability"]:
        sections.append(("Stability", [tables.STABILITY, *stability_section(about["stability"], study["stability"])]))
    if study["scaling"]:
        sections.append(("Scaling", scaling_section(about["scaling"], study["scaling"])))
    if study["effects"]:
        sections.append(("What each effect costs", [tables.EFFECTS, *effects_section(about["effects"], study["effects"])]))
    if study["long"]:
        sections.append(("Long runs", [tables.LONG, *long_section(about["long"], study["long"])]))
    sections.append(("Real time", [tables.REAL_TIME]))
    body = ["<!doctype html><html lang=en><meta charset=utf-8><title>planar_chain: report</title>",
            f"<style>{STYLE}</style>",
            "<h1>planar_chain: error against run time</h1>",
            f"<p>{'A quick report: few settings, short runs. ' if is_quick else ''}Every number is in a CSV file "
            "beside this page.</p>"]
    for title, parts in sections:
        body += [f"<h2>{html.escape(title)}</h2>", *parts]
    (folder / "index.html").write_text("\n".join(body) + "\n", encoding="utf-8")
