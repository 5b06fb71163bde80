"""A scene of the report for a program that is driven from Python, and how its runs are measured, as contest.cpp does it.

Each program has a file of its own beside this one, which lists its methods. The whole run to the end is one call into the
program's C++, so that Python costs nothing. Each method runs in a process of its own: a crash costs its points only.
"""
import argparse
import collections
import csv
import itertools
import json
import math
import os
import pathlib
import select
import signal
import statistics
import subprocess
import time
import traceback

LOST = 1          # rad: the run has nothing to do with the motion any more
IS_SHORT = 0.03   # s: such runs are made in three turns

# takes(contest); make(contest, setting) returns a run with start(), go() and read(). go() alone is timed: it returns False if the
# program gives up. read() returns θ, ω, and the numbers of evaluations, steps and rejected steps.
# decades(contest): between one tolerance and the next.
Method = collections.namedtuple("Method", "name has_fixed_step takes make decades", defaults=[lambda contest: 1])


class Contest:
    """All numbers that a program needs, from the scene's file by `equations --chain` and the report's references."""

    def __init__(self, name, data, equations):
        with open(data / "report/scenes.csv", encoding="utf-8", newline="") as file:
            line = next(row for row in csv.DictReader(file) if row["name"] == name)
        scene = line["scene"].replace("config/", "config/scenes/") if line["scene"].startswith("config/") else line["scene"]
        chain = json.loads(subprocess.run([equations, data / scene, "--chain"], stdout=subprocess.PIPE, check=True).stdout)
        self.name, self.path, self.end = name, data / scene, float(line["end_s"])
        self.gravity, self.links, self.q, self.qd = (chain[key] for key in ("gravity", "links", "q", "qd"))
        self.joints = [link["joint"] for link in self.links]
        self.has_cart = self.joints[0].get("type") == "prismatic"
        self.tip = chain.get("tip")
        self.is_plain = not set(chain) & {"loads", "springs", "base", "tip"}
        self.has_springs = any(joint["stiffness"] or joint["damping"] for joint in self.joints)
        with open(data / f"report/{name}.csv", encoding="utf-8", newline="") as file:
            ends = list(csv.DictReader(file))
        self.ends = [[(int(row["index"]), float(row["value"])) for row in ends if row["quantity"] == what]
                     for what in ("theta", "omega")]

    def __len__(self):
        return len(self.links)

    def absolute(self, relative):
        """θ from q, or ω from its rates; a cart's position stands for itself."""
        return [*relative[:self.has_cart], *itertools.accumulate(relative[self.has_cart:])]

    def errors(self, *states):
        """The largest of θ and that of ω."""
        return [max(abs(values[i] - value) if math.isfinite(values[i]) else math.inf for i, value in ends)
                for values, ends in zip(states, self.ends)]


def settings_of(method, contest, quick):
    """Loosest first: tolerances, or steps of 1, 0.3, 0.1, 0.03 … s."""
    if not method.has_fixed_step:
        return [10.0**-k for k in (range(3, 10, 3) if quick else range(0, 14, method.decades(contest)))]
    steps = [(0.3 if k % 2 else 1) * 10.0**-(k // 2) for k in range(0, 16, 2 if quick else 1)]
    return [h for h in steps if h <= contest.end / 10]


def ride(run):
    run.start()
    began = time.thread_time()
    arrived = run.go()
    return arrived is not False, time.thread_time() - began


def points(method, contest, quick):
    """(setting, row) of a method, again for those that another turn has measured."""
    limit, budget, turns = (0.1, 0.03, 1) if quick else (0.5, 0.1, 3)
    runs, times = {}, collections.defaultdict(list)
    for turn in range(turns):
        for setting in settings_of(method, contest, quick) if turn == 0 else list(runs):
            run = runs[setting] if setting in runs else method.make(contest, setting)
            arrived, seconds = ride(run)
            theta, omega, *counts = run.read()
            errors = contest.errors(theta, omega)
            outcome = ("timed out" if seconds > limit else "refused" if not arrived else
                       "ok" if errors[0] <= LOST and math.isfinite(errors[1]) else "diverged")
            if outcome == "ok":
                is_short = seconds < IS_SHORT
                if is_short:
                    runs[setting] = run
                count = min(21, max(3, budget / seconds)) / (turns if is_short else 1)
                if seconds < budget:  # longer ones run once
                    times[setting].append(statistics.median(ride(run)[1] for _ in range(math.ceil(count))))
                    seconds = statistics.median(times[setting])
            else:
                errors = [math.nan] * 2
            yield setting, [*(f"{error:.4e}" for error in errors), f"{seconds:.6e}", *counts, "nan", outcome]
            if outcome == "timed out":
                break


def lines_of(make, patience):
    """The lines that make() yields, each as JSON, from a process of its own. The last one says why there are no more if it crashes, or
    if a line takes longer than so many seconds."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # a program may chat
        try:
            with os.fdopen(writer, "w") as pipe:
                for line in make():
                    print(json.dumps(line), file=pipe, flush=True)
        except Exception:  # pylint: disable=broad-except
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        line = "none yet"
        while line and select.select([pipe], [], [], patience)[0]:
            line = pipe.readline()
            if line:
                yield json.loads(line)
    if line:
        os.kill(child, signal.SIGKILL)
    if os.waitpid(child, 0)[1]:
        yield "timed out" if line else "refused"


def race(engine, methods, contest, quick, patience):
    for method in methods:
        if not method.takes(contest):
            continue
        rows = {}
        for line in lines_of(lambda: points(method, contest, quick), patience):  # pylint: disable=cell-var-from-loop
            if isinstance(line, str):
                missing = [setting for setting in settings_of(method, contest, quick) if setting not in rows][:1]
                rows.update((setting, ["nan", "nan", "nan", 0, 0, 0, "nan", line]) for setting in missing)
            else:
                rows[line[0]] = line[1]
        for setting, row in rows.items():
            print(contest.name, engine, method.name, f"{setting:g}", *row, sep=",", flush=True)


def main(engine, methods, patience=5, studies=None):
    """The program of an engine: `race` prints rows of work_precision.csv, studies[NAME](contest, quick) others. patience: s that
    a run may take, with what it has to compile."""
    parser = argparse.ArgumentParser(description="Prints CSV for `report`, without a header.", allow_abbrev=False)
    parser.add_argument("--study", default="race")
    parser.add_argument("--scene", required=True)
    parser.add_argument("--data", type=pathlib.Path, required=True, help="folder with report/ and config/scenes")
    parser.add_argument("--equations", type=pathlib.Path, required=True, help="that program")
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    contest = Contest(given.scene, given.data, given.equations)
    if given.study == "race":
        race(engine, methods, contest, given.quick, patience)
    else:
        studies[given.study](contest, given.quick)
