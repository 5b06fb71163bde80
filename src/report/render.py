"""The page of a report: index.html and its pictures, from the tables of a folder and page.html.jinja.

report.py measures and calls write().
"""
import io
import json
import math
import pathlib
import re

import jinja2
import matplotlib.pyplot as plt

import figures
import results
from results import LEVELS, OWN, grouped, name_of, number
from store import read_table

MADE = {"exact": "exact solution by Jacobi's elliptic functions, 20 digits",
        "published": "published, 16 digits (Test Set for IVP Solvers)",
        "collocation": "quadruple precision, Radau collocation of order 17, Lagrange's equations",
        "pins": "quadruple precision, extrapolation of order 18 to 24, pin forces"}


class Marked(str):
    """A table's cell with a class of the style sheet: best, bad or words."""

    def __new__(cls, text, mark):
        cell = super().__new__(cls, text)
        cell.mark = mark
        return cell


def table(header, rows):
    return {"header": header, "rows": rows}


def digits(value, form=".3g"):
    return "–" if value is None else format(value, form)


# ---- Error against run time ----------------------------------------------------------------------

def times_table(rows):
    """ms until the angles are right to each level, held by every finer setting."""
    reached, groups = results.times_to(rows), results.by_contestant(rows)
    best = {level: min(times[level] for times in reached.values() if level in times)
            for level in LEVELS if any(level in times for times in reached.values())}
    body = []
    for who, times in reached.items():
        cells = [digits(1e3 * times[level] if level in times else None) for level in LEVELS]
        worst = results.worst_step(groups[who], 6)
        body.append([name_of(who), *(Marked(cell, "best") if times.get(level, math.nan) == best.get(level) else cell
                                     for cell, level in zip(cells, LEVELS)), digits(1e6 * worst if worst else None)])
    return table(["method", *(f"1e-{level}" for level in LEVELS), "worst step, µs, at 1e-6"], body)


def race(rows, runs, floors, titles, save):
    scenes, runs = grouped(rows, "scene"), grouped(runs, "scene")
    cells = {(name, level): results.verdict(own, level, floors[name], results.scatter(runs.get(name, []), own))
             for name, own in scenes.items() for level in LEVELS}
    reached = [cell for cell in cells.values() if cell.outcome in ("fastest", "slower")]
    slower = [[name, f"1e-{level}", name_of(cell.fastest) if cell.fastest else "–", digits(cell.ratio, ".2f"),
               digits(cell.evaluations, ".2f"), Marked(cell.why, "words")]
              for (name, level), cell in cells.items() if cell.outcome in ("slower", "not reached")]
    return {
        "verdict": save(figures.verdict(cells, list(scenes)), "verdict", "Time of auto over that of the fastest other"),
        "fastest": sum(cell.outcome == "fastest" for cell in reached), "reached": len(reached),
        "outside": [f"{name} at 1e-{level}: {name_of(cell.fastest)} takes {1 / cell.ratio:.2f} of the time"
                    for (name, level), cell in cells.items() if cell.outcome == "slower" and cell.fastest[0] != OWN],
        "why": table(["scene", "accuracy, rad", "fastest", "auto takes, times", "auto evaluates, times", "why"], slower),
        "scenes": [{"name": name, "times": times_table(own),
                    "picture": save(figures.scene(titles[name]["title"], own, floors[name]), name,
                                    f"Error against run time and evaluations: {titles[name]['title']}")}
                   for name, own in scenes.items()],
        "references": references(scenes, titles)}


def references(scenes, titles):
    body = []
    for name, rows in scenes.items():
        ends = [row for row in titles[name]["ends"] if row["quantity"] == "theta"]
        closest = min((number(row["error_theta"]) for row in rows if row["outcome"] == "ok"), default=math.nan)
        rounding, uncertainty = (max(number(row[column]) for row in ends) for column in ("rounding", "uncertainty"))
        rounded = 2.0**-53  # ends are compared as doubles: nearer than this is 0
        tighter = max(closest, rounded) / uncertainty if uncertainty else math.inf
        body.append([name, Marked(MADE[titles[name]["reference"]], "words"),
                     f"{uncertainty:.1e}" if uncertainty else "all digits given", f"{rounding:.1e}" if rounding else "–",
                     f"{closest:.1e}", "yes" if tighter >= 100 else f"no: {tighter:.0f} times"])
    return table(["scene", "reference", "against a second run, rad", "by rounding the scene, rad",
                  "closest contestant, rad", "100 times tighter"], body)


# ---- The other studies ---------------------------------------------------------------------------

def limit_cell(row):
    """The largest stable step; ≥: none tried blows up; *: larger ones passed, too; in brackets: by theory."""
    stable = row["largest_stable_s"]
    if not stable:
        return "none"
    larger = number(row["largest_of_all_s"]) > 1.01 * number(stable)
    return (f"{'' if row['unstable_s'] else '≥ '}{number(stable):.3g}{'*' if larger else ''}"
            + (f" ({number(row['predicted_s']):.3g})" if row["predicted_s"] else ""))


def error_cell(row):
    """The error after 1 s: at the largest stable step; with steps of 1 ms."""
    failure = "no stages" if row["method"] == "radau13" else "blows up"
    return "; ".join((f"{number(text):.0e}" if math.isfinite(number(text)) else failure) if text else unknown for text, unknown in
                     ((row["error_at_largest_rad"], "–"), (row["error_at_1ms_rad"], "stable")))


def stability(rows, save):
    has_errors = any(row["error_at_1ms_rad"] for row in rows)
    families = []
    for family, members in grouped(rows, "family").items():
        limits, errors = [], []
        for value, group in grouped(members, "value").items():
            *own, auto = group
            eigenvalue = own[0]["largest_eigenvalue"] or "–"
            limits.append([value, eigenvalue, *map(limit_cell, own), f"{figures.mean_step(auto):.2g}", auto["auto_method"]])
            errors.append([value, *map(error_cell, own)])
        methods = [row["method"] for row in own]
        families.append({"title": figures.FAMILIES.get(family, family),
                         "limits": table(["value", "largest eigenvalue, 1/s", *methods, "auto: mean step", "its method"], limits),
                         "errors": table(["value", *methods], errors) if has_errors else None})
    pictures = [save(figures.stability(rows, "largest_stable_s", "Largest stable step, s", "step, s"), "stability",
                     "Largest stable step of each method")]
    if has_errors:
        pictures.append(save(figures.stability(rows, "error_at_1ms_rad", "Error of an angle after 1 s with steps of 1 ms",
                                               "error, rad"), "stability_errors", "Error with steps of 1 ms"))
    return {"pictures": pictures, "families": families}


def scaling(rows, save):
    body = []
    for who, group in grouped(rows, "engine", "method").items():
        at = {int(row["links"]): number(row["seconds"]) for row in group if math.isfinite(number(row["seconds"]))}
        slopes = [results.slope([(n, s) for n, s in at.items() if least <= n <= most])
                  for least, most in ((10, 100), (100, math.inf))]
        body.append([name_of(who), *(digits(1e6 * at[n] if n in at else None) for n in (1, 10, 100, 1000, 10000)),
                     *(digits(slope, ".2f") for slope in slopes)])
    return {"picture": save(figures.scaling(rows), "scaling", "Time of a step against the number of links"),
            "table": table(["one step, µs; links:", "1", "10", "100", "1000", "10,000", "slope, 10 to 100",
                            "slope, from 100 on"], body)}


def effects(rows, _):
    names = [name for name in grouped(rows, "without") if name != "nothing"]
    body = []
    for (scene, links), group in grouped(rows, "scene", "links").items():
        ratio = {row["without"]: number(row["ratio"]) for row in group}
        body.append([scene, links, f"{1e9 * number(group[0]['seconds']):.4g}",
                     *(f"{ratio[name]:.2f}" if name in ratio else "" for name in names)])
    return {"table": table(["scene", "links", "an evaluation, ns", *(f"without {name}" for name in names)], body)}


def long_runs(rows, save):
    last = [group[-1] for group in grouped(rows, "scene", "method", "setting").values()]
    return {"picture": save(figures.long_runs(rows), "long", "Drift of energy and angular momentum"),
            "table": table(["scene", "method", "tolerance or step, s", "until t, s", "steps", "energy off by", "momentum off by"],
                           [[*(row[name] for name in ("scene", "method", "setting", "t", "steps", "energy")),
                             row["momentum"].replace("nan", "–")] for row in last])}


def real_time(rows, save):
    body = []
    for (links, rate), cell in grouped(rows, "links", "rate").items():
        at = {(row["quantity"], row["share"]): row for row in cell}
        late, work = at["late", "0"], at["work", "0"]
        body.append([links, rate, late["ticks"], late["beyond_a_period"], late["missing"], late["overruns"],
                     *(f"{1e6 * number(at['late', share]['seconds']):.0f}" for share in ("0.5", "0.01", "0.001", "0")),
                     *(f"{1e6 * number(at['work', share]['seconds']):.3g}" for share in ("0.5", "0")),
                     work["beyond_a_period"]])
    return {"picture": save(figures.real_time(rows), "real_time", "How late the node's ticks come"),
            "table": table(["links", "Hz", "ticks", "deadlines missed", "never came", "overruns by ~status",
                            "late, µs: median", "99 %", "99.9 %", "worst", "work, µs: median", "worst",
                            "work beyond a period"], body)}


def consistency(rows, race_rows):
    def line(cells, fits):
        cells = [*cells, "fits" if fits else "DOES NOT FIT"]
        return cells if fits else [Marked(str(cell), "bad") for cell in cells]

    orders = [line(found, fits) for *found, fits in results.orders(rows, race_rows)]
    energy = [line((row["scene"], row["value"], row["scale"]), number(row["value"]) <= 1e-8 * number(row["scale"]))
              for row in rows if row["study"] == "energy"]
    scenes, closest = list(grouped(race_rows, "scene")), []
    for engine, group in grouped(race_rows, "engine").items():
        own, cells = grouped(group, "scene"), []
        for scene in scenes:
            errors = [number(row["error_theta"]) for row in own.get(scene, []) if row["outcome"] == "ok"]
            text = f"{min(errors):.0e}" if errors else "lost" if scene in own else "–"
            misses = engine == OWN and not min(errors, default=math.inf) < 1e-6
            cells.append(Marked(text, "bad") if misses else text)
        closest.append([engine, *cells])
    return {"orders": table(["method", "with equal steps on", "order by theory", "measured", "verdict"], orders),
            "energy": table(["auto at tolerance 1e-10 on", "energy balance off by, J", "energy at hand, J", "verdict"], energy),
            "closest": table(["program", *scenes], closest)}


# ---- The page ------------------------------------------------------------------------------------

def shorter(svg):
    """Half of the size: tenths of a point, each marker's colour once, no empty rotations, no indentation."""
    svg = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d+\.\d)\d+", r"\1", tag.group()), svg)
    svg = re.sub(r'(<use [^>]*?) style="fill: (#\w+); stroke: \2"', r"\1", svg)
    svg = re.sub(r'style="stroke: (#\w+)"/>(?=\s*</defs>)', r'style="fill: \1; stroke: \1"/>', svg)
    return re.sub(r"\s*\n\s*", "\n", re.sub(r' transform="rotate\(-0 [^"]*"', "", svg))


def write(folder, data, titles):
    """Writes index.html and its pictures from the tables of the folder; titles: the lines of scenes.csv by name."""
    about = json.loads((folder / "about.json").read_text(encoding="utf-8"))
    floors = {}  # below these errors the rounding of the scene's numbers decides, or the reference is not known
    for name, title in titles.items():
        title["ends"] = read_table(data / f"{name}.csv")
        floors[name] = max(number(row[column]) for row in title["ends"] if row["quantity"] == "theta"
                           for column in ("rounding", "uncertainty"))

    def save(figure, name, alt):
        content = io.StringIO()
        figure.savefig(content, format="svg", metadata={"Date": None})
        plt.close(figure)
        (folder / f"{name}.svg").write_text(shorter(content.getvalue()), encoding="utf-8")
        return {"file": f"{name}.svg", "alt": alt}

    tables = {name: read_table(folder / f"{name}.csv") for name in ("work_precision", "work_precision_runs", *about)}
    rows = tables["work_precision"]
    made = {name: make(tables[name], save) for name, make in
            (("stability", stability), ("scaling", scaling), ("effects", effects), ("long", long_runs),
             ("real_time", real_time)) if tables.get(name)}
    if rows:
        made["race"] = race(rows, tables["work_precision_runs"], floors, titles, save)
    if tables.get("consistency"):
        made["consistency"] = consistency(tables["consistency"], rows)
    loader = jinja2.FileSystemLoader(str(pathlib.Path(__file__).resolve().parent))
    template = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True,
                                  undefined=jinja2.StrictUndefined).get_template("page.html.jinja")
    is_quick = any(facts["quick"] for facts in about.values())
    (folder / "index.html").write_text(template.render(about=about, made=made, is_quick=is_quick), encoding="utf-8")
