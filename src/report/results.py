"""What follows from a report's tables: times to an accuracy, slopes, orders, where auto is not the fastest."""
import collections
import csv
import itertools
import json
import math
import re
import statistics

import numpy as np

from robot import MODELS

OWN = "planar_chain"
AUTO = (OWN, "auto")
INTEGRATORS = ("odeint", "SUNDIALS")  # of others, under the equations of this program: no programs of their own
CHOOSES_FROM = ("taylor", "dop853", "rodas5p", "radau13")
LEVELS = {k: f"1e-{k}" for k in range(3, 12)}  # errors, rad
SIDES = {"own": "its own methods", "programs": "other programs", "integrators": "integrators of others under our equations"}
SECTIONS = {"race": "Error against run time", "peers": "Compiling and batches of heyoka", "stability": "Stability",
            "scaling": "Scaling", "effects": "The cost of each effect", "long": "Long runs", "python": "From Python, and many runs", "real_time": "Real time",
            "models": "Models that others published", "robot": "A real robot", "fits": "Fits of real machines",
            "consistency": "Consistency"}  # of the pages: of a study, or of a template alone
HALF = 0.5          # of the next best program's time: the aim
ROUNDING = 2.0**-53  # of 1 to a double
# Why errors grow by more than the tolerance a second. excesses() checks that the tables agree.
WHY_ERRORS_GROW = {"double": "chaotic motion", "double_long": "chaotic motion, for twice the time",
                   "cart_pole": "starts beside the top, an unstable equilibrium, and comes back there"}
ORDERS = {"rk4": 4, "dopri5": 5, "dop853": 8, "rodas5p": 5, "ros34pw2": 3, "radau13": 13, "taylor": 20}


def number(text):
    return float(text) if text else math.nan


def table(folder, study):
    return folder / ("work_precision.csv" if study == "race" else f"{study}.csv")


def read_about(folder):
    """{study: by what it was measured}. In the file, a study that has the facts of another names it instead."""
    path = folder / "about.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return {study: known[facts] if isinstance(facts, str) else facts for study, facts in known.items()}


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


def side_of(who):
    """What (engine, method) is for this program: one of its own methods, another program, or an integrator."""
    return "own" if who[0] == OWN else "integrators" if who[0] in INTEGRATORS else "programs"


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
    """The least of a column, such as cpu_seconds, from this error on; between two settings along the straight line of the diagram."""
    points = [(number(row["error_theta"]), number(row[column])) for row in group]
    first = len(points) - holding(group, level)
    if first == len(points):
        return None
    least = min(value for _, value in points[first:])  # a tighter setting may be cheaper
    if first == 0 or 0 in points[first]:
        return least
    return min(least, math.exp(np.interp(math.log(10.0**-level), *np.log([points[first], points[first - 1]]).T)))


def times_to(rows):
    """(engine, method): {level: s} of one scene."""
    return {who: {level: at_level(group, level, "cpu_seconds") for level in LEVELS if holding(group, level)}
            for who, group in by_contestant(rows).items()}


def best_times(reached):
    """{level: s} of the fastest; `reached` as from times_to()."""
    return {level: min((times[level] for times in reached.values() if level in times), default=None)
            for level in LEVELS}


def fastest_of(side, reached, level):
    """The fastest other method of this side at this level; None if none reaches it."""
    others = [who for who in reached if side_of(who) == side and who != AUTO and level in reached[who]]
    return min(others, key=lambda who: reached[who][level], default=None)


def worst_step(group, level):
    held = holding(group, level)
    return number(group[-held]["worst_step_seconds"]) if held else None


def best_of_engines(rows, side):
    """The method of each engine of a side that reaches most levels, and of these the fastest in the mean; best engine first."""
    times = times_to(rows)

    def worth(who):
        return len(times[who]), -sum(map(math.log, times[who].values()))

    engines = dict.fromkeys(who[0] for who in times if side_of(who) == side)
    return sorted((max((who for who in times if who[0] == engine), key=worth) for engine in engines), key=worth, reverse=True)


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


def verdict(rows, level, floor, side):
    """auto against a side, in one scene at one level. outcome: nobody, not reached, alone, fastest, slower (than `fastest`, by
    `ratio`)."""
    groups = by_contestant(rows)
    reached = times_to(rows)
    auto = reached.get(AUTO, {}).get(level)
    fastest = fastest_of(side, reached, level)
    if auto is None:
        return Cell("not reached" if fastest else "nobody", fastest, math.nan, None, why_not_reached(rows, level, floor))
    if fastest is None:
        return Cell("alone", None, 1e-9, None, "")
    ratio = auto / reached[fastest][level]
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
    if evaluations is None and engine != OWN:
        return "another program, whose evaluations are not counted"
    often = evaluations is not None and evaluations > 1.05
    if engine == OWN:
        return ("auto finds out during the run that this method is the fastest: it pays for trials of others and for "
                "its steps before that" if often else
                "as many evaluations or fewer: auto took dearer steps of another method for part of the time")
    if often:
        return "another method that needs fewer evaluations for this accuracy"
    return "about as many evaluations and less beside them: no trials, no guard against a change of stiffness"


def ahead(cells, least, most=math.inf):
    """(scene, engine, [(level, ratio)]) of the cells in which auto takes more than `least` times the time of the fastest other,
    and at most `most` times; a cell that only the other reaches has the ratio infinity."""
    found = {}
    for (scene, level), cell in cells.items():
        ratio = math.inf if cell.outcome == "not reached" else cell.ratio
        if cell.fastest and least < ratio <= most:
            found.setdefault((scene, cell.fastest[0]), []).append((level, ratio))
    return [(*who, those) for who, those in found.items()]


def in_words(found):
    """The cells that ahead() gives, as a text: scene (engine): least to largest ratio at these errors."""
    words = []
    for scene, engine, those in found:
        levels, ratios = zip(*those)
        is_range = len(levels) > 1 and levels == tuple(range(levels[0], levels[-1] + 1))
        ends = dict.fromkeys(f"{ratio:.2f}".replace("inf", "not reached") for ratio in (min(ratios), max(ratios)))
        named = [LEVELS[level] for level in (levels[::len(levels) - 1] if is_range else levels)]
        words.append(f"{scene} ({engine}): {' to '.join(ends)} at {(' to ' if is_range else ', ').join(named)}")
    return "; ".join(words) or "in no cell"


def tally(cells, most=1):
    """The number of cells in which auto takes at most `most` times the time of the fastest other, that of the cells that both
    reach, and that of those which auto alone reaches."""
    outcomes = [cell.outcome for cell in cells.values()]
    both = [cell for cell in cells.values() if cell.outcome in ("fastest", "slower")]
    return sum(cell.ratio <= most for cell in both), len(both), outcomes.count("alone")


# ---- Where the error of auto exceeds the tolerance, and why ----------------------------------------

Excess = collections.namedtuple("Excess", "scene tolerance ratio growth is_explained why")


def over_tolerance(scene, column):
    """(tolerance, error a second of the motion over the tolerance) of auto."""
    return [(number(row["setting"]), number(row[column]) / number(row["setting"]) / number(scene["end_s"]))
            for row in by_contestant(scene["rows"]).get(AUTO, [])]


def excesses(scenes):
    """The largest excess of each scene in which an angle's error grows by more than the tolerance a second; and the scenes of
    WHY_ERRORS_GROW that keep it. growth: of a rounding of the scene's numbers, till the end."""
    for name, scene in scenes.items():
        points, floor, seconds = over_tolerance(scene, "error_theta"), scene["floor"], number(scene["end_s"])
        coarse = [point for point in points if point[0] * seconds > 10 * floor]
        worst, worst_coarse = (max(group, key=lambda point: point[1], default=(0, 0)) for group in (points, coarse))
        growth, reason = floor / ROUNDING, WHY_ERRORS_GROW.get(name)
        if reason and worst_coarse[1] <= 1:
            yield Excess(name, *worst_coarse, growth, False, f"keeps its tolerance, though expected not to: {reason}")
        elif reason:
            explained = worst_coarse[1] * seconds <= growth
            yield Excess(name, *worst_coarse, growth, explained, reason if explained else f"NOT EXPLAINED by its growth: {reason}")
        elif worst_coarse[1] > 1:
            yield Excess(name, *worst_coarse, growth, False, "NOT EXPLAINED")
        elif worst[1] > 1:
            yield Excess(name, *worst, growth, True, "rounding the scene's numbers causes as much")


def fast_rates(scenes):
    """The scenes in which errors of rates exceed the tolerance a second, and for no reason that WHY_ERRORS_GROW names."""
    return [name for name, scene in scenes.items()
            if name not in WHY_ERRORS_GROW and any(ratio > 1 for _, ratio in over_tolerance(scene, "error_omega"))]


# ---- Effects -----------------------------------------------------------------------------------------

def effect_shares(rows):
    """{effect: {scene: the part of an evaluation's time that it takes, %}}."""
    shares = {}
    for scene, group in grouped(rows, "scene").items():
        for row in group[1:]:
            effect = re.sub(r"^\d+ (.*?)s?$", r"\1s", row["without"])
            shares.setdefault(effect, {})[scene] = round(100 - 100 * number(row["seconds"]) / number(group[0]["seconds"]))
    return shares


def effects_in_short(rows):
    """Cells: effect, scenes, median and largest share (%), the scene of the largest."""
    for effect, shares in effect_shares(rows).items():
        most = max(shares, key=shares.get)
        yield effect, len(shares), statistics.median_low(shares.values()), shares[most], most


# ---- Real machines -----------------------------------------------------------------------------------

def both_joints(values, deviations=(math.nan, math.nan)):
    """The values of one joint or of two."""
    return ", ".join(f"{value:.3g}" + (f" ± {deviation:.1g}" if math.isfinite(deviation) else "")
                     for value, deviation in zip(values, deviations) if math.isfinite(value))


def fits_in_short(rows):
    """Cells: machine, numbers, recordings, the median errors from the first sample and from a fitted start, the numbers found."""
    for (machine, numbers), group in grouped(rows, "machine", "numbers").items():
        values = {what: [[number(row["joint_1"]), number(row["joint_2"])] for row in those] for what, those in grouped(group, "what").items()}
        found = [f"{what}: " + both_joints(values[what][0], *values.get(f"deviation of {what}", []))
                 for what in dict.fromkeys(row["what"] for row in group if row["recording"] == "all") if not what.startswith("deviation")]
        first, fitted = (both_joints(map(statistics.median, zip(*values.get(start, [])))) or "–"
                         for start in ("first measured sample", "start fitted to all"))
        yield machine, numbers, len(values["start fitted to all"]), first, fitted, "; ".join(found) or "–"


def misses(rows):
    """(recording, model, root mean square of each angle's error, rad)."""
    return [(run, model, *(math.sqrt(np.mean([(number(row[f"{model}_{k}"]) - number(row[f"measured_{k}"])) ** 2 for row in group]))
                           for k in (1, 2)))
            for run, group in grouped(rows, "run").items() for model in MODELS]
