"""What follows from a report's tables: times to an accuracy, slopes, orders. Knows no picture and no page."""
import csv
import math

LEVELS = range(3, 12)  # errors 1e-3 to 1e-11
FAMILIES = {"stiff": "Stiff joints: springs k, N m/rad", "stiff_damped": "Stiff joints, damped: k, N m/rad; d = k · 1 ms",
            "heavy_tip": "Heavy tip: its mass over a link's", "slack_tip": "Heavy tip, slack: its mass over a link's",
            "light_tip": "Tapering: first mass over the last", "long": "Long chains: links", "whip": "Whips: links",
            "spin": "Spinning chain of ten links: rad/s"}
ORDERS = {("planar_chain", "rk4"): 4, ("planar_chain", "dopri5"): 5, ("planar_chain", "dop853"): 8,
          ("planar_chain", "rodas5p"): 5, ("planar_chain", "ros34pw2"): 3, ("planar_chain", "radau13"): 13,
          ("planar_chain", "ros34pw2_fixed"): 3, ("MuJoCo", "Euler"): 1, ("MuJoCo", "implicit"): 1,
          ("MuJoCo", "RK4"): 4, ("Bullet", "Euler"): 1, ("Bullet", "RK4"): 4, ("DART", "Euler"): 1, ("ODE", "Euler"): 1}

EXPLANATION = """<p>Each point is one run from t = 0 to the end of the scene: its tolerance (or its step) grows tighter to the
right. An error is the largest of any link, absolute, against the reference; time is the thread's own on the processor,
of stepping alone, after a first run; the median of up to 21 runs (at least three, or one where a run takes more than 33
ms), their least in <code>work_precision_runs.csv</code>. <code>planar_chain</code> (solid) runs without the guard on the energy balance, which would rescue what fails. Others are dashed. Failed runs stand at the upper edge:
diverged (not finite, or an angle more than 1 rad off), refused (the method gave up), timed out (tighter settings are
then not tried). Grey: below, the rounding of the scene's own numbers to double decides.</p>
<p>The worst step is the largest of a run, where each step counts with the least time of three runs.</p>"""
REFERENCES = """<p>Made in quadruple precision, from equations and by a method that share nothing with the program: Newton's and
Euler's equations with the pin forces as unknowns, Gragg's extrapolation. Before it made them, that program had to agree
to 1e-17 with another one (Lagrange's equations, Cholesky's method) on nine scenes. The second run had another order
and a hundred times the tolerance. <code>test/reference/report.py</code> makes them again.</p>"""
STABILITY = """<p>Equal steps, without error control: a step is stable if energy never exceeds 1.1 times what it was. "none": every
step tried blows up, down to 1e-9 s; "≥ 1": none blows up. Stable is not accurate. <code>rosrun planar_chain
stability</code> prints the same with what theory says.</p>"""
EFFECTS = """<p>One evaluation of the accelerations in each scene that ships, and what is left of its time when one effect is taken
out of the scene: medians of runs in turn.</p>"""
LONG = """<p>Nothing supplies or takes energy here; the second chain keeps its angular momentum too. Energy is relative to what
falling to the bottom would set free. Dashed: tolerance 1e-12. A cross ends a run that failed. Nothing is corrected: the
guard of the simulation is off.</p>"""

REAL_TIME = """<p>Left out: the report runs without a roscore, and does not measure the jitter of the node's ticks. The worst single
step of each run, above, is the part of it that a method is answerable for.</p>"""


def read(path):
    if not path.exists():
        return []
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def number(text):
    return float(text) if text else math.nan


def slope(points):
    """Of a straight line through the logarithms; None for fewer than three points."""
    logs = [(math.log(a), math.log(b)) for a, b in points if a > 0 and b > 0]
    if len(logs) < 3:
        return None
    x_mean = sum(x for x, _ in logs) / len(logs)
    y_mean = sum(y for _, y in logs) / len(logs)
    return (sum((x - x_mean) * (y - y_mean) for x, y in logs) / sum((x - x_mean)**2 for x, _ in logs))


def by_contestant(rows):
    """(engine, method): its rows that arrived, loosest setting first."""
    groups = {}
    for row in rows:
        group = groups.setdefault((row["engine"], row["method"]), [])
        if row["outcome"] == "ok":
            group.append(row)
    return groups


def first_that_holds(group, level):
    """Index of the loosest setting from which on every error is below; None if there is none."""
    first = None
    for k in range(len(group) - 1, -1, -1):
        if not number(group[k]["error_theta"]) <= 10.0**-level:
            break
        first = k
    return first


def time_to(group, level):
    """s, between two settings interpolated along the straight line of the diagram."""
    first = first_that_holds(group, level)
    if first is None:
        return None
    error, time = number(group[first]["error_theta"]), number(group[first]["cpu_seconds"])
    if first == 0 or error == 0:
        return time
    looser, sooner = number(group[first - 1]["error_theta"]), number(group[first - 1]["cpu_seconds"])
    share = (math.log(10.0**-level) - math.log(error)) / (math.log(looser) - math.log(error))
    return math.exp(math.log(time) + share * (math.log(sooner) - math.log(time)))


def times_to(rows):
    """(engine, method): {level: s} of one scene."""
    return {who: {level: time for level in LEVELS for time in [time_to(group, level)] if time is not None}
            for who, group in by_contestant(rows).items()}


def worst_step(rows, engine, method, error):
    group = by_contestant(rows)[engine, method]
    first = first_that_holds(group, -math.log10(error))
    return None if first is None else number(group[first]["worst_step_seconds"])


def measured_order(points):
    """From the errors that are neither coarse nor rounding."""
    return slope([(h, error) for h, error in points if 3e-13 < error < 3e-3])


def orders(rows, race_rows):
    """name, scene, order by theory, measured, whether it fits: none, if a method comes to no order at all."""
    found = []

    def add(who, where, points):
        order, theory = measured_order(points), ORDERS[who]
        name = who[1] if who[0] == "planar_chain" else f"{who[0]}: {who[1]}"
        fits = order is not None and abs(order - theory) <= max(0.5, 0.15 * theory)
        found.append((name, where, theory, "none" if order is None else f"{order:.2f}", fits))

    study = [row for row in rows if row["study"] == "order"]
    for method in dict.fromkeys(row["method"] for row in study):
        add(("planar_chain", method), "pendulum",
            [(number(row["setting"]), number(row["value"])) for row in study if row["method"] == method])
    for who in dict.fromkeys((row["engine"], row["method"]) for row in race_rows):
        if who[0] == "planar_chain" or who not in ORDERS:
            continue
        for scene in ("pendulum", "chain10"):
            points = [(number(row["setting"]), number(row["error_theta"])) for row in race_rows if row["outcome"] == "ok"
                      and (row["engine"], row["method"]) == who and row["scene"] == scene]
            if measured_order(points) is not None:
                add(who, scene, points)
    return found


def agreement(rows):
    """Scenes, lines of engine and least errors, and which cells (line, column) are too far off."""
    if not rows:
        return None
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    body, bad = [], set()
    for engine in dict.fromkeys(row["engine"] for row in rows):
        line = [engine]
        for scene in scenes:
            own = [row for row in rows if row["engine"] == engine and row["scene"] == scene]
            errors = [number(row["error_theta"]) for row in own if row["outcome"] == "ok"]
            if engine == "planar_chain" and not min(errors, default=math.inf) < 1e-6:
                bad.add((len(body), len(line)))
            line.append(f"{min(errors):.0e}" if errors else "lost" if own else "–")
        body.append(line)
    return scenes, body, bad
