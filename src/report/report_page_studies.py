"""The page's parts on the other studies: stability, scaling, effects, long runs, real time, consistency."""
import math

import matplotlib
import matplotlib.pyplot as plt

import report_tables as tables
from report_html import COLOURS, foot, name_of, picture, styles, table
from report_tables import number


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
        slopes = [tables.slope([(n, s) for n, s in points if least <= n <= most])
                  for least, most in ((10, 100), (100, math.inf))]
        last = next((slope for slope in reversed(slopes) if slope), None)
        name = name_of(who)
        axes.loglog(*zip(*points), **style[who], label=f"{name}, n^{last:.2f}" if last else name)
        at = dict(points)
        body.append([name, *(f"{1e6 * at[n]:.3g}" if n in at else "–" for n in (1, 10, 100, 1000, 10000)),
                     *(f"{slope:.2f}" if slope else "–" for slope in slopes)])
    axes.set_xlabel("links n")
    axes.set_ylabel("one step, s")
    axes.legend(fontsize=7.5, frameon=False, loc="center left", bbox_to_anchor=(1.01, 0.5))
    axes.set_title("One step against the number of links; slopes from 100 links on, or to there from ten", fontsize=10)
    figure.tight_layout()
    return [picture(figure, "scaling", "Time of a step against the number of links"), foot(about),
            table(["one step, µs; links:", "1", "10", "100", "1000", "10,000", "slope, 10 to 100", "slope, from 100 on"],
                  body)]


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


def real_time_section(about, rows):
    rates = sorted({int(row["rate"]) for row in rows})
    lengths = sorted({int(row["links"]) for row in rows})
    figure, panels = plt.subplots(1, len(rates), figsize=(13.5, 4.6), sharey=True, squeeze=False)
    colours = plt.get_cmap("viridis")
    for axes, rate in zip(panels.flat, rates):
        for k, n in enumerate(lengths):
            for quantity, line in (("late", "-"), ("work", ":")):
                points = [(number(row["seconds"]), max(number(row["share"]), 1 / number(row["ticks"]))) for row in rows
                          if (row["quantity"], row["links"], row["rate"]) == (quantity, str(n), str(rate))
                          and number(row["share"]) * number(row["ticks"]) >= 1 or
                          (row["quantity"], row["links"], row["rate"], row["share"]) == (quantity, str(n), str(rate), "0")]
                axes.loglog(*zip(*points), line, color=colours(0.9 * k / max(1, len(lengths) - 1)), linewidth=1.5,
                            label=f"{n} links, {'late' if quantity == 'late' else 'work of a tick'}")
        axes.axvline(1 / rate, color="#b2182b", linewidth=1)
        axes.annotate("period", (1 / rate, 1.01), xycoords=("data", "axes fraction"), color="#b2182b", ha="center",
                      fontsize=8)
        axes.set_title(f"{rate} Hz", fontsize=10, pad=16)
        axes.set_xlabel("late (solid), work of a tick (dotted), s")
    panels[0, 0].set_ylabel("part of the ticks that take longer")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(lengths), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.11, 1, 1))
    at = {(row["links"], row["rate"], row["quantity"], row["share"]): row for row in rows}
    body = []
    for n, rate in dict.fromkeys((row["links"], row["rate"]) for row in rows):
        late, work = (at[n, rate, quantity, "0"] for quantity in ("late", "work"))
        body.append([n, rate, late["ticks"], late["beyond_a_period"], late["missing"], late["overruns"],
                     *(f"{1e6 * number(at[n, rate, 'late', share]['seconds']):.0f}" for share in ("0.5", "0.01", "0.001", "0")),
                     *(f"{1e6 * number(at[n, rate, 'work', share]['seconds']):.3g}" for share in ("0.5", "0")),
                     work["beyond_a_period"]])
    return [picture(figure, "real_time", "How late the node's ticks come"), foot(about),
            table(["links", "Hz", "ticks", "deadlines missed", "never came", "overruns by ~status", "late, µs: median", "99 %",
                   "99.9 %", "worst", "work, µs: median", "worst", "work beyond a period"], body)]
