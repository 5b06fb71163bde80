"""What follows from a report's tables: times to an accuracy, slopes, orders, where auto is not the fastest."""
import collections
import csv
import itertools
import math

import numpy as np

OWN = "planar_chain"
AUTO = (OWN, "auto")
CHOOSES_FROM = ("taylor", "dop853", "rodas5p", "radau13")
LEVELS = {k: f"1e-{k}" for k in range(3, 12)}  # errors, rad
ORDERS = {"rk4": 4, "dopri5": 5, "dop853": 8, "rodas5p": 5, "ros34pw2": 3, "radau13": 13, "taylor": 20}


def number(text):
    return float(text) if text else math.nan


def table(folder, study):
    return folder / ("work_precision.csv" if study == "race" else f"{study}.csv")


def read_table(path):
    """The rows as dictionaries of text; none if there is no file."""
    if not path.exists():
        return []
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def grouped(rows, *columns):
    """The rows by the value of a column, or by the values of several, in order of their first appearance."""
    groups = {}
    for row in rows:
        name = tuple(row[column] for column in columns) if len(columns) > 1 else row[columns[0]]
        groups.setdefault(name, []).append(row)
    return groups


def name_of(who):
    """(engine, method) in words."""
    return who[1] if who[0] == OWN else f"{who[0]}: {who[1]}"


def slope(points, least=0, most=math.inf):
    """The slope of a straight line through the logarithms from `least` to `most`; None for fewer than three points."""
    logs = [(math.log(a), math.log(b)) for a, b in points if least <= a <= most and a > 0 and b > 0]
    return np.polyfit(*zip(*logs), 1)[0] if len(logs) >= 3 else None


# ---- Times to an accuracy ------------------------------------------------------------------------

def by_contestant(rows):
    """(engine, method): its rows that arrived, loosest setting first."""
    return {who: [row for row in group if row["outcome"] == "ok"]
            for who, group in grouped(rows, "engine", "method").items()}


def holding(group, level):
    """The number of tightest settings that keep every error below 10^-level."""
    return len(list(itertools.takewhile(lambda row: number(row["error_theta"]) <= 10.0**-level, reversed(group))))


def at_level(group, level, column):
    """A column, such as cpu_seconds, at this error; between two settings along the straight line of the diagram."""
    points = [(number(row["error_theta"]), number(row[column])) for row in group]
    first = len(points) - holding(group, level)
    if first in (0, len(points)) or 0 in points[first]:
        return points[first][1] if first < len(points) else None
    return math.exp(np.interp(math.log(10.0**-level), *np.log([points[first], points[first - 1]]).T))


def times_to(rows):
    """(engine, method): {level: s} of one scene."""
    return {who: {level: at_level(group, level, "cpu_seconds") for level in LEVELS if holding(group, level)}
            for who, group in by_contestant(rows).items()}


def best_times(reached):
    """{level: s} of the fastest; `reached` as from times_to()."""
    return {level: min((times[level] for times in reached.values() if level in times), default=None)
            for level in LEVELS}


def fastest_other(reached, level):
    """The fastest method of another program at this level; None if none reaches it."""
    others = [who for who in reached if who[0] != OWN and level in reached[who]]
    return min(others, key=lambda who: reached[who][level], default=None)


def worst_step(group, level):
    held = holding(group, level)
    return number(group[-held]["worst_step_seconds"]) if held else None


def best_of_engines(rows):
    """The method of each other program that reaches most levels, and of these the one that is the fastest."""
    times = times_to(rows)
    engines = dict.fromkeys(engine for engine, _ in times if engine != OWN)
    return [max((who for who in times if who[0] == engine),
                key=lambda who: (len(times[who]), -min(times[who].values(), default=0))) for engine in engines]


# ---- Consistency ---------------------------------------------------------------------------------

def orders(rows):
    """method, order by theory, measured, and if they agree. A method without a measured order does not."""
    for method, group in grouped(rows, "method").items():
        points = [(number(row["step"]), number(row["error"])) for row in group]
        order = slope([(h, error) for h, error in points if 3e-13 < error < 3e-3])  # neither coarse nor rounding
        theory = ORDERS[method]
        yield method, theory, order, order is not None and abs(order - theory) <= max(0.5, 0.15 * theory)


# ---- Where auto is not the fastest, and why ------------------------------------------------------

Cell = collections.namedtuple("Cell", "outcome fastest ratio evaluations why")


def verdict(rows, level, floor):
    """One scene at one level. outcome: nobody, not reached, alone, fastest, slower (than `fastest`, by `ratio`)."""
    groups = by_contestant(rows)
    times = {who: reached[level] for who, reached in times_to(rows).items() if level in reached}
    auto = times.pop(AUTO, None)
    fastest = min(times, key=times.get) if times else None
    if auto is None:
        return Cell("not reached" if times else "nobody", fastest, math.nan, None, why_not_reached(rows, level, floor))
    if fastest is None:
        return Cell("alone", None, 1e-9, None, "")
    ratio = auto / times[fastest]
    if ratio <= 1:
        return Cell("fastest", fastest, ratio, None, "")
    theirs = at_level(groups[fastest], level, "evaluations")
    evaluations = at_level(groups[AUTO], level, "evaluations") / theirs if theirs else None
    return Cell("slower", fastest, ratio, evaluations, why_slower(fastest, ratio, evaluations))


def why_not_reached(rows, level, floor):
    auto = grouped(rows, "engine", "method").get(AUTO, [])
    if floor > 0.1 * 10.0**-level:
        return f"rounding the scene's own numbers changes {floor:.0e} rad, so this accuracy is reached by luck only"
    if any(row["outcome"] == "timed out" for row in auto):
        return "its finer settings take longer than a run may"
    closest = min((number(row["error_theta"]) for row in auto if row["outcome"] == "ok"), default=math.nan)
    return f"its finest setting ends {closest:.0e} rad off"


def why_slower(fastest, ratio, evaluations):
    """The reason by a rule, from the faster method and the numbers of evaluations of both."""
    engine, method = fastest
    if ratio <= 1.1:
        return "as fast within 10 %; the runs at one setting scatter by as much"
    if engine == OWN and method not in CHOOSES_FROM:
        kind = "equal steps, a length found by hindsight" if method in ("rk4", "ros34pw2_fixed") else "a lower order"
        return f"a method that auto does not choose from: {kind}, cheaper at this accuracy"
    often = evaluations is not None and evaluations > 1.05
    if engine == OWN:
        return ("auto finds out during the run that this method is the fastest: it pays for trials of others and for "
                "its steps before that" if often else
                "as many evaluations or fewer: auto took dearer steps of another method for part of the time")
    if often:
        return "another method that needs fewer evaluations for this accuracy"
    return "about as many evaluations and less beside them: no trials, no guard against a change of stiffness"


# ---- The real robot --------------------------------------------------------------------------------

def misses(rows):
    """(recording, model, root mean square of each angle's error, rad)."""
    runs = {run: grouped(group, "model") for run, group in grouped(rows, "run").items()}
    return [(run, model, *(math.sqrt(np.mean([(number(a[q]) - number(b[q])) ** 2 for a, b in zip(motion, models["measured"])]))
                           for q in ("q1", "q2")))
            for run, models in runs.items() for model, motion in models.items() if model != "measured"]
