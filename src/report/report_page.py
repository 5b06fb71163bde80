"""The page of a report: its tables as pictures and words. report.py measures and calls write()."""
import html
import json

import report_page_race as race
import report_page_studies as studies
from report_tables import number, read

STYLE = """body{font:15px/1.5 sans-serif;max-width:1360px;margin:2em auto;padding:0 1em;color:#222}
img{max-width:100%;height:auto} table{border-collapse:collapse;font-size:13px;margin:.6em 0}
td,th{border-bottom:1px solid #ddd;padding:2px 9px;text-align:right;white-space:nowrap}
td:first-child,th:first-child,.words{text-align:left}
.words{white-space:normal;min-width:18em} .foot{font-size:11px;color:#777;margin:0 0 1em}
.best{font-weight:bold;background:#e6f5d0} .bad{background:#f4a582;font-weight:bold}
.wide{overflow-x:auto} h2{border-top:2px solid #ddd;padding-top:.7em}"""


EXPLANATION = """<p>Each point is one run from t = 0 to the end of the scene: its tolerance (or its step) grows
tighter to the right. An error is the largest of any link, absolute, against the reference; time is the thread's own
on the processor, of stepping alone, after a first run; the median of ten to 21 runs (in three turns through all
methods where one takes less than 0.03 s, two where one takes more than 0.25 s; a quick report: three, two above
20 ms), their least in <code>work_precision_runs.csv</code>. A run is given
up after 0.5 s (ropes of 1000 links and more: 2 s; quick: 0.1 and 0.4 s), and tighter settings of that method are not
tried. <code>planar_chain</code> (solid) runs without the guard on the energy balance, which would rescue what fails.
Others are dashed. Failed runs stand at the upper edge: diverged (not finite, or an angle more than 1 rad off),
refused (the method gave up), timed out. Grey: below, the rounding of the scene's own numbers to double decides, or
what is not known of the reference.</p>
<p>The worst step is the largest of a run, where each step counts with the least time of three runs (of one, where a
run takes more than 30 ms).</p>"""
REFERENCES = """<p>Made from equations and by a method that share nothing with the program: Newton's and Euler's
equations with the pin forces as unknowns, Gragg's extrapolation. Before it made them in quadruple precision, that
program had to agree to 1e-17 with another one (Lagrange's equations, Cholesky's method) on nine scenes. The second run
had another order and ten to a hundred times the tolerance.
<code>test/reference/report.py</code> makes them again.</p>"""
STABILITY = """<p>Equal steps, without error control: a step is stable if energy never exceeds 1.1 times what it was.
"none": every step tried blows up, down to 1e-9 s; "≥ 1": none blows up. Stable is not accurate. <code>rosrun
planar_chain stability</code> prints the same with what theory says.</p>"""
EFFECTS = """<p>One evaluation of the accelerations in each scene that ships, and what is left of its time when one
effect is taken out of the scene: medians of runs in turn.</p>"""
LONG = """<p>Nothing supplies or takes energy here; the second chain keeps its angular momentum too. Energy is
relative to what falling to the bottom would set free. Dashed: tolerance 1e-12. A cross ends a run that failed.
Nothing is corrected: the guard of the simulation is off.</p>"""
REAL_TIME = """<p>A node on a rope of so many rods of 0.1 m (<code>auto</code>, its usual tolerance), and another
process that listens to <code>joint_states</code>, on the same machine, for ten seconds (quick: two). Late: from a
tick's stamp, the time at which it is due by the wall clock, to its arrival there, so that waking, computing, writing
and the socket are all in it. Work: what the simulation of a tick takes on the processor. A tick that comes later than
its period has missed its deadline. No priorities were given, and no core was kept free.</p>"""


def write(folder, data, titles):
    """index.html from the tables of the folder; titles: the lines of scenes.csv by name."""
    about = json.loads((folder / "about.json").read_text(encoding="utf-8"))
    is_quick = any(facts["quick"] for facts in about.values())
    rows = read(folder / "work_precision.csv")
    floors = {}
    for name, title in titles.items():
        title["ends"] = read(data / f"{name}.csv")
        for quantity in ("theta", "omega"):
            floors[name, quantity] = max(number(row[column]) for row in title["ends"] if row["quantity"] == quantity
                                         for column in ("rounding", "uncertainty"))
    sections = []
    if rows:
        runs = read(folder / "work_precision_runs.csv")
        foot = about["race"]
        sections += [("Is the default the fastest?", race.verdict_section(folder, foot, rows, runs, floors)),
                     ("Error against run time", [EXPLANATION, *race.race_section(folder, foot, rows, titles, floors)]),
                     ("References", [REFERENCES, *race.references_section(foot, rows, titles)])]
    for name, title, text, section in (("stability", "Stability", STABILITY, studies.stability_section),
                                       ("scaling", "Scaling", "", studies.scaling_section),
                                       ("effects", "What each effect costs", EFFECTS, studies.effects_section),
                                       ("long", "Long runs", LONG, studies.long_section),
                                       ("real_time", "Real time", REAL_TIME, studies.real_time_section)):
        table = read(folder / f"{name}.csv")
        if table:
            sections.append((title, [text, *section(about[name], table)]))
        elif about.get(name, {}).get("left_out"):
            sections.append((title, [f"<p>Left out: {html.escape(about[name]['left_out'])}.</p>"]))
    consistency = read(folder / "consistency.csv")
    if consistency:
        sections.append(("Consistency", studies.consistency_section(about["consistency"], consistency, rows)))
    body = ["<!doctype html><html lang=en><meta charset=utf-8><title>planar_chain: report</title>",
            f"<style>{STYLE}</style>",
            "<h1>planar_chain: error against run time</h1>",
            f"<p>{'A quick report: few settings, short runs. ' if is_quick else ''}Every number is in a CSV file "
            "beside this page.</p>"]
    for title, parts in sections:
        body += [f"<h2>{html.escape(title)}</h2>", *parts]
    (folder / "index.html").write_text("\n".join(body) + "\n", encoding="utf-8")
