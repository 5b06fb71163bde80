"""What follows from a report's tables: times to an accuracy, slopes, orders. Knows no picture and no page."""
import collections
import csv
import math

LEVELS = range(3, 12)  # errors 1e-3 to 1e-11
FAMILIES = {"stiff": "Stiff joints: springs k, N m/rad", "stiff_damped": "Stiff joints, damped: k, N m/rad; d = k · 1 ms",
            "damped": "Damped joints, k = 100 N m/rad: d, N m s/rad",
            "heavy_tip": "Heavy tip: its mass over a link's", "slack_tip": "Heavy tip, slack: its mass over a link's",
            "light_tip": "Tapering: first mass over the last", "long": "Long chains: links", "whip": "Whips: links",
            "spin": "Spinning chain of ten links: rad/s"}
ORDERS = {("planar_chain", "rk4"): 4, ("planar_chain", "dopri5"): 5, ("planar_chain", "dop853"): 8,
          ("planar_chain", "rodas5p"): 5, ("planar_chain", "ros34pw2"): 3, ("planar_chain", "radau13"): 13,
          ("planar_chain", "taylor"): 20, ("planar_chain", "ros34pw2_fixed"): 3,
          ("MuJoCo", "Euler"): 1, ("MuJoCo", "implicit"): 1, ("MuJoCo", "RK4"): 4,
          ("Bullet", "Euler"): 1, ("Bullet", "RK4"): 4, ("DART", "Euler"): 1, ("ODE", "Euler"): 1}


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


def at_level(group, level, column):
    """Of a column, such as cpu_seconds; between two settings interpolated along the straight line of the diagram."""
    first = first_that_holds(group, level)
    if first is None:
        return None
    error, value = number(group[first]["error_theta"]), number(group[first][column])
    if first == 0 or error == 0 or value == 0:
        return value
    looser, sooner = number(group[first - 1]["error_theta"]), number(group[first - 1][column])
    share = (math.log(10.0**-level) - math.log(error)) / (math.log(looser) - math.log(error))
    return math.exp(math.log(value) + share * (math.log(sooner) - math.log(value)))


def times_to(rows):
    """(engine, method): {level: s} of one scene."""
    return {who: {level: time for level in LEVELS for time in [at_level(group, level, "cpu_seconds")] if time is not None}
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


# ---- Where auto is not the fastest, and why ------------------------------------------------------

AUTO = ("planar_chain", "auto")
CHOOSES_FROM = ("taylor", "dop853", "rodas5p", "radau13")
Cell = collections.namedtuple("Cell", "outcome fastest ratio evaluations why")


def scatter(runs, rows):
    """How far the median of auto's runs lies above their least, at its worst setting that arrived, relative."""
    arrived = {row["setting"]: number(row["cpu_seconds"]) for row in rows
               if (row["engine"], row["method"]) == AUTO and row["outcome"] == "ok"}
    return max([arrived[row["setting"]] / number(row["cpu_seconds_least"]) - 1 for row in runs
                if (row["engine"], row["method"]) == AUTO and row["setting"] in arrived], default=0)


def verdict(rows, level, floor, spread):
    """One scene at one level. outcome: nobody, not reached, fastest, slower (than `fastest`, by `ratio`)."""
    groups = by_contestant(rows)
    times = {who: at_level(group, level, "cpu_seconds") for who, group in groups.items()}
    times = {who: time for who, time in times.items() if time is not None}
    auto = times.pop(AUTO, None)
    fastest = min(times, key=times.get) if times else None
    if auto is None:
        return Cell("not reached" if times else "nobody", fastest, None, None, why_not_reached(rows, level, floor))
    if fastest is None or auto <= times[fastest]:
        return Cell("fastest", fastest, auto / times[fastest] if fastest else 0, None, "")
    ratio = auto / times[fastest]
    theirs = at_level(groups[fastest], level, "evaluations")
    evaluations = at_level(groups[AUTO], level, "evaluations") / theirs if theirs else None
    return Cell("slower", fastest, ratio, evaluations, why_slower(fastest, ratio, evaluations, spread))


def why_not_reached(rows, level, floor):
    auto = [row for row in rows if (row["engine"], row["method"]) == AUTO]
    if floor > 0.1 * 10.0**-level:
        return f"rounding the scene's own numbers changes {floor:.0e} rad: whoever gets there does so by luck"
    if any(row["outcome"] == "timed out" for row in auto):
        return "its finer settings take longer than a run may"
    closest = min((number(row["error_theta"]) for row in auto if row["outcome"] == "ok"), default=math.nan)
    return f"its finest setting ends {closest:.0e} rad off"


def why_slower(fastest, ratio, evaluations, spread):
    """By a rule, from who was faster and how often both evaluated the accelerations."""
    engine, method = fastest
    if ratio <= 1 + min(spread, 0.1):
        return f"as fast within {100 * min(spread, 0.1):.0f} %, and its own runs scatter by {100 * spread:.0f} %"
    if engine == "planar_chain" and method not in CHOOSES_FROM:
        kind = "equal steps, a length found by hindsight" if method in ("rk4", "ros34pw2_fixed") else "a lower order"
        return f"not one that auto chooses from: {kind}, cheaper at this accuracy"
    often = evaluations is not None and evaluations > 1.05
    if engine == "planar_chain":
        return ("auto finds out while running that this method is the fastest: its trials of others, and what it runs "
                "before it knows" if often else
                "as many evaluations or fewer: auto ran dearer steps of another method for part of the time")
    if often:
        return "another method that needs fewer evaluations for this accuracy"
    return "about as many evaluations, and less beside them: no trials, no guard against a change of stiffness"
